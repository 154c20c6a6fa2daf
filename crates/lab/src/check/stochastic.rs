//! Multi-sample stochastic transparency: no bias, exact A, and random numbers that have nothing to do with one another.

use super::prelude::*;
use pellucid_core::random::word;
use pellucid_reference::stochastic::{estimate, strata};
use pellucid_scene::Stochastic;

const SIZE: [u32; 2] = [32, 32];
const PIXELS: f64 = 1024.0;
/// The allowed number of standard errors: 1 in 150 000 of normally distributed means lies beyond.
const ERRORS: f64 = 4.5;

pub(super) fn cases() -> Vec<Case> {
    let plain = [Method::Stochastic(Stochastic { samples: 4, alpha_correction: false, ..Stochastic::default() })];
    let many = [Method::Stochastic(Stochastic { samples: 64, alpha_correction: false, ..Stochastic::default() })];
    let corrected = [Method::Stochastic(Stochastic { samples: 4, ..Stochastic::default() })];
    joined([
        each(&plain, "unbiased", unbiased)
            .about("the mean of 8 seeds and 1024 pixels, in 4.5 standard errors, against float64"),
        each(&corrected, "exact-alpha", exact_alpha).about("A with alpha correction against float64"),
        each(&plain, "rounding", rounding).about("4 samples of opacity 0.1 are 0.4 in the mean"),
        each(&plain, "pixels", neighbors).about("correlation of pixels with their neighbors, in 4.5 standard errors"),
        each(&plain, "seeds", seeds).about("correlation of images of seeds 0 to 8, 2^32 and 2^32 + 1"),
        each(&many, "samples", samples).about("the variance of 64 samples is 1/16 of that of 4"),
    ])
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
fn images(stage: &mut CaseRenderer, dots: &[Dot], method: Method, seeds: &[u64]) -> Result<Vec<Vec<[f32; 4]>>> {
    let mut cloud = stage.renderer.upload(&cloud(dots))?;
    let mut found = Vec::new();
    for seed in seeds {
        let frame = Frame { seed: *seed, ..Frame::new(pixels(SIZE), SIZE, method) };
        found.push(stage.renderer.render(&mut cloud, &frame)?.image.rgba);
    }
    Ok(found)
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

/// Computes a pixel of layers on the host, with another rule for the random words of a layer and a stratum.
fn on_host(of: &[(Vec3, f32)], samples: u32, words: impl Fn(u32, u32) -> u32) -> [f32; 4] {
    let (list, colors) = fragments(&layers(of));
    let found = estimate(&strata(&list, &colors, samples, words), None);
    found.color.extend(found.alpha).to_array().map(|c| c as f32)
}

fn unbiased(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    let dots = layers(&LAYERS);
    let wanted = composed(&dots);
    let seeds: Vec<u64> = (0..8).collect();
    let all = images(stage, &dots, method, &seeds)?.concat();
    let values_of = |channel: usize| -> Vec<f64> { all.iter().map(|pixel| f64::from(pixel[channel])).collect() };
    // Each channel in units of its own standard error.
    let off = |values: &[f64], channel: usize| {
        let parts = LAYERS.map(|(color, alpha)| (alpha.into(), f64::from(color.extend(1.0)[channel])));
        (mean(values) - wanted[channel]).abs() / (known_variance(&parts) / values.len() as f64).sqrt()
    };
    let error = |channel: usize| off(&values_of(channel), channel);
    // Masks that don't know the splat let every fragment of a pixel cover the same samples.
    let correlated: Vec<f64> =
        (0..8192).map(|i| f64::from(on_host(&LAYERS, 4, |_, p| word(0, [i % 64, i / 64], 0, p))[2])).collect();
    let naive = off(&correlated, 2);
    Ok(Finding::new((0..4).map(error).fold(0.0, f64::max), ERRORS, naive))
}

fn exact_alpha(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    let dots = layers(&LAYERS);
    let wanted = composed(&dots)[3];
    let image = &images(stage, &dots, method, &[1])?[0];
    let error = image.iter().map(|pixel| apart(&pixel[3..], &[wanted])).fold(0.0, f64::max);
    let sampled = on_host(&LAYERS, 4, |index, p| word(1, [0, 0], index, p))[3];
    Ok(Finding::new(error, 20.0 * HALF_ULP, apart(&[sampled], &[wanted])))
}

/// Each mask that a fragment of opacity α may have for four samples, and its probability: 4α samples, rounded at
/// random, of all rotations alike; two of them are neighbors with probability 11/16.
fn masks(alpha: f64) -> Vec<(u32, f64)> {
    let (fewer, part) = ((4.0 * alpha).floor() as u32, (4.0 * alpha).fract());
    let masks_of = |count: u32| -> Vec<(u32, f64)> {
        let turned = |base: u32, share: f64| (0..4).map(move |by| ((base << by | base >> (4 - by)) & 15, share / 4.0));
        match count {
            0 => vec![(0, 1.0)],
            1 => turned(0b0001, 1.0).collect(),
            2 => turned(0b0011, 11.0 / 16.0).chain(turned(0b0101, 5.0 / 16.0)).collect(),
            3 => turned(0b0111, 1.0).collect(),
            _ => vec![(0b1111, 1.0)],
        }
    };
    let weighted = |count, weight: f64| masks_of(count).into_iter().map(move |(mask, share)| (mask, weight * share));
    weighted(fewer, 1.0 - part).chain(weighted(fewer + 1, part)).filter(|(_, share)| *share > 0.0).collect()
}

/// The variance of a pixel of four samples, whose layers have these opacities and values, from near to far: each is
/// worth α times its value times the share of samples that hold nothing nearer. By the probabilities of all masks, not
/// from any image.
fn known_variance(layers: &[(f64, f64)]) -> f64 {
    // First and second moment of what the layers from some layer on are worth, by the samples that are still free.
    let mut moments = [[0.0, 0.0]; 16];
    for (alpha, value) in layers.iter().rev() {
        moments = std::array::from_fn(|free| {
            let own = alpha * value * f64::from((free as u32).count_ones()) / 4.0;
            let behind = masks(*alpha).into_iter().map(|(mask, share)| (moments[free & !(mask as usize)], share));
            let [first, second] = behind.fold([0.0, 0.0], |[a, b], ([m, q], share)| [a + share * m, b + share * q]);
            [own + first, own * own + 2.0 * own * first + second]
        });
    }
    let [mean, square] = moments[15];
    square - mean * mean
}

/// The light that passes a black layer of an opacity, in front of white: one number for each pixel.
fn through(stage: &mut CaseRenderer, method: Method, opacity: f32, seeds: &[u64]) -> Result<Vec<Vec<f64>>> {
    let found = images(stage, &layers(&[(Vec3::ZERO, opacity), (Vec3::ONE, 1.0)]), method, seeds)?;
    Ok(found.iter().map(|image| image.iter().map(|pixel| f64::from(pixel[0])).collect()).collect())
}

fn rounding(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    let found = mean(&through(stage, method, 0.1, &[0])?[0]);
    // One sample of four with probability 0.4, no others.
    let error = (0.4f64 * 0.6 / 16.0 / PIXELS).sqrt();
    // Rounded to the nearest number, it is always 0.
    let naive = 1.0 - (4f32 * 0.1).round() / 4.0;
    Ok(Finding::new((found - 0.9).abs(), ERRORS * error, apart(&[naive], &[0.9])))
}

/// An image of [`through`] an opacity on the host, with the random words of another rule: for a pixel and a layer; of a
/// stratum, too.
fn through_on_host(samples: u32, words: impl Fn([u32; 2], u32, u32) -> u32) -> Vec<f64> {
    let layers = [(Vec3::ZERO, OPACITY), (Vec3::ONE, 1.0)];
    let pixel = |i: u32| f64::from(on_host(&layers, samples, |index, p| words([i % 32, i / 32], index, p))[0]);
    (0..1024).map(pixel).collect()
}

/// Opacity that covers one or two samples of four, equally often.
const OPACITY: f32 = 0.375;

/// The largest correlation of an image with itself some pixels away, in standard errors.
fn largest_correlation(image: &[f64]) -> f64 {
    let shifted = |by: [usize; 2]| {
        let inside = |i: &usize| i % 32 + by[0] < 32 && i / 32 + by[1] < 32;
        let here: Vec<usize> = (0..1024).filter(inside).collect();
        let at_offset = |offset: usize| -> Vec<f64> { here.iter().map(|i| image[i + offset]).collect() };
        correlation(&at_offset(0), &at_offset(by[1] * 32 + by[0])) * (here.len() as f64).sqrt()
    };
    [[1, 0], [0, 1], [1, 1], [2, 0], [0, 2], [16, 0], [0, 16]].map(shifted).into_iter().fold(0.0, f64::max)
}

fn neighbors(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    let error = largest_correlation(&through(stage, method, OPACITY, &[0])?[0]);
    // A texture of 16 × 16 masks, side by side.
    let tiled = through_on_host(4, |[x, y], index, p| word(0, [x % 16, y % 16], index, p));
    Ok(Finding::new(error, ERRORS, largest_correlation(&tiled)))
}

fn seeds(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    let seeds = [0, 1, 2, 3, 4, 5, 6, 7, 8, 1 << 32, (1 << 32) + 1];
    let largest = |images: &[Vec<f64>]| {
        let pairs = (0..images.len()).flat_map(|a| (a + 1..images.len()).map(move |b| (a, b)));
        pairs.map(|(a, b)| correlation(&images[a], &images[b])).fold(0.0, f64::max) * PIXELS.sqrt()
    };
    let images = through(stage, method, OPACITY, &seeds)?;
    // Only 32 bits of a seed count.
    let short = seeds.map(|seed| through_on_host(4, |at, index, p| word(u64::from(seed as u32), at, index, p)));
    Ok(Finding::new(largest(&images), ERRORS, largest(&short)))
}

fn samples(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    let found = variance(&through(stage, method, OPACITY, &[0])?[0]);
    // A stratum has one sample or two of four; 16 of them.
    let wanted = 0.25 / 16.0 / 16.0;
    // The variance of a sample variance: 2 and the excess kurtosis, -2 / 16, over n.
    let bound = ERRORS * ((2.0 - 0.125) / PIXELS).sqrt();
    // The same word for all strata.
    let alike = variance(&through_on_host(64, |at, index, _| word(0, at, index, 0)));
    Ok(Finding::new((found / wanted - 1.0).abs(), bound, (alike / wanted - 1.0).abs()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_known_variance_is_that_of_many_pixels() {
        let channel = LAYERS.map(|(color, alpha)| (f64::from(alpha), f64::from(color.y)));
        let pixel = |i: u32| f64::from(on_host(&LAYERS, 4, |index, p| word(7, [i % 256, i / 256], index, p))[1]);
        let values: Vec<f64> = (0..1 << 16).map(pixel).collect();
        let (found, known) = (variance(&values), known_variance(&channel));
        // The variance of a sample variance is below 2 σ⁴ / n for values that are as bounded as these; 4.5 errors.
        assert!((found / known - 1.0).abs() < ERRORS * (2.0 / f64::from(1 << 16)).sqrt(), "{found}, not {known}");
        // A single layer: 4α is rounded at random, Bernoulli of a quarter of α.
        assert!((known_variance(&[(0.375, 0.0), (1.0, 1.0)]) - 0.25 / 16.0).abs() < 1e-15);
    }
}
