//! Roles of the values of a row.

use glam::{DVec3, Vec3};

use super::{ALPHA, COLOR_PREFIXES, COLORS, Column, LINEAR_COLOR, NORMAL, POSITION, RADIUS};
use crate::channel::Channel;
use pellucid_core::cloud::{CLASSIFICATION_NAMES, Cloud, INTENSITY_NAMES};

/// The largest deviation of a normal's length from 1 that is left uncorrected: float32 unit vectors are within 2e-7.
const UNIT_TOLERANCE: f32 = 1e-6;

/// The places of a table's columns in its rows.
#[derive(Debug)]
pub(crate) struct RowLayout {
    position: [usize; 3],
    normal: Option<[usize; 3]>,
    color: Option<[Channel; 3]>,
    alpha: Option<Channel>,
    radius: Option<usize>,
    intensity: Option<usize>,
    scalars: Vec<(usize, String)>,
    /// `true` if the last scalar is a classification, provided that its values are codes.
    pub(super) classified: bool,
}

impl RowLayout {
    /// Finds the columns of a table; fails with the coordinate that is missing.
    pub fn new(columns: &[Column]) -> Result<Self, &'static str> {
        let mut names = Names::new(columns);
        let coordinates = ["x", "y", "z"];
        let Some(position) = names.take_three(&POSITION) else {
            let missing = coordinates.into_iter().find(|name| names.find(name).is_none());
            return Err(missing.unwrap_or("x"));
        };
        let normal = names.take_three(&NORMAL);
        let linear = names.take_three(&LINEAR_COLOR).map(|at| at.map(Channel::linear_float));
        let channel = |at: usize| Channel::new(at, &columns[at].kind);
        let color = linear.or_else(|| {
            let channels = names.take_color()?.map(channel);
            // Three channels have one range.
            let measures = channels.iter().any(Channel::is_measured);
            Some(if measures { channels.map(Channel::stored) } else { channels })
        });
        let alpha = names.take(&ALPHA).map(channel);
        let radius = names.take(&RADIUS);
        let class = names.take(&CLASSIFICATION_NAMES);
        let intensity = names.take(&INTENSITY_NAMES);
        let scalars = names.rest().chain(class).map(|at| (at, columns[at].name.clone())).collect();
        Ok(Self { position, normal, color, alpha, radius, intensity, scalars, classified: class.is_some() })
    }

    /// Returns a cloud of no points with these columns, a classification among the scalars.
    pub(super) fn empty(&self) -> Cloud {
        Cloud {
            colors: self.color.as_ref().map(|_| Vec::new()),
            alphas: self.alpha.as_ref().map(|_| Vec::new()),
            normals: self.normal.map(|_| Vec::new()),
            radii: self.radius.map(|_| Vec::new()),
            intensity: self.intensity.map(|_| Vec::new()),
            scalars: self.scalars.iter().map(|(_, name)| (name.clone(), Vec::new())).collect(),
            ..Cloud::default()
        }
    }

    /// Returns the number of bytes of a row in the columns of a cloud.
    pub fn bytes(&self) -> u64 {
        let threes = u64::from(self.color.is_some()) + u64::from(self.normal.is_some());
        let single = [self.alpha.is_some(), self.radius.is_some(), self.intensity.is_some()];
        let ones = single.into_iter().filter(|is_there| *is_there).count() + self.scalars.len();
        size_of::<DVec3>() as u64 + threes * size_of::<Vec3>() as u64 + ones as u64 * size_of::<f32>() as u64
    }

    /// Returns `true` if the rows have colors.
    pub fn has_color(&self) -> bool {
        self.color.is_some()
    }

    /// Returns `true` if the range of colors and the range of alphas is that of all values.
    pub(super) fn measures(&self) -> [bool; 2] {
        let color = self.color.as_ref().is_some_and(|[red, ..]| red.is_measured());
        [color, self.alpha.as_ref().is_some_and(Channel::is_measured)]
    }

    /// Returns the position, if it is finite.
    #[inline]
    pub(super) fn position(&self, value: impl Fn(usize) -> f64) -> Option<DVec3> {
        let [x, y, z] = self.position;
        Some(DVec3::new(value(x), value(y), value(z))).filter(|position| position.is_finite())
    }

    #[inline]
    pub(super) fn normal(&self, value: impl Fn(usize) -> f64) -> Option<Vec3> {
        self.normal.map(|[x, y, z]| unit_or_zero(Vec3::new(value(x) as f32, value(y) as f32, value(z) as f32)))
    }

    /// Returns the linear color, or what is stored if the range is not known yet.
    #[inline]
    pub(super) fn color(&self, value: impl Fn(usize) -> f64) -> Option<Vec3> {
        let [r, g, b] = self.color.as_ref()?;
        Some(Vec3::new(r.linear(value(r.at)), g.linear(value(g.at)), b.linear(value(b.at))))
    }

    /// Returns the alpha, or what is stored if the range is not known yet.
    #[inline]
    pub(super) fn alpha(&self, value: impl Fn(usize) -> f64) -> Option<f32> {
        self.alpha.as_ref().map(|channel| channel.unit(value(channel.at)))
    }

    #[inline]
    pub(super) fn radius(&self, value: impl Fn(usize) -> f64) -> Option<f32> {
        let radius = value(self.radius?) as f32;
        Some(if radius.is_finite() { radius.max(0.0) } else { 0.0 })
    }

    #[inline]
    pub(super) fn intensity(&self, value: impl Fn(usize) -> f64) -> Option<f32> {
        self.intensity.map(|at| value(at) as f32)
    }

    /// Returns the places of the other values, in the order of the cloud's scalars.
    pub(super) fn scalar_places(&self) -> impl Iterator<Item = usize> {
        self.scalars.iter().map(|(at, _)| *at)
    }

    /// Returns the other values, in the order of the cloud's scalars.
    pub(super) fn scalars(&self, value: impl Fn(usize) -> f64) -> impl Iterator<Item = f32> {
        self.scalar_places().map(move |at| value(at) as f32)
    }
}

/// Returns the normal with length 1, or zero if it has no direction.
#[inline]
pub fn unit_or_zero(normal: Vec3) -> Vec3 {
    if (normal.length_squared() - 1.0).abs() <= UNIT_TOLERANCE {
        return normal;
    }
    // In float64, where the squares of all float32 values are finite and above zero.
    normal.as_dvec3().try_normalize().map_or(Vec3::ZERO, |unit| unit.as_vec3())
}

/// The columns of a table that are not assigned yet.
struct Names {
    lower: Vec<Option<String>>,
}

impl Names {
    fn new(columns: &[Column]) -> Self {
        Self { lower: columns.iter().map(|column| Some(column.name.to_ascii_lowercase())).collect() }
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

    fn take_color(&mut self) -> Option<[usize; 3]> {
        COLOR_PREFIXES.iter().find_map(|prefix| {
            let of = |names: &[&str; 3]| names.map(|name| format!("{prefix}{name}"));
            COLORS.iter().find_map(|names| self.take_three(&[of(names).each_ref().map(String::as_str)]))
        })
    }

    fn rest(&self) -> impl Iterator<Item = usize> {
        self.lower.iter().enumerate().filter(|(_, name)| name.is_some()).map(|(at, _)| at)
    }
}
