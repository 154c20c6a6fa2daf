//! The kernel `ellipsoid`, by chords and by hand.

use pellucid_reference::abuffer;
use pellucid_reference::gaussians::ellipsoid::{Body, Matter, blend, bodies, mean_depth, median, render};
use pellucid_reference::gaussians::possible_chords;
use pellucid_scene::Discs;

use super::*;

/// The middle pixel of the image.
const MIDDLE: usize = 4 * 9 + 4;

fn discs(alpha_max: f32) -> Discs {
    let gaussians = GaussianSettings { kernel: Kernel::Ellipsoid, alpha_max, ..GaussianSettings::default() };
    Discs { gaussians, ..Discs::default() }
}

/// Gaussians as large as many pixels.
fn large(count: usize, thinnest: f64) -> Vec<Splatted> {
    varied(count, thinnest).iter().map(|s| Splatted(s.0, 3.0 * s.1, s.2, s.3)).collect()
}

/// Ray through the middle of the image, by a cap of 1.
fn middle(camera: &Camera, all: &[Splatted], colors: &[DVec3]) -> ([f64; 4], f64, u32) {
    let picture = render(View::new(camera, SIZE), &scene(all), colors, &discs(1.0));
    (picture.rgba[MIDDLE], picture.depth[MIDDLE], picture.counts[MIDDLE])
}

#[test]
fn a_ball_has_its_opacity_along_a_diameter() {
    let at = -5.0 * DVec3::Z;
    for (camera, start) in [(perspective(), 4.0), (orthographic(), 4.0)] {
        let ([r, g, b, a], depth, count) = middle(&camera, &[ball(at, 1.0, 0.75)], &[DVec3::new(1.0, 0.5, 0.0)]);
        assert_close(a, 0.75, 1e-12);
        assert_close(r, 0.75, 1e-12);
        assert_close(g, 0.375, 1e-12);
        assert_eq!((b, count), (0.0, 1));
        assert_close(depth, start, 1e-12);
    }
}

#[test]
fn opacities_are_those_of_chords() {
    let settings = discs(0.99).gaussians;
    let mut met = 0;
    for camera in [perspective(), orthographic()] {
        for splat in large(300, 0.1) {
            let gaussian = one(splat);
            let to_view = DMat3::from_cols(camera.right, camera.up, camera.forward).transpose();
            let inverse = (to_view * gaussian.axes).inverse();
            let metric = inverse.transpose() * inverse;
            let hits = footprint(View::new(&camera, SIZE), &gaussian, &settings, Order::Pixel);
            for (y, x) in (0..9).flat_map(|y| (0..9).map(move |x| (y, x))) {
                // Of z = 1 and not of a unit of length.
                let (start, direction) = ray_through(&camera, x, y);
                let from = start - camera.to_view(gaussian.position);
                let (a, b) = (direction.dot(metric * direction), direction.dot(metric * from));
                let root = b * b - a * (from.dot(metric * from) - 1.0);
                let hit = hits.iter().find(|hit| (hit.x, hit.y) == (x, y));
                if root.abs() < 1e-9 * b * b {
                    continue;
                }
                let ends = [-1.0, 1.0].map(|sign| (sign * root.max(0.0).sqrt() - b) / a);
                assert_eq!(hit.is_some(), root > 0.0 && ends[1] >= camera.near, "({x}, {y}) of {gaussian:?}");
                let Some(hit) = hit else { continue };
                let entry = ends[0].max(camera.near);
                let length = (ends[1] - entry) * direction.length();
                let shortest = f64::from(splat.1.min_element());
                let opacity = f64::from(splat.3).min(f64::from(0.99f32));
                assert_close(hit.alpha, 1.0 - (1.0 - opacity).powf(length / (2.0 * shortest)), 1e-6);
                assert_close(hit.z, entry, 1e-6);
                met += 1;
            }
        }
    }
    assert!(met > 1000, "{met} pixels");
}

#[test]
fn the_cap_is_one_of_density() {
    // Along an axis of four times the length of the shortest, less than 1 shows through than along that.
    let long = Splatted(-5.0 * DVec3::Z, Vec3::new(0.5, 0.5, 2.0), Quat::IDENTITY, 1.0);
    let picture = render(View::new(&orthographic(), SIZE), &scene(&[long]), &[DVec3::ONE], &discs(0.75));
    assert_close(picture.rgba[MIDDLE][3], 1.0 - 0.25f64.powi(4), 1e-12);
    // Without a cap it is opaque from where it begins.
    let ([.., a], depth, _) = middle(&orthographic(), &[long], &[DVec3::ONE]);
    assert_eq!((a, depth), (1.0, 3.0));
}

