//! Work that the images of a frame with samples share: splats are projected and binned once, and moved for each
//! image. The mean must be that of the images rendered one by one.

use std::sync::Arc;

use glam::{DVec3, Vec3};
use pellucid_core::image::Image;
use pellucid_core::points::Points;
use pellucid_engine::methods::{Frame, Rendered, Renderer};
use pellucid_gpu::Device;
use pellucid_scene::{Method, Shading, ShadingModel};
use pellucid_testing::*;
use rand::RngExt;

/// The mean of a frame's images, each rendered as a frame by itself; the one whose depths the mean has, in place of
/// its depths.
fn one_by_one(device: &Device, points: &Points, frame: &Frame) -> Image {
    let mut renderer = Renderer::new(device).expect("a renderer");
    let mut cloud = renderer.upload(points).expect("fits");
    let middle = frame.samples / 2;
    let mut sums = vec![[0.0; 4]; (frame.size[0] * frame.size[1]) as usize];
    let mut last = None;
    for index in (0..frame.samples).filter(|index| *index != middle).chain([middle]) {
        let image = renderer.render(&mut cloud, &frame.image(index)).expect("renders").image;
        for (sum, color) in sums.iter_mut().zip(&image.rgba) {
            *sum = std::array::from_fn(|c| sum[c] + f64::from(color[c]));
        }
        last = Some(image);
    }
    let count = f64::from(frame.samples);
    let rgba = sums.into_iter().map(|sum: [f64; 4]| sum.map(|v| (v / count) as f32)).collect();
    Image { rgba, ..last.expect("a frame has images") }
}

fn together(device: &Device, points: &Points, frame: &Frame) -> Rendered {
    let mut renderer = Renderer::new(device).expect("a renderer");
    let mut cloud = renderer.upload(points).expect("fits");
    renderer.render(&mut cloud, frame).expect("renders")
}

/// Methods whose points are not dealt to ensembles, which are projected by themselves.
fn undealt() -> Vec<Method> {
    Method::all().into_iter().filter(|method| !method.is_dealt()).collect()
}

