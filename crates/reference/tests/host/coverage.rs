//! Discs, squares and points on the screen.

use super::*;

#[test]
fn disc_around_a_pixel_center() {
    let count = |radius| footprint(View::new(&orthographic(), SIZE), &flat(Shape::Disc, -5.0 * DVec3::Z, radius)).len();
    // Squared distances of pixel centers: 0 (1 pixel), 1 (4), 2 (4), 4 (4), 5 (8), 8 (4), 9 (4).
    assert_eq!([0.9, 1.2, 1.5, 2.0, 2.1, 2.3, 2.9, 3.0].map(count), [1, 5, 9, 13, 13, 21, 25, 29]);
}

#[test]
fn rho_is_the_distance_over_the_radius() {
    let covered = footprint(View::new(&orthographic(), SIZE), &flat(Shape::Disc, -5.0 * DVec3::Z, 2.5));
    assert_close(at(&covered, 4, 4).rho, 0.0, ROUNDING);
    assert_close(at(&covered, 5, 3).rho, 2f64.sqrt() / 2.5, ROUNDING);
    assert_close(at(&covered, 2, 4).rho, 0.8, ROUNDING);
    assert!(covered.iter().all(|c| c.z == 5.0));
}

#[test]
fn row_0_is_at_the_top_and_column_0_at_the_left() {
    let covered = footprint(View::new(&orthographic(), SIZE), &flat(Shape::Point, DVec3::new(-3.0, 2.0, -5.0), 7.0));
    assert_eq!(pixels(&covered), [(1, 2)]);
}

#[test]
fn disc_on_a_pixel_corner() {
    // 0.5, 0.5 world units to the right and up of the middle pixel's center: the corner of four pixels.
    let corner = DVec3::new(0.5, 0.5, -5.0);
    let four = footprint(View::new(&orthographic(), SIZE), &flat(Shape::Disc, corner, 0.75));
    assert_eq!(pixels(&four), [(4, 3), (5, 3), (4, 4), (5, 4)]);
    // sqrt(1/2) > 0.7: no pixel center within, so that only the pixel of the projected center (5, 4) is left.
    let one = footprint(View::new(&orthographic(), SIZE), &flat(Shape::Disc, corner, 0.7));
    assert_eq!(pixels(&one), [(5, 4)]);
    assert_eq!(one[0].rho, 1.0);
}

#[test]
fn radius_0_draws_its_pixel_with_rho_1() {
    for shape in [Shape::Point, Shape::Disc, Shape::Square, Shape::Oriented] {
        for position in [DVec3::new(0.0, 0.0, -5.0), DVec3::new(1.3, -0.2, -5.0)] {
            let splat = Splat { normal: Some(DVec3::Z), ..flat(shape, position, 0.0) };
            let covered = footprint(View::new(&orthographic(), SIZE), &splat);
            let x = (4.5 + position.x) as u32;
            assert_eq!(covered, [Coverage { x, y: 4, z: 5.0, rho: 1.0 }], "{shape:?} at {position}");
        }
    }
}

#[test]
fn squares_reach_to_their_corners() {
    let square = flat(Shape::Square, -5.0 * DVec3::Z, 1.1);
    let covered = footprint(View::new(&orthographic(), SIZE), &square);
    assert_eq!(covered.len(), 9);
    assert_close(at(&covered, 5, 5).rho, 2f64.sqrt() / 1.1, ROUNDING);
    let moved = Splat { position: DVec3::new(0.2, 0.0, -5.0), ..square };
    // Offsets −1.2, −0.2, 0.8 of the columns, −1, 0, 1 of the rows.
    assert_eq!(footprint(View::new(&orthographic(), SIZE), &moved).len(), 6);
}

#[test]
fn the_clamp_bounds_the_pixel_radius_of_flat_shapes() {
    let clamped = |shape, radius| {
        let splat = Splat { max_pixel_radius: 1.2, ..flat(shape, -5.0 * DVec3::Z, radius) };
        footprint(View::new(&orthographic(), SIZE), &splat).len()
    };
    assert_eq!([clamped(Shape::Disc, 4.0), clamped(Shape::Disc, 0.9), clamped(Shape::Square, 4.0)], [5, 1, 9]);
}

#[test]
fn pixel_radius_falls_with_depth_in_perspective_only() {
    // r·H/(2·z·tan(fov/2)) = 0.8·9/(2z): 1.2 pixels at z = 3, 1.8 at 2, 0.6 at 6, 2.4 at 1.5.
    let count =
        |camera: Camera, z: f64| footprint(View::new(&camera, SIZE), &flat(Shape::Disc, -z * DVec3::Z, 0.8)).len();
    assert_eq!([3.0, 2.0, 6.0, 1.5].map(|z| count(perspective(), z)), [5, 9, 1, 21]);
    assert_eq!([3.0, 2.0, 6.0, 1.5].map(|z| count(orthographic(), z)), [1; 4]);
}

#[test]
fn only_points_from_near_to_far_are_drawn() {
    for camera in [orthographic(), perspective()] {
        let drawn = |z: f64| !footprint(View::new(&camera, SIZE), &flat(Shape::Disc, -z * DVec3::Z, 1.0)).is_empty();
        let z = [0.5, 100.0, 0.5f64.next_down(), 100f64.next_up(), -1.0, 0.0];
        assert_eq!(z.map(drawn), [true, true, false, false, false, false]);
    }
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let splat = flat(Shape::Disc, DVec3::new(bad, 0.0, -5.0), 1e9);
        assert_eq!(footprint(View::new(&orthographic(), SIZE), &splat), []);
    }
}

#[test]
fn coverage_outside_the_image_is_cut_off() {
    // The center is 2 units left of the image: the centers of columns 0 and 1 are 2.5 and 3.5 away.
    let splat = flat(Shape::Disc, DVec3::new(-6.5, 0.0, -5.0), 3.0);
    let covered = footprint(View::new(&orthographic(), SIZE), &splat);
    // 2.5² + 1² = 7.25 and 2.5² + 2² = 10.25 against 9.
    assert_eq!(pixels(&covered), [(0, 3), (0, 4), (0, 5)]);
    let everywhere = footprint(View::new(&orthographic(), [9, 5]), &flat(Shape::Disc, -5.0 * DVec3::Z, 1e30));
    assert_eq!(everywhere.len(), 45);
}

#[test]
fn georeferenced_coordinates_cover_the_same_pixels() {
    let origin = DVec3::new(500_000.0, 4_500_000.0, 100.0);
    let here = orthographic();
    let there = Camera { eye: here.eye + origin, ..here };
    let splat = flat(Shape::Disc, DVec3::new(0.25, -0.5, -5.0), 2.2);
    let moved = Splat { position: splat.position + origin, ..splat };
    // The coordinates are multiples of 2⁻², so that nothing is rounded.
    assert_eq!(footprint(View::new(&here, SIZE), &splat), footprint(View::new(&there, SIZE), &moved));
}
