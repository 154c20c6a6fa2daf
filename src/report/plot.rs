//! Figures: rows and columns of panels with the same two logarithmic axes, as SVG.

use std::error::Error;
use std::ops::Range;

use plotters::coord::Shift;
use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};
use plotters::element::DashedPathElement;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// A measured value and how far it was spread.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    /// On the horizontal axis; above 0.
    pub x: f64,
    /// On the vertical axis.
    pub y: f64,
    /// Least and greatest y, drawn as a bar; both `y` for none.
    pub range: [f64; 2],
}

/// A line through points.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// Which name of the figure's legend it has: decides color and marker.
    pub name: usize,
    /// By ascending x.
    pub points: Vec<Point>,
    /// What stands beside its marker in a corner of the panel; nothing if empty.
    pub note: String,
}

/// One coordinate system.
#[derive(Debug, Clone, PartialEq)]
pub struct Panel {
    /// Stands above it.
    pub title: String,
    /// Its lines.
    pub series: Vec<Series>,
}

/// An axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Axis {
    /// Quantity and unit.
    pub label: &'static str,
    /// Values below are drawn here: 0 has no logarithm.
    pub floor: f64,
    /// Whether it counts by powers of 2 and not of 10.
    pub binary: bool,
}

/// Panels in rows of `columns`, under one legend.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    /// Horizontal axis of every panel.
    pub x: Axis,
    /// Vertical axis of every panel.
    pub y: Axis,
    /// Names of the series.
    pub names: Vec<&'static str>,
    /// What the legend calls a dashed line that grows in proportion to x; no such line if empty.
    pub proportional: &'static str,
    /// Panels in a row.
    pub columns: usize,
    /// Row by row.
    pub panels: Vec<Panel>,
}

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Drawn = Result<(), Box<dyn Error>>;

/// Width and height of a panel and height of the legend, in pixels.
const PANEL: [u32; 2] = [380, 290];
const LEGEND: u32 = 34;
const INK: RGBColor = RGBColor(40, 40, 40);
const GUIDE: RGBColor = RGBColor(120, 120, 120);
/// The palette of Okabe and Ito, which people with any kind of color vision tell apart; the marker is a second sign.
const COLORS: [RGBColor; 6] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
];

impl Figure {
    /// The figure as one SVG element.
    ///
    /// # Errors
    /// What the drawing library says.
    pub fn svg(&self) -> Result<String, Box<dyn Error>> {
        let rows = self.panels.len().div_ceil(self.columns).max(1);
        let size = (PANEL[0] * self.columns as u32, PANEL[1] * rows as u32 + LEGEND);
        let mut text = String::new();
        {
            let root = SVGBackend::with_string(&mut text, size).into_drawing_area();
            root.fill(&WHITE)?;
            self.draw_legend(&root)?;
            let (_, below) = root.split_vertically(LEGEND);
            for (panel, area) in self.panels.iter().zip(below.split_evenly((rows, self.columns))) {
                self.draw_panel(panel, &area, &root)?;
            }
            root.present()?;
        }
        Ok(text)
    }

    fn draw_legend(&self, root: &Area<'_>) -> Drawn {
        let (mut x, y) = (24, LEGEND as i32 / 2);
        let mut entry = |name: &str, draw: &dyn Fn((i32, i32)) -> Drawn| -> Drawn {
            draw((x, y))?;
            root.draw(&Text::new(name.to_owned(), (x + 38, y), text_style(14)))?;
            x += 66 + 8 * name.chars().count() as i32;
            Ok(())
        };
        for (index, name) in self.names.iter().enumerate() {
            entry(name, &|(x, y)| {
                root.draw(&PathElement::new([(x, y), (x + 30, y)], color(index).stroke_width(2)))?;
                draw_marker(root, (x + 15, y), index)
            })?;
        }
        if !self.proportional.is_empty() {
            entry(self.proportional, &|(x, y)| draw_dashed(root, [(x, y), (x + 30, y)]))?;
        }
        Ok(())
    }

