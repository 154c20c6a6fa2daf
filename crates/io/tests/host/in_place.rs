//! Files that are read in place, node by node: together their nodes are the cloud that loading gives.

mod copc;
mod crs;
mod ept;
mod las;
mod make_copc;
mod make_ept;
mod open;
mod ply;

use std::path::{Path, PathBuf};

use pellucid_core::cloud::{Bounds, Cloud, upright};
use pellucid_core::progress::Progress;
use pellucid_io::store::Store;
use pellucid_io::{Error, Hints, LasColumns, load_with};
use pellucid_testing_host::clouds;

/// Everything that is read only where it is asked for.
const ALL: LasColumns = LasColumns { returns: true, source: true, gps_time: true };

fn load(path: &Path, las: LasColumns) -> Result<Cloud, Error> {
    load_with(path, Hints { las, ..Hints::default() }, &Progress::hidden())
}

/// The points of all nodes in the order of their places, after a check of what the store says of them.
#[track_caller]
fn joined(store: &dyn Store) -> Cloud {
    let summary = store.summary();
    let mut all = summary.like.clone();
    let mut places = Vec::new();
    for (at, node) in store.nodes().iter().enumerate() {
        let piece = store.read(at).unwrap_or_else(|e| panic!("node {at}: {e}"));
        let points = node.points - piece.cloud.withheld as u64;
        assert_eq!((piece.cloud.len() as u64, piece.places.len() as u64), (points, points), "node {at}");
        let own = piece.cloud.bounds().expect("points");
        assert!(node.bounds.holds(&own), "node {at}: {own:?} in {:?}", node.bounds);
        assert!(summary.bounds.holds(&own), "node {at}: {own:?} in {:?}", summary.bounds);
        if let Some(parent) = node.parent {
            assert!((parent as usize) < at, "node {at}: its parent {parent} comes later");
            let parent = &store.nodes()[parent as usize];
            assert!(parent.bounds.holds(&node.bounds) && parent.level < node.level, "node {at}");
        }
        all.append(piece.cloud);
        places.extend(piece.places);
    }
    assert_eq!((places.len() + all.withheld) as u64, summary.points);
    all.non_finite = summary.like.non_finite;
    let mut order: Vec<u32> = (0..places.len() as u32).collect();
    order.sort_by_key(|&at| places[at as usize]);
    assert!(order.windows(2).all(|pair| places[pair[0] as usize] < places[pair[1] as usize]), "a place twice");
    let mut all = all.subset(&order);
    // Whoever loads a file lays a flat cloud.
    upright::lay(&mut all);
    all
}

/// Asserts that two clouds are the same to the bit.
#[track_caller]
fn assert_same(found: &Cloud, wanted: &Cloud, of: &str) {
    let bits =
        |cloud: &Cloud| -> Vec<[u64; 3]> { cloud.positions.iter().map(|p| p.to_array().map(f64::to_bits)).collect() };
    assert!(bits(found) == bits(wanted), "{of}: other positions");
    let floats = |values: &[f32]| -> Vec<u32> { values.iter().map(|value| value.to_bits()).collect() };
    let scalars = |cloud: &Cloud| -> Vec<(String, Vec<u32>)> {
        cloud.scalars.iter().map(|(name, values)| (name.clone(), floats(values))).collect()
    };
    assert!(scalars(found) == scalars(wanted), "{of}: other scalars");
    // Scalars may be NaN, which equals nothing.
    let rest = |cloud: &Cloud| Cloud { positions: Vec::new(), scalars: Vec::new(), ..cloud.clone() };
    assert!(rest(found) == rest(wanted), "{of}: other columns");
}

/// All test files whose names end so, with their names.
fn files(endings: &[&str]) -> Vec<(String, PathBuf)> {
    let mut found = Vec::new();
    for clouds in clouds() {
        for folder in crate::io::real::FOLDERS {
            let Ok(entries) = std::fs::read_dir(clouds.folder().join(folder)) else { continue };
            for entry in entries {
                let name = entry.unwrap().file_name().into_string().unwrap();
                if endings.iter().any(|ending| name.ends_with(ending)) {
                    found.push((format!("{folder}/{name}"), clouds.folder().join(folder).join(name)));
                }
            }
        }
    }
    found.sort();
    found
}

/// The middle half of a box along each axis.
fn middle(bounds: &Bounds) -> Bounds {
    let quarter = 0.25 * (bounds.max - bounds.min);
    Bounds { min: bounds.min + quarter, max: bounds.max - quarter }
}
