//! Stochastic point-based rendering: footprints by hand, then the opacities that the papers promise.

use std::sync::Arc;

use pellucid_reference::spbr::{
    Rule, limit, opacity, opacity_of_segment, over, points_per_pixel, render, render_with, share, slanted,
};
use pellucid_scene::prepare::ensembles::{CloudSurface, Deal, Dealt};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::*;

const WIDE: [u32; 2] = [32, 32];
const AREA: f64 = 32.0 * 32.0;

fn rule(ensembles: u32) -> Rule {
    Rule { ensembles, adjust: true, cos_theta: true }
}

fn dealt(clouds: &[(Vec<DVec3>, f64, f32)]) -> Dealt {
    let mut dealt = Dealt::default();
    for (positions, density, opacity) in clouds {
        let first = dealt.points.len() as u64;
        let center = pellucid_core::cloud::Bounds::enclosing(positions.iter().copied()).unwrap().center();
        let points = first..first + positions.len() as u64;
        dealt.surfaces.push(CloudSurface { points, center, density: *density, opacity: *opacity });
        let all = Arc::make_mut(&mut dealt.points);
        all.positions.extend(positions);
        all.opacities.extend(vec![*opacity; positions.len()]);
    }
    let (count, all) = (dealt.points.len(), Arc::make_mut(&mut dealt.points));
    all.colors = vec![Vec3::ONE; count];
    all.radii = vec![0.0; count];
    dealt
}

fn white(dealt: &Dealt) -> Vec<DVec3> {
    vec![DVec3::ONE; dealt.points.len()]
}

/// Camera with one pixel per world unit, 32 × 32 of them around the axis.
fn wide() -> Camera {
    camera(Projection::Orthographic { height: 32.0 })
}

/// A plane at a depth that reaches over the image's rim, with so many points over each pixel.
fn plane(per_pixel: f64, z: f64, seed: u64) -> Vec<DVec3> {
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let count = (per_pixel * 36.0 * 36.0) as usize;
    let mut at = || random.random_range(-18.0..18.0);
    (0..count).map(|_| DVec3::new(at(), at(), -z)).collect()
}

/// Mean of A.
fn mean(picture: &ReferencePicture) -> f64 {
    picture.rgba.iter().map(|c| c[3]).sum::<f64>() / picture.rgba.len() as f64
}

/// Standard error of the mean over independent pixels, from their spread.
fn error(picture: &ReferencePicture) -> f64 {
    let (mean, count) = (mean(picture), picture.rgba.len() as f64);
    let squares: f64 = picture.rgba.iter().map(|c| (c[3] - mean).powi(2)).sum();
    (squares / count / (count - 1.0)).sqrt()
}

#[track_caller]
fn assert_opacity(picture: &ReferencePicture, wanted: f64) {
    let (mean, error) = (mean(picture), error(picture));
    assert!((mean - wanted).abs() < 4.0 * error, "{mean} ± {error} instead of {wanted}");
    // Or the bound would say nothing.
    assert!(error < 0.02, "{error}");
}

#[test]
fn opacities_of_planes() {
    assert_close(opacity(2f64.ln()), 0.5, ROUNDING);
    assert_eq!((opacity(0.0), opacity(f64::INFINITY), points_per_pixel(1.0)), (0.0, 1.0, f64::INFINITY));
    for alpha in [0.0, 1e-9, 0.2, 0.99] {
        assert_close(opacity(points_per_pixel(alpha)), alpha, ROUNDING);
    }
    // Eq. 1: two points of a quarter of the area leave 9/16. With many pixels it is the exponential.
    assert_close(opacity_of_segment(2.0, 0.25), 7.0 / 16.0, ROUNDING);
    assert_close(opacity_of_segment(7e5, 1e-6), opacity(0.7), 1e-6);
    // Twice the points at 60°: 1 − 0.7².
    assert_close(slanted(0.3, 0.5), 0.51, ROUNDING);
    assert_close(slanted(0.3, -0.5), 0.51, ROUNDING);
    let (color, alpha) = over((0.5 * DVec3::X, 0.5), (0.2 * DVec3::Y, 0.2));
    assert_eq!((color, alpha), (DVec3::new(0.5, 0.1, 0.0), 0.6));
}

