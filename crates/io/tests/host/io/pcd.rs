//! PCD files by hand: the three ways to store points, and every oddity.

use glam::{DQuat, DVec3, Vec3};
use pellucid_core::cloud::UpAxis;
use pellucid_core::cloud::sensor::Sensor;
use pellucid_core::color::decode_srgb;

use super::{assert_refused, load_bytes};

/// A file with a header of these lines.
fn file(lines: &str, data: &str, payload: &[u8]) -> Vec<u8> {
    [format!("{lines}DATA {data}\n").as_bytes(), payload].concat()
}

/// The usual header of fields with types and sizes, as `x F4`.
fn header(fields: &[(&str, &str)], points: u64) -> String {
    let column = |part: fn(&str) -> String| fields.iter().map(|(_, kind)| part(kind)).collect::<Vec<_>>().join(" ");
    let names: Vec<_> = fields.iter().map(|(name, _)| *name).collect();
    format!(
        "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS {}\nSIZE {}\nTYPE {}\nWIDTH {points}\nHEIGHT 1\n\
         VIEWPOINT 1 2 3 0 1 0 0\nPOINTS {points}\n",
        names.join(" "),
        column(|kind| kind[1..].to_owned()),
        column(|kind| kind[..1].to_owned()),
    )
}

const XYZ: [(&str, &str); 3] = [("x", "F4"), ("y", "F4"), ("z", "F4")];

fn floats(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|value| value.to_le_bytes()).collect()
}

/// Compressed data of literals alone, with their sizes before them.
fn literals(planes: &[u8]) -> Vec<u8> {
    let packed: Vec<u8> = planes.chunks(32).flat_map(|run| [&[run.len() as u8 - 1][..], run].concat()).collect();
    sized(&packed, planes.len() as u32)
}

fn sized(packed: &[u8], unpacked: u32) -> Vec<u8> {
    [&(packed.len() as u32).to_le_bytes()[..], &unpacked.to_le_bytes(), packed].concat()
}

#[test]
fn three_ways_to_store_points() {
    let fields = [&XYZ[..], &[("intensity", "F8"), ("label", "U4"), ("rgb", "F4")]].concat();
    let rgb = [0x00ff_0080u32, 0xffff_ffff];
    let text = format!("1 2 3 0.5 7 {}\n\n-1.5 nan 3 0.25 8 4294967295\n4 5 6 1e3 255 0\n", f32::from_bits(rgb[0]));
    let (points, intensity) = ([[1f32, 2.0, 3.0], [-1.5, f32::NAN, 3.0], [4.0, 5.0, 6.0]], [0.5f64, 0.25, 1000.0]);
    let (label, packed) = ([7u32, 8, 255], [rgb[0], rgb[1], 0]);
    let record = |i: usize| {
        let rest = [&intensity[i].to_le_bytes()[..], &label[i].to_le_bytes(), &packed[i].to_le_bytes()].concat();
        [floats(&points[i]), rest].concat()
    };
    let planes: Vec<u8> = [
        (0..3).flat_map(|axis| floats(&points.map(|point| point[axis]))).collect::<Vec<u8>>(),
        intensity.iter().flat_map(|value| value.to_le_bytes()).collect(),
        label.iter().chain(&packed).flat_map(|value| value.to_le_bytes()).collect(),
    ]
    .concat();
    let lines = header(&fields, 3);
    for file in [
        file(&lines, "ascii", text.as_bytes()),
        file(&lines, "ascii", text.replace('\n', "\r\n").replace(' ', "\t").as_bytes()),
        file(&lines, "ascii", text.replace(' ', ", ").as_bytes()),
        file(&lines, "binary", &[record(0), record(1), record(2)].concat()),
        file(&lines, "binary_compressed", &literals(&planes)),
        file(&lines.replace('\n', "\r\n"), "BINARY", &[record(0), record(1), record(2)].concat()),
    ] {
        let cloud = load_bytes("any", file).unwrap();
        assert_eq!(cloud.positions, [DVec3::new(1.0, 2.0, 3.0), DVec3::new(4.0, 5.0, 6.0)], "where they are");
        assert_eq!((cloud.non_finite, cloud.up), (1, UpAxis::Z));
        assert_eq!(cloud.colors.unwrap(), [Vec3::new(1.0, 0.0, decode_srgb(128.0 / 255.0)), Vec3::ZERO]);
        assert_eq!((cloud.intensity.unwrap(), cloud.classification.unwrap()), (vec![0.5, 1000.0], vec![7, 255]));
        assert_eq!((cloud.alphas, cloud.normals, cloud.scalars.len()), (None, None, 0));
    }
}

