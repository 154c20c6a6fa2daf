//! Times as ratios beside the paper's, and straight lines through them.

use std::fmt::Write;

use pellucid_lab::report::fit::{PowerLaw, power_law};

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

/// How time grows with the pixels of each data set, as a sentence: (name, (pixels, ms)).
pub fn over_pixels(measured: &[(&str, Vec<(f64, f64)>)]) -> String {
    let laws: Vec<(&str, PowerLaw)> =
        measured.iter().filter_map(|(name, points)| Some((*name, power_law(points)?))).collect();
    let each = |(name, law): &(&str, PowerLaw)| format!("{name} {:.2} (R² = {:.2})", law.exponent, law.r_squared);
    let listed = laws.iter().map(each).collect::<Vec<_>>().join(", ");
    let holds = if laws.iter().all(|(_, law)| law.exponent < 1.0) { "yes" } else { "no" };
    format!("over pixels, time grows as their number to the power of: {listed}; sublinear, as the paper says: {holds}")
}

/// The least share of the variance that makes a line.
const LINEAR: f64 = 0.98;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_of_the_table_has_the_ratios_of_times_and_of_the_papers_rates() {
        let paper = [80.0, 20.0, 10.0, 40.0, 16.0, 8.0];
        let line = Line { name: "cube", points: 8, side: 512, ms: vec![2.0, 6.0, 11.0, 3.0, 5.0, 9.0], paper };
        let table = markdown(&[line]);
        let row = table.lines().nth(2).expect("a row");
        let cells = "3.00 | 4.00 | 5.50 | 8.00 | 1.50 | 2.00 | 2.50 | 5.00 | 4.50 | 10.00 |";
        assert_eq!(row, format!("| cube | 8 | 512² | 2.00 | {cells}"));
        assert_eq!(table.lines().next().expect("a head").matches('|').count(), row.matches('|').count());
    }

    #[test]
    fn a_line_is_told_from_a_curve() {
        let of = |y: fn(f64) -> f64| Fit::through(&[1.0, 2.0, 3.0, 4.0].map(|x| (x, y(x))));
        let line = of(|x| 5.0 + 2.0 * x);
        assert_eq!(line, Fit { slope: 2.0, at_zero: 5.0, r_squared: 1.0 });
        assert!(line.told("layers", "a layer", "linear").ends_with("linear, as the paper says: yes"));
        assert!(of(|x| x.powi(4)).told("layers", "a layer", "linear").ends_with("no"));
    }

    #[test]
    fn time_over_pixels_is_a_power_below_one_or_not() {
        let law = |exponent: f64| [1.0, 4.0, 16.0].map(|x: f64| (x, 3.0 * x.powf(exponent))).to_vec();
        let text = over_pixels(&[("tori", law(0.25)), ("cube", law(0.5))]);
        assert!(text.contains("tori 0.25 (R² = 1.00), cube 0.50 (R² = 1.00)") && text.ends_with("yes"), "{text}");
        assert!(over_pixels(&[("tori", law(0.25)), ("cube", law(1.25))]).ends_with("no"));
    }
}
