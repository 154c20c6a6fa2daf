//! E57 files as another library writes them, and damaged ones.

use std::io::Cursor;

use e57::{E57Writer, Extension, Quaternion, Record, RecordDataType, RecordName, RecordValue, Transform, Translation};
use glam::{DQuat, DVec3, Vec3};
use pellucid_core::cloud::UpAxis;
use pellucid_core::cloud::sensor::Sensor;
use pellucid_core::color::decode_srgb;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::{Folder, assert_refused, load, load_bytes};

/// A scan: its fields, its pose, and the values of its points.
pub struct Scan {
    pub prototype: Vec<Record>,
    pub pose: Option<Transform>,
    pub points: Vec<Vec<RecordValue>>,
}

fn field(name: RecordName, data_type: RecordDataType) -> Record {
    Record { name, data_type }
}

fn integer(name: RecordName, min: i64, max: i64) -> Record {
    field(name, RecordDataType::Integer { min, max })
}

fn extra(name: &str, data_type: RecordDataType) -> Record {
    field(RecordName::Unknown { namespace: "ext".into(), name: name.into() }, data_type)
}

fn xyz() -> Vec<Record> {
    vec![Record::CARTESIAN_X_F64, Record::CARTESIAN_Y_F64, Record::CARTESIAN_Z_F64]
}

fn doubles(values: [f64; 3]) -> Vec<RecordValue> {
    values.map(RecordValue::Double).to_vec()
}

/// A file of some scans, with its XML changed.
pub fn write_with(scans: Vec<Scan>, change: impl Fn(String) -> String) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    let mut writer = E57Writer::new(&mut bytes, "file").unwrap();
    writer.register_extension(Extension::new("ext", "https://example.com/ext")).unwrap();
    for (index, scan) in scans.into_iter().enumerate() {
        let mut cloud = writer.add_pointcloud(&format!("scan {index}"), scan.prototype).unwrap();
        cloud.set_name(Some(format!("station {index}")));
        cloud.set_transform(scan.pose);
        scan.points.into_iter().for_each(|point| cloud.add_point(point).unwrap());
        cloud.finalize().unwrap();
    }
    writer.finalize_customized_xml(|xml| Ok(change(xml))).unwrap();
    drop(writer);
    bytes.into_inner()
}

pub fn write(scans: Vec<Scan>) -> Vec<u8> {
    write_with(scans, |xml| xml)
}

/// A scan of points alone.
pub fn plain(points: impl IntoIterator<Item = [f64; 3]>) -> Scan {
    Scan { prototype: xyz(), pose: None, points: points.into_iter().map(doubles).collect() }
}

fn quarter_turn() -> Transform {
    // A quarter turn about z, not normalized: x becomes y, y becomes −x.
    let rotation = Quaternion { w: 2.0, x: 0.0, y: 0.0, z: 2.0 };
    Transform { rotation, translation: Translation { x: 100.0, y: 200.0, z: 300.0 } }
}

#[test]
fn scans_are_merged_in_their_poses() {
    let turned = Scan { pose: Some(quarter_turn()), ..plain([[1.0, 2.0, 3.0]]) };
    // More than a packet.
    let long = plain((0..20_000).map(|i| [f64::from(i), 0.5, -0.25]));
    let cloud = load_bytes("any", write(vec![plain([[4.0, 5.0, 6.0]]), turned, long])).unwrap();
    assert_eq!((cloud.len(), cloud.up, cloud.non_finite), (20_002, UpAxis::Z, 0));
    assert_eq!(cloud.positions[0], DVec3::new(4.0, 5.0, 6.0));
    // Three products and sums of numbers up to 300.
    assert!(cloud.positions[1].distance(DVec3::new(98.0, 201.0, 303.0)) < 1e-12, "{}", cloud.positions[1]);
    for i in [0, 1, 9_999, 19_999] {
        assert_eq!(cloud.positions[2 + i], DVec3::new(i as f64, 0.5, -0.25));
    }
    assert!(cloud.colors.is_none() && cloud.intensity.is_none() && cloud.scalars.is_empty());
}

