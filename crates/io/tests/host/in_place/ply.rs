//! PLY files in pieces.

use pellucid_io::LasColumns;
use pellucid_io::store::PlyPieces;
use tempfile::tempdir;

use super::open::{kind, opened};
use super::{assert_same, files, joined, load};

#[test]
fn the_pieces_of_every_file_are_the_file() {
    let (mut pieces, mut whole) = (0, 0);
    for (name, path) in files(&[".ply"]) {
        match (load(&path, LasColumns::default()), opened(&path)) {
            (Ok(cloud), Ok(store)) => {
                assert_same(&joined(&*store), &cloud, &name);
                if kind(&*store) == "PlyPieces" {
                    pieces += 1;
                } else {
                    let refused = PlyPieces::open(&path).expect_err("a file that is read as a whole").to_string();
                    assert!(refused.contains("read as a whole"), "{refused}");
                    whole += 1;
                }
            }
            (Err(loaded), Err(store)) => assert_eq!(store.to_string(), loaded.to_string()),
            (loaded, store) => panic!("{name}: {:?} and {:?}", loaded.err(), store.err()),
        }
    }
    assert!(pieces >= 4 && whole >= 3, "{pieces} in pieces, {whole} as a whole");
}

/// Rows of a file, more than a piece has.
const ROWS: u32 = 1_100_000;

/// Vertices of all kinds of numbers. Every 1000th is not finite; only the last two have a normal, and a class that is
/// no code.
fn file(little_endian: bool) -> Vec<u8> {
    let order = if little_endian { "little" } else { "big" };
    let mut bytes = format!(
        "ply\nformat binary_{order}_endian 1.0\nelement other 3\nproperty uchar a\nelement vertex {ROWS}\nproperty double x\n\
         property float y\nproperty int z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nproperty ushort alpha\n\
         property float radius\nproperty float nx\nproperty float ny\nproperty float nz\nproperty short class\nproperty char w\n\
         end_header\n123"
    )
    .into_bytes();
    fn add<const N: usize>(bytes: &mut Vec<u8>, little_endian: bool, mut value: [u8; N]) {
        if !little_endian {
            value.reverse();
        }
        bytes.extend(value);
    }
    for row in 0..ROWS {
        let x = if row % 1000 == 999 { f64::NAN } else { f64::from(row) * 0.01 };
        let last = row + 2 >= ROWS;
        add(&mut bytes, little_endian, x.to_le_bytes());
        add(&mut bytes, little_endian, ((row % 777) as f32).to_le_bytes());
        add(&mut bytes, little_endian, (row as i32 % 31).to_le_bytes());
        bytes.extend([row as u8, (row >> 8) as u8, 7]);
        add(&mut bytes, little_endian, (row as u16).to_le_bytes());
        add(&mut bytes, little_endian, (row as f32 * 1e-3).to_le_bytes());
        for normal in [0.0, if last { 2.0 } else { 0.0 }, 0.0f32] {
            add(&mut bytes, little_endian, normal.to_le_bytes());
        }
        add(&mut bytes, little_endian, if last { -1i16 } else { 3 }.to_le_bytes());
        bytes.push(row as u8);
    }
    bytes
}

#[test]
fn facts_from_the_last_points_hold_for_all_pieces() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("any.ply");
    for little_endian in [true, false] {
        std::fs::write(&path, file(little_endian)).unwrap();
        let (cloud, store) = (load(&path, LasColumns::default()).unwrap(), opened(&path).unwrap());
        assert_eq!((cloud.len(), cloud.non_finite), (1_098_900, 1100));
        assert!(cloud.normals.is_some() && cloud.classification.is_none());
        assert_eq!(cloud.scalars.iter().map(|(name, _)| &**name).collect::<Vec<_>>(), ["w", "class"]);
        assert_eq!(cloud.positions[999].x, 10.0, "the point behind the first that is not finite");
        assert_same(&joined(&*store), &cloud, "a made file");
        let radii: Vec<f32> = store.nodes().iter().filter_map(|node| node.largest_radius).collect();
        assert_eq!(radii, [499_998, 999_998, 1_099_998].map(|row| row as f32 * 1e-3));
    }
}

#[test]
fn a_file_that_changes_is_noticed() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("any.ply");
    let bytes = file(true);
    std::fs::write(&path, &bytes).unwrap();
    let store = opened(&path).unwrap();
    let mut other = bytes.clone();
    let row = (bytes.len() - 3) / ROWS as usize;
    let at = bytes.len() - 500 * row;
    other[at..at + 8].copy_from_slice(&1e9f64.to_le_bytes());
    std::fs::write(&path, &other).unwrap();
    store.read(0).unwrap();
    assert!(store.read(2).unwrap_err().to_string().contains("the file changed after it was opened"));
    std::fs::write(&path, &bytes[..bytes.len() / 2]).unwrap();
    let error = store.read(2).unwrap_err().to_string();
    assert!(error.contains("became shorter"), "{error}");
}
