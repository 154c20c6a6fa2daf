//! Discs in the tangent plane.

use super::*;

#[test]
fn facing_the_viewer_equals_flat() {
    for camera in [orthographic(), perspective()] {
        let position = DVec3::new(0.7, -0.3, -2.0);
        let flat = footprint(View::new(&camera, SIZE), &flat(Shape::Disc, position, 1.9));
        let facing = footprint(View::new(&camera, SIZE), &oriented(position, 1.9, DVec3::Z));
        assert_eq!(pixels(&flat), pixels(&facing));
        for (a, b) in flat.iter().zip(&facing) {
            assert_close(a.rho, b.rho, ROUNDING);
            assert_close(a.z, b.z, ROUNDING);
        }
    }
}

#[test]
fn without_a_normal_it_is_flat() {
    let flat = flat(Shape::Disc, DVec3::new(0.7, -0.3, -2.0), 1.9);
    for normal in [None, Some(DVec3::ZERO)] {
        let splat = Splat { normal, shape: Shape::Oriented, ..flat };
        assert_eq!(
            footprint(View::new(&perspective(), SIZE), &splat),
            footprint(View::new(&perspective(), SIZE), &flat)
        );
    }
}

#[test]
fn orthographic_at_60_degrees() {
    // On the disc an offset (dx, dy) in pixels is dx²·(1 + tan² 60°) + dy² = 4dx² + dy² away from the center.
    // Radius 2.1: |dy| ≤ 2 for dx = 0, dy = 0 for dx = ±1 (4 < 4.41 < 5).
    let covered = footprint(View::new(&orthographic(), SIZE), &oriented(-5.0 * DVec3::Z, 2.1, tilted(60.0)));
    assert_eq!(pixels(&covered), [(4, 2), (4, 3), (3, 4), (4, 4), (5, 4), (4, 5), (4, 6)]);
    assert_close(at(&covered, 3, 4).z, 5.0 - 3f64.sqrt(), ROUNDING);
    assert_close(at(&covered, 5, 4).z, 5.0 + 3f64.sqrt(), ROUNDING);
    assert_close(at(&covered, 4, 2).z, 5.0, ROUNDING);
    assert_close(at(&covered, 5, 4).rho, 2.0 / 2.1, ROUNDING);
    assert_close(at(&covered, 4, 3).rho, 1.0 / 2.1, ROUNDING);
    let other_side = footprint(View::new(&orthographic(), SIZE), &oriented(-5.0 * DVec3::Z, 2.1, -tilted(60.0)));
    assert_eq!(pixels(&covered), pixels(&other_side));
}

#[test]
fn perspective_at_60_degrees() {
    // The ray of column offset dx is (z·dx/4.5, 0, z), the plane z = 9 + tan 60°·x: z = 9/(1 − tan 60°·dx/4.5).
    let z = |dx: f64| 9.0 / (1.0 - 3f64.sqrt() * dx / 4.5);
    // (x, z − 9) from the center to the hit: 2x, since z − 9 = x·tan 60°.
    let distance = |dx: f64| 2.0 * (z(dx) * dx / 4.5).abs();
    // 2.889 at dx = −1, 6.503 at dx = +1, 4.520 at dx = −2, 5.569 at dx = −3: a radius of 5 takes two of them.
    let covered = footprint(View::new(&perspective(), SIZE), &oriented(-9.0 * DVec3::Z, 5.0, tilted(60.0)));
    let row: Vec<u32> = covered.iter().filter(|c| c.y == 4).map(|c| c.x).collect();
    assert_eq!(row, [2, 3, 4]);
    for dx in [-2.0, -1.0, 0.0] {
        let pixel = at(&covered, (4.0 + dx) as u32, 4);
        assert_close(pixel.z, z(dx), ROUNDING);
        assert_close(pixel.rho, distance(dx) / 5.0, ROUNDING);
    }
    // Above the middle the hit is 2 units (9/4.5 per pixel) higher: |dy| ≤ 2 for a radius of 5.
    let column: Vec<u32> = covered.iter().filter(|c| c.x == 4).map(|c| c.y).collect();
    assert_eq!(column, [2, 3, 4, 5, 6]);
}

