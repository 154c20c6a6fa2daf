//! LAS and LAZ as another library writes them.

use std::io::Cursor;

use glam::{DVec3, Vec3};
use las::point::Format;
use las::{Builder, Color, Point, Transform, Vector, Writer};
use pellucid_core::cloud::UpAxis;
use pellucid_core::color::decode_srgb;
use pellucid_core::progress::Progress;
use pellucid_io::{Hints, LasColumns, load_with};
use pellucid_testing_host::{random, root};
use rand::RngExt;

use super::{Folder, assert_refused, load_bytes};

const OFFSET: DVec3 = DVec3::new(289_814.15, 4_320_978.61, 170.76);

pub fn builder(minor: u8, format: u8, compressed: bool) -> Builder {
    let mut builder = Builder::from((1, minor));
    builder.point_format = Format::new(format).unwrap();
    builder.point_format.is_compressed = compressed;
    let transform = |offset| Transform { scale: 0.001, offset };
    builder.transforms = Vector { x: transform(OFFSET.x), y: transform(OFFSET.y), z: transform(OFFSET.z) };
    builder
}

pub fn write(builder: Builder, points: impl IntoIterator<Item = Point>) -> Vec<u8> {
    let mut writer = Writer::new(Cursor::new(Vec::new()), builder.into_header().unwrap()).unwrap();
    for point in points {
        writer.write_point(point).unwrap();
    }
    writer.into_inner().unwrap().into_inner()
}

/// A point on the file's grid.
pub fn point(format: &Format, index: u16) -> Point {
    let step = f64::from(index) * 0.001;
    Point {
        x: OFFSET.x + step,
        y: OFFSET.y - 2.0 * step,
        z: OFFSET.z + f64::from(index % 7),
        intensity: index,
        return_number: 1,
        number_of_returns: 2,
        classification: las::point::Classification::new((index % 7) as u8 + 1).unwrap(),
        gps_time: format.has_gps_time.then_some(f64::from(index)),
        color: format.has_color.then_some(Color::new(index, 65535 - index, 13107)),
        nir: format.has_nir.then_some(0),
        waveform: format.has_waveform.then(Default::default),
        extra_bytes: vec![0; format.extra_bytes.into()],
        ..Point::default()
    }
}

/// A small file of each kind, for tests that damage it.
pub fn sample(minor: u8, format: u8, compressed: bool, count: u16) -> Vec<u8> {
    let builder = builder(minor, format, compressed);
    let format = builder.point_format;
    write(builder, (0..count).map(|index| point(&format, index)))
}

/// A file of which every fifth point, from the first on, is withheld.
pub fn with_withheld(minor: u8, format: u8, compressed: bool, count: u16) -> Vec<u8> {
    let builder = builder(minor, format, compressed);
    let format = builder.point_format;
    let marked = |index: u16| Point { is_withheld: index.is_multiple_of(5), ..point(&format, index) };
    write(builder, (0..count).map(marked))
}

#[test]
fn versions_and_point_formats() {
    let kinds = [(0, 0), (1, 1), (2, 0), (2, 1), (2, 2), (2, 3), (3, 3), (4, 3), (4, 6), (4, 7), (4, 8)];
    for (minor, format, compressed) in kinds.into_iter().flat_map(|(m, f)| [(m, f, false), (m, f, true)]) {
        let name = format!("1.{minor}, format {format}, compressed: {compressed}");
        // More than a chunk of 50 000 points and a block of 65 536.
        let count = if format == 2 || format == 7 { 65_535 } else { 300 };
        let cloud =
            load_bytes("any", sample(minor, format, compressed, count)).unwrap_or_else(|e| panic!("{name}: {e}"));
        assert_eq!((cloud.len(), cloud.up), (count.into(), UpAxis::Z), "{name}");
        for index in [0, 1, 299, count - 1] {
            let wanted = point(&Format::new(format).unwrap(), index);
            let at = usize::from(index);
            // Scale and offset are applied in float64: a rounding at 4.3e6 is 5e-10.
            let off = cloud.positions[at].distance(DVec3::new(wanted.x, wanted.y, wanted.z));
            assert!(off < 2e-9, "{name}, point {index}: {off}");
            assert_eq!(cloud.intensity.as_ref().unwrap()[at], f32::from(index), "{name}");
            assert_eq!(cloud.classification.as_ref().unwrap()[at], (index % 7) as u8 + 1, "{name}");
            if let Some(color) = wanted.color {
                let encoded = [color.red, color.green, color.blue].map(|v| f32::from(v) / 65535.0);
                assert_eq!(cloud.colors.as_ref().unwrap()[at], Vec3::from(encoded.map(decode_srgb)), "{name}");
            }
        }
        assert_eq!(cloud.colors.is_some(), [2, 3, 7, 8].contains(&format), "{name}");
        assert_eq!(cloud.scalars[0], ("return_number".to_owned(), vec![1.0; count.into()]));
        assert_eq!(cloud.scalars[1], ("number_of_returns".to_owned(), vec![2.0; count.into()]));
    }
}

