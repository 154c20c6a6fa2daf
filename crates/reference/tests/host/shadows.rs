//! Shadow textures.

use glam::{DVec2, Vec3Swizzles};

use super::*;
use pellucid_core::cloud::Bounds;
use pellucid_reference::shadows::{Frames, Map, area, frames, holes, lit, reference_depths, shares};

const RESOLUTION: u32 = 64;

/// A map with one iteration of the filter of occluded pixels.
fn map(resolution: u32, distance: f64) -> Map {
    Map { resolution, fill: 0, occlusion: 1, distance }
}

/// A grid of n × n points around `center`, `side` wide, with two edges' directions.
fn grid(center: DVec3, [u, v]: [DVec3; 2], side: f64, n: i32) -> Vec<DVec3> {
    let at = |i: i32| side * ((f64::from(i) + 0.5) / f64::from(n) - 0.5);
    (0..n).flat_map(|i| (0..n).map(move |j| center + at(i) * u + at(j) * v)).collect()
}

fn cloud(positions: Vec<DVec3>, normal: Vec3) -> Points {
    let count = positions.len();
    Points {
        positions,
        colors: vec![Vec3::ONE; count],
        opacities: vec![1.0; count],
        radii: vec![0.0; count],
        normals: (normal != Vec3::ZERO).then(|| vec![normal; count]),
        ..Points::default()
    }
}

fn light(light: Light, points: &Points) -> Frames {
    frames(&light, &points.bounds().unwrap(), RESOLUTION)
}

const DOWN: Light = Light::Direction(DVec3::NEG_Z);
const FLAT: [DVec3; 2] = [DVec3::X, DVec3::Y];

#[test]
fn frames_hold_the_bounds_and_fit() {
    let bounds = Bounds { min: DVec3::new(-1.0, 2.0, 10.0), max: DVec3::new(3.0, 3.0, 11.0) };
    let inside = |camera: &Camera| {
        bounds.corners().map(|corner| {
            let (at, z) = camera.project(corner, [RESOLUTION; 2]);
            let off = (at - 0.5 * f64::from(RESOLUTION)).abs().max_element();
            assert!(z > camera.near && z < camera.far);
            off / (0.5 * f64::from(RESOLUTION))
        })
    };
    for light in [
        DOWN,
        Light::Direction(DVec3::new(3.0, -1.0, 0.5)),
        Light::Direction(DVec3::Y),
        Light::Position(DVec3::new(1.0, 2.5, 30.0)),
        Light::Position(DVec3::new(-9.0, 7.0, 0.0)),
    ] {
        let frames = frames(&light, &bounds, RESOLUTION);
        assert_eq!(frames.len(), 1);
        let camera = &frames[0];
        assert!((camera.right.cross(camera.up) + camera.forward).length() < ROUNDING);
        let furthest = inside(camera).into_iter().fold(0.0, f64::max);
        assert_close(furthest, 62.0 / 64.0, 1e-9);
    }
    // In the box, and so near that its corners are more than 60° off: six faces of 90°.
    for position in [DVec3::new(0.0, 2.5, 10.5), DVec3::new(1.0, 2.5, 11.5)] {
        let faces = frames(&Light::Position(position), &bounds, RESOLUTION);
        assert_eq!(faces.len(), 6);
        for direction in [DVec3::new(1.0, 0.3, -0.9), DVec3::new(-0.2, -1.0, 0.7), DVec3::new(0.1, 0.3, 1.0)] {
            let holds = |camera: &&Camera| {
                let (at, z) = camera.project(position + direction, [RESOLUTION; 2]);
                z > 0.0 && at.cmpge(DVec2::ZERO).all() && at.cmplt(DVec2::splat(64.0)).all()
            };
            assert_eq!(faces.iter().filter(holds).count(), 1, "{direction}");
        }
    }
    assert!(frames(&Light::Headlight, &bounds, RESOLUTION).is_empty());
}

