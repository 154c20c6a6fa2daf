//! Radii, normals and the uncertainty field against brute force, and the canonical order against shuffled input.

use glam::{DVec3, Vec3};
use pellucid_core::points::Points;
use pellucid_core::progress::Progress;
use pellucid_reference as reference;
use pellucid_scene::prepare::surface::{self, SurfaceEstimates};
use pellucid_scene::prepare::{order, radius};
use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// Eq. 20 by itself.
fn estimate(positions: &[DVec3], neighbors: usize) -> Vec<f32> {
    capped(positions, neighbors, 0.0)
}

fn capped(positions: &[DVec3], neighbors: usize, cap: f32) -> Vec<f32> {
    radius::estimate(positions, neighbors, cap, &Progress::hidden())
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
fn degenerate_shapes_of_many_points() {
    // A tree that can't split these searches 10¹⁰ pairs.
    let line: Vec<_> = (0..100_000).map(|i| DVec3::new(f64::from(i), 0.0, 0.0)).collect();
    let radii = estimate(&line, 24);
    // Twelve neighbors on each side: r = 2·12/√24.
    assert!((radii[50_000] - 24.0 / 24f32.sqrt()).abs() < 1e-5, "{}", radii[50_000]);
    let plane: Vec<_> = (0..100_000).map(|i| DVec3::new(f64::from(i % 316), f64::from(i / 316), 0.0)).collect();
    assert_eq!(estimate(&plane, 24).len(), 100_000);
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
        points.fields.push(pick(2));
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
        fields: order.iter().map(|&i| points.fields[i]).collect(),
        ..Points::default()
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
            .map(|i| {
                format!("{:?} {:?} {} {} {}", p.positions[i], p.colors[i], p.opacities[i], p.radii[i], p.fields[i])
            })
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
        ..Points::default()
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
            ..Points::default()
        };
        let ordered = order::canonical(points.clone());
        assert_eq!(Points { file_order: Vec::new(), ..ordered }, points);
    }
}

fn surface(positions: &[DVec3], normals: Option<&[Vec3]>, neighbors: usize) -> SurfaceEstimates {
    capped_surface(positions, normals, (neighbors, 0.0))
}

fn capped_surface(positions: &[DVec3], normals: Option<&[Vec3]>, around: (usize, f32)) -> SurfaceEstimates {
    surface::estimate(positions, normals, around, &Progress::hidden())
}

/// Unit normals from a few directions, and none for every fifth point, so that neighbors tie in them too.
fn some_normals(count: usize, seed: u64) -> Vec<Vec3> {
    let mut rng = Pcg64Mcg::seed_from_u64(seed);
    let mut pick = || Vec3::from([(); 3].map(|()| rng.random_range(-1..=1) as f32)).normalize_or(Vec3::NEG_Y);
    (0..count).map(|i| if i % 5 == 0 { Vec3::ZERO } else { pick() }).collect()
}

fn assert_surface(positions: &[DVec3], normals: Option<&[Vec3]>, (neighbors, cap): (usize, f32), what: &str) {
    let got = capped_surface(positions, normals, (neighbors, cap));
    let given: Vec<DVec3> =
        normals.map_or(vec![DVec3::ZERO; positions.len()], |n| n.iter().map(|n| n.as_dvec3()).collect());
    let wanted = reference::field::surface(positions, &given, neighbors, cap.into());
    assert_close(&got.radii, &wanted.radii, what);
    assert_close(&got.uncapped, &wanted.uncapped, what);
    for (i, (planar, margin)) in got.planar.iter().zip(&wanted.planarity).enumerate() {
        let estimated = given[i] == DVec3::ZERO && got.normals[i] != Vec3::ZERO;
        let undecided = margin.abs() < 1e-6;
        assert!(undecided || *planar == (estimated && *margin > 0.0), "{what}, point {i}: {planar}, {margin}");
    }
    assert_eq!(got.radii, capped(positions, neighbors, cap), "{what}: the two ways to radii, to the bit");
    for (i, (n, m)) in got.normals.iter().zip(&wanted.normals).enumerate() {
        // Estimated normals are rounded to float32; their sign is open.
        let off = (n.as_dvec3() - *m).length().min((n.as_dvec3() + *m).length());
        assert!(off < 3e-7, "{what}, point {i}: normal {n}, not {m}");
    }
    for (i, (f, g)) in got.fields.iter().zip(&wanted.fields).enumerate() {
        // A rounded normal moves a term (2 − |cos|)² of at most 4 by at most 4·1.2e-7, and the scale as much again.
        assert!((f64::from(*f) - g).abs() < 1e-6, "{what}, point {i}: F {f}, not {g}");
    }
}

