//! Image metrics: values worked by hand, and for each a pair of images that must differ.

use pellucid_core::image::LinearImage;
use pellucid_core::metrics::*;

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
    assert_eq!((c.nmse, c.ssim, c.flip), (0.0, 1.0, 0.0));
    for a in [drawn(40, 33, texture), drawn(13, 2, gradient), image(1, &[BLACK]), image(2, &[[-3.0, 2.0, 1e30]; 4])] {
        let c = compare(&a, &a).unwrap();
        assert_eq!((c.rmse, c.nmse, c.ssim, c.flip), (0.0, 0.0, 1.0, 0.0));
    }
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
            // 0.25² over 12 values of 0.5².
            assert!((c.nmse - 1.0 / 48.0).abs() < 1e-15);
            // An even side leaves windows of one pixel, so that three of four are equal, and so are two channels of
            // three.
            assert!((c.ssim - (11.0 + (0.25 + 1e-4) / (0.3125 + 1e-4)) / 12.0).abs() < 1e-14, "{}", c.ssim);
            assert!(c.flip > 0.01, "{}", c.flip);
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
        assert_eq!((c.nmse, c.psnr, c.ssim, c.flip), (f64::INFINITY, f64::NEG_INFINITY, -1.0, 1.0), "{bad}");
    }
}

#[test]
fn images_of_different_sizes_are_not_compared() {
    assert_eq!(compare(&image(2, &[BLACK; 4]), &image(4, &[BLACK; 4])), None);
}

/// A picture in steps of 1/64, exact in float32, from column, row and channel.
fn drawn(width: i32, height: i32, level: impl Fn(i32, i32, i32) -> i32) -> LinearImage {
    let pixel = |i: i32| [0, 1, 2].map(|c| level(i % width, i / width, c) as f32 / 64.0);
    image(width as u32, &(0..width * height).map(pixel).collect::<Vec<_>>())
}

fn texture(x: i32, y: i32, c: i32) -> i32 {
    (7 * x + 13 * y + 29 * c + 3 * (x * y % 11)) % 64
}

fn noisy(x: i32, y: i32, c: i32) -> i32 {
    (texture(x, y, c) + (5 * x + 3 * y) % 7) % 64
}

fn gradient(x: i32, y: i32, c: i32) -> i32 {
    2 * (x + (c + 1) * (y / 2)) / 3
}

fn disc(x: i32, y: i32, c: i32) -> i32 {
    let inside = (x - 20).pow(2) + (y - 15).pow(2) < 50;
    if inside { gradient(x, y, c) / 2 + 9 * c } else { gradient(x, y, c) }
}

/// Single step of one channel of one pixel brighter.
fn faint(x: i32, y: i32, c: i32) -> i32 {
    gradient(x, y, c) + i32::from((x, y, c) == (11, 7, 1))
}

#[test]
fn values_of_other_implementations() {
    // SSIM: scikit-image 0.26.0, structural_similarity(a, b, gaussian_weights=True, sigma=1.5,
    // use_sample_covariance=False, data_range=1.0, channel_axis=-1) in float64, which takes no picture smaller than its
    // window. FLIP: flip-evaluator 1.7, evaluate(a, b, "LDR", inputsRGB=False, applyMagma=False), the mean of its map.
    // Its float32 takes differences of 10⁻⁷ for features where there are none, as on the last picture, and the root of
    // them: 3·10⁻⁴ in the exponent of the colors' difference e, which makes e·ln(1/e)·3·10⁻⁴, at most 10⁻⁴; measured
    // 3·10⁻⁶. NMSE: numpy 2.4.6, in float64.
    let cases: [(LinearImage, LinearImage, f64, Option<f64>, f64); 5] = [
        (
            drawn(24, 17, texture),
            drawn(24, 17, noisy),
            0.114_593_190_175_299,
            Some(0.735_042_984_852_054),
            0.254_188_421,
        ),
        (
            drawn(40, 33, gradient),
            drawn(40, 33, disc),
            0.006_565_238_412_263,
            Some(0.866_116_305_477_480),
            0.063_188_161,
        ),
        (
            drawn(40, 33, gradient),
            drawn(40, 33, faint),
            3.861_677_790_873e-7,
            Some(0.999_944_735_711_049),
            0.000_374_509,
        ),
        (drawn(5, 4, texture), drawn(5, 4, noisy), 0.060_243_088_725_915, None, 0.222_464_443),
        (
            drawn(1, 1, texture),
            drawn(1, 1, |x, y, c| 64 - texture(x, y, c)),
            1.625_683_709_869_203,
            None,
            0.965_869_248,
        ),
    ];
    for (a, b, nmse, ssim, flip) in cases {
        let c = compare(&a, &b).unwrap();
        assert!((c.nmse - nmse).abs() < 1e-14, "{c:?}");
        assert!(ssim.is_none_or(|ssim| (c.ssim - ssim).abs() < 1e-13), "{c:?}");
        assert!((c.flip - flip).abs() < if a.width == 1 { 1e-5 } else { 1e-6 }, "{c:?}");
        let back = compare(&b, &a).unwrap();
        assert_eq!((back.ssim, back.flip), (c.ssim, c.flip), "either may be the reference");
    }
}

