//! Vertices that are Gaussian splats as radiance fields are stored (Kerbl et al. 2023), made into discs.
//!
//! Stored are the degree-0 coefficients of the color in spherical harmonics (`f_dc_0..2`), the logit of the opacity
//! (`opacity`), the logarithms of the standard deviations along three axes (`scale_0..2`) and those axes (`rot_0..3`). A
//! disc has the color that all directions have in common, the same opacity, and twice the geometric mean of the standard
//! deviations as radius: with `falloff = "gaussian"`, which is exp(−2ρ²), that is an isotropic splat's own profile.

use crate::io::columns::{Column, ScalarType};

/// The degree-0 spherical harmonic, 1 / (2√π).
const HARMONIC: f64 = 0.282_094_791_773_878_14;

/// Radius over standard deviation: opacity·exp(−2ρ²) at ρ = d/radius is opacity·exp(−d²/2σ²).
const RADIUS: f64 = 2.0;

/// The warning about such a file.
pub(super) const NOTE: &str = "Gaussian splats, read as round discs: how their color varies with the view (f_rest) and \
                               their stretch (scale, rot) are left out; method.falloff=gaussian has their profile";

/// The positions of a splat's properties in a row.
pub(super) struct Splats {
    color: [usize; 3],
    opacity: usize,
    scale: [usize; 3],
    /// Properties that stay as they are.
    kept: Vec<usize>,
    columns: Vec<Column>,
}

impl Splats {
    /// Finds splats; `None` if the properties are those of something else.
    pub fn find(properties: &[Column]) -> Option<Self> {
        let find = |name: &str| properties.iter().position(|p| p.name.eq_ignore_ascii_case(name));
        let three =
            |stem: &str| Some([find(&format!("{stem}0"))?, find(&format!("{stem}1"))?, find(&format!("{stem}2"))?]);
        let (color, opacity, scale) = (three("f_dc_")?, find("opacity")?, three("scale_")?);
        three("rot_").and(find("rot_3"))?;
        let used = |name: &str| {
            let name = name.to_ascii_lowercase();
            let made = ["red", "green", "blue", "alpha", "radius", "opacity"].contains(&name.as_str());
            made || ["f_dc_", "f_rest_", "scale_", "rot_"].iter().any(|stem| name.starts_with(stem))
        };
        let kept: Vec<usize> = (0..properties.len()).filter(|&at| !used(&properties[at].name)).collect();
        let made = ["red", "green", "blue", "alpha", "radius"].map(|name| Column::new(name, ScalarType::Float));
        let stay = kept.iter().map(|&at| Column::new(&properties[at].name, properties[at].kind.clone()));
        let columns = made.into_iter().chain(stay).collect();
        Some(Self { color, opacity, scale, kept, columns })
    }

    /// The columns of a converted row.
    pub fn columns(&self) -> &Vec<Column> {
        &self.columns
    }

    /// Makes a row of [`Splats::columns`] of a vertex: the color as encoded sRGB, which is what splats are trained on.
    pub fn convert<'a>(&self, vertex: &[f64], row: &'a mut Vec<f64>) -> &'a [f64] {
        row.clear();
        row.extend(self.color.map(|at| (0.5 + HARMONIC * vertex[at]).clamp(0.0, 1.0)));
        row.push(1.0 / (1.0 + (-vertex[self.opacity]).exp()));
        let logarithms: f64 = self.scale.iter().map(|&at| vertex[at]).sum();
        row.push(RADIUS * (logarithms / 3.0).exp());
        row.extend(self.kept.iter().map(|&at| vertex[at]));
        row
    }
}
