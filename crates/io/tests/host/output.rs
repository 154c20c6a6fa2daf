//! PNG and EXR: values, metadata, the same bytes twice, and nothing half-written.

use std::fs;
use std::path::Path;

use glam::{DVec3, Vec3};
use pellucid_core::camera::{Camera, Projection};
use pellucid_core::color::ColorSpace;
use pellucid_core::color::{decode_srgb, encode_srgb};
use pellucid_core::image::Image;
use pellucid_io::output::deep::{self, DeepLayout};
use pellucid_io::output::{
    Error, Inputs, Tagged, WriteOptions, check_target, read_image, tagged, write_atomically, write_image,
};

fn options() -> WriteOptions {
    let metadata = ["scene", "method", "settings", "device", "version", "seed"];
    WriteOptions {
        background: Vec3::new(0.25, 0.0, 1.0),
        color: ColorSpace::Linear,
        transparent: false,
        metadata: metadata.map(|key| (format!("pellucid:{key}"), format!("value of {key} äλ"))).into(),
        camera: None,
        inputs: Inputs::default(),
    }
}

/// Opaque, half covered, nothing; and a row of what a file must survive.
fn frame() -> Image {
    Image {
        width: 3,
        height: 2,
        rgba: vec![
            [1.0, 0.5, 0.0, 1.0],
            [0.25, 0.0, 0.0, 0.5],
            [0.0; 4],
            [f32::NAN, 0.0, 0.0, 1.0],
            [2.0, -1.0, 0.0, 1.0],
            [1e-7, 0.0, 0.0, 1e-7],
        ],
        depth: vec![1.0, 2.0, f32::INFINITY, 4.0, 5.0, 6.0],
        depth_median: Some(vec![1.0, f32::INFINITY, f32::INFINITY, 4.0, 5.5, f32::INFINITY]),
        depth_mean: Some(vec![1.0, 2.25, f32::INFINITY, 4.0, 5.25, 6.0]),
        fragments: Some(vec![1, 2, 0, 4, 5, 100_000]),
        layers: Some(vec![1, 2, 0, 3, 3, 3]),
        ..Image::default()
    }
}

/// 8-bit value of a linear one, by the definition.
fn byte(linear: f32) -> u8 {
    (255.0 * encode_srgb(linear) + 0.5).floor() as u8
}

fn png_pixels(path: &Path) -> (png::ColorType, Vec<u8>, Vec<(String, String)>) {
    let mut reader = png::Decoder::new(std::io::BufReader::new(fs::File::open(path).unwrap())).read_info().unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut bytes).unwrap();
    assert_eq!(info.bit_depth, png::BitDepth::Eight);
    let text = &reader.info();
    let latin = text.uncompressed_latin1_text.iter().map(|t| (t.keyword.clone(), t.text.clone()));
    let utf8 = text.utf8_text.iter().map(|t| (t.keyword.clone(), t.get_text().unwrap()));
    (info.color_type, bytes, latin.chain(utf8).collect())
}

#[test]
fn png_holds_the_composed_image_and_the_metadata() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.png");
    write_image(&path, &frame(), &options()).unwrap();
    let (color, bytes, metadata) = png_pixels(&path);
    assert_eq!(color, png::ColorType::Rgb);
    // C + (1 − A)·background: 0.25 + 0.5·0.25 = 0.375 and 0.5·1 in blue.
    assert_eq!(bytes[..9], [255, byte(0.5), 0, byte(0.375), 0, byte(0.5), byte(0.25), 0, 255]);
    assert_eq!(bytes[9..15], [0, 0, 0, 255, 0, 0], "NaN is 0, the rest is clamped");
    assert_eq!(metadata, options().metadata);
    // ASCII values go into chunks of the older kind.
    let ascii = WriteOptions { metadata: vec![("pellucid:seed".into(), "7".into())], ..options() };
    write_image(&path, &frame(), &ascii).unwrap();
    assert_eq!(png_pixels(&path).2, ascii.metadata);
}

#[test]
fn a_transparent_png_has_straight_alpha_and_no_background() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.PNG");
    write_image(&path, &frame(), &WriteOptions { transparent: true, ..options() }).unwrap();
    let (color, bytes, _) = png_pixels(&path);
    assert_eq!(color, png::ColorType::Rgba);
    // 0.25/0.5 = 0.5; alpha 0.5 is 127.5 steps, rounded up.
    assert_eq!(bytes[..12], [255, byte(0.5), 0, 255, byte(0.5), 0, 0, 128, 0, 0, 0, 0]);
}

