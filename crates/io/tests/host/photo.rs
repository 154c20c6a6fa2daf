//! Pictures as clouds: colors, places, height maps with their copies and normals; damaged pictures and bombs.

use std::fs::File;
use std::path::{Path, PathBuf};

use glam::{DVec3, Vec3};
use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder, Rgb32FImage, RgbImage, save_buffer};
use pellucid_core::cloud::{Cloud, UpAxis};
use pellucid_core::color::decode_srgb;
use pellucid_core::progress::Progress;
use pellucid_io::photo::{Heights, Photo};
use pellucid_io::store::{announced, open};
use pellucid_io::{Error, Hints, load_with};
use tempfile::TempDir;

/// A PNG or TIFF, by the name; samples row by row from the top.
fn write(folder: &TempDir, name: &str, size: [u32; 2], color: ExtendedColorType, samples: &[u8]) -> PathBuf {
    let path = folder.path().join(name);
    save_buffer(&path, samples, size[0], size[1], color).unwrap();
    path
}

/// A picture of one color.
fn flat(folder: &TempDir, name: &str, side: u32) -> PathBuf {
    write(folder, name, [side; 2], ExtendedColorType::Rgb8, &vec![9; (side * side * 3) as usize])
}

fn read(path: &Path, photo: Option<&Photo>) -> Result<Cloud, Error> {
    load_with(path, Hints { photo, ..Hints::default() }, &Progress::hidden())
}

#[track_caller]
fn assert_refused(path: &Path, photo: Option<&Photo>, says: &[&str]) {
    let message = read(path, photo).expect_err("loaded").to_string();
    for words in says {
        assert!(message.contains(words), "`{words}` is not in: {message}");
    }
}

/// Two by two pixels, red, green, blue and alpha: red, half-transparent mid gray; nothing, white.
const FOUR: [u8; 16] = [255, 0, 0, 255, 128, 128, 128, 51, 9, 9, 9, 0, 255, 255, 255, 255];

fn four(folder: &TempDir, name: &str) -> PathBuf {
    write(folder, name, [2, 2], ExtendedColorType::Rgba8, &FOUR)
}

/// 24 × 16 pixels of (200, 100, 50), of quality 75 and without subsampling.
const FLAT_JPEG: &[u8] = include_bytes!("photo/flat.jpg");

#[test]
fn pixels_are_points() {
    let folder = tempfile::tempdir().unwrap();
    for path in [four(&folder, "a.png"), four(&folder, "a.tiff")] {
        let cloud = read(&path, None).unwrap();
        let at = |x: f64, y: f64| DVec3::new(x, y, 0.0);
        assert_eq!(cloud.positions, [at(-0.25, 0.25), at(0.25, 0.25), at(0.25, -0.25)]);
        let gray = decode_srgb(128.0 / 255.0);
        assert_eq!(cloud.colors, Some(vec![Vec3::X, Vec3::splat(gray), Vec3::ONE]));
        assert_eq!((cloud.alphas, cloud.up), (Some(vec![1.0, 0.2, 1.0]), UpAxis::Y));
        assert_eq!(cloud.normals, Some(vec![Vec3::Z; 3]));
    }
    // No alpha channel, no alphas; 16 bits in full; four by one pixels of width 1/4.
    let wide: Vec<u16> = (0..4).flat_map(|x| [x * 257 + 1, 0, u16::MAX]).collect();
    let cloud =
        read(&write(&folder, "wide.png", [4, 1], ExtendedColorType::Rgb16, bytemuck::cast_slice(&wide)), None).unwrap();
    assert_eq!((cloud.len(), cloud.alphas.clone()), (4, None));
    assert_eq!(cloud.bounds().unwrap().max, DVec3::new(0.375, 0.0, 0.0));
    let red = decode_srgb((2.0 * 257.0 + 1.0) / 65535.0);
    assert_eq!(cloud.colors.unwrap()[2], Vec3::new(red, 0.0, 1.0));
    // Float pictures are linear.
    let linear = folder.path().join("linear.tiff");
    let floats = vec![0.25, 0.0, 3.0, 0.25, f32::NAN, 3.0];
    Rgb32FImage::from_vec(2, 1, floats).unwrap().save(&linear).unwrap();
    let cloud = read(&linear, None).unwrap();
    assert_eq!(cloud.colors, Some(vec![Vec3::new(0.25, 0.0, 1.0); 2]));
}

