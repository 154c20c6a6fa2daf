//! Popping over the frames of a path.

use super::{Curve, FrameError, Popping};
use crate::report::plot::{Axis, Figure, Panel, Point, Series, Steps};

/// Width and height of the figure in pixels.
const SIZE: [u32; 2] = [1140, 420];

/// Quantity that is shown of a change.
#[derive(Debug, Clone, Copy)]
pub(in crate::report) struct Scale {
    /// The label of the axis.
    pub label: &'static str,
    /// Values below are drawn here.
    pub floor: f64,
    /// The value of a frame.
    pub value: fn(&FrameError) -> Option<f64>,
}

/// A line for each method; `None` if there is nothing to show.
pub(in crate::report) fn over_frames(popping: &Popping, scale: Scale) -> Option<Figure> {
    let point = |frame: &FrameError| Some(Point::new(frame.frame.into(), (scale.value)(frame)?));
    let series = |(name, curve): (usize, &Curve)| {
        let points = curve.frames.iter().filter_map(point).collect();
        Series { name, points, note: String::new() }
    };
    let panel = Panel {
        title: String::new(),
        series: popping.curves.iter().enumerate().map(series).collect(),
        front: Vec::new(),
        is_guided: false,
    };
    let figure = Figure {
        x: Axis { label: "frame", floor: 0.0, steps: Steps::Even },
        y: Axis { label: scale.label, floor: scale.floor, steps: Steps::Tens },
        names: popping.curves.iter().map(Curve::name).collect(),
        guide: None,
        front: "",
        panel: SIZE,
        columns: 1,
        panels: vec![panel],
    };
    (popping.frames > 1 && !popping.curves.is_empty()).then_some(figure)
}
