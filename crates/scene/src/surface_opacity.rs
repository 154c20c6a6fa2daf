//! Opacities of discs such that the surface they lie on has a given one: `surface_opacity`.

use super::settings::CloudSettings;

/// The opacities of a cloud's points, where no class has one of its own.
#[derive(Clone, Copy)]
pub(super) struct Opacity<'a> {
    pub settings: &'a CloudSettings,
    /// Radii of Eq. 20 without its cap, in the file's units, if the method draws discs and a surface has an opacity.
    pub estimated: Option<&'a [f32]>,
    /// K.
    pub neighbors: usize,
}

impl Opacity<'_> {
    /// Returns the opacity of a point with a radius in world units.
    pub fn of(&self, i: usize, radius: f32) -> f32 {
        let Some(surface) = self.settings.surface_opacity else { return self.settings.opacity };
        let Some(estimated) = self.estimated else { return surface };
        of_disc(surface, f64::from(radius), f64::from(estimated[i]) * self.settings.scale, self.neighbors)
    }
}

/// Eq. 20's radius is so many times the one at which discs cover their surface once: K points within the distance d of
/// one have a density of K / (π d²), and discs of radius r = 2d/√K have n = π r² K / (π d²) = 4.
const OVERLAP: f64 = 4.0;

/// α of a disc such that n of them, as many as cover each place of the surface, hide the share `surface`:
/// 1 − (1 − A)^(1/n), n = K r²/d², at least 1.
///
/// `radius` is the disc's, `estimated` that of Eq. 20 without its cap, in the same units; it is 0 where the K neighbors
/// are in the point's own place, so that K + 1 discs lie over each other.
fn of_disc(surface: f32, radius: f64, estimated: f64, neighbors: usize) -> f32 {
    let ratio = radius / estimated;
    let n = if estimated > 0.0 { (OVERLAP * ratio * ratio).max(1.0) } else { neighbors as f64 + 1.0 };
    // 1 - exp(ln(1 - A) / n), which keeps the digits of small ones.
    -((-f64::from(surface)).ln_1p() / n).exp_m1() as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn as_many_discs_as_overlap_hide_what_the_surface_does() {
        for surface in [0.0, 1e-6, 0.3, 0.75, 0.999, 1.0] {
            for (radius, estimated, n) in
                [(1.0, 1.0, 4.0), (2.0, 1.0, 16.0), (1.0, 1000.0, 1.0), (0.0, 2.0, 1.0), (0.5, 0.0, 25.0)]
            {
                let alpha = f64::from(of_disc(surface, radius, estimated, 24));
                let covered = 1.0 - (1.0 - alpha).powf(n);
                assert!((covered - f64::from(surface)).abs() < 1e-6, "{surface}, {radius}: {alpha} {covered}");
            }
        }
    }
}
