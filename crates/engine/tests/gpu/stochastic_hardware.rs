//! `stochastic` by multisampled rasterization, against the float64 reference and against the compute way.

use glam::{DVec3, Vec3};
use pellucid_core::camera::Camera;
use pellucid_core::image::Image;
use pellucid_core::points::Points;
use pellucid_engine::methods::{Frame, Rendered, Renderer};
use pellucid_gpu::Device;
use pellucid_reference::View;
use pellucid_reference::{self as reference, ReferencePicture};
use pellucid_scene::{DiscShape, Discs, Falloff, Method, Raster, Stochastic};
use pellucid_testing::*;
use rand::seq::SliceRandom;

fn stochastic(shape: DiscShape, falloff: Falloff, samples: u32, alpha_correction: bool) -> Stochastic {
    let discs = Discs { shape, falloff, raster: Raster::Hardware, ..Discs::default() };
    Stochastic { discs, samples, alpha_correction }
}

/// Returns the settings with compute shaders instead of the rasterizer.
fn in_compute(settings: Stochastic) -> Stochastic {
    Stochastic { discs: Discs { raster: Raster::Compute, ..settings.discs }, ..settings }
}

fn drawn(device: &Device, points: &Points, frame: &Frame) -> Rendered {
    let mut renderer = Renderer::new(device).expect("a renderer");
    let mut cloud = renderer.upload(points).expect("fits");
    let rendered = renderer.render(&mut cloud, frame).expect("renders");
    assert_eq!(rendered.facts.raster, "hardware");
    rendered
}

fn sampled(
    points: &Points,
    camera: &Camera,
    size: [u32; 2],
    settings: &Stochastic,
    seed: u64,
) -> (ReferencePicture, Vec<DVec3>) {
    let colors: Vec<DVec3> = points.colors.iter().map(|c| c.as_dvec3()).collect();
    reference::stochastic::render(View::new(camera, size), points, &colors, settings, seed)
}

fn longest(image: &Image) -> u32 {
    image.fragments.iter().flatten().copied().max().expect("counted")
}

/// The largest difference of sums of this many fragments and strata in another order: each sum by n roundings of 2⁻²⁴
/// of itself, in color and opacity, in both of two images.
fn bound(fragments: u32, samples: u32) -> f64 {
    4.0 * f64::from(fragments + samples.div_ceil(4)) * 0.5f64.powi(24)
}

/// Share of the pixels whose color, depth or standard error is another one than the reference's, but for rounding.
fn share_off(image: &Image, (wanted, errors): &(ReferencePicture, Vec<DVec3>), bound: f64) -> f64 {
    let found = image.stderr.as_ref().expect("asked for");
    let is_off = |p: &usize| {
        let far = |(a, b): (&f32, &f64)| (f64::from(*a) - b).abs() > bound || a.is_nan();
        let color = image.rgba[*p].iter().zip(&wanted.rgba[*p]).any(far);
        // A few roundings of a depth of about 5, and a slope of at most some hundred.
        let (z, depth) = (f64::from(image.depth[*p]), wanted.depth[*p]);
        let depth = z != depth && (z - depth).abs() > 2e-5 * depth.abs();
        let apart = |(a, b): (&f32, f64)| f64::from(*a) != b && (f64::from(*a) - b).abs() > bound + 1e-3 * b;
        color || depth || found[*p].iter().zip(errors[*p].to_array()).any(apart)
    };
    (0..image.rgba.len()).filter(is_off).count() as f64 / image.rgba.len() as f64
}

