//! The lights that stand for an area, and the cameras through which they see a scene.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

use crate::camera::{Camera, Projection};
use crate::cloud::Bounds;
use crate::cloud::light_image::{WIDEST, axes, seen};
use crate::cloud::shadow_texture::Casting;
use crate::random::{key, threefry2x32};
use crate::scene::Light;

/// Separates this module's random numbers from others of the same seed.
const STREAM: [u32; 2] = [0x7368_6164, 0];

/// The inverse of the golden ratio.
const GOLDEN: f64 = 0.618_033_988_749_894_8;

/// A light's image of the scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LightView {
    /// The camera; its depths are those along the light's axis.
    pub camera: Camera,
    /// The index of one of six images around a position: 2 · axis of the world, plus 1 toward smaller coordinates. A
    /// point belongs to the one of its largest coordinate from the light, of equal ones to the first axis.
    pub face: Option<u32>,
}

/// Point `i` of `count` in the unit disc: a lattice of the golden ratio, shifted as a whole by `seed`, so that each
/// single point is uniformly distributed in the disc (Cranley, Patterson 1976).
fn on_disc(i: u32, count: u32, seed: u64) -> DVec2 {
    let shift = threefry2x32(STREAM, key(seed)).map(|word| f64::from(word) / 4_294_967_296.0);
    let area = (f64::from(i) / f64::from(count) + shift[0]).fract();
    let turn = (f64::from(i) * GOLDEN + shift[1]).fract();
    area.sqrt() * DVec2::from_angle(TAU * turn)
}

/// Light `i` of those that a casting has over the points in `bounds`: where it is, or where it shines to.
pub fn light(casting: &Casting, bounds: &Bounds, i: u32) -> Light {
    let radius = f64::from(casting.light_radius);
    if radius == 0.0 {
        return casting.light;
    }
    let across = |axis: DVec3, radius: f64| {
        let (x, y) = axis.any_orthonormal_pair();
        let at = radius * on_disc(i, casting.samples, casting.seed);
        at.x * x + at.y * y
    };
    match casting.light {
        Light::Direction(direction) => {
            Light::Direction((direction + across(direction, radius.to_radians().tan())).normalize())
        }
        Light::Position(position) => Light::Position(position + across(toward(position, bounds), radius)),
        Light::Headlight => Light::Headlight,
    }
}

/// Unit vector from a position to the middle of the bounds; down if both coincide.
fn toward(position: DVec3, bounds: &Bounds) -> DVec3 {
    (bounds.center() - position).try_normalize().unwrap_or(DVec3::NEG_Y)
}

/// Returns the images of a light: one, or six if the points are all around it. `reach` is that of the filters, in
/// pixels.
pub fn views(light: Light, bounds: &Bounds, resolution: u32, reach: u32) -> Vec<LightView> {
    // A pixel on each side: rounding must not lose a point.
    let margin = 1.0 + 2.0 / f64::from(resolution);
    match light {
        Light::Direction(direction) => vec![along(direction, bounds, margin)],
        Light::Position(position) => match from(position, bounds, margin) {
            Some(view) => vec![view],
            None => around(position, bounds, overlap(resolution, reach)).to_vec(),
        },
        Light::Headlight => Vec::new(),
    }
}

/// The tangent of the angle from the middle of a face of a cube to the border of its image. Filters reach beyond the
/// border of a face: what belongs to the next one has to be there. So many pixels lie around the face, and a pixel for
/// rounding; but at most a quarter of the image on each side, and at least one pixel.
fn overlap(resolution: u32, reach: u32) -> f64 {
    let free = f64::from(reach.saturating_add(1).min(resolution / 4).max(1));
    let resolution = f64::from(resolution);
    1.0 + 2.0 * free / (resolution - 2.0 * (free - 1.0))
}

/// Orthographic, along a direction.
fn along(forward: DVec3, bounds: &Bounds, margin: f64) -> LightView {
    let [right, up] = axes(forward);
    let center = bounds.center();
    let corners = seen(center, [right, up], forward, bounds);
    // The box is symmetric about its middle, seen from any direction.
    let half = corners.iter().fold(DVec3::ZERO, |most, corner| most.max(corner.abs()));
    // For a single point, or a line along the light, any size works.
    let size = if bounds.diagonal() > 0.0 { bounds.diagonal() } else { 1.0 };
    let height = 2.0 * half.x.max(half.y).max(1e-3 * size) * margin;
    let depth = half.z + 0.01 * size;
    let eye = center - depth * forward;
    let (near, far) = (1e-3 * size, 2.0 * depth);
    let camera = Camera {
        eye,
        right,
        up,
        forward,
        projection: Projection::Orthographic { height },
        near,
        far,
        shift: DVec2::ZERO,
    };
    LightView { camera, face: None }
}