#[test]
fn jpeg_is_read_to_its_precision() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("flat.jpg");
    std::fs::write(&path, FLAT_JPEG).unwrap();
    let cloud = read(&path, None).unwrap();
    assert_eq!(cloud.len(), 24 * 16);
    let wanted = Vec3::new(200.0, 100.0, 50.0);
    for color in cloud.colors.unwrap() {
        let encoded = Vec3::from_array(color.to_array().map(pellucid_core::color::encode_srgb)) * 255.0;
        // One quantization step of the encoder, and rounding to and from YCbCr.
        assert!(encoded.distance(wanted) < 6.0, "{encoded}");
    }
}

/// A little-endian TIFF without compression: pixels from byte 8 on, then a directory whose values are all of 16 bits.
fn tiff_by_hand(pixels: &[u8], entries: &[(u16, &[u16])]) -> Vec<u8> {
    let directory = 8 + pixels.len() as u32;
    let behind = directory + 2 + 12 * entries.len() as u32 + 4;
    let (mut file, mut lists) = ([b"II*\0", &directory.to_le_bytes()[..], pixels].concat(), Vec::new());
    file.extend((entries.len() as u16).to_le_bytes());
    for (tag, values) in entries {
        file.extend([tag.to_le_bytes(), 3u16.to_le_bytes()].concat());
        file.extend((values.len() as u32).to_le_bytes());
        let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        if bytes.len() <= 4 {
            file.extend([bytes.as_slice(), &[0; 4][bytes.len()..]].concat());
        } else {
            file.extend((behind + lists.len() as u32).to_le_bytes());
            lists.extend(bytes);
        }
    }
    [file, vec![0; 4], lists].concat()
}

#[test]
fn tiffs_of_bits_of_planes_and_of_inks() {
    let folder = tempfile::tempdir().unwrap();
    let colors = |name: &str, bytes: Vec<u8>| {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        read(&path, None).unwrap().colors.unwrap()
    };
    let half = decode_srgb(51.0 / 255.0);
    // Three pixels of a bit, in a byte; 0 is black.
    let entries: &[(u16, &[u16])] =
        &[(256, &[3]), (257, &[1]), (258, &[1]), (259, &[1]), (262, &[1]), (273, &[8]), (277, &[1]), (279, &[1])];
    assert_eq!(colors("bits.tiff", tiff_by_hand(&[0b1010_0000, 0], entries)), [Vec3::ONE, Vec3::ZERO, Vec3::ONE]);
    // Two pixels: both reds, both greens, both blues.
    let entries: &[(u16, &[u16])] = &[
        (256, &[2]),
        (257, &[1]),
        (258, &[8; 3]),
        (259, &[1]),
        (262, &[2]),
        (273, &[8, 10, 12]),
        (277, &[3]),
        (278, &[1]),
        (279, &[2; 3]),
        (284, &[2]),
    ];
    let planes = colors("planes.tiff", tiff_by_hand(&[255, 0, 0, 51, 0, 255], entries));
    assert_eq!(planes, [Vec3::X, Vec3::new(0.0, half, 1.0)]);
    // Cyan alone leaves no red; a fifth of the light, 51, is left behind black of 204, in the decoder's float32 50.
    let entries: &[(u16, &[u16])] = &[
        (256, &[2]),
        (257, &[1]),
        (258, &[8; 4]),
        (259, &[1]),
        (262, &[5]),
        (273, &[8]),
        (277, &[4]),
        (278, &[1]),
        (279, &[8]),
    ];
    let inks = colors("inks.tiff", tiff_by_hand(&[255, 0, 0, 0, 0, 0, 0, 204], entries));
    assert_eq!(inks, [Vec3::new(0.0, 1.0, 1.0), Vec3::splat(decode_srgb(50.0 / 255.0))]);
}

/// Exif data that say how the camera was held, 1 to 8.
fn exif(orientation: u8) -> Vec<u8> {
    let mut exif = b"II*\0\x08\0\0\0\x01\0\x12\x01\x03\0\x01\0\0\0\x06\0\0\0\0\0\0\0".to_vec();
    exif[18] = orientation;
    exif
}

