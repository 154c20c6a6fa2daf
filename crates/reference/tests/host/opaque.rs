//! Opaque points, squares and circles, flat and moved toward the viewer.

use pellucid_reference::opaque;

use super::*;

fn render(positions: &[DVec3], shape: Shape, settings: ScreenSplats) -> ReferencePicture {
    render_moved(positions, shape, settings, Relief::Flat)
}

fn render_moved(positions: &[DVec3], shape: Shape, settings: ScreenSplats, relief: Relief) -> ReferencePicture {
    let points = Points {
        positions: positions.to_vec(),
        colors: vec![Vec3::ONE; positions.len()],
        opacities: vec![0.1; positions.len()],
        radii: vec![2.0; positions.len()],
        ..Points::default()
    };
    let colors: Vec<DVec3> = (0..positions.len()).map(|i| DVec3::splat(1.0 + i as f64)).collect();
    opaque::render(View::new(&orthographic(), SIZE), &points, &colors, shape, &settings, relief)
}

#[test]
fn nearest_wins_then_the_smaller_index() {
    let z = |z: f64| -z * DVec3::Z;
    let picture = render(&[z(5.0), z(3.0), z(3.0), z(4.0)], Shape::Point, ScreenSplats::default());
    let on = 4 * 9 + 4;
    assert_eq!((picture.rgba[on], picture.depth[on], picture.counts[on]), ([2.0, 2.0, 2.0, 1.0], 3.0, 4));
    assert_eq!((picture.rgba[on + 1], picture.depth[on + 1]), ([0.0; 4], f64::INFINITY));
}

#[test]
fn size_scales_and_the_clamp_follows() {
    let drawn = |shape, size, max_pixel_radius| {
        let picture =
            render(&[-5.0 * DVec3::Z], shape, ScreenSplats { size, max_pixel_radius, ..ScreenSplats::default() });
        picture.counts.iter().sum::<u32>()
    };
    // Radius 2: 13 pixels of a disc (see `disc_around_a_pixel_center`), 25 of a square; 0.6·2 = 1.2: 5 and 9.
    assert_eq!([drawn(Shape::Disc, 1.0, 25.0), drawn(Shape::Square, 1.0, 25.0)], [13, 25]);
    assert_eq!([drawn(Shape::Disc, 0.6, 25.0), drawn(Shape::Square, 0.6, 25.0)], [5, 9]);
    assert_eq!([drawn(Shape::Disc, 2.0, 1.5), drawn(Shape::Square, 2.0, 1.5)], [9, 9]);
    assert_eq!([drawn(Shape::Point, 3.0, 25.0), drawn(Shape::Disc, 0.0, 25.0)], [1, 1]);
}

#[test]
fn overlapping_circles() {
    let positions = [DVec3::new(-1.0, 0.0, -5.0), DVec3::new(1.0, 0.0, -4.0)];
    let picture = render(&positions, Shape::Disc, ScreenSplats::default());
    // Columns 1…5 belong to the first, 3…7 to the second, which is nearer.
    let row: Vec<f64> = (0..9).map(|x| picture.rgba[4 * 9 + x][0]).collect();
    assert_eq!(row, [0.0, 1.0, 1.0, 2.0, 2.0, 2.0, 2.0, 2.0, 0.0]);
}

#[test]
fn equal_points_meet_half_way() {
    // Columns 1…5 belong to the first, 3…7 to the second; both have column 4 at the same distance.
    let positions = [DVec3::new(-1.0, 0.0, -5.0), DVec3::new(1.0, 0.0, -5.0)];
    for relief in [Relief::Paraboloid, Relief::Cone, Relief::Sphere] {
        let picture = render_moved(&positions, Shape::Disc, ScreenSplats::default(), relief);
        let row: Vec<f64> = (0..9).map(|x| picture.rgba[4 * 9 + x][0]).collect();
        assert_eq!(row, [0.0, 1.0, 1.0, 1.0, 1.0, 2.0, 2.0, 2.0, 0.0], "{relief:?}");
    }
}

