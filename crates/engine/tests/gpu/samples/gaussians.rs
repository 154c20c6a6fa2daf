//! Gaussians: projected, along rays, and as ellipsoids.

use pellucid_reference::abuffer;
use pellucid_scene::{Discs, GaussianSettings, Kernel, Order};
use pellucid_testing::gaussians::Soup;

use super::*;

/// The frame of one of the images.
fn of_one(frame: &Frame, one: &One) -> Frame {
    Frame { camera: *one.camera, ..*frame }
}

fn frame_of(camera: Camera, color: ColorSpace, discs: Discs) -> Frame {
    Frame { color, background: glam::Vec3::new(0.1, 0.6, 0.9), ..frame(camera, SIZE, Method::ABuffer(discs)) }
}

/// The reference within the bounds of each pixel; unknown where roundings decide coverage or order.
fn image_of(points: &Points, frame: &Frame, discs: &Discs) -> PictureRange {
    let colors = shaded(points, frame);
    let picture = abuffer::render(View::new(&frame.camera, frame.size), points, &colors, discs);
    let bounds = crate::gaussians::clear_pixels(points, frame, &discs.gaussians, &colors);
    // Depths along rays as at one sample.
    let mut ranges = PictureRange::of_picture(&picture, 1e-3);
    for (rgba, bound) in ranges.rgba.iter_mut().zip(&bounds) {
        *rgba = rgba.map(|range| range.widened(bound.unwrap_or(0.0)));
    }
    open(&mut ranges, |pixel| bounds[pixel].is_none());
    ranges
}

#[test]
fn gaussians_are_the_mean_of_their_references() {
    with_device(|device| {
        let points = Soup { seed: 21, count: 60, degree: 2, extents: 0.02..0.2, ..Soup::default() }.points();
        // The third one has Gaussians far beyond the border, where the projection's slope is clamped.
        let [near, parallel, wide, _] = crate::gaussians::cameras();
        let cases = [
            (near, Kernel::Ewa, Order::Pixel, ColorSpace::Linear),
            (wide, Kernel::Ewa, Order::Center, ColorSpace::Encoded),
            (parallel, Kernel::Ray, Order::Pixel, ColorSpace::Encoded),
            (near, Kernel::Ray, Order::Distance, ColorSpace::Linear),
        ];
        for (camera, kernel, order, color) in cases {
            let gaussians = GaussianSettings { kernel, order: Some(order), ..GaussianSettings::default() };
            let discs = Discs { gaussians, ..Discs::default() };
            let frame = frame_of(camera, color, discs);
            let image = |one: &One| image_of(&points, &of_one(&frame, one), &discs);
            let name = format!("{kernel:?} {order:?} {color:?}");
            // Bounds are those of each pixel; decoding may be 2.3 times as steep as the curve's own rounding.
            let slack = if color == ColorSpace::Encoded { 4.0 * ROUNDING } else { 0.0 };
            Subject { name, points: &points, frame, image: Box::new(image), slack, counts: false }.check(device);
        }
    });
}

/// The reference of ellipsoids within what roundings may leave.
fn ellipsoids(points: &Points, frame: &Frame, discs: &Discs) -> PictureRange {
    let (picture, brightest) = crate::ellipsoids::wanted(points, frame, discs);
    let allowed = crate::ellipsoids::allowed(points, frame, discs, brightest);
    let mut ranges = PictureRange::of_picture(&picture, 0.0);
    for ((rgba, depth), allowed) in ranges.rgba.iter_mut().zip(&mut ranges.depth).zip(&allowed) {
        *rgba = rgba.map(|range| range.widened(allowed.color));
        rgba[3] = allowed.alpha.widened(0.01 * allowed.color.min(1e-4));
        let nothing = allowed.alpha.low < 1e-6;
        let high = if nothing { f64::INFINITY } else { allowed.depth.high * (1.0 + 1e-6) };
        *depth = Range { low: allowed.depth.low * (1.0 - 1e-6), high };
    }
    ranges
}

#[test]
fn ellipsoids_are_the_mean_of_their_references() {
    with_device(|device| {
        let points = Soup { seed: 23, count: 60, degree: 1, extents: 0.1..0.3, ..Soup::default() }.points();
        let discs = crate::ellipsoids::settings(0.9);
        for (camera, color) in [(perspective(), ColorSpace::Linear), (orthographic(), ColorSpace::Encoded)] {
            let frame = frame_of(camera, color, discs);
            let image = |one: &One| ellipsoids(&points, &of_one(&frame, one), &discs);
            let name = format!("ellipsoids, {color:?}");
            // As at one sample.
            let subject = Subject { name, points: &points, frame, image: Box::new(image), slack: 2e-6, counts: false };
            subject.check(device);
        }
    });
}
