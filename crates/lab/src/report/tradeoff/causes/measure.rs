//! Renders the changed images and compares them.

use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use glam::Vec3;
use pellucid_core::image::LinearImage;
use pellucid_core::metrics::{self, difference_picture};
use pellucid_core::points::Points;
use pellucid_core::progress::Progress;
use pellucid_engine::Result;
use pellucid_engine::methods::{self, Frame, Renderer, Upload, linear};
use pellucid_engine::passes::project::DeviceCloud;
use pellucid_gpu::Device;
use pellucid_io::output::write_rgb_png;
use pellucid_scene::prepare::Arranged;
use pellucid_scene::{Discs, GaussianSettings, Hybrid, Method};

use super::{Cause, Change};
use crate::report::tradeoff::surfaces::Clouds;
use crate::report::tradeoff::{DIFFERENCE_GAIN, Skipped};

/// Inputs of the images.
#[derive(Clone, Copy)]
pub(in super::super) struct Effort<'a> {
    /// The exact frame, of `abuffer`.
    pub frame: &'a Frame,
    /// Image of the exact frame.
    pub reference: &'a LinearImage,
    /// Linear RGB.
    pub background: Vec3,
    /// All points.
    pub arranged: &'a Arranged,
    /// Folder for the pictures of differences.
    pub folder: &'a Path,
    /// Seconds after which no further image is begun.
    pub seconds: f64,
}

/// Measures the changes, as many as the time permits; the others, and those that can't be drawn, are skipped.
///
/// # Errors
/// Rendering fails for another reason than the change, or a picture can't be written.
pub(in super::super) fn measure(
    device: &Device,
    clouds: &mut Clouds<'_>,
    effort: Effort<'_>,
    changes: &[Change],
    progress: &Progress,
) -> Result<(Vec<Cause>, Vec<Skipped>)> {
    let begin = Instant::now();
    let mut studio = Studio { renderer: Renderer::new(device)?, effort };
    let (mut measured, mut skipped, mut longest) = (Vec::new(), Vec::new(), 0f64);
    for change in changes {
        progress.set_message(format!("causes, {} {}", change.cause, change.setting));
        let (left, before) = (effort.seconds - begin.elapsed().as_secs_f64(), Instant::now());
        if longest > left {
            let reason = format!(
                "an image takes about {longest:.1} s, and {:.1} s are left for the causes of errors",
                left.max(0.0)
            );
            skipped.push(skip(change, reason, true));
            continue;
        }
        match studio.cause(clouds, change) {
            Ok(cause) => {
                device.check_validation()?;
                write_rgb_png(&effort.folder.join(&cause.figures.difference), effort.frame.size, &cause.difference)?;
                measured.push(cause.figures);
                longest = longest.max(before.elapsed().as_secs_f64());
            }
            Err(error) if error.is_refusal() => skipped.push(skip(change, error.to_string(), false)),
            Err(error) => return Err(error.into()),
        }
    }
    // The first one is the exact image again.
    let exact = measured.first().filter(|cause: &&Cause| cause.setting.is_empty()).map(|cause| cause.gpu_ms);
    measured.iter_mut().for_each(|cause| cause.times = exact.map(|exact| cause.gpu_ms / exact));
    Ok((measured, skipped))
}

fn skip(change: &Change, reason: String, for_time: bool) -> Skipped {
    let setting = format!("{} {}", change.setting, change.against).trim_end().to_owned();
    Skipped { method: format!("abuffer, {}", change.cause), setting, reason, for_time }
}

/// The figures of a change and the picture that shows where it matters.
struct MeasuredCause {
    figures: Cause,
    difference: Vec<[f32; 3]>,
}

struct Studio<'a> {
    renderer: Renderer,
    effort: Effort<'a>,
}

