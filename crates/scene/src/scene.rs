//! A scene with every default applied and every range checked.

use std::borrow::Borrow;

use glam::Vec3;

use super::choice::MethodChoice;
use super::settings::{
    Background, CameraSettings, ClassSettings, Clip, CloudSettings, Detail, ImageSettings, Primitive, Shading,
    ShadingModel, Shadows,
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
    /// `true` of clouds without a scene file: their points decide what nothing is said of.
    pub names_clouds: bool,
    /// Warnings about keys without effect, one sentence each.
    pub warnings: Vec<String>,
    /// The keys that were given, those of options included, as one JSON object: the image's `pellucid:settings`.
    pub settings: String,
}

impl Scene {
    /// Settles what its clouds decide: scenes of Gaussians alone are blended in the space that these are meant for,
    /// unless the scene says otherwise. That is linear light if any of them has linear colors. Returns the space if
    /// they decided it.
    pub fn settle(&mut self, clouds: &[impl Borrow<Cloud>]) -> Option<ColorSpace> {
        self.settle_for(|cloud| Some(clouds.get(cloud)?.borrow().gaussians.as_ref()?.blend_space()))
    }

    /// Returns the same, given the space of each of its clouds that is a file of Gaussians.
    pub fn settle_for(&mut self, space: impl Fn(usize) -> Option<ColorSpace>) -> Option<ColorSpace> {
        let drawn = |(i, settings)| space(i).filter(|_| self.draws_gaussians(settings));
        let alone: Option<Vec<ColorSpace>> = self.clouds.iter().enumerate().map(drawn).collect();
        let alone = alone.filter(|spaces| !spaces.is_empty() && self.image.color.is_none())?;
        let linear = alone.contains(&ColorSpace::Linear);
        self.image.color = Some(if linear { ColorSpace::Linear } else { ColorSpace::Encoded });
        self.image.color
    }

    /// Settles a background that is left to the points: white if `are_dark` says so of these, else black. Returns its
    /// name if they decided it.
    pub fn settle_background(&mut self, are_dark: impl FnOnce() -> bool) -> Option<&'static str> {
        if self.image.background != Background::Auto {
            return None;
        }
        let (name, color) = if are_dark() { ("white", Vec3::ONE) } else { ("black", Vec3::ZERO) };
        self.image.background = Background::Color(color);
        Some(name)
    }

    /// Returns `true` if the Gaussians of a cloud's file are drawn, should it hold some.
    pub(super) fn draws_gaussians(&self, settings: &CloudSettings) -> bool {
        settings.primitive == Primitive::Gaussians && self.method.is_made_of_discs()
    }

    /// Returns `true` if a key of a table was given, by the file or by an option.
    pub(super) fn states(&self, table: &str, key: &str) -> bool {
        let given = serde_json::from_str::<serde_json::Value>(&self.settings).unwrap_or_default();
        given.get(table).and_then(|table| table.get(key)).is_some()
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
