//! Extensions of SPZ files: the axes that one names, and those that change no splat.

use std::io::Write;

use glam::{DVec3, Vec3};
use pellucid_core::cloud::{Cloud, UpAxis};
use ruzstd::encoding::{CompressionLevel, compress_to_vec};

use super::super::{assert_refused, load_bytes};

/// The record of the axes.
const COORDINATE_SYSTEM: u32 = 0xadbe_0003;
/// The record of limits to a viewer's camera.
const ORBIT: u32 = 0xadbe_0002;

fn record(kind: u32, content: &[u8]) -> Vec<u8> {
    [&kind.to_le_bytes()[..], &(content.len() as u32).to_le_bytes(), content].concat()
}

fn axes(number: u32) -> Vec<u8> {
    record(COORDINATE_SYSTEM, &number.to_le_bytes())
}

/// A file of one splat at (1, 2, 3), with the extents 1, e and e² along its axes, a quarter turn about z, and harmonics
/// of degree 1 with red −½ along y, green ½ along z and blue −¼ along x, in a version, with records of extensions.
fn file(version: u32, records: &[u8]) -> Vec<u8> {
    let step = |number: u8| [0, number << 4, number >> 4];
    let position = [step(1), step(2), step(3)].concat();
    let harmonics = [128 + 64, 128, 128, 128, 128 + 64, 128, 128, 128, 128 + 32];
    // z is the largest; w is as large: 511/511/√2, of the parts x, y, w the last one.
    let rotation = (2_u32 << 30 | 511).to_le_bytes();
    let planes = [&position[..], &[255], &[128; 3], &[160, 176, 192], &rotation, &harmonics];
    let mut header = b"NGSP".to_vec();
    header.extend(version.to_le_bytes());
    header.extend(1_u32.to_le_bytes());
    header.extend([1, 12, if records.is_empty() { 0 } else { 2 }, if version < 4 { 0 } else { 6 }]);
    if version < 4 {
        let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::best());
        encoder.write_all(&[&header, &planes.concat()[..], records].concat()).unwrap();
        return encoder.finish().unwrap();
    }
    header.extend((32 + records.len() as u32).to_le_bytes());
    header.extend([0; 12]);
    header.extend(records);
    let streams = planes.map(|plane| compress_to_vec(plane, CompressionLevel::Fastest));
    for (plane, stream) in planes.iter().zip(&streams) {
        header.extend((stream.len() as u64).to_le_bytes());
        header.extend((plane.len() as u64).to_le_bytes());
    }
    [header, streams.concat()].concat()
}

/// The position, half axes along x, y and z of the picture, and the colors from +x, +y and +z.
fn seen(cloud: &Cloud) -> (DVec3, Vec3, [Vec3; 3]) {
    let all = cloud.gaussians.as_ref().unwrap();
    let axis = |axis: Vec3| (all.rotations[0].inverse() * axis * all.extents[0]).length();
    let [y, z, x] = [0, 1, 2].map(|at| all.harmonics_of(0)[at]);
    // −y, z and −x times √(3/4π).
    let constant = 0.488_602_5;
    let colors = [-constant * x, -constant * y, constant * z];
    (cloud.positions[0], Vec3::new(axis(Vec3::X), axis(Vec3::Y), axis(Vec3::Z)), colors)
}

#[test]
fn splats_lie_in_the_axes_that_the_file_names() {
    let e = std::f32::consts::E;
    let along = 0.5 * 0.488_602_5;
    let (red, green, blue) = (Vec3::X * along, Vec3::Y * along, Vec3::Z * along * 0.5);
    // In the axes of the file: a quarter turn swaps the first two half axes; what x, y and z show.
    let (own, [x, y, z]) = (Vec3::new(e, 1.0, e * e), [-blue, -red, green]);
    let swapped = Vec3::new(own.x, own.z, own.y);
    for (number, position, extents, colors) in [
        // Right, up, back; also where nothing is said.
        (4, DVec3::new(1.0, -2.0, -3.0), own, [x, -y, -z]),
        (0, DVec3::new(1.0, -2.0, -3.0), own, [x, -y, -z]),
        // Right, down, front.
        (6, DVec3::new(1.0, 2.0, 3.0), own, [x, y, z]),
        // Right, up, front: a mirror.
        (8, DVec3::new(1.0, -2.0, 3.0), own, [x, -y, z]),
        (1, DVec3::new(-1.0, 2.0, -3.0), own, [-x, y, -z]),
        // Right, front, up: down is −z, front is y.
        (12, DVec3::new(1.0, -3.0, 2.0), swapped, [x, -z, y]),
        // Left, back, down.
        (13, DVec3::new(-1.0, 3.0, -2.0), swapped, [-x, z, -y]),
    ] {
        for version in [3, 4] {
            let cloud = load_bytes("a.spz", file(version, &axes(number))).unwrap();
            let name = format!("axes {number}, version {version}");
            assert!(cloud.warnings.is_empty(), "{name}: {:?}", cloud.warnings);
            assert_eq!(cloud.up, UpAxis::NegativeY);
            let found = seen(&cloud);
            assert_eq!(found.0, position, "{name}");
            assert!(found.1.distance(extents) < 1e-4, "{name}: {} is not {extents}", found.1);
            for (found, expected) in found.2.iter().zip(colors) {
                assert!(found.distance(expected) < 1e-5, "{name}: {found} is not {expected}");
            }
        }
    }
}

#[test]
fn records_that_change_no_splat_are_no_warning_and_others_are_named() {
    for version in [3, 4] {
        let load = |records: &[u8]| load_bytes("a.spz", file(version, records)).unwrap();
        let plain = load(&[]);
        for records in [axes(4), record(ORBIT, &[0; 12]), [record(ORBIT, &[0; 12]), axes(4)].concat()] {
            assert_eq!(load(&records), plain);
        }
        let other = load(&[record(0x1234_0001, &[1, 2, 3]), axes(6)].concat());
        assert_eq!(other.warnings, ["extension 0x12340001 of the SPZ file is not read"]);
        assert_eq!(other.positions, [DVec3::new(1.0, 2.0, 3.0)], "what follows is read");
        let cut = load(&axes(6)[..10]);
        assert!(cut.warnings[0].contains("record 0xadbe0003 announces 4 bytes, but 2 are left"), "{:?}", cut.warnings);
        for (records, says) in [
            (axes(17), "coordinate system 17 is unknown, expected 0 to 16"),
            (record(COORDINATE_SYSTEM, &[6, 0]), "the coordinate system has 2 bytes, expected 4"),
        ] {
            assert_refused("a.spz", file(version, &records), &["extensions", says]);
        }
    }
}
