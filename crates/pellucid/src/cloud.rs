//! Points from arrays or from a file.

use std::path::Path;

use glam::{DVec3, Vec3};
use pellucid_engine::cloud::{Cloud as Columns, UpAxis};
use pellucid_engine::io;
use pellucid_engine::progress::Progress;

use crate::{Error, Result};

/// A point cloud: float64 positions and optional columns, each as long as the positions.
#[derive(Debug, Clone)]
pub struct Cloud {
    pub(crate) columns: Columns,
    pub(crate) opacity: Option<f32>,
}

impl Cloud {
    /// Points at world positions.
    ///
    /// # Errors
    /// A coordinate that is not finite.
    pub fn from_positions(positions: &[[f64; 3]]) -> Result<Self> {
        check("positions", positions.iter().flatten().map(|x| x.is_finite()), "a finite number", 3)?;
        let positions = positions.iter().map(|p| DVec3::from_array(*p)).collect();
        Ok(Self { columns: Columns { positions, ..Columns::default() }, opacity: None })
    }

    /// Reads a file: PLY, LAS, LAZ, COPC, E57, PCD, PTS, PTX, or a table of numbers (XYZ, CSV, TXT).
    ///
    /// # Errors
    /// A missing or damaged file, or one without points.
    pub fn read(path: impl AsRef<Path>) -> Result<Self> {
        Ok(Self { columns: io::load(path.as_ref(), &Progress::hidden())?, opacity: None })
    }

    /// Gives each point a color: linear R, G, B from 0 to 1.
    ///
    /// # Errors
    /// Another number of colors than points, or a value out of range.
    pub fn with_colors(mut self, colors: &[[f32; 3]]) -> Result<Self> {
        self.check_length("colors", colors.len())?;
        check("colors", colors.iter().flatten().map(|c| (0.0..=1.0).contains(c)), "from 0 to 1", 3)?;
        self.columns.colors = Some(colors.iter().map(|c| Vec3::from_array(*c)).collect());
        Ok(self)
    }

    /// Gives each point a normal, of any length; a zero vector means no normal.
    ///
    /// # Errors
    /// The number of normals differs from the number of points, or a number is not finite.
    pub fn with_normals(mut self, normals: &[[f32; 3]]) -> Result<Self> {
        self.check_length("normals", normals.len())?;
        check("normals", normals.iter().flatten().map(|n| n.is_finite()), "a finite number", 3)?;
        let unit = |n: &[f32; 3]| DVec3::from(Vec3::from_array(*n)).normalize_or_zero().as_vec3();
        self.columns.normals = Some(normals.iter().map(unit).collect());
        Ok(self)
    }

    /// Gives each point a radius in world units, at least 0. Without radii they are estimated from each point's neighbors.
    ///
    /// # Errors
    /// Another number of radii than points, or one below 0 or not finite.
    pub fn with_radii(mut self, radii: &[f32]) -> Result<Self> {
        self.check_length("radii", radii.len())?;
        check("radii", radii.iter().map(|r| *r >= 0.0 && r.is_finite()), "finite and at least 0", 1)?;
        self.columns.radii = Some(radii.to_vec());
        Ok(self)
    }

    /// Gives each point an opacity from 0 to 1, which that of the whole cloud multiplies.
    ///
    /// # Errors
    /// Another number of opacities than points, or one out of range.
    pub fn with_opacities(mut self, opacities: &[f32]) -> Result<Self> {
        self.check_length("opacities", opacities.len())?;
        check("opacities", opacities.iter().map(|a| (0.0..=1.0).contains(a)), "from 0 to 1", 1)?;
        self.columns.alphas = Some(opacities.to_vec());
        Ok(self)
    }

    /// Gives each point a scalar that `cloud.field` can name.
    ///
    /// # Errors
    /// Another number of values than points.
    pub fn with_scalar(mut self, name: &str, values: &[f32]) -> Result<Self> {
        self.check_length(name, values.len())?;
        self.columns.scalars.retain(|(known, _)| known != name);
        self.columns.scalars.push((name.to_owned(), values.to_vec()));
        Ok(self)
    }

    /// Sets the opacity of the whole cloud, from 0 to 1; the default is 1.
    ///
    /// # Errors
    /// An opacity out of range.
    pub fn with_opacity(mut self, opacity: f32) -> Result<Self> {
        if !(0.0..=1.0).contains(&opacity) {
            return Err(Error::argument(format!("opacity: expected a number from 0 to 1, found {opacity}")));
        }
        self.opacity = Some(opacity);
        Ok(self)
    }

    /// Says that +Z points up, as in surveys, instead of +Y: the automatic camera asks.
    #[must_use]
    pub fn z_up(mut self) -> Self {
        self.columns.up = UpAxis::Z;
        self
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.columns.len()
    }

    /// True without points.
    pub fn is_empty(&self) -> bool {
        self.columns.is_empty()
    }

    /// Smallest and largest corner of the points; `None` without points.
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