/// The largest difference of a color or A.
fn difference(a: &Image, b: &Image) -> f32 {
    let pairs = a.rgba.iter().flatten().zip(b.rgba.iter().flatten());
    pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

/// A field from 0 to 1 along x, for methods that tell soft points from others.
fn with_field(mut points: Points, width: f64) -> Points {
    points.fields = points.positions.iter().map(|p| (p.x / width).clamp(0.0, 1.0) as f32).collect();
    points
}

/// Discs for [`pixel_camera`] at multiples of 1/64 of a pixel: the shifts of up to 32 samples are multiples of such,
/// and adding them is exact.
fn on_a_grid(seed: u64, count: usize, [width, height]: [u32; 2]) -> Vec<P> {
    let mut r = random(seed);
    let mut place = |size: u32| f64::from(r.random_range(0..size * 64)) / 64.0;
    let places: Vec<(f64, f64, f64)> = (0..count).map(|_| (place(width), place(height), place(100) + 1.0)).collect();
    let discs = soup(seed, count, 0.4..3.0, 0.1..0.9, false);
    let placed = discs.into_iter().zip(places);
    placed.map(|(disc, (x, y, z))| P { position: DVec3::new(x, -y, -z), normal: Vec3::ZERO, ..disc }).collect()
}

const SIZE: [u32; 2] = [72, 56];

/// Sums that round differently where rectangles hold for all images: no more than that.
const ROUNDING: f32 = 2e-6;

#[test]
fn on_a_grid_of_64ths_the_mean_is_that_of_images_one_by_one() {
    let points = with_field(scene(&on_a_grid(3, 900, SIZE)), f64::from(SIZE[0]));
    with_device(|device| {
        for method in undealt() {
            let samples = if method == Method::Points { 32 } else { 4 };
            let frame = Frame { samples, ..frame(pixel_camera(SIZE), SIZE, method) };
            let expected = one_by_one(device, &points, &frame);
            let found = together(device, &points, &frame);
            let worst = difference(&found.image, &expected);
            assert!(worst <= ROUNDING, "{}: {worst}", method.name());
            let depths = |image: &Image| image.depth.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
            assert!(depths(&found.image) == depths(&expected), "{}", method.name());
            if ["points", "circles", "squares", "sorted", "abuffer"].contains(&method.name()) {
                assert!(bits(&found.image) == bits(&expected), "{}", method.name());
            }
        }
    });
}

#[test]
fn a_moved_place_is_rounded_once_more() {
    for oriented in [false, true] {
        let points = with_field(scene(&soup(5, 1500, 0.02..0.15, 0.1..0.9, oriented)), 1.0);
        with_device(|device| {
            for method in undealt() {
                let frame = Frame { samples: 4, ..frame(perspective(), [80, 60], method) };
                let worst = difference(&together(device, &points, &frame).image, &one_by_one(device, &points, &frame));
                // 2^-25 of a pixel, over radii of some pixels, times the fragments of a pixel.
                assert!(worst <= 2e-5, "{}: {worst}", method.name());
            }
        });
    }
}

#[test]
fn three_of_four_images_neither_project_nor_bin() {
    let points = scene(&on_a_grid(7, 600, SIZE));
    with_device(|device| {
        for (name, bins) in [("circles", 0), ("sorted", 3), ("weighted", 3), ("abuffer", 0), ("hqs", 3)] {
            let method = Method::all().into_iter().find(|method| method.name() == name).expect("a method");
            let of = |samples| Frame { samples, fragments: false, ..frame(pixel_camera(SIZE), SIZE, method) };
            let (alone, four) = (together(device, &points, &of(1)).facts, together(device, &points, &of(4)).facts);
            assert_eq!((alone.shared_projections, alone.shared_bins), (0, 0), "{name}");
            assert_eq!((alone.windows, four.windows), (1, 4), "{name}");
            assert_eq!((four.shared_projections, four.shared_bins), (3, bins), "{name}");
        }
    });
}

#[test]
fn windows_budgets_orders_and_frames_before_change_no_byte() {
    let discs = soup(11, 60_000, 0.002..0.02, 0.1..0.9, true);
    let mut shuffled = discs.clone();
    shuffled.reverse();
    let (points, shuffled) = (Arc::new(with_field(scene(&discs), 1.0)), with_field(scene(&shuffled), 1.0));
    with_device(|device| {
        for name in ["points", "circles", "hqs", "sorted", "weighted", "abuffer", "peel", "soft-base", "stochastic"] {
            let method = Method::all().into_iter().find(|method| method.name() == name).expect("a method");
            let whole = Frame { samples: 4, ..frame(perspective(), [160, 120], method) };
            let mut renderer = Renderer::new(device).expect("a renderer");
            let mut cloud = renderer.upload(&*points).expect("fits");
            let expected = renderer.render(&mut cloud, &whole).expect("renders");
            // Foreseen counts, where the device can leave commands out.
            for _ in 0..3 {
                let again = renderer.render(&mut cloud, &whole).expect("renders");
                assert!(bits(&again.image) == bits(&expected.image), "{name}, once more");
            }
            let other = together(device, &shuffled, &whole);
            assert!(bits(&other.image) == bits(&expected.image), "{name}, in another order");
            let small = Frame { memory_budget: Some(9 << 20), ..whole };
            let mut supplied = by_windows(&renderer, &points);
            for _ in 0..2 {
                let found = renderer.render(&mut supplied, &small).expect("renders");
                assert!(found.facts.windows > 4, "{name}: {} windows", found.facts.windows);
                assert!(bits(&found.image) == bits(&expected.image), "{name}, by windows");
            }
        }
    });
}

#[test]
fn points_shaded_once_for_16_images_give_the_bytes_of_points_shaded_in_each() {
    let points = scene(&on_a_grid(13, 700, SIZE));
    let shading = Shading { model: ShadingModel::Lambert, ..Shading::default() };
    with_device(|device| {
        let frame = Frame { samples: 16, shading, ..frame(pixel_camera(SIZE), SIZE, Method::Points) };
        let expected = bits(&one_by_one(device, &points, &frame));
        // Keys of 8 images at a time, of fewer, and of one.
        for memory_budget in [None, Some(400_000), Some(140_000)] {
            let found = together(device, &points, &Frame { memory_budget, ..frame });
            assert!(bits(&found.image) == expected, "{memory_budget:?}");
            if memory_budget.is_none() {
                assert_eq!((found.facts.shared_projections, found.facts.shaded_points), (14, 700));
            }
        }
    });
}