/// Perspective, from a position toward the middle of the bounds; `None` if they need too wide an angle.
fn from(position: DVec3, bounds: &Bounds, margin: f64) -> Option<LightView> {
    let forward = (bounds.center() - position).try_normalize()?;
    let [right, up] = axes(forward);
    let corners = seen(position, [right, up], forward, bounds);
    let near = corners.iter().map(|corner| corner.z).fold(f64::INFINITY, f64::min);
    let far = corners.iter().map(|corner| corner.z).fold(0.0, f64::max);
    if near <= 0.0 {
        return None;
    }
    // For a single point, or a line along the light, any size works.
    let least = 1e-3 * if bounds.diagonal() > 0.0 { bounds.diagonal() / far } else { 1.0 };
    let widest = corners.iter().map(|corner| corner.x.abs().max(corner.y.abs()) / corner.z).fold(least, f64::max);
    let fov_y = 2.0 * (widest * margin).atan();
    let projection = Projection::Perspective { fov_y };
    let camera = Camera {
        eye: position,
        right,
        up,
        forward,
        projection,
        near: 0.99 * near,
        far: 1.01 * far,
        shift: DVec2::ZERO,
    };
    (widest <= WIDEST).then_some(LightView { camera, face: None })
}

/// Six images around a position.
fn around(position: DVec3, bounds: &Bounds, margin: f64) -> [LightView; 6] {
    let far = bounds.corners().iter().map(|corner| corner.distance(position)).fold(0.0, f64::max);
    let projection = Projection::Perspective { fov_y: 2.0 * margin.atan() };
    std::array::from_fn(|face| {
        let forward = DVec3::AXES[face / 2] * if face % 2 == 0 { 1.0 } else { -1.0 };
        let [right, up] = axes(forward);
        // Points can't be too near: a point at the position of the light is lit.
        let (near, far) = (NEAREST, 1.01 * far.max(2.0 * NEAREST));
        let camera = Camera { eye: position, right, up, forward, projection, near, far, shift: DVec2::ZERO };
        LightView { camera, face: Some(face as u32) }
    })
}

