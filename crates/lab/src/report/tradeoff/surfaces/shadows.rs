//! Shadows of an area light from few samples of it and from many.

use std::time::Duration;

use glam::Vec3;

use super::Clouds;
use crate::report::stress::Spread;
use crate::report::tradeoff::{Shaded, ShadedStep};
use pellucid_core::image::LinearImage;
use pellucid_core::metrics::rmse;
use pellucid_engine::methods::{Error, Frame, Renderer, linear};
use pellucid_gpu::Device;
use pellucid_scene::{Detail, Light, ShadingModel, Shadows};

/// Prefix of the labels of shadow passes.
const PASSES: &str = "shadows/";
/// Samples of the reference, if time permits; at least the second number.
const REFERENCE: [f64; 2] = [1000.0, 100.0];
/// The reference takes at most 1/`REFERENCE_SHARE` of the time, unless it has only the least samples.
const REFERENCE_SHARE: f64 = 10.0;

/// The extent of the measurement.
#[derive(Debug, Clone, Copy)]
pub(in super::super) struct Effort {
    /// Numbers of samples, ascending.
    pub samples: &'static [u32],
    /// Frames behind a median.
    pub frames: usize,
    /// Seconds for all of a comparison.
    pub seconds: f64,
}

/// The settings of the area light's shadows, if the frame has them.
fn lit(frame: &Frame) -> Option<Shadows> {
    let shades = frame.shading.model != ShadingModel::None && frame.shading.light != Light::Headlight;
    frame.shadows.filter(|shadows| shades && frame.method.takes_shadows() && shadows.light_radius > 0.0)
}

/// Renders a frame with the scene's own method and with each number of samples; `None` without soft shadows.
///
/// # Errors
/// Rendering fails.
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
        ms: Spread::from_values(times.iter().map(|time| time.as_secs_f64() * 1e3).collect()),
        rmse: rmse(&reference.pixels, &image.pixels),
    };
    let steps = effort.samples.iter().zip(&images).zip(times).map(step).collect();
    Ok(Some(Shaded { method: frame.method.name().to_owned(), reference_samples, steps }))
}

/// The number of samples that the time permits, judged by the step with the most samples.
fn reference_samples(effort: Effort, times: &[Vec<Duration>]) -> u32 {
    let least = |times: &Vec<Duration>| times.iter().map(Duration::as_secs_f64).fold(f64::INFINITY, f64::min);
    let most_samples = effort.samples.last().zip(times.last());
    let each = most_samples.map_or(0.0, |(samples, times)| least(times) / f64::from(*samples));
    let [most, fewest] = REFERENCE;
    (effort.seconds / REFERENCE_SHARE / each.max(1e-9)).clamp(fewest, most) as u32
}

/// An image with newly cast shadows, and the time of its shadow passes.
fn shaded(
    renderer: &mut Renderer,
    clouds: &mut Clouds<'_>,
    frame: &Frame,
    background: Vec3,
) -> Result<(LinearImage, Duration), Error> {
    // A cloud keeps the shadows that were found for it.
    clouds.forget();
    let rendered = renderer.render(clouds.on_device(renderer, 1, &Detail::default())?, frame)?;
    let passes = rendered.profile.passes.iter().filter(|pass| pass.name.starts_with(PASSES));
    let time = passes.map(|pass| pass.gpu).sum();
    Ok((linear(&rendered.image, background, frame.color)?, time))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_reference_has_what_there_is_time_for() {
        let effort = Effort { samples: &[1, 10], frames: 2, seconds: 50.0 };
        let samples_for = |ms: u64| {
            let times = |ms: u64| vec![Duration::from_millis(2 * ms), Duration::from_millis(ms)];
            // The fixed cost of a sample doesn't matter.
            reference_samples(effort, &[times(40), times(ms)])
        };
        // 5 seconds of 20 ms each.
        assert_eq!((samples_for(200), samples_for(1), samples_for(10_000)), (250, 1000, 100));
    }
}
