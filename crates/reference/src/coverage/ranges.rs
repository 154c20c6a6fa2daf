//! Coverage where roundings of float32 decide, at which depth, and how far from the center.
//!
//! Errors are counted in roundings ([`ROUNDING`]), as the shaders compute: pixel by pixel from the projected center,
//! which is known as a whole pixel and a rounded fraction of one.

use glam::{DVec2, DVec3};

use super::super::range::{ROUNDING, Range, screen_error};
use super::{Outline, PlacedSplat, Splat, relative};
use crate::View;
use pellucid_core::camera::Projection;

/// A pixel that a splat may cover.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Possible {
    /// Column, from the left.
    pub x: u32,
    /// Row, from the top.
    pub y: u32,
    /// Depth along the viewing axis.
    pub z: Range,
    /// Distance from the center over the radius.
    pub rho: Range,
    /// False if roundings decide that the pixel is covered.
    pub sure: bool,
}

/// Returns the pixels of some rows that a splat may cover ([`super::footprint`]). Near and far have to be clear of its
/// depth.
pub fn possible(view: View, splat: &Splat, rows: std::ops::Range<u32>) -> Vec<Possible> {
    match PlacedSplat::new(view, splat) {
        Some(placed) if placed.is_within_depth_range() => {
            placed.window_in(rows).filter_map(|p| placed.possible(p)).collect()
        }
        _ => Vec::new(),
    }
}

/// Meeting of a pixel's center with an outline.
struct Met {
    z: Range,
    rho: Range,
    /// Coverage within the rim: for sure; and perhaps.
    inside: [bool; 2],
}

impl PlacedSplat<'_> {
    fn possible(&self, [x, y]: [u32; 2]) -> Option<Possible> {
        let pixel = DVec2::new(f64::from(x), f64::from(y));
        let home = self.may_be_home(pixel);
        let center = (Range::depth(self.position_view.z), Range::only(1.0));
        let hit = self.met(pixel + 0.5).filter(|met| met.inside[1]);
        let (z, rho, sure) = match hit {
            Some(met) if met.inside[0] => (met.z, met.rho, true),
            Some(met) if home[1] => (met.z.hull(center.0), met.rho.hull(center.1), home[0]),
            Some(met) => (met.z, met.rho, false),
            None if home[1] => (center.0, center.1, home[0]),
            None => return None,
        };
        // A square's corners are farther than its sides.
        let most = if matches!(self.outline, Outline::Square { .. }) { f64::INFINITY } else { 1.0 };
        let rho = Range { low: rho.low.max(0.0), high: rho.high.min(most) };
        Some(Possible { x, y, z, rho, sure })
    }

    /// Tells if a pixel contains the projected center: for sure, and perhaps.
    fn may_be_home(&self, pixel: DVec2) -> [bool; 2] {
        let inside = |axis: usize, sign: f64| {
            let error = sign * screen_error(self.center_px[axis], self.view.size[axis]);
            let offset = self.center_px[axis] - pixel[axis];
            offset >= error && offset < 1.0 - error
        };
        [1.0, -1.0].map(|sign| inside(0, sign) && inside(1, sign))
    }

    fn met(&self, at_px: DVec2) -> Option<Met> {
        let offset = at_px - self.center_px;
        let z = Range::depth(self.position_view.z);
        match self.outline {
            Outline::Pixel => None,
            Outline::Disc { radius_px } => Some(flat(z, offset.length(), offset.length(), radius_px)),
            Outline::Square { radius_px } => Some(flat(z, offset.abs().max_element(), offset.length(), radius_px)),
            Outline::Tangent { radius, normal_view } => Some(self.tangent_met(at_px, radius, normal_view)),
        }
    }

    /// The ray o + d t in pixels at the center's depth and relative to the center, where the plane n·(o − d t) = 0 is
    /// met.
    fn tangent_met(&self, at_px: DVec2, radius: f64, normal: DVec3) -> Met {
        let (u, z) = (ROUNDING, self.position_view.z);
        let scale = self.view.pixels_per_unit(z);
        let offset = at_px - self.center_px;
        let o = DVec3::new(offset.x, -offset.y, 0.0);
        let focal = self.view.camera.focal_px(self.view.size[1]);
        let slope = self.view.on_plane(at_px);
        let (ray, facing) = match self.view.camera.projection {
            Projection::Perspective { .. } => (slope.extend(1.0), normal.dot(self.position_view) / z),
            Projection::Orthographic { .. } => (DVec3::Z, normal.z),
        };
        let perspective = matches!(self.view.camera.projection, Projection::Perspective { .. });
        // o: half a rounding for the fraction, one for the sum.
        let (reach, o_error) = (o.length(), u * (1.0 + o.length()));
        let along = normal.dot(o);
        // The normal has two roundings in each component; two products, one sum.
        let along_error = 1.5 * o_error + 5.0 * u * reach;
        let towards = if perspective { facing + along / focal } else { facing };
        let mut towards_error = 3.0 * u * facing.abs() + u * towards.abs();
        if perspective {
            towards_error += (along_error + 2.0 * u * along.abs()) / focal;
        }
        let least = towards.abs() - towards_error;
        let anywhere = Met {
            z: Range { low: f64::NEG_INFINITY, high: f64::INFINITY },
            rho: Range { low: 0.0, high: 1.0 },
            inside: [false, true],
        };
        // Edge-on, as far as roundings can tell.
        if least <= 0.0 {
            return anywhere;
        }
        let t = along / towards;
        let t_error = (along_error + t.abs() * towards_error) / least + u * t.abs();
        let distance = (o - t * ray).length();
        let error = 1.5 * o_error + ray.length() * (t_error + 3.0 * u * t.abs()) + 4.0 * u * distance;
        let hit = z - t / scale;
        let hit_error = 2.0 * u * z.abs() + (t_error + 5.0 * u * t.abs()) / scale + u * hit.abs();
        let mut met = inside(Range::around(hit, hit_error), distance, error, radius * scale);
        met.rho = met.rho.hull(Range::only(relative(distance / scale, radius).min(1.0)));
        // A ray starts at the eye.
        if perspective {
            met.inside[0] &= hit - hit_error > 0.0;
            met.inside[1] &= hit + hit_error > 0.0;
        }
        met
    }
}

/// A flat outline: `distance` decides, `from_center` is what ρ comes from. Half a rounding for the fraction of a pixel
/// and one for the sum in each coordinate, two for squares and their sum, one for the root.
fn flat(z: Range, distance: f64, from_center: f64, radius: f64) -> Met {
    let error = ROUNDING * (1.5 + 4.0 * from_center);
    let met = inside(z, distance, error, radius);
    Met { rho: inside(z, from_center, error, radius).rho, ..met }
}

/// Five roundings for a radius in pixels: its factor, the scale, the clamp, their product, and its square.
fn inside(z: Range, distance: f64, error: f64, radius: f64) -> Met {
    let error = error + 5.0 * ROUNDING * radius;
    let distance = Range::around(distance, error);
    let rho = match radius {
        0.0 => Range::only(1.0),
        _ => Range { low: distance.low / radius, high: distance.high / radius },
    };
    Met { z, rho, inside: [distance.high <= radius, distance.low <= radius] }
}