#[test]
fn fields_of_any_name_and_type() {
    let fields = [
        ("Z", "I2"),
        ("_", "U1"),
        ("X", "I8"),
        ("Y", "U8"),
        ("Red", "U2"),
        ("Green", "U2"),
        ("Blue", "U2"),
        ("normal_x", "F4"),
        ("normal_y", "F4"),
        ("normal_z", "F4"),
        ("curvature", "I1"),
        ("Classification", "U1"),
    ];
    let record = [
        &(-3i16).to_le_bytes()[..],
        &[99],
        &(-(1i64 << 40)).to_le_bytes(),
        &(1u64 << 50).to_le_bytes(),
        &[255, 0, 0, 0, 51, 0],
        &floats(&[0.0, 0.0, -2.0]),
        &[0xfe, 4],
    ]
    .concat();
    let cloud = load_bytes("a.pcd", file(&header(&fields, 1), "binary", &record)).unwrap();
    assert_eq!(cloud.positions, [DVec3::new(-(2f64.powi(40)), 2f64.powi(50), -3.0)]);
    // Shorts that don't exceed 255 are bytes.
    assert_eq!(cloud.colors.unwrap(), [Vec3::new(1.0, 0.0, decode_srgb(0.2))]);
    assert_eq!((cloud.normals.unwrap(), cloud.classification.unwrap()), (vec![Vec3::NEG_Z], vec![4]));
    assert_eq!(cloud.scalars, [("curvature".to_owned(), vec![-2.0])]);
}

#[test]
fn alpha_groups_and_old_headers() {
    let fields = [&XYZ[..], &[("rgba", "U4")]].concat();
    let with = |alpha: [u32; 2]| {
        let rows = alpha.map(|alpha| format!("0 0 0 {}\n", alpha << 24 | 0x0000_ff00)).concat();
        load_bytes("a.pcd", file(&header(&fields, 2), "ascii", rows.as_bytes())).unwrap()
    };
    let cloud = with([51, 0]);
    assert_eq!((cloud.alphas.unwrap(), cloud.colors.unwrap()[0]), (vec![51.0 / 255.0, 0.0], Vec3::Y));
    assert_eq!(with([0, 0]).alphas, None, "written by nobody");

    let lines = "# a comment\nFIELDS x y z fpfh _\nCOUNT 1 1 1 3 2\nSIZE 4 4 4 4 1\nTYPE F F F F U\nPOINTS 2\n";
    let cloud = load_bytes("a.pcd", file(lines, "ascii", b"1 2 3 4 5 6 7 8\n1 2 3 4 5 6 7 8")).unwrap();
    let names: Vec<_> = cloud.scalars.iter().map(|(name, values)| (name.as_str(), values[1])).collect();
    assert_eq!(names, [("fpfh_0", 4.0), ("fpfh_1", 5.0), ("fpfh_2", 6.0)]);
    // Version 0.5 has COLUMNS, and no number of points but the grid's.
    let old = "VERSION .5\nCOLUMNS x y z\nWIDTH 2\nHEIGHT 2\n";
    let rows = "0 0 0\n".repeat(4);
    assert_eq!(load_bytes("any", file(old, "ascii", rows.as_bytes())).unwrap().len(), 4);
    // Lines after the last announced one are not points.
    let cloud = load_bytes("a.pcd", file(&header(&XYZ, 1), "ascii", b"1 2 3\nend of file\n")).unwrap();
    assert_eq!(cloud.len(), 1);
}

