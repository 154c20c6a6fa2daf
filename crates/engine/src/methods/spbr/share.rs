//! The number of points of each cloud to deal, and the size of a point.
//!
//! Tanaka et al. 2016, Eq. 1, without its bias where a cross-section has few pixels: an ensemble needs −ln(1 − α)
//! points on the area of a pixel for opacity α, if they lie at random.

use crate::methods::prelude::*;
use crate::passes::project::Placed;
use crate::prepare::ensembles::Deal;

impl Placed {
    /// Depth at which a point is one pixel wide: that of the middle of the box, or, where the camera's plane cuts the
    /// box, of the middle of the part in front of it. With enough points any depth gives the same opacity. But behind
    /// the camera a pixel has no positive width, and too close to it more points are needed than exist.
    fn depth(&self, camera: &Camera) -> f64 {
        let deepest = self.depths(camera).fold(f64::NEG_INFINITY, f64::max);
        camera.to_view(self.surface.center).z.max(0.5 * deepest).max(camera.near)
    }

    fn depths(&self, camera: &Camera) -> impl Iterator<Item = f64> {
        self.corners.iter().map(|corner| camera.to_view(*corner).z)
    }
}

/// The share of a cloud in a frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Share {
    /// Range of the cloud's points in the list.
    pub points: Range<u64>,
    /// Slots dealt to all ensembles together: M.
    pub slots: u64,
    /// Depth at which a point of its own opacity is one pixel wide.
    pub depth: f64,
    /// −ln(1 − α) of the opacity α for which a point covers the whole of such a pixel; 0 without an area.
    pub unit: f64,
    /// `true` if all of its points have the opacity of their surface.
    pub uniform: bool,
    /// `true` if more than L copies of each point were needed, so that opacity is lost.
    pub capped: bool,
    /// Opacity of its surface in the image, of that which was asked for.
    pub opacity: f64,
    /// Most pixels that one of its points may cover.
    pub largest: f64,
}

/// A frame's settings for all clouds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wanted<'a> {
    /// The camera.
    pub camera: &'a Camera,
    /// Rows of the image.
    pub height: u32,
    /// `spbr` or `spbr-simplified`, with L.
    pub method: Method,
    /// Factor on opacities; the product is at most 1.
    pub opacity_factor: f64,
}

impl Share {
    /// Returns the share of so many images together, each of which has as many ensembles.
    pub fn times(self, images: u32) -> Self {
        Self { slots: self.slots * u64::from(images), ..self }
    }

    /// Returns the dealing of its points to this many ensembles; `place` is the cloud's among the others.
    pub fn deal(&self, ensembles: u32, place: u32, seed: u64) -> Deal {
        Deal { points: self.points.end - self.points.start, slots: self.slots, ensembles, place, seed }
    }
}

