//! Scans as their makers meant them: what writers put into files that other readers take for something else.

use e57::{Record, RecordDataType, RecordName, RecordValue};
use glam::{DVec3, Vec3};
use las::point::Format;
use las::{Color, Point, Vlr};
use pellucid_core::cloud::Cloud;
use pellucid_core::color::decode_srgb;

use super::e57::{Scan, write_with};
use super::las::{builder, point, sample, with_withheld, write};
use super::{assert_refused, load_bytes};

/// Red and blue, sRGB-encoded.
const TWO: [[u16; 3]; 2] = [[200, 40, 30], [30, 60, 200]];

/// The linear colors of [`TWO`].
fn two() -> Vec<Vec3> {
    TWO.map(|color| Vec3::from(color.map(|value| decode_srgb(f32::from(value) / 255.0)))).to_vec()
}

/// Asserts that a cloud has nearly the colors of [`TWO`]: writers round.
#[track_caller]
fn assert_two(cloud: &Cloud, of: &str) {
    let colors = cloud.colors.as_deref().unwrap_or_default();
    let off = colors.iter().zip(two()).map(|(found, wanted)| (*found - wanted).abs().max_element());
    assert!(colors.len() == 2 && off.fold(0.0, f32::max) < 4e-3, "{of}: {colors:?}");
}

fn patched(mut bytes: Vec<u8>, at: usize, with: &[u8]) -> Vec<u8> {
    bytes[at..at + with.len()].copy_from_slice(with);
    bytes
}

const MINOR: usize = 25;
const COUNT: usize = 107;
const COUNT_14: usize = 247;

#[test]
fn las_1_5_has_its_points() {
    for compressed in [false, true] {
        let newer = patched(sample(4, 6, compressed, 300), MINOR, &[5]);
        let newer = patched(newer, COUNT, &[0; 4]);
        assert_eq!(load_bytes("a.las", newer).unwrap().len(), 300);
    }
    assert_refused("a.las", patched(sample(4, 6, false, 3), MINOR, &[6]), &["version 1.6 (known: 1.0 to 1.5)"]);
}

#[test]
fn the_64_bit_count_wins() {
    let with = |legacy: u32, count: u64| {
        let bytes = patched(sample(4, 6, false, 300), COUNT, &legacy.to_le_bytes());
        load_bytes("a.las", patched(bytes, COUNT_14, &count.to_le_bytes())).unwrap()
    };
    for legacy in [100, u32::MAX] {
        let cloud = with(legacy, 300);
        assert_eq!(cloud.len(), 300);
        let said = format!("its 32-bit count says {legacy} points, its 64-bit count 300, which is used");
        assert_eq!(cloud.warnings, [said]);
    }
    for (legacy, count) in [(0, 300), (300, 300), (300, 0)] {
        let cloud = with(legacy, count);
        assert_eq!((cloud.len(), cloud.warnings.len()), (300, 0), "{legacy}, {count}");
    }
}

#[test]
fn withheld_points_are_left_out_and_counted() {
    for (minor, format, compressed) in [(1, 0, false), (2, 1, false), (2, 3, true), (4, 6, false), (4, 7, true)] {
        let cloud = load_bytes("a.las", with_withheld(minor, format, compressed, 90)).unwrap();
        assert_eq!((cloud.len(), cloud.withheld, cloud.non_finite), (72, 18, 0), "1.{minor}, format {format}");
        assert_eq!(cloud.intensity.unwrap()[..4], [1.0, 2.0, 3.0, 4.0]);
    }
    // In LAS 1.0 the bit is part of the class.
    let old = patched(with_withheld(1, 0, false, 90), MINOR, &[0]);
    assert_eq!(load_bytes("a.las", old).unwrap().len(), 90);
}

/// A descriptor of extra bytes: a type, a name, and the bytes of the number that means "no value".
fn descriptor(kind: u8, name: &str, no_data: Option<[u8; 8]>) -> Vec<u8> {
    let mut bytes = vec![0; 192];
    bytes[2] = kind;
    bytes[4..4 + name.len()].copy_from_slice(name.as_bytes());
    if let Some(value) = no_data {
        bytes[3] = 1;
        bytes[40..48].copy_from_slice(&value);
    }
    bytes
}

