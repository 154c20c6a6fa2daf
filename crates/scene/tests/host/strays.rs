//! Points that stand apart: caps of radii and outliers against brute force, on clean clouds, and in scenes.

use glam::DVec3;
use pellucid_core::cloud::Cloud;
use pellucid_core::progress::Progress;
use pellucid_reference as reference;
use pellucid_scene::prepare::outliers::{self, Rule};
use pellucid_scene::prepare::radius::{self, DEFAULT_CAP};
use pellucid_scene::tracked::{DerivedColumns, Tracked};
use pellucid_scene::{self as scene, Document, Overrides, Scene, procedural};
use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

fn radii(positions: &[DVec3], cap: f32) -> Vec<f32> {
    radius::estimate(positions, 24, cap, &Progress::hidden())
}

fn marks(positions: &[DVec3], k: usize, factor: f32) -> Vec<bool> {
    outliers::find(positions, Rule { k, factor }, &Progress::hidden())
}

/// A plane of points at random, with some far above it.
fn with_strays(count: usize, strays: usize) -> Vec<DVec3> {
    let mut rng = Pcg64Mcg::seed_from_u64(count as u64);
    let plane = (0..count).map(|_| DVec3::new(rng.random(), rng.random(), 0.0)).collect::<Vec<_>>();
    let above = (0..strays).map(|i| DVec3::new(0.3, 0.1, 1.0 + i as f64)).collect::<Vec<_>>();
    [plane, above].concat()
}

#[test]
fn a_stray_gets_a_radius_like_those_around_it() {
    let cloud = with_strays(2000, 3);
    let (plain, capped) = (radii(&cloud, 0.0), radii(&cloud, DEFAULT_CAP));
    // Its 24 neighbors are in the plane or outliers, 22 at least in the plane, where distances are below 0.2: the
    // square around a point, of 0.1² in a corner, holds 20 points of 2000 on average, of 0.2² 80.
    let largest = plain[..2000].iter().fold(0f32, |most, r| most.max(*r));
    for stray in 2000..2003 {
        assert!(plain[stray] > 0.4, "{}", plain[stray]);
        assert!(capped[stray] <= 4.0 * largest, "{}, of {largest} in the plane", capped[stray]);
    }
    assert_eq!(plain[..2000], capped[..2000]);
}

#[test]
fn a_far_stray_hides_no_nearer_one() {
    let grid = (0..2500).map(|i| DVec3::new(f64::from(i % 50), f64::from(i / 50), 0.0));
    let near = [1.0, 2.0, 3.0, 4.0, 5.0].map(|i| DVec3::new(3000.0 * i, 0.0, 2000.0));
    for far in [vec![], vec![DVec3::splat(1e8)], vec![DVec3::splat(f64::from(f32::MAX)), DVec3::splat(-1e12)]] {
        let cloud: Vec<_> = grid.clone().chain(near).chain(far.iter().copied()).collect();
        let found = marks(&cloud, 16, 3.0);
        assert!(found[2500..].iter().all(|is_one| *is_one), "{far:?}");
        assert_eq!(outliers::count(&found), 5 + far.len(), "{far:?}");
    }
}

/// A chain by hand: K = 1, so that a radius is twice the distance, and the median of two radii their mean.
#[test]
fn caps_by_hand() {
    let cloud: Vec<DVec3> = [0.0, 1.0, 9.0].map(|x| DVec3::new(x, 0.0, 0.0)).to_vec();
    let estimate = |cap| radius::estimate(&cloud, 1, cap, &Progress::hidden());
    assert_eq!(estimate(0.0), [2.0, 2.0, 16.0]);
    // 9's neighbor is 1: the median of 16 and 2 is 9.
    assert_eq!(estimate(1.0), [2.0, 2.0, 9.0]);
    assert_eq!(estimate(0.5), [1.0, 1.0, 4.5]);
    assert_eq!(estimate(4.0), [2.0, 2.0, 16.0]);
}

#[test]
fn no_radius_of_clean_clouds_changes() {
    // `garden` is a scan, with noise and with a point alone in a shadow of it; leaves of `terrain` stand alone.
    let is_clean = |name: &&str| !["garden", "terrain"].contains(name);
    for name in procedural::BUILTINS.iter().map(|scene| scene.name).filter(is_clean) {
        let generated = procedural::build(name, &[], 0).unwrap();
        for (cloud_name, cloud) in &generated.clouds {
            let changed = radii(&cloud.positions, 0.0)
                .iter()
                .zip(radii(&cloud.positions, DEFAULT_CAP))
                .filter(|(plain, capped)| plain.to_bits() != capped.to_bits())
                .count();
            assert_eq!(changed, 0, "{name}/{cloud_name} of {} points", cloud.len());
        }
    }
}

#[test]
fn shuffled_points_have_the_same_strays_to_the_bit() {
    // A grid with copies, so that distances tie.
    let cloud: Vec<_> = with_strays(3000, 5).iter().map(|p| (p * 20.0).floor() * 0.1).collect();
    let (wanted_radii, wanted_marks) = (radii(&cloud, 1.0), marks(&cloud, 16, 1.0));
    assert!(wanted_marks.contains(&true) && wanted_marks.contains(&false));
    let mut shuffle: Vec<usize> = (0..cloud.len()).collect();
    shuffle.shuffle(&mut Pcg64Mcg::seed_from_u64(3));
    let moved: Vec<_> = shuffle.iter().map(|&i| cloud[i]).collect();
    let (radii, marks) = (radii(&moved, 1.0), marks(&moved, 16, 1.0));
    for (place, &i) in shuffle.iter().enumerate() {
        assert_eq!((radii[place].to_bits(), marks[place]), (wanted_radii[i].to_bits(), wanted_marks[i]));
    }
}

