//! A camera that turns about its own axis: the picture moves, and no point changes its depth.
//!
//! Whatever changes then is due to the motion of the picture across its pixels alone. So changes along a path that are
//! larger than by as much motion of this kind come from points that change their order.

use glam::DVec3;
use pellucid_core::camera::Camera;

/// Points whose motion is looked at, about.
const LOOKED_AT: usize = 1000;

/// The first camera, turned about its axis by so much that points of the picture move as far, on the average, as they
/// do from the first camera to the second.
pub(super) fn rolled([from, to]: [&Camera; 2], positions: &[DVec3], size: [u32; 2]) -> Camera {
    let middle = 0.5 * glam::DVec2::new(size[0].into(), size[1].into());
    let (mut motion, mut distance) = (0.0, 0.0);
    for position in positions.iter().step_by(positions.len().div_ceil(LOOKED_AT).max(1)) {
        let [(before, depth), (after, later)] = [from, to].map(|camera| camera.project(*position, size));
        let is_seen = (before - middle).abs().cmple(middle).all() && depth > from.near && later > to.near;
        if is_seen && after.is_finite() {
            motion += (after - before).length();
            distance += (before - middle).length();
        }
    }
    let angle = if distance > 0.0 { (motion / distance).min(std::f64::consts::FRAC_PI_2) } else { 0.0 };
    let (sin, cos) = angle.sin_cos();
    Camera { right: cos * from.right + sin * from.up, up: cos * from.up - sin * from.right, ..*from }
}

#[cfg(test)]
mod tests {
    use glam::DVec2;
    use pellucid_core::camera::Projection;

    use super::*;

    fn camera(eye: DVec3) -> Camera {
        let lens = Projection::Orthographic { height: 2.0 };
        Camera::look_at(eye, eye - DVec3::Z, DVec3::Y, lens, 0.1, 10.0).unwrap()
    }

    /// Points on a circle of 0.5 units, 25 pixels, that move by 1 pixel: the arc of 1 / 25.
    #[test]
    fn points_move_as_far_as_along_the_path() {
        let circle: Vec<DVec3> = (0..360).map(|i| 0.5 * DVec2::from_angle(f64::from(i)).extend(0.0)).collect();
        let (from, to) = (camera(DVec3::Z), camera(DVec3::new(0.02, 0.0, 1.0)));
        let found = rolled([&from, &to], &circle, [100, 100]);
        assert!((found.up.dot(from.up) - (1.0f64 / 25.0).cos()).abs() < 1e-12, "{found:?}");
        assert!((found.right.dot(from.up) - (1.0f64 / 25.0).sin()).abs() < 1e-12, "{found:?}");
        assert_eq!((found.eye, found.forward), (from.eye, from.forward));
        // No depth changes.
        let depths = circle.iter().map(|p| (found.to_view(*p).z - from.to_view(*p).z).abs());
        assert_eq!(depths.fold(0.0, f64::max), 0.0);
    }

    #[test]
    fn nothing_turns_without_motion_or_points() {
        let from = camera(DVec3::Z);
        assert_eq!(rolled([&from, &from], &[DVec3::X * 0.1], [10, 10]), from);
        assert_eq!(rolled([&from, &camera(DVec3::ONE)], &[], [10, 10]), from);
    }
}
