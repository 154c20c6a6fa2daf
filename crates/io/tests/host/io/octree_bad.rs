//! Octrees that are damaged, lie, or change while they are open: an error that says where, and never more than that.

use std::fs;
use std::path::{Path, PathBuf};

use pellucid_core::cloud::facts::Facts;
use pellucid_io::Error;
use pellucid_io::store::{Octree, Store};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use tempfile::TempDir;

use super::octree::{ROOMY, cloud, held, write};

/// An octree of 7 points as PotreeConverter writes it: a root and one child, in a chunk of its own.
pub fn foreign(change: impl Fn(&mut serde_json::Value)) -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let attribute = |name: &str, kind: &str, elements: usize, size: usize, range: [f64; 2]| {
        serde_json::json!({
            "name": name, "description": "", "size": elements * size, "numElements": elements, "elementSize": size,
            "type": kind, "min": vec![range[0]; elements], "max": vec![range[1]; elements],
        })
    };
    let mut metadata = serde_json::json!({
        "version": "2.0", "name": "seven", "description": "", "points": 7, "projection": "",
        "hierarchy": { "firstChunkSize": 44, "stepSize": 4, "depth": 1 },
        "offset": [100.0, 0.0, 0.0], "scale": [0.5, 0.5, 0.5], "spacing": 0.25,
        "boundingBox": { "min": [100.0, 0.0, 0.0], "max": [108.0, 8.0, 8.0] },
        "encoding": "DEFAULT",
        "attributes": [
            attribute("position", "int32", 3, 4, [0.0, 108.0]),
            attribute("intensity", "uint16", 1, 2, [0.0, 6.0]),
            attribute("return number", "uint8", 1, 1, [1.0, 1.0]),
            attribute("classification", "uint8", 1, 1, [0.0, 6.0]),
            attribute("gps-time", "double", 1, 8, [1e9, 1e9 + 6.0]),
            attribute("waveform", "undefined", 1, 3, [0.0, 0.0]),
            attribute("rgb", "uint16", 3, 2, [0.0, 255.0]),
        ],
    });
    change(&mut metadata);
    let record = |i: u8, x: i32| {
        let mut record: Vec<u8> = [x, i.into(), 3].into_iter().flat_map(i32::to_le_bytes).collect();
        record.extend(u16::from(i).to_le_bytes());
        record.extend([1, i]);
        record.extend((1e9 + f64::from(i)).to_le_bytes());
        record.extend([9, 9, 9]);
        record.extend([255, u16::from(i), 0].into_iter().flat_map(u16::to_le_bytes));
        record
    };
    let points = (0..7).flat_map(|i| record(i, if i < 4 { 1 } else { 9 })).collect::<Vec<u8>>();
    let node = |kind: u8, children: u8, points: u32, offset: u64, bytes: u64| {
        [&[kind, children][..], &points.to_le_bytes(), &offset.to_le_bytes(), &bytes.to_le_bytes()].concat()
    };
    // The child's number 4: high x.
    let hierarchy = [node(0, 16, 4, 0, 4 * 33), node(2, 0, 3, 44, 22), node(1, 0, 3, 4 * 33, 3 * 33)].concat();
    fs::write(folder.path().join("metadata.json"), metadata.to_string()).unwrap();
    fs::write(folder.path().join("octree.bin"), points).unwrap();
    fs::write(folder.path().join("hierarchy.bin"), hierarchy).unwrap();
    let path = folder.path().to_path_buf();
    (folder, path)
}

#[track_caller]
fn assert_bad(path: &Path, says: &str) {
    let error =
        Octree::open(path).and_then(|octree| (0..octree.nodes().len()).try_for_each(|i| octree.read(i).map(drop)));
    let message = error.expect_err(says).to_string();
    assert!(
        message.starts_with(&path.display().to_string()) && message.contains(says),
        "`{says}` is not in: {message}"
    );
}