fn described(data: Vec<u8>) -> Vlr {
    Vlr { user_id: "LASF_Spec".to_owned(), record_id: 4, description: String::new(), data }
}

/// Points of format 6 with these extra bytes.
fn with_extra(vlrs: Vec<Vlr>, evlrs: Vec<Vlr>, compressed: bool, points: &[&[u8]]) -> Vec<u8> {
    let mut builder = builder(4, 6, compressed);
    builder.point_format.extra_bytes = points[0].len() as u16;
    (builder.vlrs, builder.evlrs) = (vlrs, evlrs);
    let plain = |bytes: &&[u8]| Point {
        number_of_returns: 1,
        extra_bytes: bytes.to_vec(),
        ..point(&Format::new(6).unwrap(), 0)
    };
    write(builder, points.iter().map(plain))
}

#[test]
fn extra_bytes_without_a_value_are_no_numbers() {
    // The number is stored in the widest type of the class, whatever the scale.
    let float = |value: f32| value.to_le_bytes();
    let mut scaled = descriptor(4, "hag", Some((-9999i64).to_le_bytes()));
    scaled[3] |= 1 << 3;
    scaled[112..120].copy_from_slice(&0.01f64.to_le_bytes());
    let short = |value: i16| value.to_le_bytes();
    let cases = [
        (descriptor(9, "hag", Some((-9999.0f64).to_le_bytes())), [&float(-9999.0)[..], &float(10.5)], 10.5),
        (descriptor(9, "hag", Some(f64::from(0.1f32).to_le_bytes())), [&float(0.1)[..], &float(0.25)], 0.25),
        (scaled, [&short(-9999)[..], &short(1234)], 12.34),
        // As RIEGL writes it: without the sign.
        (descriptor(4, "hag", Some(0x8000u64.to_le_bytes())), [&short(i16::MIN)[..], &short(5)], 5.0),
        (descriptor(1, "hag", Some(255u64.to_le_bytes())), [&[255][..], &[7]], 7.0),
        (descriptor(10, "hag", Some(1e300f64.to_le_bytes())), [&1e300f64.to_le_bytes()[..], &2f64.to_le_bytes()], 2.0),
    ];
    for (descriptor, points, wanted) in cases {
        for compressed in [false, true] {
            let file = with_extra(vec![described(descriptor.clone())], vec![], compressed, &points);
            let (_, values) = &load_bytes("a.las", file).unwrap().scalars[0];
            assert!(values[0].is_nan() && values[1] == wanted, "{values:?}");
        }
    }
    // Without the option the number is one.
    let plain = with_extra(vec![described(descriptor(1, "hag", None))], vec![], false, &[&[255], &[7]]);
    assert_eq!(load_bytes("a.las", plain).unwrap().scalars[0].1, [255.0, 7.0]);
}

#[test]
fn extra_bytes_of_all_records_are_read() {
    let (first, second) = (descriptor(1, "first", None), descriptor(3, "second", None));
    let other = Vlr { user_id: "somebody".to_owned(), record_id: 4, description: String::new(), data: vec![0; 192] };
    let wanted = [("first".to_owned(), vec![1.0, 2.0]), ("second".to_owned(), vec![258.0, 770.0])];
    for (vlrs, evlrs) in [
        (vec![first.clone()], vec![second.clone()]),
        (vec![], vec![first.clone(), second.clone()]),
        (vec![first.clone(), second.clone()], vec![]),
        (vec![], vec![[first, second].concat()]),
    ] {
        let records = |data: Vec<Vec<u8>>| data.into_iter().map(described).chain([other.clone()]).collect();
        let file = with_extra(records(vlrs), records(evlrs), false, &[&[1, 2, 1], &[2, 2, 3]]);
        assert_eq!(load_bytes("a.las", file).unwrap().scalars, wanted);
    }
}

