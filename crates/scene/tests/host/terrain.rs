//! Landscapes in tiles: the same points however they are asked for, as many as promised, each in its own tile.

use std::collections::{BTreeMap, HashSet};

use glam::DVec3;
use pellucid_core::cloud::{Bounds, Cloud};
use pellucid_io::store::build::Cell;
use pellucid_io::store::{Piece, Store};
use pellucid_scene::procedural::{Error, build, terrain::Terrain};
use rayon::prelude::*;

fn tiles(terrain: &Terrain) -> Vec<Piece> {
    (0..terrain.nodes().len()).into_par_iter().map(|tile| terrain.read(tile).unwrap()).collect()
}

/// A coordinate on the grid of millimeters, as LAS files hold it.
fn millimeters(p: &DVec3) -> [i64; 3] {
    let grid = (*p * 1000.0).round();
    assert_eq!(grid * 0.001, *p, "not on the grid");
    grid.to_array().map(|value| value as i64)
}

#[test]
fn tiles_hold_what_is_promised() {
    for (points, seed) in [(10_000, 0), (70_000, 1), (600_000, 2)] {
        let terrain = Terrain::new(points, seed).unwrap();
        let (summary, nodes) = (terrain.summary(), terrain.nodes());
        assert_eq!(nodes.iter().map(|node| node.points).sum::<u64>(), points);
        let mut next = 0;
        for (piece, node) in tiles(&terrain).iter().zip(nodes) {
            assert_eq!((piece.cloud.len() as u64, piece.places.len() as u64), (node.points, node.points));
            assert!(piece.places.iter().all(|place| {
                next += 1;
                *place + 1 == next
            }));
            for p in &piece.cloud.positions {
                let inside = p.cmpge(node.bounds.min).all() && p.cmple(node.bounds.max).all();
                assert!(inside && summary.bounds.union(node.bounds) == summary.bounds, "{p} of {node:?}");
            }
            assert_eq!(piece.cloud.subset(&[]), summary.like);
        }
    }
}

#[test]
fn a_tile_needs_no_other() {
    let terrain = Terrain::new(150_000, 5).unwrap();
    let forward = tiles(&terrain);
    for tile in [forward.len() - 1, 1, 2, 0] {
        assert!(terrain.read(tile).unwrap() == forward[tile]);
        assert!(Terrain::new(150_000, 5).unwrap().read(tile).unwrap() == forward[tile]);
        assert!(Terrain::new(150_000, 6).unwrap().read(tile).unwrap() != forward[tile]);
    }
    // The scene is its tiles, rounded to what a PLY file holds.
    let scene = build("terrain", &[("points".to_owned(), 150_000.0)], 5).unwrap();
    let [(_, cloud)] = scene.clouds.as_slice() else { panic!("one cloud") };
    let all: Vec<DVec3> = forward.iter().flat_map(|piece| piece.cloud.positions.clone()).collect();
    assert!(cloud.positions.iter().zip(&all).all(|(p, q)| *p == q.as_vec3().as_dvec3()) && cloud.len() == all.len());
}

#[test]
fn tiles_are_columns_of_an_octree_and_share_no_point() {
    for points in [150_000, 2_000_000] {
        let terrain = Terrain::new(points, 3).unwrap();
        let cube = terrain.cube().bounds(Cell::ROOT);
        let columns = (terrain.nodes().len() as f64).sqrt();
        let side = terrain.side() / columns;
        // A cell of some level is as large.
        let levels = ((cube.max.x - cube.min.x) / side).log2();
        assert!((levels - levels.round()).abs() < 1e-9, "{levels}");
        // 4.472 ∛n, rounded to whole tiles of at most a twelfth.
        assert!((terrain.side() / (4.472 * (points as f64).cbrt()) - 1.0).abs() < 1.0 / 24.0 + 1e-9);
        let mut seen = HashSet::new();
        let mut last = 0;
        for piece in tiles(&terrain) {
            let cells: HashSet<[i64; 2]> = piece
                .cloud
                .positions
                .iter()
                .map(|p| ((*p + 0.0005 - cube.min) / side).floor().truncate().to_array().map(|x| x as i64))
                .collect();
            assert!(cells.len() <= 1);
            for cell in cells {
                assert!(cell.iter().all(|x| (0..columns as i64).contains(x)) && seen.insert(cell));
                // Along the Morton curve.
                let code = (0..16).map(|bit| (cell[0] >> bit & 1) << (2 * bit) | (cell[1] >> bit & 1) << (2 * bit + 1));
                let code = 1 + code.sum::<i64>();
                assert!(code > last, "{cell:?}");
                last = code;
            }
            assert!(piece.cloud.positions.iter().all(|p| p.z > cube.min.z && p.z < cube.max.z));
        }
        assert_eq!(seen.len(), terrain.nodes().iter().filter(|node| node.points > 0).count());
    }
    let terrain = Terrain::new(150_000, 3).unwrap();
    let mut seen: HashSet<[i64; 3]> = HashSet::new();
    for piece in tiles(&terrain) {
        let own: HashSet<[i64; 3]> = piece.cloud.positions.iter().map(millimeters).collect();
        assert!(seen.is_disjoint(&own));
        seen.extend(own);
    }
}

