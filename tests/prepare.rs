//! Radii against brute force, and the canonical order against shuffled input.

use glam::{DVec3, Vec3};
use indicatif::ProgressBar;
use pellucid::points::Points;
use pellucid::prepare::{order, radius};
use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

fn estimate(positions: &[DVec3], neighbors: usize) -> Vec<f32> {
    radius::estimate(positions, neighbors, &ProgressBar::hidden())
}

/// Eq. 20 as its definition says: all distances, sorted.
fn brute_force(positions: &[DVec3], neighbors: usize) -> Vec<f64> {
    let k = neighbors.min(positions.len().saturating_sub(1));
    let one = |i: usize| {
        let mut distances: Vec<f64> =
            (0..positions.len()).filter(|&j| j != i).map(|j| positions[i].distance(positions[j])).collect();
        distances.sort_by(f64::total_cmp);
        if k == 0 { 0.0 } else { 2.0 * distances[k - 1] / (k as f64).sqrt() }
    };
    (0..positions.len()).map(one).collect()
}

fn assert_close(got: &[f32], wanted: &[f64], what: &str) {
    assert_eq!(got.len(), wanted.len());
    for (i, (&g, &w)) in got.iter().zip(wanted).enumerate() {
        // One rounding to float32; the float64 ones before it are far smaller.
        assert!((f64::from(g) - w).abs() <= 2.0 * f64::from(f32::EPSILON) * w, "{what}, point {i}: {g}, not {w}");
    }
}

fn soup(count: usize, seed: u64) -> Vec<DVec3> {
    let mut rng = Pcg64Mcg::seed_from_u64(seed);
    (0..count).map(|_| DVec3::new(rng.random(), rng.random(), rng.random())).collect()
}

#[test]
fn radii_equal_brute_force() {
    let cloud = soup(700, 1);
    for neighbors in [1, 2, 24, 699, 1000] {
        assert_close(&estimate(&cloud, neighbors), &brute_force(&cloud, neighbors), &format!("K = {neighbors}"));
    }
}

#[test]
fn radii_of_lines_planes_and_grids_equal_brute_force() {
    let cloud = soup(500, 2);
    let line: Vec<_> = cloud.iter().map(|p| DVec3::new(3.0, p.y, -1.0)).collect();
    let diagonal: Vec<_> = cloud.iter().map(|p| DVec3::splat(p.x)).collect();
    let plane: Vec<_> = cloud.iter().map(|p| DVec3::new(p.x, 7.0, p.z)).collect();
    let grid: Vec<_> = cloud.iter().map(|p| (p * 5.0).floor()).collect();
    for (name, cloud) in [("line", line), ("diagonal", diagonal), ("plane", plane), ("grid", grid)] {
        assert_close(&estimate(&cloud, 24), &brute_force(&cloud, 24), name);
    }
}

#[test]
fn coincident_points_count_as_neighbors() {
    let mut cloud = soup(60, 3);
    for copies in [1, 5, 30] {
        cloud.extend(vec![cloud[copies]; copies]);
    }
    // The two zeros are one place.
    cloud.extend([DVec3::new(0.0, 0.0, 0.0), DVec3::new(-0.0, 0.0, -0.0)]);
    let radii = estimate(&cloud, 24);
    assert_close(&radii, &brute_force(&cloud, 24), "copies");
    assert_eq!(radii[30], 0.0, "31 points in one place, K = 24");
}

#[test]
fn few_and_equal_points() {
    let p = DVec3::new(5e5, 4.5e6, 100.0);
    assert!(estimate(&[], 24).is_empty());
    assert_eq!(estimate(&[p], 24), [0.0]);
    // One neighbor: K = 1, r = 2·distance.
    assert_eq!(estimate(&[p, p + 3.0 * DVec3::X], 24), [6.0, 6.0]);
    assert_eq!(estimate(&vec![p; 200_000], 24), vec![0.0; 200_000]);
    assert_eq!(estimate(&soup(5, 4), 0), [0.0; 5]);
}

#[test]
fn scale_and_place_of_the_cloud() {
    let cloud = soup(400, 5);
    let plain = estimate(&cloud, 24);
    for scale in [1000.0, 1e-30] {
        let scaled: Vec<_> = cloud.iter().map(|&p| p * scale).collect();
        let wanted: Vec<f64> = plain.iter().map(|&r| f64::from(r) * scale).collect();
        assert_close(&estimate(&scaled, 24), &wanted, &format!("scale {scale}"));
    }
    // At 4.5e6 the coordinates themselves are rounded to 9e-10 (float64), a radius of about 0.2 to 1e-8 of it.
    let moved: Vec<_> = cloud.iter().map(|&p| p + DVec3::new(5e5, 4.5e6, 100.0)).collect();
    for (&a, &b) in estimate(&moved, 24).iter().zip(&plain) {
        assert!((a - b).abs() <= 3.0 * f32::EPSILON * b, "{a}, not {b}");
    }
    // An outlier far away takes no digits from the others (ulp of 1e9: 1e-7).
    let mut outlier = cloud.clone();
    outlier.push(DVec3::splat(1e9));
    assert_close(&estimate(&outlier, 24)[..400], &brute_force(&outlier, 24)[..400], "outlier");
    // Beyond float32: finite all the same.
    let huge: Vec<_> = cloud.iter().map(|&p| p * 1e300).collect();
    assert!(estimate(&huge, 24).iter().all(|r| r.is_finite()));
}