#[test]
fn octrees_that_lie_are_refused() {
    type Change = fn(&mut serde_json::Value);
    let changes: [(Change, &str); 19] = [
        (|m| m["scale"][2] = 1e300.into(), "coordinates within the range of float64"),
        (|m| m["offset"][2] = 1.79e308.into(), "outside its box"),
        (|m| m["spacing"] = (-0.25).into(), "spacing: -0.25"),
        (|m| m["boundingBox"]["max"][2] = 1e308.into(), "no box"),
        (|m| m["attributes"][5]["numElements"] = u64::MAX.into(), "18446744073709551615 elements"),
        (|m| m["attributes"][5]["type"] = "int128".into(), "unknown variant `int128`"),
        (|m| m["encoding"] = "BROTLI".into(), "is not supported; convert the source with"),
        (|m| m["version"] = "1.8".into(), "only Potree 2 is supported"),
        (|m| m["scale"][1] = 0.into(), "scales must be above 0"),
        (|m| m["boundingBox"]["min"][2] = 9.into(), "no box"),
        (|m| m["hierarchy"]["firstChunkSize"] = 66.into(), "no node before it"),
        (|m| m["hierarchy"]["firstChunkSize"] = u64::MAX.into(), "but the file ends after 66"),
        (|m| m["attributes"][0]["size"] = 16.into(), "attribute \"position\": 16 bytes don't match 3 elements of 4"),
        (|m| m["attributes"][0]["name"] = "place".into(), "no position of three int32, only [place, intensity"),
        (
            |m| m["attributes"][1]["elementSize"] = 4.into(),
            "its elements have 4 bytes, but those of Uint16 have another size",
        ),
        (|m| m["attributes"][5]["size"] = 4.into(), "4 bytes don't match 1 elements of 3"),
        (|m| m["attributes"] = serde_json::json!([m["attributes"][0]]), "132 bytes don't match 4 points of 12 bytes"),
        (|m| m["boundingBox"]["max"][0] = 102.into(), "outside its box"),
        (|m| m["points"] = "many".into(), "a Potree 2.0 octree was expected"),
    ];
    for (change, says) in changes {
        let (_folder, path) = foreign(change);
        assert_bad(&path, says);
    }
    let (_folder, path) = foreign(|_| ());
    for (file, says) in
        [("octree.bin", "the file has 230"), ("hierarchy.bin", "ends after 65"), ("metadata.json", "JSON")]
    {
        let whole = fs::read(path.join(file)).unwrap();
        fs::write(path.join(file), &whole[..whole.len() - 1]).unwrap();
        assert_bad(&path, says);
        fs::remove_file(path.join(file)).unwrap();
        assert_bad(&path, if file == "metadata.json" { "no metadata.json" } else { "no such file" });
        fs::write(path.join(file), whole).unwrap();
    }
    assert_eq!(Octree::open(&path).unwrap().summary().points, 7);
    fs::remove_file(path.join("metadata.json")).unwrap();
    fs::write(path.join("cloud.js"), "{}").unwrap();
    assert_bad(&path, "an octree of Potree 1");
    assert!(matches!(Octree::open(&path.join("none")), Err(Error::Missing { .. } | Error::Malformed { .. })));
}

#[test]
fn no_damage_goes_beyond_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let mut random = Pcg64Mcg::seed_from_u64(3);
    write(&[held(cloud(300, 1))], folder.path(), ROOMY);
    let read_all = || -> Result<(), Error> {
        let octree = Octree::open(folder.path())?;
        octree.survey()?;
        (0..octree.nodes().len()).try_for_each(|node| octree.read(node).map(drop))
    };
    let mut refused = 0;
    for file in ["hierarchy.bin", "nodes.bin", "metadata.json", "octree.bin", "survey.bin"] {
        let path = folder.path().join(file);
        let whole = fs::read(&path).unwrap();
        for _ in 0..200 {
            let mut damaged = whole.clone();
            let at = random.random_range(0..whole.len());
            match random.random_range(0..3) {
                0 => damaged.truncate(at),
                1 => damaged[at] ^= 1 << random.random_range(0..8),
                _ => damaged[at] = random.random(),
            }
            fs::write(&path, damaged).unwrap();
            refused += usize::from(read_all().is_err());
        }
        fs::write(&path, whole).unwrap();
    }
    read_all().unwrap();
    // Many bits of points and names may be others.
    assert!(refused > 300, "{refused}");
}

