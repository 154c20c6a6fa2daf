//! Bytes of pictures: those that the device makes are those of the host.

use std::path::Path;
use std::sync::Arc;

use pellucid_engine::methods::encode::byte_steps;
use pellucid_gpu::{Buffer, Memory};
use pellucid_scene::{ColorSpace, Document, Overrides, Scene};
use pellucid_testing::with_device;
use pellucid_viewer::display::{self, SceneImage, ScreenEncoder};
use rand::{RngExt, SeedableRng};

/// An empty scene with a picture of this size.
fn scene([width, height]: [u32; 2], color: &str) -> Scene {
    let text = format!(
        "[image]\nsize = [{width}, {height}]\nbackground = [0.5, 1.0, 0.0]\ncolor = '{color}'\n[[cloud]]\npath = 'a.ply'"
    );
    Document::from_toml(&text, Path::new("/scans/s.toml"), &Overrides::default()).unwrap().scene().unwrap()
}

#[test]
fn composed_pixels_are_those_of_the_image() {
    let scene = scene([2, 1], "linear");
    let composed = SceneImage { size: [2, 1], scene: &scene }.composed(&[[0.25, 0.0, 0.0, 0.5], [0.0; 4]]);
    assert_eq!(composed, [[0.5, 0.5, 0.0], [0.5, 1.0, 0.0]]);
    let bytes = display::bytes(&composed, ColorSpace::Linear);
    assert_eq!(bytes, [188, 188, 0, 255, 188, 255, 0, 255]);
}

/// Values near each step of a byte, others by chance, and some that are no colors.
fn pixels(count: usize) -> Vec<[f32; 4]> {
    let mut random = rand_pcg::Pcg64::seed_from_u64(11);
    let odd = [0.0, -0.0, -1.0, 1.5, f32::INFINITY, f32::NEG_INFINITY, f32::NAN, f32::MIN_POSITIVE, 1e-42];
    let mut value = |i: usize| match i % 4 {
        0 => odd[random.random_range(0..odd.len())],
        1 => random.random_range(-0.1..1.1f32),
        _ => {
            let color = if i % 8 < 4 { ColorSpace::Linear } else { ColorSpace::Encoded };
            let step = byte_steps(color)[random.random_range(1..256)];
            f32::from_bits(step.to_bits().wrapping_add_signed(random.random_range(-2..3)))
        }
    };
    (0..count).map(|i| [value(5 * i), value(7 * i + 1), value(3 * i + 2), if i % 3 == 0 { 0.5 } else { 1.0 }]).collect()
}

/// Bytes of a picture in the order of memory.
fn bytes(shown: &Buffer<u32>) -> Vec<u8> {
    shown.read(0, shown.len()).unwrap().into_iter().flat_map(u32::to_le_bytes).collect()
}

#[test]
fn the_devices_bytes_are_those_of_the_host() {
    with_device(|device| {
        for (size, color) in [([161, 100], "linear"), ([64, 300], "encoded")] {
            let scene = scene(size, color);
            let pixels = pixels((size[0] * size[1]) as usize);
            let colors = device.buffer("colors", pixels.len() as u64, Memory::Device).unwrap();
            colors.upload(&pixels).unwrap();
            let image = SceneImage { size, scene: &scene };
            let host = display::bytes(&image.composed(&pixels), scene.image.color_space());
            let swapped: Vec<u8> = host.chunks(4).flat_map(|p| [p[2], p[1], p[0], p[3]]).collect();
            for (blue_first, wanted) in [(false, &host), (true, &swapped)] {
                let mut encoder = ScreenEncoder::new(device, blue_first).unwrap();
                let encoded = encoder.encode(colors.all(), image).unwrap();
                assert!(bytes(&encoded) == *wanted, "{color}, {blue_first}");
                let uploaded = encoder.upload(&image.composed(&pixels), &scene).unwrap();
                assert!(bytes(&uploaded) == *wanted, "{color}, {blue_first}");
            }
        }
    });
}

/// Weights are float64 on the host.
#[test]
fn the_device_enlarges_as_the_host_does() {
    with_device(|device| {
        let mut random = rand_pcg::Pcg64::seed_from_u64(5);
        for (from, to) in [([31, 21], [123, 82]), ([50, 40], [50, 41]), ([1, 1], [7, 5])] {
            let scene = scene(to, "linear");
            let pixels: Vec<[f32; 4]> = (0..from[0] * from[1]).map(|_| random.random()).collect();
            let colors = device.buffer("colors", pixels.len() as u64, Memory::Device).unwrap();
            colors.upload(&pixels).unwrap();
            let image = SceneImage { size: from, scene: &scene };
            let shown = ScreenEncoder::new(device, false).unwrap().encode(colors.all(), image).unwrap();
            let host = display::bytes(&image.composed(&pixels), scene.image.color_space());
            let most = bytes(&shown).iter().zip(&host).map(|(a, b)| a.abs_diff(*b)).max();
            assert!(most <= Some(1), "{from:?} to {to:?}: {most:?}");
        }
    });
}

#[test]
fn pictures_that_nobody_holds_are_written_again() {
    with_device(|device| {
        let scene = scene([8, 4], "linear");
        let mut encoder = ScreenEncoder::new(device, false).unwrap();
        let mut upload = |value: f32| encoder.upload(&[[value; 3]; 32], &scene).unwrap();
        let (first, second) = (upload(0.0), upload(1.0));
        assert!(!Arc::ptr_eq(&first, &second));
        let before = Arc::as_ptr(&first);
        drop(first);
        let third = upload(1.0);
        assert_eq!(Arc::as_ptr(&third), before);
        assert_eq!(second.read(0, 32).unwrap(), vec![u32::MAX; 32]);
    });
}
