//! The rectangle of pixels whose rays can meet a sphere.

use std::f64::consts::FRAC_PI_2;

use super::Sphere;
use crate::View;
use pellucid_core::camera::Projection;

/// Returns the first column and row, one past the last column and row, with a pixel to spare on each side.
pub fn around(view: View, sphere: &Sphere) -> [u32; 4] {
    let View { camera, size } = view;
    let focal = camera.focal_px(size[1]);
    let extent = |offset: f64| match camera.projection {
        Projection::Perspective { .. } => tangents(offset, sphere.center.z, sphere.radius),
        Projection::Orthographic { .. } => (offset - sphere.radius, offset + sphere.radius),
    };
    let pixels = |(low, high): (f64, f64), middle: f64, size: u32| {
        let first = (middle + focal * low).floor() - 1.0;
        let end = (middle + focal * high).ceil() + 1.0;
        // Infinite ones go to the image's border.
        (first.clamp(0.0, f64::from(size)) as u32, end.clamp(0.0, f64::from(size)) as u32)
    };
    let (x0, x1) = pixels(extent(sphere.center.x), view.middle().x, size[0]);
    let (y0, y1) = pixels(extent(-sphere.center.y), view.middle().y, size[1]);
    [x0, y0, x1, y1]
}

/// Slopes of the two lines through the eye that touch a circle at (`offset`, `z`) with z > 0; infinite for a line that
/// doesn't pass in front of the eye.
fn tangents(offset: f64, z: f64, radius: f64) -> (f64, f64) {
    let away = offset.hypot(z);
    if away <= radius {
        return (f64::NEG_INFINITY, f64::INFINITY);
    }
    let (middle, half) = (offset.atan2(z), (radius / away).asin());
    let slope = |angle: f64| if angle.abs() < FRAC_PI_2 { angle.tan() } else { angle.signum() * f64::INFINITY };
    (slope(middle - half), slope(middle + half))
}
