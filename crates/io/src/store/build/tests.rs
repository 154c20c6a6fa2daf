//! Octrees put together from parts, and read back.

use std::collections::BTreeMap;
use std::path::Path;

use glam::{DVec3, Vec3};
use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::super::octree::metadata::METADATA;
use super::super::octree::nodes::NODES;
use super::super::octree::survey::SURVEY;
use super::super::octree::{HIERARCHY, POINTS};
use super::super::{Grid, Octree, Store};
use super::*;
use pellucid_core::cloud::{Cloud, UpAxis};

const FILES: [&str; 5] = [POINTS, HIERARCHY, NODES, SURVEY, METADATA];

/// A surface, a dense cluster far below it, and many points in one place; with all columns.
fn cloud(count: usize) -> Cloud {
    let mut random = Pcg64Mcg::seed_from_u64(5);
    let position = |i: usize| {
        let [u, v, w]: [f64; 3] = [(); 3].map(|()| random.random());
        match i % 10 {
            0 => DVec3::new(-700.0 + 1e-4 * u, 1e-4 * v, -300.0 + 1e-4 * w),
            1 => DVec3::new(40.0, 40.0, 7.0),
            _ => DVec3::new(100.0 * u, 100.0 * v, (9.0 * u).sin() + 0.1 * w),
        }
    };
    let positions: Vec<DVec3> = (0..count).map(position).collect();
    let mut random = Pcg64Mcg::seed_from_u64(6);
    let mut column = || (0..count).map(|_| random.random::<f32>()).collect::<Vec<f32>>();
    let scalars = vec![("return_number".to_owned(), vec![2.0; count]), ("radius".to_owned(), column())];
    Cloud {
        positions,
        colors: Some((0..count).map(|i| Vec3::splat(i as f32 / count as f32)).collect()),
        normals: Some(vec![Vec3::Z; count]),
        radii: Some(column()),
        intensity: Some((0..count).map(|i| (i % 300) as f32).collect()),
        alphas: Some(column()),
        classification: Some((0..count).map(|i| (i % 7) as u8).collect()),
        scalars,
        up: UpAxis::NegativeY,
        ..Cloud::default()
    }
}

struct EncodedCloud {
    layout: AttributeLayout,
    cube: Cube,
    /// Records of the points, a vector each.
    records: Vec<Vec<u8>>,
    like: Cloud,
}

impl EncodedCloud {
    fn new(cloud: &Cloud) -> Self {
        let bounds = cloud.bounds().unwrap();
        let cube = Cube::around(Grid::around(&bounds).unwrap(), &bounds).unwrap();
        let layout = Types::of(cloud, &cube.grid).layout(cloud, cloud.len() as u64);
        let places: Vec<u64> = (0..cloud.len() as u64).collect();
        let encoded = encode(&layout, &cube, cloud, &places).unwrap();
        let records = encoded.records.chunks_exact(layout.stride).map(<[u8]>::to_vec).collect();
        Self { layout, cube, records, like: cloud.subset(&[]) }
    }

    /// Makes a store of cells that `cut` divides a cell into.
    fn write(&self, folder: &Path, cut: &dyn Fn(Cell) -> bool) {
        let mut assembler =
            Assembler::new(folder, self.layout.clone(), self.cube, 100, self.records.len() as u64).unwrap();
        let mut cells: BTreeMap<[u128; 2], (Cell, Vec<u8>)> = BTreeMap::new();
        for record in &self.records {
            let steps = self.cube.steps_of(crate::store::octree::integers(record));
            let level = (0..self.cube.levels()).find(|level| !cut(self.cube.cell(steps, *level))).unwrap();
            let cell = self.cube.cell(steps, level);
            cells.entry(cell.morton_order()).or_insert((cell, Vec::new())).1.extend(record);
        }
        for (cell, records) in cells.values() {
            assembler.add(*cell, records).unwrap();
        }
        let told = Told { name: "test", like: &self.like, rounding: 0.0 };
        std::fs::write(folder.join(METADATA), assembler.finish(&told).unwrap()).unwrap();
    }
}

