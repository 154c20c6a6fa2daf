//! Multi-sample stochastic transparency: no bias, exact A, and random numbers that have nothing to do with one another.

use glam::{DVec3, Vec3};

use super::stage::{Dot, HALF_ULP, apart, at, cloud, composed, frame, pixels};
use super::{Case, Finding, Stage, Trouble, each};
use pellucid_engine::methods::Frame;
use pellucid_engine::random::word;
use pellucid_engine::reference::abuffer::Fragment;
use pellucid_engine::reference::stochastic::{estimate, strata};
use pellucid_engine::scene::{Method, Stochastic};

type Found = Result<Finding, Trouble>;

const SIZE: [u32; 2] = [32, 32];
const PIXELS: f64 = 1024.0;
/// Standard errors that are allowed: 1 in 150 000 of normally distributed means lies beyond.
const ERRORS: f64 = 4.5;

pub(super) fn cases() -> Vec<Case> {
    let plain = [Method::Stochastic(Stochastic { samples: 4, alpha_correction: false, ..Stochastic::default() })];
    let many = [Method::Stochastic(Stochastic { samples: 64, alpha_correction: false, ..Stochastic::default() })];
    let corrected = [Method::Stochastic(Stochastic { samples: 4, ..Stochastic::default() })];
    [
        each(
            &plain,
            "unbiased",
            "the mean of 8 seeds and 1024 pixels, in 4.5 standard errors, against float64",
            unbiased,
        ),
        each(&corrected, "exact-alpha", "A with alpha correction against float64", exact_alpha),
        each(&plain, "rounding", "4 samples of opacity 0.1 are 0.4 in the mean", rounding),
        each(&plain, "pixels", "correlation of pixels with their neighbors, in 4.5 standard errors", neighbors),
        each(&plain, "seeds", "correlation of images of seeds 0 to 8, 2^32 and 2^32 + 1", seeds),
        each(&many, "samples", "the variance of 64 samples is 1/16 of that of 4", samples),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// Layers over all pixels.
fn layers(of: &[(Vec3, f32)]) -> Vec<Dot> {
    let layer = |(i, (color, opacity)): (usize, &(Vec3, f32))| Dot {
        position: at(16, 16, 1.0 + i as f64),
        color: *color,
        opacity: *opacity,
        radius: 100.0,
        ..Dot::default()
    };
    of.iter().enumerate().map(layer).collect()
}

/// An image for each seed.
fn images(stage: &mut Stage, dots: &[Dot], method: Method, seeds: &[u64]) -> Result<Vec<Vec<[f32; 4]>>, Trouble> {
    let mut cloud = stage.renderer.upload(&cloud(dots))?;
    let mut found = Vec::new();
    for seed in seeds {
        let frame = Frame { seed: *seed, ..frame(pixels(SIZE), SIZE, method) };
        found.push(stage.renderer.render(&mut cloud, &frame)?.image.rgba);
    }
    Ok(found)
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

fn variance(values: &[f64]) -> f64 {
    let mean = mean(values);
    values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (values.len() as f64 - 1.0)
}

/// Pearson's; infinite where one of them does not vary, which no correlation of random numbers is.
fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let (of_a, of_b) = (mean(a), mean(b));
    let covariance = a.iter().zip(b).map(|(a, b)| (a - of_a) * (b - of_b)).sum::<f64>() / (a.len() as f64 - 1.0);
    let found = covariance / (variance(a) * variance(b)).sqrt();
    if found.is_nan() { f64::INFINITY } else { found.abs() }
}

const LAYERS: [(Vec3, f32); 5] =
    [(Vec3::X, 0.3), (Vec3::Y, 0.45), (Vec3::Z, 0.2), (Vec3::X, 0.7), (Vec3::new(0.0, 1.0, 1.0), 0.6)];

/// One pixel of [`LAYERS`] on the host, with the random words of another rule.
fn on_host(samples: u32, words: impl Fn(u32, u32) -> u32) -> [f32; 4] {
    let fragment = |i: usize| Fragment { z: 1.0 + i as f64, index: i as u32, alpha: LAYERS[i].1.into() };
    let list: Vec<Fragment> = (0..LAYERS.len()).map(fragment).collect();
    let colors: Vec<DVec3> = LAYERS.iter().map(|(color, _)| color.as_dvec3()).collect();
    let found = estimate(&strata(&list, &colors, samples, words), None);
    found.color.extend(found.alpha).to_array().map(|c| c as f32)
}

fn unbiased(stage: &mut Stage, method: Method) -> Found {
    let dots = layers(&LAYERS);
    let wanted = composed(&dots);
    let seeds: Vec<u64> = (0..8).collect();
    let all = images(stage, &dots, method, &seeds)?.concat();
    let of = |channel: usize| -> Vec<f64> { all.iter().map(|pixel| f64::from(pixel[channel])).collect() };
    // Each channel in units of its own standard error.
    let error = |channel: usize| {
        let values = of(channel);
        (mean(&values) - wanted[channel]).abs() / (variance(&values) / values.len() as f64).sqrt()
    };
    // Masks that don't know the splat let every fragment of a pixel cover the same samples.
    let correlated: Vec<f64> =
        (0..8192).map(|i| f64::from(on_host(4, |_, p| word(0, [i % 64, i / 64], 0, p))[2])).collect();
    let naive = (mean(&correlated) - wanted[2]).abs() / (variance(&of(2)) / all.len() as f64).sqrt();
    Ok(Finding { error: (0..4).map(error).fold(0.0, f64::max), bound: ERRORS, naive })
}

fn exact_alpha(stage: &mut Stage, method: Method) -> Found {
    let dots = layers(&LAYERS);
    let wanted = composed(&dots)[3];
    let image = &images(stage, &dots, method, &[1])?[0];
    let error = image.iter().map(|pixel| apart(&pixel[3..], &[wanted])).fold(0.0, f64::max);
    let sampled = on_host(4, |index, p| word(1, [0, 0], index, p))[3];
    Ok(Finding { error, bound: 20.0 * HALF_ULP, naive: apart(&[sampled], &[wanted]) })
}

/// What shines through a black layer of an opacity, before white: one number for each pixel.
fn through(stage: &mut Stage, method: Method, opacity: f32, seeds: &[u64]) -> Result<Vec<Vec<f64>>, Trouble> {
    let found = images(stage, &layers(&[(Vec3::ZERO, opacity), (Vec3::ONE, 1.0)]), method, seeds)?;
    Ok(found.iter().map(|image| image.iter().map(|pixel| f64::from(pixel[0])).collect()).collect())
}

fn rounding(stage: &mut Stage, method: Method) -> Found {
    let found = mean(&through(stage, method, 0.1, &[0])?[0]);
    // One sample of four with probability 0.4, none else.
    let error = (0.4f64 * 0.6 / 16.0 / PIXELS).sqrt();
    // Rounded to the nearest number, none ever.
    Ok(Finding { error: (found - 0.9).abs(), bound: ERRORS * error, naive: 0.1 })
}

fn neighbors(stage: &mut Stage, method: Method) -> Found {
    // One or two samples of four, each as often.
    let image = &through(stage, method, 0.375, &[0])?[0];
    let shifted = |by: [usize; 2]| {
        let inside = |i: &usize| i % 32 + by[0] < 32 && i / 32 + by[1] < 32;
        let here: Vec<usize> = (0..1024).filter(inside).collect();
        let of = |offset: usize| -> Vec<f64> { here.iter().map(|i| image[i + offset]).collect() };
        correlation(&of(0), &of(by[1] * 32 + by[0])) * (here.len() as f64).sqrt()
    };
    let error = [[1, 0], [0, 1], [1, 1], [2, 0], [0, 2], [16, 0], [0, 16]].map(shifted).into_iter().fold(0.0, f64::max);
    // The same mask for all pixels.
    Ok(Finding { error, bound: ERRORS, naive: PIXELS.sqrt() })
}

fn seeds(stage: &mut Stage, method: Method) -> Found {
    let seeds = [0, 1, 2, 3, 4, 5, 6, 7, 8, 1 << 32, (1 << 32) + 1];
    let images = through(stage, method, 0.375, &seeds)?;
    let pairs = (0..images.len()).flat_map(|a| (a + 1..seeds.len()).map(move |b| (a, b)));
    let error = pairs.map(|(a, b)| correlation(&images[a], &images[b])).fold(0.0, f64::max) * PIXELS.sqrt();
    // Seeds of which only 32 bits count.
    Ok(Finding { error, bound: ERRORS, naive: PIXELS.sqrt() })
}

fn samples(stage: &mut Stage, method: Method) -> Found {
    let found = variance(&through(stage, method, 0.375, &[0])?[0]);
    // A stratum has one sample or two of four; 16 of them.
    let wanted = 0.25 / 16.0 / 16.0;
    // The variance of a sample variance: 2 and the excess kurtosis, -2 / 16, over n.
    let bound = ERRORS * ((2.0 - 0.125) / PIXELS).sqrt();
    // The same word for all strata.
    Ok(Finding { error: (found / wanted - 1.0).abs(), bound, naive: 15.0 })
}
