//! Colors on their way to the host: those that stay on the device, or come as the bytes of a PNG, are those that come
//! as floats. They come so where the host goes on with them.

use glam::Vec3;
use pellucid_core::image::{Cover, Image};
use pellucid_core::progress::Progress;
use pellucid_engine::methods::{Colors, Frame, Outputs, Renderer};
use pellucid_engine::passes::project::DeviceCloud;
use pellucid_gpu::Device;
use pellucid_io::output::{Inputs, WriteOptions, raster};
use pellucid_scene::prepare::Arranged;
use pellucid_scene::prepare::ensembles::deal;
use pellucid_scene::{ColorSpace, Edl, Method, Shading};
use pellucid_testing::*;

const SIZE: [u32; 2] = [64, 40];

/// A renderer with a cloud.
fn of_soup(device: &Device) -> (Renderer, DeviceCloud) {
    let points = scene(&soup(31, 400, 0.02..0.1, 0.1..0.9, false));
    let renderer = Renderer::new(device).expect("a renderer");
    let cloud = renderer.upload(&points).expect("fits");
    (renderer, cloud)
}

#[test]
fn colors_that_stay_are_those_that_come() {
    with_device(|device| {
        let (mut renderer, mut cloud) = of_soup(device);
        let points = scene(&soup(31, 400, 0.02..0.1, 0.1..0.9, false));
        let mut dealt = renderer.upload(&Arranged::Dealt(deal(vec![points], 1, &Progress::hidden()))).expect("fits");
        let mut brightened = 0;
        for method in Method::all() {
            let frame = frame(perspective(), SIZE, method);
            let cloud = if method.is_dealt() { &mut dealt } else { &mut cloud };
            let image = renderer.render(cloud, &frame).expect("renders").image;
            let frame = Frame { outputs: Outputs::SCREEN, ..frame };
            // Twice: the second frame of a kind knows the counts of the first.
            for _ in 0..2 {
                let left = renderer.render(cloud, &frame).expect("renders");
                let name = method.name();
                if left.image.has_colors() {
                    assert!(left.image == image && name == "spbr-simplified", "{name}");
                    brightened += 1;
                    continue;
                }
                assert_eq!(left.image.depth, image.depth, "{name}");
                let read = left.profile.passes.iter().find(|pass| pass.name == "image/read-back").expect("depths");
                assert_eq!(read.bytes, Some(u64::from(SIZE[0] * SIZE[1]) * 8), "{name}");
                let colors = renderer.read_colors().expect("can be read").expect("are there");
                assert!(bits_of(&colors) == bits_of(&image.rgba), "{name}");
                renderer.recycle(left.image);
            }
        }
        assert_eq!(brightened, 2, "one method changes colors on the host");
    });
}

fn bits_of(colors: &[[f32; 4]]) -> Vec<[u32; 4]> {
    colors.iter().map(|color| color.map(f32::to_bits)).collect()
}

#[test]
fn colors_come_where_the_device_has_not_all_of_them() {
    with_device(|device| {
        let (mut renderer, mut cloud) = of_soup(device);
        let plain = frame(perspective(), SIZE, Method::ABuffer(Default::default()));
        let edl = Edl { edl: true, ..Edl::default() };
        let lit = Frame { shading: Shading { edl, ..plain.shading }, ..plain };
        let cut = Frame { size: [600, 500], memory_budget: Some(1 << 20), ..plain };
        let deep = Frame { depths: true, ..plain };
        for (frame, windows) in [(lit, 1..2), (deep, 1..2), (cut, 2..1000)] {
            let leaving = Frame { outputs: Outputs::SCREEN, ..frame };
            let there = renderer.render(&mut cloud, &leaving).expect("renders");
            assert!(windows.contains(&there.facts.windows), "{}", there.facts.windows);
            assert!(there.image.has_colors() && renderer.colors().is_none());
            let image = renderer.render(&mut cloud, &frame).expect("renders").image;
            assert!(there.image == image);
        }
    });
}

#[test]
fn colors_are_gone_once_anything_else_is_rendered() {
    with_device(|device| {
        let (mut renderer, mut cloud) = of_soup(device);
        let plain = frame(perspective(), SIZE, Method::ABuffer(Default::default()));
        let frame = Frame { outputs: Outputs::SCREEN, ..plain };
        let left = |renderer: &mut Renderer, cloud: &mut DeviceCloud| {
            renderer.render(cloud, &frame).expect("renders");
            assert!(renderer.colors().is_some());
        };
        left(&mut renderer, &mut cloud);
        renderer.survey(&mut cloud, &frame).expect("surveys");
        assert!(renderer.colors().is_none());
        left(&mut renderer, &mut cloud);
        device.allow_submissions(Some(0));
        assert!(renderer.render(&mut cloud, &frame).is_err() && renderer.colors().is_none());
        device.allow_submissions(None);
    });
}

const BACKGROUND: Vec3 = Vec3::new(0.25, 0.5, 1.0);

/// Bytes of the PNG that the host makes of an image, and the cover of its pixels.
fn png_pixels(image: &Image, color: ColorSpace) -> Vec<[u8; 4]> {
    let options = WriteOptions {
        background: BACKGROUND,
        color,
        transparent: false,
        metadata: Vec::new(),
        camera: None,
        inputs: Inputs::default(),
    };
    let covers = image.covers().map(|cover| cover as u8);
    let colors = raster(image, &options).bytes;
    colors.as_chunks().0.iter().zip(covers).map(|(&[r, g, b], cover)| [r, g, b, cover]).collect()
}