/// Bytes of a node in hierarchy.bin.
const NODE: usize = 22;
/// Offset of a node's number of points, first byte and number of bytes.
const COUNT: usize = 2;
const OFFSET: usize = 6;
const BYTES: usize = 14;

#[test]
fn hierarchies_that_lie_are_refused() {
    let (_folder, path) = foreign(|_| ());
    let file = path.join("hierarchy.bin");
    let whole = fs::read(&file).unwrap();
    // The root, a node that leads to the chunk of the child, and the child.
    let changed = |changes: &[(usize, usize, &[u8])]| {
        let mut bytes = whole.clone();
        changes.iter().for_each(|(node, at, value)| bytes[node * NODE + at..][..value.len()].copy_from_slice(value));
        bytes
    };
    let long = u64::to_le_bytes;
    let twice = {
        // Two children of the root in one chunk.
        let mut bytes = changed(&[(0, 1, &[24]), (1, OFFSET, &long(66))]);
        bytes.extend_from_within(NODE..2 * NODE);
        bytes.copy_within(2 * NODE..3 * NODE, 3 * NODE);
        bytes.copy_within(NODE..2 * NODE, 2 * NODE);
        bytes
    };
    let cases: [(Vec<u8>, &str); 9] = [
        (
            changed(&[(2, OFFSET, &long(99))]),
            "two nodes overlap in octree.bin: one ends before byte 132, the next one begins at byte 99",
        ),
        (changed(&[(2, OFFSET, &long(0))]), "two nodes overlap"),
        (changed(&[(2, OFFSET, &long(133))]), "a node has 99 bytes from byte 133, but the file has 231"),
        (changed(&[(2, OFFSET, &long(u64::MAX))]), "99 bytes from byte 18446744073709551615"),
        (changed(&[(2, COUNT, &[255; 4])]), "99 bytes don't match 4294967295 points of 33 bytes"),
        (changed(&[(2, COUNT, &[255; 4]), (2, BYTES, &long(u64::from(u32::MAX) * 33))]), "the file has 231"),
        (changed(&[(1, OFFSET, &long(u64::MAX - 21))]), "the file ends after 66"),
        (changed(&[(1, BYTES, &long(u64::MAX))]), "the file ends after 66"),
        (changed(&[(0, 1, &[255])]), "have no record"),
    ];
    for (bytes, says) in cases {
        fs::write(&file, bytes).unwrap();
        assert_bad(&path, says);
    }
    let (_folder, path) = foreign(|metadata| metadata["hierarchy"]["firstChunkSize"] = 66.into());
    fs::write(path.join("hierarchy.bin"), twice).unwrap();
    assert_bad(&path, "two nodes refer to it");
}

#[test]
fn ranges_that_are_none_are_left_out() {
    let (_folder, path) = foreign(|metadata| {
        metadata["attributes"][2]["min"] = serde_json::json!([7.0]);
        metadata["attributes"][4]["max"] = serde_json::json!([null]);
    });
    let octree = Octree::open(&path).unwrap();
    assert_eq!(octree.summary().ranges, []);
    assert!((0..2).all(|node| octree.read(node).is_ok()));
}

#[test]
fn points_that_go_while_the_octree_is_open_are_missed() {
    let (_folder, path) = foreign(|_| ());
    let octree = Octree::open(&path).unwrap();
    let points = path.join("octree.bin");
    let whole = fs::read(&points).unwrap();
    fs::write(&points, &whole[..whole.len() - 1]).unwrap();
    assert_eq!(octree.read(0).unwrap().cloud.len(), 4);
    let error = octree.read(1).unwrap_err().to_string();
    assert!(
        error.starts_with(&*points.to_string_lossy()) && error.contains("became shorter while it was read"),
        "{error}"
    );
    // Other bytes of the same number: points that lie elsewhere.
    fs::write(&points, vec![0; whole.len()]).unwrap();
    let error = octree.read(1).unwrap_err().to_string();
    assert!(error.contains("octree.bin") && error.contains("outside its box"), "{error}");
}