    fn draw_panel(&self, panel: &Panel, area: &Area<'_>, root: &Area<'_>) -> Drawn {
        let points = || self.panels.iter().flat_map(|p| &p.series).flat_map(|s| &s.points);
        let x = Scale::new(self.x, points().map(|p| p.x));
        let mut y = Scale::new(self.y, points().flat_map(|p| [p.y, p.range[0], p.range[1]]));
        // Room above the data for the box of notes: a line of it is about a twentieth of a panel's height.
        let notes = |panel: &Panel| panel.series.iter().filter(|series| !series.note.is_empty()).count();
        let lines = self.panels.iter().map(notes).max().unwrap_or(0) as f64;
        y.range.end += (y.range.end - y.range.start) * 0.08 * lines;
        let mut chart = ChartBuilder::on(area)
            .margin(6)
            .margin_right(14)
            .caption(&panel.title, ("sans-serif", 15, &INK))
            .x_label_area_size(38)
            .y_label_area_size(62)
            .build_cartesian_2d(x.clone(), y.clone())?;
        chart
            .configure_mesh()
            .x_desc(self.x.label)
            .y_desc(self.y.label)
            .label_style(("sans-serif", 13, &INK))
            .axis_desc_style(("sans-serif", 14, &INK))
            .axis_style(INK)
            .bold_line_style(RGBColor(215, 215, 215))
            .light_line_style(RGBColor(240, 240, 240))
            .draw()?;
        let at = |px: f64, py: f64| chart.backend_coord(&(x.of(px), y.of(py)));
        if !self.proportional.is_empty()
            && let Some(line) = guide(panel, &x, &y)
        {
            draw_dashed(root, line.map(|(x, y)| chart.backend_coord(&(x, y))))?;
        }
        let (columns, lines) = chart.plotting_area().get_pixel_range();
        let noted: Vec<&Series> = panel.series.iter().filter(|series| !series.note.is_empty()).collect();
        if let Some(longest) = noted.iter().map(|series| series.note.chars().count() as i32).max() {
            // A box of its own, so that its markers are not taken for data, which are drawn over it.
            let corner = (columns.start + 5, lines.start + 3);
            let end = (corner.0 + 30 + 7 * longest, corner.1 + 5 + 17 * noted.len() as i32);
            root.draw(&Rectangle::new([corner, end], WHITE.filled()))?;
            root.draw(&Rectangle::new([corner, end], GUIDE.stroke_width(1)))?;
        }
        for (line, series) in noted.iter().enumerate() {
            let (x, y) = (columns.start + 15, lines.start + 14 + 17 * line as i32);
            draw_marker(root, (x, y), series.name)?;
            root.draw(&Text::new(series.note.clone(), (x + 10, y), text_style(13)))?;
        }
        for series in &panel.series {
            let color = color(series.name);
            let line: Vec<_> = series.points.iter().map(|p| at(p.x, p.y)).collect();
            root.draw(&PathElement::new(line, color.stroke_width(2)))?;
            for p in &series.points {
                root.draw(&PathElement::new(p.range.map(|y| at(p.x, y)), color.stroke_width(1)))?;
                draw_marker(root, at(p.x, p.y), series.name)?;
            }
        }
        if panel.series.iter().all(|series| series.points.is_empty()) {
            let place = (columns.start + 8, lines.start + 12);
            root.draw(&Text::new("nothing measured", place, text_style(13)))?;
        }
        Ok(())
    }
}

/// A line in proportion to x, in logarithms, that ends below the last point of the panel's first series.
fn guide(panel: &Panel, x: &Scale, y: &Scale) -> Option<[(f64, f64); 2]> {
    // So much lower that it does not lie on the data: a factor of 1.6.
    const BELOW: f64 = 0.2;
    let last = panel.series.first()?.points.last()?;
    let decades = |units: f64| units * x.base.log10() / y.base.log10();
    let end = (x.of(last.x), y.of(last.y) - BELOW);
    let run = (end.0 - x.range.start).min((end.1 - y.range.start) / decades(1.0));
    (run > 0.0).then(|| [(end.0 - run, end.1 - decades(run)), end])
}

fn color(index: usize) -> RGBColor {
    COLORS[index % COLORS.len()]
}

fn text_style(size: u32) -> TextStyle<'static> {
    ("sans-serif", size).into_font().color(&INK).pos(Pos::new(HPos::Left, VPos::Center))
}