#[test]
fn colors_intensities_and_other_fields() {
    let int = RecordValue::Integer;
    let single = RecordValue::Single;
    let colors = [RecordName::ColorRed, RecordName::ColorGreen, RecordName::ColorBlue];
    let mut prototype = xyz();
    prototype.extend(colors.map(|name| integer(name, 0, 1023)));
    prototype.push(integer(RecordName::IsColorInvalid, 0, 1));
    prototype.push(field(RecordName::Intensity, RecordDataType::Single { min: Some(-1.0), max: Some(3.0) }));
    prototype.push(integer(RecordName::RowIndex, 0, 10));
    prototype.push(field(RecordName::TimeStamp, RecordDataType::F32));
    prototype.push(extra("normalX", RecordDataType::F32));
    prototype.push(extra("normalY", RecordDataType::F32));
    prototype.push(extra("normalZ", RecordDataType::F32));
    prototype.push(extra("classification", RecordDataType::U8));
    let point = |x: f64, color: [i64; 3], invalid: i64, intensity: f32| {
        let mut point = doubles([x, 0.0, 0.0]);
        point.extend(color.map(int));
        point.extend([
            int(invalid),
            single(intensity),
            int(7),
            single(2.0),
            single(2.0),
            single(0.0),
            single(0.0),
            int(6),
        ]);
        point
    };
    let points = vec![point(1.0, [1023, 0, 341], 0, 0.0), point(2.0, [1, 2, 3], 1, 9.0)];
    let scan = Scan { prototype, pose: Some(quarter_turn()), points };
    let file = |limits: &str| {
        let scan = Scan { prototype: scan.prototype.clone(), pose: scan.pose.clone(), points: scan.points.clone() };
        write_with(vec![scan], |xml| {
            assert!(xml.contains("<colorRedMaximum"), "{xml}");
            if limits.is_empty() { xml } else { xml.replace(">1023</color", &format!(">{limits}</color")) }
        })
    };
    let cloud = load_bytes("a.e57", file("")).unwrap();
    let colors = cloud.colors.unwrap();
    assert_eq!(colors[0], Vec3::new(1.0, 0.0, decode_srgb(341.0 / 1023.0)));
    assert_eq!(colors[1], Vec3::ONE, "invalid: as white as points without color");
    // 9 is outside of [-1, 3], so these limits are false.
    assert_eq!(cloud.intensity.unwrap(), [0.0, 9.0]);
    assert_eq!(cloud.classification.unwrap(), [6, 6]);
    let normal = cloud.normals.unwrap()[0];
    assert!(normal.distance(Vec3::Y) < 1e-6, "turned with the scan, and made unit: {normal}");
    assert_eq!(cloud.scalars, [("timeStamp".to_owned(), vec![2.0, 2.0])]);
    // Limits of the scan win over those of the type.
    let cloud = load_bytes("a.e57", file("2046")).unwrap();
    assert_eq!(cloud.colors.unwrap()[0], Vec3::new(decode_srgb(0.5), 0.0, decode_srgb(341.0 / 2046.0)));
    // But not if colors exceed them.
    let cloud = load_bytes("a.e57", file("682")).unwrap();
    assert_eq!(cloud.colors.unwrap()[0], Vec3::new(1.0, 0.0, decode_srgb(341.0 / 1023.0)));

    // Beside a scan that has nothing: white, no normal, 0; and scalars are left out.
    let cloud = load_bytes("a.e57", write(vec![plain([[9.0, 9.0, 9.0]]), scan])).unwrap();
    assert_eq!((cloud.colors.unwrap()[0], cloud.normals.unwrap()[0]), (Vec3::ONE, Vec3::ZERO));
    assert_eq!((cloud.intensity.unwrap()[0], cloud.classification, cloud.scalars.len()), (0.0, None, 0));
    assert!(cloud.warnings.iter().any(|w| w.contains("`timeStamp` is left out")), "{:?}", cloud.warnings);
}