/// The pixels that one opaque ensemble of a few points covers.
fn covered(camera: &Camera, points: &[DVec3], center: DVec3, adjust: bool) -> (Vec<(u32, u32)>, ReferencePicture) {
    let mut dealt = dealt(&[(points.to_vec(), 0.0, 1.0)]);
    dealt.surfaces[0].center = center;
    let rule = Rule { ensembles: 1, adjust, cos_theta: true };
    let (picture, _) = render(View::new(camera, SIZE), &dealt, &white(&dealt), &rule, 0);
    let at = |i: usize| (i as u32 % SIZE[0], i as u32 / SIZE[0]);
    ((0..81).filter(|&i| picture.rgba[i][3] > 0.0).map(at).collect(), picture)
}

#[test]
fn a_point_is_one_pixel_at_its_clouds_center_and_a_square_before() {
    // 4.5 pixels at z = 1, a point on the axis: at (4.5, 4.5).
    let camera = perspective();
    let on_axis = |z: f64| vec![-z * DVec3::Z];
    let far = -4.0 * DVec3::Z;
    assert_eq!(covered(&camera, &on_axis(4.0), far, true).0, [(4, 4)]);
    // q = 2: from 3.5 to 5.5, the upper side left out; q = 3: from 3 to 6.
    assert_eq!(covered(&camera, &on_axis(2.0), far, true).0, [(3, 3), (4, 3), (3, 4), (4, 4)]);
    let three: Vec<_> = (3..6).flat_map(|y| (3..6).map(move |x| (x, y))).collect();
    assert_eq!(covered(&camera, &on_axis(4.0 / 3.0), far, true).0, three);
    assert_eq!(covered(&camera, &on_axis(4.0 / 3.0), far, false).0, three);
    // The whole image, cut at its rim.
    assert_eq!(covered(&camera, &on_axis(0.5), far, true).0.len(), 64);
    // A center before `near` (0.5) counts as there.
    assert_eq!(covered(&camera, &on_axis(0.5), DVec3::Z, true).0, [(4, 4)]);
    // Not drawn: before near, behind far, behind the eye.
    for z in [0.4, 101.0, -1.0] {
        assert_eq!(covered(&camera, &on_axis(z), far, true).0, []);
    }
    // Orthographic: one pixel whatever the depth, that of the projected position. (x, y) is at (4.5 + x, 4.5 − y).
    let flat = orthographic();
    assert_eq!(covered(&flat, &[DVec3::new(0.49, 0.49, -1.0)], far, true).0, [(4, 4)]);
    assert_eq!(covered(&flat, &[DVec3::new(0.51, 0.51, -9.0)], far, true).0, [(5, 3)]);
}

#[test]
fn the_nearest_point_wins_and_of_equal_ones_the_first() {
    let camera = orthographic();
    let at = |z: f64| DVec3::new(0.0, 0.0, -z);
    let dealt = dealt(&[(vec![at(3.0), at(2.0)], 0.0, 1.0), (vec![at(2.0), at(5.0)], 0.0, 1.0)]);
    let colors = [DVec3::X, DVec3::Y, DVec3::Z, DVec3::ONE];
    let (picture, stderr) = render(View::new(&camera, SIZE), &dealt, &colors, &rule(1), 0);
    let middle = 4 * 9 + 4;
    assert_eq!(picture.rgba[middle], [0.0, 1.0, 0.0, 1.0]);
    assert_eq!((picture.depth[middle], picture.counts[middle]), (2.0, 4));
    assert_eq!((picture.depth[0], picture.rgba[0]), (f64::INFINITY, [0.0; 4]));
    assert_eq!(stderr[middle], DVec3::INFINITY);
    // Simplified: two ensembles of one point of each cloud: first red and blue, where blue is nearer, then green and
    // white.
    let halves = Rule { ensembles: 2, adjust: false, cos_theta: true };
    let (picture, stderr) = render(View::new(&camera, SIZE), &dealt, &colors, &halves, 0);
    assert_eq!(picture.rgba[middle], [0.0, 0.5, 0.5, 1.0]);
    // 0 and 1: variance 1/2, over two.
    assert_eq!(stderr[middle], DVec3::new(0.0, 0.5, 0.5));
    assert_eq!(stderr[0], DVec3::ZERO);
}

