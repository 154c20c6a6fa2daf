//! The figures and their captions.

use maud::{Markup, html};
use pellucid_io::output;

use super::surfaces::figures::{self as surfaces, Over};
use super::{Analytic, Convergence, Errors, Row, Tradeoff};
use crate::report::fit::PowerLaw;
use crate::report::page::Drawn;
use crate::report::plot::{Axis, Figure, Guide, Panel, Point, Series};
use crate::report::{popping, unique};

/// RMSE below is drawn at this value, since 0 has no place on a logarithmic axis: a forty-thousandth of an 8-bit step.
const RMSE_FLOOR: f64 = 1e-7;
/// FLIP below is drawn at this value; it grows faster than small differences do.
const FLIP_FLOOR: f64 = 1e-6;
/// A power law must explain at least this much of the variance.
const LAW_R_SQUARED: f64 = 0.95;
/// Device time below is drawn here, in ms.
const TIME_FLOOR: f64 = 1e-3;

/// All figures that have something to show.
pub(super) fn draw(report: &Tradeoff) -> Result<Vec<Drawn>, output::Error> {
    let over_size = |over| surfaces::over_size(report.surveyed.as_ref()?, &report.rows, over);
    let over_frames = |measure, axis, value| popping::over_frames(report.popping.as_ref()?, measure, axis, value);
    let [rmse, flip] = [Axis::tens("RMSE", RMSE_FLOOR), Axis::tens("FLIP", FLIP_FLOOR)];
    let [rmse_change, flip_change] = ["change of the error, RMSE", "change of the error, FLIP"];
    let figures = [
        ("size-time.svg", over_size(Over::Time)),
        ("size-holes.svg", over_size(Over::Holes)),
        ("size-error.svg", over_size(Over::Error)),
        ("error.svg", Some((error_over_time(report, rmse, |errors| errors.rmse), about_rmse(report)))),
        ("flip.svg", Some((error_over_time(report, flip, |errors| errors.flip), about_flip(report)))),
        ("convergence.svg", convergence(report)),
        ("bias.svg", bias(report)),
        ("popping.svg", over_frames("RMSE", Axis { label: rmse_change, ..rmse }, |frame| frame.rmse)),
        ("popping-flip.svg", over_frames("FLIP", Axis { label: flip_change, ..flip }, |frame| frame.flip)),
    ];
    let drawn = figures.into_iter().filter_map(|(name, figure)| Some((name, figure?)));
    drawn.map(|(name, (figure, caption))| Drawn::new(name, &figure, caption)).collect()
}

fn about_rmse(report: &Tradeoff) -> Markup {
    html! {
        b { "RMSE over device time. " }
        @if report.surveyed.is_some() {
            "Lower left is better. Each cloud has a panel with its own front; the first point of a ladder names the setting that "
            "changes, the last one gives its last value. No image with one sample per pixel is as smooth at edges as the reference, so 0 is out of reach."
        } @else {
            "Lower left is better. Points are medians, bars reach from the shortest to the longest time; the first point "
            "of a ladder names the setting that changes. RMSE below " (power(RMSE_FLOOR)) ", equality included, is drawn there."
        }
    }
}

fn about_flip(report: &Tradeoff) -> Markup {
    html! {
        b { "FLIP over device time, " }
        "which weighs differences as an eye does while the two images alternate. "
        @if report.surveyed.is_some() { "The fronts are those of FLIP." } @else {
            "The front is that of FLIP. Values below " (power(FLIP_FLOOR)) ", equality included, are drawn there."
        }
    }
}

