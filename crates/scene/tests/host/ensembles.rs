//! The order that ensembles are drawn from, and the density of surfaces by counting spheres.

use std::f64::consts::{PI, TAU};

use glam::{DMat3, DVec3, Vec3};
use pellucid_core::progress::Progress;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use pellucid_core::points::Points;
use pellucid_scene::prepare::ensembles::{Dealt, deal, slots};

fn random(seed: u64) -> Pcg64Mcg {
    Pcg64Mcg::seed_from_u64(seed)
}

/// White points, each with an opacity of a half.
fn cloud(positions: Vec<DVec3>) -> Points {
    let count = positions.len();
    Points {
        positions,
        colors: vec![Vec3::ONE; count],
        opacities: vec![0.5; count],
        radii: vec![0.0; count],
        ..Points::default()
    }
}

fn dealt(clouds: Vec<Points>, seed: u64) -> Dealt {
    deal(clouds, seed, &Progress::hidden())
}

fn density(positions: &[DVec3]) -> f64 {
    let dealt = dealt(vec![cloud(positions.to_vec())], 1);
    assert_eq!(dealt.surfaces.len(), 1);
    dealt.surfaces[0].density
}

/// Density as the paper has it, rims, centers and all: every sphere's points, its center among them, over its great
/// circle.
fn uncorrected(positions: &[DVec3]) -> f64 {
    let bounds = pellucid_core::cloud::Bounds::enclosing(positions.iter().copied()).unwrap();
    let radius = bounds.diagonal() / 50.0;
    let step = positions.len().div_ceil(1000);
    let centers: Vec<DVec3> = positions.iter().copied().step_by(step).collect();
    let within = |c: &DVec3| positions.iter().filter(|p| p.distance_squared(*c) < radius * radius).count();
    centers.iter().map(within).sum::<usize>() as f64 / centers.len() as f64 / (PI * radius * radius)
}

/// Asserts both densities over the true one, less 1; printed, and the corrected one bounded.
#[track_caller]
fn assert_density(name: &str, positions: &[DVec3], wanted: f64, bound: f64) {
    let (found, raw) = (density(positions) / wanted - 1.0, uncorrected(positions) / wanted - 1.0);
    println!("{name}: {:+.2} % (uncorrected {:+.2} %), {} points", 100.0 * found, 100.0 * raw, positions.len());
    assert!(found.abs() < bound, "{name}: {found:+.4}, not within {bound}");
}

fn rectangle(count: usize, width: f64, height: f64, seed: u64) -> Vec<DVec3> {
    let mut random = random(seed);
    let mut point = || DVec3::new(random.random_range(0.0..width), random.random_range(0.0..height), 0.0);
    (0..count).map(|_| point()).collect()
}

fn disc(count: usize, seed: u64) -> Vec<DVec3> {
    let mut random = random(seed);
    let mut point = || {
        let (r, angle) = (random.random_range(0.0f64..1.0).sqrt(), random.random_range(0.0..TAU));
        DVec3::new(r * angle.cos(), r * angle.sin(), 0.0)
    };
    (0..count).map(|_| point()).collect()
}

fn sphere(count: usize, seed: u64) -> Vec<DVec3> {
    let mut random = random(seed);
    let mut point = || {
        let (z, angle) = (random.random_range(-1.0f64..1.0), random.random_range(0.0..TAU));
        let r = (1.0 - z * z).sqrt();
        DVec3::new(r * angle.cos(), r * angle.sin(), z)
    };
    (0..count).map(|_| point()).collect()
}

#[test]
fn squares_of_random_points() {
    // Pairs of points in the spheres say how far chance goes: with a few thousand points it is some percent.
    for (count, bound) in [(1000, 0.12), (10_000, 0.04), (100_000, 0.01), (400_000, 0.01)] {
        assert_density("square", &rectangle(count, 1.0, 1.0, 2), count as f64, bound);
    }
}

