//! Pictures as clouds: colors, places, height maps with their copies and normals; damaged pictures and bombs.

use std::io::Cursor;
use std::path::{Path, PathBuf};

use glam::{DVec3, Vec3};
use image::{DynamicImage, ImageBuffer, ImageFormat, Luma, Rgb, Rgba};
use pellucid_engine::cloud::{Cloud, UpAxis};
use pellucid_engine::color::decode_srgb;
use pellucid_engine::io::photo::{Heights, Photo};
use pellucid_engine::io::{Error, Hints, load, load_with};
use pellucid_engine::progress::Progress;
use pellucid_engine::scene::{self, Overrides, Scene};
use tempfile::TempDir;

fn write(folder: &TempDir, name: &str, picture: &DynamicImage) -> PathBuf {
    let path = folder.path().join(name);
    picture.save(&path).unwrap();
    path
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

/// Two by two pixels: red, half-transparent mid gray; nothing, white.
fn four() -> DynamicImage {
    let bytes = [[255, 0, 0, 255], [128, 128, 128, 51], [9, 9, 9, 0], [255; 4]].concat();
    DynamicImage::ImageRgba8(ImageBuffer::<Rgba<u8>, _>::from_raw(2, 2, bytes).unwrap())
}

#[test]
fn pixels_are_points() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["a.png", "a.tiff"] {
        let cloud = read(&write(&folder, name, &four()), None).unwrap();
        let at = |x: f64, y: f64| DVec3::new(x, y, 0.0);
        assert_eq!(cloud.positions, [at(-0.25, 0.25), at(0.25, 0.25), at(0.25, -0.25)]);
        let gray = decode_srgb(128.0 / 255.0);
        assert_eq!(cloud.colors, Some(vec![Vec3::X, Vec3::splat(gray), Vec3::ONE]));
        assert_eq!((cloud.alphas, cloud.up), (Some(vec![1.0, 0.2, 1.0]), UpAxis::Y));
        assert_eq!(cloud.normals, Some(vec![Vec3::Z; 3]));
    }
    // No alpha channel, no alphas; 16 bits in full; four by one pixels of width 1/4.
    let wide = ImageBuffer::from_fn(4, 1, |x, _| Rgb([x as u16 * 257 + 1, 0, u16::MAX]));
    let cloud = read(&write(&folder, "wide.png", &DynamicImage::ImageRgb16(wide)), None).unwrap();
    assert_eq!((cloud.len(), cloud.alphas.clone()), (4, None));
    assert_eq!(cloud.bounds().unwrap().max, DVec3::new(0.375, 0.0, 0.0));
    let red = decode_srgb((2.0 * 257.0 + 1.0) / 65535.0);
    assert_eq!(cloud.colors.unwrap()[2], Vec3::new(red, 0.0, 1.0));
    // Float pictures are linear.
    let linear = ImageBuffer::from_fn(2, 1, |x, _| Rgb([0.25f32, x as f32 * f32::NAN, 3.0]));
    let cloud = read(&write(&folder, "linear.tiff", &DynamicImage::ImageRgb32F(linear)), None).unwrap();
    assert_eq!(cloud.colors, Some(vec![Vec3::new(0.25, 0.0, 1.0); 2]));
}

#[test]
fn jpeg_is_read_to_its_precision() {
    let folder = tempfile::tempdir().unwrap();
    let flat = DynamicImage::ImageRgb8(ImageBuffer::from_pixel(24, 16, Rgb([200, 100, 50])));
    let path = folder.path().join("flat.jpg");
    let mut bytes = Cursor::new(Vec::new());
    flat.write_to(&mut bytes, ImageFormat::Jpeg).unwrap();
    std::fs::write(&path, bytes.into_inner()).unwrap();
    let cloud = read(&path, None).unwrap();
    assert_eq!(cloud.len(), 24 * 16);
    let wanted = Vec3::new(200.0, 100.0, 50.0);
    for color in cloud.colors.unwrap() {
        let encoded = Vec3::from_array(color.to_array().map(pellucid_engine::color::encode_srgb)) * 255.0;
        // One quantisation step of the encoder, and rounding to and from YCbCr.
        assert!(encoded.distance(wanted) < 6.0, "{encoded}");
    }
}

