//! The reference that images are compared with.

use std::time::Instant;

use pellucid_core::image::{Image, LinearImage};
use pellucid_engine::Result;
use pellucid_engine::methods::{Facts, Frame, Rendered, Renderer, linear};
use pellucid_gpu::Device;

use super::MeasuredScene;
use crate::report::tradeoff::surfaces::{Clouds, Silhouette, supersampled};
use crate::report::truth::soft_spheres;
use pellucid_session::area;
use pellucid_session::candidates::Formation;
use pellucid_session::choice;

/// The reference that images are compared with.
pub(super) struct ReferenceImage {
    pub(super) reference: LinearImage,
    /// The image of the device, if it must be checked against the float64 reference.
    pub(super) unchecked: Option<Image>,
    /// The method that made it, in words.
    pub(super) method: String,
    /// The facts of the exact method's frame.
    pub(super) facts: Facts,
    /// Silhouette of the surfaces, for opaque points.
    pub(super) silhouette: Option<Silhouette>,
    pub(super) samples_across: u32,
    /// Samples in a pixel of it.
    pub(super) samples: u32,
    /// Pixels on which something is drawn, of methods that are compared with an exact one.
    pub(super) covered: Vec<bool>,
}

/// Samples in a pixel of the reference.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Samples {
    /// Samples of the frame.
    Own,
    /// So many.
    Exactly(u32),
    /// Samples that stand for the area of a pixel, and fit so many seconds if any do.
    Within(f64),
}

impl Samples {
    /// Returns their number, if a picture of one sample takes so many seconds.
    fn count(self, frame: &Frame, image_seconds: f64) -> u32 {
        match self {
            Self::Own => frame.samples,
            Self::Exactly(count) => count,
            Self::Within(seconds) => area::affordable(image_seconds, 1, seconds).unwrap_or(area::FEWER),
        }
    }
}

impl ReferenceImage {
    pub(super) fn new(
        device: &Device,
        subject: &MeasuredScene<'_>,
        formation: &Formation,
        (frame, wanted): (&Frame, Samples),
        clouds: &mut Clouds<'_>,
    ) -> Result<Self> {
        let (name, background) = (frame.method.name(), subject.background);
        let mut renderer = Renderer::new(device)?;
        let cloud = clouds.on_device(&renderer, 1, &frame.detail)?;
        if let Formation::Surfaces(_) = formation {
            let made = supersampled(&mut renderer, cloud, frame, background)?;
            let across = made.samples_across;
            return Ok(Self {
                reference: made.image,
                unchecked: None,
                method: format!("{name} of all points with {across} × {across} samples in a pixel"),
                facts: Facts::default(),
                silhouette: Some(made.silhouette),
                samples_across: across,
                samples: across * across,
                covered: Vec::new(),
            });
        }
        let Rendered { mut image, facts, .. } = renderer.render(cloud, frame)?;
        let one = Frame { samples: 1, ..*frame };
        let mut seconds = 0.0;
        if let Samples::Within(_) = wanted {
            // The first frame paid for shaders and buffers.
            let begin = Instant::now();
            if choice::ensembles(subject.arranged, &one).is_none() {
                renderer.render(cloud, &one)?;
            }
            seconds = begin.elapsed().as_secs_f64();
        }
        let samples = wanted.count(frame, seconds);
        let of_area = wanted != Samples::Own;
        let frame = &Frame { samples, ..*frame };
        let in_float64 = match choice::ensembles(subject.arranged, frame) {
            Some(image) => Some(image),
            // As many pictures in float64 would take too long.
            None if of_area => None,
            None => soft_spheres(device, subject.arranged.points(), frame)?,
        };
        if of_area && in_float64.is_none() {
            image = renderer.render(cloud, frame)?.image;
        }
        drop(renderer);
        let method = match (formation, &in_float64) {
            (_, None) if of_area => format!("{name} with {samples} samples in a pixel"),
            (_, None) => name.to_owned(),
            (Formation::Ensembles(_), _) if of_area => {
                format!("{name} with ever more ensembles, in float64, with {samples} samples in a pixel")
            }
            (Formation::Ensembles(_), _) => format!("{name} with ever more ensembles, in float64"),
            _ => format!("{name} in float64, before the solid points as the device splats them"),
        };
        let exact = in_float64.as_ref().unwrap_or(&image);
        let reference = linear(exact, background, frame.color)?;
        let covered = exact.rgba.iter().map(|pixel| pixel[3] > 0.0).collect();
        // The pixels that are checked are those of discs.
        let unchecked = (in_float64.is_none() && frame.method.as_soft().is_none()).then_some(image);
        Ok(Self { reference, unchecked, method, facts, silhouette: None, samples_across: 1, samples, covered })
    }
}