fn write_turned(path: &Path, picture: &RgbImage, orientation: u8) {
    let mut encoder = PngEncoder::new(File::create(path).unwrap());
    encoder.set_exif_metadata(exif(orientation)).unwrap();
    picture.write_with_encoder(encoder).unwrap();
}

/// All formats tell how the camera was held; 6: the stored rows are columns, the first at the right.
#[test]
fn pictures_are_turned_upright() {
    let folder = tempfile::tempdir().unwrap();
    let pixels = [[255, 0, 0], [0, 255, 0], [0, 0, 255]].concat();
    let png = folder.path().join("a.png");
    write_turned(&png, &RgbImage::from_vec(3, 1, pixels.clone()).unwrap(), 6);
    let tiff = folder.path().join("a.tiff");
    let entries: &[(u16, &[u16])] = &[
        (256, &[3]),
        (257, &[1]),
        (258, &[8; 3]),
        (259, &[1]),
        (262, &[2]),
        (273, &[8]),
        (274, &[6]),
        (277, &[3]),
        (278, &[1]),
        (279, &[9]),
    ];
    std::fs::write(&tiff, tiff_by_hand(&pixels, entries)).unwrap();
    for path in [png, tiff] {
        let cloud = read(&path, None).unwrap();
        assert_eq!(cloud.colors, Some(vec![Vec3::X, Vec3::Y, Vec3::Z]));
        let (top, bottom) = (cloud.positions[0], cloud.positions[2]);
        assert_eq!((top.x, bottom.x, top.y, bottom.y), (0.0, 0.0, 1.0, -1.0), "{}", path.display());
    }
    // After a JPEG's first marker, the segment of Exif.
    let exif = exif(6);
    let segment = [&[0xff, 0xe1, 0, 8 + exif.len() as u8], b"Exif\0\0".as_slice(), &exif].concat();
    let jpeg = folder.path().join("a.jpg");
    std::fs::write(&jpeg, [&FLAT_JPEG[..2], &segment, &FLAT_JPEG[2..]].concat()).unwrap();
    let bounds = read(&jpeg, None).unwrap().bounds().unwrap();
    // 16 wide, 24 high; the width is 1.
    assert_eq!((bounds.max.x, bounds.max.y), (0.5 - 1.0 / 32.0, 0.75 - 1.0 / 32.0));
}

/// Exif (CIPA DC-008, tag 274) names the sides of the picture at which the stored row 0 and column 0 are, of 1 to 8.
const ROW_AND_COLUMN: [(&str, &str); 8] = [
    ("top", "left"),
    ("top", "right"),
    ("bottom", "right"),
    ("bottom", "left"),
    ("left", "top"),
    ("right", "top"),
    ("right", "bottom"),
    ("left", "bottom"),
];

#[test]
fn the_first_row_and_column_are_where_exif_has_them() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.png");
    // Red tells the stored column, green the stored row.
    let stored = RgbImage::from_fn(3, 2, |x, y| image::Rgb([100 * x as u8, 100 * y as u8, 0]));
    for (number, (row, column)) in (1..).zip(ROW_AND_COLUMN) {
        write_turned(&path, &stored, number);
        let colors = read(&path, None).unwrap().colors.unwrap();
        let [width, height] = if number < 5 { [3, 2] } else { [2, 3] };
        let is_at = |side: &str, x: usize, y: usize| match side {
            "top" => y == 0,
            "bottom" => y == height - 1,
            "left" => x == 0,
            _ => x == width - 1,
        };
        assert_eq!(colors.len(), 6);
        for (at, color) in colors.iter().enumerate() {
            let (x, y) = (at % width, at / width);
            assert_eq!((color.y == 0.0, color.x == 0.0), (is_at(row, x, y), is_at(column, x, y)), "{number}: {x} {y}");
        }
    }
}

#[test]
fn the_photo_stands_where_it_is_put() {
    let folder = tempfile::tempdir().unwrap();
    let path = four(&folder, "a.png");
    let edges = [DVec3::new(0.0, 4.0, 0.0), DVec3::new(0.0, 0.0, 2.0)];
    let photo = Photo { origin: Some(DVec3::new(500_000.0, 7.0, 1.0)), edges: Some(edges), heights: None };
    let cloud = read(&path, Some(&photo)).unwrap();
    let at = |y: f64, z: f64| DVec3::new(500_000.0, y, z);
    assert_eq!(cloud.positions, [at(8.0, 2.5), at(10.0, 2.5), at(10.0, 1.5)]);
    assert_eq!(cloud.normals.unwrap()[0], Vec3::X);
    // Without an origin, around the middle.
    let cloud = read(&path, Some(&Photo { origin: None, ..photo })).unwrap();
    assert_eq!(cloud.positions[0], DVec3::new(0.0, -1.0, 0.5));
}