#[test]
fn discs_spheres_and_strips() {
    assert_density("disc", &disc(100_000, 3), 100_000.0 / PI, 0.01);
    assert_density("sphere", &sphere(100_000, 4), 100_000.0 / (4.0 * PI), 0.01);
    // R is 0.02 of the length: a strip twice as wide, as wide, and a fifth of that.
    for (width, bound) in [(0.04, 0.01), (0.02, 0.02), (0.004, 0.05)] {
        assert_density(&format!("strip {width}"), &rectangle(100_000, 1.0, width, 5), 100_000.0 / width, bound);
    }
}

#[test]
fn a_grid_of_points() {
    for side in [50, 100, 300] {
        let step = 1.0 / f64::from(side);
        let grid = (0..side * side).map(|i| DVec3::new(f64::from(i % side) * step, f64::from(i / side) * step, 0.0));
        // Points on the outer rows stand for cells that reach beyond the rim: the square's area is side², not (side −
        // 1)².
        assert_density(&format!("grid {side}"), &grid.collect::<Vec<_>>(), f64::from(side * side), 0.04);
    }
}

#[test]
fn points_that_keep_their_distance_and_points_measured_twice() {
    // One point anywhere in each cell but near its rim.
    let mut random = random(15);
    let mut jitter = || random.random_range(0.2..0.8);
    let thinned = (0..90_000).map(|i| DVec3::new(f64::from(i % 300) + jitter(), f64::from(i / 300) + jitter(), 0.0));
    assert_density("thinned", &thinned.collect::<Vec<_>>(), 1.0, 0.01);
    let mut twice = rectangle(20_000, 1.0, 1.0, 16);
    twice.extend(twice.clone());
    // Twice as large a variance as that of single points.
    assert_density("twice", &twice, 40_000.0, 0.03);
}

#[test]
fn a_turned_scaled_and_moved_cloud() {
    let flat = rectangle(50_000, 1.0, 1.0, 6);
    let upright = density(&flat);
    for axis in [DVec3::X, DVec3::new(0.3, -0.7, 0.5)] {
        let turn = DMat3::from_axis_angle(axis.normalize(), 0.8);
        // Another box has another radius.
        assert_density("turned", &flat.iter().map(|&p| turn * p).collect::<Vec<_>>(), 50_000.0, 0.015);
    }
    let scaled = density(&flat.iter().map(|&p| 1024.0 * p).collect::<Vec<_>>());
    assert!((scaled * 1024.0 * 1024.0 / upright - 1.0).abs() < 1e-9, "{scaled} {upright}");
    // Float64 has steps of 10⁻⁹ out there: rounded places are others, and so are the centers that are chosen.
    let moved = density(&flat.iter().map(|&p| p + DVec3::new(5e5, 4.5e6, 100.0)).collect::<Vec<_>>());
    assert!((moved / upright - 1.0).abs() < 2e-3, "{moved} {upright}");
}

#[test]
fn sheets_are_told_apart_unless_they_nearly_touch() {
    // R is 0.028 here.
    for (gap, sheets, bound) in [(0.02, 1.0, 0.02), (0.01, 1.0, 0.02), (0.005, 2.0, 0.1), (1e-4, 2.0, 0.02)] {
        let mut points = rectangle(200_000, 1.0, 1.0, 7);
        points.extend(rectangle(200_000, 1.0, 1.0, 8).into_iter().map(|p| p + gap * DVec3::Z));
        assert_density(&format!("sheets {gap} apart"), &points, 200_000.0 * sheets, bound);
    }
}

#[test]
fn a_rough_surface_is_seen_from_afar() {
    let mut random = random(9);
    for (thickness, bound) in [(0.001, 0.02), (0.005, 0.05)] {
        let mut rough = rectangle(400_000, 1.0, 1.0, 10);
        rough.iter_mut().for_each(|p| p.z = random.random_range(0.0..thickness));
        assert_density(&format!("thickness {thickness}"), &rough, 400_000.0, bound);
    }
}

