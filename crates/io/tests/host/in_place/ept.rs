//! EPT folders, read node by node.

use std::path::{Path, PathBuf};

use pellucid_core::cloud::Cloud;
use pellucid_io::store::{Ept, Store};
use pellucid_io::{Error, LasColumns};
use pellucid_testing_host::random;
use rand::RngExt;
use serde_json::{Value, json};
use tempfile::{TempDir, tempdir};

use super::make_ept::{Tiles, make};
use super::{ALL, files, joined, load, middle};
use crate::io::las::{sample, with_withheld};

/// Each point with all that belongs to it, in the order of these bits.
fn sorted(cloud: &Cloud) -> Vec<Vec<u64>> {
    let bits = |value: f32| u64::from(value.to_bits());
    let row = |at: usize| {
        let mut row: Vec<u64> = cloud.positions[at].to_array().map(f64::to_bits).to_vec();
        row.extend(cloud.colors.iter().flat_map(|colors| colors[at].to_array().map(bits)));
        row.extend(cloud.intensity.iter().map(|values| bits(values[at])));
        row.extend(cloud.classification.iter().map(|codes| u64::from(codes[at])));
        row.extend(cloud.scalars.iter().map(|(_, values)| bits(values[at])));
        row
    };
    let mut rows: Vec<_> = (0..cloud.len()).map(row).collect();
    rows.sort_unstable();
    rows
}

#[test]
fn withheld_points_are_left_out_of_every_tile() {
    let folder = tempdir().unwrap();
    let file = folder.path().join("from.las");
    std::fs::write(&file, with_withheld(2, 3, false, 900)).unwrap();
    let wanted = load(&file, LasColumns::default()).unwrap();
    for (tiles, statistics) in [(Tiles::Laszip, true), (Tiles::Binary, false), (Tiles::Zstandard, true)] {
        let path = folder.path().join("ept");
        make(&path, &file, tiles, statistics);
        let cloud = joined(&Ept::open(&path, LasColumns::default()).unwrap());
        assert!(sorted(&cloud) == sorted(&wanted));
        assert_eq!((cloud.len(), cloud.withheld), (720, 180));
        std::fs::remove_dir_all(path).unwrap();
    }
}

/// A folder of the points of a made LAS file, and the file.
fn made(tiles: Tiles, statistics: bool) -> (TempDir, PathBuf) {
    let folder = tempdir().unwrap();
    let file = folder.path().join("from.las");
    std::fs::write(&file, sample(2, 3, false, 900)).unwrap();
    make(&folder.path().join("ept"), &file, tiles, statistics);
    (folder, file)
}

#[test]
fn the_nodes_of_a_folder_are_the_file_that_it_was_made_of() {
    let kinds = [
        (Tiles::Laszip, true),
        (Tiles::Laszip, false),
        (Tiles::Binary, true),
        (Tiles::Binary, false),
        (Tiles::Zstandard, true),
    ];
    let real = files(&[".las", ".laz"]).into_iter().filter(|(name, _)| {
        ["lidar/sample_c", "formats/1.2-with-color", "lidar/autzen_trim"].iter().any(|wanted| name.starts_with(wanted))
    });
    let (_folder, file) = made(Tiles::Laszip, true);
    for (name, file) in real.chain([("made".to_owned(), file)]) {
        for (tiles, statistics) in kinds {
            let folder = tempdir().unwrap();
            make(folder.path(), &file, tiles, statistics);
            for asked in [LasColumns::default(), ALL] {
                let store = Ept::open(&folder.path().join("ept.json"), asked).unwrap_or_else(|e| panic!("{name}: {e}"));
                let (found, wanted) = (joined(&store), load(&file, asked).unwrap());
                let names = |cloud: &Cloud| cloud.scalars.iter().map(|(name, _)| name.clone()).collect::<Vec<_>>();
                assert_eq!((names(&found), found.up), (names(&wanted), wanted.up), "{name}");
                assert!(sorted(&found) == sorted(&wanted), "{name}: other points");
            }
        }
    }
}