#[test]
fn the_field_equals_brute_force() {
    let cloud = soup(400, 8);
    let grid: Vec<_> = soup(600, 9).iter().map(|p| (p * 5.0).floor()).collect();
    let plane: Vec<_> = cloud.iter().map(|p| DVec3::new((p.x * 9.0).floor(), 7.0, (p.z * 9.0).floor())).collect();
    let line: Vec<_> = cloud.iter().map(|p| DVec3::new(3.0, p.y, -1.0)).collect();
    for (name, cloud) in [("soup", cloud), ("grid with copies", grid), ("plane", plane), ("line", line)] {
        let normals = some_normals(cloud.len(), 10);
        // Caps of less than 1 cut most radii, so that every median counts; an odd K has an even number of radii.
        for around in [(1, 0.0), (3, 0.75), (4, 1.0), (24, 0.0), (24, 0.5), (1000, 4.0)] {
            assert_surface(&cloud, None, around, &format!("{name}, K and cap {around:?}"));
            assert_surface(&cloud, Some(&normals), around, &format!("{name} with normals, K and cap {around:?}"));
        }
    }
}

#[test]
fn the_comparison_with_brute_force_can_fail() {
    let cloud = soup(50, 11);
    let wrong = std::panic::catch_unwind(|| {
        let got = surface(&cloud, None, 6);
        let wanted = reference::field::surface(&cloud, &[DVec3::ZERO; 50], 7, 0.0);
        assert_close(&got.fields, &wanted.fields, "another K");
    });
    assert!(wrong.is_err());
}

#[test]
fn shuffled_points_have_the_same_field_to_the_bit() {
    // A grid with copies: distances, positions and normals tie, at the K-th neighbor too.
    let positions: Vec<_> =
        soup(3000, 12).iter().map(|p| (p * 8.0).floor() * 0.1 + DVec3::new(5e5, 4.5e6, 0.0)).collect();
    for normals in [Some(some_normals(3000, 13)), None] {
        let wanted = surface(&positions, normals.as_deref(), 24);
        let mut shuffle: Vec<usize> = (0..3000).collect();
        shuffle.shuffle(&mut Pcg64Mcg::seed_from_u64(14));
        let moved: Vec<_> = shuffle.iter().map(|&i| positions[i]).collect();
        let turned: Option<Vec<_>> = normals.map(|normals| shuffle.iter().map(|&i| normals[i]).collect());
        let got = surface(&moved, turned.as_deref(), 24);
        for (place, &i) in shuffle.iter().enumerate() {
            assert_eq!(got.fields[place].to_bits(), wanted.fields[i].to_bits());
            assert_eq!((got.radii[place], got.normals[place]), (wanted.radii[i], wanted.normals[i]));
        }
        // Nor does it matter which way normals point.
        if let Some(turned) = turned {
            let flipped: Vec<_> = turned.iter().enumerate().map(|(i, n)| if i % 3 == 0 { -*n } else { *n }).collect();
            assert_eq!(surface(&moved, Some(&flipped), 24).fields, got.fields);
        }
    }
}

#[test]
fn scale_and_place_change_no_field() {
    let cloud = soup(500, 15);
    let plain = surface(&cloud, None, 24);
    for (scale, offset) in [(1000.0, DVec3::ZERO), (1e-3, DVec3::ONE), (1.0, DVec3::new(5e5, 4.5e6, 100.0))] {
        let moved: Vec<_> = cloud.iter().map(|&p| p * scale + offset).collect();
        let got = surface(&moved, None, 24);
        for i in 0..500 {
            // At 4.5e6 coordinates are rounded to 9e-10, neighbors are 0.1 apart.
            assert!((got.fields[i] - plain.fields[i]).abs() < 1e-6, "{scale}: {} {}", got.fields[i], plain.fields[i]);
            let wanted = plain.radii[i] * scale as f32;
            assert!((got.radii[i] - wanted).abs() <= 1e-6 * wanted, "{scale}");
        }
    }
    // Beyond float32, and near the end of float64.
    for scale in [1e-200, 1e60, 1e300] {
        let moved: Vec<_> = cloud.iter().map(|&p| p * scale).collect();
        let got = surface(&moved, None, 24);
        assert!(got.fields.iter().zip(&plain.fields).all(|(a, b)| (a - b).abs() < 1e-6), "{scale}");
    }
}

