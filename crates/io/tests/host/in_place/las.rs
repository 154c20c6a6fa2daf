//! LAS and LAZ files in pieces.

use pellucid_io::LasColumns;
use pellucid_io::store::{LasPieces, Store};
use tempfile::tempdir;

use super::{ALL, assert_same, files, joined, load};
use crate::io::las::{builder, point, sample, with_withheld, write};

#[test]
fn the_pieces_of_every_file_are_the_file() {
    let mut count = 0;
    for (name, path) in files(&[".las", ".laz"]) {
        for asked in [LasColumns::default(), ALL] {
            let (loaded, store) = (load(&path, asked), LasPieces::open(&path, asked));
            match (loaded, store) {
                (Ok(cloud), Ok(store)) => {
                    assert_same(&joined(&store), &cloud, &name);
                    let most = store.nodes().iter().map(|node| node.points).max().unwrap();
                    assert!(most < 600_000, "{name}: a node of {most} points");
                    count += 1;
                }
                (Err(loaded), Err(store)) => assert_eq!(store.to_string(), loaded.to_string()),
                (loaded, store) => panic!("{name}: {:?} and {:?}", loaded.err(), store.err()),
            }
        }
    }
    assert!(count >= 20, "{count} files");
}

#[test]
fn withheld_points_are_left_out_of_every_piece() {
    let folder = tempdir().unwrap();
    for (minor, format, compressed) in [(2, 1, false), (4, 6, true)] {
        let path = folder.path().join("any.laz");
        std::fs::write(&path, with_withheld(minor, format, compressed, 60_000)).unwrap();
        let store = LasPieces::open(&path, ALL).unwrap();
        let cloud = joined(&store);
        assert_same(&cloud, &load(&path, ALL).unwrap(), "as in memory");
        assert_eq!((cloud.len(), cloud.withheld), (48_000, 12_000));
        // Places are those of the file, so that points keep their numbers.
        assert_eq!(store.read(0).unwrap().places[..4], [1, 2, 3, 4]);
    }
}

/// A file whose header has this box: minima and maxima of x, y and z.
fn with_box(mut bytes: Vec<u8>, ends: [[f64; 2]; 3]) -> Vec<u8> {
    for (axis, [min, max]) in ends.into_iter().enumerate() {
        bytes[179 + 16 * axis..][..8].copy_from_slice(&max.to_le_bytes());
        bytes[187 + 16 * axis..][..8].copy_from_slice(&min.to_le_bytes());
    }
    bytes
}

#[test]
fn a_box_that_lies_is_found_or_refused() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("any.laz");
    for (compressed, ends) in [(false, [[0.0; 2]; 3]), (true, [[f64::NAN; 2]; 3]), (true, [[1.0, -1.0]; 3])] {
        std::fs::write(&path, with_box(sample(2, 3, compressed, 300), ends)).unwrap();
        assert_same(&joined(&LasPieces::open(&path, ALL).unwrap()), &load(&path, ALL).unwrap(), "a box of nothing");
    }
    // The values that decide about columns are known long before the point that lies outside.
    let mut builder = builder(2, 2, true);
    builder.point_format.is_compressed = false;
    let format = builder.point_format;
    let points = (0..600_000u32).map(|index| las::Point {
        z: if index == 590_000 { 500.0 } else { 170.0 },
        color: Some(las::Color::new(65_535, 0, 0)),
        ..point(&format, (index % 60_000) as u16)
    });
    let bytes = write(builder, points);
    std::fs::write(&path, with_box(bytes, [[289_000.0, 290_000.0], [4_320_000.0, 4_322_000.0], [0.0, 200.0]])).unwrap();
    let store = LasPieces::open(&path, LasColumns::default()).unwrap();
    assert_eq!(store.nodes().len(), 2);
    store.read(0).unwrap();
    let error = store.read(1).unwrap_err().to_string();
    assert!(
        error.starts_with(&path.display().to_string()) && error.contains("200") && error.contains("repair it"),
        "{error}"
    );
}

#[test]
fn a_file_that_becomes_shorter_is_an_error() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("any.las");
    let bytes = sample(2, 3, false, 60_000);
    std::fs::write(&path, &bytes).unwrap();
    let store = LasPieces::open(&path, LasColumns::default()).unwrap();
    store.read(0).unwrap();
    std::fs::File::options().write(true).open(&path).unwrap().set_len(bytes.len() as u64 / 2).unwrap();
    let error = store.read(0).unwrap_err().to_string();
    assert!(error.contains("truncated"), "{error}");
}
