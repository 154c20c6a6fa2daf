//! Figures: rows and columns of panels with the same two axes, mostly logarithmic, as SVG.

mod label;

use std::error::Error;
use std::ops::Range;

use plotters::coord::Shift;
use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};
use plotters::element::DashedPathElement;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use label::Space;

/// A measured value and how far it was spread.
#[derive(Debug, Clone, PartialEq)]
pub struct Point {
    /// On the horizontal axis; above 0.
    pub x: f64,
    /// On the vertical axis.
    pub y: f64,
    /// Least and greatest x, drawn as a bar; both equal `x` to draw no bar.
    pub range_x: [f64; 2],
    /// Least and greatest y, drawn as a bar; both equal `y` to draw no bar.
    pub range_y: [f64; 2],
    /// Text near the marker, if space permits; empty for no label.
    pub label: String,
}

impl Point {
    /// A point alone.
    pub fn new(x: f64, y: f64) -> Self {
        Self { x, y, range_x: [x; 2], range_y: [y; 2], label: String::new() }
    }

    fn is_finite(&self) -> bool {
        self.x.is_finite() && self.y.is_finite()
    }
}

/// A line through points.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// Which name of the figure's legend it has: decides color and marker.
    pub name: usize,
    /// In ascending x.
    pub points: Vec<Point>,
    /// Text beside the series' marker in a corner of the panel; empty for no note.
    pub note: String,
}

/// A single coordinate system.
#[derive(Debug, Clone, PartialEq)]
pub struct Panel {
    /// Stands above it.
    pub title: String,
    /// Its lines.
    pub series: Vec<Series>,
    /// The Pareto front in ascending x: points (x, y) that no other dominates, each marked with a ring. The line
    /// through them falls in steps and separates dominated points from the unreached region. Empty for no front.
    pub front: Vec<[f64; 2]>,
    /// True if it shows the figure's guide.
    pub is_guided: bool,
}

/// An axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Axis {
    /// Quantity and unit.
    pub label: &'static str,
    /// Values below are drawn here: 0 has no logarithm.
    pub floor: f64,
    /// The spacing of the ticks.
    pub steps: Steps,
}

/// The scale of an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Steps {
    /// Logarithmic, by powers of 10.
    Tens,
    /// Logarithmic, by powers of 2.
    Twos,
    /// Linear, like time on a path; a floor has no effect.
    Even,
}

/// A straight line below the last point of a panel's first series, for the eye to compare slopes with.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Guide {
    /// Its name in the legend.
    pub name: &'static str,
    /// The exponent of its growth in x.
    pub exponent: f64,
}

/// Panels in rows of `columns`, under one legend.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    /// Horizontal axis of every panel.
    pub x: Axis,
    /// Vertical axis of every panel.
    pub y: Axis,
    /// Names of the series.
    pub names: Vec<String>,
    /// A dashed line in panels that want it.
    pub guide: Option<Guide>,
    /// The name of the front's line in the legend.
    pub front: &'static str,
    /// Width and height of a panel in pixels.
    pub panel: [u32; 2],
    /// Number of panels per row.
    pub columns: usize,
    /// Row by row.
    pub panels: Vec<Panel>,
}

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Drawn = Result<(), Box<dyn Error>>;