#[test]
fn a_plane_is_certain_and_noise_is_uncertain() {
    // Around a torus of rows: every point of a closed ring has the same neighborhood.
    let ring: Vec<_> = (0..500)
        .map(|i| {
            DVec3::new(
                0.0,
                (f64::from(i) * std::f64::consts::TAU / 500.0).sin(),
                (f64::from(i) * std::f64::consts::TAU / 500.0).cos(),
            )
        })
        .collect();
    assert_eq!(surface(&ring, None, 24).fields, [0.0; 500], "equal but for rounding");

    let mut rng = Pcg64Mcg::seed_from_u64(16);
    let mut cloud: Vec<_> = (0..4000).map(|_| DVec3::new(rng.random(), rng.random(), 0.0) * 10.0).collect();
    cloud.extend((0..200).map(|_| DVec3::new(rng.random(), rng.random(), 0.1 + rng.random::<f64>()) * 10.0));
    let fields = surface(&cloud, None, 24).fields;
    let mean = |fields: &[f32]| fields.iter().sum::<f32>() / fields.len() as f32;
    let (plane, noise) = fields.split_at(4000);
    assert!(mean(noise) > 5.0 * mean(plane), "{} {}", mean(noise), mean(plane));
    let least = noise.iter().copied().fold(1.0, f32::min);
    // As uncertain as the nearest noise is only a point that has noise among its neighbors.
    for (point, _) in plane.iter().enumerate().filter(|(_, field)| **field > least) {
        let mut others: Vec<usize> = (0..cloud.len()).filter(|other| *other != point).collect();
        others.sort_by(|a, b| cloud[*a].distance(cloud[point]).total_cmp(&cloud[*b].distance(cloud[point])));
        let has_noise = others[..24].iter().any(|other| *other >= plane.len());
        assert!(has_noise, "{}: {}, above {least}", cloud[point], plane[point]);
    }
}

#[test]
fn fields_of_few_and_equal_points() {
    let p = DVec3::new(5e5, 4.5e6, 100.0);
    assert!(surface(&[], None, 24).fields.is_empty());
    assert_eq!(surface(&[p], None, 24).fields, [0.0]);
    assert_eq!(
        surface(&[p, p + DVec3::X], None, 24),
        SurfaceEstimates {
            radii: vec![2.0; 2],
            uncapped: vec![2.0; 2],
            normals: vec![Vec3::ZERO; 2],
            planar: vec![false; 2],
            fields: vec![0.0; 2]
        }
    );
    let equal = surface(&vec![p; 10_000], None, 24);
    assert_eq!((equal.fields, equal.radii), (vec![0.0; 10_000], vec![0.0; 10_000]));
    // Coincident with as many others as K: radius 0, certain; the two apart are as uncertain as each other.
    let cloud = [vec![p; 5], vec![p + DVec3::X, p - DVec3::X]].concat();
    assert_eq!(surface(&cloud, None, 4).fields, [0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0]);
}

#[test]
fn normals_of_a_sphere_are_estimated_and_given_ones_kept() {
    let cloud: Vec<_> = soup(5000, 17).iter().map(|p| (p - 0.5).normalize() + DVec3::new(5e5, 4.5e6, 0.0)).collect();
    let mut given = vec![Vec3::ZERO; 5000];
    given[7] = Vec3::X;
    let got = surface(&cloud, Some(&given), 24);
    assert_eq!(got.normals[7], Vec3::X);
    let center = DVec3::new(5e5, 4.5e6, 0.0);
    for (i, (p, n)) in cloud.iter().zip(&got.normals).enumerate().filter(|(i, _)| *i != 7) {
        // 24 neighbors reach 0.14 far; uneven ones tilt the plane by a part of that.
        assert!(n.as_dvec3().dot(*p - center).abs() > 0.98, "{i}: {n}");
        assert!((n.length() - 1.0).abs() < 1e-6);
    }
}

#[test]
fn plants_of_the_garden_are_less_certain_than_the_house() {
    let garden = pellucid_scene::procedural::build("garden", &[("points".to_owned(), 100_000.0)], 0).unwrap();
    let soft = |name: &str| {
        let (_, cloud) = garden.clouds.iter().find(|(cloud, _)| cloud == name).expect(name);
        let fields = surface(&cloud.positions, cloud.normals.as_deref(), 24).fields;
        fields.iter().filter(|f| **f > 0.1).count() as f64 / fields.len() as f64
    };
    let (plants, built) = (["leaves.ply", "wood.ply"].map(soft), ["structure.ply", "ground.ply"].map(soft));
    // With five times the points it is 61% and more against 3% and less.
    let [least, most] = [plants[0].min(plants[1]), built[0].max(built[1])];
    assert!(least > 2.0 * most, "soft for a threshold of 0.1: plants {plants:?}, house and ground {built:?}");
}