#[test]
fn encoded_values_go_into_a_png_as_they_are_and_into_an_exr_decoded() {
    let folder = tempfile::tempdir().unwrap();
    let options = WriteOptions { color: ColorSpace::Encoded, ..options() };
    let frame = Image {
        width: 2,
        height: 1,
        rgba: vec![[0.5, 0.0, 0.0, 0.5], [0.0; 4]],
        depth: vec![1.0; 2],
        ..Image::default()
    };
    let (a, b) = (folder.path().join("a.png"), folder.path().join("a.exr"));
    write_image(&a, &frame, &options).unwrap();
    write_image(&b, &frame, &options).unwrap();
    // The background is encoded before it is blended: 0.5 + 0.5·encode(0.25).
    let red = 0.5 + 0.5 * encode_srgb(0.25);
    let (_, bytes, _) = png_pixels(&a);
    assert_eq!((bytes[0], bytes[3]), ((255.0 * red + 0.5) as u8, byte(0.25)));
    let exr = read_image(&b).unwrap();
    assert!((exr.pixels[0][0] - decode_srgb(red)).abs() < 1e-6);
    assert!((exr.pixels[1][0] - 0.25).abs() < 1e-6);
}

#[test]
fn exr_holds_float_channels_and_the_metadata() {
    use exr::prelude::*;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    write_image(&path, &frame(), &options()).unwrap();
    let picture = read_first_flat_layer_from_file(&path).unwrap();
    let names: Vec<_> = picture.layer_data.channel_data.list.iter().map(|c| c.name.to_string()).collect();
    assert_eq!(names, ["A", "B", "G", "R", "Z", "depth.mean", "depth.median", "fragments.Y", "layers.Y"]);
    let values = |name: &str| -> Vec<f32> {
        let channels = &picture.layer_data.channel_data.list;
        let channel = channels.iter().find(|c| c.name.to_string() == name).unwrap();
        assert!(matches!(channel.sample_data, FlatSamples::F32(_)), "{name} is float32");
        channel.sample_data.values_as_f32().collect()
    };
    assert_eq!(values("R")[..3], [1.0, 0.375, 0.25]);
    assert_eq!(values("R")[4..], [2.0, (1.0f32 - 1e-7).mul_add(0.25, 1e-7)]);
    assert!(values("R")[3].is_nan(), "an EXR hides nothing");
    assert_eq!(values("A")[..3], [1.0, 0.5, 0.0]);
    assert_eq!(values("Z"), frame().depth);
    assert_eq!(Some(values("depth.median")), frame().depth_median);
    assert_eq!(Some(values("depth.mean")), frame().depth_mean);
    assert_eq!(values("fragments.Y"), [1.0, 2.0, 0.0, 4.0, 5.0, 100_000.0]);
    assert_eq!(values("layers.Y"), [1.0, 2.0, 0.0, 3.0, 3.0, 3.0]);
    for (name, value) in options().metadata {
        let found = picture.layer_data.attributes.other.get(&Text::from(name.as_str()));
        let Some(AttributeValue::Text(text)) = found else { panic!("{name}: {found:?}") };
        assert_eq!(text.as_slice(), value.as_bytes(), "{name}");
    }
    let without =
        pellucid_core::image::Image { depth_median: None, depth_mean: None, fragments: None, layers: None, ..frame() };
    write_image(&path, &without, &options()).unwrap();
    assert_eq!(read_first_flat_layer_from_file(&path).unwrap().layer_data.channel_data.list.len(), 5);
}

#[test]
fn the_same_image_gives_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    // Large enough for many compressed blocks.
    let side = 200;
    let pixels = 0..side * side;
    let large = Image {
        width: side,
        height: side,
        rgba: pixels.clone().map(|i| [(i as f32).sin(), (i % 7) as f32, 0.5, 1.0]).collect(),
        depth: pixels.clone().map(|i| i as f32).collect(),
        depth_median: None,
        depth_mean: None,
        fragments: Some(pixels.clone().collect()),
        layers: Some(pixels.collect()),
        ..Image::default()
    };
    for name in ["a.png", "a.exr"] {
        let bytes = || {
            let path = folder.path().join(name);
            write_image(&path, &large, &options()).unwrap();
            fs::read(path).unwrap()
        };
        let first = bytes();
        // The EXR encoder's hash map draws a new seed each time: ten runs with six names agree by chance only once in
        // 720⁹.
        for _ in 0..10 {
            assert!(bytes() == first, "{name}: the bytes differ between runs");
        }
    }
}

