//! Random samples: each image has numbers of its own, those that follow the numbers of the image before it.

use pellucid_core::random::{STRATA_OF_A_CALL, STRATUM, word};
use pellucid_reference::abuffer::{depth_margin, lists, splat};
use pellucid_reference::samples::stderr;
use pellucid_reference::stochastic::render_with;
use pellucid_reference::{WithErrors, abuffer};
use pellucid_scene::{DiscShape, Discs, Stochastic};

use super::*;

/// Means of normally distributed numbers lie beyond with a probability of 1 in 150 000.
const ERRORS: f64 = 4.5;

fn settings(samples: u32, alpha_correction: bool) -> Stochastic {
    Stochastic { samples, alpha_correction, ..Stochastic::default() }
}

/// An image with the numbers that follow those of the images before it.
fn with_numbers(one: &One, points: &Points, colors: &[DVec3], settings: &Stochastic, seed: u64) -> WithErrors {
    let ids = points.ids(&points.anchor(), 0..points.len());
    let calls = settings.samples.div_ceil(STRATUM * STRATA_OF_A_CALL);
    let before = one.number * calls * STRATA_OF_A_CALL;
    render_with(View::new(one.camera, SIZE), points, colors, settings, |pixel, index, p| {
        word(seed, pixel, ids[index as usize], before + p)
    })
}

#[test]
fn pictures_are_the_mean_of_references_with_masks_of_their_own() {
    with_device(|device| {
        let soup = [soup(31, 300, 0.0..0.1, 0.0..1.0, true), soup(32, 10, 0.2..0.8, 0.05..1.0, true)].concat();
        for (camera, seed) in [(perspective(), 5), (orthographic(), 1 << 40)] {
            let points = clear(&soup, &camera, SIZE, |_, points, i| splat(points, i, DiscShape::Flat));
            let colors = colors(&points);
            // One word of a call is left over by 4 and by 20 samples.
            for (samples, alpha_correction) in [(4, true), (8, false), (20, true)] {
                let settings = settings(samples, alpha_correction);
                let frame = Frame { seed, ..frame(camera, SIZE, Method::Stochastic(settings)) };
                let image = |one: &One| {
                    let (picture, _) = with_numbers(one, &points, &colors, &settings, seed);
                    let mut ranges = of_picture(&picture);
                    let lists = lists(View::new(one.camera, SIZE), &points, &settings.discs);
                    open(&mut ranges, |pixel| depth_margin(&lists[pixel..=pixel]) < FLAT_DEPTH);
                    ranges
                };
                let name = format!("{settings:?}");
                // A rounding for each fragment, as at one sample; lists have fewer than 60.
                let slack = 70.0 * 2.0 * ROUNDING;
                let subject = Subject { name, points: &points, frame, image: Box::new(image), slack, counts: true };
                subject.check(device);
                // The same numbers in every image make another picture.
                let same = |camera: &Camera| {
                    let one = One { camera, number: 0 };
                    of_picture(&with_numbers(&one, &points, &colors, &settings, seed).0)
                };
                let images: Vec<PictureRange> = reference::samples::cameras(&camera, 4).iter().map(same).collect();
                let found = subject.found(&mut Renderer::new(device).expect("a renderer"), 4);
                assert!(subject.compare_with(&found, &without_depths(mean(&images))).is_err());
            }
        }
    });
}

#[test]
fn standard_errors_are_those_of_independent_images() {
    with_device(|device| {
        let (camera, seed, settings) = (perspective(), 9, settings(16, true));
        let points = clear(&mixed(33), &camera, SIZE, |_, points, i| splat(points, i, DiscShape::Flat));
        let colors = colors(&points);
        let mut renderer = Renderer::new(device).expect("a renderer");
        let mut cloud = renderer.upload(&points).expect("fits");
        for count in COUNTS {
            let frame = Frame { seed, ..sampled(camera, Method::Stochastic(settings), count) };
            let image = renderer.render(&mut cloud, &frame).expect("renders").image;
            let cameras = reference::samples::cameras(&camera, count);
            let errors = |(camera, number): (&Camera, u32)| {
                with_numbers(&One { camera, number }, &points, &colors, &settings, seed).1
            };
            let wanted = stderr(&cameras.iter().zip(0..).map(errors).collect::<Vec<_>>());
            let is_clear = |pixel: usize| {
                let margin = |camera: &Camera| {
                    depth_margin(&abuffer::lists_at(View::new(camera, SIZE), &points, &settings.discs, &[pixel]))
                };
                cameras.iter().all(|camera| margin(camera) > FLAT_DEPTH)
            };
            let found = image.stderr.expect("asked for");
            let close = |pixel: usize| {
                let pairs = found[pixel].iter().zip(wanted[pixel].to_array());
                // As at one sample.
                pairs.into_iter().all(|(found, wanted)| (f64::from(*found) - wanted).abs() <= 2e-4 * (wanted + 1.0))
            };
            let off: Vec<usize> = (0..found.len()).filter(|pixel| !close(*pixel)).collect();
            assert!(off.iter().all(|pixel| !is_clear(*pixel)), "{count}: {off:?}");
            assert!(off.len() * 100 < found.len(), "{count}: {} pixels", off.len());
            // The error of one image is √N times as large: the comparison notices that.
            let alone: Vec<f64> = wanted.iter().map(|error| error.x * f64::from(count).sqrt()).collect();
            let largest = alone.iter().copied().fold(0.0, f64::max);
            assert!(largest * (1.0 - f64::from(count).sqrt().recip()) > 1e-2, "{largest}");
        }
    });
}

