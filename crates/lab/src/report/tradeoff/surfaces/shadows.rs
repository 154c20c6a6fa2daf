//! Shadows of an area light from few samples of it and from many.

use std::time::Duration;

use glam::Vec3;

use super::Clouds;
use crate::report::stress::Spread;
use crate::report::tradeoff::{Shaded, ShadedStep};
use pellucid_engine::gpu::Device;
use pellucid_engine::image::LinearImage;
use pellucid_engine::methods::{Error, Frame, Renderer};
use pellucid_engine::metrics::rmse;
use pellucid_engine::output::linear;
use pellucid_engine::scene::{Light, ShadingModel, Shadows};

/// How a pass of shadows is called.
const PASSES: &str = "shadows/";
/// Samples of the reference, if there is time; at least the second.
const REFERENCE: [f64; 2] = [1000.0, 100.0];
/// The reference takes at most one in so many parts of the time, if it has more than the least samples.
const REFERENCE_SHARE: f64 = 10.0;

/// How much is measured.
#[derive(Debug, Clone, Copy)]
pub(in super::super) struct Effort {
    /// Numbers of samples, ascending.
    pub samples: &'static [u32],
    /// Frames behind a median.
    pub frames: usize,
    /// Seconds for all of a comparison.
    pub seconds: f64,
}

/// What decides whether a frame has shadows of an area light.
fn lit(frame: &Frame) -> Option<Shadows> {
    let shades = frame.shading.model != ShadingModel::None && frame.shading.light != Light::Headlight;
    frame.shadows.filter(|shadows| shades && frame.method.takes_shadows() && shadows.light_radius > 0.0)
}

/// Renders a frame with the scene's own method and with each number of samples; `None` if it has no shadows that are soft.
///
/// # Errors
/// What rendering says.
pub(in super::super) fn measure(
    device: &Device,
    clouds: &mut Clouds<'_>,
    frame: &Frame,
    background: Vec3,
    effort: Effort,
) -> Result<Option<Shaded>, Error> {
    let Some(shadows) = lit(frame) else { return Ok(None) };
    let mut renderer = Renderer::new(device)?;
    // Buffers and shaders.
    shaded(&mut renderer, clouds, frame, background)?;
    let mut images = Vec::new();
    let mut times = Vec::new();
    for samples in effort.samples {
        let frame = Frame { shadows: Some(Shadows { samples: *samples, ..shadows }), ..*frame };
        let (image, first) = shaded(&mut renderer, clouds, &frame, background)?;
        let mut all = vec![first];
        while all.len() < effort.frames {
            all.push(shaded(&mut renderer, clouds, &frame, background)?.1);
        }
        images.push(image);
        times.push(all);
    }
    let reference_samples = reference_samples(effort, &times);
    let many = Frame { shadows: Some(Shadows { samples: reference_samples, ..shadows }), ..*frame };
    let (reference, _) = shaded(&mut renderer, clouds, &many, background)?;
    let step = |((samples, image), times): ((&u32, &LinearImage), Vec<Duration>)| ShadedStep {
        samples: *samples,
        ms: Spread::of(times.iter().map(|time| time.as_secs_f64() * 1e3).collect()),
        rmse: rmse(&reference.pixels, &image.pixels),
    };
    let steps = effort.samples.iter().zip(&images).zip(times).map(step).collect();
    Ok(Some(Shaded { method: frame.method.name().to_owned(), reference_samples, steps }))
}

/// As many as there is time for, by the step with the most samples.
fn reference_samples(effort: Effort, times: &[Vec<Duration>]) -> u32 {
    let least = |times: &Vec<Duration>| times.iter().map(Duration::as_secs_f64).fold(f64::INFINITY, f64::min);
    let most_samples = effort.samples.last().zip(times.last());
    let each = most_samples.map_or(0.0, |(samples, times)| least(times) / f64::from(*samples));
    let [most, fewest] = REFERENCE;
    (effort.seconds / REFERENCE_SHARE / each.max(1e-9)).clamp(fewest, most) as u32
}

/// An image with shadows found anew, and what its passes of shadows took.
fn shaded(
    renderer: &mut Renderer,
    clouds: &mut Clouds<'_>,
    frame: &Frame,
    background: Vec3,
) -> Result<(LinearImage, Duration), Error> {
    // A cloud keeps the shadows that were found for it.
    clouds.forget();
    let rendered = renderer.render(clouds.of(renderer, 1)?, frame)?;
    let passes = rendered.profile.passes.iter().filter(|pass| pass.name.starts_with(PASSES));
    let time = passes.map(|pass| pass.gpu).sum();
    Ok((linear(&rendered.image, background, frame.color), time))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_reference_has_what_there_is_time_for() {
        let effort = Effort { samples: &[1, 10], frames: 2, seconds: 50.0 };
        let of = |ms: u64| {
            let times = |ms: u64| vec![Duration::from_millis(2 * ms), Duration::from_millis(ms)];
            // What one sample takes besides is not asked for.
            reference_samples(effort, &[times(40), times(ms)])
        };
        // 5 seconds of 20 ms each.
        assert_eq!((of(200), of(1), of(10_000)), (250, 1000, 100));
    }
}
