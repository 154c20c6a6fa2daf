//! Points from arrays.

use std::sync::Arc;

use glam::{DVec3, Vec3};
use pellucid_core::cloud::{Cloud as Columns, UpAxis};

use crate::{Error, Result};

/// Point cloud: float64 positions and optional columns, each as long as the positions. Clones share all of it.
#[derive(Debug, Clone)]
pub struct Cloud {
    pub(crate) columns: Arc<Columns>,
    pub(crate) opacity: Option<f32>,
    pub(crate) radius: Option<f32>,
    pub(crate) color: Option<[f32; 3]>,
}

/// Columns of a [`Cloud`]; [`build`](Self::build) checks them. Arrays that are given as `Vec` are not copied.
#[derive(Debug, Clone, Default)]
#[must_use]
pub struct CloudBuilder {
    positions: Vec<[f64; 3]>,
    colors: Option<Vec<[f32; 3]>>,
    normals: Option<Vec<[f32; 3]>>,
    radii: Option<Vec<f32>>,
    opacities: Option<Vec<f32>>,
    scalars: Vec<(String, Vec<f32>)>,
    color: Option<[f32; 3]>,
    opacity: Option<f32>,
    radius: Option<f32>,
    z_up: bool,
}

impl Cloud {
    /// Begins a cloud of points at positions in world units.
    pub fn from_positions(positions: impl Into<Vec<[f64; 3]>>) -> CloudBuilder {
        CloudBuilder { positions: positions.into(), ..CloudBuilder::default() }
    }

    /// Returns the number of points.
    pub fn len(&self) -> usize {
        self.columns.len()
    }

    /// Returns `true` if there are no points.
    pub fn is_empty(&self) -> bool {
        self.columns.is_empty()
    }

    /// Returns the smallest and the largest corner of the points; `None` if there are no points.
    pub fn bounds(&self) -> Option<[[f64; 3]; 2]> {
        self.columns.bounds().map(|b| [b.min.to_array(), b.max.to_array()])
    }
}

impl CloudBuilder {
    /// Sets the color of each point: linear R, G, B from 0 to 1.
    pub fn colors(self, colors: impl Into<Vec<[f32; 3]>>) -> Self {
        Self { colors: Some(colors.into()), ..self }
    }

    /// Sets one color for all points: linear R, G, B from 0 to 1.
    pub fn color(self, color: [f32; 3]) -> Self {
        Self { color: Some(color), ..self }
    }

    /// Sets the normal of each point, of any length. A zero vector means that the point has no normal.
    pub fn normals(self, normals: impl Into<Vec<[f32; 3]>>) -> Self {
        Self { normals: Some(normals.into()), ..self }
    }

    /// Sets the radius of each point in world units, at least 0. Without radii, they are estimated from the neighbors
    /// of each point.
    pub fn radii(self, radii: impl Into<Vec<f32>>) -> Self {
        Self { radii: Some(radii.into()), ..self }
    }

    /// Sets one radius for all points, in world units, at least 0.
    pub fn radius(self, radius: f32) -> Self {
        Self { radius: Some(radius), ..self }
    }

    /// Sets the opacity of each point, from 0 to 1. The opacity of the whole cloud multiplies it.
    pub fn opacities(self, opacities: impl Into<Vec<f32>>) -> Self {
        Self { opacities: Some(opacities.into()), ..self }
    }

    /// Sets the opacity of the whole cloud, from 0 to 1, 1 by default.
    pub fn opacity(self, opacity: f32) -> Self {
        Self { opacity: Some(opacity), ..self }
    }

    /// Adds a scalar of each point, which the setting `cloud.field` can name. It replaces one of the same name.
    pub fn scalar(mut self, name: &str, values: impl Into<Vec<f32>>) -> Self {
        self.scalars.retain(|(known, _)| known != name);
        self.scalars.push((name.to_owned(), values.into()));
        self
    }

    /// Makes +Z point up, as in surveys, instead of +Y. The automatic camera depends on it.
    pub fn z_up(self) -> Self {
        Self { z_up: true, ..self }
    }

    /// Checks the columns.
    ///
    /// # Errors
    /// Returns an error if a column has another length than the positions, if a coordinate or a normal is not finite,
    /// or if a color, a radius or an opacity is out of range.
    pub fn build(self) -> Result<Cloud> {
        let unit = |x: &f32| (0.0..=1.0).contains(x);
        let not_negative = |x: &f32| *x >= 0.0 && x.is_finite();
        let count = self.positions.len();
        check("positions", self.positions.iter().flatten().map(|x| x.is_finite()), "a finite number", 3)?;
        column("colors", &self.colors, count, |color| color.iter().all(unit), "from 0 to 1")?;
        column("normals", &self.normals, count, |n| n.iter().all(|x| x.is_finite()), "a finite number")?;
        column("radii", &self.radii, count, not_negative, "finite and at least 0")?;
        column("opacities", &self.opacities, count, unit, "from 0 to 1")?;
        for (name, values) in &self.scalars {
            check_length(name, values.len(), count)?;
        }
        one("color", self.color.iter().flatten(), unit, "numbers from 0 to 1")?;
        one("opacity", self.opacity.iter(), unit, "a number from 0 to 1")?;
        one("radius", self.radius.iter(), not_negative, "a finite number of at least 0")?;
        let direction = |n: [f32; 3]| DVec3::from(Vec3::from_array(n)).normalize_or_zero().as_vec3();
        let columns = Columns {
            positions: bytemuck::allocation::cast_vec(self.positions),
            colors: self.colors.map(bytemuck::allocation::cast_vec),
            normals: self.normals.map(|normals| normals.into_iter().map(direction).collect()),
            radii: self.radii,
            alphas: self.opacities,
            scalars: self.scalars,
            up: if self.z_up { UpAxis::Z } else { UpAxis::Y },
            ..Columns::default()
        };
        let Self { opacity, radius, color, .. } = self;
        Ok(Cloud { columns: Arc::new(columns), opacity, radius, color })
    }
}

/// Refuses a column of another length, or the first value that is not as expected.
fn column<T>(
    name: &str,
    values: &Option<Vec<T>>,
    count: usize,
    is_fine: impl Fn(&T) -> bool,
    expected: &str,
) -> Result<()> {
    let Some(values) = values else { return Ok(()) };
    check_length(name, values.len(), count)?;
    check(name, values.iter().map(is_fine), expected, 1)
}

fn check_length(name: &str, found: usize, expected: usize) -> Result<()> {
    if found == expected {
        return Ok(());
    }
    Err(Error::argument(format!("{name}: expected one for each of {expected} points, found {found}")))
}

/// Refuses the first value that is not as expected; `width` values belong to a point.
fn check(name: &str, fine: impl Iterator<Item = bool>, expected: &str, width: usize) -> Result<()> {
    match fine.enumerate().find(|(_, fine)| !fine) {
        Some((i, _)) => Err(Error::argument(format!("{name}: the value of point {} is not {expected}", i / width))),
        None => Ok(()),
    }
}

/// Refuses a value for all points that is not as expected.
fn one<'a>(
    name: &str,
    mut values: impl Iterator<Item = &'a f32>,
    is_fine: impl Fn(&f32) -> bool,
    expected: &str,
) -> Result<()> {
    match values.find(|value| !is_fine(value)) {
        Some(value) => Err(Error::argument(format!("{name}: expected {expected}, found {value}"))),
        None => Ok(()),
    }
}
