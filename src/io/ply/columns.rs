//! From the values of a vertex to the columns of a cloud, by the names of its properties (the table in `ply`).

use glam::{DVec3, Vec3};

use super::header::{Element, ScalarType};
use crate::cloud::{Cloud, UpAxis};
use crate::color::decode_srgb;

const POSITION: [[&str; 3]; 1] = [["x", "y", "z"]];
const NORMAL: [[&str; 3]; 3] =
    [["nx", "ny", "nz"], ["normal_x", "normal_y", "normal_z"], ["normalx", "normaly", "normalz"]];
const COLOR: [[&str; 3]; 3] =
    [["red", "green", "blue"], ["diffuse_red", "diffuse_green", "diffuse_blue"], ["r", "g", "b"]];
/// Linear colors, which only files have that 16-bit sRGB would round.
pub(super) const LINEAR_COLOR: [[&str; 3]; 1] = [["linear_red", "linear_green", "linear_blue"]];
const ALPHA: [&str; 2] = ["alpha", "diffuse_alpha"];
const RADIUS: [&str; 1] = ["radius"];
/// Names of a classification, in lower case.
pub(crate) const CLASSIFICATION_NAMES: [&str; 6] =
    ["classification", "scalar_classification", "class", "scalar_class", "label", "scalar_label"];
/// Names of an intensity, in lower case.
pub(crate) const INTENSITY_NAMES: [&str; 2] = ["intensity", "scalar_intensity"];

/// How far from 1 a normal's length may be to be left as it is: float32 unit vectors are within 2e-7.
const UNIT_TOLERANCE: f32 = 1e-6;

/// Columns that grow row by row, and where in a row each finds its values.
pub(super) struct Columns {
    position: [usize; 3],
    normal: Option<[usize; 3]>,
    color: Option<[Channel; 3]>,
    alpha: Option<Channel>,
    radius: Option<usize>,
    classification: Option<usize>,
    classification_name: String,
    intensity: Option<usize>,
    scalars: Vec<usize>,
    codes: Vec<f32>,
    cloud: Cloud,
}

impl Columns {
    /// Finds the columns of a vertex element; fails with the coordinate that is missing.
    pub fn new(vertex: &Element) -> Result<Self, &'static str> {
        let mut names = Names::of(vertex);
        let coordinates = ["x", "y", "z"];
        let Some(position) = names.take_three(&POSITION) else {
            let missing = coordinates.into_iter().find(|name| names.find(name).is_none());
            return Err(missing.unwrap_or("x"));
        };
        let normal = names.take_three(&NORMAL);
        let linear = names.take_three(&LINEAR_COLOR).map(|at| at.map(Channel::linear_float));
        let color = linear.or_else(|| names.take_three(&COLOR).map(|at| at.map(|at| names.channel(at))));
        let alpha = names.take(&ALPHA).map(|at| names.channel(at));
        let radius = names.take(&RADIUS);
        let classification = names.take(&CLASSIFICATION_NAMES);
        let intensity = names.take(&INTENSITY_NAMES);
        let scalars: Vec<usize> = names.rest().collect();
        let cloud = Cloud {
            colors: color.as_ref().map(|_| Vec::new()),
            alphas: alpha.as_ref().map(|_| Vec::new()),
            normals: normal.map(|_| Vec::new()),
            radii: radius.map(|_| Vec::new()),
            intensity: intensity.map(|_| Vec::new()),
            scalars: scalars.iter().map(|&at| (names.original[at].clone(), Vec::new())).collect(),
            up: UpAxis::Y,
            ..Cloud::default()
        };
        let classification_name = classification.map(|at| names.original[at].clone()).unwrap_or_default();
        let codes = Vec::new();
        Ok(Self {
            position,
            normal,
            color,
            alpha,
            radius,
            classification,
            classification_name,
            intensity,
            scalars,
            codes,
            cloud,
        })
    }

    /// Adds a vertex, or counts it if its position is not finite.
    pub fn push(&mut self, row: &[f64]) {
        let cloud = &mut self.cloud;
        let position = DVec3::from(self.position.map(|at| row[at]));
        if !position.is_finite() {
            cloud.non_finite += 1;
            return;
        }
        cloud.positions.push(position);
        if let (Some(at), Some(normals)) = (self.normal, &mut cloud.normals) {
            normals.push(unit_or_zero(Vec3::from(at.map(|at| row[at] as f32))));
        }
        if let (Some(channels), Some(colors)) = (&self.color, &mut cloud.colors) {
            colors.push(Vec3::from(channels.each_ref().map(|channel| channel.linear(row))));
        }
        if let (Some(channel), Some(alphas)) = (&self.alpha, &mut cloud.alphas) {
            alphas.push(channel.unit(row));
        }
        if let (Some(at), Some(radii)) = (self.radius, &mut cloud.radii) {
            let radius = row[at] as f32;
            radii.push(if radius.is_finite() { radius.max(0.0) } else { 0.0 });
        }
        if let Some(at) = self.classification {
            self.codes.push(row[at] as f32);
        }
        if let (Some(at), Some(intensity)) = (self.intensity, &mut cloud.intensity) {
            intensity.push(row[at] as f32);
        }
        for (&at, (_, values)) in self.scalars.iter().zip(&mut cloud.scalars) {
            values.push(row[at] as f32);
        }
    }

    /// The cloud. Normals that are all zero are none.
    pub fn finish(self) -> Cloud {
        let mut cloud = self.cloud;
        if self.classification.is_some() {
            if self.codes.iter().all(|code| (0.0..=255.0).contains(code) && code.fract() == 0.0) {
                cloud.classification = Some(self.codes.iter().map(|&code| code as u8).collect());
            } else {
                cloud.scalars.push((self.classification_name, self.codes));
            }
        }
        cloud.normals = cloud.normals.filter(|normals| normals.iter().any(|&n| n != Vec3::ZERO));
        cloud
    }
}

