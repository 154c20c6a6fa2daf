//! COPC files, read node by node.

use pellucid_engine::io::LasColumns;
use pellucid_engine::io::store::{Copc, LasPieces, Store};
use tempfile::tempdir;

use super::{ALL, assert_same, files, joined, load, middle};

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
