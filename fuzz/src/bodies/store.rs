//! Point clouds that are read node by node: each node has what the store says of it, or isn't read.

use std::path::Path;

use pellucid_engine::io::store::{Copc, Ept, LasPieces, Store};
use pellucid_engine::io::{Error, LasColumns};

use super::cloud::check;
use super::with_file;

/// What is read only where it is asked for, but for times: laz 0.13 decodes them by a function that calls itself as often as the file
/// says, and a stack that is full ends the process. It is the library's to mend.
const ASKED: LasColumns = LasColumns { returns: true, source: true, gps_time: false };

/// COPC files by their hierarchy, and as the LAZ files that they are.
pub fn copc(input: &[u8]) {
    with_file("input.copc.laz", input, |path| {
        read(path, Copc::open(path, ASKED));
        read(path, LasPieces::open(path, LasColumns::default()));
    });
}

/// EPT folders: behind a line of the description, one of the root's hierarchy and one of that of node 1-0-0-0, the rest is the root's
/// tile, in any of the formats.
pub fn ept(input: &[u8]) {
    let mut parts = input.splitn(4, |byte| *byte == b'\n');
    let mut part = || parts.next().unwrap_or_default();
    let (description, root, below, tile) = (part(), part(), part(), part());
    let folder = tempfile::tempdir().expect("a temporary folder");
    let write = |name: &str, content: &[u8]| {
        let path = folder.path().join(name);
        std::fs::create_dir_all(path.parent().expect("a folder")).expect("a temporary folder");
        std::fs::write(path, content).expect("room for a temporary file");
    };
    write("ept.json", description);
    write("ept-hierarchy/0-0-0-0.json", root);
    write("ept-hierarchy/1-0-0-0.json", below);
    for tile_name in ["0-0-0-0.bin", "0-0-0-0.laz", "0-0-0-0.zst", "1-0-0-0.bin"] {
        write(&format!("ept-data/{tile_name}"), tile);
    }
    read(folder.path(), Ept::open(folder.path(), ASKED));
}

/// Reads all nodes of a store and compares them with what it says.
fn read<S: Store>(path: &Path, store: Result<S, Error>) {
    let refused = |error: Error| assert!(error.to_string().starts_with(&*path.to_string_lossy()), "{error}");
    let store = match store {
        Ok(store) => store,
        Err(error) => return refused(error),
    };
    for (at, node) in store.nodes().iter().enumerate() {
        assert!(
            node.bounds.min.is_finite() && node.bounds.max.is_finite() && node.bounds.min.cmple(node.bounds.max).all()
        );
        let parent = node.parent.map(|parent| &store.nodes()[..at][parent as usize]);
        assert!(parent.is_none_or(|parent| parent.bounds.holds(&node.bounds)), "a node outside of the one above");
        match store.read(at) {
            Err(error) => refused(error),
            Ok(piece) => {
                check(&piece.cloud);
                assert_eq!((piece.cloud.len() as u64, piece.places.len() as u64), (node.points, node.points));
                assert!(
                    piece.cloud.bounds().is_some_and(|bounds| node.bounds.holds(&bounds)),
                    "points beyond their box"
                );
                let mut all = store.summary().like.clone();
                all.append(piece.cloud);
            }
        }
    }
}