impl Wanted<'_> {
    /// Returns the points on a pixel's area at a depth, all of them.
    pub(super) fn per_pixel(&self, placed: &Placed, depth: f64) -> f64 {
        let pixel = self.camera.pixels_per_unit(depth, self.height).recip();
        placed.surface.density * pixel * pixel
    }

    /// Returns the opacity that is asked for a cloud's surface.
    pub(super) fn opacity(&self, placed: &Placed) -> f64 {
        (f64::from(placed.surface.opacity) * self.opacity_factor).min(1.0)
    }

    /// Returns the share of a cloud.
    pub fn share(&self, placed: &Placed) -> Share {
        let surface = &placed.surface;
        let ensembles = f64::from(self.method.ensembles().unwrap_or(1));
        let count = surface.points.end - surface.points.start;
        let depth = placed.depth(self.camera);
        let (there, alpha) = (self.per_pixel(placed, depth), self.opacity(placed));
        let needed = -(-alpha).ln_1p();
        let simplified = matches!(self.method, Method::SpbrSimplified(_));
        let ratio = match needed {
            _ if simplified => 1.0,
            0.0 => 0.0,
            _ => (ensembles * needed / there).min(ensembles),
        };
        let capped = !simplified && needed > there;
        let unit = if capped { there } else { needed };
        let nearest = placed.depths(self.camera).fold(f64::INFINITY, f64::min).max(self.camera.near);
        let largest = match self.camera.projection {
            Projection::Perspective { .. } => (depth / nearest).powi(2),
            Projection::Orthographic { .. } => 1.0,
        };
        Share {
            points: surface.points.clone(),
            slots: (ratio * count as f64).round() as u64,
            depth,
            unit,
            uniform: placed.uniform,
            capped,
            opacity: if capped { -(-there).exp_m1() } else { alpha },
            largest,
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::prepare::ensembles::CloudSurface;
    use crate::scene::{Spbr, SpbrSimplified};

    /// A cloud of 1000 points in a cube of side 2, 10 on each unit of area, before a camera at `z`.
    fn share(z: f64, opacity: f32, height: u32) -> Share {
        let corners = std::array::from_fn(|i| {
            DVec3::from_array([0, 1, 2].map(|axis| f64::from(i as u32 >> axis & 1) * 2.0 - 1.0))
        });
        let surface = CloudSurface { points: 0..1000, center: DVec3::ZERO, density: 10.0, opacity };
        let projection = Projection::Perspective { fov_y: 1.0 };
        let camera = Camera::look_at(DVec3::Z * z, DVec3::Z * (z - 1.0), DVec3::Y, projection, 0.1, 100.0);
        let camera = &camera.expect("a valid camera");
        let method = Method::Spbr(Spbr { ensembles: 8, ..Spbr::default() });
        let placed = Placed { surface, corners, uniform: true };
        Wanted { camera, height, method, opacity_factor: 1.0 }.share(&placed)
    }

    #[test]
    fn a_point_is_one_pixel_wide_in_the_middle_of_what_lies_before_the_camera() {
        for (z, depth) in [(5.0, 5.0), (1.0, 1.0), (0.5, 0.75), (0.0, 0.5), (-0.5, 0.25), (-3.0, 0.1)] {
            assert!((share(z, 0.5, 10).depth - depth).abs() < 1e-12, "{z}");
        }
        assert!((share(5.0, 0.5, 10).largest - (5.0f64 / 4.0).powi(2)).abs() < 1e-12);
    }

    /// Figures of Tanaka et al. 2016, Table 1, for points on a plane of known density: k = nL / n_raw.
    #[test]
    fn a_plane_of_known_density_is_adjusted_by_n_l_over_n_raw() {
        // A pixel of 0.1 × 0.1 world units has 10 · 0.01 = 0.1 points.
        let lens = Projection::Orthographic { height: 1.0 };
        let camera = Camera::look_at(DVec3::Z * 5.0, DVec3::ZERO, DVec3::Y, lens, 0.1, 100.0).expect("a valid camera");
        let surface = CloudSurface { points: 7..1007, center: DVec3::ZERO, density: 10.0, opacity: 0.05 };
        let flat = Placed { surface, corners: [DVec3::ZERO; 8], uniform: true };
        let of = |method, opacity_factor, placed: &Placed| {
            Wanted { camera: &camera, height: 10, method, opacity_factor }.adjustment(placed)
        };
        let spbr = Method::Spbr(Spbr { ensembles: 100, ..Spbr::default() });
        let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-6 * b, "{a} for {b}");
        // n = −ln 0.95 = 0.0512933, so k = 51.2933.
        let asked = of(spbr, 1.0, &flat);
        close(asked.per_pixel.unwrap(), 0.1);
        assert_eq!((asked.points, asked.adjusted), (1000, 51_293));
        close(asked.ratio(), 51.293);
        close(asked.opacity.unwrap(), 0.05);
        // Twice the opacity: 0.1053605 of the points that a pixel has, where 0.1 are there. All are used in all
        // ensembles, and the surface has 1 − e^(−0.1).
        let lost = of(spbr, 2.0, &flat);
        assert_eq!(lost.adjusted, 100_000);
        close(lost.asked.unwrap(), 0.1);
        close(lost.opacity.unwrap(), 0.095_162_58);
        // Dealt once to 4 ensembles, a pixel of each has 0.025 points: 1 − e^(−0.025).
        let simplified = Method::SpbrSimplified(SpbrSimplified { ensembles: 4, ..SpbrSimplified::default() });
        let follows = of(simplified, 1.0, &flat);
        assert_eq!((follows.adjusted, follows.asked), (1000, None));
        close(follows.opacity.unwrap(), 0.024_690_09);
        // Too few points to know a density are drawn in each ensemble.
        let alone = CloudSurface { points: 0..1, density: 0.0, ..flat.surface.clone() };
        let unknown = of(spbr, 1.0, &Placed { surface: alone, ..flat });
        assert_eq!((unknown.per_pixel, unknown.opacity, unknown.adjusted), (None, None, 100));
    }

    #[test]
    fn as_many_slots_as_the_opacity_asks_for_and_no_more_than_there_are() {
        // Points on a pixel: 10 (depth / focal)^2.
        let there = 10.0 * (5.0 * 2.0 * 0.5f64.tan() / 10.0).powi(2);
        let half = share(5.0, 0.5, 10);
        assert_eq!(half.slots, (8.0 * std::f64::consts::LN_2 / there * 1000.0).round() as u64);
        assert!(!half.capped && half.opacity == 0.5);
        // Smaller pixels: not enough of them.
        let thin = share(5.0, 0.9, 40);
        assert!(thin.capped && thin.slots == 8000);
        assert!(
            (thin.opacity - (1.0 - (-there / 16.0).exp())).abs() < 1e-12 && (thin.unit - there / 16.0).abs() < 1e-12
        );
        assert_eq!(share(5.0, 1.0, 10).slots, 8000);
        assert_eq!(share(5.0, 0.0, 10).slots, 0);
    }
}
