//! Figures of opaque points: a panel for each cloud, with all points and with fewer.

use maud::{Markup, html};

use crate::report::plot::{Axis, Figure, Panel, Point, Series};
use crate::report::tradeoff::{Row, Surveyed};
use crate::report::unique;

/// Device time below is drawn here, in ms.
const TIME_FLOOR: f64 = 1e-3;

/// The quantity shown over the size of splats.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in super::super) enum Over {
    Time,
    Holes,
    Error,
}

/// Time, holes or error over the size factor, and the caption; `None` if no splats were measured. Methods without a
/// size are a horizontal line: points of one pixel, and `image-space` with one iteration of each filter.
pub(in super::super) fn over_size(surveyed: &Surveyed, rows: &[Row], over: Over) -> Option<(Figure, Markup)> {
    let has_size = |row: &&Row| row.step.as_ref().is_some_and(|(key, _)| key == "size");
    let sized: Vec<&Row> = rows.iter().filter(has_size).collect();
    let names = names(rows.iter());
    let sizes = || sized.iter().filter_map(|row| row.step.as_ref()).map(|(_, size)| *size);
    let (least, largest) = sizes().fold((f64::INFINITY, 0f64), |(l, h), size| (l.min(size), h.max(size)));
    let is_across = |row: &Row| row.step.as_ref().is_none_or(|(key, value)| key != "size" && *value == 1.0);
    let value = |row: &Row| match over {
        Over::Time => row.gpu_ms.median,
        Over::Holes => row.holes.unwrap_or(f64::NAN),
        Over::Error => row.rmse_inside.unwrap_or(f64::NAN),
    };
    let points = |row: &Row| {
        let y = value(row);
        let range_y = if over == Over::Time { [row.gpu_ms.min, row.gpu_ms.max] } else { [y; 2] };
        let point = |size| Point { range_y, ..Point::new(size, y) };
        match &row.step {
            Some((key, size)) if key == "size" => vec![point(*size)],
            _ if is_across(row) => vec![point(least), point(largest)],
            _ => Vec::new(),
        }
    };
    let panel = |(thinning, count): &(u32, u64)| {
        let series = names.iter().enumerate().map(|(name, method)| {
            let rows = rows.iter().filter(|row| row.thinning == *thinning && row.method == *method);
            Series::new(name, rows.flat_map(points))
        });
        Panel::new(title(*thinning, *count), series)
    };
    let y = match over {
        Over::Time => Axis::tens("device time in ms", TIME_FLOOR),
        // No holes at all are drawn as half a pixel of the silhouette.
        Over::Holes => Axis::tens("share of holes", 0.5 / surveyed.silhouette.max(1) as f64),
        Over::Error => Axis::tens("RMSE inside the silhouette", 0.0),
    };
    let panels: Vec<Panel> = surveyed.clouds.iter().map(panel).collect();
    (!sized.is_empty()).then(|| (side_by_side(names, Axis::even("size factor"), y, panels), caption(over)))
}

fn caption(over: Over) -> Markup {
    match over {
        Over::Time => html! {
            b { "Device time over the size factor, " }
            "as in Fig. 8 of Schütz and Wimmer (2015), but with times instead of frames per second: lower is better. Size 0 draws one pixel, "
            "size 1 the radius of each point. Points of one pixel, and image-space with one iteration of its filters, have no size and are "
            "horizontal lines. Bars reach from the shortest to the longest time."
        },
        Over::Holes => html! {
            b { "Holes over the size factor: " }
            "the share of the silhouette's pixels on which nothing is drawn. No holes at all appear as half a pixel, the least value."
        },
        Over::Error => html! {
            b { "RMSE inside the silhouette over the size factor. " }
            "Small points leave holes, and large points hide each other; the least error lies between. This figure leaves out how far splats reach "
            "over the outline; the figures above include it."
        },
    }
}

/// The title of a cloud's panel.
pub(in super::super) fn title(thinning: u32, points: u64) -> String {
    match thinning {
        1 => format!("all {points} points"),
        one_of => format!("1 of {one_of}: {points} points"),
    }
}

/// Methods in the order of their rows.
pub(in super::super) fn names<'a>(rows: impl Iterator<Item = &'a Row>) -> Vec<String> {
    unique(rows.map(|row| row.method.clone()))
}

/// A figure with panels in a row.
pub(in super::super) fn side_by_side(names: Vec<String>, x: Axis, y: Axis, panels: Vec<Panel>) -> Figure {
    Figure { front: "Pareto front of the cloud", ..Figure::in_rows(430, names, x, y, panels) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::tradeoff::surfaces::findings::tests::made;

    #[test]
    fn a_line_for_each_method_in_each_cloud() {
        let mut rows: Vec<Row> = [0.0, 1.0, 2.0].map(|size| made("circles", 1, size, 1.0 + size, 0.1, 0.0)).into();
        rows.push(made("circles", 4, 1.0, 0.5, 0.2, 0.01));
        rows.push(Row { step: None, ..made("points", 1, 0.0, 0.7, 0.3, 0.5) });
        rows.extend([1.0, 2.0].map(|count| {
            let row = made("image-space", 1, count, 3.0, 0.1, 0.0);
            Row { step: Some(("fill+occlusion".into(), count)), ..row }
        }));
        let surveyed = Surveyed { samples_across: 4, silhouette: 100, clouds: vec![(1, 80), (4, 20)] };
        let (figure, _) = over_size(&surveyed, &rows, Over::Holes).unwrap();
        assert_eq!(figure.names, ["circles", "points", "image-space"]);
        let places = |panel: usize, series: usize| {
            figure.panels[panel].series[series].points.iter().map(|p| [p.x, p.y]).collect::<Vec<_>>()
        };
        assert_eq!(places(0, 0), [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]]);
        assert_eq!((places(0, 1), places(0, 2)), (vec![[0.0, 0.5], [2.0, 0.5]], vec![[0.0, 0.0], [2.0, 0.0]]));
        assert_eq!((places(1, 0), places(1, 1)), (vec![[1.0, 0.01]], vec![]));
        assert_eq!((figure.panels[1].title.as_str(), figure.y.floor), ("1 of 4: 20 points", 0.005));
        assert!(figure.svg().unwrap().contains("\nall 80 points\n"));
        assert!(over_size(&surveyed, &rows[4..], Over::Time).is_none());
    }
}