fn draw_marker(root: &Area<'_>, (x, y): (i32, i32), index: usize) -> Drawn {
    let style = color(index).filled();
    let polygon = |corners: &[(i32, i32)]| {
        Polygon::new(corners.iter().map(|(dx, dy)| (x + dx, y + dy)).collect::<Vec<_>>(), style)
    };
    match index % 4 {
        0 => root.draw(&Circle::new((x, y), 4, style))?,
        1 => root.draw(&polygon(&[(-4, -4), (4, -4), (4, 4), (-4, 4)]))?,
        2 => root.draw(&polygon(&[(0, -5), (5, 4), (-5, 4)]))?,
        _ => root.draw(&polygon(&[(0, -6), (5, 0), (0, 6), (-5, 0)]))?,
    }
    Ok(())
}

fn draw_dashed(root: &Area<'_>, line: [(i32, i32); 2]) -> Drawn {
    root.draw(&DashedPathElement::new(line, 5, 4, GUIDE.stroke_width(1)))?;
    Ok(())
}

/// A logarithmic axis over some values. Its units are powers of the base.
#[derive(Debug, Clone, PartialEq)]
struct Scale {
    base: f64,
    floor: f64,
    range: Range<f64>,
    /// With a label.
    ticks: Vec<f64>,
    /// Without one.
    minor: Vec<f64>,
}

impl Scale {
    /// From the round number (a power of the base; of 10 also twice and five times one) below all values to the one
    /// above, and over one power at least.
    fn new(axis: Axis, values: impl Iterator<Item = f64>) -> Self {
        let base: f64 = if axis.binary { 2.0 } else { 10.0 };
        let floor = axis.floor;
        let logs = values.filter(|v| v.is_finite()).map(|v| v.max(floor).log10() / base.log10());
        let (low, high) =
            logs.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), log| (low.min(log), high.max(log)));
        let (low, high) = if low <= high { (low, high) } else { (0.0, 1.0) };
        let powers = (low.floor() as i32 - 1..=high.ceil() as i32 + 2).map(f64::from);
        let times = |digits: &[f64]| -> Vec<f64> {
            powers.clone().flat_map(|p| digits.iter().map(move |d| p + d.log10()).collect::<Vec<_>>()).collect()
        };
        let round = times(if axis.binary { &[1.0] } else { &[1.0, 2.0, 5.0] });
        // Rounding must not cost a whole step.
        let start = round.iter().copied().filter(|v| *v <= low + 1e-9).fold(low - 1.0, f64::max);
        let end =
            round.iter().copied().filter(|v| *v >= (high - 1e-9).max(start + 1.0 - 1e-9)).fold(high + 2.0, f64::min);
        let within = |v: &f64| *v >= start - 1e-9 && *v <= end + 1e-9;
        // Labels for all round numbers where there are few, for every second power where there are many.
        let whole: Vec<f64> = powers.clone().filter(within).collect();
        let stride = if whole.len() > 9 { 2 } else { 1 };
        let few: Vec<f64> = round.iter().copied().filter(within).collect();
        let ticks = if few.len() <= 9 { few } else { whole.iter().copied().step_by(stride).collect() };
        let digits: Vec<f64> = (1..=9).map(f64::from).collect();
        let minor = times(if axis.binary { &[1.0] } else { &digits }).into_iter().filter(within).collect();
        // The data keep off the frame.
        let margin = 0.03 * (end - start);
        Self { base, floor, range: start - margin..end + margin, ticks, minor }
    }

    fn of(&self, value: f64) -> f64 {
        let lowest = if self.floor > 0.0 { self.floor } else { f64::MIN_POSITIVE };
        value.max(lowest).log10() / self.base.log10()
    }

    fn label(&self, at: f64) -> String {
        let value = self.base.powf(at);
        if (1e-3..1e6).contains(&value) {
            // To three digits: what is left of a logarithm's rounding.
            let digits = (2 - value.log10().floor() as i32).max(0) as usize;
            let text = format!("{value:.digits$}");
            return if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text };
        }
        let exponent = (at * self.base.log10() + 1e-9).floor();
        let mantissa = (value / 10f64.powf(exponent)).round();
        let power = format!("10{}", superscript(exponent as i32));
        if mantissa == 1.0 { power } else { format!("{mantissa}·{power}") }
    }
}

