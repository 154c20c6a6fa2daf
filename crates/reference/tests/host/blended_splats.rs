//! Splats in three passes, and one layer before them.

use super::*;
use pellucid_reference::one_layer::{self, Parts};
use pellucid_reference::splats::{self, Fragment, blend, limit};
use pellucid_scene::{BlendedSplats, OneLayer};

const COLORS: [DVec3; 3] = [DVec3::X, DVec3::Y, DVec3::Z];

fn fragment(z: f64, rho: f64, radius: f64, index: usize) -> Fragment {
    Fragment { z, rho, radius, index }
}

/// exp(−2ρ²)
fn weight(rho: f64) -> f64 {
    (-2.0 * rho * rho).exp()
}

#[track_caller]
fn assert_composite(got: Composite, color: [f64; 3], alpha: f64, depth: f64) {
    assert!((got.color - DVec3::from(color)).abs().max_element() < ROUNDING, "{got:?} is not {color:?}");
    assert_close(got.alpha, alpha, ROUNDING);
    assert_eq!(got.depth, depth);
}

#[test]
fn nothing_is_nothing() {
    assert_composite(blend(&[], &[], 1.0), [0.0; 3], 0.0, f64::INFINITY);
    assert_eq!(limit(&[], 1.0), f64::INFINITY);
}

#[test]
fn splats_within_a_radius_are_blended() {
    let list = [fragment(5.0, 0.0, 1.0, 0), fragment(5.75, 0.5, 2.0, 1), fragment(6.25, 0.0, 1.0, 2)];
    assert_eq!(limit(&list, 1.0), 6.0);
    let (a, b) = (1.0, weight(0.5));
    assert_composite(blend(&list, &COLORS, 1.0), [a / (a + b), b / (a + b), 0.0], 1.0, 5.0);
    // Any order of the fragments, and a deeper reach.
    let back = [list[2], list[1], list[0]];
    assert_composite(blend(&back, &COLORS, 1.0), [a / (a + b), b / (a + b), 0.0], 1.0, 5.0);
    assert_composite(blend(&list, &COLORS, 1.25), [1.0 / (2.0 + b), b / (2.0 + b), 1.0 / (2.0 + b)], 1.0, 5.0);
    // No reach: the nearest alone.
    assert_composite(blend(&list, &COLORS, 0.0), [1.0, 0.0, 0.0], 1.0, 5.0);
    // Behind a small splat more is hidden than behind the large one before it.
    let small = [fragment(5.0, 0.0, 9.0, 0), fragment(5.5, 0.0, 0.25, 1), fragment(6.0, 0.0, 1.0, 2)];
    assert_eq!(limit(&small, 1.0), 5.75);
    assert_composite(blend(&small, &COLORS, 1.0), [0.5, 0.5, 0.0], 1.0, 5.0);
}

fn points(positions: &[DVec3], radii: &[f32], normals: Option<Vec<Vec3>>, fields: &[f32]) -> Points {
    Points {
        positions: positions.to_vec(),
        colors: vec![Vec3::ONE; positions.len()],
        opacities: vec![0.1; positions.len()],
        radii: radii.to_vec(),
        normals,
        fields: fields.to_vec(),
        ..Points::default()
    }
}

#[test]
fn equal_points_meet_on_their_bisector() {
    let pair = points(&[DVec3::new(-1.0, 0.0, -5.0), DVec3::new(1.0, 0.0, -5.0)], &[3.0; 2], None, &[]);
    let picture =
        splats::render(View::new(&orthographic(), SIZE), &pair, &COLORS[..2], Shape::Disc, &BlendedSplats::default());
    for y in 3..6 {
        let [red, green, _, a] = picture.rgba[y * 9 + 4];
        assert!((red - 0.5).abs() < ROUNDING && (green - 0.5).abs() < ROUNDING && a == 1.0, "{red} {green}");
    }
    // Left of it more of the left one: at x = 3 the centers are 0 and 2 of 3 away.
    let wanted = 1.0 / (1.0 + weight(2.0 / 3.0));
    assert_close(picture.rgba[4 * 9 + 3][0], wanted, ROUNDING);
    assert_eq!((picture.rgba[4 * 9], picture.counts[4 * 9 + 4]), ([1.0, 0.0, 0.0, 1.0], 2));
    assert_eq!((picture.rgba[0], picture.depth[0]), ([0.0; 4], f64::INFINITY));
}

#[test]
fn the_drawn_radius_is_scaled_and_clamped_in_the_world() {
    let one = points(&[-3.0 * DVec3::Z], &[2.0625], Some(vec![Vec3::Z]), &[]);
    // 1.5 pixels per unit at z = 3; 3.1 pixels reach 29 pixel centers, 1.5 pixels the 8 neighbors.
    for (size, most, wanted, pixels) in
        [(1.0, 25.0, 2.0625, 29), (0.5, 25.0, 1.03125, 9), (1.0, 1.5, 1.0, 9), (4.0, 1.5, 1.0, 9), (0.0, 25.0, 0.0, 1)]
    {
        let settings = ScreenSplats { size, max_pixel_radius: most, ..ScreenSplats::default() };
        for shape in [Shape::Disc, Shape::Oriented] {
            let drawn = splats::splat(View::new(&perspective(), SIZE), &one, 0, shape, &settings);
            assert_close(drawn.radius, wanted, ROUNDING);
            let covered = splats::lists(View::new(&perspective(), SIZE), &one, shape, &settings, |_| true);
            assert_eq!(covered.iter().flatten().count(), pixels, "{settings:?} {shape:?}");
            assert!(covered.iter().flatten().all(|f| (f.radius - wanted).abs() < ROUNDING));
        }
    }
}

