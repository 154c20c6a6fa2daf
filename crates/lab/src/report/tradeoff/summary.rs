//! Rows from frames: medians, the Pareto front, slopes.

use super::figures::short;
use super::partial::SettingResults;
use super::{Convergence, Row};
use crate::report::fit::power_law;
use crate::report::stress::Spread;
use crate::report::unique;
use pellucid_engine::profile::median;
use pellucid_session::candidates::Setting;

/// A row without its place on the front.
pub(super) fn row(SettingResults { row, frames, .. }: &SettingResults) -> Row {
    let passes = || frames.iter().flat_map(|frame| &frame.passes);
    let time = |name: &str| median(passes().filter(|pass| pass.0 == name).map(|pass| pass.1).collect());
    let names = unique(passes().map(|pass| &pass.0));
    Row {
        gpu_ms: Spread::from_values(frames.iter().map(|frame| frame.gpu_ms).collect()),
        wall_ms: Spread::from_values(frames.iter().map(|frame| frame.wall_ms).collect()),
        frames: frames.len(),
        passes: names.into_iter().map(|name| (name.clone(), time(name))).collect(),
        ..row.clone()
    }
}

/// Marks what no other row beats: by median device time and RMSE.
pub(super) fn mark_front(rows: &mut [Row]) {
    let places: Vec<[f64; 2]> = rows.iter().map(|row| [row.gpu_ms.median, row.errors.rmse]).collect();
    for (row, place) in rows.iter_mut().zip(&places) {
        // Nowhere above and somewhere below it.
        let beats = |other: &[f64; 2]| other[0] <= place[0] && other[1] <= place[1] && other != place;
        row.front = !places.iter().any(beats);
    }
}

/// The number of frames of each cost (seconds) that fit the allowed seconds, including one warm-up frame each: at most
/// `most`, at least 1, and fewer for those with the largest total.
pub(super) fn frames(costs: &[f64], most: usize, allowed: f64) -> Vec<usize> {
    let mut counts = vec![most; costs.len()];
    let total = |counts: &[usize]| counts.iter().zip(costs).map(|(n, cost)| (1 + n) as f64 * cost).sum::<f64>();
    while total(&counts) > allowed {
        let share = |i: &usize| counts[*i] as f64 * costs[*i];
        let reducible = (0..costs.len()).filter(|i| counts[*i] > 1);
        let Some(longest) = reducible.max_by(|a, b| share(a).total_cmp(&share(b))) else { break };
        counts[longest] -= 1;
    }
    counts
}

/// Slopes of every ladder with at least three rows; `rows` are those of `settings`.
pub(super) fn convergence(settings: &[Setting], rows: &[Row]) -> Vec<Convergence> {
    let mut found: Vec<Convergence> = Vec::new();
    for series in unique(settings.iter().map(|setting| &setting.series)) {
        let has_step = |setting: &&Setting| setting.series == *series && setting.step.is_some();
        let Some(first) = settings.iter().find(has_step) else { continue };
        let Some((key, value)) = first.step else { continue };
        let ladder: Vec<(f64, &Row)> = settings
            .iter()
            .zip(rows)
            .filter(|(setting, _)| setting.series == *series)
            .filter_map(|(setting, row)| Some((setting.step?.1, row)))
            .collect();
        let over_steps: Vec<_> = ladder.iter().map(|(step, row)| (*step, row.errors.rmse)).collect();
        let over_time: Vec<_> = ladder.iter().map(|(_, row)| (row.gpu_ms.median, row.errors.rmse)).collect();
        if let (true, Some(rmse), Some(over_time)) = (ladder.len() >= 3, power_law(&over_steps), power_law(&over_time))
        {
            let rest = short(&first.text).replace(&format!("{key}={value}"), "");
            let key = format!("{key} {}", rest.trim()).trim_end().to_owned();
            let method = first.method.name().to_owned();
            found.push(Convergence { method, key, rmse, over_time, rows: ladder.len() });
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::tradeoff::Errors;
    use crate::report::tradeoff::partial::Timed;
    use pellucid_scene::Discs;
    use pellucid_session::candidates::{Formation, Ladders, Occasion, settings};

    fn measured(times: &[f64], rmse: f64) -> SettingResults {
        let row = Row { errors: Errors { rmse, ..Errors::default() }, ..Row::default() };
        let frame = |ms: &f64| Timed { sitting: 1, gpu_ms: *ms, wall_ms: 2.0 * ms, passes: vec![("a/b".into(), *ms)] };
        SettingResults { row, seconds: 0.0, frames: times.iter().map(frame).collect() }
    }

    fn all() -> Vec<Setting> {
        let formation = Formation::Discs(Discs::default());
        let occasion = Occasion { formation, opaque: false, oriented: false, max_list: 1000, points: 1000 };
        settings(&occasion, &Ladders::FULL).0
    }

    #[test]
    fn rows_hold_medians() {
        let row = row(&measured(&[3.0, 1.0, 2.0], 0.0));
        assert_eq!((row.gpu_ms.min, row.gpu_ms.median, row.wall_ms.max, row.frames), (1.0, 2.0, 6.0, 3));
        assert_eq!(row.passes, [("a/b".to_owned(), 2.0)]);
    }

    #[test]
    fn the_front_is_what_nothing_beats() {
        let places = [(1.0, 0.5), (2.0, 0.5), (2.0, 0.1), (3.0, 0.2), (4.0, 0.0), (4.0, 0.0), (0.5, 0.9)];
        let mut rows: Vec<Row> = places.map(|(ms, rmse)| row(&measured(&[ms], rmse))).into();
        mark_front(&mut rows);
        let front: Vec<bool> = rows.iter().map(|row| row.front).collect();
        // Of two equal rows neither dominates.
        assert_eq!(front, [true, false, true, false, true, true, true]);
    }

    #[test]
    fn slow_settings_get_fewer_frames() {
        assert_eq!(frames(&[1.0, 1.0], 10, 100.0), [10, 10]);
        // 11 + 6·4 = 35 and 11 + 6·3 = 29.
        assert_eq!(frames(&[1.0, 6.0], 10, 29.0), [10, 2]);
        // At least one, even if it doesn't fit.
        assert_eq!(frames(&[100.0, 0.1], 4, 1.0), [1, 1]);
        assert_eq!(frames(&[], 4, 1.0), Vec::<usize>::new());
    }

    #[test]
    fn every_long_ladder_gets_its_slopes() {
        let settings: Vec<Setting> = all().into_iter().filter(Setting::is_stochastic).collect();
        // RMSE falls as samples^(−1/2), time grows in proportion.
        let rows: Vec<Row> = settings
            .iter()
            .map(|setting| {
                let samples = setting.step.unwrap().1;
                row(&measured(&[samples], 0.5 / samples.sqrt()))
            })
            .collect();
        let found = convergence(&settings, &rows);
        let keys: Vec<&str> = found.iter().map(|c| c.key.as_str()).collect();
        assert_eq!(keys, ["samples", "samples alpha_correction=false", "samples raster=hardware"]);
        for law in found.iter().flat_map(|c| [c.rmse, c.over_time]) {
            assert!((law.exponent + 0.5).abs() < 1e-12, "{law:?}");
        }
        assert_eq!(convergence(&settings[..2], &rows[..2]), []);
    }
}
