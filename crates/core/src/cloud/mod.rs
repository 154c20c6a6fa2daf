//! A point cloud as a file holds it: float64 positions and named columns, in the file's order.

pub mod crs;
#[doc(hidden)]
pub mod depth_camera;
pub mod facts;
pub mod field;
pub mod filter;
pub mod gaussians;
pub mod light_image;
mod parts;
pub mod sampling;
pub mod sensor;
pub mod shadow_texture;
#[doc(hidden)]
pub mod upright;

use std::sync::Arc;

use glam::{BVec3, DVec3, Vec3};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crs::Crs;
use field::Field;
use filter::Filter;
use gaussians::Gaussians;
use sensor::Sensor;
use shadow_texture::ShadowTexture;

/// Names of a classification, in lower case.
pub const CLASSIFICATION_NAMES: [&str; 6] =
    ["classification", "scalar_classification", "class", "scalar_class", "label", "scalar_label"];
/// Names of an intensity, in lower case.
pub const INTENSITY_NAMES: [&str; 2] = ["intensity", "scalar_intensity"];

/// The scalar that holds the number of a return within its pulse.
pub const RETURN_NUMBER: &str = "return_number";
/// The scalar that holds the number of returns of a pulse.
pub const NUMBER_OF_RETURNS: &str = "number_of_returns";
/// The scalar that holds the source of a point.
pub const POINT_SOURCE: &str = "point_source_id";
/// The scalar that holds the GPS time of a point.
pub const GPS_TIME: &str = "gps_time";

/// Returns `true` if two names mean the same scalar, as `GpsTime`, `scalar_GpsTime` and `gps_time` do.
pub fn same_scalar(a: &str, b: &str) -> bool {
    let letters = |name: &str| {
        let name = name.to_lowercase();
        let name = name.strip_prefix("scalar_").unwrap_or(&name);
        name.chars().filter(|c| c.is_alphanumeric()).collect::<String>()
    };
    letters(a) == letters(b)
}

/// Axis of a file that points up; decides the automatic camera.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum UpAxis {
    /// Clouds that are flattest along X.
    X,
    /// Models (PLY): +Y is up.
    #[default]
    Y,
    /// Surveys and scans (all other point clouds): +Z is up.
    Z,
    /// Clouds in the frame of a depth camera, whose rows run along +Y: −Y is up.
    #[serde(rename = "-y")]
    NegativeY,
}

impl UpAxis {
    /// Returns the unit vector that points up.
    pub fn direction(self) -> DVec3 {
        match self {
            Self::X => DVec3::X,
            Self::Y => DVec3::Y,
            Self::Z => DVec3::Z,
            Self::NegativeY => DVec3::NEG_Y,
        }
    }
}

/// A cloud of finite points. Every optional column is as long as `positions`.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Cloud {
    /// Positions in the file's units, float64 up to the camera-relative subtraction.
    pub positions: Vec<DVec3>,
    /// Linear RGB; 8- and 16-bit file colors are sRGB-decoded on load.
    pub colors: Option<Vec<Vec3>>,
    /// The file's own alpha in [0, 1]; multiplies the scene's opacity.
    pub alphas: Option<Vec<f32>>,
    /// Unit normals; `Vec3::ZERO` for points without one (missing, zero or non-finite in the file).
    pub normals: Option<Vec<Vec3>>,
    /// The file's own radii in file units, finite and at least 0.
    pub radii: Option<Vec<f32>>,
    /// Shape and color of the points of files that hold Gaussian splats; `colors` are then those without harmonics, and
    /// `alphas` their opacities.
    pub gaussians: Option<Gaussians>,
    /// The filter that a file of splats names.
    pub filter: Option<Filter>,
    /// LAS classification codes, or an integer property of that name.
    pub classification: Option<Vec<u8>>,
    /// Intensity as stored (LAS: 0–65535), of E57 from 0 to 1 where its limits hold.
    pub intensity: Option<Vec<f32>>,
    /// Every other scalar property, by the name the file gives it.
    pub scalars: Vec<(String, Vec<f32>)>,
    /// Points that the file holds but that were dropped because a coordinate is not finite.
    pub non_finite: usize,
    /// Points that the file marks as withheld (deleted), which were dropped.
    pub withheld: usize,
    /// The file's vertical.
    pub up: UpAxis,
    /// Reason why it isn't the axis of the file's format, if its points alone say so: the end of a sentence.
    pub up_reason: Option<&'static str>,
    /// The coordinate reference system that the file states.
    pub crs: Option<Arc<Crs>>,
    /// `true` as long as `up` is but the convention of a format.
    pub up_is_convention: bool,
    /// The sensor of a cloud that was seen from one place.
    pub sensor: Option<Sensor>,
    /// Data that `pellucid prepare` stored with the points, if they are unchanged since then.
    pub prepared: Option<Prepared>,
    /// Oddities of the file that did not prevent reading it, one sentence each.
    pub warnings: Vec<String>,
}

