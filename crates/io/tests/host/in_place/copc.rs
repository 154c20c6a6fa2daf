//! COPC files, read node by node.

use pellucid_io::store::{Copc, Store};
use pellucid_io::{Error, LasColumns};
use pellucid_testing_host::random;
use rand::RngExt;
use tempfile::tempdir;

use super::make_copc::{ENTRY, INFO, POINTS, entry, make};
use super::{ALL, assert_same, files, joined, load, middle};
use crate::io::las::sample;

#[test]
fn the_nodes_of_every_file_are_the_file() {
    for (name, path) in files(&[".copc.laz"]) {
        for asked in [LasColumns::default(), ALL] {
            let store = Copc::open(&path, asked).unwrap_or_else(|e| panic!("{e}"));
            assert_same(&joined(&store), &load(&path, asked).unwrap(), &name);
        }
    }
}

#[test]
fn levels_halve_the_spacing_and_boxes_leave_nodes_out() {
    for (name, path) in files(&[".copc.laz"]) {
        let store = Copc::open(&path, LasColumns::default()).unwrap();
        let root = &store.nodes()[0];
        assert_eq!((root.level, root.parent), (0, None), "{name}");
        assert!(
            store.nodes().iter().all(|node| node.spacing == root.spacing / f64::from(1u32 << node.level)),
            "{name}"
        );
        assert!(store.nodes()[1..].iter().all(|node| node.parent.is_some()), "{name}");
        assert!(store.nodes().iter().any(|node| node.level > 0), "{name}");
        // The root spreads over the whole cloud.
        let own = store.read(0).unwrap().cloud.bounds().unwrap();
        assert!(own.holds(&middle(&store.summary().bounds)), "{name}: {own:?}");
    }
}

/// Opens some bytes as a COPC file and reads all of its nodes.
fn read_bytes(bytes: &[u8]) -> Result<u64, Error> {
    let folder = tempdir().unwrap();
    let path = folder.path().join("any.copc.laz");
    std::fs::write(&path, bytes).unwrap();
    let store = Copc::open(&path, LasColumns::default())?;
    (0..store.nodes().len()).try_fold(0, |points, node| Ok(points + store.read(node)?.places.len() as u64))
}

#[test]
fn pages_of_a_hierarchy_are_followed() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("any.copc.laz");
    for format in [6, 7, 8] {
        std::fs::write(&path, make(format).bytes).unwrap();
        let store = Copc::open(&path, ALL).unwrap();
        assert_same(&joined(&store), &load(&path, ALL).unwrap(), &format!("format {format}"));
        let levels: Vec<_> = store.nodes().iter().map(|node| (node.level, node.parent)).collect();
        assert_eq!(levels, [(0, None), (1, Some(0)), (1, Some(0)), (2, Some(1)), (2, Some(2))]);
    }
}

#[test]
fn lying_hierarchies_are_refused() {
    let made = make(7);
    let changed = |page: usize, entry: usize, at: usize, value: &[u8]| {
        let mut bytes = made.bytes.clone();
        let start = made.pages[page] + entry * ENTRY + at;
        bytes[start..start + value.len()].copy_from_slice(value);
        bytes
    };
    let info = |at: usize, value: &[u8]| {
        let mut bytes = made.bytes.clone();
        bytes[INFO + at..INFO + at + value.len()].copy_from_slice(value);
        bytes
    };
    let word = i32::to_le_bytes;
    assert_eq!(read_bytes(&made.bytes).unwrap(), u64::from(POINTS));
    let page = |page: usize| made.pages[page] as u64;
    let link = entry([2, 0, 0, 1], page(1), 2 * ENTRY as i32, -1);
    let looped = changed(1, 0, 0, &[&*link, &link].concat());
    let cases: [(&str, Vec<u8>, &str); 19] = [
        ("a loop of one page", changed(0, 3, 16, &page(0).to_le_bytes()), "a second node"),
        ("a loop without nodes", looped, "so they overlap"),
        ("a page beyond the end", changed(0, 3, 16, &(made.bytes.len() as u64).to_le_bytes()), "the file has"),
        ("a page far beyond the end", changed(0, 3, 16, &u64::MAX.to_le_bytes()), "the file has"),
        ("a page of half entries", changed(0, 3, 24, &word(63)), "a multiple of the"),
        ("a page of nothing", changed(0, 3, 24, &word(0)), "a multiple of the"),
        ("a page of less than nothing", changed(0, 3, 24, &word(-32)), "-1 points in -32 bytes"),
        ("a node beyond the end", changed(0, 0, 16, &u64::MAX.to_le_bytes()), "no chunk of points begins"),
        ("a node within a chunk", changed(0, 0, 16, &(page(0) - 100).to_le_bytes()), "no chunk of points begins"),
        ("more bytes", changed(0, 0, 24, &word(i32::MAX)), "2147483647 bytes"),
        ("more points", changed(0, 0, 28, &word(i32::MAX)), "2147483647 points"),
        ("fewer points", changed(0, 0, 28, &word(7)), "a chunk of 300 points"),
        ("no points", changed(0, 0, 28, &word(0)), "belong to no node"),
        ("less than no points", changed(0, 0, 28, &word(-2)), "-2 points"),
        ("a level of 32", changed(0, 1, 0, &word(32)), "no octree"),
        ("a place outside", changed(0, 1, 4, &word(2)), "no octree"),
        ("a node twice", changed(0, 1, 12, &word(0)), "a second node 1-0-0-0"),
        ("a root page of everything", info(48, &u64::MAX.to_le_bytes()), "so they overlap"),
        ("a cube of no size", info(24, &0f64.to_le_bytes()), "half a side of 0"),
    ];
    for (name, bytes, says) in cases {
        let error = read_bytes(&bytes).expect_err(name).to_string();
        assert!(error.contains("any.copc.laz: ") && error.contains(says), "{name}: {error}");
    }
    // A key that is another place in the octree: the points are not there.
    let error = read_bytes(&changed(0, 1, 4, &word(1))).expect_err("elsewhere").to_string();
    assert!(error.contains("outside the box") || error.contains("their box"), "{error}");
    let plain = sample(4, 6, true, 300);
    let error = read_bytes(&plain).expect_err("not a COPC file").to_string();
    assert!(error.contains("not a COPC file"), "{error}");
}

#[test]
fn random_damage_never_panics() {
    let made = make(7);
    let mut random = random(11);
    let mut read = 0;
    for _ in 0..600 {
        let mut bytes = made.bytes.clone();
        for _ in 0..random.random_range(1..4) {
            // The hierarchy and the records of the header, which are what is read here; the points are those of LAS
            // files.
            let (from, to) = if random.random() { (made.pages[0], bytes.len()) } else { (0, 1000) };
            let at = random.random_range(from..to);
            bytes[at] = random.random();
        }
        if random.random_range(0..8) == 0 {
            bytes.truncate(random.random_range(0..bytes.len()));
        }
        match read_bytes(&bytes) {
            Ok(_) => read += 1,
            Err(error) => assert!(error.to_string().contains("any.copc.laz: "), "{error}"),
        }
    }
    assert!(read > 20, "{read}");
}
