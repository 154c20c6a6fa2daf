//! Transparent discs: exact methods and approximations of them, flat and oriented, linear and encoded.

use pellucid_reference::abuffer::{Fragment, depth_margin, lists, splat};
use pellucid_reference::{abuffer, approximate, peel, sorted};
use pellucid_scene::{DiscShape, Discs, Falloff, Hybrid, Mlab, MomentCount, Moments, Peel, Wavelet};

use super::*;

/// Roundings of a flat disc's depth; an oriented one adds its slope.
fn depth_error(discs: &Discs) -> f64 {
    if discs.shape == DiscShape::Flat { FLAT_DEPTH } else { 4e-5 }
}

/// The reference of an image of discs; pixels are unknown where roundings decide the order of two.
fn image_of(view: View, points: &Points, colors: &[DVec3], method: &Method) -> PictureRange {
    let discs = method.discs().expect("discs");
    let picture = match method {
        Method::ABuffer(_) | Method::LinkedList(_) => abuffer::render(view, points, colors, discs),
        Method::Peel(Peel { layers, .. }) => peel::render(view, points, colors, discs, *layers),
        Method::Sorted(_) => sorted::render(view, points, colors, discs),
        _ => approximate::render(view, points, colors, method).expect("an approximation"),
    };
    let mut ranges = PictureRange::of_picture(&picture, depth_error(discs));
    let lists = lists(view, points, discs);
    open(&mut ranges, |pixel| depth_margin(&lists[pixel..=pixel]) < depth_error(discs));
    ranges
}

/// A frame of discs, and its reference.
fn subject<'a>(points: &'a Points, colors: &'a [DVec3], frame: Frame, slack: f64) -> Subject<'a> {
    let image = move |one: &One| image_of(View::new(one.camera, SIZE), points, colors, &frame.method);
    let name = format!("{:?}, {:?}", frame.method, frame.camera.projection);
    Subject { name, points, frame, image: Box::new(image), slack, counts: true }
}

fn exact(discs: Discs) -> [Method; 3] {
    let settings = Peel { discs, ..Peel::default() };
    [Method::ABuffer(discs), Method::LinkedList(discs), Method::Peel(settings)]
}

/// Every approximation whose reference is known to 3e-5.
fn approximations(discs: Discs) -> [Method; 6] {
    [
        Method::Weighted(discs),
        Method::Average(discs),
        Method::Unsorted(discs),
        Method::Hybrid(Hybrid { discs, k: 3, ..Hybrid::default() }),
        Method::Mlab(Mlab { discs, nodes: 3 }),
        Method::Sorted(discs),
    ]
}

fn clear_discs(seed: u64, camera: &Camera, shape: DiscShape) -> Points {
    clear(&mixed(seed), camera, SIZE, |_, points, i| splat(points, i, shape))
}

/// Both shapes, both falloffs.
const DISCS: [(DiscShape, Falloff); 2] = [(DiscShape::Flat, Falloff::Flat), (DiscShape::Oriented, Falloff::Gaussian)];

fn check(device: &Device, methods: impl Fn(Discs) -> Vec<Method>) {
    for camera in cameras() {
        for (shape, falloff) in DISCS {
            let points = clear_discs(11, &camera, shape);
            let colors = colors(&points);
            for method in methods(Discs { shape, falloff, ..Discs::default() }) {
                // The bound at one sample.
                subject(&points, &colors, frame(camera, SIZE, method), 3e-5).check(device);
            }
        }
    }
}

#[test]
fn exact_discs_are_the_mean_of_their_references() {
    with_device(|device| check(device, |discs| exact(discs).to_vec()));
}

#[test]
fn approximations_are_the_mean_of_their_references() {
    with_device(|device| check(device, |discs| approximations(discs).to_vec()));
}

#[test]
fn encoded_colors_are_decoded_over_the_background_before_they_are_averaged() {
    with_device(|device| {
        let (camera, discs) = (perspective(), Discs::default());
        let points = clear_discs(13, &camera, discs.shape);
        for method in [Method::ABuffer(discs), Method::Weighted(discs), Method::Sorted(discs)] {
            let background = glam::Vec3::new(0.9, 0.3, 0.0);
            let frame = Frame { color: ColorSpace::Encoded, background, ..frame(camera, SIZE, method) };
            let colors = shaded(&points, &frame);
            // Decoding is up to 2.4 / 1.055 times as steep as the encoded values, whose curve rounds by itself.
            let subject = subject(&points, &colors, frame, 2.3 * 1e-4);
            subject.check(device);
            // A mean of encoded values is another picture.
            let mut renderer = Renderer::new(device).expect("a renderer");
            let image = subject.found(&mut renderer, 4);
            let encoded = Frame { color: ColorSpace::Linear, ..frame };
            let plain = Subject { frame: encoded, name: String::new(), image: subject.image, ..subject };
            let mean = shown(&plain.wanted(&places(4)), super::encoded(&frame).as_dvec3());
            assert!(plain.compare_with(&image, &mean).is_err(), "{method:?}");
        }
    });
}

/// A small image, as bounds take the reference once for each fragment.
const FADED: [u32; 2] = [31, 23];

/// The reference of `moments` or `wavelet`, within what float32 may change of it.
fn faded(view: View, points: &Points, colors: &[DVec3], method: &Method) -> PictureRange {
    let discs = method.discs().expect("discs");
    let mut ranges = image_of(view, points, colors, method);
    let off = crate::fading::off(discs);
    for (rgba, list) in ranges.rgba.iter_mut().zip(lists(view, points, discs)) {
        let bound = crate::fading::bound(&list, colors, view.camera, method, |f: &Fragment| off(f));
        *rgba = rgba.map(|range| range.widened(bound));
    }
    ranges
}

#[test]
fn fading_by_moments_and_wavelets_is_the_mean_of_its_references() {
    with_device(|device| {
        let discs = Discs::default();
        let soup = [soup(15, 150, 0.02..0.15, 0.1..0.9, true), soup(16, 4, 0.3..0.8, 0.05..0.4, true)].concat();
        for camera in cameras() {
            let points = clear(&soup, &camera, FADED, |_, points, i| splat(points, i, discs.shape));
            let colors = colors(&points);
            let moments = Method::Moments(Moments { discs, moments: MomentCount::Six, ..Moments::default() });
            for method in [moments, Method::Wavelet(Wavelet { discs, ..Wavelet::default() })] {
                let image = |one: &One| faded(View::new(one.camera, FADED), &points, &colors, &method);
                let frame = frame(camera, FADED, method);
                let name = format!("{method:?}");
                Subject { name, points: &points, frame, image: Box::new(image), slack: 0.0, counts: true }
                    .check(device);
            }
        }
    });
}