#[test]
fn only_the_near_plane_cuts_ellipsoids() {
    let camera = perspective();
    let across = ball(DVec3::new(0.0, 0.0, -camera.near), 1.0, 0.75);
    let ([.., a], depth, _) = middle(&camera, &[across], &[DVec3::ONE]);
    assert_close(a, 0.5, 1e-12);
    assert_close(depth, camera.near, 1e-12);
    let beyond = ball(DVec3::new(0.0, 0.0, 1e-6 - camera.far), 1.0, 0.75);
    let ([.., a], ..) = middle(&camera, &[beyond], &[DVec3::ONE]);
    assert_close(a, 0.75, 1e-9);
}

#[test]
fn without_thickness_it_is_a_disc() {
    let colors = [DVec3::ONE];
    for camera in [perspective(), orthographic()] {
        for degrees in [0.0, 30.0, 80.0] {
            let ([.., a], depth, count) = middle(&camera, &[pancake(-5.0 * DVec3::Z, 1.0, degrees, 0.6)], &colors);
            assert_close(a, f64::from(0.6f32), 1e-12);
            assert_close(depth, 5.0, 1e-12);
            assert_eq!(count, 1);
        }
        // Seen along its plane, and without a plane, it is nothing.
        let needle = Splatted(-5.0 * DVec3::Z, Vec3::new(1.0, 0.0, 0.0), Quat::IDENTITY, 0.6);
        assert_eq!(middle(&camera, &[needle], &colors).2, 0);
    }
    // The cap is one of density alone.
    let picture = render(
        View::new(&orthographic(), SIZE),
        &scene(&[pancake(-5.0 * DVec3::Z, 1.0, 0.0, 1.0)]),
        &colors,
        &discs(0.5),
    );
    assert_eq!(picture.rgba[MIDDLE][3], 1.0);
}

#[test]
fn apart_they_blend_and_together_they_mix() {
    let colors = [DVec3::X, DVec3::Y];
    let apart = [ball(-5.0 * DVec3::Z, 1.0, 0.5), ball(-8.0 * DVec3::Z, 1.0, 0.75)];
    let ([r, g, _, a], depth, count) = middle(&orthographic(), &apart, &colors);
    assert_close(r, 0.5, 1e-12);
    assert_close(g, 0.5 * 0.75, 1e-12);
    assert_close(a, 1.0 - 0.5 * 0.25, 1e-12);
    assert_eq!((depth, count), (4.0, 2));
    // In the same place, the second of twice the density.
    let together = [ball(-5.0 * DVec3::Z, 1.0, 0.5), ball(-5.0 * DVec3::Z, 1.0, 0.75)];
    let ([r, g, ..], ..) = middle(&orthographic(), &together, &colors);
    assert_close(r, (1.0 - 0.125) / 3.0, 1e-12);
    assert_close(g, (1.0 - 0.125) * 2.0 / 3.0, 1e-12);
}

#[test]
fn half_overlapping_ones_by_hand() {
    // From z = 4 to 6, and from 5 to 7, each of optical depth ln 4: segments of ln 2, 2 ln 2 and ln 2.
    let all = [ball(-5.0 * DVec3::Z, 1.0, 0.75), ball(-6.0 * DVec3::Z, 1.0, 0.75)];
    let ([r, g, _, a], ..) = middle(&orthographic(), &all, &[DVec3::X, DVec3::Y]);
    assert_close(r, 0.5 + 0.5 * 0.75 * 0.5, 1e-12);
    assert_close(g, 0.5 * 0.75 * 0.5 + 0.125 * 0.5, 1e-12);
    assert_close(a, 1.0 - 1.0 / 16.0, 1e-12);
}

#[test]
fn a_disc_within_divides_what_it_is_in() {
    let mut points = scene(&[ball(-5.0 * DVec3::Z, 1.0, 0.75)]);
    points.append(Points {
        positions: vec![-5.0 * DVec3::Z],
        colors: vec![Vec3::ONE],
        opacities: vec![0.5],
        radii: vec![0.5],
        ..Points::default()
    });
    let picture = abuffer::render(View::new(&orthographic(), SIZE), &points, &[DVec3::X, DVec3::Y], &discs(1.0));
    let [r, g, _, a] = picture.rgba[MIDDLE];
    assert_close(r, 0.5 + 0.25 * 0.5, 1e-12);
    assert_close(g, 0.25, 1e-12);
    assert_close(a, 1.0 - 0.125, 1e-12);
    assert_eq!(picture.counts[MIDDLE], 2);
}