/// Data that `pellucid prepare` stored with a cloud (docs/prepared-clouds.md).
#[derive(Debug, Clone, PartialEq)]
pub struct Prepared {
    /// K of the radii and of an uncertainty field.
    pub neighbors: usize,
    /// The cap of the radii of Eq. 20, also in an uncertainty field; 0: none.
    pub radius_cap: f32,
    /// `true` if the cloud's radii are those of Eq. 20 instead of the source's own.
    pub estimated_radii: bool,
    /// The definition of the field.
    pub field: Field,
    /// F of each point, in [0, 1].
    pub values: Vec<f32>,
    /// The light of each point, if it was asked for.
    pub shadows: Option<ShadowTexture>,
}

impl Cloud {
    /// Returns the radii of the points themselves, not those of Eq. 20 that were stored with them.
    pub fn own_radii(&self) -> Option<&[f32]> {
        self.radii.as_deref().filter(|_| !self.prepared.as_ref().is_some_and(|prepared| prepared.estimated_radii))
    }

    /// Returns the scalar of a name, however the file spells it.
    pub fn scalar(&self, name: &str) -> Option<&[f32]> {
        let found = self.scalars.iter().find(|(known, _)| known == name);
        let found = found.or_else(|| self.scalars.iter().find(|(known, _)| same_scalar(known, name)));
        found.map(|(_, values)| values.as_slice())
    }

    /// Returns the number of finite points.
    pub fn len(&self) -> usize {
        self.positions.len()
    }

    /// Returns `true` if no finite point is left.
    pub fn is_empty(&self) -> bool {
        self.positions.is_empty()
    }

    /// Returns the smallest and largest corner of the finite points; `None` for an empty cloud.
    pub fn bounds(&self) -> Option<Bounds> {
        Bounds::of(&self.positions)
    }
}

/// An axis-aligned box in world units.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(from = "[[f64; 3]; 2]", into = "[[f64; 3]; 2]")]
pub struct Bounds {
    /// Smallest corner.
    pub min: DVec3,
    /// Largest corner.
    pub max: DVec3,
}

impl From<[[f64; 3]; 2]> for Bounds {
    fn from([min, max]: [[f64; 3]; 2]) -> Self {
        Self { min: min.into(), max: max.into() }
    }
}

impl From<Bounds> for [[f64; 3]; 2] {
    fn from(bounds: Bounds) -> Self {
        [bounds.min.to_array(), bounds.max.to_array()]
    }
}

impl Bounds {
    /// Returns the bounding box of a list of points, found on all cores; `None` if there are none.
    pub fn of(points: &[DVec3]) -> Option<Self> {
        let first = *points.first()?;
        let add = |b: Self, p: &DVec3| Self { min: b.min.min(*p), max: b.max.max(*p) };
        let one = Self { min: first, max: first };
        Some(points.par_chunks(1 << 14).map(|some| some.iter().fold(one, add)).reduce(|| one, Self::union))
    }

    /// Returns the bounding box of some points; `None` if there are none.
    pub fn enclosing(points: impl IntoIterator<Item = DVec3>) -> Option<Self> {
        points.into_iter().map(|p| Self { min: p, max: p }).reduce(Self::union)
    }

    /// Returns the smallest box around both.
    pub fn union(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// Returns `true` if another box lies within this one.
    pub fn holds(&self, other: &Self) -> bool {
        self.min.cmple(other.min).all() && other.max.cmple(self.max).all()
    }

    /// Returns the middle of the box.
    pub fn center(&self) -> DVec3 {
        0.5 * self.min + 0.5 * self.max
    }

    /// Returns the length of the diagonal.
    pub fn diagonal(&self) -> f64 {
        (self.max - self.min).length()
    }

    /// Returns the eight corners.
    pub fn corners(&self) -> [DVec3; 8] {
        std::array::from_fn(|i| {
            let is_high = BVec3::from_array([0, 1, 2].map(|bit| i >> bit & 1 == 1));
            DVec3::select(is_high, self.max, self.min)
        })
    }
}