/// A ramp of 16 bits along x whose slope is exact: 1/64 per pixel, from 0 to 63/64.
fn ramp(folder: &TempDir) -> PathBuf {
    let ramp: Vec<u16> = (0..64 * 64).map(|pixel| pixel % 64 * 1024).collect();
    write(folder, "ramp.png", [64; 2], ExtendedColorType::L16, bytemuck::cast_slice(&ramp))
}

#[test]
fn a_ramp_has_its_normals_and_its_copies() {
    let folder = tempfile::tempdir().unwrap();
    let photo = flat(&folder, "photo.png", 64);
    // Heights grow by 65535/65536·scale over the width 1: the slope.
    let slope: f64 = 2.0;
    let heights = Some(Heights { path: ramp(&folder), scale: slope * 65535.0 / 65536.0 });
    let cloud = read(&photo, Some(&Photo { heights, ..Photo::default() })).unwrap();
    let normal = DVec3::new(-slope, 0.0, 1.0).normalize();
    for found in cloud.normals.as_ref().unwrap() {
        // Float32 rounds each component; the map's values were rounded to float32 before.
        assert!(found.as_dvec3().distance(normal) < 1e-5, "{found}");
    }
    for position in &cloud.positions {
        let column = (position.x + 0.5) * 64.0 - 0.5;
        assert!((column - column.round()).abs() < 1e-9);
        assert!((position.z - slope * column / 64.0).abs() < 1e-6, "{position}");
    }
    // 1 / cos φ = √5: 2 copies of each pixel, and a third of 0.236 of them.
    let pixels = 64.0 * 64.0;
    let fraction = 5f64.sqrt() - 2.0;
    let third = cloud.len() as f64 - 2.0 * pixels;
    let error = (pixels * fraction * (1.0 - fraction)).sqrt();
    assert!((third - pixels * fraction).abs() < 4.0 * error, "{third} of {}", pixels * fraction);
    let mut copies = std::collections::BTreeMap::new();
    for position in &cloud.positions {
        *copies.entry(position.to_array().map(f64::to_bits)).or_insert(0) += 1;
    }
    assert_eq!(copies.len(), 4096);
    assert!(copies.values().all(|count| (2..=3).contains(count)));
    // The same picture is the same cloud.
    let heights = Some(Heights { path: ramp(&folder), scale: slope * 65535.0 / 65536.0 });
    assert!(cloud == read(&photo, Some(&Photo { heights, ..Photo::default() })).unwrap());
    // A quarter of the size, and downward: as steep, since slopes are those of the world.
    let small = flat(&folder, "small.png", 16);
    let heights = Some(Heights { path: ramp(&folder), scale: -slope });
    let cloud = read(&small, Some(&Photo { heights, ..Photo::default() })).unwrap();
    let normal = DVec3::new(slope, 0.0, 1.0).normalize();
    assert!(cloud.normals.unwrap().iter().all(|found| found.as_dvec3().distance(normal) < 1e-4));
}

#[test]
fn a_bump_is_differentiated_by_central_differences() {
    let folder = tempfile::tempdir().unwrap();
    let photo = flat(&folder, "photo.png", 3);
    let bump = [0, 0, 0, 0, 255, 0, 0, 0, 0];
    let path = write(&folder, "bump.png", [3, 3], ExtendedColorType::L8, &bump);
    let heights = Some(Heights { path, scale: 0.1 });
    let edges = Some([DVec3::X * 3.0, DVec3::Y * 3.0]);
    let cloud = read(&photo, Some(&Photo { origin: None, edges, heights })).unwrap();
    let normals = cloud.normals.unwrap();
    // All slopes are at most 0.1: one copy of each pixel but by chance, so find pixels by place.
    let at = |x: f64, y: f64| {
        let index = cloud.positions.iter().position(|p| (p.x, p.y) == (x, y)).unwrap();
        (cloud.positions[index].z, normals[index].as_dvec3())
    };
    let (top, normal) = at(0.0, 0.0);
    assert!((top - 0.1).abs() < 1e-9 && normal == DVec3::Z, "the top is level: {top} {normal}");
    let wanted = DVec3::new(-0.1, 0.0, 1.0).normalize();
    assert!(at(-1.0, 0.0).1.distance(wanted) < 1e-7, "a step to the right of the left rim: {}", at(-1.0, 0.0).1);
    let wanted = DVec3::new(0.0, 0.1, 1.0).normalize();
    assert!(at(0.0, 1.0).1.distance(wanted) < 1e-7, "the upper rim falls upward: {}", at(0.0, 1.0).1);
    assert_eq!(at(1.0, 1.0), (0.0, DVec3::Z));
}

