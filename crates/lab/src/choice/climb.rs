//! Which settings are tried, and in which order.

use super::trials::Trials;
use super::{EXACT, Figures};
use crate::report::tradeoff::settings::Setting;
use pellucid_engine::Result;

/// Samples of the two steps from which the error of more is extrapolated.
const PROBES: [u32; 2] = [4, 16];
/// An extrapolated time has to be above the best by this factor for a step not to be tried.
const DOUBT: f64 = 1.3;

/// What finds figures of settings.
pub(super) trait Measures {
    /// The figures of a setting that was measured.
    fn figures(&self, setting: &Setting) -> Option<Figures>;

    /// The figures of a setting, measured now unless they are cached; `None` if it can't be rendered. `best` is the
    /// time of the best setting so far. The first frame pays for buffers and shaders; after it, a much slower setting
    /// gets one frame, others two.
    fn look(&mut self, setting: &Setting, best: Option<f64>) -> Result<Option<Figures>>;

    /// The fastest of some measured settings: those close to it take turns until their medians are reliable.
    fn fastest(&mut self, settings: &[&Setting]) -> Result<Option<(Setting, Figures)>>;
}

/// The fastest setting with an RMSE of at most `most`; if none exists, the most accurate of those tried. `first` are keys of
/// settings that were the fastest elsewhere: those of them that apply are tried before the others, until one is accurate
/// enough. Its time ends the ladders of slower methods early. What is chosen doesn't depend on them.
pub(super) fn by_error<M: Measures>(
    trials: &mut M,
    all: &[Setting],
    most: f64,
    first: &[String],
) -> Result<Option<(Setting, Figures)>> {
    let mut best = Best { most, ms: None };
    for setting in first.iter().filter_map(|key| all.iter().find(|setting| setting.key() == *key)) {
        if trials.look(setting, None)?.is_some_and(|figures| best.note(figures)) {
            break;
        }
    }
    for ladder in ladders(all) {
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

/// The most accurate setting whose frame takes at most `budget` ms; if none exists, the fastest of those tried.
pub(super) fn by_time(trials: &mut Trials<'_>, all: &[Setting], budget: f64) -> Result<Option<(Setting, Figures)>> {
    let occasion = trials.occasion();
    let (exact, others): (Vec<&Setting>, Vec<&Setting>) = all.iter().partition(|setting| setting.is_exact(&occasion));
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
fn most_accurate<'a>(
    trials: &impl Measures,
    settings: impl Iterator<Item = &'a Setting>,
) -> Option<(Setting, Figures)> {
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
fn climb(trials: &mut impl Measures, ladder: &[&Setting], best: &mut Best) -> Result<()> {
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
fn jump(trials: &mut impl Measures, ladder: &[&Setting], best: &mut Best) -> Result<()> {
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

/// From an accurate step down, as long as the cheaper ones are too.
fn descend(trials: &mut impl Measures, below: &[&Setting], best: &mut Best) -> Result<()> {
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

    use std::collections::BTreeMap;

    use pellucid_engine::points::Points;
    use pellucid_engine::scene::Discs;

    use crate::report::tradeoff::settings::{Formation, Ladders, Occasion, settings};

    /// Settings whose figures are given by a function of method and step.
    struct Known {
        of: fn(&str, f64) -> Figures,
        /// Those that were looked at.
        met: BTreeMap<String, Figures>,
    }

    impl Measures for Known {
        fn figures(&self, setting: &Setting) -> Option<Figures> {
            self.met.get(&setting.key()).copied()
        }

        fn look(&mut self, setting: &Setting, _: Option<f64>) -> Result<Option<Figures>> {
            let step = setting.step.map_or(f64::INFINITY, |(_, value)| value);
            let figures = (self.of)(setting.method.name(), step);
            self.met.insert(setting.key(), figures);
            Ok(Some(figures))
        }

        fn fastest(&mut self, settings: &[&Setting]) -> Result<Option<(Setting, Figures)>> {
            let found = settings.iter().filter_map(|setting| Some(((*setting).clone(), self.figures(setting)?)));
            Ok(found.min_by(|(_, a), (_, b)| a.gpu_ms.total_cmp(&b.gpu_ms)))
        }
    }

    /// A scene on which `mlab` is the fastest accurate method, and every step of a ladder takes longer than the one before.
    fn deep(method: &str, step: f64) -> Figures {
        let (rmse, gpu_ms) = match method {
            "abuffer" => (0.0, 100.0),
            "linked-list" | "sorted" => (0.0, 120.0),
            "peel" => (1.0 / step, 20.0 * step),
            "stochastic" => (0.3 / step.sqrt(), 10.0 + step),
            "hybrid" => (0.1 / step, 30.0 + step),
            "mlab" => (0.02 / step, 10.0 + step),
            "moments" => (0.02, 25.0),
            "wavelet" => (0.04 / step, 20.0 + 5.0 * step),
            _ => (0.2, 5.0),
        };
        Figures { rmse, gpu_ms }
    }

    /// The key of the choice, its figures, and how many settings were looked at.
    fn chosen(most: f64, first: &[&str]) -> (String, f64, usize) {
        let occasion = Occasion::new(&Points::default(), Formation::Discs(Discs::default()), 300);
        let (all, _) = settings(&Occasion { opaque: false, ..occasion }, &Ladders::FINE);
        let mut known = Known { of: deep, met: BTreeMap::new() };
        let first: Vec<String> = first.iter().map(|key| (*key).to_owned()).collect();
        let (setting, figures) = by_error(&mut known, &all, most, &first).unwrap().unwrap();
        (setting.key(), figures.gpu_ms, known.met.len())
    }

    #[test]
    fn where_one_begins_changes_the_work_and_not_the_choice() {
        for most in [0.1, 0.015, 0.005, 0.0021, 1e-4, 0.0] {
            let (key, ms, looks) = chosen(most, &[]);
            // A good start, one that is too inaccurate, a slow one, none that applies.
            for first in [&["mlab method.nodes=4"][..], &["average"], &["linked-list", "sorted"], &["attic"]] {
                let (other, other_ms, _) = chosen(most, first);
                assert_eq!((&other, other_ms), (&key, ms), "{most}: {first:?}");
            }
            let (_, _, fewer) = chosen(most, &[key.as_str()]);
            assert!(fewer <= looks, "{most}: {fewer} of {looks}");
        }
        let (_, _, looks) = chosen(0.005, &[]);
        let (key, _, fewer) = chosen(0.005, &["mlab method.nodes=4"]);
        // Ladders of hybrid, moments and wavelet end at their first step, which is slower.
        assert!(key == "mlab method.nodes=4" && fewer + 4 <= looks, "{fewer} of {looks}");
        // Of two the second is not looked at if the first is accurate enough.
        assert_eq!(chosen(0.005, &["mlab method.nodes=4", "average"]).2, fewer);
    }

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