impl Studio<'_> {
    fn cause(&mut self, clouds: &mut Clouds<'_>, change: &Change) -> Result<MeasuredCause, methods::Error> {
        let (image, gpu_ms) = match change.degree {
            Some(degree) => self.of_degree(clouds, change.settings, degree)?,
            None => self.changed(clouds, self.method(change))?,
        };
        let base = match change.base {
            Some(settings) => Some(self.changed(clouds, self.exact(settings))?.0),
            None => None,
        };
        let base = base.as_ref().unwrap_or(self.effort.reference);
        let difference = difference_picture(&base.pixels, &image.pixels, DIFFERENCE_GAIN);
        Ok(MeasuredCause { figures: compared(change, base, &image, gpu_ms), difference })
    }

    /// The image by another method or settings, and its device time in ms.
    fn changed(&mut self, clouds: &mut Clouds<'_>, method: Method) -> Result<(LinearImage, f64), methods::Error> {
        let frame = Frame { method, ..*self.effort.frame };
        let cloud = clouds.on_device(&self.renderer, 1, &frame.detail)?;
        self.timed(cloud, &frame)
    }

    /// The image with fewer harmonics.
    fn of_degree(
        &mut self,
        clouds: &mut Clouds<'_>,
        settings: GaussianSettings,
        degree: u32,
    ) -> Result<(LinearImage, f64), methods::Error> {
        // The memory of the others first.
        clouds.forget();
        let points = self.effort.arranged.points();
        let gaussians = points.gaussians.clone().map(|gaussians| gaussians.with_degree(degree));
        let frame = Frame { method: self.exact(settings), ..*self.effort.frame };
        let arranged = Arranged::Canonical(Arc::new(Points { gaussians, ..points.clone() }));
        let mut cloud = self.renderer.upload(Upload::with_detail(&arranged, &frame.detail))?;
        self.timed(&mut cloud, &frame)
    }

    /// The exact method with other settings of Gaussians.
    fn exact(&self, gaussians: GaussianSettings) -> Method {
        let discs = self.effort.frame.method.discs().copied().unwrap_or_default();
        Method::ABuffer(Discs { gaussians, ..discs })
    }

    /// The method of a changed image.
    fn method(&self, change: &Change) -> Method {
        let exact = self.exact(change.settings);
        match (change.core_alpha_min, exact.discs()) {
            (Some(core_alpha_min), Some(discs)) => {
                Method::Hybrid(Hybrid { discs: *discs, core_alpha_min, ..Hybrid::default() })
            }
            _ => exact,
        }
    }

    /// A frame's image, and the least device time of the two that follow it, in ms: the first one pays for shaders and
    /// buffers.
    fn timed(&mut self, cloud: &mut DeviceCloud, frame: &Frame) -> Result<(LinearImage, f64), methods::Error> {
        let rendered = self.renderer.render(cloud, frame)?;
        let image = linear(&rendered.image, self.effort.background, frame.color)?;
        self.renderer.recycle(rendered.image);
        let mut least = f64::INFINITY;
        for _ in 0..2 {
            let again = self.renderer.render(cloud, frame)?;
            self.renderer.recycle(again.image);
            least = least.min(again.profile.gpu().as_secs_f64() * 1e3);
        }
        Ok((image, least))
    }
}

/// The figures of an image with one thing changed.
fn compared(change: &Change, base: &LinearImage, image: &LinearImage, gpu_ms: f64) -> Cause {
    Cause {
        cause: change.cause.to_owned(),
        setting: change.setting.clone(),
        against: change.against.to_owned(),
        meaning: change.meaning.clone(),
        rmse: metrics::rmse(&base.pixels, &image.pixels),
        flip: metrics::flip(base, image),
        max: metrics::largest(base, image).value,
        above_1_255: metrics::share_above(&base.pixels, &image.pixels, metrics::STEP),
        gpu_ms,
        times: None,
        difference: format!("cause-{}-difference.png", stem(change.cause, &change.setting)),
    }
}

/// A name for a file, which no other change has.
pub(super) fn stem(cause: &str, setting: &str) -> String {
    let words: Vec<&str> = [cause, setting].into_iter().filter(|word| !word.is_empty()).collect();
    words
        .join(" ")
        .replace("method.", "")
        .replace("cloud.*.", "")
        .replace("image.", "")
        .replace([' ', '=', '_', '.'], "-")
}

#[cfg(test)]
mod tests {
    use super::super::changes;
    use super::*;
    use pellucid_core::camera::Projection;
    use pellucid_scene::Order;

    fn image(pixels: [[f32; 3]; 4]) -> LinearImage {
        LinearImage { width: 2, height: 2, pixels: pixels.to_vec() }
    }

    #[test]
    fn figures_of_two_images_by_hand() {
        let all = changes(&Discs::default(), Order::Pixel, 3, &Projection::Perspective { fov_y: 1.0 });
        let exact = image([[0.5; 3]; 4]);
        let same = compared(&all[0], &exact, &exact, 2.0);
        assert_eq!((same.rmse, same.flip, same.max, same.above_1_255, same.gpu_ms), (0.0, 0.0, 0.0, 0.0, 2.0));
        // One channel of twelve by 0.25, and one by less than a step.
        let changed = image([[0.75, 0.5, 0.5], [0.5; 3], [0.5, 0.502, 0.5], [0.5; 3]]);
        let found = compared(&all[1], &exact, &changed, 2.0);
        let squares = 0.25f64.powi(2) + f64::from(0.502f32 - 0.5).powi(2);
        assert!((found.rmse - (squares / 12.0).sqrt()).abs() < 1e-12, "{found:?}");
        assert!((found.max, found.above_1_255) == (0.25, 0.25) && found.flip > 0.01, "{found:?}");
    }

    #[test]
    fn pictures_have_names_of_their_own() {
        let all = changes(&Discs::default(), Order::Pixel, 3, &Projection::Perspective { fov_y: 1.0 });
        let mut names: Vec<String> = all.iter().map(|change| stem(change.cause, &change.setting)).collect();
        for name in ["order-of-centers-order-center", "harmonics-sh-degree-0"] {
            assert!(names.iter().any(|other| other == name), "{name} of {names:?}");
        }
        names.sort();
        names.dedup();
        assert_eq!(names.len(), all.len());
    }
}
