//! The figures.

use super::surfaces::figures::{self as surfaces, Over};
use super::{Analytic, Convergence, Errors, Row, Tradeoff};
use crate::report::fit::PowerLaw;
use crate::report::plot::{Axis, Figure, Guide, Panel, Point, Series, Steps};
use crate::report::popping::{Scale, over_frames};
use pellucid_engine::output;

/// RMSE below is drawn at this value, since 0 has no place on a logarithmic axis: a forty-thousandth of an 8-bit step.
pub(super) const RMSE_FLOOR: f64 = 1e-7;
/// FLIP below is drawn at this value; it grows faster than small differences do.
pub(super) const FLIP_FLOOR: f64 = 1e-6;
/// A power law must explain at least this much of the variance.
pub(super) const LAW_R_SQUARED: f64 = 0.95;
/// Device time below is drawn here, in ms.
const TIME_FLOOR: f64 = 1e-3;
/// Width of all panels of a row together, in pixels.
const WIDTH: u32 = 1140;

/// A figure and the name of its file.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Drawn {
    pub name: &'static str,
    pub svg: String,
}

/// All figures that have something to show.
pub(super) fn draw(report: &Tradeoff) -> Result<Vec<Drawn>, output::Error> {
    let over_size = |over| surfaces::over_size(report.surveyed.as_ref()?, &report.rows, over);
    let figures = [
        ("size-time.svg", over_size(Over::Time)),
        ("size-holes.svg", over_size(Over::Holes)),
        ("size-error.svg", over_size(Over::Error)),
        ("error.svg", Some(error_over_time(report, RMSE_FLOOR, "RMSE", |errors| errors.rmse))),
        ("flip.svg", Some(error_over_time(report, FLIP_FLOOR, "FLIP", |errors| errors.flip))),
        ("convergence.svg", convergence(report)),
        ("bias.svg", bias(report)),
        ("popping.svg", popping(report, POPPING)),
        ("popping-flip.svg", popping(report, POPPING_FLIP)),
    ];
    let drawn = figures.into_iter().filter_map(|(name, figure)| Some((name, figure?)));
    let svg = |(name, figure): (&'static str, Figure)| {
        let failed = |error| output::Error::Report { reason: format!("{name}: {error}") };
        Ok(Drawn { name, svg: figure.svg().map_err(failed)? })
    };
    drawn.map(svg).collect()
}

/// Scales of the figures of popping.
const POPPING: Scale = Scale { label: "change of the error, RMSE", floor: RMSE_FLOOR, value: |frame| frame.rmse };
const POPPING_FLIP: Scale = Scale { label: "change of the error, FLIP", floor: FLIP_FLOOR, value: |frame| frame.flip };

fn popping(report: &Tradeoff, scale: Scale) -> Option<Figure> {
    over_frames(report.popping.as_ref()?, scale)
}

/// A setting without what all methods' settings share: `samples=64` for `method.samples=64`.
pub(super) fn short(setting: &str) -> String {
    let parts = setting.split_whitespace().map(|part| part.strip_prefix("method.").unwrap_or(part));
    parts.collect::<Vec<_>>().join(" ")
}

/// A signed number with fixed decimals and a minus sign as wide as a digit.
pub(super) fn signed(value: f64, places: usize) -> String {
    format!("{value:.places$}").replace('-', "−")
}

/// The rows of one method that differ in one setting, by ascending step; or one row without a step.
struct Ladder<'a> {
    rows: Vec<&'a Row>,
    /// The other settings.
    rest: String,
}

fn ladders(report: &Tradeoff) -> Vec<Ladder<'_>> {
    let mut ladders: Vec<Ladder<'_>> = Vec::new();
    for row in &report.rows {
        let key = row.step.as_ref().map(|(key, _)| key.as_str());
        let setting = short(&row.setting);
        let turned =
            |part: &&str| key.is_some_and(|keys| keys.split('+').any(|key| part.split('=').next() == Some(key)));
        let rest = setting.split_whitespace().filter(|part| !turned(part)).collect::<Vec<_>>().join(" ");
        let same = |ladder: &&mut Ladder<'_>| {
            let first = ladder.rows[0];
            key.is_some()
                && first.method == row.method
                && first.step.as_ref().map(|(key, _)| key.as_str()) == key
                && ladder.rest == rest
        };
        match ladders.iter_mut().find(same) {
            Some(ladder) => ladder.rows.push(row),
            None => ladders.push(Ladder { rows: vec![row], rest }),
        }
    }
    for ladder in &mut ladders {
        ladder.rows.sort_by(|a, b| step(a).total_cmp(&step(b)));
    }
    ladders
}

/// The position on the ladder; NaN without a ladder.
fn step(row: &Row) -> f64 {
    row.step.as_ref().map_or(f64::NAN, |(_, value)| *value)
}

