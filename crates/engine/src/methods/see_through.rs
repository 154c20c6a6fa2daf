//! The opacity at which the median covered pixel lets a given share of its light through.
//!
//! One factor on all opacities is sought. Where k discs of opacity α f cover a pixel, T = (1 − α f)^k: ln(−ln T) grows
//! with ln f at a slope near 1, so that a few trials by the secant find it; bisection takes over where a trial is no
//! help, since T is 0 or 1 to the last bit. Trials begin on a small image of the same view and end on one of the
//! frame's size.

use serde_json::{Value, json};

use super::{Error, Frame, Outputs, Renderer};
use crate::passes::project::DeviceCloud;
use crate::points::Points;
use crate::scene::{CloudSettings, MethodChoice};

/// Largest difference of the median from the share that was asked for.
pub const TOLERANCE: f64 = 0.004;

/// Longer side of the images of the first trials.
const SMALL_SIDE: u32 = 256;

/// Trials on an image of one size: bisection over the whole range to the last bit would take no more.
const MAX_TRIALS: u32 = 40;

/// The smallest factor tried.
const SMALLEST: f64 = 1e-8;

/// A factor that was found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OpacityFactor {
    /// The factor on all opacities.
    pub factor: f32,
    /// The median T of the covered pixels with it.
    pub transmittance: f64,
    /// Images that were rendered to find it.
    pub trials: u32,
}

impl OpacityFactor {
    /// Returns `true` if the median is within [`TOLERANCE`] of the share that was asked for.
    pub fn meets(&self, share: f64) -> bool {
        (self.transmittance - share).abs() <= TOLERANCE
    }

    /// Returns the metadata of an image, `{factor, opacities, transmittance}`, with `radius_factor` unless that is 1.
    pub fn json(&self, clouds: &[CloudSettings], radius_factor: f32) -> Value {
        let mut about = json!({
            "factor": self.factor,
            "opacities": opacities(self.factor, clouds),
            "transmittance": self.transmittance,
        });
        if radius_factor != 1.0 {
            about["radius_factor"] = json!(radius_factor);
        }
        about
    }
}

/// Returns each cloud's opacity with a factor, cut at 1.
pub fn opacities(factor: f32, clouds: &[CloudSettings]) -> Vec<f32> {
    clouds.iter().map(|cloud| (cloud.opacity * factor).min(1.0)).collect()
}

/// Returns the factor at which even the faintest point that can be seen is opaque.
pub fn largest_factor(points: &Points) -> f32 {
    points.opacities.iter().copied().filter(|opacity| *opacity > 0.0).fold(1.0, f32::min).recip()
}

/// Returns the reason why no opacity makes light pass through the pictures of a method; `None` if one does.
pub fn refusal(method: MethodChoice) -> Option<String> {
    let method = method.fixed().filter(|method| !method.family().has_opacity())?;
    let name = method.name();
    Some(format!(
        "the opacity of points has no effect with method {name}; use `auto`, abuffer, sorted, spbr or another transparent method"
    ))
}

/// Finds the factor from 0 to `max_factor`, at which all opacities are cut at 1. `None` if no pixel is covered. Where
/// no factor meets the share, as of opacities that don't count, the nearest one found is returned.
///
/// # Errors
/// Returns an error if rendering fails.
pub fn find(
    renderer: &mut Renderer,
    cloud: &mut DeviceCloud,
    frame: &Frame,
    share: f64,
    max_factor: f32,
) -> Result<Option<OpacityFactor>, Error> {
    let mut search = Search::new(share, f64::from(max_factor));
    let small = small(frame.size);
    let sizes = if small == frame.size { vec![small] } else { vec![small, frame.size] };
    let mut found = None;
    for size in sizes {
        search.restart();
        found = look(renderer, cloud, &Frame { size, ..*frame }, &mut search)?.or(found);
    }
    Ok(found)
}

/// Like [`find`], on a small image alone: for an advice.
///
/// # Errors
/// Returns an error if rendering fails.
pub fn estimate(
    renderer: &mut Renderer,
    cloud: &mut DeviceCloud,
    frame: &Frame,
    share: f64,
    max_factor: f32,
) -> Result<Option<OpacityFactor>, Error> {
    let mut search = Search::new(share, f64::from(max_factor));
    look(renderer, cloud, &Frame { size: small(frame.size), ..*frame }, &mut search)
}