#[test]
fn the_photo_stands_where_it_is_put() {
    let folder = tempfile::tempdir().unwrap();
    let path = write(&folder, "a.png", &four());
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
    let ramp = ImageBuffer::from_fn(64, 64, |x, _| Luma([(x * 1024) as u16]));
    write(folder, "ramp.png", &DynamicImage::ImageLuma16(ramp))
}

#[test]
fn a_ramp_has_its_normals_and_its_copies() {
    let folder = tempfile::tempdir().unwrap();
    let photo = write(&folder, "photo.png", &DynamicImage::ImageRgb8(ImageBuffer::from_pixel(64, 64, Rgb([9; 3]))));
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
    let small = write(&folder, "small.png", &DynamicImage::ImageRgb8(ImageBuffer::from_pixel(16, 16, Rgb([9; 3]))));
    let heights = Some(Heights { path: ramp(&folder), scale: -slope });
    let cloud = read(&small, Some(&Photo { heights, ..Photo::default() })).unwrap();
    let normal = DVec3::new(slope, 0.0, 1.0).normalize();
    assert!(cloud.normals.unwrap().iter().all(|found| found.as_dvec3().distance(normal) < 1e-4));
}

#[test]
fn a_bump_is_differentiated_by_central_differences() {
    let folder = tempfile::tempdir().unwrap();
    let photo = write(&folder, "photo.png", &DynamicImage::ImageRgb8(ImageBuffer::from_pixel(3, 3, Rgb([9; 3]))));
    let bump = ImageBuffer::from_fn(3, 3, |x, y| Luma([if (x, y) == (1, 1) { 255u8 } else { 0 }]));
    let path = write(&folder, "bump.png", &DynamicImage::ImageLuma8(bump));
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
    let good = std::fs::read(write(&folder, "good.png", &four())).unwrap();
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
    let tiff = std::fs::read(write(&folder, "good.tiff", &four())).unwrap();
    for at in 0..tiff.len().min(400) {
        let mut bytes = tiff.clone();
        bytes[at] ^= 0xff;
        // Read or refused, without a panic and without taking much memory.
        let _ = read(&named("flipped.tiff", &bytes), None);
    }
    // A header of 40 000 × 40 000 and of 16 000 × 16 000 pixels before no data.
    for (side, says) in [(40_000u32, "268435456 is the most"), (16_000, "can't be in a file of")] {
        let mut bomb = good[..33].to_vec();
        bomb[16..20].copy_from_slice(&side.to_be_bytes());
        bomb[20..24].copy_from_slice(&side.to_be_bytes());
        let check = crc(&bomb[12..29]).to_be_bytes();
        bomb[29..33].copy_from_slice(&check);
        bomb.extend([0, 0, 0, 0, b'I', b'D', b'A', b'T', 0x35, 0xaf, 0x06, 0x1e]);
        assert_refused(&named("bomb.png", &bomb), None, &["bomb.png", &side.to_string(), says]);
    }
    let empty = ImageBuffer::from_pixel(3, 3, Rgba([7, 7, 7, 0]));
    assert_refused(&write(&folder, "empty.png", &DynamicImage::ImageRgba8(empty)), None, &["cloud without points"]);
}

/// The checksum of a chunk of a PNG (ISO 3309).
fn crc(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(u32::MAX, |crc, byte| {
        (0..8).fold(crc ^ u32::from(*byte), |c, _| if c & 1 == 1 { 0xedb8_8320 ^ (c >> 1) } else { c >> 1 })
    })
}

#[test]
fn maps_that_are_missing_or_too_steep() {
    let folder = tempfile::tempdir().unwrap();
    let photo = write(&folder, "photo.png", &four());
    let with = |path: PathBuf, scale: f64| Photo { heights: Some(Heights { path, scale }), ..Photo::default() };
    assert_refused(&photo, Some(&with("none.png".into(), 1.0)), &["none.png: no such file"]);
    let steep = with(ramp(&folder), 1e12);
    assert_refused(&photo, Some(&steep), &["photo.png", "photo.heights", "smaller height_scale"]);
    assert_refused(&photo, Some(&with(ramp(&folder), 1e75)), &["photo.heights"]);
}