#[test]
fn bytes_that_come_are_those_of_the_png_of_every_method() {
    with_device(|device| {
        let (mut renderer, mut cloud) = of_soup(device);
        let points = scene(&soup(31, 400, 0.02..0.1, 0.1..0.9, false));
        let mut dealt = renderer.upload(&Arranged::Dealt(deal(vec![points], 1, &Progress::hidden()))).expect("fits");
        let (mut brightened, mut covers) = (0, [0; 4]);
        for (number, method) in Method::all().into_iter().enumerate() {
            let name = method.name();
            let color = if number % 2 == 0 { ColorSpace::Linear } else { ColorSpace::Encoded };
            let frame = Frame { color, background: BACKGROUND, ..frame(perspective(), SIZE, method) };
            let cloud = if method.is_dealt() { &mut dealt } else { &mut cloud };
            let image = renderer.render(cloud, &frame).expect("renders").image;
            let wanted = png_pixels(&image, color);
            // Twice: the second frame of a kind knows the counts of the first.
            for _ in 0..2 {
                let png = Frame { outputs: Outputs::PNG, ..frame };
                let rendered = renderer.render(cloud, &png).expect("renders");
                if rendered.image.has_colors() {
                    assert!(rendered.image == image && name == "spbr-simplified", "{name}");
                    brightened += 1;
                    continue;
                }
                assert!(rendered.image.bytes.as_ref() == Some(&wanted), "{name}");
                assert!(rendered.image.depth.is_empty() && rendered.image.rgba.is_empty(), "{name}");
                let of_pass = |name| rendered.profile.passes.iter().find(|pass| pass.name == name).expect("runs").bytes;
                // Four bytes, read and written; and colors of 16 bytes as four.
                let pixels = u64::from(SIZE[0] * SIZE[1]);
                assert_eq!(of_pass("image/read-back"), Some(pixels * 8), "{name}");
                assert_eq!(of_pass("image/encode"), Some(pixels * 20), "{name}");
                renderer.recycle(rendered.image);
            }
            wanted.iter().for_each(|pixel| covers[usize::from(pixel[3])] += 1);
        }
        assert_eq!(brightened, 2, "one method changes colors on the host");
        // No point is faint.
        assert!([0, 2, 3].iter().all(|cover| covers[*cover] > 0), "{covers:?}");
    });
}

#[test]
fn faint_points_hardly_cover_a_pixel() {
    with_device(|device| {
        // Opacities up to half of what is more than hardly anything.
        let points = scene(&soup(32, 50, 0.02..0.1, 0.001..0.005, false));
        let mut renderer = Renderer::new(device).expect("a renderer");
        let mut cloud = renderer.upload(&points).expect("fits");
        let method = Method::ABuffer(Default::default());
        let frame = Frame { background: BACKGROUND, ..frame(perspective(), SIZE, method) };
        let image = renderer.render(&mut cloud, &frame).expect("renders").image;
        let png = renderer.render(&mut cloud, &Frame { outputs: Outputs::PNG, ..frame }).expect("renders").image;
        let bytes = png.bytes.expect("asked for");
        assert!(bytes == png_pixels(&image, frame.color));
        assert!(bytes.iter().any(|pixel| pixel[3] == Cover::Hardly as u8));
    });
}

#[test]
fn bytes_come_window_by_window_and_floats_where_the_host_goes_on_with_them() {
    with_device(|device| {
        let (mut renderer, mut cloud) = of_soup(device);
        let method = Method::ABuffer(Default::default());
        let plain = Frame { background: BACKGROUND, ..frame(perspective(), SIZE, method) };
        let cut = Frame { size: [600, 500], memory_budget: Some(1 << 20), ..plain };
        let whole = renderer.render(&mut cloud, &cut).expect("renders");
        assert!(whole.facts.windows > 1);
        for outputs in [Outputs::PNG, Outputs { depth: true, ..Outputs::PNG }] {
            let png = renderer.render(&mut cloud, &Frame { outputs, ..cut }).expect("renders").image;
            assert!(png.bytes == Some(png_pixels(&whole.image, cut.color)));
            assert!(png.depth == if outputs.depth { whole.image.depth.clone() } else { Vec::new() });
        }
        let edl = Edl { edl: true, ..Edl::default() };
        let lit = Frame { shading: Shading { edl, ..plain.shading }, ..plain };
        for frame in [lit, Frame { depths: true, ..plain }, Frame { samples: 4, ..plain }] {
            let image = renderer.render(&mut cloud, &frame).expect("renders").image;
            let png = renderer.render(&mut cloud, &Frame { outputs: Outputs::PNG, ..frame }).expect("renders").image;
            assert!(png == image && png.bytes.is_none());
        }
    });
}

#[test]
fn depths_alone_are_left_out_and_come_again() {
    with_device(|device| {
        let (mut renderer, mut cloud) = of_soup(device);
        let all = frame(perspective(), SIZE, Method::Points);
        let image = renderer.render(&mut cloud, &all).expect("renders").image;
        for colors in [Colors::Float, Colors::Bytes, Colors::Stay] {
            let without = Frame { outputs: Outputs { colors, depth: false }, ..all };
            let shallow = renderer.render(&mut cloud, &without).expect("renders").image;
            assert!(shallow.depth.is_empty(), "{colors:?}");
            assert_eq!(shallow.pixel_bytes(), without.outputs.pixel_bytes(), "{colors:?}");
            renderer.recycle(shallow);
            assert!(renderer.render(&mut cloud, &all).expect("renders").image == image, "{colors:?}");
        }
    });
}