#[test]
fn damaged_pictures_and_bombs() {
    let folder = tempfile::tempdir().unwrap();
    let good = std::fs::read(four(&folder, "good.png")).unwrap();
    let named = |name: &str, bytes: &[u8]| {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        path
    };
    assert_refused(&named("a.png", b"no picture"), None, &["a.png", "byte 0", "PNG"]);
    assert_refused(&named("a.jpg", b"GIF89a..."), None, &["byte 0"]);
    assert_refused(&named("a.png", &good[..good.len() / 2]), None, &["a.png: "]);
    for cut in 0..good.len() {
        assert!(read(&named("cut.png", &good[..cut]), None).is_err() || cut > good.len() - 13, "{cut}");
    }
    let tiff = std::fs::read(four(&folder, "good.tiff")).unwrap();
    for at in 0..tiff.len().min(400) {
        let mut bytes = tiff.clone();
        bytes[at] ^= 0xff;
        // Read or refused, without a panic and without taking much memory.
        let _ = read(&named("flipped.tiff", &bytes), None);
    }
    // Headers before no data.
    for (side, says) in [(70_000u32, "at most 4294967296 are supported"), (16_000, "don't fit in a file of")] {
        let bomb = claiming(&good, [side; 2]);
        assert_refused(&named("bomb.png", &bomb), None, &["bomb.png", &side.to_string(), says]);
    }
    let empty = write(&folder, "empty.png", [3, 3], ExtendedColorType::Rgba8, &[7, 7, 7, 0].repeat(9));
    assert_refused(&empty, None, &["the cloud has no points"]);
}

/// The start of a PNG with another size, before no data.
fn claiming(png: &[u8], [width, height]: [u32; 2]) -> Vec<u8> {
    let mut claim = png[..33].to_vec();
    claim[16..20].copy_from_slice(&width.to_be_bytes());
    claim[20..24].copy_from_slice(&height.to_be_bytes());
    let check = crc(&claim[12..29]).to_be_bytes();
    claim[29..33].copy_from_slice(&check);
    claim.extend([0, 0, 0, 0, b'I', b'D', b'A', b'T', 0x35, 0xaf, 0x06, 0x1e]);
    claim
}

/// The checksum of a chunk of a PNG (ISO 3309).
fn crc(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(u32::MAX, |crc, byte| {
        (0..8).fold(crc ^ u32::from(*byte), |c, _| if c & 1 == 1 { 0xedb8_8320 ^ (c >> 1) } else { c >> 1 })
    })
}

/// Steep heights, and pixels that are no points.
#[test]
fn pieces_of_a_picture_are_the_cloud_of_the_whole() {
    let folder = tempfile::tempdir().unwrap();
    let side = 1000;
    let pixel =
        |i: u32| [(i % 251) as u8, (i % 7) as u8, 40, if i < 200 * side || i.is_multiple_of(5) { 0 } else { 255 }];
    let pixels: Vec<u8> = (0..side * side).flat_map(pixel).collect();
    let path = write(&folder, "photo.png", [side; 2], ExtendedColorType::Rgba8, &pixels);
    let heights: Vec<u8> = (0..64 * 64).map(|i| (37 * (i / 64) + 11 * i) as u8).collect();
    let map = write(&folder, "map.png", [64; 2], ExtendedColorType::L8, &heights);
    let photo = Photo { heights: Some(Heights { path: map, scale: 0.05 }), ..Photo::default() };
    let cloud = read(&path, Some(&photo)).unwrap();
    let store = open(&path, Hints { photo: Some(&photo), ..Hints::default() }, &Progress::hidden()).unwrap();
    assert_eq!((store.summary().points, store.nodes().len()), (cloud.len() as u64, 2), "the first fifth is empty");
    assert_eq!(Some(store.summary().bounds), cloud.bounds());
    let pieces: Vec<_> = (0..2).map(|node| store.read(node).unwrap()).collect();
    for (piece, node) in pieces.iter().zip(store.nodes()) {
        assert_eq!((piece.cloud.bounds(), piece.cloud.len() as u64), (Some(node.bounds), node.points));
    }
    assert!(pieces.iter().flat_map(|piece| &piece.places).copied().eq(0..cloud.len() as u64));
    let mut whole = store.summary().like.clone();
    pieces.into_iter().for_each(|piece| whole.append(piece.cloud));
    assert_eq!(whole, cloud);
    assert_eq!(announced(&path, &Hints::default()).unwrap(), Some((u64::from(side * side), None)));
}

