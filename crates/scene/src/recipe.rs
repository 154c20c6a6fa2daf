//! The table of what a changed key of a scene makes again: points, stored shadows, or only a frame.
//!
//! [`Recipe::of`] and [`Lighting::of`] name every key of a scene. A new key does not compile until it has its place
//! here.

use glam::DVec3;

use super::scene::Scene;
use super::settings::{Clip, CloudSettings, Detail, ImageSettings, Light, Shading, Shadows};
use super::{ColorSpace, MethodChoice};
use crate::prepare::ShadingNormals;
use pellucid_core::cloud::UpAxis;

/// Everything that the points of a scene follow from. Scenes of the same clouds with equal recipes have the same
/// points.
#[derive(Debug, Clone, PartialEq)]
pub struct Recipe {
    clouds: Vec<CloudSettings>,
    clips: Vec<Clip>,
    /// Radii and field, if the method needs them.
    columns: [bool; 2],
    normals: Option<ShadingNormals>,
    /// Axis along which heights are measured.
    vertical: DVec3,
    /// Seed of the shuffle into ensembles, for methods that draw them.
    shuffled: Option<u64>,
    /// Keys that the colors and the size of Gaussians follow from.
    gaussians: Option<(MethodChoice, Option<ColorSpace>, Detail)>,
}

impl Recipe {
    /// Returns the recipe of a scene. `up` is the vertical of its clouds, and `has_gaussians` says if some of them are
    /// files of Gaussians.
    pub fn of(scene: &Scene, seed: u64, up: UpAxis, has_gaussians: bool) -> Self {
        let Scene {
            image,
            camera,
            shading: _,
            clouds,
            clips,
            method,
            detail,
            shadows: _,
            names_clouds: _,
            warnings: _,
            settings: _,
        } = scene;
        let ImageSettings { size: _, background: _, color, samples: _, sampling_error: _ } = image;
        Self {
            clouds: clouds.clone(),
            clips: clips.clone(),
            columns: [method.needs_radii(), method.needs_field()],
            normals: scene.shading_normals(),
            vertical: camera.vertical(up).up(),
            shuffled: method.is_dealt().then_some(seed),
            gaussians: has_gaussians.then_some((*method, *color, *detail)),
        }
    }
}

/// Everything that decides if shadows stored with a cloud are those of a scene, while its points stay in place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lighting {
    light: Light,
    shadows: Option<Shadows>,
}

impl Lighting {
    /// Returns the lighting of a scene.
    pub fn of(scene: &Scene) -> Self {
        let Shading { model: _, ambient: _, diffuse: _, specular: _, shininess: _, light, edl: _ } = scene.shading;
        Self { light, shadows: scene.shadows }
    }
}