const TIMES: LasColumns = LasColumns { returns: false, source: false, gps_time: true };

/// Times of a file that is read as a whole.
fn times(name: &str, bytes: &[u8]) -> Result<Vec<f32>, String> {
    let folder = Folder::new();
    let hints = Hints { las: TIMES, ..Hints::default() };
    let cloud = load_with(&folder.file(name, bytes), hints, &Progress::hidden()).map_err(|error| error.to_string())?;
    Ok(cloud.scalar("gps_time").map(<[f32]>::to_vec).unwrap_or_default())
}

#[test]
fn compressed_times_are_those_of_the_plain_file() {
    // Two scanners with clocks of their own, then jumps, repeated times and rising steps, in channels where there are
    // any.
    let time = |index: u16| match index % 11 {
        0 => 5e5 + f64::from(index) * 1e-3,
        1..4 => f64::from(index) * 2.5e-4,
        4 => f64::from(index - 1) * 2.5e-4,
        5 => 1e7 * f64::from(index % 3),
        6 => f64::from(index) * f64::from(index) * 1e-5,
        7 => 12.0 + f64::from(index / 500),
        _ => 5e5 + f64::from(index / 4) * 1e-3,
    };
    for (minor, format) in [(2, 1), (2, 3), (4, 6), (4, 7)] {
        let file = |compressed: bool| {
            let builder = builder(minor, format, compressed);
            let format = builder.point_format;
            let point = |index: u16| Point {
                gps_time: Some(time(index)),
                scanner_channel: if format.is_extended { (index / 7 % 4) as u8 } else { 0 },
                ..point(&format, index)
            };
            write(builder, (0..60_000).map(point))
        };
        let (plain, compressed) = (times("a.las", &file(false)).unwrap(), times("a.laz", &file(true)).unwrap());
        assert_eq!(plain.len(), 60_000);
        assert!(plain == compressed, "format {format}");
    }
}

#[test]
fn damaged_times_end_in_errors_at_most() {
    let mut random = random(23);
    let found = root().join("fuzz/corpus/copc/found-times-without-end");
    let error = times("a.laz", &std::fs::read(found).unwrap()).unwrap_err();
    assert!(
        error.contains("a.laz: points ") && error.contains("the GPS times change their sequence without end"),
        "{error}"
    );
    let mut refused = 0;
    for whole in [sample(2, 1, true, 900), sample(4, 6, true, 900)] {
        for _ in 0..300 {
            let mut bytes = whole.clone();
            // Times come last in what is compressed by layers.
            for _ in 0..random.random_range(1..20) {
                let at = random.random_range(bytes.len() / 2..bytes.len());
                bytes[at] = if random.random() { 0xff } else { random.random() };
            }
            match times("a.laz", &bytes) {
                Ok(times) => assert_eq!(times.len(), 900),
                Err(error) => refused += usize::from(error.contains("a.laz: ")),
            }
        }
    }
    assert!(refused > 20, "{refused}");
}

#[test]
fn eight_bit_colors_in_sixteen_bits_and_no_colors() {
    let colors = |values: [u16; 2]| {
        let builder = builder(2, 2, true);
        let points = values.map(|v| Point { color: Some(Color::new(v, 0, 0)), ..point(&Format::new(2).unwrap(), 0) });
        load_bytes("a.laz", write(builder, points)).unwrap().colors
    };
    assert_eq!(colors([51, 255]), Some(vec![Vec3::new(decode_srgb(0.2), 0.0, 0.0), Vec3::X]));
    assert_eq!(colors([0, 65535]), Some(vec![Vec3::ZERO, Vec3::X]));
    assert_eq!(colors([0, 0]), None);
}

