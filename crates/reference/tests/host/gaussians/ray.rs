//! The kernel `ray`, and depths along a ray.

use super::*;

/// The largest density along the ray through a pixel's center, by thirds: its ρ² and its depth.
fn densest(camera: &Camera, gaussian: &Gaussian, axes: DMat3, x: u32, y: u32) -> (f64, f64) {
    let (start, direction) = ray_through(camera, x, y);
    let to_view = DMat3::from_cols(camera.right, camera.up, camera.forward).transpose();
    let inverse = (to_view * axes).inverse();
    let center = camera.to_view(gaussian.position);
    let rho2 = |t: f64| (inverse * (start + t * direction - center)).length_squared();
    let (mut low, mut high) = (-1e3, 1e3);
    while high - low > 1e-9 {
        let third = (high - low) / 3.0;
        if rho2(low + third) < rho2(high - third) { high -= third } else { low += third }
    }
    (rho2(0.5 * (low + high)), 0.5 * (low + high))
}

#[test]
fn opacity_is_that_of_the_largest_density_along_the_ray() {
    let settings = GaussianSettings { alpha_min: 1e-4, ..bare(Kernel::Ray) };
    let mut found = 0;
    for camera in [perspective(), orthographic()] {
        for splat in varied(100, 0.1) {
            let gaussian = one(splat);
            let hits = footprint(View::new(&camera, SIZE), &gaussian, &settings, Order::Pixel);
            for (y, x) in (0..9).flat_map(|y| (0..9).map(move |x| (y, x))) {
                let (rho2, depth) = densest(&camera, &gaussian, gaussian.axes, x, y);
                let alpha = f64::from(splat.3) * (-0.5 * rho2).exp();
                let wanted = alpha >= 1e-4f32.into() && depth >= camera.near && depth <= camera.far;
                let hit = hits.iter().find(|hit| (hit.x, hit.y) == (x, y));
                assert_eq!(hit.is_some(), wanted, "({x}, {y}) of {gaussian:?}: {alpha} at {depth}");
                let Some(hit) = hit else { continue };
                // Where ρ² is least it is known to half the digits of t, which are 9; in steps of a tenth of the size.
                assert_close(hit.alpha, alpha, 1e-9);
                assert_close(hit.key, depth, 1e-6);
                assert_eq!(hit.key, hit.z);
                found += 1;
            }
        }
    }
    assert!(found > 1000, "{found}");
}

#[test]
fn orthographic_it_is_the_projection() {
    let settings = |kernel| GaussianSettings { kernel, ..bare(kernel) };
    for splat in varied(100, 0.05) {
        let [ewa, ray] = [Kernel::Ewa, Kernel::Ray]
            .map(|kernel| footprint(View::new(&orthographic(), SIZE), &one(splat), &settings(kernel), Order::Center));
        // Depths may be outside near and far, of `ray` alone.
        for hit in &ray {
            let other = ewa.iter().find(|other| (other.x, other.y) == (hit.x, hit.y)).unwrap();
            assert_close(hit.alpha, other.alpha, 1e-11);
            assert_eq!((hit.key, hit.z), (other.key, other.z));
        }
    }
}

#[test]
fn without_thickness_it_is_where_the_ray_meets_the_plane() {
    // The plane z = 9 + x tan 60° meets the ray of column offset dx at z = 9 / (1 − tan 60°·dx/4.5), 2|x| from the
    // center.
    let splat = pancake(-9.0 * DVec3::Z, 3.0, 60.0, 1.0);
    let hits = footprint(View::new(&perspective(), SIZE), &one(splat), &bare(Kernel::Ray), Order::Pixel);
    for dx in [-2.0, -1.0, 0.0, 1.0] {
        let z = 9.0 / (1.0 - 3f64.sqrt() * dx / 4.5);
        let hit = hit(&hits, (4.0 + dx) as u32, 4);
        // The quaternion is rounded to float32, and 1/cos² 60° makes the more of it.
        assert_close(hit.key, z, 1e-5);
        assert_close(hit.alpha, (-0.5 * (2.0 * z * dx / 4.5 / 3.0).powi(2)).exp(), 1e-6);
    }
    // Seen along the plane there is nothing, and neither of a line.
    let along = pancake(-5.0 * DVec3::Z, 1.0, 0.0, 1.0);
    let edge_on = Splatted(along.0, Vec3::new(0.0, 1.0, 1.0), along.2, 1.0);
    let line = Splatted(along.0, Vec3::X, along.2, 1.0);
    for splat in [edge_on, line] {
        let hits = footprint(View::new(&orthographic(), SIZE), &one(splat), &bare(Kernel::Ray), Order::Pixel);
        assert!(hits.is_empty(), "{hits:?}");
    }
}

#[test]
fn depths_outside_near_and_far_are_none() {
    // The plane z = 5 + 2·x: 0.5 ≤ z means x ≥ −2.25, and z ≤ 9 that x ≤ 2.
    let camera = Camera { far: 9.0, ..orthographic() };
    let splat = pancake(-5.0 * DVec3::Z, 20.0, 2f32.atan().to_degrees(), 1.0);
    let columns = |z: f64, kernel| {
        let splat = Splatted(-z * DVec3::Z, splat.1, splat.2, 1.0);
        let hits = footprint(View::new(&camera, SIZE), &one(splat), &bare(kernel), Order::Pixel);
        hits.iter().filter(|hit| hit.y == 4).map(|hit| hit.x).collect::<Vec<_>>()
    };
    // One unit to the right of what roundings decide.
    assert_eq!(columns(4.9, Kernel::Ray), [2, 3, 4, 5, 6]);
    assert_eq!(columns(4.9, Kernel::Ewa), [0, 1, 2, 3, 4, 5, 6, 7, 8]);
    // The center itself has to be within.
    assert!(columns(9.1, Kernel::Ray).is_empty());
    assert!(columns(0.4, Kernel::Ray).is_empty());
}

#[test]
fn ewa_is_ordered_by_where_it_is_densest_as_thick_as_a_thousandth() {
    for camera in [perspective(), orthographic()] {
        for (step, splat) in varied(100, 0.1).into_iter().enumerate() {
            // A flat one, a line, or none of both.
            let extents = splat.1 * [Vec3::ONE, Vec3::new(1.0, 1.0, 0.0), Vec3::new(0.0, 0.0, 1.0)][step % 3];
            let splat = Splatted(splat.0, extents, splat.2, splat.3);
            let gaussian = one(splat);
            let least = 1e-3 * f64::from(extents.max_element());
            let turned = DMat3::from_quat(splat.2.as_dquat().normalize());
            let thick = turned * DMat3::from_diagonal(extents.as_dvec3().max(DVec3::splat(least)));
            for hit in footprint(View::new(&camera, SIZE), &gaussian, &bare(Kernel::Ewa), Order::Pixel) {
                let (_, depth) = densest(&camera, &gaussian, thick, hit.x, hit.y);
                // By thirds the depth has half the digits of ρ², which is large where the ray is far off.
                assert_close(hit.key, depth, 1e-5 * (1.0 + depth.abs()));
                assert_eq!(hit.z, hit.key);
            }
        }
    }
}