#[test]
fn degenerate_shapes_of_many_points_are_not_slow() {
    let start = std::time::Instant::now();
    let line: Vec<_> = (0..100_000).map(|i| DVec3::new(f64::from(i), 0.0, 0.0)).collect();
    let radii = estimate(&line, 24);
    // Twelve neighbors on each side: r = 2·12/√24.
    assert!((radii[50_000] - 24.0 / 24f32.sqrt()).abs() < 1e-5, "{}", radii[50_000]);
    let plane: Vec<_> = (0..100_000).map(|i| DVec3::new(f64::from(i % 316), f64::from(i / 316), 0.0)).collect();
    assert_eq!(estimate(&plane, 24).len(), 100_000);
    // A tree that can't split these searches 10¹⁰ pairs, minutes; a working one needs about a second.
    assert!(start.elapsed().as_secs() < 30, "{:?}", start.elapsed());
}

/// Points with equal positions, colors, opacities and radii among them, so that every tie-break is used.
fn many_ties(count: usize) -> Points {
    let mut rng = Pcg64Mcg::seed_from_u64(6);
    let mut points = Points { normals: Some(Vec::new()), ..Points::default() };
    for _ in 0..count {
        let mut pick = |n: u32| rng.random_range(0..n) as f32;
        points.positions.push(DVec3::new(pick(8).into(), pick(3).into(), 4.5e6));
        points.colors.push(Vec3::new(pick(2), 0.0, pick(2)));
        points.opacities.push(pick(2) * 0.5);
        points.radii.push(pick(2));
        points.normals.as_mut().unwrap().push([Vec3::X, Vec3::ZERO, -Vec3::X][pick(3) as usize]);
    }
    points
}

fn reordered(points: &Points, order: &[usize]) -> Points {
    Points {
        positions: order.iter().map(|&i| points.positions[i]).collect(),
        colors: order.iter().map(|&i| points.colors[i]).collect(),
        opacities: order.iter().map(|&i| points.opacities[i]).collect(),
        radii: order.iter().map(|&i| points.radii[i]).collect(),
        normals: points.normals.as_ref().map(|n| order.iter().map(|&i| n[i]).collect()),
        file_order: Vec::new(),
        fields: Vec::new(),
    }
}

#[test]
fn shuffled_points_have_the_same_order() {
    let points = many_ties(5000);
    let wanted = order::canonical(points.clone());
    assert_ne!(wanted, points, "the test's points are in order already");
    let mut shuffle: Vec<usize> = (0..points.len()).collect();
    for seed in 0..3 {
        shuffle.shuffle(&mut Pcg64Mcg::seed_from_u64(seed));
        let ordered = order::canonical(reordered(&points, &shuffle));
        // Each knows where it stood in the file: the shuffled one, here.
        for (place, standing) in ordered.file_order.iter().enumerate().step_by(97) {
            assert_eq!(points.positions[shuffle[*standing as usize]], ordered.positions[place]);
        }
        assert_eq!(Points { file_order: wanted.file_order.clone(), ..ordered }, wanted);
    }
    assert_eq!(order::canonical(wanted.clone()), wanted, "sorting twice is sorting once");
}

#[test]
fn the_order_keeps_points_together_and_loses_none() {
    let points = many_ties(1000);
    let rows = |p: &Points| {
        let mut rows: Vec<_> = (0..p.len())
            .map(|i| format!("{:?} {:?} {} {}", p.positions[i], p.colors[i], p.opacities[i], p.radii[i]))
            .collect();
        rows.sort();
        rows
    };
    assert_eq!(rows(&order::canonical(points.clone())), rows(&points));
}

#[test]
fn neighbors_in_the_order_are_near() {
    let positions = soup(20_000, 7);
    let count = positions.len();
    let ordered = order::canonical(Points {
        positions,
        colors: vec![Vec3::ONE; count],
        opacities: vec![1.0; count],
        radii: vec![0.0; count],
        normals: None,
        file_order: Vec::new(),
        fields: Vec::new(),
    });
    let step: f64 = ordered.positions.windows(2).map(|w| w[0].distance(w[1])).sum::<f64>() / (count - 1) as f64;
    // Random order has a mean step of 0.66 (mean distance in a unit cube); 20 000 points are about 0.037 apart.
    assert!(step < 0.1, "{step}");
}

#[test]
fn no_points_one_point_and_equal_points() {
    assert!(order::canonical(Points::default()).is_empty());
    for count in [1, 3] {
        let points = Points {
            positions: vec![DVec3::ONE; count],
            colors: vec![Vec3::ONE; count],
            opacities: vec![1.0; count],
            radii: vec![0.0; count],
            normals: None,
            file_order: Vec::new(),
            fields: Vec::new(),
        };
        let ordered = order::canonical(points.clone());
        assert_eq!(Points { file_order: Vec::new(), ..ordered }, points);
    }
}