/// The normal with length 1, or zero if it has no direction.
fn unit_or_zero(normal: Vec3) -> Vec3 {
    if (normal.length_squared() - 1.0).abs() <= UNIT_TOLERANCE {
        return normal;
    }
    // In float64, where the squares of all float32 values are finite and above zero.
    normal.as_dvec3().try_normalize().map_or(Vec3::ZERO, |unit| unit.as_vec3())
}

/// A color or alpha channel.
struct Channel {
    at: usize,
    scale: Scale,
    /// Linear values of the integers of that type; empty for floats.
    table: Vec<f32>,
}

#[derive(Clone, Copy)]
enum Scale {
    /// Integers up to this are 0–1. Signed bytes are bytes that someone declared wrongly.
    Integer {
        largest: u16,
        signed_byte: bool,
    },
    Float,
    /// As it is.
    Linear,
}

/// Whether the reader would take a property of this name for one of its columns, if need be together with others.
pub(super) fn is_known(name: &str) -> bool {
    let lower = name.to_ascii_lowercase();
    let threes = POSITION.iter().chain(&NORMAL).chain(&COLOR).chain(&LINEAR_COLOR).flatten();
    let ones = ALPHA.iter().chain(&RADIUS).chain(&CLASSIFICATION_NAMES).chain(&INTENSITY_NAMES);
    threes.chain(ones).any(|known| *known == lower)
}

impl Channel {
    fn linear_float(at: usize) -> Self {
        Self { at, scale: Scale::Linear, table: Vec::new() }
    }

    fn new(at: usize, scalar: &ScalarType) -> Self {
        let scale = match scalar {
            ScalarType::Float | ScalarType::Double => Scale::Float,
            ScalarType::UShort => Scale::Integer { largest: u16::MAX, signed_byte: false },
            ScalarType::Char => Scale::Integer { largest: 255, signed_byte: true },
            ScalarType::UChar | ScalarType::Short | ScalarType::Int | ScalarType::UInt => {
                Scale::Integer { largest: 255, signed_byte: false }
            }
        };
        let table = match scale {
            Scale::Integer { largest, .. } => {
                (0..=largest).map(|value| decode_srgb(f32::from(value) / f32::from(largest))).collect()
            }
            Scale::Float | Scale::Linear => Vec::new(),
        };
        Self { at, scale, table }
    }

    /// The stored integer, clamped to its range.
    fn integer(&self, row: &[f64], largest: u16, signed_byte: bool) -> u16 {
        let value = row[self.at];
        let value = if signed_byte && value < 0.0 { value + 256.0 } else { value };
        // The conversion saturates, and turns NaN into 0.
        (value as u16).min(largest)
    }

    /// The linear value of an sRGB-encoded channel.
    fn linear(&self, row: &[f64]) -> f32 {
        match self.scale {
            Scale::Integer { largest, signed_byte } => self.table[usize::from(self.integer(row, largest, signed_byte))],
            Scale::Float => {
                let value = row[self.at] as f32;
                if value.is_nan() { 0.0 } else { decode_srgb(value.clamp(0.0, 1.0)) }
            }
            Scale::Linear => {
                let value = row[self.at] as f32;
                if value.is_nan() { 0.0 } else { value.clamp(0.0, 1.0) }
            }
        }
    }

    /// The value itself in [0, 1]; what is not a number counts as 1.
    fn unit(&self, row: &[f64]) -> f32 {
        match self.scale {
            Scale::Integer { largest, signed_byte } => {
                f32::from(self.integer(row, largest, signed_byte)) / f32::from(largest)
            }
            Scale::Float | Scale::Linear => {
                let value = row[self.at] as f32;
                if value.is_nan() { 1.0 } else { value.clamp(0.0, 1.0) }
            }
        }
    }
}

/// The scalar properties of an element that no column has taken yet.
struct Names {
    original: Vec<String>,
    lower: Vec<Option<String>>,
    types: Vec<ScalarType>,
}

impl Names {
    fn of(element: &Element) -> Self {
        let scalars = || element.properties.iter().filter_map(|p| Some((&p.name, p.kind.scalar()?)));
        Self {
            original: scalars().map(|(name, _)| name.clone()).collect(),
            lower: scalars().map(|(name, _)| Some(name.to_ascii_lowercase())).collect(),
            types: scalars().map(|(_, scalar)| scalar.clone()).collect(),
        }
    }

    fn find(&self, name: &str) -> Option<usize> {
        self.lower.iter().position(|n| n.as_deref() == Some(name))
    }

    fn take(&mut self, names: &[&str]) -> Option<usize> {
        let at = names.iter().find_map(|name| self.find(name))?;
        self.lower[at] = None;
        Some(at)
    }

    fn take_three(&mut self, names: &[[&str; 3]]) -> Option<[usize; 3]> {
        let at = names.iter().find_map(|[a, b, c]| Some([self.find(a)?, self.find(b)?, self.find(c)?]))?;
        for at in at {
            self.lower[at] = None;
        }
        Some(at)
    }

    fn channel(&self, at: usize) -> Channel {
        Channel::new(at, &self.types[at])
    }

    fn rest(&self) -> impl Iterator<Item = usize> {
        self.lower.iter().enumerate().filter(|(_, name)| name.is_some()).map(|(at, _)| at)
    }
}