#[test]
fn samples_are_those_of_the_reference() {
    with_device(|device| {
        let size = [80, 60];
        let mixed = [soup(3, 700, 0.0..0.1, 0.0..1.0, true), soup(4, 30, 0.2..1.5, 0.05..0.4, true)].concat();
        let cases = [
            (perspective(), DiscShape::Flat, Falloff::Flat, 64, true),
            (perspective(), DiscShape::Oriented, Falloff::Gaussian, 6, true),
            (perspective(), DiscShape::Oriented, Falloff::Flat, 4, true),
            (perspective(), DiscShape::Flat, Falloff::Gaussian, 1, true),
            (orthographic(), DiscShape::Flat, Falloff::Flat, 6, false),
            (orthographic(), DiscShape::Oriented, Falloff::Gaussian, 64, false),
            (orthographic(), DiscShape::Oriented, Falloff::Flat, 9, true),
        ];
        for (camera, shape, falloff, samples, correction) in cases {
            let points = scene(&safe(&mixed, &camera, size, shape));
            let settings = stochastic(shape, falloff, samples, correction);
            let frame = Frame { seed: 7, ..frame(camera, size, Method::Stochastic(settings)) };
            let rendered = drawn(device, &points, &frame);
            let image = &rendered.image;
            let wanted = sampled(&points, &camera, size, &settings, 7);
            let bound = bound(longest(image), samples);
            let off = share_off(image, &wanted, bound);
            // Flat opacities are the same numbers in both, flat depths are far enough apart. Where float32 decides the
            // rounding of a Gaussian opacity to samples, or the order of two tilted discs, a pixel may be off by a
            // sample.
            let allowed = if (shape, falloff) == (DiscShape::Flat, Falloff::Flat) { 0.0 } else { 0.003 };
            assert!(off <= allowed, "{settings:?}: {off}");
            assert_eq!(image.fragments.as_deref(), Some(&wanted.0.counts[..]));
            // Another seed's samples are others, and the comparison notices: a color within its bound of one reference
            // is off the other where these are two bounds apart. Few pixels are: with alpha correction a single
            // fragment, or several of one color, have no noise.
            let other = sampled(&points, &camera, size, &settings, 8);
            let are_apart = |(a, b): (&[f64; 4], &[f64; 4])| a.iter().zip(b).any(|(a, b)| (a - b).abs() > 2.0 * bound);
            let apart = wanted.0.rgba.iter().zip(&other.0.rgba).filter(|pair| are_apart(*pair)).count();
            let apart = apart as f64 / wanted.0.rgba.len() as f64;
            let found = share_off(image, &other, bound);
            println!("{settings:?}: {found} off the other seed, {apart} apart");
            assert!(apart > 0.01 && found >= apart - off, "{settings:?}: {found}, {apart}");
        }
    });
}

/// Points on few levels of depth, many at one place, with some that are opaque.
fn tied() -> Vec<P> {
    let mut tied = soup(21, 1500, 0.0..0.2, 0.1..1.1, true);
    for p in &mut tied {
        p.position = (p.position * 4.0).round() / 4.0;
        p.opacity = p.opacity.min(1.0);
    }
    tied
}

#[test]
fn the_image_is_that_of_the_compute_way() {
    with_device(|device| {
        let crossing = [soup(22, 1000, 0.0..0.1, 0.0..0.9, true), soup(23, 20, 0.5..3.0, 0.1..0.3, true)].concat();
        let cases = [
            (tied(), perspective(), DiscShape::Flat, Falloff::Flat, 64, true),
            (tied(), orthographic(), DiscShape::Flat, Falloff::Flat, 6, false),
            (crossing, perspective(), DiscShape::Oriented, Falloff::Gaussian, 6, true),
        ];
        for (points, camera, shape, falloff, samples, correction) in cases {
            let points = scene(&points);
            let settings = stochastic(shape, falloff, samples, correction);
            let by = |settings| frame(camera, [97, 77], Method::Stochastic(settings));
            let found = drawn(device, &points, &by(settings)).image;
            let wanted = render(device, &points, &by(in_compute(settings)));
            let bound = bound(longest(&found), samples);
            let far = |(a, b): (&[f32; 4], &[f32; 4])| a.iter().zip(b).any(|(a, b)| f64::from((a - b).abs()) > bound);
            let off = found.rgba.iter().zip(&wanted.rgba).filter(|(a, b)| far((*a, *b))).count();
            let depths = found.depth.iter().zip(&wanted.depth).filter(|(a, b)| a != b).count();
            assert_eq!((off, depths), (0, 0), "{settings:?}, bound {bound}");
            assert_eq!(found.fragments, wanted.fragments);
        }
    });
}