#[test]
fn spacing_boxes_and_ranges_are_those_of_the_description() {
    let (folder, file) = made(Tiles::Binary, true);
    let store = Ept::open(&folder.path().join("ept"), ALL).unwrap();
    let description = description(&folder.path().join("ept"));
    let side = description["bounds"][3].as_f64().unwrap() - description["bounds"][0].as_f64().unwrap();
    let root = &store.nodes()[0];
    assert!((root.spacing - side / 128.0).abs() < 1e-9 && root.parent.is_none());
    let deep = store.nodes().iter().filter(|node| node.level == 2).collect::<Vec<_>>();
    assert!(!deep.is_empty() && deep.iter().all(|node| node.parent.is_some() && node.spacing == root.spacing / 4.0));
    assert!(root.bounds.holds(&middle(&load(&file, ALL).unwrap().bounds().unwrap())));
    let range = |name: &str| store.summary().ranges.iter().find(|(known, _)| known == name).unwrap().1;
    assert_eq!((range("number_of_returns"), range("gps_time")), ([2.0, 2.0], [0.0, 899.0]));
    assert_eq!(store.nodes().iter().map(|node| node.bytes).sum::<u64>(), 900 * (12 + 12 + 8 + 6));
}

fn description(folder: &Path) -> Value {
    serde_json::from_slice(&std::fs::read(folder.join("ept.json")).unwrap()).unwrap()
}

/// Opens a folder and reads all of its nodes.
fn read(folder: &Path) -> Result<u64, Error> {
    let store = Ept::open(folder, LasColumns::default())?;
    (0..store.nodes().len()).try_fold(0, |points, node| Ok(points + store.read(node)?.places.len() as u64))
}

#[test]
fn lying_descriptions_are_refused() {
    let cases: [(&str, Value, &str); 12] = [
        ("points", json!(901), "says 901"),
        ("points", json!(u64::MAX), "the nodes of the hierarchy have 900"),
        ("points", json!(-3), "line 1"),
        ("span", json!(0), "`span`"),
        ("dataType", json!("zip"), "known: laszip, binary, zstandard"),
        ("dataType", json!("laszip"), "no such file"),
        ("hierarchyType", json!("gzip"), "known: json"),
        ("bounds", json!([0, 0, 0, -1, 1, 1]), "is not a box"),
        ("bounds", json!([0, 0, 0]), "line 1"),
        ("boundsConforming", json!([0, 0, 0, 1, 1, 1]), "lies outside"),
        ("schema", json!([]), "lacks one of `X`"),
        ("schema", json!([{ "name": "X", "type": "signed", "size": 3 }]), "can't have 3 bytes"),
    ];
    for (key, value, says) in cases {
        let (folder, _) = made(Tiles::Binary, true);
        let ept = folder.path().join("ept");
        let mut json = description(&ept);
        json[key] = value.clone();
        std::fs::write(ept.join("ept.json"), json.to_string()).unwrap();
        let error = read(&ept).expect_err(key).to_string();
        assert!(error.starts_with(&*ept.to_string_lossy()) && error.contains(says), "{key} {value}: {error}");
    }
}

