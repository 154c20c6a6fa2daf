//! Missing, empty, truncated, lying and damaged files: an error that says where and why, never a panic.

use pellucid_io::Error;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::las::{sample, with_extra_bytes};
use super::{Folder, assert_refused, load, load_bytes};

#[test]
fn missing_empty_folder_and_unknown() {
    let folder = Folder::new();
    assert!(matches!(load(&folder.0.path().join("none.ply")), Err(Error::Missing { .. })));
    assert!(matches!(load(folder.0.path()), Err(Error::Folder { .. })));
    assert_refused("a.ply", "", &["empty file (0 bytes)"]);
    assert_refused(
        "a.dat",
        "one 2 3\n",
        &["unknown format; expected a point cloud (PLY, LAS, LAZ, COPC, E57, PCD", "one 2 3"],
    );
    assert_refused("a.las", "ABCDEFGH", &["byte 0", "expected `LASF`", "ABCD"]);
    assert_refused("a.PLY", "plain text", &["byte 0", "expected `ply`", "plain te"]);
    assert_refused("a.ply", "plywood\nend_header\n", &["line 1", "plywood"]);
}

fn ply(format: &str, count: &str, rows: &[u8]) -> Vec<u8> {
    let properties = "property float x\nproperty float y\nproperty float z\n";
    let header = format!("ply\nformat {format} 1.0\nelement vertex {count}\n{properties}end_header\n");
    [header.as_bytes(), rows].concat()
}

/// The file is as long as its header says, but takes no room on the disk.
#[cfg(target_os = "linux")]
#[test]
fn more_points_than_memory_holds_are_refused_before_they_are_read() {
    let folder = Folder::new();
    let path = folder.0.path().join("huge.ply");
    let count = 100_000_000_000u64;
    let header = ply("binary_little_endian", &count.to_string(), b"");
    std::fs::write(&path, &header).unwrap();
    let file = std::fs::File::options().write(true).open(&path).unwrap();
    file.set_len(header.len() as u64 + 12 * count).unwrap();
    let error = load(&path).unwrap_err();
    // Three float64 for each.
    assert!(
        matches!(error, Error::TooLarge { points, needed, .. } if (points, needed) == (count, 24 * count)),
        "{error}"
    );
    assert!(error.to_string().contains("pellucid prepare"), "{error}");
}

#[test]
fn clouds_without_points() {
    assert_refused("a.ply", ply("ascii", "0", b""), &["the cloud has no points"]);
    let rows = b"nan 0 0\n0 inf 0\n";
    assert_refused(
        "a.ply",
        ply("ascii", "2", rows),
        &["the cloud has no points", "all 2 have a coordinate that is not finite"],
    );
    assert_refused("a.las", sample(2, 0, false, 0), &["the cloud has no points"]);
    assert_refused("a.laz", sample(2, 0, true, 0), &["the cloud has no points"]);
}

#[test]
fn headers_of_ply() {
    let vertex = |lines: &str| format!("ply\nformat ascii 1.0\nelement vertex 1\n{lines}end_header\n1 2 3\n");
    let xy = vertex("property float x\nproperty int y\nproperty float other\n");
    assert_refused("a.ply", xy, &["no property `z`", "[x, y, other]"]);
    assert_refused("a.ply", vertex("property list uchar int x\n"), &["no property `x`"]);
    assert_refused("a.ply", "ply\nformat ascii 1.0\nend_header\n", &["header", "no element `vertex`"]);
    assert_refused("a.ply", vertex("property fluid x\n"), &["line 4", "property fluid x"]);
    assert_refused("a.ply", "ply\nformat ascii 1.0\nproperty float x\nend_header\n", &["line 3", "property float x"]);
    assert_refused("a.ply", "ply\nformat text 1.0\nend_header\n", &["line 2", "format text"]);
    assert_refused("a.ply", "ply\nend_header\n", &["header", "format"]);
    assert_refused("a.ply", "ply\nformat ascii 1.0\nelement vertex -1\nend_header\n", &["line 3"]);
    assert_refused("a.ply", "ply\nformat ascii 1.0\nelement vertex 1\n", &["line 4", "no line `end_header`"]);
    assert_refused("a.ply", b"ply".repeat(1 << 20), &["line 1", "no line `end_header` in the first"]);
    let endless = [b"ply\ncomment ".to_vec(), vec![b'x'; 3 << 20]].concat();
    assert_refused("a.ply", endless, &["line 2", "no line `end_header` in the first"]);
}