#[test]
fn a_plane_alone_is_lit() {
    for degrees in [0.0, 30.0, 60.0, 80.0f64] {
        // Sparse and dense for the light's image, with and without normals.
        for (n, side) in [(20, 2.0), (150, 2.0)] {
            let (sin, cos) = degrees.to_radians().sin_cos();
            let edges = [DVec3::new(cos, 0.0, -sin), DVec3::Y];
            let positions = grid(DVec3::ZERO, edges, side, n);
            for normal in [tilted(degrees).as_vec3(), -tilted(degrees).as_vec3()] {
                let points = cloud(positions.clone(), normal);
                // A pixel's depths differ by its width times the slope at most.
                let pixel = side / 62.0;
                let distance = pixel * degrees.to_radians().sin() + 1e-6;
                let lit = lit(&light(DOWN, &points), map(RESOLUTION, distance), &points);
                assert!(lit.iter().all(|lit| *lit), "{degrees}°, {n}");
            }
        }
    }
    // At 80° a d̃ without the factor is too small.
    let (sin, cos) = 80f64.to_radians().sin_cos();
    let positions = grid(DVec3::ZERO, [DVec3::new(cos, 0.0, -sin), DVec3::Y], 2.0, 150);
    let bare = cloud(positions, Vec3::ZERO);
    let lit = lit(&light(DOWN, &bare), map(RESOLUTION, 2.0 / 62.0), &bare);
    assert!(lit.iter().any(|lit| !lit));
}

/// A plane of side 4 at z = 0 under a plane of side 1 at z = 1, and which of its points are below that.
fn covered(normal: Vec3) -> (Points, impl Fn(DVec3) -> Option<bool>) {
    let floor = grid(DVec3::ZERO, FLAT, 4.0, 81);
    let lid = grid(DVec3::Z, FLAT, 1.0, 81);
    // `None` within a pixel and a half of the border: 4 world units on 62 pixels.
    let dark = |p: DVec3| {
        let inside = 0.5 - p.x.abs().max(p.y.abs());
        (inside.abs() > 0.1).then_some(inside > 0.0 && p.z == 0.0)
    };
    (cloud([floor, lid].concat(), normal), dark)
}

#[test]
fn points_that_a_plane_covers_are_dark() {
    for normal in [Vec3::ZERO, Vec3::Z] {
        let (points, dark) = covered(normal);
        let far = Light::Position(DVec3::new(0.0, 0.0, 1e5));
        for light in [light(DOWN, &points), light(far, &points)] {
            let lit = lit(&light, map(RESOLUTION, 0.1), &points);
            let clear: Vec<(bool, bool)> =
                points.positions.iter().zip(&lit).filter_map(|(p, lit)| Some((dark(*p)?, *lit))).collect();
            assert!(clear.iter().all(|(dark, lit)| dark != lit));
            assert!(clear.iter().filter(|(dark, _)| *dark).count() > 200);
            // Nearer than d̃ they are one layer.
            assert!(pellucid_reference::shadows::lit(&light, map(RESOLUTION, 1.1), &points).iter().all(|lit| *lit));
        }
    }
}

#[test]
fn holes_of_one_pixel_let_no_light_through() {
    // Points of the lid on every second pixel of a row leave holes of a pixel that the occlusion filter closes.
    let camera = &Camera { near: 0.0, ..orthographic() };
    let lid: Vec<DVec3> = (-4..=4)
        .flat_map(|x| (-4..=4).map(move |y| DVec3::new(f64::from(x), f64::from(y), -2.0)))
        .filter(|p| (p.x as i32 + p.y as i32) % 3 != 0 || p.x.abs().max(p.y.abs()) == 4.0)
        .collect();
    let floor = grid(DVec3::new(0.0, 0.0, -5.0), FLAT, 9.0, 9);
    let count = lid.len();
    let points = cloud([lid, floor].concat(), Vec3::ZERO);
    let lit = lit(std::slice::from_ref(camera), map(9, 0.5), &points);
    assert!(lit[..count].iter().all(|lit| *lit));
    assert!(lit[count..].iter().all(|lit| !lit));
    assert!(reference_depths(camera, map(9, 0.5), &points).iter().all(|z| *z == 2.0));
}