#[test]
fn las_records_behind_the_points_that_lie_do_no_harm() {
    let file = with_extra(vec![], vec![described(descriptor(1, "first", None))], false, &[&[1], &[2]]);
    let start = u64::from_le_bytes(file[235..243].try_into().unwrap()) as usize;
    for (at, with) in [
        (235, u64::MAX.to_le_bytes().to_vec()),
        (235, vec![0; 8]),
        (243, u32::MAX.to_le_bytes().to_vec()),
        (start + 20, u64::MAX.to_le_bytes().to_vec()),
        (start + 20, (1u64 << 40).to_le_bytes().to_vec()),
    ] {
        assert_eq!(load_bytes("a.las", patched(file.clone(), at, &with)).unwrap().len(), 2);
    }
}

#[test]
fn las_colors_have_the_bits_that_their_largest_needs() {
    let colors = |scale: fn(u16) -> u16, extra: Option<u16>| {
        let builder = builder(2, 2, false);
        let format = builder.point_format;
        let points =
            TWO.map(|[r, g, b]| Point { color: Some(Color::new(scale(r), scale(g), scale(b))), ..point(&format, 0) });
        let black = extra.map(|red| Point { color: Some(Color::new(red, 0, 0)), ..point(&format, 0) });
        let mut cloud = load_bytes("a.las", write(builder, points.into_iter().chain(black))).unwrap();
        cloud.colors.iter_mut().for_each(|colors| colors.truncate(2));
        cloud
    };
    assert_two(&colors(|value| value, None), "8 bits");
    assert_two(&colors(|value| value, Some(256)), "8 bits, counted to 256");
    assert_two(&colors(|value| (u32::from(value) * 1023 / 255) as u16, None), "10 bits");
    assert_two(&colors(|value| (u32::from(value) * 4095 / 255) as u16, None), "12 bits");
    assert_two(&colors(|value| value * 257, None), "16 bits");
}

/// A PLY file of two points with a property.
fn ply(properties: &str, values: [String; 2]) -> Cloud {
    let header = format!(
        "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\n{properties}end_header\n"
    );
    let rows = values.iter().zip([0, 1]).map(|(values, x)| format!("{x} 0 0 {values}\n")).collect::<String>();
    load_bytes("a.ply", header + &rows).unwrap()
}

#[test]
fn ply_colors_have_the_range_of_their_values() {
    let types = [("float", 255.0), ("double", 255.0), ("ushort", 255.0), ("short", 255.0), ("int", 255.0)];
    let wide = [("float", 65535.0), ("int", 65535.0), ("uint", 65535.0), ("ushort", 65535.0), ("double", 1.0)];
    for (kind, full) in types.into_iter().chain(wide).chain([("uchar", 255.0), ("float", 1.0)]) {
        for names in [["red", "green", "blue"], ["Rf", "Gf", "Bf"], ["scalar_R", "scalar_G", "scalar_B"]] {
            let properties: String = names.iter().map(|name| format!("property {kind} {name}\n")).collect();
            let values = TWO.map(|color| color.map(|value| (f64::from(value) * full / 255.0).to_string()).join(" "));
            assert_two(&ply(&properties, values), &format!("{kind} of {full}, {}", names[0]));
        }
    }
}

#[test]
fn colors_have_the_names_that_programs_give_them() {
    let prefixes = ["", "diffuse_", "vertex_", "color_", "f_", "scalar_", "Color_"];
    for prefix in prefixes {
        let properties: String =
            ["red", "green", "blue"].iter().map(|name| format!("property uchar {prefix}{name}\n")).collect();
        let values = TWO.map(|color| color.map(|value| value.to_string()).join(" "));
        assert_two(&ply(&properties, values), prefix);
    }
    let cloud = load_bytes(
        "a.txt",
        "//X;Y;Z;Rf;Gf;Bf;Intensity;Nx;Ny;Nz\n0;0;0;0.784314;0.156863;0.117647;7;0;0;1\n1;0;0;0.117647;0.235294;0.784314;8;0;0;1\n",
    );
    assert_two(&cloud.unwrap(), "CloudCompare");
}