#[test]
fn edge_on_leaves_its_own_pixel_at_the_centers_depth() {
    let position = DVec3::new(1.2, 0.3, -5.0);
    let own = [Coverage { x: 5, y: 4, z: 5.0, rho: 1.0 }];
    assert_eq!(footprint(View::new(&orthographic(), SIZE), &oriented(position, 3.0, DVec3::X)), own);
    // (4, 0, 3) is at right angles to (1.5, 0, −2), which is 1.5/2·4.5 = 3.375 pixels to the right.
    let splat = oriented(DVec3::new(1.5, 0.0, -2.0), 0.5, DVec3::new(4.0, 0.0, 3.0));
    let covered = footprint(View::new(&perspective(), SIZE), &splat);
    assert_eq!(pixels(&covered), [(7, 4)]);
    assert_close(covered[0].z, 2.0, ROUNDING);
    assert_close(covered[0].rho, 1.0, ROUNDING);
}

#[test]
fn own_pixel_has_the_rays_depth_only_where_the_ray_meets_the_disc() {
    // The center lies 0.25 right of the pixel's center; along the disc that is 0.25·sqrt(1 + tan² 60°) = 0.5.
    let position = DVec3::new(0.25, 0.0, -5.0);
    let reached = footprint(View::new(&orthographic(), SIZE), &oriented(position, 0.6, tilted(60.0)));
    assert_eq!(pixels(&reached), [(4, 4)]);
    assert_close(reached[0].z, 5.0 - 0.25 * 3f64.sqrt(), ROUNDING);
    assert_close(reached[0].rho, 0.5 / 0.6, ROUNDING);
    let missed = footprint(View::new(&orthographic(), SIZE), &oriented(position, 0.4, tilted(60.0)));
    assert_eq!(missed, [Coverage { x: 4, y: 4, z: 5.0, rho: 1.0 }]);
}

#[test]
fn perspective_rays_start_at_the_eye() {
    // The plane z = 1 + tan 80°·x meets the ray of column offset dx at z = 1/(1 − tan 80°·dx/4.5): behind the eye
    // for dx ≥ 1 (tan 80° = 5.67). The five columns dx ≤ 0 are met before it, at most 1.5 units away.
    let disc = oriented(-DVec3::Z, 1000.0, tilted(80.0));
    let covered = footprint(View::new(&perspective(), SIZE), &disc);
    assert_eq!(covered.len(), 5 * 9);
    assert!(covered.iter().all(|c| c.x <= 4 && c.z > 0.0));
    // Orthographic rays are whole lines: depths before the near plane and behind the eye are drawn as well.
    let whole = footprint(View::new(&orthographic(), SIZE), &disc);
    assert_eq!(whole.len(), 81);
    assert_close(at(&whole, 0, 0).z, 1.0 - 4.0 * 80f64.to_radians().tan(), 10.0 * ROUNDING);
}

#[test]
fn the_window_misses_no_pixel() {
    // Every pixel of the image against the ray test, for discs of all tilts in and around the image.
    for step in 0..60 {
        let angle = f64::from(step) * 0.7;
        let normal = DVec3::new(angle.sin(), (2.3 * angle).cos(), (1.1 * angle).sin());
        let position = DVec3::new(1.5 * angle.cos(), 1.2 * (1.7 * angle).sin(), -1.0 - 0.05 * f64::from(step));
        for radius in [0.2, 0.9, 3.0] {
            let mut expected = Vec::new();
            for (y, x) in (0..9).flat_map(|y| (0..9).map(move |x| (y, x))) {
                let ray = DVec3::new((f64::from(x) - 4.0) / 4.5, (4.0 - f64::from(y)) / 4.5, -1.0);
                let t = normal.dot(position) / normal.dot(ray);
                let home = [4.5 - 4.5 * position.x / position.z, 4.5 + 4.5 * position.y / position.z];
                let is_home = home.map(f64::floor) == [f64::from(x), f64::from(y)];
                if is_home || (t > 0.0 && (t * ray - position).length() <= radius) {
                    expected.push((x, y));
                }
            }
            let covered = footprint(View::new(&perspective(), SIZE), &oriented(position, radius, normal));
            assert_eq!(pixels(&covered), expected, "position {position}, normal {normal}, radius {radius}");
        }
    }
}