#[test]
fn keys_of_the_scene() {
    let folder = tempfile::tempdir().unwrap();
    write(&folder, "photo.png", &four());
    ramp(&folder);
    let origin = folder.path().join("scene.toml");
    let read = |keys: &str| Scene::from_toml(&format!("[[cloud]]\npath = \"photo.png\"\n{keys}\n"), &origin);
    let keys =
        "photo = { origin = [1, 2, 3], right = [1, 0, 0], up = [0, 0, 2], heights = \"ramp.png\", height_scale = 0.1 }";
    let scene = read(&format!("{keys}\ntranslate = [0, 0, 10]\nopacity = 0.5")).unwrap();
    let wanted = Photo {
        origin: Some(DVec3::new(1.0, 2.0, 3.0)),
        edges: Some([DVec3::X, DVec3::Z * 2.0]),
        heights: Some(Heights { path: folder.path().join("ramp.png"), scale: 0.1 }),
    };
    assert_eq!((&scene.clouds[0].photo, scene.warnings.len()), (&Some(wanted), 0));
    let progress = Progress::hidden();
    let clouds = scene::load_clouds(&scene, &progress).unwrap();
    let points = scene::assemble(&scene, clouds, false, &progress).unwrap();
    let bounds = points.bounds().unwrap();
    assert!(bounds.min.z == 13.5 && bounds.max.z == 14.5 && points.opacities.contains(&0.1), "{bounds:?}");

    let refused = |keys: &str, says: &[&str]| {
        let message = read(keys).expect_err(keys).to_string();
        assert!(says.iter().all(|words| message.contains(words)) && message.contains("scene.toml:3:"), "{message}");
    };
    refused("photo = { right = [1, 0, 0] }", &["`photo.right` needs `photo.up`"]);
    refused("photo = { right = [1, 0, 0], up = [2, 0, 0] }", &["photo.up", "span a plane"]);
    refused("photo = { right = [0, 0, 0], up = [2, 0, 0] }", &["photo.right", "direction"]);
    refused("photo = { heights = \"ramp.png\" }", &["needs `photo.height_scale`"]);
    refused("photo = { hights = \"ramp.png\" }", &["unknown key", "did you mean `heights`"]);
    refused("photo = \"here\"", &["must be a table"]);
    assert!(read("photo = { height_scale = 1 }").unwrap().warnings[0].contains("no effect"));

    // By options too; and a cloud that is no picture has no such place.
    let mut overrides = Overrides::default();
    overrides.set_pair("cloud.0.photo.origin=[5, 5, 5]").unwrap();
    let scene = Scene::from_clouds(["photo.png"], &overrides).unwrap();
    assert_eq!(scene.clouds[0].photo.as_ref().unwrap().origin, Some(DVec3::splat(5.0)));
    let ply = folder.path().join("cloud.ply");
    let cloud = Cloud { positions: vec![DVec3::ZERO], ..Cloud::default() };
    pellucid_engine::io::ply::write(&ply, &cloud).unwrap();
    assert!(load(&ply, &progress).is_ok());
    let photo = Photo::default();
    let hints = Hints { photo: Some(&photo), ..Hints::default() };
    let message = load_with(&ply, hints, &progress).unwrap_err().to_string();
    assert!(message.contains("cloud.ply") && message.contains("this is a point cloud"), "{message}");
}

#[test]
fn info_reads_pictures() {
    let folder = tempfile::tempdir().unwrap();
    let path = write(&folder, "a.png", &four());
    let output =
        assert_cmd::Command::cargo_bin("pellucid").unwrap().args(["info", "--json"]).arg(path).output().unwrap();
    let info: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let found = (&info["points"], &info["attributes"], &info["bounds"]["max"]);
    assert_eq!(
        found,
        (&3.into(), &serde_json::json!(["color", "alpha", "normal"]), &serde_json::json!([0.25, 0.25, 0.0]))
    );
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
    let flat = DynamicImage::ImageRgb8(ImageBuffer::from_pixel(24, 16, Rgb([200, 100, 50])));
    let mut bytes = Cursor::new(Vec::new());
    flat.write_to(&mut bytes, ImageFormat::Jpeg).unwrap();
    let mut bytes = bytes.into_inner();
    // Start of frame: marker, length, precision, then height and width, big-endian.
    let frame = bytes.windows(2).position(|marker| marker == [0xff, 0xc0]).unwrap();
    assert_eq!(bytes[frame + 5..frame + 9], [0, 16, 0, 24]);
    bytes[frame + 5..frame + 9].copy_from_slice(&[0x07, 0xd0, 0x07, 0xd0]);
    std::fs::write(&path, &bytes).unwrap();
    assert_refused(&path, None, &["a.jpg: truncated", "2000 × 2000 pixels of 12000000 bytes can't be in a file of"]);
}