#[test]
fn shares() {
    let camera = perspective();
    let hundred = dealt(&[(vec![-2.0 * DVec3::Z; 100], 5.0, 0.5)]);
    let surface = &hundred.surfaces[0];
    // 4.5 / 2 pixels per unit: 5 · (2/4.5)² = 0.988 points over a pixel, of which 0.693 are wanted.
    let most = 5.0 * (2.0 / 4.5f64).powi(2);
    let found = share(View::new(&camera, SIZE), &hundred, surface, &rule(20));
    assert_close(found.ratio, 20.0 * 2f64.ln() / most, ROUNDING);
    assert_close(found.unit, 2f64.ln(), ROUNDING);
    assert_eq!((found.depth, found.slots), (2.0, 1404));
    let of = |density: f64, opacity: f32, rule: Rule| {
        let found =
            share(View::new(&camera, SIZE), &hundred, &CloudSurface { density, opacity, ..surface.clone() }, &rule);
        (found.ratio, found.slots, found.unit)
    };
    // More than L is L; opaque surfaces and those without a density have all points in all ensembles.
    let (_, slots, unit) = of(0.05, 0.5, rule(20));
    assert_eq!(slots, 2000);
    assert_close(unit, most / 100.0, ROUNDING);
    let (ratio, slots, unit) = of(5.0, 1.0, rule(20));
    assert_eq!((ratio, slots), (f64::INFINITY, 2000));
    assert_close(unit, most, ROUNDING);
    assert_eq!(of(0.0, 0.5, rule(20)), (f64::INFINITY, 2000, 0.0));
    assert_eq!(of(0.0, 0.0, rule(20)), (0.0, 0, 0.0));
    assert_eq!(of(5.0, 0.5, Rule { adjust: false, ..rule(20) }).1, 100);
}

#[test]
fn a_cloud_around_the_camera_has_the_depth_of_its_part_before_it() {
    let camera = perspective();
    let depth = |z: [f64; 2]| {
        let dealt = dealt(&[(z.map(|z| -z * DVec3::Z).to_vec(), 5.0, 0.5)]);
        share(View::new(&camera, SIZE), &dealt, &dealt.surfaces[0], &rule(20)).depth
    };
    assert_eq!(depth([4.0, 8.0]), 6.0);
    assert_eq!(depth([-20.0, 8.0]), 4.0);
    assert_eq!(depth([-20.0, -8.0]), 0.5);
}

#[test]
fn a_white_plane_shows_its_opacity_whatever_the_number_of_points() {
    // k from 0.36 to 20, and L of one.
    for (ensembles, per_pixel, alpha, seed) in
        [(50, 100.0, 0.5, 1), (100, 10.0, 0.3, 2), (100, 3.5, 0.5, 3), (50, 5.0, 0.9, 4), (1, 8.0, 0.6, 5)]
    {
        let dealt = dealt(&[(plane(per_pixel, 5.0, seed), per_pixel, alpha)]);
        let (picture, _) = render(View::new(&wide(), WIDE), &dealt, &white(&dealt), &rule(ensembles), 0);
        assert_opacity(&picture, f64::from(alpha));
        assert!(picture.rgba.iter().all(|c| c[0] == c[3]), "white on black");
    }
}

#[test]
fn a_slanted_plane_is_more_opaque_unless_that_is_taken_back() {
    let (sin, cos) = 60f64.to_radians().sin_cos();
    // Turned about the vertical: half as wide in the image, so that its own plane needs twice the width.
    let turn = |p: &DVec3| DVec3::new(p.x, p.y, -30.0 + p.x * sin / cos);
    let mut dealt = dealt(&[(plane(40.0, 0.0, 6).iter().map(turn).collect(), 20.0, 0.3)]);
    let with = |cos_theta, dealt: &Dealt| {
        render(View::new(&wide(), WIDE), dealt, &white(dealt), &Rule { cos_theta, ..rule(60) }, 9).0
    };
    assert_opacity(&with(true, &dealt), slanted(0.3, 0.5));
    // Without normals nothing is known of the slant.
    assert_eq!(with(false, &dealt), with(true, &dealt));
    let count = dealt.points.len();
    Arc::make_mut(&mut dealt.points).normals = Some(vec![Vec3::new(-sin as f32, 0.0, cos as f32); count]);
    assert_opacity(&with(true, &dealt), slanted(0.3, 0.5));
    assert_opacity(&with(false, &dealt), 0.3);
}

