//! Missing, empty, truncated, lying and wrong input, end to end: the error, the status, no file, no memory.

use std::fs;

use tempfile::TempDir;

use crate::{assert_refused, folder, inside, pellucid, write_cloud};

/// A binary PLY whose header announces `count` points.
fn ply(format: &str, count: u64, rows: &[u8]) -> Vec<u8> {
    let properties = "property float x\nproperty float y\nproperty float z\n";
    let header = format!("ply\nformat {format} 1.0\nelement vertex {count}\n{properties}end_header\n");
    [header.as_bytes(), rows].concat()
}

/// A LAS 1.4 file of 10 points whose header announces `count`.
fn las(count: u64, compressed: bool) -> Vec<u8> {
    let mut builder = las::Builder::from((1, 4));
    builder.point_format = las::point::Format::new(6).unwrap();
    builder.point_format.is_compressed = compressed;
    let header = builder.into_header().unwrap();
    let mut writer = las::Writer::new(std::io::Cursor::new(Vec::new()), header).unwrap();
    for i in 0..10 {
        let point = las::Point { x: f64::from(i), gps_time: Some(0.0), ..Default::default() };
        writer.write_point(point).unwrap();
    }
    let mut bytes = writer.into_inner().unwrap().into_inner();
    // The legacy count and that of LAS 1.4.
    bytes[107..111].fill(0);
    bytes[247..255].copy_from_slice(&count.to_le_bytes());
    bytes
}

/// Asserts that every command refuses a file and says these things about it.
fn assert_unusable(folder: &TempDir, name: &str, parts: &[&str]) {
    let parts = [&[name], parts].concat();
    for args in [vec!["render", name, "-o", "out.png"], vec!["render", name, "-o", "out.exr"], vec!["info", name]] {
        assert_refused(folder, &args, 1, &parts);
    }
}

#[test]
fn missing_empty_and_truncated_files() {
    let folder = folder();
    assert_unusable(&folder, "none.ply", &["no such file"]);
    assert_unusable(&folder, "none.laz", &["no such file"]);
    let whole = ply("binary_little_endian", 2, &[0; 24]);
    for (name, content, says) in [
        ("zero.ply", vec![], "empty file (0 bytes)"),
        ("zero.laz", vec![], "empty file (0 bytes)"),
        ("none.ply", ply("ascii", 0, b""), "the cloud has no points"),
        ("none.las", las(0, false), "the cloud has no points"),
        ("nan.ply", ply("ascii", 1, b"nan 0 0\n"), "the cloud has no points"),
        ("cut.ply", whole[..whole.len() - 1].to_vec(), "truncated file or wrong header"),
        ("cut.las", las(10, false)[..500].to_vec(), "truncated file or wrong header"),
        ("cut.laz", las(10, true)[..450].to_vec(), ".laz: "),
        ("notes.txt", b"to do\n".to_vec(), "line 1: no column `x`, only [to, do]"),
        ("notes.md", b"to do\n".to_vec(), "unknown format; expected a point cloud (PLY, LAS, LAZ, COPC, E57, PCD"),
    ] {
        fs::write(inside(&folder, name), content).unwrap();
        assert_unusable(&folder, name, &[says]);
    }
}

#[test]
fn headers_that_lie_cost_no_memory() {
    let folder = folder();
    let count = 1_000_000_000_000;
    let pcd = |data: &str| {
        let header = format!("FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH {count}\nHEIGHT 1\nDATA {data}\n");
        [header.as_bytes(), &[0; 1200]].concat()
    };
    let grid = format!("{count}\n1\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n1 2 3\n");
    for (name, content) in [
        ("binary.ply", ply("binary_little_endian", count, &[0; 1200])),
        ("big.ply", ply("binary_big_endian", count, &[0; 1200])),
        ("ascii.ply", ply("ascii", count, &b"1 2 3\n".repeat(100))),
        ("plain.las", las(count, false)),
        ("packed.laz", las(count, true)),
        ("ascii.pcd", pcd("ascii")),
        ("binary.pcd", pcd("binary")),
        ("compressed.pcd", pcd("binary_compressed")),
        ("scan.pts", format!("{count}\n1 2 3\n").into_bytes()),
        ("grid.ptx", grid.into_bytes()),
        ("count.e57", e57(|xml| xml.replace("recordCount=\"5\"", &format!("recordCount=\"{count}\"")))),
    ] {
        fs::write(inside(&folder, name), content).unwrap();
        assert_unusable(&folder, name, &["1000000000000"]);
        #[cfg(unix)]
        assert_modest(&folder, name);
    }
    // Headers that announce no number of points to check, but many other numbers.
    let numbers = "FIELDS x y z\nCOUNT 1 1 1000000000\nPOINTS 0\nDATA binary\n";
    let constant = "<returnCount type=\"Integer\" minimum=\"5\" maximum=\"5\"/>".repeat(1000);
    let prototype = "<prototype type=\"Structure\">";
    let bit = "type=\"Integer\" minimum=\"0\" maximum=\"1\"/>";
    for (name, content) in [
        ("numbers.pcd", numbers.as_bytes().to_vec()),
        ("line.csv", vec![b'1'; 4 << 20]),
        ("fields.csv", b"x,".repeat(400_000)),
        ("constants.e57", e57(|xml| xml.replace(prototype, &format!("{prototype}{constant}")))),
        ("bits.e57", e57(|xml| xml.replace("Count=\"5", "Count=\"6").replace("type=\"Float\">0</cartesianX>", bit))),
        ("deep.e57", e57(|xml| xml.replace("</e57Root>", &("<a>".repeat(100_000) + "</e57Root>")))),
    ] {
        fs::write(inside(&folder, name), content).unwrap();
        assert_unusable(&folder, name, &[name]);
        #[cfg(unix)]
        assert_modest(&folder, name);
    }
}