#[test]
fn truncated_and_lying_ply() {
    let points = [[1f32, 2.0, 3.0]; 3].concat();
    let rows: Vec<u8> = points.iter().flat_map(|v| v.to_le_bytes()).collect();
    let binary = |count: &str, rows: &[u8]| ply("binary_little_endian", count, rows);
    assert_eq!(load_bytes("a.ply", binary("3", &rows)).unwrap().len(), 3);
    let says = ["truncated file or wrong header", "announces 3 × element `vertex`", "35 bytes left", "at most 2"];
    assert_refused("a.ply", binary("3", &rows[..35]), &says);
    for count in ["4", "1000000000000", "18446744073709551615"] {
        assert_refused("a.ply", binary(count, &rows), &[&format!("announces {count} ×"), "hold at most 3"]);
        let text = ply("ascii", count, b"1 2 3\n1 2 3\n1 2 3\n");
        assert_refused("a.ply", text, &["truncated file or wrong header", "1"]);
    }
    assert_refused("a.ply", binary("99999999999999999999", &rows), &["line 3"]);
    let text = ply("ascii", "3", b"1.5 2.5 3.5\n1.5 2.5 3.5\n");
    assert_refused("a.ply", text, &["ends at line 9 after 2 of the 3 records of element `vertex`"]);
    let text = ply("ascii", "2", b"1.5 2.5 3.5\n1.5 2.");
    assert_refused("a.ply", text, &["truncated", "ends in line 9, after 1 of the 2 records of element `vertex`"]);
    assert_refused("a.ply", ply("ascii", "2", b"1.5 2.5 3.5\n1 2\n"), &["line 9", "expected 3 values, found 2"]);
    assert_refused("a.ply", ply("ascii", "2", b"1.5 2.5 3.5\n\n1 2 3 4\n"), &["line 10", "1 more values"]);
    assert_refused("a.ply", ply("ascii", "1", b"1 2,5 3\n"), &["line 8", "property `y`", "`2,5` is not a number"]);
}

#[test]
fn lying_lists_of_ply() {
    let header = "ply\nformat binary_little_endian 1.0\nelement face 2\nproperty list TYPE double skip\nelement vertex 1\n\
                  property uchar x\nproperty uchar y\nproperty uchar z\nend_header\n";
    let file = |ty: &str, rows: &[u8]| [header.replace("TYPE", ty).as_bytes(), rows].concat();
    assert_eq!(load_bytes("a.ply", file("uchar", &[0, 0, 1, 2, 3])).unwrap().len(), 1);
    assert_refused("a.ply", file("uint", &[255; 40]), &["record 0 of element `face`"]);
    assert_refused("a.ply", file("char", &[0, 255, 1, 2, 3]), &["element `face`, record 1", "-1 items"]);
    assert_refused("a.ply", file("float", &[0, 0, 192, 127, 0, 0, 192, 127, 1, 2, 3]), &["NaN items"]);
}

/// Overwrites some bytes.
fn patched(mut file: Vec<u8>, at: usize, bytes: &[u8]) -> Vec<u8> {
    file[at..at + bytes.len()].copy_from_slice(bytes);
    file
}

/// Bytes of the LAS header that the tests change.
mod field {
    pub const MAJOR: usize = 24;
    pub const POINTS_START: usize = 96;
    pub const VLR_COUNT: usize = 100;
    pub const FORMAT: usize = 104;
    pub const RECORD_LEN: usize = 105;
    pub const COUNT: usize = 107;
    pub const SCALE_X: usize = 131;
    pub const COUNT_14: usize = 247;
}

#[test]
fn truncated_and_lying_las() {
    let plain = sample(2, 1, false, 10);
    assert_refused("a.las", &plain[..plain.len() - 1], &["announces 10 points of 28 bytes each", "hold at most 9"]);
    assert_refused("a.las", &plain[..100], &["within the LAS header, at byte 100"]);
    assert_refused("a.las", patched(plain.clone(), field::COUNT, &[255; 4]), &["announces 4294967295 points"]);
    assert_refused("a.las", patched(plain.clone(), field::MAJOR, &[7]), &["version 7.2"]);
    assert_refused("a.las", patched(plain.clone(), field::POINTS_START, &[255; 4]), &["start at byte 4294967295"]);
    assert_refused("a.las", patched(plain.clone(), field::FORMAT, &[11]), &["point format 11"]);
    assert_refused("a.las", patched(plain.clone(), field::FORMAT, &[203]), &["point format 203"]);
    assert_refused("a.las", patched(plain.clone(), field::RECORD_LEN, &[27, 0]), &["27 bytes", "needs 28"]);
    assert_refused(
        "a.las",
        patched(plain.clone(), field::FORMAT, &[129]),
        &["LAZ record of the header: it is missing"],
    );
    // More records than fit before the points: the points are there all the same.
    let vlrs = patched(plain.clone(), field::VLR_COUNT, &[255; 4]);
    assert_eq!(load_bytes("a.las", vlrs).unwrap().len(), 10);
    // A scale that is not a number leaves no finite point.
    let nan = patched(plain, field::SCALE_X, &f64::NAN.to_le_bytes());
    assert_refused("a.las", nan, &["no points (all 10 have a coordinate that is not finite)"]);
    for compressed in [false, true] {
        let large = patched(sample(4, 6, compressed, 10), field::COUNT, &[0; 4]);
        let lie = patched(large, field::COUNT_14, &1_000_000_000_000u64.to_le_bytes());
        assert_refused("a.las", lie, &["announces 1000000000000 points"]);
    }
}