/// Points of each class, as shares.
fn classes(cloud: &Cloud) -> BTreeMap<u8, f64> {
    let mut shares = BTreeMap::new();
    for class in cloud.classification.as_ref().unwrap() {
        *shares.entry(*class).or_default() += 1.0 / cloud.len() as f64;
    }
    shares
}

#[test]
fn a_landscape_has_what_surveys_have() {
    for (points, seed) in [(200_000, 0), (1_000_000, 0), (1_000_000, 4)] {
        let terrain = Terrain::new(points, seed).unwrap();
        let mut all = terrain.summary().like.clone();
        tiles(&terrain).into_iter().for_each(|piece| all.append(piece.cloud));
        let shares = classes(&all);
        assert_eq!(shares.keys().copied().collect::<Vec<_>>(), [1, 2, 3, 4, 5, 6, 9, 11, 17]);
        for (class, least) in [(2, 0.2), (3, 0.02), (4, 0.005), (5, 0.05), (6, 0.015), (9, 0.01), (11, 0.01)] {
            assert!(shares[&class] > least, "{points} {seed}, class {class}: {shares:?}");
        }
        let normals = all.normals.as_ref().unwrap();
        let columns = all.positions.iter().zip(all.classification.as_ref().unwrap()).zip(normals);
        for ((p, class), normal) in columns {
            // Water is level, ground looks up, nothing stands higher than the steeple on its hill.
            assert!(*class != 9 || (p.z == 0.0 && *normal == glam::Vec3::Z), "{p}");
            assert!(*class != 2 || normal.z > 0.5, "{p}: {normal}");
            assert!((-0.1..260.0).contains(&p.z), "{p}");
        }
    }
}

#[test]
fn the_ground_is_closed() {
    let terrain = Terrain::new(1_000_000, 0).unwrap();
    // The first sixteen tiles are a square at the edge; most of it is open land.
    let mut cloud = terrain.summary().like.clone();
    (0..16).for_each(|tile| cloud.append(terrain.read(tile).unwrap().cloud));
    let bounds = terrain.nodes()[..16].iter().map(|node| node.bounds).reduce(Bounds::union).unwrap();
    let radii = cloud.radii.as_ref().unwrap();
    let cell = 4.0;
    let key = |p: DVec3| [(p.x / cell).floor() as i64, (p.y / cell).floor() as i64];
    let mut bins: BTreeMap<[i64; 2], Vec<usize>> = BTreeMap::new();
    cloud.positions.iter().enumerate().for_each(|(i, p)| bins.entry(key(*p)).or_default().push(i));
    let (mut open, mut all) = (0, 0);
    for i in 0..200 * 200 {
        let share = DVec3::new(f64::from(i % 200) + 0.5, f64::from(i / 200) + 0.5, 0.0) / 200.0;
        let at = bounds.min + (bounds.max - bounds.min) * share;
        let covers = |i: &usize| (cloud.positions[*i] - at).truncate().length() < f64::from(radii[*i]);
        let near = (-1..=1).flat_map(|x| (-1..=1).map(move |y| DVec3::new(f64::from(x), f64::from(y), 0.0) * cell));
        let covered = near.filter_map(|step| bins.get(&key(at + step))).flatten().any(covers);
        open += usize::from(!covered);
        all += 1;
    }
    // Pulses stray by a fifth of their distance from an even pattern: few gaps.
    assert!(open * 200 < all, "{open} of {all} places are under no disc");
}

#[test]
fn sizes_out_of_range_are_refused() {
    for points in [0, 9_999, 10_000_000_001] {
        let error = Terrain::new(points, 0).unwrap_err();
        assert!(matches!(error, Error::OutOfRange { name: "points", .. }), "{error}");
    }
    // In memory there is less room.
    let error = build("terrain", &[("points".to_owned(), 1e9)], 0).unwrap_err();
    assert!(matches!(error, Error::OutOfRange { name: "points", max: 200e6, .. }), "{error}");
}