#[test]
fn nmse_is_relative_to_the_first_image() {
    let (a, b) = (image(1, &[[0.5, 0.0, 0.0]]), image(1, &[[0.0, 0.0, 0.25]]));
    // (0.5² + 0.25²) over 0.5², and over 0.25².
    assert_eq!((compare(&a, &b).unwrap().nmse, compare(&b, &a).unwrap().nmse), (1.25, 5.0));
    let black = image(1, &[BLACK]);
    assert_eq!(nmse(&a.pixels, &black.pixels), 1.0);
    assert_eq!(nmse(&black.pixels, &a.pixels), f64::INFINITY);
    assert_eq!(nmse(&black.pixels, &black.pixels), 0.0);
}

#[test]
fn windows_larger_than_the_picture_are_cut() {
    // A single pixel has no variance, so that (2xy + C₁) / (x² + y² + C₁) is left; red alone differs.
    let (a, b) = (image(1, &[[0.5; 3]]), image(1, &[[0.25, 0.5, 0.5]]));
    let red = (2.0 * 0.125 + 1e-4) / (0.25 + 0.0625 + 1e-4);
    assert!((ssim(&a, &b) - (red + 2.0) / 3.0).abs() < 1e-15);
    // Weights of one row of three: e^(−1/4.5), 1, e^(−1/4.5), over their sum. x is 0, 0, 1 and y is 0, 1, 0, in gray.
    let (a, b) = (image(3, &[BLACK, BLACK, [1.0; 3]]), image(3, &[BLACK, [1.0; 3], BLACK]));
    let side = (-1.0f64 / 4.5).exp();
    let (x, y) = (side / (1.0 + 2.0 * side), 1.0 / (1.0 + 2.0 * side));
    let expected =
        (2.0 * x * y + 1e-4) * (-2.0 * x * y + 9e-4) / ((x * x + y * y + 1e-4) * (x - x * x + y - y * y + 9e-4));
    assert!((ssim(&a, &b) - expected).abs() < 1e-14, "{}", ssim(&a, &b));
    assert!(expected < -0.3, "opposite structure: {expected}");
}

#[test]
fn flip_takes_what_lies_outside_of_0_to_1_as_its_end() {
    let [gray, white, bright, black, negative] = [0.5, 1.0, 7.0, 0.0, -3.0].map(|v| image(4, &[[v; 3]; 16]));
    assert_eq!((flip(&white, &bright), flip(&black, &negative)), (0.0, 0.0));
    assert_eq!(flip(&gray, &white), flip(&gray, &bright));
    // Without edges or points the color alone counts: black to white is 100 in lightness and nothing else, beyond the
    // knee at 0.4 of green to blue. From CIELAB of these (87.73, −86.18, 83.18; 32.30, 79.19, −107.86), a and b times
    // L/100:
    let greatest = (55.43f64 + (25.58f64 + 75.61).hypot(34.84 + 72.97)).powf(0.7);
    let expected = 0.95 + 0.05 * (100f64.powf(0.7) / greatest - 0.4) / 0.6;
    assert!((flip(&black, &white) - expected).abs() < 1e-4, "{} {expected}", flip(&black, &white));
}

#[test]
fn closer_pictures_measure_closer() {
    let a = drawn(40, 33, texture);
    let mixed = |t: f32| {
        let b = drawn(40, 33, noisy);
        let pixels = a.pixels.iter().zip(&b.pixels).map(|(a, b)| [0, 1, 2].map(|c| a[c] + t * (b[c] - a[c])));
        compare(&a, &image(40, &pixels.collect::<Vec<_>>())).unwrap()
    };
    let steps = [0.0, 1e-4, 1e-2, 0.1, 0.3, 1.0].map(mixed);
    for pair in steps.windows(2) {
        let [near, far] = pair else { unreachable!() };
        assert!(near.rmse < far.rmse && near.nmse < far.nmse && near.psnr > far.psnr, "{pair:?}");
        assert!(near.ssim > far.ssim && near.flip < far.flip && near.max.value < far.max.value, "{pair:?}");
    }
    assert_eq!((steps[0].ssim, steps[0].flip), (1.0, 0.0));
}