#[test]
fn truncated_and_lying_laz() {
    for (minor, format) in [(2, 1), (4, 6)] {
        let file = sample(minor, format, true, 1000);
        let start = u32::from_le_bytes(file[field::POINTS_START..field::POINTS_START + 4].try_into().unwrap()) as usize;
        let table = u64::from_le_bytes(file[start..start + 8].try_into().unwrap()) as usize;
        assert_refused(
            "a.laz",
            &file[..table - 100],
            &["chunk table should be", &format!("has {} bytes", table - 100)],
        );
        assert_refused(
            "a.laz",
            patched(file.clone(), table + 4, &[255; 4]),
            &["chunk table at byte", "4294967295 chunks"],
        );
        assert_refused("a.laz", patched(file.clone(), start, &[255; 8]), &["chunk table"]);
        let count = if minor < 4 { field::COUNT } else { field::COUNT_14 };
        let more = patched(file.clone(), count, &60_000u32.to_le_bytes());
        assert_refused("a.laz", more, &["60000 points"]);
        let longer = patched(file.clone(), field::RECORD_LEN, &100u16.to_le_bytes());
        assert_refused("a.laz", longer, &["LAZ record", "a point record has 100"]);
        if format == 6 {
            // The size of the first layer: after the place of the table, a point and the count.
            let lie = patched(file, start + 8 + 30 + 4, &[255; 4]);
            assert_refused("a.laz", lie, &["points 0–999", "its layers take"]);
        }
    }
}

/// The decoder takes kilobytes of memory for each byte of a record.
#[test]
fn huge_records_of_laz() {
    for (minor, format, len) in [(2, 1, 28), (4, 6, 30)] {
        let most = with_extra_bytes(minor, format, true, 2048 - len);
        assert_eq!(load_bytes("a.laz", most).unwrap().len(), 1);
        let more = with_extra_bytes(minor, format, true, 2049 - len);
        assert_refused("a.laz", more, &["LAZ record", "2049 bytes (at most 2048)"]);
        let plain = with_extra_bytes(minor, format, false, 60_000);
        assert_eq!(load_bytes("a.las", plain).unwrap().len(), 1);
    }
}

/// Sizes of fields whose sum is that of a record only in 16 bits.
#[test]
fn fields_of_laz_beyond_sixteen_bits() {
    let file = sample(2, 1, true, 10);
    // The record of the header ends with its fields, of 6 bytes each: type, size, version.
    let start = u32::from_le_bytes(file[field::POINTS_START..field::POINTS_START + 4].try_into().unwrap()) as usize;
    assert_eq!(file[start - 12..start], [6, 0, 20, 0, 2, 0, 7, 0, 8, 0, 2, 0]);
    // Extra bytes, 61 440 and 4124 of them: 65 536 more than the 28 of a record.
    let lie = patched(file, start - 12, &[0, 0, 0, 240, 2, 0, 0, 0, 28, 16, 2, 0]);
    assert_refused("a.laz", lie, &["LAZ record", "its fields take 65564 bytes, but a point record has 28"]);
}

#[test]
fn random_damage_never_panics() {
    let text = b"ply\nformat ascii 1.0\ncomment c\nelement e 1\nproperty list uchar int l\nelement vertex 3\nproperty float x\n\
        property float y\nproperty float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n\
        2 1 2\n1 2 3 4 5 6\n1 2 3 4 5 6\n1 2 3 4 5 6\n";
    let binary = ply("binary_big_endian", "4", &[66; 48]);
    let laz = [(2, 3), (4, 7), (4, 8)].map(|(minor, format)| sample(minor, format, true, 200));
    let mut files = vec![text.to_vec(), binary, sample(2, 3, false, 20), sample(4, 8, false, 20)];
    files.extend(laz);
    let folder = Folder::new();
    let mut rng = Pcg64Mcg::seed_from_u64(1);
    let mut refused = 0;
    for file in &files {
        for _ in 0..150 {
            let mut damaged = file.clone();
            for _ in 0..rng.random_range(1..4) {
                let at = rng.random_range(0..damaged.len());
                damaged[at] = if rng.random() { 255 } else { rng.random() };
            }
            if rng.random_range(0..4) == 0 {
                damaged.truncate(rng.random_range(0..damaged.len()));
            }
            refused += usize::from(load(&folder.file("damaged", damaged)).is_err());
        }
    }
    // Most damage to headers shows; damage to coordinates can't.
    assert!(refused > 100, "only {refused} damaged files were refused");
}
