//! A scene with every default applied and every range checked.

use std::borrow::Borrow;

use super::choice::MethodChoice;
use super::settings::{
    CameraSettings, ClassSettings, Clip, CloudSettings, Detail, ImageSettings, Primitive, Shading, ShadingModel,
    Shadows,
};
use crate::prepare::ShadingNormals;
use pellucid_core::cloud::Cloud;
use pellucid_core::color::ColorSpace;

/// A scene: everything a frame is made of but the points themselves.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    /// `[image]`.
    pub image: ImageSettings,
    /// `[camera]`.
    pub camera: CameraSettings,
    /// `[shading]`.
    pub shading: Shading,
    /// `[[cloud]]`, at least one.
    pub clouds: Vec<CloudSettings>,
    /// `[[clip]]`: points are drawn where all of them keep the center.
    pub clips: Vec<Clip>,
    /// `[method]`.
    pub method: MethodChoice,
    /// `[detail]`.
    pub detail: Detail,
    /// `[shadows]`, if they were asked for and can be: with a light of its own place or direction, shading and an
    /// opaque method.
    pub shadows: Option<Shadows>,
    /// Warnings about keys without effect, one sentence each.
    pub warnings: Vec<String>,
    /// The keys that were given, those of options included, as one JSON object: the image's `pellucid:settings`.
    pub settings: String,
}

impl Scene {
    /// Settles what its clouds decide: scenes of Gaussians alone are blended in display values, in which they are
    /// trained, unless the scene says otherwise. Returns true if they decided it.
    pub fn settle(&mut self, clouds: &[impl Borrow<Cloud>]) -> bool {
        self.settle_for(|cloud| clouds.get(cloud).is_some_and(|cloud| cloud.borrow().gaussians.is_some()))
    }

    /// Returns the same, given which of its clouds are files of Gaussians.
    pub fn settle_for(&mut self, has_gaussians: impl Fn(usize) -> bool) -> bool {
        let drawn = |(i, settings)| has_gaussians(i) && self.draws_gaussians(settings);
        let alone = !self.clouds.is_empty() && self.clouds.iter().enumerate().all(drawn);
        let decided = self.image.color.is_none() && alone;
        if decided {
            self.image.color = Some(ColorSpace::Encoded);
        }
        decided
    }

    /// Returns `true` if the Gaussians of a cloud's file are drawn, should it hold some.
    pub(super) fn draws_gaussians(&self, settings: &CloudSettings) -> bool {
        settings.primitive == Primitive::Gaussians && self.method.is_made_of_discs()
    }

    /// Returns the normals that are estimated where a cloud has none: those that shading or the method needs.
    pub fn shading_normals(&self) -> Option<ShadingNormals> {
        match self.shading.model {
            _ if self.method.scales_by_normals() => Some(ShadingNormals::All),
            ShadingModel::None => None,
            ShadingModel::Lambert | ShadingModel::Phong => Some(ShadingNormals::All),
            ShadingModel::Auto => Some(ShadingNormals::Planar),
        }
    }

    /// Returns `true` if some points may not be drawn.
    pub fn hides_points(&self) -> bool {
        let hides = |entry: &ClassSettings| entry.visible == Some(false);
        !self.clips.is_empty() || self.clouds.iter().flat_map(|cloud| &cloud.class).any(hides)
    }
}