/// A point in the middle of each of these pixels of [`orthographic`]'s image, at a depth.
fn pixels(places: impl IntoIterator<Item = [i32; 2]>, depth: f64) -> Vec<DVec3> {
    places.into_iter().map(|[x, y]| DVec3::new(f64::from(x - 4), f64::from(4 - y), -depth)).collect()
}

fn square(range: std::ops::Range<i32>) -> impl Iterator<Item = [i32; 2]> + Clone {
    range.clone().flat_map(move |y| range.clone().map(move |x| [x, y]))
}

#[test]
fn background_in_a_hole_keeps_the_mask_until_it_is_filled() {
    // A lid on 7 × 7 pixels with a hole of 3 × 3, in whose middle alone a floor shows.
    let camera = &Camera { near: 0.0, ..orthographic() };
    let lid = pixels(square(1..8).filter(|[x, y]| x.abs_diff(4).max(y.abs_diff(4)) > 1), 2.0);
    let count = lid.len();
    let points = cloud([lid, pixels([[4, 4]], 5.0)].concat(), Vec3::ZERO);
    let middle = |fill: u32, occlusion: u32| {
        let map = Map { fill, occlusion, ..map(9, 0.5) };
        let lit = lit(std::slice::from_ref(camera), map, &points);
        assert!(lit[..count].iter().all(|lit| *lit));
        lit[count]
    };
    // The eight pixels around it are background, which lies beyond: all masks match, however often.
    assert!(middle(0, 0) && middle(0, 1) && middle(0, 9));
    // None of these has five neighbors of background in a row. One iteration fills all, and the next filter closes the
    // middle.
    assert!(middle(1, 0) && !middle(1, 1));
    assert_eq!(reference_depths(camera, Map { fill: 1, ..map(9, 0.5) }, &points)[9 * 4 + 4], 2.0);
}

#[test]
fn holes_are_what_the_filters_leave_in_blocks_within_a_surface() {
    // 9 × 9 pixels are 3 × 3 blocks of 3: only the middle one has all eight around it, pixels 3 to 5.
    let camera = &Camera { near: 0.0, ..orthographic() };
    let lid =
        |hole: i32| pixels(square(0..9).filter(move |[x, y]| [x, y].into_iter().any(|at| (*at - 4).abs() > hole)), 2.0);
    let none = Map { fill: 0, occlusion: 0, ..map(9, 0.5) };
    let of = |points: Vec<DVec3>, map: Map| holes(camera, map, &cloud(points, Vec3::ZERO), 3);
    assert_eq!(of(lid(-1), none), [9, 0, 9, 0]);
    // A hole of one pixel over nothing, and over a floor; filters close it.
    assert_eq!(of(lid(0), none), [9, 1, 8, 0]);
    let floor = pixels([[4, 4]], 5.0);
    assert_eq!(of([lid(0), floor.clone()].concat(), none), [9, 1, 9, 1]);
    assert_eq!(of(lid(0), Map { fill: 1, ..none }), [9, 0, 9, 0]);
    assert_eq!(of([lid(0), floor.clone()].concat(), Map { occlusion: 1, ..none }), [9, 0, 9, 0]);
    // Points no farther than d̃ behind are the surface itself.
    assert_eq!(of([lid(0), pixels([[4, 4]], 2.5)].concat(), none), [9, 0, 9, 0]);
    // A hole that is a whole block has no surface: it is an opening.
    assert_eq!(of(lid(1), none), [0, 0, 0, 0]);
    // A floor that shows through it is the surface there, as far as the farthest of the nine.
    assert_eq!(of([lid(1), floor].concat(), none), [9, 8, 1, 0]);
    // Blocks of four end beyond the image: 3 × 3 of them, whose middle is pixels 4 to 7.
    assert_eq!(holes(camera, none, &cloud(lid(-1), Vec3::ZERO), 4), [16, 0, 16, 0]);
}