#[test]
fn two_planes_are_as_if_blended() {
    let dealt = dealt(&[(plane(12.0, 4.0, 7), 12.0, 0.3), (plane(20.0, 6.0, 8), 20.0, 0.6)]);
    let front = dealt.surfaces[0].points.end as usize;
    let colors: Vec<DVec3> = (0..dealt.points.len()).map(|i| if i < front { DVec3::X } else { DVec3::Y }).collect();
    let (picture, _) = render(View::new(&wide(), WIDE), &dealt, &colors, &rule(60), 0);
    let (color, alpha) = over((0.3 * DVec3::X, 0.3), (0.6 * DVec3::Y, 0.6));
    assert_opacity(&picture, alpha);
    for (channel, wanted) in color.to_array().into_iter().enumerate() {
        let found = picture.rgba.iter().map(|c| c[channel]).sum::<f64>() / AREA;
        assert!((found - wanted).abs() < 4.0 * error(&picture).max(0.002), "{channel}: {found}, {wanted}");
    }
    // The nearest of all ensembles.
    assert!(picture.depth.iter().all(|z| *z == 4.0 || *z == 6.0));
}

#[test]
fn opacity_does_not_depend_on_the_distance() {
    // 32 pixels per unit at z = 1. The cloud's center is at 4, where it has 8 units over the image.
    let camera = camera(Projection::Perspective { fov_y: 2.0 * 0.5f64.atan() });
    for z in [2.0, 4.0, 8.0] {
        let scale = z / 32.0;
        let points: Vec<DVec3> = plane(30.0, 0.0, 9).iter().map(|p| DVec3::new(scale * p.x, scale * p.y, -z)).collect();
        // Per world area; a pixel at the center is (4 / 32)² large.
        let mut dealt = dealt(&[(points, 30.0 / (scale * scale), 0.4)]);
        dealt.surfaces[0].center = -4.0 * DVec3::Z;
        let (picture, _) = render(View::new(&camera, WIDE), &dealt, &white(&dealt), &rule(200), 1);
        let spread = if z < 4.0 { 2.0 } else { 1.0 };
        // Squares of several pixels make neighbors alike, and so the error of the mean larger.
        let (found, error) = (mean(&picture), spread * error(&picture));
        assert!((found - 0.4).abs() < 4.0 * error && error < 0.02, "{z}: {found} ± {error}");
    }
}

#[test]
fn points_weigh_as_much_as_their_own_opacity() {
    let mut dealt = dealt(&[(plane(30.0, 5.0, 10), 30.0, 0.6)]);
    Arc::make_mut(&mut dealt.points).opacities.fill(0.25);
    let (picture, _) = render(View::new(&wide(), WIDE), &dealt, &white(&dealt), &rule(40), 2);
    assert_opacity(&picture, 0.25);
    // An opaque point uses all points.
    Arc::make_mut(&mut dealt.points).opacities.fill(1.0);
    dealt.surfaces[0].opacity = 1.0;
    Arc::make_mut(&mut dealt.points).opacities[..1000].fill(0.25);
    let (picture, _) = render(View::new(&wide(), WIDE), &dealt, &white(&dealt), &rule(3), 2);
    assert!(mean(&picture) > 0.999, "{}", mean(&picture));
    // Not so in the simplified method: 30 points in 40 ensembles.
    let simple = Rule { adjust: false, ..rule(40) };
    let (picture, _) = render(View::new(&wide(), WIDE), &dealt, &white(&dealt), &simple, 2);
    assert_opacity(&picture, opacity(30.0 / 40.0));
}

#[test]
fn the_mean_tends_to_points_blended_front_to_back() {
    // k is 0.9 at most.
    let mut dealt = dealt(&[(plane(160.0, 4.0, 12), 160.0, 0.3), (plane(400.0, 6.0, 13), 400.0, 0.6)]);
    // Some of half the weight, and all at depths of their own.
    Arc::make_mut(&mut dealt.points).opacities.iter_mut().take(207_360).step_by(4).for_each(|alpha| *alpha = 0.16);
    Arc::make_mut(&mut dealt.points).positions.iter_mut().enumerate().for_each(|(i, p)| p.z -= 1e-6 * i as f64);
    let colors: Vec<DVec3> = (0..dealt.points.len()).map(|i| DVec3::new(1.0, (i % 3) as f64, 0.0)).collect();
    let exact = limit(View::new(&wide(), WIDE), &dealt, &colors, &rule(1));
    let mut previous = f64::INFINITY;
    for ensembles in [25, 100, 400] {
        let (picture, stderr) = render(View::new(&wide(), WIDE), &dealt, &colors, &rule(ensembles), 3);
        let squares = picture.rgba.iter().zip(&exact.rgba).map(|(a, b)| (a[0] - b[0]).powi(2)).sum::<f64>() / AREA;
        let said = stderr.iter().map(|e| e.x * e.x).sum::<f64>() / AREA;
        // No point is dealt twice before all were once, so that the error is a little less than is said.
        assert!(squares < 1.2 * said && squares < 0.4 * previous, "{ensembles}: {squares}, {said}");
        previous = squares;
    }
}

