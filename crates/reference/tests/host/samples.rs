//! Samples of a pixel's area by hand.

use glam::DVec2;
use pellucid_reference::range::{PictureRange, Range};
use pellucid_reference::samples::{cameras, mean, places, radical_inverse, shown, stderr};

use super::*;

/// A picture of one pixel: red and A, its depth, its count.
fn pixel(red: f64, alpha: f64, depth: f64, count: u32) -> PictureRange {
    let picture = ReferencePicture {
        width: 1,
        height: 1,
        rgba: vec![[red, 0.0, 0.0, alpha]],
        depth: vec![depth],
        counts: vec![count],
    };
    PictureRange::of_picture(&picture, 0.0)
}

#[test]
fn samples_lie_where_digits_mirrored_at_the_point_say() {
    assert_eq!([0, 1, 2, 3, 4, 5, 6, 7].map(radical_inverse), [0.0, 0.5, 0.25, 0.75, 0.125, 0.625, 0.375, 0.875]);
    assert_eq!(places(1), [DVec2::splat(0.5)]);
    let eighths = [[1, 1], [3, 5], [5, 3], [7, 7]].map(|place: [u32; 2]| DVec2::from(place.map(f64::from)) / 8.0);
    assert_eq!(places(4), eighths);
}

#[test]
fn a_position_at_a_sample_comes_to_the_center_of_its_pixel() {
    for camera in [orthographic(), perspective()] {
        for (place, moved) in places(16).into_iter().zip(cameras(&camera, 16)) {
            // Pixel (6, 2), at depth 4; the middle of the image is at (4.5, 4.5).
            let at = DVec2::new(6.0, 2.0) + place - 4.5;
            let position = DVec3::new(at.x, -at.y, 0.0) / camera.pixels_per_unit(4.0, SIZE[1]) - 4.0 * DVec3::Z;
            let (found, depth) = moved.project(position, SIZE);
            assert!((found - DVec2::new(6.5, 2.5)).length() < ROUNDING, "{found} of {place}");
            assert_eq!(depth, 4.0);
        }
    }
}

#[test]
fn colors_and_counts_are_means_and_depths_those_of_the_picture_after_half_of_them() {
    let pictures = [(0.0, 0.0, f64::INFINITY, 0), (0.5, 1.0, 3.0, 7), (0.25, 0.5, 2.0, 3), (0.25, 0.5, 4.0, 1)];
    let found = mean(&pictures.map(|(red, alpha, depth, count)| pixel(red, alpha, depth, count)));
    let only = [0.25, 0.0, 0.0, 0.5].map(Range::only);
    assert_eq!((found.rgba[0], found.depth[0], found.counts[0]), (only, Range::only(2.0), Range::only(2.75)));
    let two = mean(&[pixel(0.0, 0.0, 5.0, 1), pixel(1.0, 1.0, f64::INFINITY, 0)]);
    assert_eq!((two.rgba[0][0], two.depth[0]), (Range::only(0.5), Range::only(f64::INFINITY)));
}

#[test]
fn encoded_values_are_decoded_over_the_background() {
    // Half of 0.5 over half of an encoded background: 0.25 + 0.5 · 0.8 = 0.65, ((0.65 + 0.055) / 1.055)^2.4 of light.
    let found = shown(&pixel(0.25, 0.5, 1.0, 1), DVec3::new(0.8, 0.0, 0.04));
    let light = (0.705f64 / 1.055).powf(2.4);
    assert_close(found.rgba[0][0].low, light, ROUNDING);
    assert_close(found.rgba[0][0].high, light, ROUNDING);
    assert_eq!((found.rgba[0][1], found.rgba[0][3]), (Range::only(0.0), Range::only(0.5)));
    // On the straight part of the curve.
    assert_close(found.rgba[0][2].low, 0.02 / 12.92, ROUNDING);
}

#[test]
fn errors_of_means_add_as_squares() {
    let of = |red: f64| vec![DVec3::new(red, 1.0, f64::INFINITY)];
    assert_eq!(stderr(&[of(3.0), of(4.0)]), [DVec3::new(2.5, 2f64.sqrt() / 2.0, f64::INFINITY)]);
}