/// A descriptor of one extra dimension (LAS 1.4, table 24).
fn descriptor(kind: u8, name: &str, scale: Option<f64>) -> Vec<u8> {
    let mut bytes = vec![0; 192];
    bytes[2] = kind;
    bytes[3] = if scale.is_some() { 0b1_1000 } else { 0 };
    bytes[4..4 + name.len()].copy_from_slice(name.as_bytes());
    bytes[112..120].copy_from_slice(&scale.unwrap_or_default().to_le_bytes());
    bytes[136..144].copy_from_slice(&5f64.to_le_bytes());
    bytes
}

#[test]
fn extra_dimensions_are_scalars() {
    for compressed in [false, true] {
        let mut builder = builder(4, 6, compressed);
        // u16 scaled, an array of three u8 (skipped), f32, and a byte that nobody describes.
        builder.point_format.extra_bytes = 2 + 3 + 4 + 1;
        builder.vlrs.push(las::Vlr {
            user_id: "LASF_Spec".to_owned(),
            record_id: 4,
            description: String::new(),
            data: [
                descriptor(3, "Pulse width", Some(0.5)),
                descriptor(21, "rgb", None),
                descriptor(9, "Deviation", None),
            ]
            .concat(),
        });
        let point = |width: u16, deviation: f32| Point {
            number_of_returns: 1,
            extra_bytes: [&width.to_le_bytes()[..], &[1, 2, 3], &deviation.to_le_bytes(), &[9]].concat(),
            ..point(&Format::new(6).unwrap(), 0)
        };
        let cloud = load_bytes("a.las", write(builder, [point(7, 0.25), point(65535, -1.5)])).unwrap();
        let wanted = [("Pulse width".to_owned(), vec![8.5, 32772.5]), ("Deviation".to_owned(), vec![0.25, -1.5])];
        assert_eq!(cloud.scalars, wanted, "compressed: {compressed}");
    }
}

/// A file of one point with so many extra bytes that nobody describes.
pub fn with_extra_bytes(minor: u8, format: u8, compressed: bool, extra_bytes: u16) -> Vec<u8> {
    let mut builder = builder(minor, format, compressed);
    builder.point_format.extra_bytes = extra_bytes;
    let point = Point { extra_bytes: vec![7; extra_bytes.into()], ..point(&Format::new(format).unwrap(), 0) };
    write(builder, [point])
}

#[test]
fn sources_and_times_are_read_when_they_are_asked_for() {
    // Adjusted standard time. Neighbors in float32 are 32 seconds apart there.
    let times = [300_000_000.25, 300_000_007.5, 300_000_000.0];
    for compressed in [false, true] {
        let builder = builder(4, 6, compressed);
        let format = builder.point_format;
        let points = times.iter().zip([7, 65_535, 3]).map(|(time, source)| Point {
            gps_time: Some(*time),
            point_source_id: source,
            number_of_returns: 1,
            ..point(&format, source)
        });
        let folder = Folder::new();
        let file = folder.file("any.las", write(builder, points));
        let asked = LasColumns { returns: true, source: true, gps_time: true };
        let load = |las| load_with(&file, Hints { las, ..Hints::default() }, &Progress::hidden()).unwrap();
        let plain = load(LasColumns::default());
        assert!(plain.scalars.is_empty(), "{:?}", plain.scalars);
        let cloud = load(asked);
        assert_eq!(cloud.scalar("point_source_id"), Some(&[7.0, 65_535.0, 3.0][..]));
        assert_eq!(cloud.scalar("GpsTime"), Some(&[0.25, 7.5, 0.0][..]));
        assert_eq!(cloud.scalar("return_number"), Some(&[1.0; 3][..]));
    }
}

/// Damaged times of points in layers are no matter where nobody asks for them; these points have other defects.
#[test]
fn times_that_nobody_asked_for_do_no_harm() {
    let path = root().join("fuzz/corpus/las/found-times-without-end");
    assert_refused("a.laz", std::fs::read(path).unwrap(), &["end before 9 points are decoded"]);
}