#[test]
fn a_box_covers_its_outline() {
    use pellucid_reference::shadows::covered;

    let bounds = Bounds { min: DVec3::new(-1.0, 2.0, 10.0), max: DVec3::new(3.0, 3.0, 11.0) };
    // 4 × 1 from above, on 62 of 64 pixels each way.
    let free = (62.0f64 / 64.0).powi(2);
    assert_close(covered(&frames(&DOWN, &bounds, RESOLUTION), &bounds), 0.25 * free, 1e-12);
    // From 3 above its upper side all others are hidden.
    let lamp = Light::Position(DVec3::new(1.0, 2.5, 14.0));
    assert_close(covered(&frames(&lamp, &bounds, RESOLUTION), &bounds), 0.25 * free, 1e-12);
    assert_eq!(covered(&frames(&Light::Position(bounds.center()), &bounds, RESOLUTION), &bounds), 6.0);
}

#[test]
fn a_light_in_the_cloud_shines_in_all_directions() {
    // A cube around the light in a larger one: the inner is lit, the outer dark.
    let wall = |half: f64| {
        [DVec3::X, DVec3::Y, DVec3::Z].into_iter().flat_map(move |axis| {
            let edges = [axis.yzx(), axis.zxy()];
            [-1.0, 1.0].into_iter().flat_map(move |sign| grid(sign * half * axis, edges, 2.0 * half, 90))
        })
    };
    let inner: Vec<DVec3> = wall(1.0).collect();
    let count = inner.len();
    let points = cloud(inner.into_iter().chain(wall(2.0)).collect(), Vec3::ZERO);
    let light = light(Light::Position(DVec3::splat(0.01)), &points);
    assert_eq!(light.len(), 6);
    let lit = lit(&light, map(RESOLUTION, 0.2), &points);
    assert!(lit[..count].iter().all(|lit| *lit));
    assert!(lit[count..].iter().all(|lit| !lit));
}

/// Places on a disc, rings of equal area.
fn disc(rings: u32, spokes: u32) -> Vec<DVec2> {
    let place = |ring: u32, spoke: u32| {
        let angle = std::f64::consts::TAU * (f64::from(spoke) + 0.5) / f64::from(spokes);
        ((f64::from(ring) + 0.5) / f64::from(rings)).sqrt() * DVec2::from_angle(angle)
    };
    (0..rings).flat_map(|ring| (0..spokes).map(move |spoke| place(ring, spoke))).collect()
}

#[test]
fn half_a_disc_of_light_is_half_the_light() {
    // A half-plane x < 0 at z = 1 over the floor: at x = 0 half of the directions pass it.
    let lid = grid(DVec3::new(-1.0, 0.0, 1.0), FLAT, 2.0, 120);
    let floor: Vec<DVec3> = (-20..=20).map(|i| DVec3::new(0.05 * f64::from(i), 0.0, 0.0)).collect();
    let below = lid.len();
    let points = cloud([lid, floor].concat(), Vec3::ZERO);
    let bounds = points.bounds().unwrap();
    // The edge of the lid is half a spacing inside of x = 0.
    let edge = -1.0 / 120.0;
    let slope = 10f64.to_radians().tan();
    // (light, radius in its unit, reach of the penumbra on each side of the edge)
    let near = DVec3::new(0.0, 0.0, 3.0);
    for (source, radius, reach) in [(DOWN, 10.0, slope), (Light::Position(near), 0.5, 0.5 / 2.0)] {
        let lights = area(&source, radius, &bounds, &disc(8, 50));
        let lights: Vec<Frames> = lights.iter().map(|light| frames(light, &bounds, 256)).collect();
        let shares = shares(&lights, map(256, 0.1), &points);
        for (p, m) in points.positions[below..].iter().zip(&shares[below..]) {
            // Share of the unit disc beyond the chord at −t.
            let t = match source {
                Light::Position(light) => {
                    // The light reaches the point from places beyond the line through point and edge.
                    let at = p.x + (edge - p.x) * light.z;
                    -at / radius
                }
                _ => (p.x - edge) / reach,
            };
            let t = t.clamp(-1.0, 1.0);
            let wanted = 0.5 + (t.asin() + t * (1.0 - t * t).sqrt()) / std::f64::consts::PI;
            // A pixel of the light's image against the penumbra, and the rings.
            assert_close(*m, wanted, 0.12);
        }
        assert!(shares[..below].iter().all(|m| *m == 1.0));
    }
}

