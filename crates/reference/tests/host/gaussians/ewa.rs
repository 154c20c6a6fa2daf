//! The kernel `ewa`.

use glam::DMat2;

use super::*;

fn center(camera: &Camera, splat: Splatted, settings: &GaussianSettings) -> Vec<Hit> {
    footprint(View::new(camera, SIZE), &one(splat), settings, Order::Center)
}

/// Every pixel of the image against α by its offset from the middle of the image, right and down.
#[track_caller]
fn assert_alphas(hits: &[Hit], settings: &GaussianSettings, alpha: impl Fn(f64, f64) -> f64) {
    for (y, x) in (0..9u32).flat_map(|y| (0..9).map(move |x| (y, x))) {
        let wanted = alpha(f64::from(x) - 4.0, f64::from(y) - 4.0);
        match hits.iter().find(|hit| (hit.x, hit.y) == (x, y)) {
            Some(hit) => assert_close(hit.alpha, wanted, ROUNDING),
            None => assert!(wanted < f64::from(settings.alpha_min), "({x}, {y}) has {wanted}"),
        }
    }
    assert!(hits.iter().all(|hit| hit.alpha >= f64::from(settings.alpha_min)));
}

#[test]
fn the_same_in_all_directions_on_the_axis() {
    let settings = GaussianSettings::default();
    let dilation = f64::from(settings.dilation);
    let ball = ball(-3.0 * DVec3::Z, 0.75, 0.5);
    // 1 pixel per unit, or 4.5/3 of them.
    for (camera, deviation) in [(orthographic(), 0.75), (perspective(), 1.125)] {
        let variance = deviation * deviation + dilation;
        let hits = center(&camera, ball, &settings);
        assert_alphas(&hits, &settings, |x, y| 0.5 * (-0.5 * (x * x + y * y) / variance).exp());
        assert!(hits.len() < 81 && hits.iter().all(|hit| (hit.key, hit.z) == (3.0, 3.0)));
    }
}

#[test]
fn off_the_axis_it_is_stretched_away_from_the_middle() {
    // At x/z = 1/2, y/z = 1/4: J/4.5·z = [1 0 −½; 0 −1 ¼], so J Jᵀ = (4.5/z)² (I + [¼ −⅛; −⅛ 1/16]).
    let settings = bare(Kernel::Ewa);
    let hits = center(&perspective(), ball(DVec3::new(1.0, 0.5, -2.0), 0.5, 0.5), &settings);
    let scale = 0.5 * 4.5 / 2.0;
    let covariance = scale * scale * DMat2::from_cols(DVec2::new(1.25, -0.125), DVec2::new(-0.125, 1.0625));
    assert_alphas(&hits, &settings, |x, y| {
        let d = DVec2::new(x - 2.25, y + 1.125);
        0.5 * (-0.5 * d.dot(covariance.inverse() * d)).exp()
    });
}

#[test]
fn beyond_the_image_j_stays_at_1_3_times_the_half_field_of_view() {
    // 90° over 9 pixels: the half field of view has the slope 1. The center at slope 2 is at 9 pixels, J at 1.3.
    let settings = bare(Kernel::Ewa);
    let hits = center(&perspective(), ball(DVec3::new(4.0, 0.0, -2.0), 2.0, 1.0), &settings);
    let across = (2.0f64 * 4.5 / 2.0).powi(2);
    assert_alphas(&hits, &settings, |x, y| {
        (-0.5 * ((x - 9.0).powi(2) / (across * (1.0 + 1.69)) + y * y / across)).exp()
    });
    assert!(hits.len() > 60);
}

#[test]
fn a_wide_image_has_a_bound_of_its_own_along_each_axis() {
    // 9 pixels high, 27 wide: half fields of slope 1 and 3. At slope 3.5 J is not clamped, since 1.3 · 3 = 3.9.
    let ball = one(ball(DVec3::new(7.0, 0.0, -2.0), 1.0, 1.0));
    let hits = footprint(View::new(&perspective(), [27, 9]), &ball, &bare(Kernel::Ewa), Order::Center);
    let (variance, offset) = ((4.5f64 / 2.0).powi(2) * (1.0 + 3.5 * 3.5), 26.5 - (13.5 + 3.5 * 4.5));
    assert_close(hit(&hits, 26, 4).alpha, (-0.5 * offset * offset / variance).exp(), ROUNDING);
}

#[test]
fn it_ends_where_opacity_does() {
    let at = |alpha_min: f32, alpha_max: f32| {
        let settings = GaussianSettings { alpha_min, alpha_max, ..bare(Kernel::Ewa) };
        let hits = center(&orthographic(), ball(-5.0 * DVec3::Z, 1.0, 0.5), &settings);
        hits.iter().map(|hit| hit.alpha).collect::<Vec<_>>()
    };
    // Opacity 1/2 in the middle, e^−½/2 = 0.3033 beside it, e^−1/2 = 0.184 across.
    assert_eq!(at(0.5, 1.0), [0.5]);
    assert!(at(0.5f32.next_up(), 1.0).is_empty());
    assert_eq!(at(0.3, 1.0).len(), 5);
    assert_eq!(at(0.304, 1.0).len(), 1);
    assert_eq!(at(0.183, 1.0).len(), 9);
    assert_eq!(at(0.25, 0.25), [0.25; 5]);
    assert!(at(0.25, 0.25f32.next_down()).is_empty());
    assert!(center(&orthographic(), ball(-5.0 * DVec3::Z, 1.0, 0.0), &bare(Kernel::Ewa)).is_empty());
}

