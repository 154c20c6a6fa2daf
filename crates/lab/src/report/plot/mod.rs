//! Figures: rows and columns of panels with the same two axes, mostly logarithmic, as SVG.

mod label;
mod legend;
mod parts;
mod scale;

use std::error::Error;

use plotters::coord::Shift;
use plotters::element::DashedPathElement;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

pub use self::parts::{Axis, Guide, Panel, Point, Series, Steps};

use self::label::Space;
use self::legend::LEGEND;
use self::scale::AxisScale;

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

/// Width of all panels of a row together, in pixels.
const WIDTH: u32 = 1140;
/// Width and height of one of several panels, in pixels.
pub const PANEL: [u32; 2] = [380, 290];
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
    /// Panels of a height, up to three in a row, without a guide or a front.
    pub fn in_rows(height: u32, names: Vec<String>, x: Axis, y: Axis, panels: Vec<Panel>) -> Self {
        let columns = panels.len().clamp(1, 3);
        Self { x, y, names, guide: None, front: "", panel: [WIDTH / columns as u32, height], columns, panels }
    }

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
        let mut labeled: Vec<_> = points.filter(|point| !point.label.is_empty() && point.is_finite()).collect();
        // Long labels are placed first, while space is free.
        labeled.sort_by_key(|point| std::cmp::Reverse(point.label.chars().count()));
        for point in labeled {
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

    /// Returns the scales of both axes, over the points of all panels.
    fn scales(&self) -> (AxisScale, AxisScale) {
        let points = || self.panels.iter().flat_map(|p| &p.series).flat_map(|s| &s.points).filter(|p| p.is_finite());
        let x = AxisScale::new(self.x, points().flat_map(|p| [p.x, p.range_x[0], p.range_x[1]]));
        let mut y = AxisScale::new(self.y, points().flat_map(|p| [p.y, p.range_y[0], p.range_y[1]]));
        // Room above the data for the box of notes: a line of it is 17 pixels, and about 80 are caption and axis.
        let lines = self.panels.iter().map(|panel| notes(panel).count()).max().unwrap_or(0) as f64;
        let line = 17.0 / f64::from(self.panel[1].saturating_sub(80).max(17));
        y.range.end += (y.range.end - y.range.start) * line * lines;
        (x, y)
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
fn guide_line(exponent: f64, panel: &Panel, x: &AxisScale, y: &AxisScale) -> Option<[(f64, f64); 2]> {
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
    // Four markers of six colors repeat after twelve, so the next twelve start with another marker.
    match (index + index / 12) % 4 {
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

#[cfg(test)]
mod tests {
    use super::*;

    pub(super) const TEN: Axis = Axis::tens("time in ms", 0.0);
    pub(super) const TWO: Axis = Axis::twos("layers");

    /// A panel of one series that shows the guide.
    fn guided(title: &str, series: Option<Series>) -> Panel {
        Panel { is_guided: true, ..Panel::new(title, series) }
    }

    fn figure(panels: Vec<Panel>) -> Figure {
        let guide = Some(Guide { name: "in proportion", exponent: 1.0 });
        Figure {
            guide,
            front: "front",
            panel: PANEL,
            columns: 2,
            ..Figure::in_rows(0, vec!["abuffer".into()], TWO, TEN, panels)
        }
    }

    #[test]
    fn a_figure_holds_its_texts_and_a_marker_for_each_point() {
        let point = |x: f64| Point { range_y: [2.0 * x, 4.0 * x], label: format!("{x} MiB"), ..Point::new(x, 3.0 * x) };
        let series = Series { note: "slope 1.00".into(), ..Series::new(0, [1.0, 4.0, 16.0].map(point)) };
        let svg = figure(vec![guided("stack", Some(series)), guided("mosaic", None)]).svg().unwrap();
        let texts = ["stack", "mosaic", "layers", "time in ms", "abuffer", "slope 1.00", "nothing measured", "16"];
        for text in texts.into_iter().chain(["1 MiB", "4 MiB", "16 MiB"]) {
            assert!(svg.contains(&format!("\n{text}\n")), "{text} in {svg}");
        }
        // Two more: one in the legend, one beside the note.
        assert_eq!(svg.matches("<circle").count(), 3 + 2);
        assert!(!svg.contains("\nfront\n"));
    }

    #[test]
    fn two_dozen_series_differ_in_color_or_marker() {
        let marker = |index: usize| {
            let mut svg = String::new();
            let root = SVGBackend::with_string(&mut svg, (20, 20)).into_drawing_area();
            draw_marker(&root, (10, 10), index).unwrap();
            root.present().unwrap();
            drop(root);
            svg
        };
        let all: std::collections::HashSet<String> = (0..24).map(marker).collect();
        assert_eq!(all.len(), 24);
    }

    #[test]
    fn points_that_are_not_numbers_are_left_out_and_a_front_gets_rings() {
        let points = [Point::new(1.0, 2.0), Point::new(f64::NAN, 1.0), Point::new(4.0, f64::INFINITY)];
        let panel = Panel { front: vec![[1.0, 2.0]], ..guided("", Some(Series::new(0, points))) };
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
        let (x, y) = (AxisScale::new(TWO, [1.0, 1024.0].into_iter()), AxisScale::new(TEN, [0.1, 1000.0].into_iter()));
        for (exponent, last) in [(1.0, 1000.0), (-0.5, 1.0), (-0.5, 300.0)] {
            let point = Point::new(1024.0, last);
            let panel = guided("", Some(Series::new(0, [point])));
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