/// Width and height of one of several panels, in pixels.
pub const PANEL: [u32; 2] = [380, 290];
/// Height of the legend's first line and of each further one, in pixels.
const LEGEND: u32 = 34;
const LEGEND_LINE: u32 = 22;
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
    /// The drawing library fails.
    pub fn svg(&self) -> Result<String, Box<dyn Error>> {
        let rows = self.panels.len().div_ceil(self.columns).max(1);
        let width = self.panel[0] * self.columns as u32;
        let entries = self.legend(width as i32);
        let lines = entries.last().map_or(0, |(_, (_, y))| *y) as u32;
        let legend = lines + LEGEND / 2;
        let mut text = String::new();
        {
            let root =
                SVGBackend::with_string(&mut text, (width, self.panel[1] * rows as u32 + legend)).into_drawing_area();
            root.fill(&WHITE)?;
            for (entry, place) in &entries {
                entry.draw(&root, *place)?;
            }
            let (_, below) = root.split_vertically(legend);
            for (panel, area) in self.panels.iter().zip(below.split_evenly((rows, self.columns))) {
                self.draw_panel(panel, &area, &root)?;
            }
            root.present()?;
        }
        Ok(text)
    }

    /// The legend's entries and their places, line by line.
    fn legend(&self, width: i32) -> Vec<(Entry<'_>, (i32, i32))> {
        let names = self.names.iter().enumerate().map(|(index, name)| Entry { name, sign: Sign::Series(index) });
        let guide = self.guide.iter().map(|guide| Entry { name: guide.name, sign: Sign::Guide });
        let has_front = self.panels.iter().any(|panel| !panel.front.is_empty());
        let front = has_front.then_some(Entry { name: self.front, sign: Sign::Front });
        let (mut x, mut y) = (24, LEGEND as i32 / 2);
        let place = |entry: Entry<'_>| {
            let needed = 66 + 8 * entry.name.chars().count() as i32;
            if x > 24 && x + needed > width {
                (x, y) = (24, y + LEGEND_LINE as i32);
            }
            let place = (x, y);
            x += needed;
            place
        };
        let entries: Vec<_> = names.chain(guide).chain(front).collect();
        let places: Vec<_> = entries.iter().copied().map(place).collect();
        entries.into_iter().zip(places).collect()
    }

    fn draw_panel(&self, panel: &Panel, area: &Area<'_>, root: &Area<'_>) -> Drawn {
        let (x, y) = self.scales();
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
        let at = |px: f64, py: f64| chart.backend_coord(&(x.position(px), y.position(py)));
        if let Some(line) =
            self.guide.filter(|_| panel.is_guided).and_then(|guide| guide_line(guide.exponent, panel, &x, &y))
        {
            draw_dashed(root, line.map(|(x, y)| chart.backend_coord(&(x, y))))?;
        }
        let (columns, lines) = chart.plotting_area().get_pixel_range();
        let mut space = Space::new([columns.start, lines.start, columns.end, lines.end]);
        if let Some(corner) = draw_notes(panel, root, (columns.start, lines.start))? {
            space.take(corner);
        }
        let front: Vec<_> = panel.front.iter().map(|[x, y]| at(*x, *y)).collect();
        let steps = steps(&front, columns.end, lines.start);
        root.draw(&PathElement::new(steps.clone(), GUIDE.stroke_width(2)))?;
        let mut lines_drawn = vec![steps];
        for series in &panel.series {
            let color = color(series.name);
            let finite = || series.points.iter().filter(|point| point.is_finite());
            let line: Vec<_> = finite().map(|p| at(p.x, p.y)).collect();
            root.draw(&PathElement::new(line.clone(), color.stroke_width(2)))?;
            lines_drawn.push(line);
            for p in finite() {
                for bar in [p.range_y.map(|y| at(p.x, y)), p.range_x.map(|x| at(x, p.y))] {
                    root.draw(&PathElement::new(bar, color.stroke_width(1)))?;
                    lines_drawn.push(bar.to_vec());
                }
                draw_marker(root, at(p.x, p.y), series.name)?;
                space.take_marker(at(p.x, p.y));
            }
        }
        for place in &front {
            root.draw(&Circle::new(*place, 9, INK.stroke_width(1)))?;
            space.take_ring(*place);
        }
        for line in lines_drawn.iter().flat_map(|line| line.windows(2)) {
            space.avoid([line[0], line[1]]);
        }
        let points = panel.series.iter().flat_map(|series| &series.points);
        let mut labelled: Vec<_> = points.filter(|point| !point.label.is_empty() && point.is_finite()).collect();
        // Long labels are placed first, while space is free.
        labelled.sort_by_key(|point| std::cmp::Reverse(point.label.chars().count()));
        for point in labelled {
            let marker = at(point.x, point.y);
            let Some(placed) = space.place(marker, &point.label) else { continue };
            if let Some(end) = placed.tie {
                root.draw(&PathElement::new([marker, end], INK.stroke_width(1)))?;
            }
            let [left, top, right, bottom] = placed.rectangle;
            // A line behind is faint there.
            root.draw(&Rectangle::new([(left, top + 2), (right, bottom - 2)], WHITE.mix(0.75).filled()))?;
            root.draw(&Text::new(point.label.clone(), placed.text, text_style(12)))?;
        }
        if panel.series.iter().all(|series| series.points.is_empty()) {
            let place = (columns.start + 8, lines.start + 12);
            root.draw(&Text::new("nothing measured", place, text_style(13)))?;
        }
        Ok(())
    }

    /// Both axes, over the points of all panels.
    fn scales(&self) -> (Scale, Scale) {
        let points = || self.panels.iter().flat_map(|p| &p.series).flat_map(|s| &s.points).filter(|p| p.is_finite());
        let x = Scale::new(self.x, points().flat_map(|p| [p.x, p.range_x[0], p.range_x[1]]));
        let mut y = Scale::new(self.y, points().flat_map(|p| [p.y, p.range_y[0], p.range_y[1]]));
        // Room above the data for the box of notes: a line of it is 17 pixels, and about 80 are caption and axis.
        let lines = self.panels.iter().map(|panel| notes(panel).count()).max().unwrap_or(0) as f64;
        let line = 17.0 / f64::from(self.panel[1].saturating_sub(80).max(17));
        y.range.end += (y.range.end - y.range.start) * line * lines;
        (x, y)
    }
}