#[test]
fn headers_that_are_wrong() {
    let good = header(&XYZ, 2);
    let refused = |from: &str, to: &str, says: &[&str]| {
        assert!(good.contains(from));
        assert_refused("a.pcd", file(&good.replace(from, to), "ascii", b"1 2 3\n1 2 3\n"), says);
    };
    refused("FIELDS x y z", "FIELDS x y w", &["header", "no field `z`, only [x, y, w]"]);
    refused("FIELDS x y z\n", "", &["header", "no line `FIELDS`"]);
    refused("SIZE 4 4 4", "SIZE 4 4 3", &["line 4", "1, 2, 4 or 8", "`3`"]);
    refused("SIZE 4 4 4", "SIZE 4 4", &["SIZE has 2 values for 3 FIELDS"]);
    refused("SIZE 4 4 4", "SIZE 4 4 2", &["field `z` is a float of 2 bytes"]);
    refused("TYPE F F F", "TYPE F F Q", &["line 5", "`Q`"]);
    refused("WIDTH 2", "WIDTH two", &["line 6", "`two`"]);
    refused("POINTS 2", "POINTS -2", &["line 9", "`-2`"]);
    refused("POINTS 2", "POINTS 3", &["POINTS is 3, but WIDTH × HEIGHT is 2"]);
    refused("HEIGHT 1", "HEIGHT 18446744073709551615", &["too large"]);
    refused("VERSION", "VERSATILE", &["line 2", "`VERSATILE 0.7`"]);
    refused("WIDTH 2\nHEIGHT 1\nVIEWPOINT 1 2 3 0 1 0 0\nPOINTS 2\n", "", &["there is neither POINTS nor WIDTH"]);
    assert_refused("a.pcd", &good, &["line 10", "no line `DATA`"]);
    assert_refused("a.pcd", file(&good, "zipped", b""), &["line 10", "\"zipped\"", "binary_compressed"]);
    assert_refused("a.pcd", "hello", &["line 1", "`hello`"]);
    assert_refused("a.pcd", vec![b'#'; 3 << 20], &["no line `DATA` in the first 1048576 bytes"]);
    assert_refused("a.pcd", file(&header(&XYZ, 0), "binary", b""), &["the cloud has no points"]);
}

#[test]
fn truncated_and_lying_payloads() {
    let lines = |points: u64| header(&XYZ, points);
    let rows = floats(&[1.0; 9]);
    let says = ["announces 3 points of at least 12 bytes each", "35 bytes after it hold at most 2"];
    assert_refused("a.pcd", file(&lines(3), "binary", &rows[..35]), &says);
    for count in [1_000_000_000_000, u64::MAX] {
        for data in ["ascii", "binary", "binary_compressed"] {
            assert_refused(
                "a.pcd",
                file(&lines(count), data, &rows),
                &[&format!("announces {count} points"), "at most"],
            );
        }
    }
    assert_refused("a.pcd", file(&lines(2), "ascii", b"1 2 3\n1.5 2.5 x\n"), &["line 12", "field `z`: `x` is not"]);
    assert_refused(
        "a.pcd",
        file(&lines(2), "ascii", b"1 2 3\n1.5 2.5\n"),
        &["line 12", "there is no value for field `z`"],
    );
    assert_refused("a.pcd", file(&lines(2), "ascii", b"1 2 3\n1 2 3 4\n"), &["line 12", "1 more values"]);
    assert_refused("a.pcd", file(&lines(2), "ascii", b"1.5 2.5 3.5\n1.5"), &["ends in line 12", "after 1 of the 2"]);
    assert_refused("a.pcd", file(&lines(2), "ascii", b"1.55 2.55 3.55\n"), &["ends at line 11 after 1 of the 2"]);

    let compressed = |points, payload: &[u8]| file(&lines(points), "binary_compressed", payload);
    assert_eq!(load_bytes("a.pcd", compressed(3, &literals(&rows))).unwrap().len(), 3);
    assert_refused(
        "a.pcd",
        compressed(3, &literals(&rows[..24])),
        &["24 unpacked bytes are announced, but 3 points need 36"],
    );
    assert_refused("a.pcd", compressed(3, &literals(&rows)[..30]), &["announced, but only 22 are left"]);
    assert_refused("a.pcd", compressed(3, &[1, 2, 3]), &["before the sizes"]);
    assert_refused("a.pcd", compressed(3, &sized(&[3 << 5, 7], 36)), &["refers to 8 bytes back, but there are only 0"]);
    assert_refused("a.pcd", compressed(3, &sized(&[1, 2, 3], 36)), &["expand to 2 bytes, not to 36"]);
    // The most that a byte becomes is 88; more is a lie before any is decoded.
    let lie = compressed(1 << 20, &sized(&[0; 1000], 12 << 20));
    assert_refused("a.pcd", lie, &["announces 1048576 points", "hold at most"]);

    let count = lines(1).replace("TYPE", "COUNT 1 1 18446744073709551615\nTYPE");
    assert_refused(
        "a.pcd",
        file(&count, "binary", &rows),
        &["announces 1 points of at least 18446744073709551615 bytes"],
    );
    let count = lines(0).replace("TYPE", "COUNT 1 1 1000000000\nTYPE");
    assert_refused("a.pcd", file(&count, "binary", &rows), &["COUNT gives a point 1000000002 numbers"]);
    let none = lines(5).replace("TYPE", "COUNT 0 0 0\nTYPE");
    assert_refused("a.pcd", file(&none, "binary", &rows), &["announces 5 points"]);
}

