//! Points from arrays or from a file.

use std::path::Path;

use glam::{DVec3, Vec3};
use pellucid_engine::cloud::{Cloud as Columns, UpAxis};
use pellucid_engine::io;
use pellucid_engine::progress::Progress;

use crate::{Error, Result};

/// Point cloud: float64 positions and optional columns, each as long as the positions.
#[derive(Debug, Clone)]
pub struct Cloud {
    pub(crate) columns: Columns,
    pub(crate) opacity: Option<f32>,
}

impl Cloud {
    /// Creates a cloud from positions in world units.
    ///
    /// # Errors
    /// Returns an error if a coordinate is not finite.
    pub fn from_positions(positions: &[[f64; 3]]) -> Result<Self> {
        check("positions", positions.iter().flatten().map(|x| x.is_finite()), "a finite number", 3)?;
        let positions = positions.iter().map(|p| DVec3::from_array(*p)).collect();
        Ok(Self { columns: Columns { positions, ..Columns::default() }, opacity: None })
    }

    /// Reads a file: PLY, LAS, LAZ, COPC, E57, PCD, PTS, PTX, or a table of numbers (XYZ, CSV, TXT).
    ///
    /// # Errors
    /// Returns an error if the file is missing, damaged, or without points.
    pub fn read(path: impl AsRef<Path>) -> Result<Self> {
        Ok(Self { columns: io::load(path.as_ref(), &Progress::hidden())?, opacity: None })
    }

    /// Sets the color of each point: linear R, G, B from 0 to 1.
    ///
    /// # Errors
    /// Returns an error if the number of colors differs from the number of points, or a value is out of range.
    pub fn with_colors(mut self, colors: &[[f32; 3]]) -> Result<Self> {
        self.check_length("colors", colors.len())?;
        check("colors", colors.iter().flatten().map(|c| (0.0..=1.0).contains(c)), "from 0 to 1", 3)?;
        self.columns.colors = Some(colors.iter().map(|c| Vec3::from_array(*c)).collect());
        Ok(self)
    }

    /// Sets the normal of each point, of any length. A zero vector means that the point has no normal.
    ///
    /// # Errors
    /// Returns an error if the number of normals differs from the number of points, or a number is not finite.
    pub fn with_normals(mut self, normals: &[[f32; 3]]) -> Result<Self> {
        self.check_length("normals", normals.len())?;
        check("normals", normals.iter().flatten().map(|n| n.is_finite()), "a finite number", 3)?;
        let unit = |n: &[f32; 3]| DVec3::from(Vec3::from_array(*n)).normalize_or_zero().as_vec3();
        self.columns.normals = Some(normals.iter().map(unit).collect());
        Ok(self)
    }

    /// Sets the radius of each point in world units, at least 0. Without radii, they are estimated from the neighbors
    /// of each point.
    ///
    /// # Errors
    /// Returns an error if the number of radii differs from the number of points, or a radius is below 0 or not finite.
    pub fn with_radii(mut self, radii: &[f32]) -> Result<Self> {
        self.check_length("radii", radii.len())?;
        check("radii", radii.iter().map(|r| *r >= 0.0 && r.is_finite()), "finite and at least 0", 1)?;
        self.columns.radii = Some(radii.to_vec());
        Ok(self)
    }

    /// Sets the opacity of each point, from 0 to 1. The opacity of the whole cloud multiplies it.
    ///
    /// # Errors
    /// Returns an error if the number of opacities differs from the number of points, or one is out of range.
    pub fn with_opacities(mut self, opacities: &[f32]) -> Result<Self> {
        self.check_length("opacities", opacities.len())?;
        check("opacities", opacities.iter().map(|a| (0.0..=1.0).contains(a)), "from 0 to 1", 1)?;
        self.columns.alphas = Some(opacities.to_vec());
        Ok(self)
    }

    /// Adds a scalar of each point, which the setting `cloud.field` can name.
    ///
    /// # Errors
    /// Returns an error if the number of values differs from the number of points.
    pub fn with_scalar(mut self, name: &str, values: &[f32]) -> Result<Self> {
        self.check_length(name, values.len())?;
        self.columns.scalars.retain(|(known, _)| known != name);
        self.columns.scalars.push((name.to_owned(), values.to_vec()));
        Ok(self)
    }

    /// Sets the opacity of the whole cloud, from 0 to 1, 1 by default.
    ///
    /// # Errors
    /// Returns an error if the opacity is out of range.
    pub fn with_opacity(mut self, opacity: f32) -> Result<Self> {
        if !(0.0..=1.0).contains(&opacity) {
            return Err(Error::argument(format!("opacity: expected a number from 0 to 1, found {opacity}")));
        }
        self.opacity = Some(opacity);
        Ok(self)
    }

    /// Makes +Z point up, as in surveys, instead of +Y. The automatic camera depends on it.
    #[must_use]
    pub fn z_up(mut self) -> Self {
        self.columns.up = UpAxis::Z;
        self
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

    fn check_length(&self, name: &str, found: usize) -> Result<()> {
        let expected = self.len();
        if found == expected {
            return Ok(());
        }
        Err(Error::argument(format!("{name}: expected one for each of {expected} points, found {found}")))
    }
}

/// Refuses the first value that is not as expected; `width` values belong to a point.
fn check(name: &str, fine: impl Iterator<Item = bool>, expected: &str, width: usize) -> Result<()> {
    match fine.enumerate().find(|(_, fine)| !fine) {
        Some((i, _)) => Err(Error::argument(format!("{name}: the value of point {} is not {expected}", i / width))),
        None => Ok(()),
    }
}