/// A line of a legend.
#[derive(Debug, Clone, Copy)]
struct Entry<'a> {
    name: &'a str,
    sign: Sign,
}

#[derive(Debug, Clone, Copy)]
enum Sign {
    Series(usize),
    Guide,
    Front,
}

impl Entry<'_> {
    fn draw(&self, root: &Area<'_>, (x, y): (i32, i32)) -> Drawn {
        let line = [(x, y), (x + 30, y)];
        match self.sign {
            Sign::Series(index) => {
                root.draw(&PathElement::new(line, color(index).stroke_width(2)))?;
                draw_marker(root, (x + 15, y), index)?;
            }
            Sign::Guide => draw_dashed(root, line)?,
            Sign::Front => {
                root.draw(&PathElement::new(line, GUIDE.stroke_width(2)))?;
                root.draw(&Circle::new((x + 15, y), 9, INK.stroke_width(1)))?;
            }
        }
        root.draw(&Text::new(self.name.to_owned(), (x + 38, y), text_style(14)))?;
        Ok(())
    }
}

fn notes(panel: &Panel) -> impl Iterator<Item = &Series> {
    panel.series.iter().filter(|series| !series.note.is_empty())
}

/// Draws the notes of a panel's series in a box at its corner. Returns the box, if any.
fn draw_notes(panel: &Panel, root: &Area<'_>, (left, top): (i32, i32)) -> Result<Option<[i32; 4]>, Box<dyn Error>> {
    let Some(longest) = notes(panel).map(|series| series.note.chars().count() as i32).max() else {
        return Ok(None);
    };
    // A separate box, so that its markers are not mistaken for data; the data are drawn over it.
    let corner = (left + 5, top + 3);
    let end = (corner.0 + 30 + 7 * longest, corner.1 + 5 + 17 * notes(panel).count() as i32);
    root.draw(&Rectangle::new([corner, end], WHITE.filled()))?;
    root.draw(&Rectangle::new([corner, end], GUIDE.stroke_width(1)))?;
    for (line, series) in notes(panel).enumerate() {
        let (x, y) = (left + 15, top + 14 + 17 * line as i32);
        draw_marker(root, (x, y), series.name)?;
        root.draw(&Text::new(series.note.clone(), (x + 10, y), text_style(13)))?;
    }
    Ok(Some([corner.0, corner.1, end.0, end.1]))
}