#[test]
fn lying_hierarchies_are_refused() {
    let (folder, _) = made(Tiles::Binary, true);
    let ept = folder.path().join("ept");
    assert_eq!(read(&ept).unwrap(), 900);
    let root: Value = serde_json::from_slice(&std::fs::read(ept.join("ept-hierarchy/0-0-0-0.json")).unwrap()).unwrap();
    let below = root.as_object().unwrap().iter().find(|(_, count)| **count == json!(-1)).unwrap().0.clone();
    let cases = [
        (&*below, json!(5), "the nodes of the hierarchy have"),
        ("0-0-0-0", json!(-1), "read before"),
        ("1-2-0-0", json!(1), "not a level and place"),
        ("40-0-0-0", json!(1), "not a level and place"),
        ("a", json!(1), "not a level and place"),
        ("0-0-0-0", json!(-2), "-2 points"),
        ("0-0-0-0", json!(1e30), "line 1"),
        ("2-3-3-3", json!(-1), "no such file"),
        ("2-3-3-3", json!(7), "the nodes of the hierarchy have 907"),
        ("0-0-0-0", json!(i64::MAX), "the nodes of the hierarchy have 9223372036854"),
    ];
    for (name, count, says) in cases {
        let mut lying = root.clone();
        lying[name] = count.clone();
        std::fs::write(ept.join("ept-hierarchy/0-0-0-0.json"), lying.to_string()).unwrap();
        let error = read(&ept).expect_err(name).to_string();
        assert!(error.starts_with(&*ept.to_string_lossy()) && error.contains(says), "{name} {count}: {error}");
    }
    // More points than numbers count, and more than their tiles can hold.
    let mut many = root.clone();
    many.as_object_mut()
        .unwrap()
        .values_mut()
        .filter(|count| **count != json!(-1))
        .for_each(|count| *count = json!(i64::MAX));
    std::fs::write(ept.join("ept-hierarchy/0-0-0-0.json"), many.to_string()).unwrap();
    let description = std::fs::read(ept.join("ept.json")).unwrap();
    let mut json: Value = serde_json::from_slice(&description).unwrap();
    json["points"] = json!(u64::MAX);
    std::fs::write(ept.join("ept.json"), json.to_string()).unwrap();
    let error = read(&ept).expect_err("many").to_string();
    assert!(error.contains("ept-data/0-0-0-0.bin: ") && error.contains("bytes hold at most 300"), "{error}");
    std::fs::write(ept.join("ept.json"), description).unwrap();
    std::fs::write(ept.join("ept-hierarchy/0-0-0-0.json"), root.to_string()).unwrap();
    // A file below that leads to itself, and one with a node that another file has.
    for (own, says) in [(json!({ below.clone(): -1 }), "read before"), (json!({ "0-0-0-0": 1 }), "a second count")] {
        std::fs::write(ept.join(format!("ept-hierarchy/{below}.json")), own.to_string()).unwrap();
        let error = read(&ept).expect_err(says).to_string();
        assert!(error.contains(says), "{error}");
    }
}

#[test]
fn tiles_that_are_damaged_or_gone_are_refused() {
    for (tiles, ending) in [(Tiles::Laszip, "laz"), (Tiles::Binary, "bin"), (Tiles::Zstandard, "zst")] {
        let (folder, _) = made(tiles, true);
        let ept = folder.path().join("ept");
        let path = ept.join(format!("ept-data/0-0-0-0.{ending}"));
        let store = Ept::open(&ept, LasColumns::default()).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        std::fs::write(&path, &bytes[..bytes.len() / 2 + 1]).unwrap();
        let error = store.read(0).unwrap_err();
        assert!(matches!(error, Error::Truncated { .. } | Error::Malformed { .. }), "{error}");
        std::fs::remove_file(&path).unwrap();
        assert!(matches!(store.read(0), Err(Error::Missing { .. })));
        assert!(matches!(Ept::open(&ept, LasColumns::default()), Err(Error::Missing { .. })));
        // A tile of another node: its points lie elsewhere, or are of another number.
        let other = std::fs::read_dir(ept.join("ept-data")).unwrap().next().unwrap().unwrap().path();
        std::fs::copy(other, &path).unwrap();
        let error = store.read(0).unwrap_err().to_string();
        assert!(error.contains("the hierarchy says 300"), "{error}");
    }
}

#[test]
fn random_damage_never_panics() {
    let (folder, _) = made(Tiles::Binary, true);
    let ept = folder.path().join("ept");
    let files = ["ept.json", "ept-hierarchy/0-0-0-0.json", "ept-data/0-0-0-0.bin"].map(|name| ept.join(name));
    let whole = files.each_ref().map(|path| std::fs::read(path).unwrap());
    let mut random = random(5);
    let mut fine = 0;
    for _ in 0..400 {
        let at = random.random_range(0..files.len());
        let mut bytes = whole[at].clone();
        for _ in 0..random.random_range(1..3) {
            let place = random.random_range(0..bytes.len());
            bytes[place] = random.random();
        }
        std::fs::write(&files[at], bytes).unwrap();
        match read(&ept) {
            Ok(_) => fine += 1,
            Err(error) => assert!(error.to_string().starts_with(&*ept.to_string_lossy()), "{error}"),
        }
        std::fs::write(&files[at], &whole[at]).unwrap();
    }
    assert!(fine > 20, "{fine}");
}