#[test]
fn bytes_that_came_with_an_image_are_those_of_an_opaque_png_and_of_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let (path, exr) = (folder.path().join("a.png"), folder.path().join("a.exr"));
    let bytes = Some(vec![[1, 2, 3, 0], [4, 5, 255, 3]]);
    let image = Image { width: 2, height: 1, bytes, ..Image::default() };
    write_image(&path, &image, &options()).unwrap();
    let (kind, pixels, _) = png_pixels(&path);
    assert_eq!((kind, pixels), (png::ColorType::Rgb, vec![1, 2, 3, 4, 5, 255]));
    let transparent = WriteOptions { transparent: true, ..options() };
    for (path, options) in [(&exr, options()), (&path, transparent)] {
        let refused = write_image(path, &image, &options);
        assert!(matches!(&refused, Err(Error::OnlyBytes(named)) if named == path), "{refused:?}");
    }
    assert!(!exr.exists());
}

#[test]
fn both_formats_are_read_back_as_linear_values() {
    let folder = tempfile::tempdir().unwrap();
    let (a, b) = (folder.path().join("a.png"), folder.path().join("a.exr"));
    write_image(&a, &frame(), &options()).unwrap();
    write_image(&b, &frame(), &options()).unwrap();
    let (png, exr) = (read_image(&a).unwrap(), read_image(&b).unwrap());
    assert_eq!((png.width, png.height, exr.width, exr.height), (3, 2, 3, 2));
    assert_eq!(exr.pixels[1], [0.375, 0.0, 0.5]);
    for (p, e) in png.pixels.iter().zip(&exr.pixels).take(3) {
        for channel in 0..3 {
            // Half a step of sRGB is at most 0.5/255·dL/dE, and the slope is at most 2.4/1.055 at white.
            assert!((p[channel] - e[channel]).abs() < 0.5 / 255.0 * 2.3, "{p:?} {e:?}");
        }
    }
}

#[test]
fn png_variants_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.png");
    let write = |color, depth, bytes: &[u8]| {
        let mut encoder = png::Encoder::new(fs::File::create(&path).unwrap(), 1, 1);
        encoder.set_color(color);
        encoder.set_depth(depth);
        encoder.write_header().unwrap().write_image_data(bytes).unwrap();
        read_image(&path).unwrap().pixels[0]
    };
    let gray = decode_srgb(128.0 / 255.0);
    let close = |found: [f32; 3], wanted: [f32; 3]| {
        // Two roundings of float32 values of at most 1.
        assert!(found.iter().zip(wanted).all(|(f, w)| (f - w).abs() < 2e-7), "{found:?} {wanted:?}");
    };
    close(write(png::ColorType::Grayscale, png::BitDepth::Eight, &[128]), [gray; 3]);
    close(write(png::ColorType::GrayscaleAlpha, png::BitDepth::Eight, &[128, 51]), [0.2 * gray; 3]);
    close(write(png::ColorType::Rgba, png::BitDepth::Eight, &[255, 128, 0, 51]), [0.2, 0.2 * gray, 0.0]);
    close(write(png::ColorType::Rgb, png::BitDepth::Sixteen, &[255, 255, 128, 128, 0, 0]), [1.0, gray, 0.0]);
}

#[test]
fn targets_that_can_not_be_written_are_refused_before() {
    let folder = tempfile::tempdir().unwrap();
    let here = |name: &str| folder.path().join(name);
    assert!(check_target(&here("a.png")).is_ok() && check_target(&here("a.EXR")).is_ok());
    for name in ["a.jpg", "a", "png", ".png"] {
        let error = check_target(&here(name)).unwrap_err();
        assert_eq!(error.exit_status(), 2, "{name}");
        assert!(error.to_string().contains(".png") && error.to_string().contains(".exr"), "{error}");
    }
    assert!(matches!(check_target(&here("missing/a.png")), Err(Error::NoFolder { .. })));
    fs::create_dir(here("d.png")).unwrap();
    assert!(matches!(check_target(&here("d.png")), Err(Error::IsFolder { .. })));
}