#[test]
fn outliers_equal_brute_force() {
    let grid: Vec<_> = with_strays(500, 4).iter().map(|p| (p * 8.0).floor()).collect();
    for (name, cloud) in [("plane", with_strays(600, 7)), ("grid with copies", grid)] {
        for (k, factor) in [(1, 0.0), (2, 1.0), (16, 3.0), (1000, 0.5)] {
            let above = reference::field::outlying(&cloud, k, factor.into());
            for (i, (mark, above)) in marks(&cloud, k, factor).into_iter().zip(above).enumerate() {
                // Nearer than that, rounding decides, or the 10⁻⁹ that count as rounding do.
                let decided = above.abs() > 2e-9;
                assert!(!decided || mark == (above > 0.0), "{name}, k = {k}, factor {factor}, point {i}: {above}");
            }
        }
    }
}

/// Five points: four in a square of side 1, one 3 away from its corner.
#[test]
fn outliers_by_hand() {
    let at = |x: f64, y: f64| DVec3::new(x, y, 0.0);
    let cloud = [at(0.0, 0.0), at(1.0, 0.0), at(0.0, 1.0), at(1.0, 1.0), at(4.0, 1.0)];
    // k = 1: distances 1, 1, 1, 1, 3: mean 1.4, deviation √(4·0.16 + 2.56)/√4 = 0.894. 3 > 1.4 + 1.78·0.894 = 2.99.
    assert_eq!(marks(&cloud, 1, 1.78), [false, false, false, false, true]);
    // 1.4 + 1.8·0.894 = 3.01; of a whole population the deviation were 0.8, and 3 above 1.4 + 1.8·0.8 = 2.84.
    assert_eq!(marks(&cloud, 1, 1.8), [false; 5]);
}

#[test]
fn few_equal_and_even_points_have_no_outliers() {
    assert!(marks(&[], 16, 3.0).is_empty());
    assert_eq!(marks(&[DVec3::ONE], 16, 0.0), [false]);
    assert_eq!(marks(&[DVec3::ONE, DVec3::ZERO], 16, 0.0), [false; 2]);
    assert_eq!(marks(&[DVec3::ONE; 50], 16, 0.0), [false; 50]);
    let angle = |i: i32| f64::from(i) * std::f64::consts::TAU / 500.0;
    let ring: Vec<_> = (0..500).map(|i| DVec3::new(0.0, angle(i).sin(), angle(i).cos())).collect();
    assert_eq!(marks(&ring, 16, 0.0), [false; 500], "equal but for rounding");
}

fn read(text: &str) -> Scene {
    let text = format!("[method]\nname = 'soft-base'\n[[cloud]]\npath = 'a.ply'\nfield = 'x'\n{text}");
    Document::from_toml(&text, "s.toml".as_ref(), &Overrides::default()).unwrap().scene().unwrap()
}

fn tracked(scene: &Scene, cloud: &Cloud, derived: &mut [DerivedColumns]) -> Tracked {
    Tracked::new(scene, std::slice::from_ref(cloud), derived, 0, &Progress::hidden()).unwrap()
}

#[test]
fn outliers_are_kept_soft_or_dropped() {
    let cloud = Cloud { positions: with_strays(400, 2), ..Cloud::default() };
    let assembled = |text: &str| scene::assemble(&read(text), vec![cloud.clone()], true, &Progress::hidden()).unwrap();
    let (kept, soft, dropped) = (assembled(""), assembled("outliers = 'soft'"), assembled("outliers = 'drop'"));
    let is_stray = |p: &DVec3| p.z > 0.0;
    assert_eq!(kept.positions.iter().filter(|p| is_stray(p)).count(), 2);
    assert_eq!(kept.positions, soft.positions);
    for (i, position) in soft.positions.iter().enumerate() {
        let wanted = if is_stray(position) { 1.0 } else { kept.fields[i] };
        assert_eq!(soft.fields[i], wanted);
    }
    let wanted: Vec<_> = kept.positions.iter().copied().filter(|p| !is_stray(p)).collect();
    assert_eq!(dropped.positions.len(), wanted.len());
    assert!(!dropped.positions.iter().any(is_stray));
    assert_eq!(dropped.bounds().unwrap().max.z, 0.0, "framed without them");
    // An edited scene goes through all of them.
    let derived = &mut [DerivedColumns::default()];
    let mut edited = tracked(&read(""), &cloud, derived);
    let changed = |edited: &mut Tracked, text: &str, derived: &mut [DerivedColumns]| {
        edited.follow(&read(text), std::slice::from_ref(&cloud), derived, &Progress::hidden()).unwrap()
    };
    assert!(changed(&mut edited, "outliers = 'soft'", derived).is_some_and(|changes| changes.fields));
    assert_eq!(*edited.points(), soft);
    assert_eq!(changed(&mut edited, "outliers = 'drop'", derived), None, "points would move");
    let mut edited = tracked(&read("outliers = 'drop'"), &cloud, derived);
    assert_eq!(*edited.points(), dropped);
    assert!(changed(&mut edited, "outliers = 'drop'\nradius_cap = 0.5", derived).is_some_and(|changes| changes.radii));
    assert_eq!(*edited.points(), assembled("outliers = 'drop'\nradius_cap = 0.5"));
}
