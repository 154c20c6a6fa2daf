//! Multi-sample stochastic transparency (Enderton, Sintorn, Shirley, Luebke, "Stochastic Transparency", 2011),
//! depth-based: applies the masks of [`pellucid_core::random`] to a pixel's fragments.
//!
//! Samples come in strata of four. Each fragment covers some samples of a stratum; a sample holds the nearest fragment
//! that covers it. A fragment is visible in the samples that hold nothing nearer, even if it doesn't cover them itself
//! (the paper's Section 3.2), and counts with opacity and color there.

use glam::DVec3;

use super::abuffer::lists;
use super::fragments::{Composite, Fragment, composite};
use super::{ReferencePicture, View, WithErrors, gaussians};
use pellucid_core::points::Points;
use pellucid_core::random::{STRATUM, mask, word};
use pellucid_scene::Stochastic;

/// The estimate of a stratum for a pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stratum {
    /// Σ α c vis.
    pub color: DVec3,
    /// Σ α vis.
    pub alpha: f64,
    /// Share of the stratum's samples that were asked for.
    pub weight: f64,
    /// z of the nearest fragment that any of these samples holds, +inf if they are empty.
    pub depth: f64,
}

/// A pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// Premultiplied color.
    pub color: DVec3,
    /// A = 1 − T.
    pub alpha: f64,
    /// The nearest depth over all samples, +inf where they hold nothing.
    pub depth: f64,
    /// Standard error of the color, from the spread of the strata: infinite for a single one.
    pub stderr: DVec3,
}

/// Returns one stratum of a pixel; `samples` (1 to 4) of its samples are used. `masks` holds the covered samples for
/// each fragment of the sorted list.
pub fn stratum(list: &[Fragment], colors: &[DVec3], masks: &[u32], samples: u32) -> Stratum {
    // The place in the list of the first fragment that covers a sample: the smallest rank.
    let held: Vec<Option<usize>> = (0..samples).map(|s| masks.iter().position(|mask| mask >> s & 1 == 1)).collect();
    let mut found = Stratum {
        color: DVec3::ZERO,
        alpha: 0.0,
        weight: f64::from(samples) / f64::from(STRATUM),
        depth: held.iter().flatten().min().map_or(f64::INFINITY, |nearest| list[*nearest].z),
    };
    for (rank, fragment) in list.iter().enumerate() {
        let visible = held.iter().filter(|held| held.is_none_or(|held| held >= rank)).count();
        let weight = fragment.alpha * visible as f64 / f64::from(samples);
        found.color += weight * colors[fragment.index as usize];
        found.alpha += weight;
    }
    found
}

/// Returns the strata of a pixel for this number of samples. `words` gives the random word of a fragment (its index) in
/// a stratum.
pub fn strata(list: &[Fragment], colors: &[DVec3], samples: u32, words: impl Fn(u32, u32) -> u32) -> Vec<Stratum> {
    let stratum_at = |p: u32| {
        let masks: Vec<u32> = list.iter().map(|f| mask(f.alpha as f32, words(f.index, p))).collect();
        stratum(list, colors, &masks, (samples - p * STRATUM).min(STRATUM))
    };
    (0..samples.div_ceil(STRATUM)).map(stratum_at).collect()
}

/// Returns the strata together. `exact` is A = 1 − ∏(1 − α), by which alpha correction scales the color; without it,
/// the means.
pub fn estimate(strata: &[Stratum], exact: Option<f64>) -> Estimate {
    let count = strata.len() as f64;
    let weights: f64 = strata.iter().map(|s| s.weight).sum();
    let color: DVec3 = strata.iter().map(|s| s.weight * s.color).sum();
    let alpha: f64 = strata.iter().map(|s| s.weight * s.alpha).sum();
    // Both are ratios of sums over strata, C = f ΣX / ΣY with X = w C_p and Y = w, or f = A and Y = w A_p; the error is
    // that of a ratio (Cochran, "Sampling Techniques", Section 2.11): f / mean(Y) · sqrt(Σ(X − R Y)² / (P (P − 1))).
    let (factor, visible) = match exact {
        Some(exact) => (exact, (|s: &Stratum| s.weight * s.alpha) as fn(&Stratum) -> f64),
        None => (1.0, (|s: &Stratum| s.weight) as fn(&Stratum) -> f64),
    };
    let below: f64 = strata.iter().map(visible).sum();
    let ratio = if below > 0.0 { color / below } else { DVec3::ZERO };
    let squares: DVec3 = strata.iter().map(|s| (s.weight * s.color - ratio * visible(s)).powf(2.0)).sum();
    let spread = (squares / (count * (count - 1.0))).map(f64::sqrt);
    let stderr = match strata.len() {
        1 => DVec3::INFINITY,
        _ if below > 0.0 => factor * count / below * spread,
        _ => DVec3::ZERO,
    };
    Estimate {
        color: factor * ratio,
        alpha: exact.unwrap_or(alpha / weights),
        depth: strata.iter().map(|s| s.depth).fold(f64::INFINITY, f64::min),
        stderr,
    }
}

/// Returns the whole image, and the standard error of each pixel. `colors` holds a color for each point, shaded and in
/// the space that blending runs in ([`super::shading::shade`]).
pub fn render(view: View, points: &Points, colors: &[DVec3], settings: &Stochastic, seed: u64) -> WithErrors {
    let ids = points.ids(&points.anchor(), 0..points.len());
    render_with(view, points, colors, settings, |pixel, splat, p| word(seed, pixel, ids[splat as usize], p))
}

/// Renders like [`render`], with random words by pixel, splat and stratum from elsewhere.
pub fn render_with(
    view: View,
    points: &Points,
    colors: &[DVec3],
    settings: &Stochastic,
    words: impl Fn([u32; 2], u32, u32) -> u32,
) -> WithErrors {
    let lists = lists(view, points, &settings.discs);
    let estimates: Vec<Estimate> = lists
        .iter()
        .enumerate()
        .map(|(at, list)| {
            let strata = strata(list, colors, settings.samples, |splat, p| words(view.place(at), splat, p));
            estimate(&strata, settings.alpha_correction.then(|| composite(list, colors).alpha))
        })
        .collect();
    let shown =
        |list: &[Fragment], key| gaussians::depth_of_key(view.camera, points, &settings.discs.gaussians, list, key);
    let pixels = estimates.iter().zip(&lists).map(|(e, list)| {
        (Composite { color: e.color, alpha: e.alpha, depth: shown(list, e.depth) }, list.len() as u32)
    });
    (ReferencePicture::of(view.size, pixels), estimates.iter().map(|e| e.stderr).collect())
}
