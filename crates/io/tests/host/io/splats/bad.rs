//! Damaged and made-up files of splats: each is refused with a message that says what is wrong, or read as far as it
//! goes.

use std::io::Write;

use serde_json::{Value, json};

use super::super::{Folder, assert_refused, load, load_bytes};
use super::{bytes, folder};

/// Small files, and the name that they are read under.
const FILES: [&str; 15] = [
    "minimal/minimal.splat",
    "minimal/minimal.ksplat",
    "minimal/minimal-v2.spz",
    "minimal/minimal-v3.spz",
    "minimal/minimal-v4.spz",
    "minimal/minimal-raw.spz",
    "soup.ply",
    "soup.compressed.ply",
    "soup.sog",
    "soup.glb",
    "soup.gltf",
    "soup-mode2.ksplat",
    "soup-v1.spz",
    "soup-v2.spz",
    "soup-v4.spz",
];

/// The name without its folder.
fn name_of(file: &str) -> &str {
    file.rsplit('/').next().unwrap()
}

/// Every length of the smallest files, and every 13th of the others.
#[test]
fn truncated_files() {
    for file in FILES {
        let (whole, name, own) = (bytes(file), name_of(file), Folder::new());
        for len in (1..whole.len()).rev().step_by(if whole.len() < 1000 { 1 } else { 13 }) {
            let path = own.file(name, &whole[..len]);
            let result = load(&path);
            if file.ends_with(".splat") && len % 32 == 0 {
                assert_eq!(result.unwrap().len(), len / 32);
                continue;
            }
            let Err(error) = result else { panic!("{file}: the first {len} of {} bytes are read", whole.len()) };
            let message = error.to_string();
            assert!(message.starts_with(&format!("{}: ", path.display())), "{file} of {len} bytes: {message}");
        }
    }
}

/// No byte of the smallest files, and no 23rd of the others, may make a reader panic. What is read is whole.
#[test]
fn changed_bytes() {
    for file in FILES {
        let (whole, name, own) = (bytes(file), name_of(file), Folder::new());
        let step = if whole.len() < 300 { 1 } else { 23 };
        for (at, value) in (0..whole.len()).step_by(step).flat_map(|at| [0, 1, 0x7f, 0xff].map(|value| (at, value))) {
            let mut changed = whole.clone();
            changed[at] = value;
            let path = own.file(name, &changed);
            if let Ok(cloud) = load(&path)
                && let Some(gaussians) = &cloud.gaussians
            {
                assert_eq!((gaussians.len(), !cloud.positions.is_empty()), (cloud.positions.len(), true), "{file}");
                assert_eq!(gaussians.harmonics.len(), gaussians.len() * gaussians.coefficients(), "{file}");
            }
        }
    }
}

/// The bytes of a file with some others at a place.
fn patched(file: &str, at: usize, with: &[u8]) -> Vec<u8> {
    let mut bytes = bytes(file);
    bytes[at..at + with.len()].copy_from_slice(with);
    bytes
}

#[test]
fn splat_and_ksplat() {
    assert_refused(
        "a.splat",
        [0; 33],
        &["truncated", "33 bytes are 1 splats of 32 bytes each, and 1 bytes of an incomplete one"],
    );
    assert_refused("a.splat", [0; 32], &["splats: 1 splats are left out", "no extent"]);
    let refused =
        |at, with: &[u8], says: &[&str]| assert_refused("a.ksplat", patched("soup-mode2.ksplat", at, with), says);
    refused(0, &[1], &["byte 0", "version 1.1, expected 0.1"]);
    refused(4, &[0xff; 4], &["truncated", "4294967295 sections, but the file has room for only 2 section headers"]);
    refused(16, &[41], &["byte 16", "41 splats are announced, but the sections have 40"]);
    refused(20, &[3], &["byte 20", "compression mode 3, expected 0, 1 or 2"]);
    refused(4096, &[0xff; 4], &["section 0", "4294967295 splats, but room for only 40"]);
    refused(
        4096,
        &[0xff; 8],
        &[
            "truncated",
            "section 0",
            "4294967295 rows of 48 bytes end at byte 206158435320, but the file has 7080 bytes",
        ],
    );
    refused(4096 + 8, &[1], &["section 0", "3 buckets of 12 bytes, 2 of them full with 1 splats", "10 splats of 40"]);
    refused(4096 + 12, &[0xff; 4], &["truncated", "section 0"]);
    refused(4096 + 40, &[4], &["section 0", "harmonics have degree 4, expected at most 3"]);
}

/// A header of SPZ.
fn spz(version: u32, count: u32, degree: u8, fraction: u8) -> Vec<u8> {
    let mut header = b"NGSP".to_vec();
    header.extend(version.to_le_bytes());
    header.extend(count.to_le_bytes());
    header.extend([degree, fraction, 0, 0]);
    header
}