/// Tries factors on images of the frame's size; the best one, or `None` if no pixel is covered.
fn look(
    renderer: &mut Renderer,
    cloud: &mut DeviceCloud,
    frame: &Frame,
    search: &mut Search,
) -> Result<Option<OpacityFactor>, Error> {
    let mut best: Option<OpacityFactor> = None;
    for _ in 0..MAX_TRIALS {
        let Some(factor) = search.next() else { break };
        let outputs = Outputs::default();
        let mut trial = Frame { outputs, fragments: false, spread: false, max_error: None, ..*frame };
        trial.factors.opacity = factor as f32;
        // It changes no A.
        trial.shading.edl.edl = false;
        let image = renderer.render(cloud, &trial)?.image;
        search.trials += 1;
        // Points too faint for the last bit cover nothing.
        let median = median_transmittance(&image.rgba);
        search.tell(factor, median.unwrap_or(1.0));
        let Some(transmittance) = median else { continue };
        let found = OpacityFactor { factor: factor as f32, transmittance, trials: search.trials };
        let off = |found: &OpacityFactor| (found.transmittance - search.share).abs();
        best = best.filter(|best| off(best) <= off(&found)).or(Some(found));
        if found.meets(search.share) {
            break;
        }
    }
    Ok(best.map(|best| OpacityFactor { trials: search.trials, ..best }))
}

/// Width and height of at most [`SMALL_SIDE`], in about the same ratio.
fn small([width, height]: [u32; 2]) -> [u32; 2] {
    let longer = width.max(height);
    if longer <= SMALL_SIDE {
        return [width, height];
    }
    let scaled = |side: u32| ((u64::from(side) * u64::from(SMALL_SIDE)).div_ceil(u64::from(longer)) as u32).max(1);
    [scaled(width), scaled(height)]
}

/// Returns the median of T = 1 − A over the pixels with A > 0; `None` if there are none.
pub fn median_transmittance(pixels: &[[f32; 4]]) -> Option<f64> {
    let mut all: Vec<f32> = pixels.iter().map(|pixel| pixel[3]).filter(|a| *a > 0.0).collect();
    let middle = all.len().checked_sub(1)? / 2;
    let even = all.len().is_multiple_of(2);
    let (_, low, above) = all.select_nth_unstable_by(middle, f32::total_cmp);
    let next = above.iter().copied().min_by(f32::total_cmp).filter(|_| even);
    let high = f64::from(next.unwrap_or(*low));
    Some(1.0 - 0.5 * (f64::from(*low) + high))
}

/// The search for a factor. T falls with it.
struct Search {
    share: f64,
    max: f64,
    /// The largest factor known to let too much through, and the smallest known to let too little.
    bracket: [f64; 2],
    /// ln f and ln(−ln T) of the last trials with a T between 0 and 1.
    last: Vec<[f64; 2]>,
    /// The factor of the next trial, if one was already tried on an image of another size.
    next: Option<f64>,
    trials: u32,
    tried_max: bool,
    done: bool,
}

impl Search {
    fn new(share: f64, max: f64) -> Self {
        // The faintest float32 is 10⁻⁴⁵: times larger factors none is finite.
        let max = max.clamp(SMALLEST, 1e30);
        // Where 16 discs of opacity 1 overlap, this is right for a half.
        let next = Some((max * 0.04).clamp(SMALLEST, max));
        Self { share, max, bracket: [SMALLEST, max], last: Vec::new(), next, trials: 0, tried_max: false, done: false }
    }

    /// Begins anew at the factor that fits best so far: another image has another median.
    fn restart(&mut self) {
        if self.trials > 0 {
            self.next = self.guess().or(Some(self.bracket[0]));
        }
        self.bracket = [SMALLEST, self.max];
        self.last.clear();
        self.tried_max = false;
        self.done = false;
    }

    /// The next factor; `None` if there is none to try.
    fn next(&mut self) -> Option<f64> {
        if self.done {
            return None;
        }
        if self.share >= 1.0 || self.share <= 0.0 {
            self.done = true;
            return Some(if self.share <= 0.0 { self.max } else { SMALLEST });
        }
        let [low, high] = self.bracket;
        if let Some(next) = self.next.take() {
            return Some(next.clamp(low, high));
        }
        if high <= low * (1.0 + 1e-7) {
            return None;
        }
        // The upper end of the range is tried once.
        let within = |x: &f64| *x > low && (*x < high || (high >= self.max && !self.tried_max));
        let guess = self.guess().map(|x| x.min(self.max)).filter(within);
        Some(guess.unwrap_or((low * high).sqrt()))
    }