#[test]
fn spherical_coordinates_and_states() {
    let spherical = [
        Record::SPHERICAL_RANGE_F64,
        Record::SPHERICAL_AZIMUTH_F64,
        Record::SPHERICAL_ELEVATION_F64,
        Record::SPHERICAL_INVALID_STATE,
    ];
    let turn = std::f64::consts::FRAC_PI_2;
    let point = |range, azimuth, elevation, state| {
        [doubles([range, azimuth, elevation]), vec![RecordValue::Integer(state)]].concat()
    };
    let points =
        vec![point(2.0, turn, 0.0, 0), point(2.0, 0.0, turn, 0), point(1.0, 0.0, 0.0, 1), point(1.0, 0.0, 0.0, 2)];
    let scan = |points| Scan { prototype: spherical.to_vec(), pose: None, points };
    let cloud = load_bytes("a.e57", write(vec![scan(points)])).unwrap();
    assert_eq!((cloud.len(), cloud.non_finite), (2, 2));
    // cos(π/2) is 6e-17.
    assert!(cloud.positions[0].distance(DVec3::new(0.0, 2.0, 0.0)) < 1e-15);
    assert!(cloud.positions[1].distance(DVec3::new(0.0, 0.0, 2.0)) < 1e-15);

    // Where the Cartesian coordinates are invalid, the spherical ones count.
    let prototype = [&xyz()[..], &[Record::CARTESIAN_INVALID_STATE], &spherical[..3]].concat();
    let both = |state| [doubles([7.0, 8.0, 9.0]), vec![RecordValue::Integer(state)], doubles([2.0, 0.0, 0.0])].concat();
    let scan = Scan { prototype, pose: None, points: vec![both(0), both(2), both(1)] };
    let cloud = load_bytes("a.e57", write(vec![scan])).unwrap();
    let found = [DVec3::new(7.0, 8.0, 9.0), DVec3::new(2.0, 0.0, 0.0), DVec3::new(2.0, 0.0, 0.0)];
    assert_eq!(cloud.positions, found);

    let scan = Scan { points: vec![point(1.0, 0.0, 0.0, 2)], prototype: spherical.to_vec(), pose: None };
    assert_refused("a.e57", write(vec![scan]), &["no points (all 1"]);
}

#[test]
fn damaged_and_lying_files() {
    let good = write(vec![plain([[1.0, 2.0, 3.0]; 100])]);
    assert_eq!(load_bytes("a.e57", &good).unwrap().len(), 100);
    assert_refused("a.e57", "no points here", &["byte 0", "expected `ASTM-E57`"]);
    assert_refused("a.e57", &good[..20], &["truncated", "within the E57 header"]);
    assert_refused("a.e57", &good[..1024], &["truncated", "announces", "the file has 1024"]);
    let patched = |at: usize, bytes: &[u8]| {
        let mut file = good.clone();
        file[at..at + bytes.len()].copy_from_slice(bytes);
        file
    };
    // Bytes of the header: version, length, start and length of the XML, size of a page.
    assert_refused("a.e57", patched(8, &[9]), &["E57 header", "version"]);
    assert_refused("a.e57", patched(16, &[255; 8]), &["announces 18446744073709551615 bytes"]);
    assert_refused("a.e57", patched(24, &[255; 8]), &["of XML at byte 18446744073709551615"]);
    assert_refused("a.e57", patched(32, &[255, 255, 255, 255, 255, 0]), &["bytes of XML"]);
    assert_refused("a.e57", patched(40, &[255, 255]), &["page size"]);
    assert_refused("a.e57", patched(200, &[1, 2, 3]), &["checksum"]);
    let xml = |from: &str, to: &str| {
        write_with(vec![plain([[1.0, 2.0, 3.0]; 100])], |xml| {
            assert!(xml.contains(from), "{xml}");
            xml.replace(from, to)
        })
    };
    let count = |count: u64| xml("recordCount=\"100\"", &format!("recordCount=\"{count}\""));
    assert_refused("a.e57", count(101), &["scan 1 (\"station 0\"), point 100 of 101"]);
    for lie in [1_000_000_000_000, u64::MAX] {
        assert_refused("a.e57", count(lie), &["scan 1", &format!("{lie} points of 192 bits each")]);
    }
    assert_refused("a.e57", count(0), &["the cloud has no points"]);
    assert_refused("a.e57", xml("<cartesianX", "<wrong"), &["E57 header", "XML"]);
    assert_refused("a.e57", xml("fileOffset=\"", "fileOffset=\"9"), &["scan 1"]);
    assert_refused("a.e57", xml("cartesianX", "otherX"), &["scan 1", "no coordinates"]);
    assert_refused("a.e57", xml("data3D", "noData"), &["the cloud has no points"]);
    // Constants take no bits, so that any number of them could be claimed.
    let constant = "type=\"Integer\" minimum=\"5\" maximum=\"5\"";
    assert_refused(
        "a.e57",
        xml("type=\"Float\">0</cartesian", &format!("{constant}>0</cartesian")),
        &["every field of its 100 points is a constant"],
    );
    let many = format!("<prototype type=\"Structure\">{}", format!("<returnCount {constant}/>").repeat(2000));
    assert_refused("a.e57", xml("<prototype type=\"Structure\">", &many), &["2003 fields (at most 1024)"]);
    // Elements within each other, as deep as the file is long.
    let deep = format!("{}{}</e57Root>", "<a>".repeat(100_000), "</a>".repeat(100_000));
    let _ = load_bytes("a.e57", xml("</e57Root>", &deep));
}