/// The mean square of what a plane of so many points over each pixel is off its opacity, times the number of ensembles.
fn noise(per_pixel: f64, alpha: f32, ensembles: u32) -> f64 {
    let dealt = dealt(&[(plane(per_pixel, 5.0, 14), per_pixel, alpha)]);
    let (picture, _) = render(View::new(&wide(), WIDE), &dealt, &white(&dealt), &rule(ensembles), 0);
    let squares = picture.rgba.iter().map(|c| (c[3] - f64::from(alpha)).powi(2)).sum::<f64>() / AREA;
    squares * f64::from(ensembles)
}

#[test]
fn copies_add_no_noise_but_that_of_the_points() {
    for (alpha, per_pixel, ensembles) in [(0.2f32, 5.0, 100), (0.5, 7.0, 100), (0.9, 23.0, 100), (0.5, 3.5, 100)] {
        let wanted = points_per_pixel(f64::from(alpha));
        let k = wanted * f64::from(ensembles) / per_pixel;
        let alpha64 = f64::from(alpha);
        let (single, found) = (alpha64 * (1.0 - alpha64), noise(per_pixel, alpha, ensembles));
        // How many points lie on a pixel is left to chance.
        let least = single + (1.0 - alpha64).powi(2) * wanted * k;
        println!("alpha {alpha}, k {k:.1}: {:.2} times that of k < 1, expected {:.2}", found / single, least / single);
        // The mean square of 1024 pixels, to a linear order in the number of points.
        assert!((found / least - 1.0).abs() < 4.0 * 0.044 + 0.1, "alpha {alpha}, k {k}: {found} and not {least}");
    }
}

#[test]
fn ensembles_of_copies_tend_to_the_limit_too() {
    let dealt = dealt(&[(plane(4.0, 4.0, 15), 4.0, 0.5)]);
    let exact = limit(View::new(&wide(), WIDE), &dealt, &white(&dealt), &rule(1));
    let mut errors = Vec::new();
    // k = 4.3, 17, 69.
    for ensembles in [25, 100, 400] {
        let (picture, stderr) = render(View::new(&wide(), WIDE), &dealt, &white(&dealt), &rule(ensembles), 5);
        let squares = picture.rgba.iter().zip(&exact.rgba).map(|(a, b)| (a[0] - b[0]).powi(2)).sum::<f64>() / AREA;
        let said = stderr.iter().map(|e| e.x * e.x).sum::<f64>() / AREA;
        // Hands of a pass have nothing in common, so that the error is less than is said.
        assert!(squares < said, "{ensembles}: {squares}, {said}");
        errors.push(squares);
    }
    assert!(errors[1] < 0.35 * errors[0] && errors[2] < 0.35 * errors[1], "{errors:?}");
    // Dealt in the same order again and again, they are no better than the first pass.
    let again = |deal: &Deal, e: u32| deal.slots(e).map(|slot| slot % deal.points).collect();
    let same = |deal: &Deal| (0..deal.ensembles).map(|e| again(deal, e)).collect();
    let (picture, _) = render_with(View::new(&wide(), WIDE), &dealt, &white(&dealt), &rule(400), 5, same);
    let squares = picture.rgba.iter().zip(&exact.rgba).map(|(a, b)| (a[0] - b[0]).powi(2)).sum::<f64>() / AREA;
    assert!(squares > 3.0 * errors[2], "{squares}, {errors:?}");
}

