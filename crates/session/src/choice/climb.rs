//! Search over settings: the ones that are tried, and their order.

use super::trials::Trials;
use super::{EXACT, Figures};
use crate::candidates::Setting;
use pellucid_engine::Result;

/// Samples of the two steps from which the error of more is extrapolated.
const PROBES: [u32; 2] = [4, 16];
/// An extrapolated time has to be above the best by this factor for a step not to be tried.
const DOUBT: f64 = 1.3;

/// The fastest setting with an RMSE of at most `most`; if none exists, the most accurate of those tried.
pub(super) fn by_error(trials: &mut Trials<'_>, all: &[Setting], most: f64) -> Result<Option<(Setting, Figures)>> {
    let mut best = Best { most, ms: None };
    let occasion = trials.occasion();
    let exact: Vec<&Setting> = all.iter().filter(|setting| setting.is_exact(&occasion)).collect();
    for mut ladder in ladders(all) {
        if !ladder[0].is_exact(&occasion) {
            let least = fewest_samples(trials, &exact, most);
            ladder.retain(|setting| setting.samples.is_none_or(|count| count >= least));
        }
        if ladder.is_empty() {
            continue;
        }
        if ladder[0].is_stochastic() {
            jump(trials, &ladder, &mut best)?;
        } else {
            climb(trials, &ladder, &mut best)?;
        }
    }
    let fits = |setting: &&Setting| trials.figures(setting).is_some_and(|figures| figures.rmse <= most);
    let fitting: Vec<&Setting> = all.iter().filter(fits).collect();
    if !fitting.is_empty() {
        return trials.fastest(&fitting);
    }
    let found = most_accurate(trials, all.iter()).map(|(setting, _)| setting);
    let found: Vec<&Setting> = found.iter().collect();
    trials.fastest(&found)
}

/// Returns the fewest samples of a pixel's area with which an exact method is accurate enough, by what was measured:
/// with fewer the error of an approximation, which has its own beside it, is hardly smaller. With none that is accurate
/// enough it is more than any number; without exact methods, such as for a choice among settings of one, it is 0.
fn fewest_samples(trials: &Trials<'_>, exact: &[&Setting], most: f64) -> u32 {
    let fits = |setting: &&&Setting| trials.figures(setting).is_some_and(|figures| figures.rmse <= most);
    let fewest = exact.iter().filter(fits).filter_map(|setting| setting.samples).min();
    fewest.unwrap_or(if exact.is_empty() { 0 } else { u32::MAX })
}

/// The most accurate setting whose frame takes at most `budget` ms; if none exists, the fastest of those tried.
pub(super) fn by_time(trials: &mut Trials<'_>, all: &[Setting], budget: f64) -> Result<Option<(Setting, Figures)>> {
    let occasion = trials.occasion();
    // Against the area no picture of some samples is exact.
    let is_exact = |setting: &&Setting| setting.is_exact(&occasion) && setting.samples.is_none();
    let (exact, others): (Vec<&Setting>, Vec<&Setting>) = all.iter().partition(is_exact);
    for setting in &exact {
        // Peeling all layers may take very long; the ladder's steps show how long.
        if setting.effort.is_none() {
            trials.look(setting, Some(budget))?;
        }
    }
    let fastest = trials.fastest(&exact)?;
    if let Some((_, figures)) = &fastest
        && figures.gpu_ms <= budget
    {
        return Ok(fastest);
    }
    for ladder in ladders(others.into_iter().chain(exact.iter().copied().filter(|setting| setting.effort.is_some()))) {
        for setting in ladder {
            if trials.look(setting, Some(budget))?.is_none_or(|figures| figures.gpu_ms > budget) {
                break;
            }
        }
    }
    // Two frames are not reliable: the best setting is timed again until it stays the best.
    loop {
        let fits = |setting: &&Setting| trials.figures(setting).is_some_and(|figures| figures.gpu_ms <= budget);
        let Some((found, figures)) = most_accurate(trials, all.iter().filter(fits)) else { break };
        trials.settle(&[&found])?;
        if trials.figures(&found) == Some(figures) {
            return Ok(Some((found, figures)));
        }
    }
    let measured: Vec<&Setting> = all.iter().collect();
    trials.fastest(&measured)
}

/// The most accurate of those measured, of equally accurate ones the fastest.
fn most_accurate<'a>(trials: &Trials<'_>, settings: impl Iterator<Item = &'a Setting>) -> Option<(Setting, Figures)> {
    let measured = settings.filter_map(|setting| Some((setting, trials.figures(setting)?)));
    let key = |figures: &Figures| (figures.rmse.max(EXACT), figures.gpu_ms);
    let best = measured.min_by(|(_, a), (_, b)| {
        let ((error_a, ms_a), (error_b, ms_b)) = (key(a), key(b));
        error_a.total_cmp(&error_b).then(ms_a.total_cmp(&ms_b))
    });
    best.map(|(setting, figures)| (setting.clone(), figures))
}