#[test]
fn lights_of_an_area_lie_on_its_disc() {
    let bounds = Bounds { min: DVec3::NEG_ONE, max: DVec3::ONE };
    let places = [DVec2::ZERO, DVec2::X, 0.5 * DVec2::Y];
    let far = DVec3::new(0.0, 3.0, 4.0);
    for (found, wanted) in area(&Light::Position(far), 2.0, &bounds, &places).into_iter().zip([0.0, 2.0, 1.0]) {
        let Light::Position(position) = found else { panic!("{found:?}") };
        assert_close((position - far).length(), wanted, ROUNDING);
        assert_close((position - far).dot(far), 0.0, ROUNDING);
    }
    let axis = DVec3::new(1.0, -2.0, 2.0);
    for (found, wanted) in area(&Light::Direction(axis), 30.0, &bounds, &places).into_iter().zip([0.0, 1.0, 0.5]) {
        let Light::Direction(direction) = found else { panic!("{found:?}") };
        assert_close(direction.angle_between(axis).tan(), wanted * 30f64.to_radians().tan(), 1e-7);
    }
}

#[test]
fn unlit_points_have_ambient_light_alone() {
    let phong = Shading {
        model: ShadingModel::Phong,
        ambient: 0.25,
        diffuse: 0.5,
        specular: 1.0,
        shininess: 2.0,
        light: Light::Headlight,
        ..Shading::default()
    };
    let points = cloud(vec![DVec3::new(0.0, 0.0, -2.0); 3], tilted(60.0).as_vec3());
    let red = |points: &Points, shading: Shading, lit: &[f64]| -> Vec<f64> {
        let colors = shading::shade_lit(points, &orthographic(), &shading, ColorSpace::Linear, lit);
        colors.iter().map(|c| c.x).collect()
    };
    // cos 60° = 1/2; the reflection is 120° off the viewer: no highlight. Then straight on, with one.
    for (found, wanted) in red(&points, phong, &[1.0, 0.5, 0.0]).into_iter().zip([0.5, 0.375, 0.25]) {
        assert_close(found, wanted, 1e-6);
    }
    let facing = cloud(points.positions.clone(), Vec3::Z);
    for (found, wanted) in red(&facing, phong, &[1.0, 0.5, 0.0]).into_iter().zip([1.75, 1.0, 0.25]) {
        assert_close(found, wanted, ROUNDING);
    }
    // Without a normal: in full light the color as it is.
    let bare = cloud(points.positions.clone(), Vec3::ZERO);
    for (found, wanted) in red(&bare, phong, &[1.0, 0.5, 0.0]).into_iter().zip([1.0, 2.0 / 3.0, 1.0 / 3.0]) {
        assert_close(found, wanted, ROUNDING);
    }
    assert_eq!(red(&bare, Shading { ambient: 0.0, diffuse: 0.0, ..phong }, &[0.0; 3]), [1.0; 3]);
    assert_eq!(red(&facing, Shading { model: ShadingModel::None, ..phong }, &[0.0; 3]), [1.0; 3]);
    // Without any of them all are lit.
    assert_eq!(red(&facing, phong, &[]), red(&facing, phong, &[1.0; 3]));
}