#[test]
fn a_volume_has_about_what_the_paper_says() {
    let mut random = random(11);
    let mut volume = rectangle(100_000, 1.0, 1.0, 12);
    volume.iter_mut().for_each(|p| p.z = random.random_range(0.0..1.0));
    // A ball of radius R over its great circle; the mean over spheres up to that size is 4/5 of it.
    let radius = 3f64.sqrt() / 50.0;
    assert_density("volume", &volume, 100_000.0 * 4.0 / 3.0 * radius, 0.3);
}

#[test]
fn outliers_widen_the_spheres_but_not_beyond_use() {
    for distance in [10.0, 100.0] {
        let mut points = rectangle(100_000, 1.0, 1.0, 13);
        points.extend([DVec3::splat(distance), DVec3::new(-distance, 0.0, distance)]);
        // The sphere of a fiftieth of the diagonal swallows the whole square.
        assert_density(&format!("outliers {distance} away"), &points, 100_000.0, 0.03);
    }
}

#[test]
fn degenerate_clouds_have_no_density_or_a_finite_one() {
    let p = DVec3::new(5e5, 4.5e6, 100.0);
    assert_eq!(density(&[p]), 0.0);
    assert_eq!(density(&[p, p]), 0.0);
    assert_eq!(density(&vec![p; 70_000]), 0.0);
    // No sphere around one reaches the other.
    assert_eq!(density(&[p, p + DVec3::X]), 0.0);
    assert!(dealt(vec![], 0).surfaces.is_empty());
    let none = dealt(vec![cloud(vec![]), cloud(vec![p]), cloud(vec![])], 0);
    assert_eq!((none.surfaces.len(), none.surfaces[0].points.clone()), (1, 0..1));
    let finite = |name: &str, positions: &[DVec3]| {
        let density = density(positions);
        assert!(density.is_finite() && density >= 0.0, "{name}: {density}");
    };
    finite("line", &(0..2000).map(|i| p + f64::from(i) * DVec3::new(1.0, 2.0, 3.0)).collect::<Vec<_>>());
    finite("duplicates", &(0..2000).map(|i| DVec3::X * f64::from(i / 1000)).collect::<Vec<_>>());
    let huge = rectangle(2000, 1.0, 1.0, 14);
    finite("huge", &huge.iter().map(|&q| (2.0 * q - 1.0) * 1.7e308).collect::<Vec<_>>());
    finite("tiny", &huge.iter().map(|&q| q * 1e-300).collect::<Vec<_>>());
    finite("denormal", &huge.iter().map(|&q| q * 1e-320).collect::<Vec<_>>());
    finite("far", &[DVec3::splat(-1.7e308), DVec3::ZERO, DVec3::splat(1.7e308)]);
}

/// The points as comparable rows.
fn rows(points: &Points) -> Vec<([u64; 3], [u32; 3], u32)> {
    (0..points.len())
        .map(|i| {
            let position = points.positions[i].to_array().map(f64::to_bits);
            (position, points.colors[i].to_array().map(f32::to_bits), points.opacities[i].to_bits())
        })
        .collect()
}

fn colored(count: usize, seed: u64) -> Points {
    let mut random = random(seed);
    let mut points = cloud(rectangle(count, 1.0, 1.0, seed));
    points.opacities = (0..count).map(|_| random.random_range(0.0..0.8)).collect();
    points.colors = points.opacities.iter().map(|alpha| Vec3::splat(*alpha)).collect();
    points
}