fn gzip(content: &[u8]) -> Vec<u8> {
    let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::best());
    encoder.write_all(content).unwrap();
    encoder.finish().unwrap()
}

#[test]
fn spz_headers() {
    for pack in [gzip, |content: &[u8]| content.to_vec()] {
        let refused = |version, count, degree, fraction, says: &[&str]| {
            assert_refused("a.spz", pack(&spz(version, count, degree, fraction)), says);
        };
        refused(0, 1, 0, 12, &["byte 4 of the header", "SPZ version 0, expected 1 to 4"]);
        refused(5, 1, 0, 12, &["byte 4 of the header", "SPZ version 5, expected 1 to 4"]);
        refused(2, 1, 5, 12, &["byte 12 of the header", "harmonics of degree 5, expected at most 4"]);
        refused(2, 1, 0, 25, &["byte 13 of the header", "25 fractional bits", "expected at most 24"]);
        refused(2, 1, 0, 12, &["truncated", "0 bytes are left for the 9 bytes of positions of 1 splats"]);
    }
    assert_refused(
        "a.spz",
        gzip(b"something else"),
        &["byte 0", "expected `NGSP`", "\"somethin\"", "unpack other files"],
    );
    assert_refused("a.spz", gzip(&spz(4, 1, 0, 12)), &["version 4 in a gzip stream, expected 1, 2 or 3"]);
    assert_refused("a.spz", "nothing", &["byte 0", "expected `NGSP` or"]);
    assert_refused("a.spz", gzip(&spz(2, 0, 0, 12)), &["the cloud has no points"]);
    // The last eight bytes are checksum and length.
    let mut wrong = bytes("soup-v2.spz");
    let at = wrong.len() - 8;
    wrong[at] ^= 1;
    assert_refused("a.spz", wrong, &["gzip stream", "checksum"]);
}

#[test]
fn spz_streams() {
    let refused = |at, with: &[u8], says: &[&str]| assert_refused("a.spz", patched("soup-v4.spz", at, with), says);
    refused(15, &[5], &["byte 15 of the header", "5 streams, expected 6 for harmonics of degree 2"]);
    refused(16, &[31], &["byte 16 of the header", "a table of 6 streams at byte 31"]);
    refused(16, &[0xff; 4], &["byte 16 of the header", "at byte 4294967295, but the file has 1522 bytes"]);
    refused(32, &[0xff; 8], &["truncated", "the stream of positions has 18446744073709551615 bytes"]);
    refused(
        40,
        &[0xff; 8],
        &["stream of positions", "18446744073709551615 bytes are announced, but 40 splats have 360"],
    );
    // Behind the table.
    refused(32 + 6 * 16, &[0], &["stream of positions"]);
}

/// SOG in a folder of its own, with a changed description.
fn sog(change: impl FnOnce(&mut Value)) -> String {
    let own = tempfile::tempdir().unwrap();
    for entry in std::fs::read_dir(folder().join("soup-folder")).unwrap() {
        let path = entry.unwrap().path();
        std::fs::copy(&path, own.path().join(path.file_name().unwrap())).unwrap();
    }
    let mut json = serde_json::from_slice(&bytes("soup-folder/meta.json")).unwrap();
    change(&mut json);
    std::fs::write(own.path().join("meta.json"), json.to_string()).unwrap();
    let message = load(own.path()).map_or_else(|error| error.to_string(), |cloud| format!("{:?}", cloud.warnings));
    message.replace(&own.path().display().to_string(), "")
}