#[test]
fn an_alpha_of_zero_everywhere_is_none() {
    let rgba = "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty uchar alpha\n";
    let with = |alphas: [u8; 2]| {
        let row =
            |(color, alpha): ([u16; 3], u8)| color.map(|value| value.to_string()).join(" ") + &format!(" {alpha}");
        ply(rgba, [row((TWO[0], alphas[0])), row((TWO[1], alphas[1]))])
    };
    let cloud = with([0, 0]);
    assert_two(&cloud, "no alpha");
    assert_eq!((cloud.alphas, &*cloud.warnings), (None, &["alpha is 0 at every point and is ignored".to_owned()][..]));
    let cloud = with([0, 51]);
    assert_eq!((cloud.alphas, cloud.warnings.len()), (Some(vec![0.0, 0.2]), 0));
    let faint = with([2, 6]);
    assert!(faint.alphas.is_some() && faint.warnings[0].contains("no alpha is above 0.02"), "{:?}", faint.warnings);
    let cloud = load_bytes("a.csv", "x,y,z,r,g,b,a\n0,0,0,1,0,0,0\n1,0,0,0,1,0,0\n").unwrap();
    assert_eq!((cloud.alphas, cloud.warnings.len()), (None, 1));
}

/// A file of two points in scans of these intensities, in a type.
fn intensities(kind: &RecordDataType, scans: &[[f32; 2]], change: impl Fn(String) -> String) -> Vec<f32> {
    let prototype = || {
        vec![
            Record::CARTESIAN_X_F64,
            Record::CARTESIAN_Y_F64,
            Record::CARTESIAN_Z_F64,
            Record { name: RecordName::Intensity, data_type: kind.clone() },
        ]
    };
    let value = |value: f32| match kind {
        RecordDataType::Single { .. } => RecordValue::Single(value),
        RecordDataType::Double { .. } => RecordValue::Double(value.into()),
        _ => RecordValue::Integer(value as i64),
    };
    let point =
        |x: f64, own: f32| vec![RecordValue::Double(x), RecordValue::Double(0.0), RecordValue::Double(0.0), value(own)];
    let scan = |own: &[f32; 2]| Scan {
        prototype: prototype(),
        pose: None,
        points: vec![point(0.0, own[0]), point(1.0, own[1])],
    };
    load_bytes("a.e57", write_with(scans.iter().map(scan).collect(), change)).unwrap().intensity.unwrap()
}

#[test]
fn e57_intensities_without_limits_that_hold_stay_as_they_are() {
    let same = |xml: String| xml;
    let own = [[0.0, 4000.0]];
    for kind in [RecordDataType::F32, RecordDataType::F64] {
        assert_eq!(intensities(&kind, &own, same), own[0]);
    }
    let any = RecordDataType::Single { min: Some(-f32::MAX), max: Some(f32::MAX) };
    assert_eq!(intensities(&any, &own, same), own[0]);
    for false_limits in [[0.0, 0.0], [0.0, 1.0], [0.0, 255.0]] {
        let kind = RecordDataType::Single { min: Some(false_limits[0]), max: Some(false_limits[1]) };
        assert_eq!(intensities(&kind, &own, same), own[0], "{false_limits:?}");
    }
    assert_eq!(intensities(&RecordDataType::F32, &[[-2048.0, 1952.0]], same), [-2048.0, 1952.0]);
    let kind = RecordDataType::Single { min: Some(0.0), max: Some(4000.0) };
    assert_eq!(intensities(&kind, &own, same), [0.0, 1.0]);
    assert_eq!(intensities(&RecordDataType::Integer { min: 0, max: 4000 }, &[[1000.0, 3000.0]], same), [0.25, 0.75]);
    // One of two scans has false limits: the scans stay alike.
    assert_eq!(intensities(&kind, &[[0.0, 2000.0], [0.0, 8000.0]], same), [0.0, 2000.0, 0.0, 8000.0]);
}