/// Returns the index of a method in the names of the legend; all methods are among them.
fn index(names: &[String], method: &str) -> usize {
    names.iter().position(|name| name == method).unwrap_or(0)
}

fn error_over_time(report: &Tradeoff, floor: f64, label: &'static str, error: fn(&Errors) -> f64) -> Figure {
    let names = surfaces::names(report.rows.iter());
    let series = |ladder: &Ladder<'_>| {
        // The panel's title already names the cloud.
        let rest = if report.surveyed.is_some() { "" } else { &ladder.rest };
        let point = |(place, row): (usize, &&Row)| Point {
            range_x: [row.gpu_ms.min, row.gpu_ms.max],
            label: point_label(row, place == 0, rest),
            ..Point::new(row.gpu_ms.median, error(&row.errors))
        };
        let mut points: Vec<Point> = ladder.rows.iter().enumerate().map(point).collect();
        // There are many ladders in a small panel: their ends are enough to follow them.
        if let (Some(_), [_, between @ .., _]) = (&report.surveyed, points.as_mut_slice()) {
            between.iter_mut().for_each(|point| point.label.clear());
        }
        Series { name: index(&names, &ladder.rows[0].method), points, note: String::new() }
    };
    let all = ladders(report);
    let panel = |title: String, thinning: Option<u32>| {
        let is_in = |row: &Row| thinning.is_none_or(|one_of| row.thinning == one_of);
        let rows = report.rows.iter().filter(|row| is_in(row));
        Panel {
            title,
            series: all.iter().filter(|ladder| is_in(ladder.rows[0])).map(series).collect(),
            front: front(rows.map(|row| [row.gpu_ms.median, error(&row.errors)])),
            is_guided: false,
        }
    };
    let x = Axis { label: "device time of a frame in ms", floor: TIME_FLOOR, steps: Steps::Tens };
    if let Some(surveyed) = &report.surveyed {
        let of_cloud = |(thinning, points): &(u32, u64)| panel(surfaces::title(*thinning, *points), Some(*thinning));
        let panels = surveyed.clouds.iter().map(of_cloud).collect();
        let y = Axis { label, floor, steps: Steps::Tens };
        return surfaces::side_by_side(names.clone(), x, y, panels);
    }
    let panel = panel(String::new(), None);
    Figure {
        x,
        y: Axis { label, floor, steps: Steps::Tens },
        names,
        guide: None,
        front: "Pareto front",
        panel: [WIDTH, 620],
        columns: 1,
        panels: vec![panel],
    }
}

/// The first point of a ladder also names the key that varies.
fn point_label(row: &Row, is_first: bool, rest: &str) -> String {
    let head = match &row.step {
        Some((key, value)) if is_first => format!("{key} {value}"),
        Some((_, value)) => value.to_string(),
        None => row.method.clone(),
    };
    if is_first && !rest.is_empty() { format!("{head} {rest}") } else { head }
}

/// The points [time, error] that no other beats in both, by ascending time.
fn front(points: impl Iterator<Item = [f64; 2]>) -> Vec<[f64; 2]> {
    let mut points: Vec<_> = points.filter(|point| point.iter().all(|value| value.is_finite())).collect();
    points.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    let mut best = f64::INFINITY;
    points.retain(|[_, error]| {
        let is_better = *error < best;
        best = best.min(*error);
        is_better
    });
    points
}

/// Panels side by side.
fn side_by_side(names: Vec<String>, x: &'static str, y: Axis, guide: Option<Guide>, panels: Vec<Panel>) -> Figure {
    let columns = panels.len().clamp(1, 3);
    let x = Axis { label: x, floor: 0.0, steps: Steps::Twos };
    Figure { x, y, names, guide, front: "", panel: [WIDTH / columns as u32, 400], columns, panels }
}