/// The line that falls in steps through the points of a front, from the panel's top to its right end.
fn steps(front: &[(i32, i32)], right: i32, top: i32) -> Vec<(i32, i32)> {
    let mut line = Vec::new();
    let mut before = top;
    for &(x, y) in front {
        line.extend([(x, before), (x, y)]);
        before = y;
    }
    if !front.is_empty() {
        line.push((right, before));
    }
    line
}

/// A line of a given slope, in logarithms, that ends below the last point of the panel's first series.
fn guide_line(exponent: f64, panel: &Panel, x: &Scale, y: &Scale) -> Option<[(f64, f64); 2]> {
    // Distance below the data, a factor of 1.6.
    const BELOW: f64 = 0.2;
    let last = panel.series.first()?.points.iter().rev().find(|point| point.is_finite())?;
    let rise = exponent * x.base.log10() / y.base.log10();
    let end = (x.position(last.x), y.position(last.y) - BELOW);
    // Until the panel's left, lower or upper end.
    let bound = if exponent > 0.0 { y.range.start } else { y.range.end };
    let run = (end.0 - x.range.start).min((end.1 - bound) / rise);
    (run > 0.0).then_some([(end.0 - run, end.1 - run * rise), end])
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

/// An axis over some values. Its units are powers of the base; without one they are the values.
#[derive(Debug, Clone, PartialEq)]
struct Scale {
    base: f64,
    is_even: bool,
    floor: f64,
    range: Range<f64>,
    /// Labelled ticks.
    ticks: Vec<f64>,
    /// Without one.
    minor: Vec<f64>,
    /// True if values below the floor are drawn at the floor.
    is_floored: bool,
}

impl Scale {
    /// From the round number (a power of the base; of 10 also twice and five times one) below all values to the one
    /// above, and over one power at least.
    fn new(axis: Axis, values: impl Iterator<Item = f64>) -> Self {
        let binary = match axis.steps {
            Steps::Even => return Self::even(values),
            steps => steps == Steps::Twos,
        };
        let base: f64 = if binary { 2.0 } else { 10.0 };
        let floor = axis.floor;
        let values: Vec<f64> = values.filter(|v| v.is_finite()).collect();
        let is_floored = values.iter().any(|v| *v < floor);
        let logs = values.iter().map(|v| v.max(floor).log10() / base.log10());
        let (low, high) =
            logs.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), log| (low.min(log), high.max(log)));
        let (low, high) = if low <= high { (low, high) } else { (0.0, 1.0) };
        let powers = (low.floor() as i32 - 1..=high.ceil() as i32 + 2).map(f64::from);
        let times = |digits: &[f64]| -> Vec<f64> {
            powers.clone().flat_map(|p| digits.iter().map(move |d| p + d.log10()).collect::<Vec<_>>()).collect()
        };
        let round = times(if binary { &[1.0] } else { &[1.0, 2.0, 5.0] });
        // Rounding must not cost a whole step.
        let start = round.iter().copied().filter(|v| *v <= low + 1e-9).fold(low - 1.0, f64::max);
        let end =
            round.iter().copied().filter(|v| *v >= (high - 1e-9).max(start + 1.0 - 1e-9)).fold(high + 2.0, f64::min);
        let within = |v: &f64| *v >= start - 1e-9 && *v <= end + 1e-9;
        // Every round number gets a label if they are few, else every second power.
        let whole: Vec<f64> = powers.clone().filter(within).collect();
        let stride = if whole.len() > 9 { 2 } else { 1 };
        let few: Vec<f64> = round.iter().copied().filter(within).collect();
        let ticks = if few.len() <= 9 { few } else { whole.iter().copied().step_by(stride).collect() };
        let digits: Vec<f64> = (1..=9).map(f64::from).collect();
        let minor = times(if binary { &[1.0] } else { &digits }).into_iter().filter(within).collect();
        // The data keep off the frame.
        let margin = 0.03 * (end - start);
        Self { base, is_even: false, floor, range: start - margin..end + margin, ticks, minor, is_floored }
    }

    /// From 0, or the least value, to the greatest, in at most ten round steps.
    fn even(values: impl Iterator<Item = f64>) -> Self {
        let (low, high) = values.filter(|v| v.is_finite()).fold((0f64, 0f64), |(l, h), v| (l.min(v), h.max(v)));
        let span = if high > low { high - low } else { 1.0 };
        let power = 10f64.powf((span / 10.0).log10().floor());
        let step = [1.0, 2.0, 5.0, 10.0].map(|digit| digit * power).into_iter().find(|step| *step >= span / 10.0);
        let step = step.unwrap_or(10.0 * power);
        let (first, last) = ((low / step).floor() as i64, ((low + span) / step).ceil() as i64);
        let ticks: Vec<f64> = (first..=last).map(|tick| tick as f64 * step).collect();
        let (start, end) = (first as f64 * step, last as f64 * step);
        let margin = 0.03 * (end - start);
        let (range, minor) = (start - margin..end + margin, ticks.clone());
        Self { base: 10.0, is_even: true, floor: 0.0, range, ticks, minor, is_floored: false }
    }

    fn position(&self, value: f64) -> f64 {
        if self.is_even {
            return value;
        }
        let lowest = if self.floor > 0.0 { self.floor } else { f64::MIN_POSITIVE };
        value.max(lowest).log10() / self.base.log10()
    }

    fn label(&self, at: f64) -> String {
        let number = self.number(at);
        if self.is_floored && (at - self.position(self.floor)).abs() < 1e-9 { format!("≤ {number}") } else { number }
    }

    fn number(&self, at: f64) -> String {
        if self.is_even {
            // Round to nine digits, which removes the rounding errors of the steps.
            return format!("{}", (at * 1e9).round() / 1e9);
        }
        let value = self.base.powf(at);
        if (1e-3..1e6).contains(&value) {
            // Round to three digits, which removes the rounding errors of the logarithm.
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

    const TEN: Axis = Axis { label: "time in ms", floor: 0.0, steps: Steps::Tens };
    const TWO: Axis = Axis { label: "layers", floor: 0.0, steps: Steps::Twos };

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
        assert_eq!(labels(Axis { floor: 1e-8, ..TEN }, &[0.0, 1e-5]), ["≤ 10⁻⁸", "10⁻⁷", "10⁻⁶", "10⁻⁵"]);
        assert_eq!(labels(Axis { floor: 1e-8, ..TEN }, &[1e-8, 1e-5]), ["10⁻⁸", "10⁻⁷", "10⁻⁶", "10⁻⁵"]);
        let even = Axis { steps: Steps::Even, ..TEN };
        assert_eq!(labels(even, &[3.0, 59.0]), ["0", "10", "20", "30", "40", "50", "60"]);
        assert_eq!(labels(even, &[0.25]), ["0", "0.05", "0.1", "0.15", "0.2", "0.25"]);
        assert_eq!(labels(even, &[]), ["0", "0.1", "0.2", "0.3", "0.4", "0.5", "0.6", "0.7", "0.8", "0.9", "1"]);
        assert_eq!(labels(TEN, &[2e-7]), ["2·10⁻⁷", "5·10⁻⁷", "10⁻⁶", "2·10⁻⁶"]);
        assert_eq!(superscript(-10), "⁻¹⁰");
    }

    fn series(name: usize, points: impl IntoIterator<Item = Point>) -> Series {
        Series { name, points: points.into_iter().collect(), note: String::new() }
    }

    fn figure(panels: Vec<Panel>) -> Figure {
        Figure {
            x: TWO,
            y: TEN,
            names: vec!["abuffer".into()],
            guide: Some(Guide { name: "in proportion", exponent: 1.0 }),
            front: "front",
            panel: PANEL,
            columns: 2,
            panels,
        }
    }

    #[test]
    fn a_figure_holds_its_texts_and_a_marker_for_each_point() {
        let point = |x: f64| Point { range_y: [2.0 * x, 4.0 * x], label: format!("{x} MiB"), ..Point::new(x, 3.0 * x) };
        let series = Series { note: "slope 1.00".into(), ..series(0, [1.0, 4.0, 16.0].map(point)) };
        let panel = Panel { title: "stack".into(), series: vec![series], front: Vec::new(), is_guided: true };
        let empty = Panel { title: "mosaic".into(), series: Vec::new(), front: Vec::new(), is_guided: true };
        let svg = figure(vec![panel, empty]).svg().unwrap();
        let texts = ["stack", "mosaic", "layers", "time in ms", "abuffer", "slope 1.00", "nothing measured", "16"];
        for text in texts.into_iter().chain(["1 MiB", "4 MiB", "16 MiB"]) {
            assert!(svg.contains(&format!("\n{text}\n")), "{text} in {svg}");
        }
        // Two more: one in the legend, one beside the note.
        assert_eq!(svg.matches("<circle").count(), 3 + 2);
        assert!(!svg.contains("\nfront\n"));
    }

    #[test]
    fn what_is_not_a_number_is_left_out_and_a_front_gets_rings() {
        let points = [Point::new(1.0, 2.0), Point::new(f64::NAN, 1.0), Point::new(4.0, f64::INFINITY)];
        let panel =
            Panel { title: String::new(), series: vec![series(0, points)], front: vec![[1.0, 2.0]], is_guided: true };
        let svg = figure(vec![panel]).svg().unwrap();
        // Marker and ring, here and in the legend.
        assert_eq!(svg.matches("<circle").count(), 2 + 2);
        assert!(svg.contains("\nfront\n"));
    }

    #[test]
    fn a_long_legend_goes_on_below() {
        let mut figure = figure(Vec::new());
        figure.names = (0..9).map(|index| format!("method number {index}")).collect();
        let entries = figure.legend(760);
        assert!(entries.iter().all(|(entry, (x, _))| *x + 66 + 8 * entry.name.len() as i32 <= 760), "{entries:?}");
        let unique: std::collections::BTreeSet<_> = entries.iter().map(|(_, place)| place).collect();
        assert_eq!(unique.len(), 10);
    }

    #[test]
    fn a_front_falls_in_steps() {
        assert_eq!(steps(&[(2, 5), (4, 9)], 10, 1), [(2, 1), (2, 5), (4, 5), (4, 9), (10, 9)]);
        assert_eq!(steps(&[], 10, 1), []);
    }

    #[test]
    fn the_guide_has_its_slope() {
        let (x, y) = (Scale::new(TWO, [1.0, 1024.0].into_iter()), Scale::new(TEN, [0.1, 1000.0].into_iter()));
        for (exponent, last) in [(1.0, 1000.0), (-0.5, 1.0), (-0.5, 300.0)] {
            let point = Point::new(1024.0, last);
            let panel =
                Panel { title: String::new(), series: vec![series(0, [point])], front: Vec::new(), is_guided: true };
            let [from, to] = guide_line(exponent, &panel, &x, &y).unwrap();
            let (factor_x, factor_y) = (2f64.powf(to.0 - from.0), 10f64.powf(to.1 - from.1));
            assert!((factor_x.powf(exponent) / factor_y - 1.0).abs() < 1e-9, "{factor_x} and {factor_y}");
            let is_within = |(px, py): (f64, f64)| {
                px >= x.range.start - 1e-9 && py >= y.range.start - 1e-9 && py <= y.range.end + 1e-9
            };
            assert!(is_within(from) && is_within(to), "{from:?} to {to:?}");
        }
    }
}