/// Numbers of a caption: powers of ten alone are floors.
fn power(value: f64) -> Markup {
    html! { "10" sup { "−" (-value.log10().round()) } }
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

fn error_over_time(report: &Tradeoff, y: Axis, error: fn(&Errors) -> f64) -> Figure {
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
        Series::new(index(&names, &ladder.rows[0].method), points)
    };
    let all = ladders(report);
    let panel = |title: String, thinning: Option<u32>| {
        let is_in = |row: &Row| thinning.is_none_or(|one_of| row.thinning == one_of);
        let rows = report.rows.iter().filter(|row| is_in(row));
        let front = front(rows.map(|row| [row.gpu_ms.median, error(&row.errors)]));
        Panel { front, ..Panel::new(title, all.iter().filter(|ladder| is_in(ladder.rows[0])).map(series)) }
    };
    let x = Axis::tens("device time of a frame in ms", TIME_FLOOR);
    if let Some(surveyed) = &report.surveyed {
        let of_cloud = |(thinning, points): &(u32, u64)| panel(surfaces::title(*thinning, *points), Some(*thinning));
        let panels = surveyed.clouds.iter().map(of_cloud).collect();
        return surfaces::side_by_side(names.clone(), x, y, panels);
    }
    let panels = vec![panel(String::new(), None)];
    Figure { front: "Pareto front", ..Figure::in_rows(620, names, x, y, panels) }
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

/// Panels of errors over the value of a setting.
fn over_setting(names: Vec<String>, floor: f64, panels: Vec<Panel>) -> Figure {
    Figure::in_rows(400, names, Axis::twos("value of the setting"), Axis::tens("RMSE", floor), panels)
}

/// RMSE over the ladders' settings: one panel for each key, those of stochastic methods first.
fn convergence(report: &Tradeoff) -> Option<(Figure, Markup)> {
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
    // Ladders of one key need not be adjacent.
    let keys = unique(ladders.iter().map(key));
    let series = |ladder: &Ladder<'_>| {
        let method = &ladder.rows[0].method;
        let is_law = |law: &PowerLaw| law.r_squared >= LAW_R_SQUARED;
        let turned = format!("{} {}", key(ladder), ladder.rest);
        let law = |c: &&Convergence| c.method == *method && c.key == turned.trim_end() && is_law(&c.rmse);
        let fitted = report.convergence.iter().find(law);
        let note = fitted.map(|law| format!("slope {}", signed(law.rmse.exponent, 2))).unwrap_or_default();
        let points = ladder.rows.iter().map(|row| Point::new(step(row), row.errors.rmse));
        Series { note, ..Series::new(index(&names, method), points) }
    };
    let panel = |title: &String| {
        let of_key = ladders.iter().filter(|ladder| key(ladder) == *title);
        let is_guided = of_key.clone().any(|ladder| ladder.rows[0].stochastic);
        Panel { is_guided, ..Panel::new(title, of_key.map(series)) }
    };
    let mut panels: Vec<_> = keys.iter().map(panel).collect();
    if let (Some(analytic), Some(panel)) = (&report.analytic, panels.first_mut()) {
        panel.series.extend(blended(analytic, &report.rows, names.len()));
        names.extend(["against alpha blending".to_owned(), "expected of that".to_owned()]);
    }
    let guide = Some(Guide { name: "slope −1/2", exponent: -0.5 });
    let caption = html! {
        b { "RMSE over the setting that changes. " }
        "Errors of independent samples fall parallel to the dashed line. A slope is given where a power law explains "
        (100.0 * LAW_R_SQUARED) " % of the variance. RMSE below " (power(RMSE_FLOOR))
        " is drawn there."
        @if report.analytic.is_some() { " The slope against alpha blending is that of settings that deal no point twice." }
    };
    (!panels.is_empty()).then(|| (Figure { guide, ..over_setting(names, RMSE_FLOOR, panels) }, caption))
}

/// Errors against the analytic image, measured and expected, with names that begin at an index.
fn blended(analytic: &Analytic, rows: &[Row], name: usize) -> [Series; 2] {
    let found: Vec<_> = rows.iter().filter_map(|row| Some((step(row), row.rmse_analytic?))).collect();
    let slope = analytic.slope.map(|law| format!("slope {}", signed(law.exponent, 2)));
    let expected = found.iter().map(|(step, _)| Point::new(*step, analytic.expected(*step)));
    let measured = found.iter().map(|(step, rmse)| Point::new(*step, *rmse));
    // Measured points are drawn on top.
    let measured = Series { note: slope.unwrap_or_default(), ..Series::new(name, measured) };
    [Series::new(name + 1, expected), measured]
}

/// The position of a zero bias: the power of ten below all noise and floors.
fn bias_floor(report: &Tradeoff) -> f64 {
    let repeats = report.rows.iter().filter_map(|row| row.repeats);
    let values = repeats.flat_map(|r| [r.noise, r.bias_floor]).filter(|value| *value > 0.0 && value.is_finite());
    let least = values.fold(1.0, f64::min);
    10f64.powi(least.log10().floor() as i32).max(RMSE_FLOOR)
}

/// Bias and noise over the ladders of stochastic methods: one panel for each.
fn bias(report: &Tradeoff) -> Option<(Figure, Markup)> {
    let panel = |ladder: Ladder<'_>| {
        let repeats = || ladder.rows.iter().filter(|row| step(row) > 0.0).filter_map(|r| Some((step(r), r.repeats?)));
        let (key, _) = ladder.rows[0].step.as_ref()?;
        let series = |name, value: fn(&super::Repeats) -> f64| {
            Series::new(name, repeats().map(|(step, repeats)| Point::new(step, value(&repeats))))
        };
        let series = [series(0, |r| r.noise), series(1, |r| r.bias), series(2, |r| r.bias_floor)];
        let title = format!("{} over {key} {}", ladder.rows[0].method, ladder.rest);
        let has_points = repeats().next().is_some();
        has_points.then(|| Panel::new(title.trim_end(), series))
    };
    let panels: Vec<_> = ladders(report).into_iter().filter_map(panel).collect();
    let names = ["noise of one image", "bias", "floor of the bias"].map(str::to_owned).to_vec();
    let floor = bias_floor(report);
    let caption = html! {
        b { "Noise and bias of stochastic methods. " }
        "Noise decreases with more images, bias stays. The floor is what noise alone leaves in the mean over the seeds: "
        "a bias below it can't be distinguished from none. A bias below " (power(floor)) ", 0 included, is drawn there."
    };
    (!panels.is_empty()).then(|| (over_setting(names, floor, panels), caption))
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