/// Bytes of nodes.bin before the first node, of a node, and of its parts.
const HEAD: usize = 8;
const RECORD: usize = 36;
const RADIUS: usize = 8;
const LEAST: usize = 12;
const MOST: usize = 24;

#[test]
fn boxes_and_radii_that_lie_are_found_where_points_are_read() {
    let folder = tempfile::tempdir().unwrap();
    write(&[held(cloud(3000, 1))], folder.path(), ROOMY);
    let file = folder.path().join("nodes.bin");
    let whole = fs::read(&file).unwrap();
    let last = whole.len() - RECORD;
    let changed = |at: usize, value: &[u8]| {
        let mut bytes = whole.clone();
        bytes[at..at + value.len()].copy_from_slice(value);
        bytes
    };
    let least = whole[last + LEAST..last + MOST].to_vec();
    let cases: [(Vec<u8>, &str); 8] = [
        // The box ends where it begins.
        (changed(HEAD + MOST, &whole[HEAD + LEAST..HEAD + MOST]), "outside its box from"),
        (changed(HEAD + RADIUS, &0_f32.to_le_bytes()), "but the largest should be 0"),
        (changed(last + LEAST, &i32::MIN.to_le_bytes()), "its box is outside its part"),
        (changed(last + MOST, &i32::MAX.to_le_bytes()), "its box is outside its part"),
        (changed(last + LEAST, &i32::MAX.to_le_bytes()), "no box"),
        (changed(last, &u64::MAX.to_le_bytes()), "missing"),
        (whole[..last].to_vec(), "missing"),
        ([&whole[..], &least].concat(), "are not a multiple of"),
    ];
    for (bytes, says) in cases {
        fs::write(&file, bytes).unwrap();
        assert_bad(folder.path(), says);
    }
}

#[test]
fn surveys_that_lie_are_refused_and_others_are_those_of_all_points() {
    let folder = tempfile::tempdir().unwrap();
    let all = cloud(3000, 1);
    write(&[held(all.clone())], folder.path(), ROOMY);
    let survey = || Octree::open(folder.path()).unwrap().survey();
    let known = survey().unwrap().expect("a survey");
    // Few points all stand for themselves; positions are on the store's grid.
    assert_eq!((known.facts.points, known.sample.len()), (3000, 3000));
    assert_eq!(known.facts, Facts::of(&known.sample));
    let file = folder.path().join("survey.bin");
    let whole = fs::read(&file).unwrap();
    let facts = 12 + u32::from_le_bytes(whole[8..12].try_into().unwrap()) as usize;
    let text = |from: &str, to: &str| {
        let text = String::from_utf8(whole[12..facts].to_vec()).unwrap();
        assert!(text.contains(from), "{text}");
        let text = text.replace(from, to);
        [&whole[..8], &(text.len() as u32).to_le_bytes(), text.as_bytes(), &whole[facts..]].concat()
    };
    let cases: [(Vec<u8>, &str); 7] = [
        (whole[..5].to_vec(), "first bytes are not those of a file"),
        (whole[..10].to_vec(), "ends within its facts"),
        (whole[..facts - 1].to_vec(), "ends within its facts"),
        (whole[..whole.len() - 1].to_vec(), "ends within a point"),
        (text("\"points\":3000", "\"points\":3001"), "other points than those of octree.bin"),
        (text("\"points\"", "\"joints\""), "missing field"),
        ([&whole[..facts], &[0x7f; 12], &whole[facts + 12..]].concat(), "points outside the octree"),
    ];
    for (bytes, says) in cases {
        fs::write(&file, bytes).unwrap();
        let error = survey().unwrap_err().to_string();
        assert!(error.contains("survey.bin") && error.contains(says), "{error}");
    }
    fs::remove_file(&file).unwrap();
    assert_eq!(survey().unwrap(), None);
}