#[test]
fn median_and_mean_depth_by_hand() {
    let all = |opacity| [ball(-5.0 * DVec3::Z, 1.0, opacity)];
    let of = |splats: &[Splatted], stretch: f64| {
        let list = bodies(View::new(&orthographic(), SIZE), &scene(splats), &discs(1.0)).swap_remove(MIDDLE);
        (median(&list, stretch, 0.5), mean_depth(&list, stretch))
    };
    // From z = 4 to 6 of optical depth ln 4: a half is left in the middle. The mean is 4 + 2 (1 / x - 1 / (exp(x) -
    // 1)).
    let (half, mean) = of(&all(0.75), 1.0);
    assert_close(half, 5.0, 1e-9);
    assert_close(mean, 4.0 + 2.0 * (1.0 / 4f64.ln() - 1.0 / 3.0), 1e-9);
    // Lengths over depths.
    assert_close(of(&all(0.75), 2.0).0, 2.5, 1e-9);
    // Hardly anything: the middle of the chord on average, and a half nowhere.
    let (half, mean) = of(&all(1e-6), 1.0);
    assert!(half.is_infinite());
    assert_close(mean, 5.0, 1e-6);
    // A disc behind it takes what is left to less than a half.
    let mut splats = all(0.25).to_vec();
    splats.push(pancake(-8.0 * DVec3::Z, 1.0, 0.0, 0.5));
    let (half, mean) = of(&splats, 1.0);
    let alone = 4.0 + 2.0 * (1.0 / (4f64 / 3.0).ln() - 3.0);
    assert_close(half, 8.0, 1e-9);
    assert_close(mean, (0.25 * alone + 0.375 * 8.0) / 0.625, 1e-9);
    assert_eq!(of(&[], 1.0), (f64::INFINITY, f64::INFINITY));
}

#[test]
fn opacity_is_that_of_all_optical_depths_and_colors_are_means() {
    let all = large(60, 0.3);
    let points = scene(&all);
    for camera in [perspective(), orthographic()] {
        let settings = discs(0.99);
        let lists = bodies(View::new(&camera, SIZE), &points, &settings);
        assert!(lists.iter().any(|list| list.len() > 3));
        for list in lists {
            let clear: f64 = list.iter().map(|body| 1.0 - body.opacity()).product();
            let same = blend(&list, &vec![DVec3::new(0.25, 0.5, 1.0); points.len()], 1.0);
            assert_close(same.alpha, 1.0 - clear, 1e-9);
            assert_close(same.color.y, 0.5 * same.alpha, 1e-9);
            // Their order has no effect.
            let reversed: Vec<Body> = list.iter().rev().copied().collect();
            assert_close(blend(&reversed, &vec![DVec3::ONE; points.len()], 1.0).alpha, same.alpha, 1e-12);
        }
    }
}

#[test]
fn float32_bounds_of_a_chord_contain_the_chord() {
    let settings = discs(0.99).gaussians;
    for camera in [perspective(), orthographic()] {
        for splat in large(100, 1e-3) {
            let gaussian = one(splat);
            let points = scene(&[splat]);
            let possible = possible_chords(View::new(&camera, SIZE), &gaussian, &settings);
            let lists = bodies(View::new(&camera, SIZE), &points, &discs(0.99));
            for (pixel, list) in lists.iter().enumerate() {
                let found = possible.iter().find(|chord| (chord.y * 9 + chord.x) as usize == pixel);
                let Some(body) = list.first() else {
                    assert!(found.is_none_or(|chord| chord.half.low == 0.0 || chord.middle.low < camera.near));
                    continue;
                };
                let chord = found.expect("it is met");
                let (_, direction) = ray_through(&camera, pixel as u32 % 9, pixel as u32 / 9);
                let [start, end] = [body.start, body.end].map(|s| s / direction.length());
                let Matter::Density(_) = body.matter else { panic!("{body:?}") };
                if start > camera.near {
                    let slack = 1e-9 * end;
                    assert!(chord.middle.covers(0.5 * (start + end), slack), "{chord:?} {start} {end}");
                    assert!(chord.half.covers(0.5 * (end - start), slack), "{chord:?} {start} {end}");
                }
            }
        }
    }
}