#[test]
fn nothing_else_bounds_it() {
    // 1/255 of opacity 1 is at 3.329 deviations, beyond three.
    let hits = center(&orthographic(), ball(-5.0 * DVec3::Z, 1.21, 1.0), &bare(Kernel::Ewa));
    assert_close(hit(&hits, 8, 4).alpha, (-0.5 * (4.0 / f64::from(1.21f32)).powi(2)).exp(), ROUNDING);
    // And one between pixel centers is nowhere: 0.5/0.1 = 5 deviations.
    assert!(center(&orthographic(), ball(DVec3::new(0.5, 0.0, -5.0), 0.1, 1.0), &bare(Kernel::Ewa)).is_empty());
}

#[test]
fn antialiasing_takes_back_what_the_dilation_adds() {
    let settings = GaussianSettings { antialias: true, alpha_max: 1.0, ..GaussianSettings::default() };
    let dilation = f64::from(settings.dilation);
    let middle =
        |extent: f32| hit(&center(&orthographic(), ball(-5.0 * DVec3::Z, extent, 0.75), &settings), 4, 4).alpha / 0.75;
    // √(v² / (v + dilation)²).
    for extent in [0.1f32, 1.0, 20.0] {
        let variance = f64::from(extent).powi(2);
        assert_close(middle(extent), variance / (variance + dilation), ROUNDING);
    }
    // Not below √2.5e-5 = 0.005.
    let least = GaussianSettings { alpha_min: 1e-3, ..settings };
    let tiny = center(&orthographic(), ball(-5.0 * DVec3::Z, 1e-3, 0.75), &least);
    assert_close(hit(&tiny, 4, 4).alpha, 0.75 * 0.005, ROUNDING);
}

#[test]
fn every_pixel_has_the_opacity_of_the_projected_covariance() {
    let settings = GaussianSettings::default();
    for camera in [perspective(), orthographic()] {
        for splat in varied(200, 0.02) {
            let gaussian = one(splat);
            let view = camera.to_view(splat.0);
            let (scale, clamped) = match camera.projection {
                Projection::Perspective { .. } => {
                    (4.5 / view.z, (view.truncate() / view.z).clamp(DVec2::splat(-1.3), DVec2::splat(1.3)))
                }
                Projection::Orthographic { .. } => (1.0, DVec2::ZERO),
            };
            let right = scale * DVec3::new(1.0, 0.0, -clamped.x);
            let down = scale * DVec3::new(0.0, -1.0, clamped.y);
            let sigma = covariance(&camera, &gaussian);
            let across = right.dot(sigma * down);
            let dilation = f64::from(settings.dilation);
            let projected = DMat2::from_cols(
                DVec2::new(right.dot(sigma * right) + dilation, across),
                DVec2::new(across, down.dot(sigma * down) + dilation),
            );
            let middle = scale * DVec2::new(view.x, -view.y);
            assert_alphas(&center(&camera, splat, &settings), &settings, |x, y| {
                let d = DVec2::new(x, y) - middle;
                (f64::from(splat.3) * (-0.5 * d.dot(projected.inverse() * d)).exp()).min(f64::from(0.99f32))
            });
        }
    }
}

#[test]
fn needles_keep_their_digits() {
    // 1000 by 0.001 along the diagonal. Across it e^−½(d/0.001)², along it 1.
    let turned = Quat::from_rotation_z(-std::f32::consts::FRAC_PI_4);
    let settings = GaussianSettings { dilation: 1e-6, ..bare(Kernel::Ewa) };
    let hits = center(&orthographic(), Splatted(-5.0 * DVec3::Z, Vec3::new(1e3, 0.0, 0.0), turned, 1.0), &settings);
    let diagonal: Vec<(u32, u32)> = (0..9).map(|i| (i, i)).collect();
    assert_eq!(hits.iter().map(|hit| (hit.x, hit.y)).collect::<Vec<_>>(), diagonal);
    // The angle in float32 is off by 2^-25 of π/4, 5 pixels along it by less than 2e-4 of 0.001.
    assert!(hits.iter().all(|hit| (hit.alpha - 1.0).abs() < 1e-4), "{hits:?}");
}

#[test]
fn projections_without_an_inverse_have_no_fragments() {
    let edge_on = pancake(-5.0 * DVec3::Z, 1.0, 90.0, 1.0);
    let flat = Splatted(edge_on.0, edge_on.1, Quat::from_xyzw(0.0, 0.5f32.sqrt(), 0.0, 0.5f32.sqrt()), 1.0);
    let needle = Splatted(-5.0 * DVec3::Z, Vec3::Z, Quat::IDENTITY, 1.0);
    assert!(center(&orthographic(), needle, &bare(Kernel::Ewa)).is_empty());
    // With a dilation they are lines and dots.
    assert!(center(&orthographic(), flat, &GaussianSettings::default()).len() > 7);
    assert_eq!(center(&orthographic(), needle, &GaussianSettings::default()).len(), 9);
}

#[test]
fn only_the_center_is_compared_with_near_and_far() {
    let seen = |z: f64| !center(&orthographic(), ball(-z * DVec3::Z, 3.0, 1.0), &bare(Kernel::Ewa)).is_empty();
    // Near is 0.5, far is 100.
    assert_eq!([0.5, 0.4999, 100.0, 100.0001, -1.0].map(seen), [true, false, true, false, false]);
    let behind =
        footprint(View::new(&perspective(), SIZE), &one(ball(DVec3::Z, 9.0, 1.0)), &bare(Kernel::Ewa), Order::Pixel);
    assert!(behind.is_empty());
    assert!(center(&orthographic(), ball(DVec3::NAN, 3.0, 1.0), &bare(Kernel::Ewa)).is_empty());
}
