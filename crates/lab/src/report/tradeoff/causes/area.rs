//! The error of looking at a few points of each pixel in place of its area.

use std::time::Instant;

use pellucid_core::image::LinearImage;
use pellucid_core::metrics::{self, difference_picture};
use pellucid_core::progress::Progress;
use pellucid_engine::methods::{Frame, Renderer, linear};
use pellucid_engine::{Error, Result};
use pellucid_gpu::Device;
use pellucid_io::output::write_rgb_png;
use pellucid_session::area::{self, PixelArea};
use pellucid_session::choice;
use serde::{Deserialize, Serialize};

use super::measure::stem;
use super::{Cause, Effort};
use crate::report::tradeoff::surfaces::Clouds;
use crate::report::tradeoff::{DIFFERENCE_GAIN, Skipped};

/// See [`Cause::cause`].
pub(in super::super) const CAUSE: &str = "pixel area";

/// Measurements of the area of pixels.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(in super::super) struct AreaErrors {
    /// The picture of the scene's own samples.
    pub picture: PixelArea,
    /// Samples of the scene and others, ascending.
    pub causes: Vec<Cause>,
}

/// A picture of the exact method.
struct Sampled {
    image: LinearImage,
    /// Time on the device, or on the host if that drew it.
    ms: f64,
    /// Time until it was there.
    seconds: f64,
}

