//! Times as ratios beside the paper's, and straight lines through them.

use std::fmt::Write;

/// Measurements of a cloud at a size: local illumination, 3 and 6 layers, shadows of 1, 5 and 10 samples.
pub const COLUMNS: usize = 6;

/// Row of the table.
pub struct Line {
    pub name: &'static str,
    pub points: usize,
    /// Side of the image in pixels.
    pub side: u32,
    /// Median device times in ms, in the order of the columns.
    pub ms: Vec<f64>,
    /// The paper's frames per second, in the same order.
    pub paper: [f64; COLUMNS],
}

/// The table.
pub fn markdown(lines: &[Line]) -> String {
    let mut text = String::from(
        "| data | points | image | local, ms | 3 layers | paper | 6 layers | paper | 1 sample | paper | 5 samples | paper | 10 \
         samples | paper |\n|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|\n",
    );
    for Line { name, points, side, ms, paper } in lines {
        let _ = write!(text, "| {name} | {points} | {side}² | {:.2} |", ms[0]);
        for (ms_of, rate) in ms.iter().zip(paper).skip(1) {
            // Frame rates the other way round: how many times as long a frame takes.
            let _ = write!(text, " {:.2} | {:.2} |", ms_of / ms[0], paper[0] / rate);
        }
        text.push('\n');
    }
    text + "\nTimes of a frame over that with local illumination; beside them the ratios of the paper's frame rates (Table 3)."
}

/// y = at 0 + slope · x, by least squares.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fit {
    pub slope: f64,
    pub at_zero: f64,
    /// Share of the variance of y that the line explains.
    pub r_squared: f64,
}

impl Fit {
    /// Fits a line through at least two points with different x.
    pub fn through(points: &[(f64, f64)]) -> Self {
        let n = points.len() as f64;
        let mean = |of: fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / n;
        let (x, y) = (mean(|p| p.0), mean(|p| p.1));
        let sum = |of: &dyn Fn(f64, f64) -> f64| points.iter().map(|p| of(p.0 - x, p.1 - y)).sum::<f64>();
        let (xx, xy, yy) = (sum(&|a, _| a * a), sum(&|a, b| a * b), sum(&|_, b| b * b));
        let slope = xy / xx;
        let r_squared = if yy > 0.0 { xy * xy / (xx * yy) } else { 1.0 };
        Self { slope, at_zero: y - slope * x, r_squared }
    }

    /// Formats the fit as a sentence that says whether it is a line.
    pub fn told(&self, over: &str, each: &str, claim: &str) -> String {
        let Self { slope, at_zero, r_squared } = self;
        let holds = if *r_squared >= LINEAR { "yes" } else { "no" };
        format!(
            "over {over}: {at_zero:.2} ms + {slope:.2} ms for {each}, R² = {r_squared:.4}; {claim}, as the paper says: {holds}"
        )
    }
}

/// The least share of the variance that makes a line.
const LINEAR: f64 = 0.98;