/// The tapestry of Tanaka et al. 2016, Section 4.5: more points than memory may hold at once.
#[test]
fn the_size_of_the_largest_published_picture_is_announced_and_not_refused() {
    let folder = tempfile::tempdir().unwrap();
    let good = std::fs::read(four(&folder, "good.png")).unwrap();
    let claim = folder.path().join("tapestry.png");
    std::fs::write(&claim, claiming(&good, [39_348, 8_857])).unwrap();
    assert_eq!(announced(&claim, &Hints::default()).unwrap(), Some((39_348 * 8_857, None)));
    assert_refused(&claim, None, &["39348 × 8857 pixels of 1394020944 bytes don't fit in a file of"]);
}

#[test]
fn maps_that_are_missing_or_too_steep() {
    let folder = tempfile::tempdir().unwrap();
    let photo = four(&folder, "photo.png");
    let with = |path: PathBuf, scale: f64| Photo { heights: Some(Heights { path, scale }), ..Photo::default() };
    assert_refused(&photo, Some(&with("none.png".into(), 1.0)), &["none.png: no such file"]);
    let steep = with(ramp(&folder), 1e12);
    assert_refused(&photo, Some(&steep), &["photo.png", "photo.heights", "smaller height_scale"]);
    assert_refused(&photo, Some(&with(ramp(&folder), 1e75)), &["photo.heights"]);
}

/// The decoder would take 32 bytes of memory for each value before it looks for them in the file.
#[test]
fn a_tiff_directory_of_more_values_than_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let entry = |tag: u16, kind: u16, count: u32, value: u32| -> Vec<u8> {
        [&tag.to_le_bytes()[..], &kind.to_le_bytes(), &count.to_le_bytes(), &value.to_le_bytes()].concat()
    };
    let file = |count: u32| {
        let entries = [entry(0x100, 4, 1, 2), entry(0x101, 4, count, 8), entry(0x102, 3, 1, 8)];
        [&b"II*\0\x08\0\0\0\x03\0"[..], &entries.concat(), &[0; 4]].concat()
    };
    let path = folder.path().join("a.tiff");
    std::fs::write(&path, file(7_000_000)).unwrap();
    assert_refused(&path, None, &["a.tiff: truncated", "tag 257", "announces 7000000 values", "only 50 bytes"]);
    // As many as the file may hold are the decoder's business.
    std::fs::write(&path, file(12)).unwrap();
    let message = read(&path, None).expect_err("no picture").to_string();
    assert!(message.contains("a.tiff: ") && !message.contains("announces"), "{message}");
}

/// A JPEG's decoder fills what is missing with gray: 12 MB of pixels, and a point for each, from a header.
#[test]
fn a_jpeg_of_more_pixels_than_its_bits_can_say() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.jpg");
    let mut bytes = FLAT_JPEG.to_vec();
    // Start of frame: marker, length, precision, then height and width, big-endian.
    let frame = bytes.windows(2).position(|marker| marker == [0xff, 0xc0]).unwrap();
    assert_eq!(bytes[frame + 5..frame + 9], [0, 16, 0, 24]);
    bytes[frame + 5..frame + 9].copy_from_slice(&[0x07, 0xd0, 0x07, 0xd0]);
    std::fs::write(&path, &bytes).unwrap();
    assert_refused(&path, None, &["a.jpg: truncated", "2000 × 2000 pixels of 12000000 bytes don't fit in a file of"]);
}