#[test]
fn after_a_failure_there_is_the_old_file_and_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.txt");
    let fail = || {
        write_atomically(&path, |out| {
            std::io::Write::write_all(out, b"half")?;
            Err(std::io::Error::other("the disk is full"))
        })
    };
    assert!(fail().unwrap_err().to_string().contains("the disk is full"));
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    write_atomically(&path, |out| std::io::Write::write_all(out, b"old")).unwrap();
    assert!(fail().is_err());
    assert_eq!(fs::read(&path).unwrap(), b"old");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[cfg(unix)]
#[test]
fn a_result_has_the_permissions_of_any_new_file() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().unwrap();
    let (a, b) = (folder.path().join("a"), folder.path().join("b"));
    fs::write(&a, "").unwrap();
    write_atomically(&b, |_| Ok(())).unwrap();
    let mode = |path| fs::metadata(path).unwrap().permissions().mode();
    assert_eq!(mode(&a), mode(&b));
}

#[test]
fn damaged_images_are_errors_that_name_the_file() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["a.png", "a.exr"] {
        let path = folder.path().join(name);
        write_image(&path, &frame(), &options()).unwrap();
        let whole = fs::read(&path).unwrap();
        for cut in [0, 5, whole.len() / 2, whole.len() - 30] {
            fs::write(&path, &whole[..cut]).unwrap();
            let error = read_image(&path).expect_err(name);
            assert!(error.to_string().contains(name), "{error}");
            assert_eq!(error.exit_status(), 1);
        }
    }
    assert!(matches!(read_image(Path::new("no/such.png")), Err(Error::Read { .. })));
}

#[test]
fn a_lying_header_is_refused_before_anything_is_allocated() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.png");
    let mut bytes = Vec::new();
    {
        let mut encoder = png::Encoder::new(&mut bytes, 65_000, 65_000);
        encoder.set_color(png::ColorType::Grayscale);
        encoder.set_depth(png::BitDepth::One);
        encoder.write_header().unwrap().write_chunk(png::chunk::IDAT, &[0x78, 0x9c]).unwrap();
    }
    fs::write(&path, &bytes).unwrap();
    assert!(matches!(read_image(&path), Err(Error::TooLarge { width: 65_000, height: 65_000, .. })));
}

/// Sizes that images may have, but not in files of a few hundred bytes: 3 GiB would be taken for them.
#[test]
fn a_size_that_the_file_cannot_hold_is_refused_before_anything_is_allocated() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |name: &str, bytes: &[u8]| {
        let path = folder.path().join(name);
        fs::write(&path, bytes).unwrap();
        let message = read_image(&path).expect_err(name).to_string();
        assert!(message.contains("16384 × 16384 pixels don't fit in"), "{message}");
    };
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 16_384, 16_384);
    encoder.set_color(png::ColorType::Rgba);
    encoder.set_depth(png::BitDepth::Sixteen);
    encoder.write_header().unwrap().write_chunk(png::chunk::IDAT, &[0x78, 0x9c]).unwrap();
    refused("a.png", &bytes);
    let path = folder.path().join("whole.exr");
    write_image(&path, &frame(), &options()).unwrap();
    let mut bytes = fs::read(&path).unwrap();
    // Both windows are four 32-bit numbers behind name, type and size: the largest x and y are the last two.
    for name in [&b"dataWindow\0box2i\0"[..], b"displayWindow\0box2i\0"] {
        let start = bytes.windows(name.len()).position(|window| window == name).unwrap() + name.len() + 4;
        bytes[start..start + 8].fill(0);
        bytes[start + 8..start + 12].copy_from_slice(&16_383u32.to_le_bytes());
        bytes[start + 12..start + 16].copy_from_slice(&16_383u32.to_le_bytes());
    }
    refused("a.exr", &bytes);
}

#[test]
fn a_picture_never_replaces_what_it_was_made_of() {
    let folder = tempfile::tempdir().unwrap();
    let [photo, other] = ["photo.png", "other.png"].map(|name| folder.path().join(name));
    fs::write(&photo, "the photograph").unwrap();
    let options = WriteOptions { inputs: Inputs::default().with([&photo]), ..options() };
    for path in [&photo, &folder.path().join("./photo.png")] {
        let error = write_image(path, &frame(), &options).unwrap_err();
        assert!(matches!(error, Error::Input { .. }) && error.exit_status() == 2, "{error}");
        assert!(error.to_string().contains("this would replace the input"), "{error}");
    }
    assert_eq!(fs::read(&photo).unwrap(), b"the photograph");
    write_image(&other, &frame(), &options).unwrap();
}

