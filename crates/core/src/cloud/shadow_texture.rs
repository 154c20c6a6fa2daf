//! The settings a shadow texture belongs to: one share of light for each point (Dobrev et al. 2010, Section 6).

use glam::DVec3;
use serde::{Deserialize, Serialize};

use crate::light::Light;

/// Everything that decides which lights reach which of the points: the same casting of the same points is the same
/// texture.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Casting {
    /// The light, its direction of length 1; not a headlight.
    #[serde(flatten, with = "LightRecord")]
    pub light: Light,
    /// M: the number of lights that stand for an area light; 1 without an area.
    pub samples: u32,
    /// Degrees around a direction, world units around a position.
    pub light_radius: f32,
    /// Side of the shadow map.
    pub resolution: u32,
    /// Iterations of the filter of background. Textures that were stored before there was one had none.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub fill: u32,
    /// Iterations of the filter of occluded pixels. Textures that were stored before it was a setting had one.
    #[serde(default = "one", skip_serializing_if = "is_one")]
    pub occlusion: u32,
    /// d̃ in world units.
    pub min_layer_distance: f32,
    /// Seed of the shifts of an area's lights; 0 without an area.
    pub seed: u64,
}

impl Casting {
    /// Returns how far the filters reach, in pixels of the map.
    pub fn reach(&self) -> u32 {
        self.fill.saturating_add(self.occlusion)
    }

    /// Returns the settings that differ from `other`, by their names in a scene.
    pub fn differences(&self, other: &Self) -> Vec<&'static str> {
        [
            ("light", self.light != other.light),
            ("samples", self.samples != other.samples),
            ("light_radius", self.light_radius != other.light_radius),
            ("resolution", self.resolution != other.resolution),
            ("fill", self.fill != other.fill),
            ("occlusion", self.occlusion != other.occlusion),
            ("min_layer_distance", self.min_layer_distance != other.min_layer_distance),
            ("seed", self.seed != other.seed),
        ]
        .into_iter()
        .filter_map(|(name, differs)| differs.then_some(name))
        .collect()
    }
}

fn is_zero(iterations: &u32) -> bool {
    *iterations == 0
}

fn one() -> u32 {
    1
}

fn is_one(iterations: &u32) -> bool {
    *iterations == 1
}

/// A shadow texture that is stored with a cloud.
#[derive(Debug, Clone, PartialEq)]
pub struct ShadowTexture {
    /// The settings it belongs to.
    pub casting: Casting,
    /// m of each point, in [0, 1], in the order of the cloud.
    pub lit: Vec<f32>,
}

/// A light in the form of a prepared file.
#[derive(Serialize, Deserialize)]
#[serde(remote = "Light", rename = "LightRecord", rename_all = "lowercase")]
enum LightRecord {
    // No casting has one.
    #[serde(skip)]
    Headlight,
    Direction(DVec3),
    Position(DVec3),
}
