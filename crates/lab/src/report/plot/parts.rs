//! Parts of a figure.

/// A measured value and its spread.
#[derive(Debug, Clone, PartialEq)]
pub struct Point {
    /// Position on the horizontal axis; above 0.
    pub x: f64,
    /// Position on the vertical axis.
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

    pub(super) fn is_finite(&self) -> bool {
        self.x.is_finite() && self.y.is_finite()
    }
}

/// A line through points.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// Index of the series' name in the figure's legend: decides color and marker.
    pub name: usize,
    /// Points in ascending x.
    pub points: Vec<Point>,
    /// Text beside the series' marker in a corner of the panel; empty for no note.
    pub note: String,
}

impl Series {
    /// A line without a note.
    pub fn new(name: usize, points: impl IntoIterator<Item = Point>) -> Self {
        Self { name, points: points.into_iter().collect(), note: String::new() }
    }
}

/// A single coordinate system.
#[derive(Debug, Clone, PartialEq)]
pub struct Panel {
    /// Stands above it.
    pub title: String,
    /// Lines of the panel.
    pub series: Vec<Series>,
    /// The Pareto front in ascending x: points (x, y) that no other dominates, each marked with a ring. The line
    /// through them falls in steps and separates dominated points from the unreached region. Empty for no front.
    pub front: Vec<[f64; 2]>,
    /// True if it shows the figure's guide.
    pub is_guided: bool,
}

impl Panel {
    /// A panel without a front or a guide.
    pub fn new(title: impl Into<String>, series: impl IntoIterator<Item = Series>) -> Self {
        Self { title: title.into(), series: series.into_iter().collect(), front: Vec::new(), is_guided: false }
    }
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

impl Axis {
    /// A logarithmic axis by powers of 10, with a floor.
    pub const fn tens(label: &'static str, floor: f64) -> Self {
        Self { label, floor, steps: Steps::Tens }
    }

    /// A logarithmic axis by powers of 2.
    pub const fn twos(label: &'static str) -> Self {
        Self { label, floor: 0.0, steps: Steps::Twos }
    }

    /// A linear axis.
    pub const fn even(label: &'static str) -> Self {
        Self { label, floor: 0.0, steps: Steps::Even }
    }
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
    /// Name in the legend.
    pub name: &'static str,
    /// The exponent of its growth in x.
    pub exponent: f64,
}