/// RMSE over the ladders' settings: one panel for each key, those of stochastic methods first.
fn convergence(report: &Tradeoff) -> Option<Figure> {
    if report.surveyed.is_some() {
        return None;
    }
    let mut ladders = ladders(report);
    // 0 can't be shown on a logarithmic axis; `layers=0` means all layers.
    ladders.iter_mut().for_each(|ladder| ladder.rows.retain(|row| step(row) > 0.0));
    ladders.retain(|ladder| ladder.rows.len() > 1);
    ladders.sort_by_key(|ladder| !ladder.rows[0].stochastic);
    let mut names = surfaces::names(ladders.iter().map(|ladder| ladder.rows[0]));
    let key = |ladder: &Ladder<'_>| ladder.rows[0].step.as_ref().map(|(key, _)| key.clone()).unwrap_or_default();
    let mut keys: Vec<String> = ladders.iter().map(key).collect();
    // Ladders of one key need not be adjacent.
    let mut seen = Vec::new();
    keys.retain(|key| {
        !seen.contains(key) && {
            seen.push(key.clone());
            true
        }
    });
    let series = |ladder: &Ladder<'_>| {
        let method = &ladder.rows[0].method;
        let is_law = |law: &PowerLaw| law.r_squared >= LAW_R_SQUARED;
        let turned = format!("{} {}", key(ladder), ladder.rest);
        let law = |c: &&Convergence| c.method == *method && c.key == turned.trim_end() && is_law(&c.rmse);
        let fitted = report.convergence.iter().find(law);
        Series {
            name: index(&names, method),
            points: ladder.rows.iter().map(|row| Point::new(step(row), row.errors.rmse)).collect(),
            note: fitted.map(|law| format!("slope {}", signed(law.rmse.exponent, 2))).unwrap_or_default(),
        }
    };
    let panel = |title: &String| {
        let of_key = ladders.iter().filter(|ladder| key(ladder) == *title);
        let is_guided = of_key.clone().any(|ladder| ladder.rows[0].stochastic);
        Panel { title: title.clone(), series: of_key.map(series).collect(), front: Vec::new(), is_guided }
    };
    let mut panels: Vec<_> = keys.iter().map(panel).collect();
    if let (Some(analytic), Some(panel)) = (&report.analytic, panels.first_mut()) {
        panel.series.extend(blended(analytic, &report.rows, names.len()));
        names.extend(["against alpha blending".to_owned(), "expected of that".to_owned()]);
    }
    let guide = Guide { name: "slope −1/2", exponent: -0.5 };
    let y = Axis { label: "RMSE", floor: RMSE_FLOOR, steps: Steps::Tens };
    (!panels.is_empty()).then(|| side_by_side(names, "value of the setting", y, Some(guide), panels))
}

/// Errors against the analytic image, measured and expected, with names that begin at an index.
fn blended(analytic: &Analytic, rows: &[Row], name: usize) -> [Series; 2] {
    let found: Vec<_> = rows.iter().filter_map(|row| Some((step(row), row.rmse_analytic?))).collect();
    let slope = analytic.slope.map(|law| format!("slope {}", signed(law.exponent, 2)));
    let expected = found.iter().map(|(step, _)| Point::new(*step, analytic.expected(*step))).collect();
    let measured = found.iter().map(|(step, rmse)| Point::new(*step, *rmse)).collect();
    // Measured points are drawn on top.
    [
        Series { name: name + 1, points: expected, note: String::new() },
        Series { name, points: measured, note: slope.unwrap_or_default() },
    ]
}

/// The position of a zero bias: the power of ten below all noise and floors.
pub(super) fn bias_floor(report: &Tradeoff) -> f64 {
    let repeats = report.rows.iter().filter_map(|row| row.repeats);
    let values = repeats.flat_map(|r| [r.noise, r.bias_floor]).filter(|value| *value > 0.0 && value.is_finite());
    let least = values.fold(1.0, f64::min);
    10f64.powi(least.log10().floor() as i32).max(RMSE_FLOOR)
}

/// Bias and noise over the ladders of stochastic methods: one panel for each.
fn bias(report: &Tradeoff) -> Option<Figure> {
    let panel = |ladder: Ladder<'_>| {
        let repeats = || ladder.rows.iter().filter(|row| step(row) > 0.0).filter_map(|r| Some((step(r), r.repeats?)));
        let (key, _) = ladder.rows[0].step.as_ref()?;
        let series = |name, value: fn(&super::Repeats) -> f64| {
            let points = repeats().map(|(step, repeats)| Point::new(step, value(&repeats))).collect();
            Series { name, points, note: String::new() }
        };
        let series = vec![series(0, |r| r.noise), series(1, |r| r.bias), series(2, |r| r.bias_floor)];
        let title = format!("{} over {key} {}", ladder.rows[0].method, ladder.rest);
        let has_points = repeats().next().is_some();
        has_points.then(|| Panel { title: title.trim_end().to_owned(), series, front: Vec::new(), is_guided: false })
    };
    let panels: Vec<_> = ladders(report).into_iter().filter_map(panel).collect();
    let names = ["noise of one image", "bias", "floor of the bias"].map(str::to_owned).to_vec();
    let y = Axis { label: "RMSE", floor: bias_floor(report), steps: Steps::Tens };
    (!panels.is_empty()).then(|| side_by_side(names, "value of the setting", y, None, panels))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_front_holds_what_nothing_beats() {
        let points = [[3.0, 0.1], [1.0, 0.5], [2.0, 0.5], [1.0, 0.7], [4.0, 0.0], [5.0, 0.0], [0.5, f64::NAN]];
        assert_eq!(front(points.into_iter()), [[1.0, 0.5], [3.0, 0.1], [4.0, 0.0]]);
        assert_eq!(front([].into_iter()), Vec::<[f64; 2]>::new());
    }

    #[test]
    fn settings_are_shortened() {
        assert_eq!(short("method.samples=64 cloud.0.opacity=0.5"), "samples=64 cloud.0.opacity=0.5");
        assert_eq!(short(""), "");
    }
}