#[test]
fn fragments_move_by_the_drawn_radius() {
    let alone = |shape, settings, relief| render_moved(&[-5.0 * DVec3::Z], shape, settings, relief).depth;
    let (middle, beside, corner) = (4 * 9 + 4, 4 * 9 + 5, 3 * 9 + 5);
    let plain = ScreenSplats::default();
    let near = |found: f64, wanted: f64| assert!((found - wanted).abs() < 1e-12, "{found} {wanted}");
    let z = alone(Shape::Disc, plain, Relief::Paraboloid);
    near(z[middle], 3.0);
    near(z[beside], 5.0 - 2.0 * 0.75);
    near(z[corner], 5.0 - 2.0 * 0.5);
    let z = alone(Shape::Disc, plain, Relief::Cone);
    near(z[middle], 3.0);
    near(z[beside], 4.0);
    near(z[corner], 3.0 + 2f64.sqrt());
    let z = alone(Shape::Disc, plain, Relief::Sphere);
    near(z[middle], 3.0);
    near(z[beside], 5.0 - 3f64.sqrt());
    near(z[corner], 5.0 - 2f64.sqrt());
    // A square's corner lies √2 radii out, where a paraboloid is as far behind the center as its apex is before it.
    let z = alone(Shape::Square, plain, Relief::Paraboloid);
    near(z[2 * 9 + 6], 7.0);
    // Half the size, and clamped.
    near(alone(Shape::Disc, ScreenSplats { size: 0.5, ..plain }, Relief::Paraboloid)[middle], 4.0);
    near(alone(Shape::Disc, ScreenSplats { max_pixel_radius: 1.5, ..plain }, Relief::Paraboloid)[middle], 3.5);
    // A radius of 0 is its own rim.
    near(alone(Shape::Disc, ScreenSplats { size: 0.0, ..plain }, Relief::Sphere)[middle], 5.0);
}

#[test]
fn a_radius_in_pixels_is_the_same_at_every_depth_and_for_every_radius() {
    let radius = |pixels| ScreenSplats { pixel_radius: Some(pixels), ..ScreenSplats::default() };
    let covered = |camera: &Camera, z: f64, shape, settings: ScreenSplats, own: f32| {
        let points = Points {
            positions: vec![-z * DVec3::Z],
            colors: vec![Vec3::ONE],
            opacities: vec![1.0],
            radii: vec![own],
            ..Points::default()
        };
        let view = View::new(camera, SIZE);
        opaque::render(view, &points, &[DVec3::ONE], shape, &settings, Relief::Flat).counts.iter().sum::<u32>()
    };
    for camera in [orthographic(), perspective()] {
        for z in [1.0, 5.0, 90.0] {
            for own in [0.0, 2.0, f32::MAX] {
                // Of a disc of 2 pixels around a pixel's center the rim counts: 13 pixels; of a square 25.
                for (shape, pixels, wanted) in
                    [(Shape::Disc, 2.0, 13), (Shape::Square, 2.0, 25), (Shape::Disc, 1.0, 5), (Shape::Disc, 0.0, 1)]
                {
                    assert_eq!(covered(&camera, z, shape, radius(pixels), own), wanted, "{shape:?} {pixels} {z} {own}");
                }
                // The size doesn't count, the clamp does.
                let sized = ScreenSplats { size: 3.0, ..radius(2.0) };
                assert_eq!(covered(&camera, z, Shape::Disc, sized, own), 13);
                let clamped = ScreenSplats { max_pixel_radius: 1.0, ..radius(2.0) };
                assert_eq!(covered(&camera, z, Shape::Square, clamped, own), 9);
            }
        }
    }
}

#[test]
fn fragments_move_by_a_radius_in_pixels_too() {
    // A pixel is a unit.
    let settings = ScreenSplats { pixel_radius: Some(3.0), ..ScreenSplats::default() };
    let z = render_moved(&[-5.0 * DVec3::Z], Shape::Disc, settings, Relief::Cone).depth;
    assert!((z[4 * 9 + 4] - 2.0).abs() < 1e-12 && (z[4 * 9 + 5] - 3.0).abs() < 1e-12, "{z:?}");
}
