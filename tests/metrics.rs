//! Image metrics: values worked by hand, and for each a pair of images that must differ.

use pellucid::metrics::*;
use pellucid::output::LinearImage;

fn image(width: u32, pixels: &[[f32; 3]]) -> LinearImage {
    LinearImage { width, height: pixels.len() as u32 / width, pixels: pixels.to_vec() }
}

const BLACK: [f32; 3] = [0.0; 3];

#[test]
fn hand_worked_values() {
    // 3 × 2 pixels, two of which differ: by 0.5 in green, by −0.25 in red and 0.25 in blue.
    let a = image(3, &[BLACK, BLACK, [0.5, 0.5, 0.5], BLACK, BLACK, BLACK]);
    let b = image(3, &[BLACK, BLACK, [0.75, 0.5, 0.25], BLACK, [0.0, 0.5, 0.0], BLACK]);
    let c = compare(&a, &b).unwrap();
    // (0.5² + 0.25² + 0.25²) / (6·3) = 0.375 / 18; −20·log10 of the root is −10·log10(0.0208333) = 16.8124.
    assert!((c.rmse - (0.375f64 / 18.0).sqrt()).abs() < 1e-15, "{}", c.rmse);
    assert!((c.psnr - 16.812_412_37).abs() < 1e-6, "{}", c.psnr);
    assert_eq!(c.max, Largest { value: 0.5, x: 1, y: 1 });
    assert_eq!(c.above_1_255, 2.0 / 6.0);
    let picture = difference_picture(&a.pixels, &b.pixels, 10.0);
    assert_eq!((picture[2], picture[4], picture[0]), ([2.5, 0.0, 2.5], [0.0, 5.0, 0.0], BLACK));
}

#[test]
fn equal_images_have_no_difference() {
    let a = image(1, &[[0.1, 0.2, 0.3], [f32::NAN, f32::INFINITY, -1.0]]);
    let c = compare(&a, &a).unwrap();
    assert_eq!((c.rmse, c.psnr, c.max.value, c.above_1_255), (0.0, f64::INFINITY, 0.0, 0.0));
}

#[test]
fn every_metric_sees_every_channel_and_every_pixel() {
    for pixel in 0..4 {
        for channel in 0..3 {
            let a = image(2, &[[0.5; 3]; 4]);
            let mut b = a.clone();
            b.pixels[pixel][channel] = 0.25;
            let c = compare(&a, &b).unwrap();
            assert_eq!(c.rmse, (0.0625f64 / 12.0).sqrt());
            assert!(c.psnr < 100.0);
            assert_eq!(c.max, Largest { value: 0.25, x: pixel as u32 % 2, y: pixel as u32 / 2 });
            assert_eq!(c.above_1_255, 0.25);
        }
    }
}

#[test]
fn the_share_counts_what_is_above_one_step_only() {
    // In units of 1/256, exact in float32, one step of 1/255 lies between 1 and 1.01.
    let a = image(2, &[BLACK, BLACK]);
    let b = image(2, &[[1.0 / 256.0, 0.0, 0.0], [1.01 / 256.0, 0.0, 0.0]]);
    assert_eq!(compare(&a, &b).unwrap().above_1_255, 0.5);
}

#[test]
fn a_value_that_is_not_finite_never_passes_for_close() {
    let a = image(1, &[[0.5; 3]]);
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let c = compare(&a, &image(1, &[[0.5, bad, 0.5]])).unwrap();
        assert_eq!((c.rmse, c.max.value, c.above_1_255), (f64::INFINITY, f64::INFINITY, 1.0), "{bad}");
    }
}

#[test]
fn images_of_different_sizes_are_not_compared() {
    assert_eq!(compare(&image(2, &[BLACK; 4]), &image(4, &[BLACK; 4])), None);
}