fn bytes(folder: &Path) -> Vec<Vec<u8>> {
    FILES.map(|file| std::fs::read(folder.join(file)).unwrap()).to_vec()
}

/// All points of a store, by their places.
fn points(store: &dyn Store) -> (Cloud, Vec<u64>) {
    let pieces = (0..store.nodes().len()).map(|node| store.read(node).unwrap());
    let mut whole = store.summary().like.clone();
    let mut places = Vec::new();
    for piece in pieces {
        whole.append(piece.cloud);
        places.extend(piece.places);
    }
    let mut order: Vec<u32> = (0..places.len() as u32).collect();
    order.sort_unstable_by_key(|i| places[*i as usize]);
    (whole.subset(&order), order.iter().map(|i| places[*i as usize]).collect())
}

#[test]
fn neither_cuts_nor_order_change_a_byte() {
    let mut source = EncodedCloud::new(&cloud(5000));
    let folder = tempfile::tempdir().unwrap();
    source.write(folder.path(), &|_| false);
    let whole = bytes(folder.path());
    source.records.shuffle(&mut Pcg64Mcg::seed_from_u64(1));
    source.write(folder.path(), &|cell| cell.level < 3);
    assert!(bytes(folder.path()) == whole, "cells of one level");
    source.write(folder.path(), &|cell| cell.level < 9 && (cell.at[0] + cell.level) % 3 > 0);
    assert!(bytes(folder.path()) == whole, "cells of several levels");
    let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    alone.install(|| source.write(folder.path(), &|_| false));
    assert!(bytes(folder.path()) == whole, "one thread");
}

#[test]
fn every_point_comes_back_to_the_bit() {
    let cloud = cloud(5000);
    let source = EncodedCloud::new(&cloud);
    let folder = tempfile::tempdir().unwrap();
    source.write(folder.path(), &|_| false);
    let octree = Octree::open(folder.path()).unwrap();
    let (back, places) = points(&octree);
    assert_eq!(places, (0..5000).collect::<Vec<u64>>());
    let moved = back.positions.iter().zip(&cloud.positions).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max);
    // Half a step along each axis; 800 is below 2¹⁰, so a step is 2⁻²⁰.
    assert!(moved > 0.0 && moved <= 0.5 * 3_f64.sqrt() * (-20_f64).exp2(), "{moved}");
    assert_eq!(Cloud { positions: cloud.positions.clone(), ..back }, cloud);
}

#[test]
fn nodes_are_small_and_get_finer_below() {
    let source = EncodedCloud::new(&cloud(5000));
    let folder = tempfile::tempdir().unwrap();
    source.write(folder.path(), &|_| false);
    let octree = Octree::open(folder.path()).unwrap();
    let nodes = octree.nodes();
    // 500 points are in one place: 100 and one by one those that the nodes above took are not in the leaf.
    let large: Vec<u64> = nodes.iter().map(|node| node.points).filter(|points| *points > 100).collect();
    assert!(large.len() == 1 && (450..500).contains(&large[0]), "{large:?}");
    assert!(nodes.iter().map(|node| node.level).max() > Some(8), "the cluster is deep");
    assert_eq!((nodes[0].level, nodes.iter().map(|node| node.points).sum::<u64>()), (0, 5000));
    for (index, node) in nodes.iter().enumerate() {
        let radii = octree.read(index).unwrap().cloud.radii.unwrap();
        assert_eq!(node.largest_radius.unwrap_or(0.0), radii.into_iter().fold(0.0, f32::max));
        if let Some(parent) = node.parent {
            let above = &nodes[parent as usize];
            assert_eq!(above.level + 1, node.level);
            assert_eq!(above.bounds.union(node.bounds), above.bounds);
            assert_eq!(above.spacing, 2.0 * node.spacing);
        }
    }
}
