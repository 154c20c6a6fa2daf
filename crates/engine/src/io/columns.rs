//! From the rows of a table to the columns of a cloud, by the names of the table's columns (the table in `ply`).

use glam::{DVec3, Vec3};
use rayon::prelude::*;

pub(super) use ply_rs_bw::ply::ScalarType;

use super::channel::{self, Channel};
use crate::cloud::{CLASSIFICATION_NAMES, Cloud, INTENSITY_NAMES};

const POSITION: [[&str; 3]; 1] = [["x", "y", "z"]];
const NORMAL: [[&str; 3]; 3] =
    [["nx", "ny", "nz"], ["normal_x", "normal_y", "normal_z"], ["normalx", "normaly", "normalz"]];
const COLOR: [[&str; 3]; 3] =
    [["red", "green", "blue"], ["diffuse_red", "diffuse_green", "diffuse_blue"], ["r", "g", "b"]];
/// Linear colors, which only files have that 16-bit sRGB would round.
pub(super) const LINEAR_COLOR: [[&str; 3]; 1] = [["linear_red", "linear_green", "linear_blue"]];
const ALPHA: [&str; 2] = ["alpha", "diffuse_alpha"];
const RADIUS: [&str; 1] = ["radius"];

/// The largest deviation of a normal's length from 1 that is left uncorrected: float32 unit vectors are within 2e-7.
const UNIT_TOLERANCE: f32 = 1e-6;

/// A column of a file: a name and the type of its values.
pub(super) struct Column {
    pub name: String,
    pub kind: ScalarType,
}

impl Column {
    pub fn new(name: impl Into<String>, kind: ScalarType) -> Self {
        Self { name: name.into(), kind }
    }
}

/// The source of the number that means full intensity in colors and alphas.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum FullScale {
    /// The type: bytes reach 255, shorts 65535, floats 1.
    Typed,
    /// The values of the whole file, unless they are bytes.
    Measured,
}

/// The source of colors.
enum Rgb {
    Typed([Channel; 3]),
    /// Kept as they are until the largest is known.
    Measured([usize; 3], Vec<[f32; 3]>),
}

/// The source of alphas.
enum Alpha {
    Typed(Channel),
    /// Kept as they are until the largest is known.
    Measured(usize, Vec<f32>),
}

/// Columns that grow row by row, and the position of each one's values in a row.
pub(super) struct Columns {
    position: [usize; 3],
    normal: Option<[usize; 3]>,
    color: Option<Rgb>,
    alpha: Option<Alpha>,
    radius: Option<usize>,
    classification: Option<usize>,
    classification_name: String,
    intensity: Option<usize>,
    scalars: Vec<usize>,
    codes: Vec<f32>,
    cloud: Cloud,
}

impl Columns {
    /// Finds the columns of a table; fails with the coordinate that is missing.
    pub fn new(columns: &[Column], full_scale: FullScale) -> Result<Self, &'static str> {
        let mut names = Names::new(columns);
        let coordinates = ["x", "y", "z"];
        let Some(position) = names.take_three(&POSITION) else {
            let missing = coordinates.into_iter().find(|name| names.find(name).is_none());
            return Err(missing.unwrap_or("x"));
        };
        let normal = names.take_three(&NORMAL);
        let linear = names.take_three(&LINEAR_COLOR).map(|at| at.map(Channel::linear_float));
        let color = linear.map(Rgb::Typed).or_else(|| {
            let at = names.take_three(&COLOR)?;
            let measured = full_scale == FullScale::Measured && at.iter().any(|&at| !names.is_byte(at));
            Some(if measured { Rgb::Measured(at, Vec::new()) } else { Rgb::Typed(at.map(|at| names.channel(at))) })
        });
        let alpha = names.take(&ALPHA).map(|at| {
            let measured = full_scale == FullScale::Measured && !names.is_byte(at);
            if measured { Alpha::Measured(at, Vec::new()) } else { Alpha::Typed(names.channel(at)) }
        });
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
        match (&mut self.color, &mut cloud.colors) {
            (Some(Rgb::Typed(channels)), Some(colors)) => {
                colors.push(Vec3::from(channels.each_ref().map(|channel| channel.linear(row))));
            }
            (Some(Rgb::Measured(at, encoded)), _) => encoded.push(at.map(|at| row[at] as f32)),
            _ => {}
        }
        match (&mut self.alpha, &mut cloud.alphas) {
            (Some(Alpha::Typed(channel)), Some(alphas)) => alphas.push(channel.unit(row)),
            (Some(Alpha::Measured(at, stored)), _) => stored.push(row[*at] as f32),
            _ => {}
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

    /// The cloud, its vertical +Y. Normals that are all zero are dropped.
    pub fn finish(self) -> Cloud {
        let mut cloud = self.cloud;
        if self.classification.is_some() {
            if self.codes.iter().all(|code| (0.0..=255.0).contains(code) && code.fract() == 0.0) {
                cloud.classification = Some(self.codes.iter().map(|&code| code as u8).collect());
            } else {
                cloud.scalars.push((self.classification_name, self.codes));
            }
        }
        if let Some(Rgb::Measured(_, encoded)) = self.color {
            cloud.colors = channel::measured(&encoded);
        }
        if let Some(Alpha::Measured(_, stored)) = self.alpha {
            let full = channel::full_scale(stored.par_iter().copied()).unwrap_or(1.0);
            let unit = |value: f32| if value.is_nan() { 1.0 } else { (value / full).clamp(0.0, 1.0) };
            cloud.alphas = Some(stored.into_iter().map(unit).collect());
        }
        cloud.normals = cloud.normals.filter(|normals| normals.iter().any(|&n| n != Vec3::ZERO));
        cloud
    }
}

/// The normal with length 1, or zero if it has no direction.
pub(super) fn unit_or_zero(normal: Vec3) -> Vec3 {
    if (normal.length_squared() - 1.0).abs() <= UNIT_TOLERANCE {
        return normal;
    }
    // In float64, where the squares of all float32 values are finite and above zero.
    normal.as_dvec3().try_normalize().map_or(Vec3::ZERO, |unit| unit.as_vec3())
}

/// True if the reader would take a property of this name for one of its columns, alone or together with others.
pub(super) fn is_known(name: &str) -> bool {
    let lower = name.to_ascii_lowercase();
    let threes = POSITION.iter().chain(&NORMAL).chain(&COLOR).chain(&LINEAR_COLOR).flatten();
    let ones = ALPHA.iter().chain(&RADIUS).chain(&CLASSIFICATION_NAMES).chain(&INTENSITY_NAMES);
    threes.chain(ones).any(|known| *known == lower)
}

/// The columns of a table that are not assigned yet.
struct Names {
    original: Vec<String>,
    lower: Vec<Option<String>>,
    types: Vec<ScalarType>,
}

impl Names {
    fn new(columns: &[Column]) -> Self {
        Self {
            original: columns.iter().map(|column| column.name.clone()).collect(),
            lower: columns.iter().map(|column| Some(column.name.to_ascii_lowercase())).collect(),
            types: columns.iter().map(|column| column.kind.clone()).collect(),
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

    fn is_byte(&self, at: usize) -> bool {
        self.types[at] == ScalarType::UChar
    }

    fn channel(&self, at: usize) -> Channel {
        Channel::new(at, &self.types[at])
    }

    fn rest(&self) -> impl Iterator<Item = usize> {
        self.lower.iter().enumerate().filter(|(_, name)| name.is_some()).map(|(at, _)| at)
    }
}
