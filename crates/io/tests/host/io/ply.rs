//! PLY: encodings, types, names, and what is written back.

use glam::{DVec3, Vec3};
use pellucid_core::cloud::{Cloud, UpAxis};
use pellucid_core::color::decode_srgb;
use pellucid_io::ply;

use super::{Folder, load, load_bytes};

/// File of the same two vertices with one property of each scalar type, between other elements with lists.
fn file(format: &str, number: impl Fn(&mut Vec<u8>, &str, f64)) -> Vec<u8> {
    let types = ["char", "uint8", "int16", "ushort", "int", "uint32", "float", "float64"];
    let mut bytes = format!("ply\r\nformat {format} 1.0\r\n\r\ncomment caf\u{e9}\r\n").into_bytes();
    bytes.extend(b"comment \xe9\nelement camera 2\nproperty list uchar short where\nproperty float f\n");
    bytes.extend(b"element note 1\nproperty uint n\nelement vertex 2\n");
    bytes.extend(b"property double X\nproperty float y\nproperty list int float skip\nproperty float64 Z\n");
    for ty in types {
        bytes.extend(format!("property {ty} scalar_of.{ty}[0]\n").bytes());
    }
    bytes.extend(b"element face 1\nproperty list uchar int vertex_indices\nend_header\n");
    let mut row = |values: &[(&str, f64)]| {
        values.iter().for_each(|(ty, value)| number(&mut bytes, ty, *value));
        if format == "ascii" {
            bytes.extend(b"\r\n\n");
        }
    };
    row(&[("uchar", 2.0), ("short", -1.0), ("short", 5.0), ("float", 0.5)]);
    row(&[("uchar", 0.0), ("float", 0.25)]);
    row(&[("uint", 9.0)]);
    for vertex in VERTICES {
        let [x, y, z] = [vertex[0], vertex[1], vertex[2]];
        let position = [("double", x), ("float", y), ("int", 2.0), ("float", 7.0), ("float", 8.0), ("double", z)];
        row(&position.into_iter().chain(types.into_iter().zip(vertex.into_iter().skip(3))).collect::<Vec<_>>());
    }
    bytes
}

/// x, y, z, then the extremes of each type; all are exact in float32 but those of the 32-bit integers.
const VERTICES: [[f64; 11]; 2] = [
    [500_000.123_456_789, 0.5, -1e300, -128.0, 255.0, -32768.0, 65535.0, -2147483648.0, 4294967295.0, 1.5, -0.25],
    [-1.0, 2.0, 3.0, 127.0, 0.0, 32767.0, 0.0, 2147483647.0, 0.0, -2.5, 1024.0],
];

fn text(bytes: &mut Vec<u8>, _: &str, value: f64) {
    bytes.extend(format!("{value} ").bytes());
}

fn binary(bytes: &mut Vec<u8>, ty: &str, value: f64, order: fn(Vec<u8>) -> Vec<u8>) {
    bytes.extend(order(match ty {
        "char" => (value as i8).to_le_bytes().to_vec(),
        "uchar" | "uint8" => (value as u8).to_le_bytes().to_vec(),
        "short" | "int16" => (value as i16).to_le_bytes().to_vec(),
        "ushort" => (value as u16).to_le_bytes().to_vec(),
        "int" => (value as i32).to_le_bytes().to_vec(),
        "uint" | "uint32" => (value as u32).to_le_bytes().to_vec(),
        "float" => (value as f32).to_le_bytes().to_vec(),
        _ => value.to_le_bytes().to_vec(),
    }));
}

