//! Images of a frame with samples that are drawn at once: four as one of quarters of pixels, and those of points by one
//! walk. The mean must be that of the images rendered one by one.

use std::sync::Arc;

use glam::{DVec3, Vec3};
use pellucid_core::image::Image;
use pellucid_core::points::Points;
use pellucid_engine::methods::{Frame, Rendered, Renderer};
use pellucid_gpu::Device;
use pellucid_scene::{Discs, Edl, GaussianSettings, Method, ScreenSplats, Shading, ShadingModel, Soft};
use pellucid_testing::gaussians::Soup;
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

/// Sums that round differently where other tiles group their terms: no more than that.
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

/// A projected place is rounded by 2^-25 of a pixel, or of a quarter of one: over radii of some pixels, times the
/// fragments of a pixel.
const PLACES: f32 = 2e-5;

#[test]
fn images_at_once_are_those_that_are_drawn_one_by_one() {
    for oriented in [false, true] {
        let points = with_field(scene(&soup(5, 1500, 0.02..0.15, 0.1..0.9, oriented)), 1.0);
        with_device(|device| {
            for method in undealt() {
                let frame = Frame { samples: 4, ..frame(perspective(), [80, 60], method) };
                let worst = difference(&together(device, &points, &frame).image, &one_by_one(device, &points, &frame));
                assert!(worst <= PLACES, "{}: {worst}", method.name());
            }
        });
    }
}

/// Largest radii, radii in pixels, dilation and the pixels of a shell: a frame of quarters has them twice as large.
#[test]
fn what_is_given_in_pixels_is_given_in_those_of_the_picture() {
    let points = with_field(scene(&soup(6, 1200, 0.02..0.15, 0.1..0.9, false)), 1.0);
    let gaussians = Soup { count: 400, ..Soup::default() }.points();
    let splats = ScreenSplats::default();
    let discs = Discs::default();
    let dilated = GaussianSettings { dilation: 1.5, ..discs.gaussians };
    let subjects = [
        (&points, Method::Circles(ScreenSplats { max_pixel_radius: 1.5, ..splats })),
        (&points, Method::Squares(ScreenSplats { pixel_radius: Some(2.25), ..splats })),
        (&points, Method::SoftConcentric(Soft { pixels_per_shell: 1.0, ..Soft::default() })),
        (&gaussians, Method::Sorted(Discs { gaussians: dilated, ..discs })),
        (&gaussians, Method::ABuffer(Discs { gaussians: GaussianSettings { antialias: true, ..dilated }, ..discs })),
    ];
    with_device(|device| {
        for (points, method) in &subjects {
            let frame = Frame { samples: 16, ..frame(perspective(), [80, 60], *method) };
            let (found, expected) = (together(device, points, &frame), one_by_one(device, points, &frame));
            assert_eq!(found.facts.images, 4, "{}", method.name());
            let worst = difference(&found.image, &expected);
            assert!(worst <= PLACES, "{}: {worst}", method.name());
        }
    });
}

#[test]
fn lengths_of_lists_are_the_sums_over_images() {
    let points = scene(&on_a_grid(9, 700, SIZE));
    with_device(|device| {
        for name in ["abuffer", "sorted", "peel", "weighted", "circles"] {
            let method = named(name);
            let frame = Frame { samples: 8, fragments: true, ..frame(pixel_camera(SIZE), SIZE, method) };
            let found = together(device, &points, &frame).image;
            let mut renderer = Renderer::new(device).expect("a renderer");
            let mut cloud = renderer.upload(&points).expect("fits");
            let mut image = |index| renderer.render(&mut cloud, &frame.image(index)).expect("renders").image;
            let images: Vec<Image> = (0..8).map(&mut image).collect();
            for (found, of) in [
                (&found.fragments, images.iter().map(|image| &image.fragments).collect::<Vec<_>>()),
                (&found.layers, images.iter().map(|image| &image.layers).collect()),
            ] {
                let Some(found) = found else { continue };
                for (pixel, found) in found.iter().enumerate() {
                    let wanted: u32 = of.iter().copied().flatten().map(|of| of[pixel]).sum();
                    assert_eq!(*found, wanted, "{name}, pixel {pixel}");
                }
            }
        }
    });
}

fn named(name: &str) -> Method {
    Method::all().into_iter().find(|method| method.name() == name).expect("a method")
}

#[test]
fn four_images_are_one_unless_pixels_need_their_neighbors_or_random_numbers() {
    let points = scene(&on_a_grid(7, 600, SIZE));
    let shading = |edl| Shading { edl: Edl { edl, ..Edl::default() }, ..Shading::NONE };
    with_device(|device| {
        for (name, edl, wanted) in [
            ("circles", false, 1),
            ("sorted", false, 1),
            ("abuffer", false, 1),
            ("soft-base", false, 1),
            ("circles", true, 4),
            ("image-space", false, 4),
            ("stochastic", false, 4),
            ("points", false, 4),
        ] {
            let method = named(name);
            let of = |samples| Frame { samples, shading: shading(edl), ..frame(pixel_camera(SIZE), SIZE, method) };
            let [alone, two, four] = [1, 2, 4].map(|samples| together(device, &points, &of(samples)).facts);
            assert_eq!((alone.images, two.images, four.images), (1, 2, wanted), "{name}, {edl}");
            assert_eq!(four.shared_walks, if name == "points" { 3 } else { 0 }, "{name}");
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
            let method = named(name);
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
                let (windows, images) = (found.facts.windows, found.facts.images);
                assert!(windows > images, "{name}: {windows} windows");
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
                assert_eq!((found.facts.shared_walks, found.facts.shaded_points), (14, 700));
            }
        }
    });
}