#[test]
fn oriented_depths_decide_pixel_by_pixel() {
    // A disc whose z grows to the right through a flat one that lies at its center's depth: within 0.5 of each other
    // they blend.
    let crossing = points(&[-5.0 * DVec3::Z; 2], &[2.2, 2.2], Some(vec![tilted(45.0).as_vec3(), Vec3::ZERO]), &[]);
    let settings = BlendedSplats { blend_depth: 0.25, ..BlendedSplats::default() };
    let picture = splats::render(View::new(&orthographic(), SIZE), &crossing, &COLORS[..2], Shape::Oriented, &settings);
    let row: Vec<[f64; 4]> = (3..6).map(|x| picture.rgba[4 * 9 + x]).collect();
    assert_eq!((row[0], row[2]), ([1.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 1.0]));
    assert_close(row[1][0], 0.5, ROUNDING);
    assert_close(picture.depth[4 * 9 + 3], 4.0, 1e-7);
    assert_eq!(picture.depth[4 * 9 + 5], 5.0);
}

#[test]
fn a_layer_before_solid_points_lets_them_through() {
    let soft = |z| fragment(z, 0.0, 0.5, 0);
    let parts = |soft: &[Fragment], solid: &[Fragment]| Parts { soft: soft.to_vec(), solid: solid.to_vec() };
    let solid = |z| fragment(z, 0.0, 0.5, 1);
    let far = |z| fragment(z, 0.0, 0.5, 2);
    let blend = |p: Parts, softness: f64| p.blend(&COLORS, softness, 1.0);
    assert_composite(blend(parts(&[soft(2.0)], &[solid(5.0)]), 0.25), [0.25, 0.75, 0.0], 1.0, 2.0);
    // Behind the solid, or as deep, it is not seen.
    for z in [5.0, 6.0] {
        assert_composite(blend(parts(&[soft(z)], &[solid(5.0)]), 0.25), [0.0, 1.0, 0.0], 1.0, 5.0);
    }
    // Alone it leaves the background.
    assert_composite(blend(parts(&[soft(2.0)], &[]), 0.25), [0.25, 0.0, 0.0], 0.25, 2.0);
    assert_composite(blend(parts(&[], &[solid(5.0)]), 0.25), [0.0, 1.0, 0.0], 1.0, 5.0);
    assert_composite(blend(parts(&[], &[]), 0.25), [0.0; 3], 0.0, f64::INFINITY);
    // A soft point more than its radius behind the layer is opaque; one within is part of the layer.
    assert_composite(blend(parts(&[soft(2.0), far(2.75)], &[]), 0.25), [0.25, 0.0, 0.75], 1.0, 2.0);
    assert_composite(blend(parts(&[soft(2.0), far(2.25)], &[]), 0.5), [0.25, 0.0, 0.25], 0.5, 2.0);
    // It blends with a solid point that is as near, and is hidden by a nearer one.
    assert_composite(blend(parts(&[soft(2.0), far(5.25)], &[solid(5.0)]), 0.5), [0.5, 0.25, 0.25], 1.0, 2.0);
    assert_composite(blend(parts(&[soft(2.0), far(6.0)], &[solid(5.0)]), 0.5), [0.5, 0.5, 0.0], 1.0, 2.0);
    // The extremes.
    assert_composite(blend(parts(&[soft(2.0)], &[solid(5.0)]), 0.0), [0.0, 1.0, 0.0], 1.0, 5.0);
    assert_composite(blend(parts(&[soft(2.0)], &[solid(5.0)]), 1.0), [1.0, 0.0, 0.0], 1.0, 2.0);
    assert_composite(blend(parts(&[soft(2.0)], &[]), 0.0), [0.0; 3], 0.0, f64::INFINITY);
}

#[test]
fn images_of_one_layer() {
    // Red before green before blue, of which red and green are soft.
    let z = |z: f64| -z * DVec3::Z;
    let scene = points(&[z(5.0), z(9.0), z(13.0)], &[3.0, 2.0, 1.5], None, &[0.6, 0.9, 0.5]);
    let settings = OneLayer { threshold: 0.5, softness: 0.25 };
    let picture = one_layer::render(View::new(&orthographic(), SIZE), &scene, &COLORS, &settings);
    let on = 4 * 9 + 4;
    // Green is farther behind red than its radius: opaque, and before blue.
    assert_eq!((picture.rgba[on], picture.depth[on], picture.counts[on]), ([0.25, 0.75, 0.0, 1.0], 5.0, 3));
    assert_eq!((picture.rgba[on + 3], picture.depth[on + 3]), ([0.25, 0.0, 0.0, 0.25], 5.0));
    // Above all fields everything is solid.
    let solid =
        one_layer::render(View::new(&orthographic(), SIZE), &scene, &COLORS, &OneLayer { threshold: 0.9, ..settings });
    assert_eq!(solid.rgba[on], [1.0, 0.0, 0.0, 1.0]);
}