#[test]
fn encodings_types_lists_and_other_elements() {
    let little = file("binary_little_endian", |bytes, ty, value| binary(bytes, ty, value, |b| b));
    let big = file("binary_big_endian", |bytes, ty, value| {
        binary(bytes, ty, value, |b| b.into_iter().rev().collect());
    });
    for (name, bytes) in [("text", file("ascii", text)), ("little", little), ("big", big)] {
        let cloud = load_bytes("any", &bytes).unwrap_or_else(|e| panic!("{name}: {e}"));
        let positions: Vec<_> = VERTICES.iter().map(|v| DVec3::new(v[0], v[1], v[2])).collect();
        assert_eq!(cloud.positions, positions, "{name}");
        assert_eq!(cloud.up, UpAxis::Y);
        assert_eq!(cloud.scalars.len(), 8);
        assert_eq!(cloud.scalars[2].0, "scalar_of.int16[0]");
        for (column, (property, values)) in cloud.scalars.iter().enumerate() {
            let wanted = VERTICES.map(|v| v[3 + column] as f32);
            assert_eq!(values[..], wanted, "{name}, {property}");
        }
    }
}

fn vertices(properties: &str, rows: &str) -> Cloud {
    let count = rows.lines().count();
    let header = format!("ply\nformat ascii 1.0\nelement vertex {count}\n");
    let properties: String = properties.split(", ").map(|p| format!("property {p}\n")).collect();
    load_bytes("a.ply", format!("{header}{properties}end_header\n{rows}")).unwrap()
}

#[test]
fn names_that_tools_use() {
    for names in [["nx", "ny", "nz"], ["Normal_X", "normal_y", "normal_z"], ["normalx", "normaly", "normalz"]] {
        let [a, b, c] = names;
        let cloud = vertices(&format!("float x, float y, float z, float {a}, float {b}, float {c}"), "0 0 0 0 3 4");
        // 3-4-5 triangle.
        assert_eq!(cloud.normals, Some(vec![Vec3::new(0.0, 0.6, 0.8)]), "{names:?}");
        assert!(cloud.scalars.is_empty());
    }
    for names in [["red", "green", "blue"], ["R", "G", "B"], ["diffuse_red", "diffuse_green", "diffuse_blue"]] {
        let [a, b, c] = names;
        let cloud = vertices(&format!("float x, float y, float z, uchar {a}, uchar {b}, uchar {c}"), "0 0 0 0 51 255");
        assert_eq!(cloud.colors, Some(vec![Vec3::new(0.0, decode_srgb(0.2), 1.0)]), "{names:?}");
    }
    for name in ["classification", "scalar_Classification", "label", "class"] {
        let cloud = vertices(&format!("float x, float y, float z, int {name}"), "0 0 0 5\n0 0 1 255");
        assert_eq!(cloud.classification, Some(vec![5, 255]), "{name}");
    }
    for name in ["intensity", "scalar_Intensity"] {
        let cloud = vertices(&format!("float x, float y, float z, float {name}"), "0 0 0 0.125");
        assert_eq!(cloud.intensity, Some(vec![0.125]), "{name}");
    }
    let cloud =
        vertices("float x, float y, float z, float radius, uchar alpha", "0 0 0 2 51\n0 0 0 -1 0\n0 0 0 nan 255");
    assert_eq!(cloud.radii, Some(vec![2.0, 0.0, 0.0]), "a radius that is none is 0");
    assert_eq!(cloud.alphas, Some(vec![0.2, 0.0, 1.0]));
}

#[test]
fn properties_that_fit_no_column_become_scalars() {
    let cloud = vertices("float x, float y, float z, int label, uchar red, float nx", "0 0 0 -1 7 1\n0 0 0 300 8 0");
    assert_eq!((&cloud.classification, &cloud.colors, &cloud.normals), (&None, &None, &None));
    let names: Vec<_> = cloud.scalars.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names, ["red", "nx", "label"]);
    assert_eq!(cloud.scalars[2].1, [-1.0, 300.0]);
    // Two properties of one meaning, and of one name.
    let cloud = vertices(
        "float x, float y, float z, float intensity, float scalar_intensity, float a, float a",
        "0 0 0 1 2 3 4",
    );
    assert_eq!(cloud.intensity, Some(vec![1.0]));
    assert_eq!(cloud.scalars.iter().map(|(_, v)| v[0]).collect::<Vec<_>>(), [2.0, 3.0, 4.0]);
}