/// The standard attributes of an EXR: matrices of rows, as OpenEXR's `ImfStandardAttributes.h` defines them.
#[test]
fn cameras_are_standard_attributes_of_flat_and_deep_files() {
    use exr::prelude::MetaData;
    let folder = tempfile::tempdir().unwrap();
    let (eye, target) = (DVec3::new(3.0, -5.0, 2.0), DVec3::new(0.5, 0.25, 0.75));
    for projection in [Projection::Perspective { fov_y: 0.7 }, Projection::Orthographic { height: 4.0 }] {
        let camera = Camera::look_at(eye, target, DVec3::Z, projection, 0.5, 20.0).unwrap();
        let flat = folder.path().join("flat.exr");
        write_image(&flat, &frame(), &WriteOptions { camera: Some(camera), ..options() }).unwrap();
        let deep = folder.path().join("deep.exr");
        let layout = DeepLayout { camera: Some(camera), ..crate::deep::layout([3, 2]) };
        let mut writer = deep::Writer::begin(fs::File::create(&deep).unwrap(), &layout).unwrap();
        writer.push(&[0; 6], &[]).unwrap();
        writer.finish().unwrap();
        for file in [flat, deep] {
            let header = MetaData::read_from_file(&file, true).unwrap().headers.remove(0).own_attributes;
            let [to_camera, to_ndc] =
                [header.world_to_camera, header.world_to_normalized_device].map(|m| m.expect("the matrix"));
            for point in [DVec3::ZERO, target, DVec3::new(1.0, -1.0, 2.0), DVec3::new(-2.0, 0.5, 0.125)] {
                let row = point.extend(1.0).to_array();
                let times = |m: [f32; 16]| -> [f64; 4] {
                    std::array::from_fn(|i| (0..4).map(|k| row[k] * f64::from(m[4 * k + i])).sum())
                };
                let (view, found) = (camera.to_view(point), times(to_camera));
                assert!(
                    (DVec3::new(found[0], found[1], found[2]) - view).length() < 2e-6 && found[3] == 1.0,
                    "{found:?}"
                );
                let ([x, y, z, w], (pixel, depth)) = (times(to_ndc), camera.project(point, [3, 2]));
                assert!((x / w * 3.0 - pixel.x).abs() < 1e-5 && (y / w * 2.0 - pixel.y).abs() < 1e-5, "{x} {y} {w}");
                let whole = (depth - 0.5) / 19.5;
                let share = if w == 1.0 { whole } else { whole * 20.0 / depth };
                assert!((z / w - share).abs() < 1e-5, "{z} {w}: {share}");
            }
        }
    }
    // Beyond float32 there are none rather than infinite ones.
    let projection = Projection::Orthographic { height: 4.0 };
    let far = Camera::look_at(DVec3::splat(1e60), DVec3::ZERO, DVec3::Z, projection, 1.0, 2.0);
    for camera in [None, far] {
        let path = folder.path().join("none.exr");
        write_image(&path, &frame(), &WriteOptions { camera, ..options() }).unwrap();
        let header = MetaData::read_from_file(&path, true).unwrap().headers.remove(0).own_attributes;
        assert_eq!((header.world_to_camera, header.world_to_normalized_device), (None, None));
    }
}

#[test]
fn a_name_of_the_metadata_is_read_with_the_size_of_the_picture() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["a.png", "a.exr"] {
        let path = folder.path().join(name);
        write_image(&path, &frame(), &options()).unwrap();
        let found = tagged(&path, "pellucid:seed").unwrap();
        assert_eq!(found, Tagged { size: [3, 2], value: Some("value of seed äλ".into()) });
        assert_eq!(tagged(&path, "pellucid:none").unwrap(), Tagged { size: [3, 2], value: None });
        // Cut anywhere in its header it is damaged, but nothing panics.
        let bytes = fs::read(&path).unwrap();
        for length in 0..bytes.len().min(900) {
            fs::write(&path, &bytes[..length]).unwrap();
            drop(tagged(&path, "pellucid:seed"));
        }
        fs::write(&path, &bytes[..40]).unwrap();
        assert_eq!(tagged(&path, "pellucid:seed").unwrap_err().exit_status(), 1);
    }
}