#[test]
fn the_bytes_depend_on_nothing_but_the_scene() {
    with_device(|device| {
        let mut points = tied();
        let settings = stochastic(DiscShape::Oriented, Falloff::Gaussian, 6, true);
        let mut frame = frame(perspective(), [160, 120], Method::Stochastic(settings));
        let once = drawn(device, &scene(&points), &frame);
        assert_eq!(once.facts.windows, 1);
        let same = |other: &Rendered| {
            let errors =
                |r: &Rendered| r.image.stderr.iter().flatten().flatten().map(|v| v.to_bits()).collect::<Vec<_>>();
            bits(&other.image) == bits(&once.image) && errors(other) == errors(&once)
        };
        assert!(same(&drawn(device, &scene(&points), &frame)), "a second frame differs");
        points.shuffle(&mut random(5));
        assert!(same(&drawn(device, &scene(&points), &frame)), "the order of points shows");
        frame.memory_budget = Some(4 << 20);
        let cut = drawn(device, &scene(&points), &frame);
        assert!(cut.facts.windows > 3, "{} windows", cut.facts.windows);
        assert!(same(&cut), "windows show");
        frame.seed = 1;
        assert!(!same(&drawn(device, &scene(&points), &frame)), "the seed does not show");
    });
}

#[test]
fn chunks_draw_one_after_another() {
    let settings = stochastic(DiscShape::Oriented, Falloff::Flat, 6, true);
    let frame = frame(perspective(), [40, 30], Method::Stochastic(settings));
    let points = scene(&soup(9, 280_000, 0.0..0.02, 0.0..0.3, true));
    let (mut whole, mut cut) = (None, None);
    with_device(|device| whole = Some(drawn(device, &points, &frame)));
    with_device_that_binds(Some(2 << 20), |device| {
        let renderer = Renderer::new(device).expect("a renderer");
        assert!(renderer.upload(&points).expect("fits").chunks().count() >= 3);
        drop(renderer);
        cut = Some(drawn(device, &points, &frame));
    });
    if let (Some(whole), Some(cut)) = (whole, cut) {
        assert!(bits(&whole.image) == bits(&cut.image), "chunks show");
    }
}

#[test]
fn coincident_splats_and_nothing_at_all() {
    with_device(|device| {
        let size = [8, 8];
        let point =
            |color, opacity| P { position: at_pixel(4.0, 4.0, 5.0), color, opacity, radius: 2.6, normal: Vec3::ZERO };
        // Twenty at one place, then one that is opaque, and nothing shows behind it.
        let mut points: Vec<P> = (0..20).map(|i| point(Vec3::new(0.05 * i as f32, 0.5, 0.25), 0.3)).collect();
        points.push(point(Vec3::X, 1.0));
        let points = scene(&points);
        let camera = pixel_camera(size);
        let settings = stochastic(DiscShape::Flat, Falloff::Flat, 64, true);
        let frame = frame(camera, size, Method::Stochastic(settings));
        let image = drawn(device, &points, &frame).image;
        let wanted = sampled(&points, &camera, size, &settings, 0);
        assert_eq!(longest(&image), 21);
        assert_eq!(share_off(&image, &wanted, bound(21, 64)), 0.0);
        assert_eq!(image.rgba[4 * 8 + 4][3], 1.0);
        assert_eq!(
            (image.rgba[0], image.depth[0], image.stderr.as_ref().map(|e| e[0])),
            ([0.0; 4], f32::INFINITY, Some([0.0; 3]))
        );
        // Behind the camera: no draw clears anything.
        let mut away = frame;
        away.camera.near = 6.0;
        let nothing = drawn(device, &points, &away).image;
        assert!(nothing.rgba.iter().all(|rgba| *rgba == [0.0; 4]) && nothing.depth.iter().all(|z| z.is_infinite()));
        assert!(nothing.stderr.iter().flatten().all(|e| *e == [0.0; 3]));
    });
}