#[test]
fn e57_colors_have_the_range_of_their_values_where_limits_are_false() {
    let colors = |kind: RecordDataType, full: f64, limits: Option<&str>| {
        let mut prototype = vec![Record::CARTESIAN_X_F64, Record::CARTESIAN_Y_F64, Record::CARTESIAN_Z_F64];
        let names = [RecordName::ColorRed, RecordName::ColorGreen, RecordName::ColorBlue];
        prototype.extend(names.map(|name| Record { name, data_type: kind.clone() }));
        let value = |value: u16| {
            let value = f64::from(value) * full / 255.0;
            match kind {
                RecordDataType::Single { .. } => RecordValue::Single(value as f32),
                _ => RecordValue::Integer(value.round() as i64),
            }
        };
        let point = |color: [u16; 3]| [0.0; 3].map(RecordValue::Double).into_iter().chain(color.map(value)).collect();
        let scan = Scan { prototype, pose: None, points: TWO.map(point).to_vec() };
        let change = |xml: String| match limits {
            Some(limits) => xml
                .replace(">65535</color", &format!(">{limits}</color"))
                .replace(">255</color", &format!(">{limits}</color")),
            None => xml,
        };
        load_bytes("a.e57", write_with(vec![scan], change)).unwrap()
    };
    let integer = |max| RecordDataType::Integer { min: 0, max };
    assert_two(&colors(integer(65535), 65535.0, None), "16 bits");
    assert_two(&colors(integer(65535), 65535.0, Some("255")), "16 bits with limits of 8");
    assert_two(&colors(integer(255), 255.0, None), "8 bits");
    assert_two(&colors(integer(255), 255.0, Some("1")), "8 bits with limits of 1");
    assert_two(&colors(integer(65535), 255.0, None), "8 bits in a field of 16");
    assert_two(&colors(RecordDataType::F32, 255.0, None), "floats without limits");
    assert_two(&colors(RecordDataType::F32, 1.0, None), "floats of 1");
}

#[test]
fn pts_columns_in_another_order_are_found_by_their_values() {
    for (name, last) in [("fractions", ["0.25", "1.5"]), ("negative", ["-3", "7"]), ("large", ["300", "2000"])] {
        let row = |i: usize| format!("{i} 0 0 {} {}\n", TWO[i].map(|value| value.to_string()).join(" "), last[i]);
        assert_two(&load_bytes("a.pts", format!("2\n{}{}", row(0), row(1))).unwrap(), name);
    }
    let leica = load_bytes("a.pts", "2\n0 0 0 -1613 200 40 30\n1 0 0 12 30 60 200\n").unwrap();
    assert_two(&leica, "a scanner's order");
    assert_eq!(leica.intensity, Some(vec![-1613.0, 12.0]));
    let normals = load_bytes("a.pts", "2\n0 0 0 0.6 0 -0.8\n1 0 0 0 0 1\n").unwrap();
    assert_eq!(normals.normals.unwrap()[1], Vec3::Z);
}

#[test]
fn words_are_refused_where_numbers_should_be() {
    assert_refused("a.csv", "x,y,z,tree\n0,0,0,1\n1,0,0,Banana\n", &["line 3", "Banana"]);
    assert_refused("a.csv", "x,y,z\n0,0,12#4\n", &["12#4"]);
    assert_refused("a.xyz", "0 0 0 1\n0 0 0 #c8281e\n", &["line 2", "#c8281e"]);
    let cloud = load_bytes("a.csv", "x,y,z,w\n0,0,0,-nan(ind)\n1,0,0,1.#QNAN0\n2,0,0,3\n").unwrap();
    assert!(
        cloud.scalars[0].1[..2].iter().all(|value| value.is_nan()) && cloud.positions[2] == DVec3::new(2.0, 0.0, 0.0)
    );
}

#[test]
fn a_packed_color_that_is_no_number_is_white() {
    let header = "VERSION 0.7\nFIELDS x y z rgb\nSIZE 4 4 4 4\nTYPE F F F F\nWIDTH 3\nHEIGHT 1\nPOINTS 3\nDATA ascii\n";
    let cloud =
        load_bytes("a.pcd", format!("{header}0 0 0 nan\n1 0 0 -nan\n2 0 0 {}\n", f32::from_bits(0xff0000))).unwrap();
    assert_eq!(cloud.colors.unwrap(), [Vec3::ONE, Vec3::ONE, Vec3::X]);
}