/// A point of opacity `alpha` on the middle of each pixel, before nothing: in each image it is in the same pixel.
fn grid(size: [u32; 2], alpha: f32) -> Points {
    let at = (0..size[0] * size[1]).map(|i| [i % size[0], i / size[0]].map(|at| f64::from(at) + 0.5));
    scene_of(at.map(|[x, y]| at_pixel(x, y, 2.0)).collect(), alpha)
}

fn scene_of(positions: Vec<DVec3>, alpha: f32) -> Points {
    pellucid_scene::prepare::order::canonical(white(positions, alpha))
}

fn moments(values: &[f64]) -> (f64, f64) {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    (mean, values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (values.len() as f64 - 1.0))
}

/// The pixels' correlation of two images.
fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let ((of_a, var_a), (of_b, var_b)) = (moments(a), moments(b));
    let products: f64 = a.iter().zip(b).map(|(a, b)| (a - of_a) * (b - of_b)).sum();
    products / (a.len() as f64 - 1.0) / (var_a * var_b).sqrt()
}

#[test]
fn images_have_independent_numbers_so_that_the_variance_falls_as_their_number_grows() {
    with_device(|device| {
        // 4α covered samples of 4, rounded at random: of α = 3/8 one or two, each with probability ½, seen in white
        // before nothing; without alpha correction the color is α (the fragment itself) in the samples of nothing
        // nearer. Two layers of one color make its variance visible: the second is seen where the first leaves room.
        let size = [64, 64];
        let pixels = f64::from(size[0] * size[1]);
        let [front, back] = [0.375f32, 0.8];
        let mut points = grid(size, front);
        points.append(Points { colors: vec![glam::Vec3::ZERO; 4096], ..grid(size, back) });
        let points = {
            let mut points = points;
            for position in &mut points.positions[4096..] {
                position.z -= 1.0;
            }
            pellucid_scene::prepare::order::canonical(points)
        };
        let method = Method::Stochastic(settings(4, false));
        let mut renderer = Renderer::new(device).expect("a renderer");
        let mut cloud = renderer.upload(&points).expect("fits");
        let mut alphas = |frame: &Frame| -> Vec<f64> {
            let image = renderer.render(&mut cloud, frame).expect("renders").image;
            image.rgba.iter().map(|rgba| f64::from(rgba[3])).collect()
        };
        let frame = Frame { seed: 77, samples: 16, ..frame(pixel_camera(size), size, method) };
        let images: Vec<Vec<f64>> = (0..16).map(|number| alphas(&frame.image(number))).collect();
        // A = α₁ + α₂ (1 − c/4), c = 1 or 2 samples that the front one covers: variance (α₂/4)²/4.
        let variance = (f64::from(back) / 4.0).powi(2) / 4.0;
        // The variance of a sample variance of two values is small: 2 σ⁴/n is above it.
        let bound = ERRORS * (2.0 / pixels).sqrt();
        for (number, image) in images.iter().enumerate() {
            let found = moments(image).1;
            assert!((found / variance - 1.0).abs() < bound, "image {number}: {found}, not {variance}");
            for other in &images[..number] {
                let found = correlation(image, other);
                assert!(found.abs() < ERRORS / pixels.sqrt(), "{number}: {found}");
            }
        }
        for count in COUNTS {
            let (mean, found) = moments(&alphas(&Frame { samples: count, ..frame }));
            let wanted = variance / f64::from(count);
            assert!((found / wanted - 1.0).abs() < bound, "{count}: {found}, not {wanted}");
            // The expected A: 3/8 + 0.8 · (1 − 3/8).
            let exact = f64::from(front) + f64::from(back) * 0.625;
            assert!((mean - exact).abs() < ERRORS * (wanted / pixels).sqrt(), "{count}: {mean}, not {exact}");
        }
        // The same numbers in each image would be noticed.
        assert!((correlation(&images[0], &images[0]) - 1.0).abs() < 1e-9 && 1.0 > ERRORS / pixels.sqrt());
    });
}

#[test]
fn the_mean_over_pixels_is_that_of_the_exact_picture() {
    with_device(|device| {
        let (camera, discs) = (perspective(), Discs::default());
        let points = clear(&mixed(35), &camera, SIZE, |_, points, i| splat(points, i, DiscShape::Flat));
        let colors = colors(&points);
        let settings = settings(16, false);
        let mut renderer = Renderer::new(device).expect("a renderer");
        let mut cloud = renderer.upload(&points).expect("fits");
        for count in COUNTS {
            let frame = Frame { seed: 4, ..sampled(camera, Method::Stochastic(settings), count) };
            let image = renderer.render(&mut cloud, &frame).expect("renders").image;
            let exact =
                |camera: Camera| of_picture(&abuffer::render(View::new(&camera, SIZE), &points, &colors, &discs));
            let wanted = mean(&reference::samples::cameras(&camera, count).into_iter().map(exact).collect::<Vec<_>>());
            let errors = image.stderr.expect("asked for");
            let apart: f64 = image.rgba.iter().zip(&wanted.rgba).map(|(a, b)| f64::from(a[1]) - b[1].low).sum::<f64>();
            let error = errors.iter().map(|error| f64::from(error[1]).powi(2)).sum::<f64>().sqrt();
            assert!(apart.abs() < ERRORS * error, "{count}: {apart}, standard error {error}");
        }
    });
}
