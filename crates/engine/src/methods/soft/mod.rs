//! Soft transparency (Seemann et al. 2018): shared by its models.

mod engine;
mod explain;
pub mod express;
mod spheres;

pub(crate) use engine::{ExpressEngine, Solids, SpheresEngine};
pub(crate) use explain::{disc_group, sphere_group};
pub(super) use spheres::record_carry;
pub use spheres::*;

use crate::gpu::shader::Shader;
use crate::scene::{Density, Method, Soft};

/// Model of the density of spheres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SoftModel {
    /// λ of Eq. 1, 14 or 19: per squared world unit (`soft-base`), per world unit (`soft-concentric`), or an opacity
    /// (`soft-express`).
    pub lambda: f32,
    /// Opacity of a whole chord through the center of a sphere of median radius, in [0, 1].
    pub peak: f32,
    /// `true` if the density of a shell falls with the ray's distance from the center: μ′ of Eq. 15 in place of μ.
    pub equalize: bool,
}

/// Optical depth through which nothing is seen, however little of it there is: for a peak opacity of 1.
const OPAQUE: f64 = 1e20;
/// Optical depth of a sphere from which on float32 shows: where a ray passes so near to the rim that a sphere of
/// optical depth D is neither opaque nor clear, 1 − d/r is about D^(−2/3), of which float32 leaves 2·10⁻⁷. At this D
/// that makes an error of 10⁻⁵ in the opacity; it grows as D^(2/3).
const STIFF: f64 = 1e3;
/// Optical depth from which on float32 shows in shells with one density for all rays, whose opacity rises from the rim
/// as a root. The middle between opaque and clear is where 1 − d/r is 1/(2 D²), and this D makes an error of 10⁻⁵
/// there. It grows as D².
const STIFF_SHELLS: f64 = 10.0;

impl SoftModel {
    /// Makes the model of a method's settings; `median_radius` in world units.
    pub fn new(method: &Method, soft: &Soft, median_radius: f32) -> Self {
        let radius = f64::from(median_radius);
        // Optical depth of the central chord over λ.
        let chord = match method {
            Method::SoftBase(_) => radius * radius,
            _ => 2.0 * radius,
        };
        let (express, equalize) = (matches!(method, Method::SoftExpress(_)), soft.equalize);
        match soft.density {
            Density::Softness(peak) | Density::Lambda(peak) if express => {
                let peak = peak.min(1.0);
                Self { lambda: peak, peak, equalize }
            }
            Density::Softness(peak) => {
                let depth = (-(-f64::from(peak)).ln_1p()).min(OPAQUE);
                let lambda = if chord > 0.0 { (depth / chord) as f32 } else { 0.0 };
                Self { lambda: lambda.min(f32::MAX), peak, equalize }
            }
            Density::Lambda(lambda) => Self { lambda, peak: -(-f64::from(lambda) * chord).exp_m1() as f32, equalize },
        }
    }

    /// Returns `true` if spheres of up to this radius (world units) are so dense that their places take more than
    /// float32.
    pub fn is_stiff(&self, interior: Interior, max_radius: f32) -> bool {
        let radius = f64::from(max_radius);
        let (chord, stiff) = match interior.is_integrated() {
            true => (radius * radius, STIFF),
            false => (2.0 * radius, if self.equalize { STIFF } else { STIFF_SHELLS }),
        };
        // The paper's layout rounds more than that.
        interior != Interior::Packed && f64::from(self.lambda) * chord > stiff
    }
}

/// Returns the passes with their variants.
pub fn shaders() -> Vec<Shader> {
    let mut all = spheres::shaders();
    all.extend(express::shaders());
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_peak_opacity_and_its_factor_belong_together() {
        let soft = |density| Soft { density, ..Soft::default() };
        for radius in [1e-3f32, 0.5, 1e3] {
            for (method, chord) in
                [(Method::SoftBase as fn(Soft) -> Method, radius * radius), (Method::SoftConcentric, 2.0 * radius)]
            {
                let of = |settings| SoftModel::new(&method(settings), &settings, radius);
                let model = of(soft(Density::Softness(0.75)));
                assert!((model.lambda * chord - 4f32.ln()).abs() < 1e-6 * 4.0, "{model:?}");
                let back = of(soft(Density::Lambda(model.lambda)));
                assert!((back.peak - 0.75).abs() < 1e-6 && back.lambda == model.lambda, "{back:?}");
                let opaque = of(soft(Density::Softness(1.0)));
                assert!(opaque.lambda.is_finite() && (-opaque.lambda * chord).exp() == 0.0, "{opaque:?}");
            }
        }
        let express = soft(Density::Lambda(3.0));
        let model = SoftModel::new(&Method::SoftExpress(express), &express, 2.0);
        assert_eq!(model, SoftModel { lambda: 1.0, peak: 1.0, equalize: true });
    }
}