/// Settings by series, in order; each series by ascending effort, which it has already.
fn ladders<'a>(all: impl IntoIterator<Item = &'a Setting>) -> Vec<Vec<&'a Setting>> {
    let mut ladders: Vec<Vec<&Setting>> = Vec::new();
    for setting in all {
        match ladders.iter_mut().find(|ladder| ladder[0].series == setting.series) {
            Some(ladder) => ladder.push(setting),
            None => ladders.push(vec![setting]),
        }
    }
    ladders
}

/// The fastest setting so far that is accurate enough.
struct Best {
    most: f64,
    ms: Option<f64>,
}

impl Best {
    /// Records a setting. Returns true if it is accurate enough.
    fn note(&mut self, figures: Figures) -> bool {
        let fits = figures.rmse <= self.most;
        if fits {
            self.ms = Some(self.ms.map_or(figures.gpu_ms, |ms| ms.min(figures.gpu_ms)));
        }
        fits
    }

    fn is_slower(&self, ms: f64) -> bool {
        self.ms.is_some_and(|best| ms > best)
    }
}

/// Step by step until one is accurate enough or slower than the best.
fn climb(trials: &mut Trials<'_>, ladder: &[&Setting], best: &mut Best) -> Result<()> {
    let mut times = Vec::new();
    for setting in ladder {
        if setting.effort.and_then(|effort| affine(&times, effort)).is_some_and(|ms| best.is_slower(ms / DOUBT)) {
            break;
        }
        let Some(figures) = trials.look(setting, best.ms)? else { break };
        times.extend(setting.effort.map(|effort| (effort, figures.gpu_ms)));
        if best.note(figures) || best.is_slower(figures.gpu_ms) {
            break;
        }
    }
    Ok(())
}

/// Two probes, then the step that should be accurate enough since errors fall as samples^(−1/2), then its neighbors.
fn jump(trials: &mut Trials<'_>, ladder: &[&Setting], best: &mut Best) -> Result<()> {
    let samples = |at: usize| ladder[at].step.map_or(0.0, |(_, samples)| samples);
    let effort = |at: usize| ladder[at].effort.unwrap_or(0.0);
    let first_with = |least: f64| (0..ladder.len()).find(|at| samples(*at) >= least);
    let mut times = Vec::new();
    let mut next = first_with(PROBES[0].into());
    while let Some(at) = next {
        if affine(&times, effort(at)).is_some_and(|ms| best.is_slower(ms / DOUBT)) {
            return Ok(());
        }
        let Some(figures) = trials.look(ladder[at], best.ms)? else { return Ok(()) };
        times.push((effort(at), figures.gpu_ms));
        if best.note(figures) {
            return descend(trials, &ladder[..at], best);
        }
        if best.is_slower(figures.gpu_ms) && times.len() > 1 {
            return Ok(());
        }
        let ratio = figures.rmse / best.most;
        // A little less than needed: the ladder is steep, and too few samples are cheap to find out about.
        let needed = 0.8 * samples(at) * ratio * ratio;
        let probe = if times.len() < PROBES.len() { f64::from(PROBES[1]) } else { f64::INFINITY };
        next = first_with(needed.min(probe).max(samples(at) + 1.0));
    }
    Ok(())
}

/// Descends from an accurate step, as long as the cheaper ones are accurate too.
fn descend(trials: &mut Trials<'_>, below: &[&Setting], best: &mut Best) -> Result<()> {
    for setting in below.iter().rev() {
        match trials.look(setting, best.ms)? {
            Some(figures) if best.note(figures) => {}
            _ => break,
        }
    }
    Ok(())
}

/// The time at `x` on the line through the last two points (x, ms), if two exist; never less than the last time.
fn affine(times: &[(f64, f64)], x: f64) -> Option<f64> {
    let [.., (x0, y0), (x1, y1)] = times else { return None };
    let slope = ((y1 - y0) / (x1 - x0)).max(0.0);
    Some(y1 + slope * (x - x1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_extrapolated_along_a_line() {
        assert_eq!(affine(&[(1.0, 5.0)], 2.0), None);
        assert_eq!(affine(&[(0.0, 9.0), (4.0, 10.0), (8.0, 12.0)], 16.0), Some(16.0));
        assert_eq!(affine(&[(4.0, 10.0), (8.0, 9.0)], 16.0), Some(9.0));
    }

    #[test]
    fn the_best_is_the_fastest_that_is_accurate_enough() {
        let mut best = Best { most: 0.1, ms: None };
        assert!(!best.note(Figures { rmse: 0.2, gpu_ms: 1.0 }) && !best.is_slower(1e9));
        assert!(best.note(Figures { rmse: 0.1, gpu_ms: 5.0 }) && best.note(Figures { rmse: 0.0, gpu_ms: 7.0 }));
        assert!(best.is_slower(5.1) && !best.is_slower(5.0));
    }
}