#[test]
fn random_damage_never_panics() {
    let folder = Folder::new();
    let mut rng = Pcg64Mcg::seed_from_u64(3);
    let mut refused = 0;
    for _ in 0..150 {
        // Damage to the XML has right checksums here, and so gets to the parser and beyond.
        let damage: Vec<(f64, u8)> =
            (0..rng.random_range(1..4)).map(|_| (rng.random(), b"0129<>/\"az-"[rng.random_range(0..11)])).collect();
        let file = write_with(vec![plain([[1.0, 2.0, 3.0]; 20])], |xml| {
            let mut bytes = xml.into_bytes();
            for (place, byte) in &damage {
                let at = (place * bytes.len() as f64) as usize;
                bytes[at] = *byte;
            }
            String::from_utf8_lossy(&bytes).into_owned()
        });
        refused += usize::from(load(&folder.file("damaged", file)).is_err());
    }
    assert!(refused > 50, "only {refused} damaged files were refused");
}

#[test]
fn a_file_with_one_scan_position_has_its_scanner() {
    let of = |scans: Vec<Scan>| load_bytes("any", write(scans)).unwrap().sensor;
    let turned = || Scan { pose: Some(quarter_turn()), ..plain([[1.0, 2.0, 3.0]]) };
    let place = DVec3::new(100.0, 200.0, 300.0);
    for scans in [vec![turned()], vec![turned(), turned()]] {
        let sensor = of(scans).unwrap();
        assert_eq!((sensor.position, sensor.turns), (place, true));
        assert!(sensor.forward.distance(DVec3::Y) < 1e-15 && sensor.up.distance(DVec3::Z) < 1e-15, "{sensor:?}");
    }
    // Two positions, and points that may come from anywhere.
    let elsewhere = Transform { translation: Translation { x: 0.0, y: 0.0, z: 1.0 }, ..quarter_turn() };
    assert_eq!(of(vec![turned(), Scan { pose: Some(elsewhere), ..plain([[1.0; 3]]) }]), None);
    assert_eq!(of(vec![plain([[1.0, 2.0, 3.0]])]), None);
    // The grid of a scanner without a pose.
    let prototype = [xyz(), vec![integer(RecordName::RowIndex, 0, 10)]].concat();
    let point = [doubles([1.0, 2.0, 3.0]), vec![RecordValue::Integer(4)]].concat();
    let grid = Scan { prototype, pose: None, points: vec![point] };
    assert_eq!(of(vec![grid]), Some(Sensor::laser(DVec3::ZERO, DQuat::IDENTITY)));
}