/// An E57 file of five points with its XML changed.
fn e57(change: impl Fn(String) -> String) -> Vec<u8> {
    use e57::{E57Writer, Record, RecordValue};
    let mut bytes = std::io::Cursor::new(Vec::new());
    let mut writer = E57Writer::new(&mut bytes, "file").unwrap();
    let prototype = vec![Record::CARTESIAN_X_F64, Record::CARTESIAN_Y_F64, Record::CARTESIAN_Z_F64];
    let mut cloud = writer.add_pointcloud("scan", prototype).unwrap();
    (0..5).for_each(|_| cloud.add_point(vec![RecordValue::Double(1.0); 3]).unwrap());
    cloud.finalize().unwrap();
    drop(cloud);
    writer.finalize_customized_xml(|xml| Ok(change(xml))).unwrap();
    drop(writer);
    bytes.into_inner()
}

/// Address space in KiB in which `info` must get along: 200 MiB.
#[cfg(unix)]
const MODEST: u32 = 200 << 10;

/// Asserts that `info` gets along with little address space: the message is the same, and not that of an allocator.
#[cfg(unix)]
fn assert_modest(folder: &TempDir, name: &str) {
    let binary = pellucid(folder, &[]).get_program().to_owned();
    let mut shell = assert_cmd::Command::new("sh");
    let script = format!("ulimit -v {MODEST} && exec \"$0\" info \"$1\"");
    // An allocator reserves address space for each thread that it never touches.
    shell.current_dir(folder).env("MALLOC_ARENA_MAX", "1").env("RAYON_NUM_THREADS", "1");
    let output = shell.args(["-c", &script]).arg(binary).arg(name).output().unwrap();
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1), "{name}: {stderr}");
    assert!(stderr.starts_with(&format!("error: {name}: ")), "{stderr}");
}

#[test]
fn wrong_scene_files_leave_no_picture() {
    let folder = folder();
    write_cloud(&inside(&folder, "a.ply"));
    let cloud = "[[cloud]]\npath = \"a.ply\"\n";
    for (text, place) in [
        ("[[cloud]\npath = 1\n".to_owned(), "s.toml:1:"),
        (format!("{cloud}radius = \"large\"\n"), "s.toml:3:10: `cloud.0.radius`"),
        (format!("{cloud}colour = [1, 1, 1]\n"), "s.toml:3:1: unknown key"),
        (format!("[image]\nsize = [0, 10]\n{cloud}"), "s.toml:2:9: `image.size`"),
        (format!("[camera]\nfov_y = 45\nheight = 2\n{cloud}"), "s.toml:"),
        (format!("[method]\nname = \"none\"\n{cloud}"), "s.toml:2:8: "),
    ] {
        fs::write(inside(&folder, "s.toml"), text).unwrap();
        for output in ["out.png", "out.exr"] {
            assert_refused(&folder, &["render", "s.toml", "-o", output], 2, &[place]);
        }
    }
    // A cloud that isn't there is no mistake of the scene file.
    fs::write(inside(&folder, "s.toml"), "[[cloud]]\npath = \"lost.ply\"\n").unwrap();
    assert_refused(&folder, &["render", "s.toml", "-o", "out.png"], 1, &["lost.ply: no such file"]);
}