#[test]
fn color_types() {
    let color = |ty: &str, values: &str| {
        let cloud = vertices(
            &format!("float x, float y, float z, {ty} red, {ty} green, {ty} blue"),
            &format!("0 0 0 {values}"),
        );
        cloud.colors.unwrap()[0]
    };
    let wanted = Vec3::new(0.0, decode_srgb(0.2), 1.0);
    assert_eq!(color("uchar", "0 51 255"), wanted);
    assert_eq!(color("int", "-4 51 255"), wanted);
    assert_eq!(color("ushort", "0 13107 65535"), wanted);
    assert_eq!(color("float", "-1 0.2 1.5"), wanted);
    assert_eq!(color("double", "nan 0.2 inf"), wanted);
    // Signed bytes: 255 is stored as −1.
    assert_eq!(color("char", "0 51 -1"), wanted);
}

#[test]
fn normals_without_direction_are_zero() {
    let properties = "float x, float y, float z, float nx, float ny, float nz";
    let cloud = vertices(properties, "0 0 0 0 0 0\n0 0 0 nan 0 1\n0 0 0 inf 0 0\n0 0 0 0 0 1e-30\n0 0 0 1e30 0 0");
    assert_eq!(cloud.normals.unwrap(), [Vec3::ZERO, Vec3::ZERO, Vec3::ZERO, Vec3::Z, Vec3::X]);
    assert_eq!(vertices(properties, "0 0 0 0 0 0\n1 0 0 0 0 0").normals, None, "no point has a normal");
}

#[test]
fn points_that_are_not_finite_are_dropped_from_every_column() {
    let properties = "float x, float y, float z, float nx, float ny, float nz, uchar red, uchar green, uchar blue, \
                      uchar alpha, float radius, uchar class, float intensity, float extra";
    let row = |x: &str, n: u8| format!("{x} 0 0 0 0 1 {n} {n} {n} {n} {n} {n} {n} {n}\n");
    let rows = [row("1", 1), row("nan", 2), row("3", 3), row("-inf", 4), row("5", 5)].concat();
    let cloud = vertices(properties, &rows);
    assert_eq!((cloud.len(), cloud.non_finite), (3, 2));
    let odd = vec![1.0, 3.0, 5.0];
    assert_eq!(cloud.positions.iter().map(|p| p.x as f32).collect::<Vec<_>>(), odd);
    assert_eq!(
        cloud.colors.unwrap().iter().map(|c| c.x).collect::<Vec<_>>(),
        [1.0, 3.0, 5.0].map(|v| decode_srgb(v / 255.0))
    );
    assert_eq!(cloud.alphas.unwrap(), [1.0, 3.0, 5.0].map(|v: f32| v / 255.0));
    assert_eq!(cloud.radii, Some(odd.clone()));
    assert_eq!(cloud.classification, Some(vec![1, 3, 5]));
    assert_eq!(cloud.intensity, Some(odd.clone()));
    assert_eq!(cloud.scalars, [("extra".to_owned(), odd)]);
    assert_eq!(cloud.normals.unwrap().len(), 3);
}

/// Cloud with one point for each 8-bit value in each column that is stored so.
fn full_cloud(offset: DVec3) -> Cloud {
    let value = |i: u16| f32::from(i) / 255.0;
    Cloud {
        positions: (0..256u16).map(|i| DVec3::new(f64::from(i) * 0.25, -1.0, 0.0) + offset).collect(),
        colors: Some(
            (0..256)
                .map(|i| Vec3::new(value(i), value(255 - i), 0.5).map(|v| decode_srgb((v * 255.0).round() / 255.0)))
                .collect(),
        ),
        alphas: Some((0..256).map(value).collect()),
        normals: Some((0..256).map(|i| Vec3::new(1.0, value(i), -2.0).normalize()).collect()),
        radii: Some((0..256).map(value).collect()),
        classification: Some((0..=255).collect()),
        intensity: Some((0..256u16).map(|i| f32::from(i) * 257.0).collect()),
        scalars: vec![("height".to_owned(), (0..256).map(|i| value(i) - 0.5).collect())],
        ..Cloud::default()
    }
}