/// Measures these numbers of samples and the scene's own, as far as they are fewer than those of the reference; that
/// has as many as `effort.seconds` of `all` allow. If they allow none, or the device can't draw them, it is skipped.
/// Without numbers the scene's own are measured, and no picture is written.
///
/// # Errors
/// Rendering fails, or a picture can't be written.
pub(in super::super) fn measure(
    device: &Device,
    clouds: &mut Clouds<'_>,
    effort: (Effort<'_>, f64),
    counts: &[u32],
    progress: &Progress,
) -> Result<Result<AreaErrors, Skipped>> {
    match compare(device, clouds, effort, counts, progress) {
        Err(Error::Render(error)) if error.is_refusal() => Ok(Err(skipped(&effort.0, error.to_string(), false))),
        compared => compared,
    }
}

fn skipped(effort: &Effort<'_>, reason: String, for_time: bool) -> Skipped {
    let method = format!("{}, {CAUSE}", effort.frame.method.name());
    Skipped { method, setting: "image.samples".to_owned(), reason, for_time }
}

fn compare(
    device: &Device,
    clouds: &mut Clouds<'_>,
    (effort, all): (Effort<'_>, f64),
    counts: &[u32],
    progress: &Progress,
) -> Result<Result<AreaErrors, Skipped>> {
    progress.set_message("causes, pixel area");
    let method = effort.frame.method.name();
    let skipped = |reason: String, for_time: bool| Ok(Err(skipped(&effort, reason, for_time)));
    let own = effort.frame.samples;
    if own >= area::MOST {
        return skipped(format!("the scene has {own} samples in a pixel, and no picture has more"), false);
    }
    let mut studio = Studio { renderer: Renderer::new(device)?, effort };
    // The first one pays for shaders and buffers.
    studio.picture(clouds, 1)?;
    let one = studio.picture(clouds, 1)?;
    // The pictures of fewer samples take half as long again.
    let Some(against) = area::affordable(1.5 * one.seconds, own, effort.seconds) else {
        let (seconds, limit) = (f64::from(area::FEWER) * 1.5 * one.seconds, effort.seconds);
        let reason = format!(
            "16 samples in a pixel would take about {seconds:.1} s, but for them {limit:.1} s are left of {all} s in all"
        );
        return skipped(reason, true);
    };
    let reference = studio.picture(clouds, against)?.image;
    let is_shown = !counts.is_empty();
    let mut counts: Vec<u32> = counts.iter().copied().chain([own]).filter(|count| *count < against).collect();
    counts.sort_unstable();
    counts.dedup();
    let (mut causes, mut differences) = (Vec::new(), Vec::new());
    for count in counts {
        let sampled = if count == 1 { None } else { Some(studio.picture(clouds, count)?) };
        let sampled = sampled.as_ref().unwrap_or(&one);
        causes.push(cause(count, against, &reference, sampled, one.ms));
        differences.push(difference_picture(&reference.pixels, &sampled.image.pixels, DIFFERENCE_GAIN));
    }
    // Only once all of them could be drawn: a cause that is skipped leaves no picture. Nor does one that only the
    // picture's error is wanted of.
    for (cause, difference) in causes.iter().zip(&differences).filter(|_| is_shown) {
        write_rgb_png(&effort.folder.join(&cause.difference), effort.frame.size, difference)?;
    }
    device.check_validation()?;
    let rmse = causes.iter().find(|cause| cause.setting == setting(own)).map_or(0.0, |cause| cause.rmse);
    let picture = PixelArea { method: method.to_owned(), samples: own, against, rmse };
    Ok(Ok(AreaErrors { picture, causes }))
}

fn setting(samples: u32) -> String {
    format!("image.samples={samples}")
}

fn cause(samples: u32, against: u32, reference: &LinearImage, sampled: &Sampled, one_ms: f64) -> Cause {
    let image = &sampled.image;
    let meaning = match samples {
        1 => "What is lost where the center of a pixel stands for all of it: edges and fine texture.".to_owned(),
        _ => format!("What is left of that error with the mean of {samples} points of each pixel."),
    };
    Cause {
        cause: CAUSE.to_owned(),
        setting: setting(samples),
        against: setting(against),
        meaning,
        rmse: metrics::rmse(&reference.pixels, &image.pixels),
        flip: metrics::flip(reference, image),
        max: metrics::largest(reference, image).value,
        above_1_255: metrics::share_above(&reference.pixels, &image.pixels, metrics::STEP),
        gpu_ms: sampled.ms,
        times: Some(sampled.ms / one_ms),
        difference: format!("cause-{}-difference.png", stem(CAUSE, &setting(samples))),
    }
}

struct Studio<'a> {
    renderer: Renderer,
    effort: Effort<'a>,
}

impl Studio<'_> {
    /// The exact image with so many samples in a pixel.
    fn picture(&mut self, clouds: &mut Clouds<'_>, samples: u32) -> Result<Sampled> {
        let Effort { frame, background, arranged, .. } = self.effort;
        let frame = Frame { samples, ..*frame };
        let begin = Instant::now();
        if let Some(limit) = choice::ensembles(arranged, &frame) {
            let image = linear(&limit, background, frame.color)?;
            let seconds = begin.elapsed().as_secs_f64();
            return Ok(Sampled { image, ms: 1e3 * seconds, seconds });
        }
        let cloud = clouds.on_device(&self.renderer, 1, &frame.detail)?;
        let rendered = self.renderer.render(cloud, &frame)?;
        let image = linear(&rendered.image, background, frame.color)?;
        self.renderer.recycle(rendered.image);
        let ms = rendered.profile.gpu().as_secs_f64() * 1e3;
        Ok(Sampled { image, ms, seconds: begin.elapsed().as_secs_f64() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_of_two_pixels_by_hand() {
        let image = |values: [f32; 2]| LinearImage { width: 2, height: 1, pixels: values.map(|v| [v; 3]).into() };
        let sampled = Sampled { image: image([1.0, 0.5]), ms: 12.0, seconds: 1.0 };
        let found = cause(4, 64, &image([0.5, 0.5]), &sampled, 3.0);
        // One of two pixels is off by 0.5.
        assert!((found.rmse - 0.125f64.sqrt()).abs() < 1e-12, "{found:?}");
        assert_eq!((found.max, found.above_1_255, found.times), (0.5, 0.5, Some(4.0)));
        assert_eq!(
            [&found.cause, &found.setting, &found.against, &found.difference],
            ["pixel area", "image.samples=4", "image.samples=64", "cause-pixel-area-samples-4-difference.png"]
        );
    }
}