/// An organized file of 40 × 30 points with this line about its sensor.
fn organized(viewpoint: &str, place: impl Fn(f64, f64) -> DVec3) -> Vec<u8> {
    let points = (0..30).flat_map(|row| (0..40).map(move |column| (f64::from(row), f64::from(column))));
    let text: String =
        points.map(|(row, column)| place(row, column)).map(|p| format!("{} {} {}\n", p.x, p.y, p.z)).collect();
    let lines =
        format!("VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 40\nHEIGHT 30\n{viewpoint}POINTS 1200\n");
    file(&lines, "ascii", text.as_bytes())
}

#[test]
fn organized_clouds_have_the_sensor_of_their_viewpoint() {
    let depth = |row: f64, column: f64| DVec3::new(column - 19.5, row - 14.5, 30.0) * (0.1 + 0.01 * (column % 3.0));
    let of = |file: Vec<u8>| load_bytes("any", file).unwrap().sensor;
    assert_eq!(of(organized("", depth)), Some(Sensor::depth_camera(DVec3::ZERO, DQuat::IDENTITY)));
    // A half turn about z; quaternions need not have length 1.
    let (place, turn) = (DVec3::new(1.0, -2.0, 3.5), DQuat::from_xyzw(0.0, 0.0, 1.0, 0.0));
    let turned = organized("VIEWPOINT 1 -2 3.5 0 0 0 2\n", |row, column| place + turn * depth(row, column));
    assert_eq!(of(turned), Some(Sensor::depth_camera(place, turn)));
    // A half turn about x, as PCL's grabbers write it beside points that are not turned.
    let legacy = organized("VIEWPOINT 0 0 0 0 1 0 0\n", depth);
    assert_eq!(of(legacy), Some(Sensor::depth_camera(DVec3::ZERO, DQuat::IDENTITY)));
    let laser = |row: f64, column: f64| {
        let (azimuth, elevation) = ((9.0 * column).to_radians(), (10.0 - row).to_radians());
        DVec3::new(azimuth.cos(), azimuth.sin(), elevation.tan()) * (5.0 + row % 4.0)
    };
    assert_eq!(of(organized("", laser)), Some(Sensor::laser(DVec3::ZERO, DQuat::IDENTITY)));
    let moved = organized("VIEWPOINT 1 -2 3.5 1 0 0 0\n", |row, column| place + laser(row, column));
    assert_eq!(of(moved), Some(Sensor::laser(place, DQuat::IDENTITY)));
    // No rotation, no numbers, too few of them, and a cloud that is not organized.
    for line in ["VIEWPOINT 1 2 3 0 0 0 0\n", "VIEWPOINT nan 2 3 1 0 0 0\n", "VIEWPOINT 1 2 3\n"] {
        assert_eq!(of(organized(line, depth)), None, "{line}");
    }
    let flat = String::from_utf8(organized("", depth)).unwrap().replace("WIDTH 40\nHEIGHT 30", "WIDTH 1200\nHEIGHT 1");
    assert_eq!(of(flat.into_bytes()), None);
}
