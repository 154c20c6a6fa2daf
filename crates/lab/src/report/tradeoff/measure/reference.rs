//! The reference that images are compared with.

use pellucid_core::image::{Image, LinearImage};
use pellucid_engine::Result;
use pellucid_engine::methods::{Facts, Frame, Rendered, Renderer, linear};
use pellucid_gpu::Device;

use super::MeasuredScene;
use crate::report::tradeoff::surfaces::{Clouds, Silhouette, supersampled};
use crate::report::truth::soft_spheres;
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
    /// Pixels on which something is drawn, of methods that are compared with an exact one.
    pub(super) covered: Vec<bool>,
}

impl ReferenceImage {
    pub(super) fn new(
        device: &Device,
        subject: &MeasuredScene<'_>,
        formation: &Formation,
        frame: &Frame,
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
                covered: Vec::new(),
            });
        }
        let Rendered { image, facts, .. } = renderer.render(cloud, frame)?;
        drop(renderer);
        let in_float64 = match choice::ensembles(subject.arranged, frame) {
            Some(image) => Some(image),
            None => soft_spheres(device, subject.arranged.points(), frame)?,
        };
        let method = match (formation, &in_float64) {
            (_, None) => name.to_owned(),
            (Formation::Ensembles(_), _) => format!("{name} with ever more ensembles, in float64"),
            _ => format!("{name} in float64, before the solid points as the device splats them"),
        };
        let exact = in_float64.as_ref().unwrap_or(&image);
        let reference = linear(exact, background, frame.color)?;
        let covered = exact.rgba.iter().map(|pixel| pixel[3] > 0.0).collect();
        let unchecked = in_float64.is_none().then_some(image);
        Ok(Self { reference, unchecked, method, facts, silhouette: None, samples_across: 1, covered })
    }
}