/// Tests images of ensembles dealt like this: their mean is α, and the mean square of its error α(1 − α)/L, which the
/// standard error must equal, too.
fn judge(hand: impl Fn(&Deal, u32) -> Vec<u64>) -> Result<(), String> {
    let (ensembles, alpha) = (10u32, 0.5f32);
    let dealt = dealt(&[(plane(200.0, 5.0, 11), 200.0, alpha)]);
    let hands = |deal: &Deal| (0..deal.ensembles).map(|e| hand(deal, e)).collect();
    let (picture, stderr) = render_with(View::new(&wide(), WIDE), &dealt, &white(&dealt), &rule(ensembles), 0, hands);
    let alpha = f64::from(alpha);
    let variance = alpha * (1.0 - alpha) / f64::from(ensembles);
    let off = picture.rgba.iter().map(|c| (c[3] - alpha).powi(2)).sum::<f64>() / AREA;
    let said = stderr.iter().map(|e| e.x * e.x).sum::<f64>() / AREA;
    // A mean square over 1024 pixels has a relative error of sqrt(2/1024) = 4.4 %.
    let bound = 4.0 * 0.044;
    for (what, found) in [("mean square", off), ("standard error", said)] {
        if (found / variance - 1.0).abs() > bound {
            return Err(format!("{what}: {found} instead of {variance}"));
        }
    }
    let mean = mean(&picture);
    ((mean - alpha).abs() < 4.0 * (variance / AREA).sqrt()).then_some(()).ok_or(format!("mean {mean}"))
}

#[test]
fn the_variance_is_that_of_independent_ensembles() {
    judge(Deal::hand).unwrap();
    // The same points in every ensemble: the mean is right, the noise that of a single one.
    let wrong = judge(|deal, _| deal.hand(0)).unwrap_err();
    assert!(wrong.starts_with("mean square"), "{wrong}");
    // Two by two.
    let wrong = judge(|deal, e| deal.hand(e / 2)).unwrap_err();
    assert!(wrong.starts_with("mean square"), "{wrong}");
    // A tenth of the copies lost.
    judge(|deal, e| Deal { slots: deal.slots * 9 / 10, ..*deal }.hand(e)).unwrap_err();
}

#[test]
fn copies_are_dealt_to_different_ensembles() {
    // N points, M = kN copies in L parts: while k ≤ L a part is no longer than the list.
    for (points, ratio, ensembles) in
        [(7u64, 3.4, 5u32), (100, 20.0, 20), (100, 0.3, 7), (13, 9.9, 10), (5000, 90.0, 100), (100_000, 7.5, 10)]
    {
        let all = (points as f64 * ratio).round() as u64;
        let deal = Deal { points, slots: all, ensembles, place: 1, seed: 9 };
        let mut dealt = vec![0u64; points as usize];
        let mut sizes = Vec::new();
        for e in 0..ensembles {
            let mut here = deal.hand(e);
            sizes.push(here.len());
            here.iter().for_each(|&point| dealt[point as usize] += 1);
            here.sort_unstable();
            assert!(here.windows(2).all(|w| w[0] != w[1]), "twice in ensemble {e}");
        }
        assert!(sizes.iter().max().unwrap() - sizes.iter().min().unwrap() <= 1, "{sizes:?}");
        assert_eq!(dealt.iter().sum::<u64>(), all);
        // Those of the first pass one by one, in order.
        let first = deal.pass(0).ensembles;
        assert!((0..).zip(first.clone().flat_map(|e| deal.hand(e))).all(|(n, point)| n == point));
        // Hands of a pass have nothing in common.
        let Some(start) = Some(first.end).filter(|end| *end < ensembles) else { continue };
        let mut of_pass: Vec<u64> = deal.pass(start).ensembles.flat_map(|e| deal.hand(e)).collect();
        let len = of_pass.len();
        of_pass.sort_unstable();
        of_pass.dedup();
        assert_eq!(of_pass.len(), len);
    }
    // Two hands of different passes have as much in common as two at random: 500 · 500 / 5000, and a spread of 6.4.
    let deal = Deal { points: 5000, slots: 100_000, ensembles: 200, place: 0, seed: 1 };
    for (a, b) in [(0, 10), (3, 25), (12, 40), (15, 195)] {
        let (a, b) = (deal.hand(a), deal.hand(b));
        let common = a.iter().filter(|point| b.contains(point)).count();
        // Blocks of 4 points go together.
        assert!((common as f64 - 50.0).abs() < 4.0 * 2.0 * 6.4, "{common}");
    }
}