impl Ranged for Scale {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, (from, to): (i32, i32)) -> i32 {
        let share = (value - self.range.start) / (self.range.end - self.range.start);
        from + (share * f64::from(to - from)).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        if hint.weight().allow_light_points() { self.minor.clone() } else { self.ticks.clone() }
    }

    fn range(&self) -> Range<f64> {
        self.range.clone()
    }
}

impl ValueFormatter<f64> for Scale {
    fn format_ext(&self, value: &f64) -> String {
        self.label(*value)
    }
}

fn superscript(number: i32) -> String {
    let digit = |c: char| match c {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        // The others follow one another in Unicode.
        c => c.to_digit(10).and_then(|d| char::from_u32(0x2070 + d)).unwrap_or(c),
    };
    number.to_string().chars().map(digit).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEN: Axis = Axis { label: "time in ms", floor: 0.0, binary: false };
    const TWO: Axis = Axis { label: "layers", floor: 0.0, binary: true };

    fn labels(axis: Axis, values: &[f64]) -> Vec<String> {
        let scale = Scale::new(axis, values.iter().copied());
        scale.ticks.iter().map(|tick| scale.label(*tick)).collect()
    }

    #[test]
    fn axes_reach_around_their_values_in_whole_powers() {
        assert_eq!(labels(TEN, &[0.02, 70_000.0, 3.0]), ["0.1", "1", "10", "100", "1000", "10000", "100000"]);
        assert_eq!(labels(TWO, &[1.0, 64.0]), ["1", "2", "4", "8", "16", "32", "64"]);
        assert_eq!(labels(TWO, &[1.0, 4096.0]), ["1", "4", "16", "64", "256", "1024", "4096"]);
        assert_eq!(labels(TEN, &[8.0, 143.0]), ["5", "10", "20", "50", "100", "200"]);
        assert_eq!(labels(TEN, &[3.0]), ["2", "5", "10", "20"]);
        assert_eq!(labels(TEN, &[]), ["1", "2", "5", "10"]);
        assert_eq!(labels(Axis { floor: 1e-8, ..TEN }, &[0.0, 1e-5]), ["10⁻⁸", "10⁻⁷", "10⁻⁶", "10⁻⁵"]);
        assert_eq!(labels(TEN, &[2e-7]), ["2·10⁻⁷", "5·10⁻⁷", "10⁻⁶", "2·10⁻⁶"]);
        assert_eq!(superscript(-10), "⁻¹⁰");
    }

    #[test]
    fn a_figure_holds_its_texts_and_a_marker_for_each_point() {
        let point = |x: f64| Point { x, y: 3.0 * x, range: [2.0 * x, 4.0 * x] };
        let series = Series { name: 0, points: [1.0, 4.0, 16.0].map(point).to_vec(), note: "slope 1.00".into() };
        let panel = Panel { title: "stack".into(), series: vec![series] };
        let empty = Panel { title: "mosaic".into(), series: Vec::new() };
        let figure = Figure {
            x: TWO,
            y: TEN,
            names: vec!["abuffer"],
            proportional: "in proportion",
            columns: 2,
            panels: vec![panel, empty],
        };
        let svg = figure.svg().unwrap();
        for text in ["stack", "mosaic", "layers", "time in ms", "abuffer", "slope 1.00", "nothing measured", "16"] {
            assert!(svg.contains(&format!("\n{text}\n")), "{text} in {svg}");
        }
        // One in the legend and one beside the note.
        assert_eq!(svg.matches("<circle").count(), 3 + 2);
    }

    #[test]
    fn the_guide_is_parallel_to_what_grows_in_proportion() {
        let (x, y) = (Scale::new(TWO, [1.0, 1024.0].into_iter()), Scale::new(TEN, [0.1, 1000.0].into_iter()));
        let point = Point { x: 1024.0, y: 1000.0, range: [1000.0; 2] };
        let panel =
            Panel { title: String::new(), series: vec![Series { name: 0, points: vec![point], note: String::new() }] };
        let [from, to] = guide(&panel, &x, &y).unwrap();
        let (factor_x, factor_y) = (2f64.powf(to.0 - from.0), 10f64.powf(to.1 - from.1));
        assert!((factor_x / factor_y - 1.0).abs() < 1e-9, "{factor_x} and {factor_y}");
    }
}