#[test]
fn written_clouds_are_read_back_exactly() {
    let folder = Folder::new();
    let path = folder.0.path().join("out.ply");
    let plain = Cloud { positions: vec![DVec3::new(0.1, 0.2, 0.3)], ..Cloud::default() };
    // A survey, whose vertical the file can't say, but its coordinates do.
    let surveyed = Cloud { up: UpAxis::Z, ..full_cloud(DVec3::new(5e5, 4.5e6, 0.01)) };
    for cloud in [full_cloud(DVec3::ZERO), surveyed, plain] {
        ply::write(&path, &cloud).unwrap();
        assert_eq!(load(&path).unwrap(), cloud);
    }
    assert_eq!(std::fs::read_dir(folder.0.path()).unwrap().count(), 1, "a temporary file is left");
}

#[test]
fn positions_are_double_only_where_float_would_round() {
    let folder = Folder::new();
    let path = folder.0.path().join("out.ply");
    for (x, property) in [(0.25, "property float x"), (0.1, "property double x")] {
        ply::write(&path, &Cloud { positions: vec![DVec3::new(x, 0.0, 0.0)], ..Cloud::default() }).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        assert!(String::from_utf8_lossy(&bytes).contains(property), "{x}");
    }
}

#[test]
fn names_with_blanks_and_of_other_columns_survive_writing() {
    let folder = Folder::new();
    let path = folder.0.path().join("out.ply");
    let scalars = vec![("pulse  width ".to_owned(), vec![1.0]), ("pulse_width".to_owned(), vec![2.0])];
    let cloud = Cloud { positions: vec![DVec3::ZERO], scalars, ..Cloud::default() };
    ply::write(&path, &cloud).unwrap();
    let back = load(&path).unwrap().scalars;
    assert_eq!(back, [("pulse_width".to_owned(), vec![1.0]), ("pulse_width".to_owned(), vec![2.0])]);
}

#[test]
fn a_failed_write_names_the_file() {
    let folder = Folder::new();
    let path = folder.0.path().join("no/such/folder/out.ply");
    let message = ply::write(&path, &full_cloud(DVec3::ZERO)).unwrap_err().to_string();
    assert!(message.starts_with(&format!("{}: not written: ", path.display())), "{message}");
}

#[test]
fn survey_coordinates_stand_on_z() {
    let up = |offset: [f64; 3]| {
        let row = |x: f64| format!("{} {} {}\n", offset[0] + x, offset[1], offset[2]);
        vertices("double x, double y, double z", &(row(0.0) + &row(50.0))).up
    };
    assert_eq!(up([0.0, 0.0, 0.0]), UpAxis::Y);
    assert_eq!(up([500_000.0, 4_500_000.0, 100.0]), UpAxis::Z);
    assert_eq!(up([-20_000.0, 30_000.0, 0.0]), UpAxis::Z);
    // Far along one axis only, or along all of them: no survey's eastings, northings and heights.
    assert_eq!(up([500_000.0, 100.0, 4_500_000.0]), UpAxis::Y);
    assert_eq!(up([500_000.0, 500_000.0, 500_000.0]), UpAxis::Y);
    // So large that it is not far from the origin for its size: a model in small units.
    let row = |x: f64| format!("{x} {x} 0\n");
    let large = vertices("double x, double y, double z", &(row(0.0) + &row(90_000.0)));
    assert_eq!(large.up, UpAxis::Y);
}