/// A depth above zero that is a normal number in float32, and whose inverse is.
const NEAREST: f64 = 1e-30;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Shadows;

    /// Pixels that filters reach.
    const REACH: u32 = 2;

    fn unit_box() -> Bounds {
        Bounds { min: DVec3::splat(-1.0), max: DVec3::ONE }
    }

    fn casting(light: Light, samples: u32, light_radius: f32, seed: u64) -> Casting {
        let shadows = Shadows { samples, light_radius, ..Shadows::default() };
        shadows.casting(light, seed, (&unit_box(), 1)).expect("it casts")
    }

    /// Asserts that some image has each corner of the bounds and their middle at least half a pixel from its border.
    fn assert_holds(light: Light, bounds: &Bounds, resolution: u32) -> Vec<LightView> {
        let views = views(light, bounds, resolution, REACH);
        let side = f64::from(resolution);
        // A point at the light's own position has no defined image.
        let points = bounds.corners().into_iter().chain([bounds.center()]).filter(|p| light != Light::Position(*p));
        for point in points {
            let holds = |view: &&LightView| {
                let camera = &view.camera;
                let (at, z) = camera.project(point, [resolution; 2]);
                z >= camera.near && z <= camera.far && at.min_element() > 0.5 && at.max_element() < side - 0.5
            };
            let count = views.iter().filter(holds).count();
            assert!(count == 1 || (count > 1 && views.len() == 6), "{light:?}: {point} is in {count} images");
        }
        views
    }

    #[test]
    fn images_hold_all_points() {
        let flat = Bounds { min: DVec3::new(5e5, 4.5e6, 10.0), max: DVec3::new(5.001e5, 4.5001e6, 10.0) };
        for bounds in [unit_box(), flat] {
            for resolution in [16, 1024] {
                for direction in [DVec3::NEG_Y, DVec3::Z, DVec3::new(1.0, -2.0, 0.3)] {
                    let light = Light::Direction(direction.normalize());
                    assert_eq!(assert_holds(light, &bounds, resolution).len(), 1);
                }
                let far = bounds.center() + bounds.diagonal() * DVec3::new(0.5, 3.0, 0.2);
                assert_eq!(assert_holds(Light::Position(far), &bounds, resolution).len(), 1);
            }
        }
        for near in [DVec3::ZERO, DVec3::new(0.3, 0.9, -0.5), DVec3::new(0.0, 1.2, 0.0)] {
            assert_eq!(assert_holds(Light::Position(near), &unit_box(), 64).len(), 6);
        }
    }

    #[test]
    fn faces_of_a_cube_hold_what_filters_reach_beyond_them() {
        for (resolution, reach) in [(1024, 1), (1024, 2), (64, 6), (256, 40)] {
            for view in views(Light::Position(DVec3::ZERO), &unit_box(), resolution, reach) {
                // The middle of an edge of the face: a pixel and so many beyond it are in the image.
                let edge = view.camera.forward + view.camera.right;
                let (at, _) = view.camera.project(edge, [resolution; 2]);
                let pixels = f64::from(resolution) - at.x.floor() - 1.0;
                assert!(pixels >= f64::from(reach) && pixels <= f64::from(reach) + 1.0, "{reach}: {pixels}");
            }
        }
        // The old picture of one iteration of one filter had a pixel around the image; a small image has no more.
        assert_eq!(overlap(1024, 0), 1.0 + 2.0 / 1024.0);
        assert_eq!(overlap(4, 9), 1.5);
        assert_eq!(overlap(1, 9), 3.0);
    }

    #[test]
    fn images_are_no_larger_than_the_points_need() {
        // The box from above: two units of 64 pixels, except for the margin; so far away that perspective vanishes.
        let pixel = |light| {
            let camera = views(light, &unit_box(), 64, REACH)[0].camera;
            camera.pixels_per_unit(camera.to_view(DVec3::ZERO).z, 64)
        };
        for light in [Light::Direction(DVec3::NEG_Y), Light::Position(DVec3::new(0.0, 1e5, 0.0))] {
            assert!((29.0..32.0).contains(&pixel(light)), "{light:?}: {}", pixel(light));
        }
    }

    #[test]
    fn a_single_point_has_an_image() {
        let bounds = Bounds { min: DVec3::ONE, max: DVec3::ONE };
        assert_holds(Light::Direction(DVec3::X), &bounds, 8);
        assert_holds(Light::Position(DVec3::ZERO), &bounds, 8);
        assert_eq!(views(Light::Position(DVec3::ONE), &bounds, 8, REACH).len(), 6);
    }

    #[test]
    fn lights_without_an_area_are_the_light() {
        let down = Light::Direction(DVec3::NEG_Y);
        assert_eq!(light(&casting(down, 30, 0.0, 5), &unit_box(), 17), down);
    }

    #[test]
    fn lights_spread_evenly_over_their_area() {
        let count = 256;
        for seed in 0..4 {
            let points: Vec<DVec2> = (0..count).map(|i| on_disc(i, count, seed)).collect();
            assert!(points.iter().all(|p| p.length() <= 1.0));
            // Halves of the disc and its inner half by area have half of the points: of independent ones 128 ± 8.
            for inside in [
                points.iter().filter(|p| p.x > 0.0).count(),
                points.iter().filter(|p| p.x + 0.7 * p.y > 0.0).count(),
                points.iter().filter(|p| p.length_squared() < 0.5).count(),
            ] {
                assert!(inside.abs_diff(128) <= 4, "{inside} of {count}, seed {seed}");
            }
        }
    }

    #[test]
    fn each_light_by_itself_is_anywhere_alike() {
        // The fifth of seven lights, over 4000 seeds: the mean of a unit disc's points is 0 ± 0.5 / √4000 in either
        // coordinate, that of their squared radius 1/2 ± 1 / √(12 · 4000).
        let seeds = 4000;
        let points: Vec<DVec2> = (0..seeds).map(|seed| on_disc(4, 7, seed)).collect();
        let mean = points.iter().sum::<DVec2>() / seeds as f64;
        let squared = points.iter().map(|p| p.length_squared()).sum::<f64>() / seeds as f64;
        assert!(mean.abs().max_element() < 4.5 * 0.0079, "{mean}");
        assert!((squared - 0.5).abs() < 4.5 * 0.0046, "{squared}");
    }

    #[test]
    fn areas_have_the_radius_that_was_asked_for() {
        let bounds = unit_box();
        let most = |of: &dyn Fn(u32) -> f64| (0..500).map(of).fold(0.0, f64::max);
        let sun = casting(Light::Direction(DVec3::X), 500, 5.0, 3);
        let angle = |i| match light(&sun, &bounds, i) {
            Light::Direction(d) => d.dot(DVec3::X).acos().to_degrees(),
            _ => f64::NAN,
        };
        assert!((4.9..=5.0 + 1e-9).contains(&most(&angle)));
        let lamp = DVec3::new(0.0, 4.0, 0.0);
        let area = casting(Light::Position(lamp), 500, 0.25, 3);
        let offset = |i| match light(&area, &bounds, i) {
            Light::Position(p) if (p - lamp).y.abs() < 1e-12 => p.distance(lamp),
            _ => f64::NAN,
        };
        assert!((0.245..=0.25 + 1e-6).contains(&most(&offset)));
    }
}
