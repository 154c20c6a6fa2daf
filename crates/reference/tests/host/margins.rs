//! Distances of a splat from covering other pixels.

use super::*;

#[test]
fn distance_from_the_rim_to_the_nearest_pixel_center() {
    let margin = |shape, radius| margin_px(View::new(&orthographic(), SIZE), &flat(shape, -5.0 * DVec3::Z, radius));
    // Distances of pixel centers: 1, sqrt(2), 2.
    assert_close(margin(Shape::Disc, 1.1), 0.1, ROUNDING);
    assert_close(margin(Shape::Disc, 1.95), 0.05, ROUNDING);
    assert_close(margin(Shape::Square, 1.45), 0.45, ROUNDING);
    // 60° make it steeper: 0.1 world units along the disc are 0.05 pixels across it.
    let tilted = margin_px(View::new(&orthographic(), SIZE), &oriented(-5.0 * DVec3::Z, 2.1, tilted(60.0)));
    // A central difference over 1e-4 pixels of a smooth function.
    assert_close(tilted, 0.05, 1e-6);
}

#[test]
fn distance_from_the_center_to_a_pixel_border() {
    let margin =
        |shape, x, radius| margin_px(View::new(&orthographic(), SIZE), &flat(shape, DVec3::new(x, 0.0, -5.0), radius));
    assert_close(margin(Shape::Point, 0.45, 0.0), 0.05, ROUNDING);
    assert_close(margin(Shape::Disc, 0.47, 0.2), 0.03, ROUNDING);
    // From sqrt(1/2) on a disc covers its own pixel anyway and only the rim counts: pixel centers are 0.47, 0.53,
    // hypot(0.47, 1) = 1.105 and more away.
    assert_close(margin(Shape::Disc, 0.47, 0.8), 0.8 - 0.53, ROUNDING);
}

#[test]
fn distance_to_near_and_far() {
    let margin = |z: f64| margin_px(View::new(&orthographic(), SIZE), &flat(Shape::Point, -z * DVec3::Z, 0.0));
    assert_close(margin(0.51), 0.01, ROUNDING);
    assert_close(margin(0.49), 0.01, ROUNDING);
    assert_close(margin(100.25), 0.25, ROUNDING);
    assert_close(margin(50.0), 0.5, ROUNDING);
    assert_eq!(margin(f64::NAN), f64::INFINITY);
}

#[test]
fn a_smaller_shift_than_the_margin_changes_nothing() {
    for (step, shape) in (0..200).zip([Shape::Disc, Shape::Square, Shape::Oriented, Shape::Point].iter().cycle()) {
        let angle = f64::from(step) * 1.3;
        let normal = DVec3::new(angle.sin(), 0.3, 1.0 + (0.7 * angle).cos());
        let position = DVec3::new(3.0 * angle.cos(), 3.0 * (1.7 * angle).sin(), -5.0);
        let splat = Splat { normal: Some(normal), ..flat(*shape, position, 1.0 + angle.sin()) };
        // The oriented margin is of first order; the curvature of ρ takes less than half of it here.
        let margin = 0.5 * margin_px(View::new(&orthographic(), SIZE), &splat);
        let before = pixels(&footprint(View::new(&orthographic(), SIZE), &splat));
        for shift in [DVec3::X, -DVec3::X, DVec3::Y, -DVec3::Y] {
            let moved = Splat { position: position + shift * margin, ..splat };
            assert_eq!(
                pixels(&footprint(View::new(&orthographic(), SIZE), &moved)),
                before,
                "{splat:?} by {margin} px"
            );
        }
    }
}