#[test]
fn sog_descriptions() {
    type Change = fn(&mut Value);
    let cases: [(Change, &[&str]); 20] = [
        (|json| json["version"] = 3.into(), &["/meta.json: ", "SOG version 3, expected 2"]),
        (|json| drop(json.as_object_mut().unwrap().remove("version")), &["/meta.json: ", "SOG 1 is not supported"]),
        (|json| *json = json!({}), &["/meta.json: ", "neither `version` nor `means`"]),
        (|json| drop(json.as_object_mut().unwrap().remove("quats")), &["/meta.json: ", "missing field `quats`"]),
        (|json| json["count"] = (-1).into(), &["/meta.json: ", "invalid value"]),
        (|json| json["count"] = 41_000.into(), &["/means_l.webp: ", "240 bytes for 41000 splats: more than 32"]),
        (|json| json["count"] = 7_000.into(), &["/means_l.webp: ", "pixels are fewer than the 7000 splats"]),
        (|json| json["count"] = u64::MAX.into(), &["/meta.json: 18446744073709551615 points take at least", "memory"]),
        (
            |json| json["scales"]["codebook"] = json!([]),
            &["/meta.json: ", "`scales.codebook` has 0 numbers, expected 1 to 256"],
        ),
        (|json| json["sh0"]["codebook"] = vec![0.0; 257].into(), &["`sh0.codebook` has 257 numbers"]),
        (|json| json["sh0"]["codebook"][3] = Value::Null, &["/meta.json: ", "invalid type: null"]),
        (|json| json["sh0"]["codebook"] = json!([1.0]), &["splats are left out: each has a number that is not finite"]),
        (|json| json["scales"]["codebook"] = vec![1e4; 256].into(), &["splats: 40 splats are left out"]),
        (|json| json["shN"]["codebook"] = json!([]), &["`shN.codebook` has 0 numbers"]),
        (|json| json["shN"]["bands"] = 5.into(), &["`shN.bands` is 5, expected at most 4"]),
        (|json| json["shN"]["bands"] = 3.into(), &["/shN_centroids.webp: ", "expected 960 ×"]),
        (|json| json["shN"]["count"] = 0.into(), &["`shN.count` is 0, expected 1 to 65536"]),
        (|json| json["shN"]["count"] = 1.into(), &["/shN_labels.webp: ", "refers to entry", "of a palette of 1"]),
        (
            |json| json["quats"]["files"][0] = "../quats.webp".into(),
            &["\"../quats.webp\" is not the name of a file in the same folder"],
        ),
        (|json| json["quats"]["files"][0] = "meta.json".into(), &["not a WebP picture"]),
    ];
    for (change, says) in cases {
        let message = sog(change);
        for words in says {
            assert!(message.contains(words), "`{words}` is not in: {message}");
        }
    }
    assert!(sog(|json| json["quats"]["files"][0] = "none.webp".into()).ends_with("/none.webp: no such file"));
    assert_eq!(sog(|json| json["antialias"] = true.into()), "[]");
}

#[test]
fn sog_archives() {
    assert_refused("a.sog", "nothing", &["byte 0", "expected `PK`"]);
    assert_refused("a.sog", b"PK\x03\x04 and nothing else", &["ZIP archive"]);
    let mut archive = bytes("soup.sog");
    let at = archive.windows(9).rposition(|bytes| bytes == b"meta.json").unwrap();
    archive[at] = b'x';
    assert_refused("a.sog", &archive, &["ZIP archive", "the ZIP archive has no meta.json", "8 other files"]);
    let mut archive = bytes("soup.sog");
    let at = archive.windows(10).rposition(|bytes| bytes == b"quats.webp").unwrap();
    archive[at] = b'x';
    assert_refused("a.sog", &archive, &["quats.webp", "the ZIP archive has no file quats.webp"]);
    // A changed byte of a picture that is stored as it is.
    let mut archive = bytes("soup.sog");
    let at = archive.windows(4).position(|bytes| bytes == b"RIFF").unwrap();
    archive[at + 60] ^= 1;
    let error = load_bytes("a.sog", &archive).unwrap_err().to_string();
    assert!(error.contains("means_l.webp"), "{error}");
}

/// The header of a compressed PLY file with something replaced.
fn compressed(from: &str, to: &str) -> Vec<u8> {
    let whole = bytes("soup.compressed.ply");
    let end = whole.windows(11).position(|bytes| bytes == b"end_header\n").unwrap();
    let header = String::from_utf8(whole[..end].to_vec()).unwrap();
    assert!(header.contains(from), "{header}");
    [header.replace(from, to).as_bytes(), &whole[end..]].concat()
}

#[test]
fn compressed_ply_headers() {
    for (from, to, says) in [
        (
            "element vertex 40",
            "element vertex 400",
            &["header", "1 chunks of 256 splats don't match 400 splats"] as &[&str],
        ),
        ("element vertex 40", "element vertex 41", &["header", "element `sh` has 40 records for 41 splats"]),
        ("element chunk 1", "element junk 1", &["header", "compressed splats need an element `chunk`"]),
        ("property float min_z", "property float min_q", &["header", "element `chunk` has no property `min_z`"]),
        ("property uchar f_rest_0\n", "", &["header", "23 properties of element `sh`, expected 0, 9, 24, 45 or 72"]),
        ("property float max_b", "property double max_b", &["truncated", "40 records of element `sh`", "end at byte"]),
        ("property uint packed_color", "property list uchar uint packed_colors", &["no property `x`"]),
        ("property float min_x", "property list uchar float min_x", &["header", "`chunk`", "list"]),
    ] {
        assert_refused("a.ply", compressed(from, to), says);
    }
    let huge = compressed("element vertex 40", "element vertex 18446744073709551615");
    load_bytes("a.ply", huge).unwrap_err();
}
