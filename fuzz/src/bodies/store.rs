//! Point clouds that are read node by node: each node has what the store says of it, or isn't read.

use std::path::Path;

use pellucid_io::store::{Copc, Ept, LasPieces, Octree, PlyPieces, Store};
use pellucid_io::{Error, LasColumns};

use super::cloud::check;
use super::with_file;

/// Columns that are read only where they are asked for.
const ASKED: LasColumns = LasColumns { returns: true, source: true, gps_time: true };

/// COPC files by their hierarchy, and as the LAZ files that they are.
pub fn copc(input: &[u8]) {
    with_file("input.copc.laz", input, |path| {
        read(path, Copc::open(path, ASKED));
        read(path, LasPieces::open(path, ASKED));
    });
}

/// LAS and LAZ files in pieces, with and without what is read only where it is asked for.
pub fn las_pieces(path: &Path) {
    read(path, LasPieces::open(path, LasColumns::default()));
    read(path, LasPieces::open(path, ASKED));
}

/// PLY files in pieces.
pub fn ply_pieces(path: &Path) {
    read(path, PlyPieces::open(path));
}

/// Octrees of Potree: behind a line of metadata.json and a line of four numbers, the bytes of hierarchy.bin, of
/// nodes.bin (none if it has 0) and of octree.bin, and how many of the latter are gone once the folder is open. What is
/// left is survey.bin.
pub fn octree(input: &[u8]) {
    let mut parts = input.splitn(3, |byte| *byte == b'\n');
    let mut part = || parts.next().unwrap_or_default();
    let (metadata, lengths, mut rest) = (part(), part(), part());
    let lengths = String::from_utf8_lossy(lengths);
    let mut lengths = lengths.split(' ').map(|length| length.parse::<usize>().unwrap_or(0));
    let mut take = || {
        let (own, others) = rest.split_at(lengths.next().unwrap_or(0).min(rest.len()));
        rest = others;
        own
    };
    let (hierarchy, nodes, points) = (take(), take(), take());
    let folder = tempfile::tempdir().expect("a temporary folder");
    let write = |name: &str, content: &[u8]| {
        std::fs::write(folder.path().join(name), content).expect("room for a temporary file");
    };
    write("metadata.json", metadata);
    write("hierarchy.bin", hierarchy);
    write("octree.bin", points);
    if !nodes.is_empty() {
        write("nodes.bin", nodes);
    }
    let octree = Octree::open(folder.path());
    if let Ok(octree) = &octree {
        // The rest of the input is a survey.
        write("survey.bin", rest);
        let _ = octree.survey();
    }
    let gone = lengths.next().unwrap_or(0).min(points.len());
    if gone > 0 {
        write("octree.bin", &points[..points.len() - gone]);
    }
    read(folder.path(), octree);
}

/// EPT folders: behind a line of the description, one of the root's hierarchy and one of that of node 1-0-0-0, the rest
/// is the root's tile, in any of the formats.
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
                let found = piece.cloud.len() as u64;
                assert_eq!(piece.places.len() as u64, found);
                // Points that are withheld are left out and counted, splats that are none are left out.
                let told = found + piece.cloud.withheld as u64;
                let may_lack = piece.cloud.gaussians.is_some() && told < node.points;
                assert!(may_lack || told == node.points);
                if found > 0 {
                    check(&piece.cloud);
                }
                let within = |bounds| node.bounds.holds(&bounds);
                assert!(piece.cloud.bounds().is_none_or(within), "points beyond their box");
                let radii = piece.cloud.radii.iter().flatten();
                assert!(
                    node.largest_radius.is_none_or(|largest| radii.max_by(|a, b| a.total_cmp(b)) <= Some(&largest))
                );
                let mut all = store.summary().like.clone();
                all.append(piece.cloud);
            }
        }
    }
}