#[test]
fn a_shuffle_keeps_the_points_and_follows_from_the_seed_alone() {
    let points = colored(5000, 20);
    let one = dealt(vec![points.clone()], 7);
    let sorted = |points: &Points| {
        let mut rows = rows(points);
        rows.sort_unstable();
        rows
    };
    assert_eq!(sorted(&one.points), sorted(&points));
    assert!(one.points.file_order.is_empty());
    let largest = points.opacities.iter().copied().fold(0.0, f32::max);
    assert_eq!((one.surfaces[0].opacity, one.surfaces[0].points.clone()), (largest, 0..5000));
    // The file's order has no effect, the seed has, both of its words.
    let mut backward = points.clone();
    backward.positions.reverse();
    backward.colors.reverse();
    backward.opacities.reverse();
    assert_eq!(dealt(vec![backward], 7), one);
    for other in [8, 7 + (1 << 32)] {
        assert_ne!(rows(&dealt(vec![points.clone()], other).points), rows(&one.points));
    }
    // The first words are those of Threefry, so that every machine has them.
    assert_ne!(rows(&one.points), rows(&pellucid_scene::prepare::order::canonical(points)));
}

#[test]
fn shuffled_again_it_is_another_order_of_the_same_clouds() {
    let one = dealt(vec![colored(500, 23), colored(300, 24)], 7);
    let other = one.again(8);
    assert_eq!(other.surfaces, one.surfaces);
    assert_eq!(one.again(8), other);
    let sorted = |dealt: &Dealt, range: std::ops::Range<usize>| {
        let mut rows = rows(&dealt.points)[range].to_vec();
        rows.sort_unstable();
        rows
    };
    for range in [0..500, 500..800] {
        assert_ne!(rows(&one.points)[range.clone()], rows(&other.points)[range.clone()]);
        assert_eq!(sorted(&one, range.clone()), sorted(&other, range));
    }
}

#[test]
fn the_order_is_random() {
    // Points along a line: the mean of the first half, and neighbors in the list, have nothing to do with each other.
    let count = 100_000usize;
    let line = (0..count).map(|i| DVec3::X * (i as f64 / count as f64 - 0.5)).collect();
    let found = dealt(vec![cloud(line)], 3).points.positions.clone();
    let half: f64 = found[..count / 2].iter().map(|p| p.x).sum::<f64>() / (count / 2) as f64;
    // Variance 1/12; half of all without replacement has half of that.
    assert!(half.abs() < 4.0 * (1.0 / 12.0 / count as f64).sqrt(), "{half}");
    let lag: f64 = found.windows(2).map(|w| w[0].x * w[1].x).sum::<f64>() / count as f64 * 12.0;
    assert!(lag.abs() < 4.0 / (count as f64).sqrt(), "{lag}");
}

#[test]
fn clouds_stay_apart_and_have_orders_of_their_own() {
    let (a, b) = (colored(3000, 21), colored(1000, 22));
    let both = dealt(vec![a.clone(), b.clone(), a.clone()], 5);
    let ranges: Vec<_> = both.surfaces.iter().map(|s| s.points.clone()).collect();
    assert_eq!(ranges, [0..3000, 3000..4000, 4000..7000]);
    let all = rows(&both.points);
    // The first cloud is as it is alone; a second copy of it lies in another order, or both would be dealt alike.
    assert_eq!(all[..3000], rows(&dealt(vec![a], 5).points));
    assert_ne!(all[..3000], all[4000..]);
    // Normals of one are zeros for the other.
    let mut with = b.clone();
    with.normals = Some(vec![Vec3::Z; 1000]);
    let mixed = dealt(vec![b, with], 5).points.normals.clone().unwrap();
    assert!(mixed[..1000].iter().all(|n| *n == Vec3::ZERO) && mixed[1000..].iter().all(|n| *n == Vec3::Z));
}

#[test]
fn slots_cover_everything_once_in_parts_of_nearly_one_size() {
    for (all, ensembles) in [(0u64, 3u32), (1, 1), (2, 7), (1000, 7), (1001, 1000), (u64::MAX, 65_536)] {
        let mut next = 0;
        for e in 0..ensembles {
            let part = slots(all, ensembles, e);
            assert_eq!(part.start, next);
            let size = part.end - part.start;
            let mean = all / u64::from(ensembles);
            assert!(size == mean || size == mean + 1, "{all} in {ensembles}: {size}");
            next = part.end;
        }
        assert_eq!(next, all);
    }
}