    /// Returns where the secant through the last trials, or the slope 1 through a single one, meets the share.
    fn guess(&self) -> Option<f64> {
        let wanted = (-self.share.ln()).ln();
        let [.., [x, y]] = self.last[..] else { return None };
        let slope = match self.last[..] {
            [.., [x0, y0], [x1, y1]] if (x1 - x0).abs() > 1e-9 => ((y1 - y0) / (x1 - x0)).clamp(0.25, 8.0),
            _ => 1.0,
        };
        Some((x + (wanted - y) / slope).exp())
    }

    fn tell(&mut self, factor: f64, transmittance: f64) {
        let end = usize::from(transmittance < self.share);
        self.bracket[end] = factor;
        self.tried_max |= factor >= self.max;
        // Nothing lets less through.
        self.done |= factor >= self.max && transmittance >= self.share;
        if transmittance > 0.0 && transmittance < 1.0 {
            self.last.push([factor.ln(), (-transmittance.ln()).ln()]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Trials until the median of an analytic model is met.
    fn trials(share: f64, max: f64, model: impl Fn(f64) -> f64) -> (f64, u32) {
        let mut search = Search::new(share, max);
        let mut last = f64::NAN;
        while let Some(factor) = search.next() {
            search.trials += 1;
            assert!(search.trials <= MAX_TRIALS && factor <= max && factor > 0.0, "{factor}");
            last = factor;
            let found = model(factor);
            if (found - share).abs() <= TOLERANCE {
                break;
            }
            search.tell(factor, found);
        }
        (last, search.trials)
    }

    #[test]
    fn stacks_of_discs_are_found_in_few_trials() {
        for layers in [1.0, 2.0, 7.0, 16.0, 300.0, 1e4] {
            for share in [0.02, 0.1, 0.5, 0.9, 0.98] {
                let (factor, count) = trials(share, 1.0, |f| (1.0 - f).powf(layers));
                let found = (1.0 - factor).powf(layers);
                assert!((found - share).abs() <= TOLERANCE, "{layers} layers, {share}: {found}");
                assert!(count <= 14, "{layers} layers, {share}: {count} trials");
            }
        }
    }

    #[test]
    fn medians_that_saturate_or_stay_are_survived() {
        // T of 0 and of 1 to the last bit away from a narrow range.
        let steep = |f: f64| {
            if f < 0.001 {
                1.0
            } else if f > 0.0012 {
                0.0
            } else {
                (0.0012 - f) / 0.0002
            }
        };
        assert!((steep(trials(0.5, 1.0, steep).0) - 0.5).abs() <= TOLERANCE);
        // Opacities that don't count: the search ends.
        for constant in [0.0, 0.2, 0.8, 1.0] {
            trials(0.5, 1.0, |_| constant);
        }
        // A single faint layer lets more through than is asked for even where it is opaque.
        let (factor, _) = trials(0.1, 1.0, |f| 1.0 - 0.5 * f);
        assert!(factor > 0.99, "{factor}");
        assert_eq!(trials(0.0, 3.0, |_| 0.5).0, 3.0);
    }

    #[test]
    fn medians() {
        let image = |alphas: &[f32]| alphas.iter().map(|a| [0.0, 0.0, 0.0, *a]).collect::<Vec<_>>();
        assert_eq!(median_transmittance(&image(&[0.0, 0.0])), None);
        assert_eq!(median_transmittance(&image(&[0.0, 0.25, 0.0])), Some(0.75));
        assert_eq!(median_transmittance(&image(&[1.0, 0.25, 0.5])), Some(0.5));
        assert_eq!(median_transmittance(&image(&[1.0, 0.25, 0.5, 0.75])), Some(0.375));
    }

    #[test]
    fn sizes() {
        assert_eq!(small([256, 100]), [256, 100]);
        assert_eq!(small([1024, 512]), [256, 128]);
        assert_eq!(small([16384, 1]), [256, 1]);
    }
}
