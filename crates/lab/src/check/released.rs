//! Errors that the last release measured, in addition to the bounds: a bound that holds for every device is often a
//! thousand times what a good one is off, and would not see it get a hundred times worse.

use std::fmt;

use super::{Case, Finding, Verdict};

/// A case and its error in each line, as [`released_table`] writes them; behind `#` a comment.
const TABLE: &str = include_str!("released.txt");

/// The allowed factor on a case's error of the last release, on the same driver: other compilers order operations
/// differently.
const FACTOR: f64 = 4.0;
/// The allowed error of a case that had none: a few roundings of float32 at 1.
const FLOOR: f64 = 4.0 * f32::EPSILON as f64;

fn lines() -> impl Iterator<Item = (&'static str, f64)> {
    let lines = TABLE.lines().filter(|line| !line.starts_with('#'));
    lines.filter_map(|line| {
        let (name, error) = line.split_once(' ')?;
        Some((name, error.parse().ok()?))
    })
}

/// The error of a case, in its own unit, that the last release measured on llvmpipe; `None` for one that it didn't
/// have.
pub fn released(name: &str) -> Option<f64> {
    lines().find(|(known, _)| *known == name).map(|(_, error)| error)
}

/// The table of errors that this release measures: a line for each case that was run.
pub fn released_table(results: &[(&Case, Verdict)]) -> String {
    let head = "# Errors that `pellucid check` measures on llvmpipe, in the units of the cases.\n\
                # Written by crates/lab/tests/lab/check.rs with PELLUCID_UPDATE=1.\n";
    let line = |(case, verdict): &(&Case, Verdict)| Some(format!("{} {:e}\n", case.name, verdict.finding()?.error));
    head.to_owned() + &results.iter().filter_map(line).collect::<String>()
}

/// An error much larger than that of the last release, or one that the table doesn't know.
#[derive(Debug, Clone, PartialEq)]
pub struct Regression {
    /// The case.
    pub name: String,
    /// The error found.
    pub error: f64,
    /// The error of the last release, if it had the case.
    pub released: Option<f64>,
}

impl fmt::Display for Regression {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { name, error, released } = self;
        match released {
            Some(released) => write!(
                out,
                "{name}: error {error:.3e}, more than {FACTOR} times the {released:.3e} that the last release measured"
            )?,
            None => write!(out, "{name}: error {error:.3e}, of which the table of the last release has no line")?,
        }
        write!(
            out,
            " (released.txt); if that is right, run crates/lab/tests/lab/check.rs with PELLUCID_UPDATE=1 and commit the table"
        )
    }
}

/// The regression, if a case's error is out of proportion to that of the last release. Only on the driver of the table:
/// others round differently.
pub fn regression(name: &str, finding: &Finding) -> Option<Regression> {
    compare(name, finding.error, released(name))
}

fn compare(name: &str, error: f64, released: Option<f64>) -> Option<Regression> {
    let limit = released.map(|released| if released == 0.0 { FLOOR } else { FACTOR * released });
    // NaN is within nothing.
    let is_within = limit.is_some_and(|limit| error <= limit);
    (!is_within).then(|| Regression { name: name.to_owned(), error, released })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn four_times_is_too_much() {
        let found = |error, released| compare("a/case", error, released).is_some();
        for released in [1e-20, 1e-7, 3.0] {
            assert!(!found(0.0, Some(released)) && !found(FACTOR * released, Some(released)));
            assert!(found(4.01 * released, Some(released)) && found(5.0 * released, Some(released)));
        }
        assert!(!found(4e-7, Some(0.0)) && found(5e-7, Some(0.0)) && found(1.0, Some(0.0)));
        assert!(found(f64::NAN, Some(1e-7)) && found(f64::INFINITY, Some(1e-7)) && found(0.0, None));
    }

    #[test]
    fn the_message_names_case_errors_and_the_way_to_update() {
        let text = compare("a/case", 5e-7, Some(1e-7)).expect("a regression").to_string();
        for part in ["a/case", "5.000e-7", "1.000e-7", "PELLUCID_UPDATE=1"] {
            assert!(text.contains(part), "{text}");
        }
    }

    #[test]
    fn the_table_knows_every_case_once_and_no_other() {
        let mut known: Vec<&str> = lines().map(|(name, _)| name).collect();
        let mut cases: Vec<String> = super::super::cases().into_iter().map(|case| case.name).collect();
        // The order of methods is the table of methods' own business.
        known.sort_unstable();
        cases.sort_unstable();
        assert_eq!(known, cases);
        assert_eq!(lines().count(), TABLE.lines().filter(|line| !line.starts_with('#')).count());
    }
}
