//! The costs as figures and as a table.

use std::path::Path;

use bytesize::ByteSize;
use pellucid_lab::report::plot::{Axis, Figure, Guide, Panel, Point, Series};

use super::Line;
use super::child::Cost;

/// Width and height in pixels.
const SIZE: [u32; 2] = [520, 340];

/// Value of a cost that is shown.
type Value = fn(&Cost) -> f64;

/// Writes `time.svg` and `memory.svg`.
///
/// # Errors
/// Returns an error if the figures can't be drawn or written.
pub fn write(folder: &Path, lines: &[Line]) -> Result<(), String> {
    std::fs::create_dir_all(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    for (name, label, value) in [
        ("time.svg", "seconds", (|cost| cost.seconds) as Value),
        ("memory.svg", "resident, GiB", |cost| cost.bytes as f64 / f64::from(1 << 30)),
    ] {
        let series = |(name, line): (usize, &Line)| {
            Series::new(name, line.costs.iter().map(|(points, cost)| Point::new(*points, value(cost))))
        };
        let series = lines.iter().enumerate().map(series);
        let panel = Panel { is_guided: label == "seconds", ..Panel::new("", series) };
        let names = lines.iter().map(|line| line.name.clone()).collect();
        let guide = Some(Guide { name: "proportional", exponent: 1.0 });
        let (x, y) = (Axis::tens("points", 1.0), Axis::tens(label, 0.01));
        let figure = Figure { guide, panel: SIZE, ..Figure::in_rows(SIZE[1], names, x, y, vec![panel]) };
        let path = folder.join(name);
        let svg = figure.svg().map_err(|error| format!("{}: {error}", path.display()))?;
        std::fs::write(&path, svg).map_err(|error| format!("{}: {error}", path.display()))?;
    }
    Ok(())
}

/// A table of the costs, and the slopes between the last two sizes.
pub fn markdown(lines: &[Line]) -> String {
    let mut text = String::from("| command | points | seconds | points/s | resident |\n|---|--:|--:|--:|--:|\n");
    for Line { name, costs } in lines {
        for (points, Cost { seconds, bytes }) in costs {
            let rate = points / seconds / 1e6;
            text += &format!("| {name} | {points:e} | {seconds:.1} | {rate:.2} M | {} |\n", ByteSize(*bytes));
        }
    }
    for line in lines {
        if let Some([time, memory]) = slopes(&line.costs) {
            text += &format!("\n{}: time grows as N^{time:.2}, memory as N^{memory:.2}\n", line.name);
        }
    }
    text
}

/// The exponents of time and memory between the last two sizes.
fn slopes(costs: &[(f64, Cost)]) -> Option<[f64; 2]> {
    let [.., (less, before), (more, after)] = costs else { return None };
    let size = (more / less).ln();
    Some([(after.seconds / before.seconds).ln() / size, (after.bytes as f64 / before.bytes as f64).ln() / size])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slopes_are_those_of_the_last_two_sizes() {
        let cost = |seconds, bytes| Cost { seconds, bytes };
        let costs = [(1e6, cost(1.0, 100)), (1e7, cost(5.0, 100)), (1e8, cost(50.0, 200))];
        let [time, memory] = slopes(&costs).unwrap();
        assert!((time - 1.0).abs() < 1e-12 && (memory - 2f64.log10()).abs() < 1e-12, "{time}, {memory}");
        assert_eq!(slopes(&costs[..1]), None);
        let text = markdown(&[Line { name: "points".to_owned(), costs: costs.to_vec() }]);
        assert!(text.contains("| points | 1e8 | 50.0 | 2.00 M | 200 B |"), "{text}");
        assert!(text.contains("time grows as N^1.00, memory as N^0.30"), "{text}");
    }
}
