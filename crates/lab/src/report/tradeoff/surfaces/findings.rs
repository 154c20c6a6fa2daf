//! Compares measurements with the statements of Schütz and Wimmer (2015) on opaque points.

use crate::report::popping::{Curve, Popping};
use crate::report::tradeoff::{Finding, Row};

/// Surfaces count as covered if at most this share of their pixels is not.
const COVERED: f64 = 1e-3;
/// Slowest last.
const ORDER: [&str; 4] = ["squares", "circles", "paraboloid", "hqs"];

/// Returns a finding for each statement whose rows were all measured.
pub(in super::super) fn check_statements(rows: &[Row], popping: Option<&Popping>) -> Vec<Finding> {
    [cost(rows), covering(rows), quality(rows), popping.and_then(flicker)].into_iter().flatten().collect()
}

/// The row of a method with splats of a size.
fn row<'a>(rows: &'a [Row], thinning: u32, method: &str, size: f64) -> Option<&'a Row> {
    let is_it = |row: &&Row| {
        row.thinning == thinning && row.method == method && row.step.as_ref().is_some_and(|(_, value)| *value == size)
    };
    rows.iter().find(is_it)
}

/// The sizes that all these methods were measured with, from a least one on, ascending.
fn sizes(rows: &[Row], thinning: u32, methods: &[&str], least: f64) -> Vec<f64> {
    let step = |row: &Row| row.step.as_ref().filter(|(key, _)| key == "size").map(|(_, size)| *size);
    let first = rows.iter().filter(|row| row.thinning == thinning && row.method == methods[0]).filter_map(step);
    let mut sizes: Vec<f64> = first.filter(|size| *size >= least).collect();
    sizes.retain(|size| methods.iter().all(|method| row(rows, thinning, method, *size).is_some()));
    sizes.sort_by(f64::total_cmp);
    sizes
}

/// Lists the sizes at which a statement holds and those at which it doesn't.
fn told(so: &[f64], not_so: &[f64]) -> String {
    let list = |sizes: &[f64]| sizes.iter().map(f64::to_string).collect::<Vec<_>>().join(", ");
    match (so, not_so) {
        (so, []) => format!("at sizes {}", list(so)),
        ([], not_so) => format!("at none of the sizes {}", list(not_so)),
        (so, not_so) => format!("at sizes {}, not at {}", list(so), list(not_so)),
    }
}

/// Fig. 8: who is faster, at all sizes that close holes.
fn cost(rows: &[Row]) -> Option<Finding> {
    let sizes = sizes(rows, 1, &ORDER, 1.0);
    let times = |size: f64| ORDER.map(|method| row(rows, 1, method, size).map_or(f64::NAN, |row| row.gpu_ms.median));
    let (ordered, other): (Vec<f64>, Vec<f64>) = sizes.iter().partition(|size| times(**size).is_sorted());
    let largest = *sizes.last()?;
    let times: Vec<_> = ORDER.iter().zip(times(largest)).map(|(method, ms)| format!("{method} {ms:.2}")).collect();
    Some(Finding {
        claim: "squares are fastest, then circles, then paraboloids, then high-quality splats (Fig. 8)".to_owned(),
        measured: format!("{}; ms at {largest}: {}", told(&ordered, &other), times.join(", ")),
        holds: Some(other.is_empty()),
    })
}

/// Fig. 8: the faults of sizes other than 1, for clouds whose points alone don't cover the surfaces.
fn covering(rows: &[Row]) -> Option<Finding> {
    let mut thinning: Vec<u32> = rows.iter().map(|row| row.thinning).collect();
    thinning.sort_unstable();
    thinning.dedup();
    let holes = |one_of: u32, size: f64| row(rows, one_of, "circles", size)?.holes;
    thinning.retain(|one_of| holes(*one_of, 0.0).is_some());
    let told = |one_of: &u32| -> Option<(String, Option<bool>)> {
        let all = sizes(rows, *one_of, &["circles"], 0.0);
        let at = all.iter().position(|size| *size == 1.0)?;
        let [less, more] = [all.get(at.checked_sub(1)?)?, all.get(at + 1)?];
        let [before, here] = [holes(*one_of, *less)?, holes(*one_of, 1.0)?];
        let ms = |size: f64| row(rows, *one_of, "circles", size).map(|row| row.gpu_ms.median);
        let (time, longer) = (ms(1.0)?, ms(*more)?);
        let cloud = if *one_of == 1 { "all points".to_owned() } else { format!("1 point of {one_of}") };
        if holes(*one_of, 0.0)? <= COVERED {
            return Some((format!("{cloud}: closed at any size"), None));
        }
        let text = format!(
            "{cloud}: {:.2}% holes with {less}, {:.3}% with 1; {time:.2} ms with 1, {longer:.2} ms with {more}",
            100.0 * before,
            100.0 * here
        );
        Some((text, Some(here <= COVERED && before > COVERED && longer > time)))
    };
    let told: Vec<_> = thinning.iter().filter_map(told).collect();
    let decided: Vec<bool> = told.iter().filter_map(|(_, holds)| *holds).collect();
    (!told.is_empty()).then(|| Finding {
        claim: "a size factor of 1 covers holes while minimizing overdraw, lower ones leave holes (Fig. 8)".to_owned(),
        measured: format!("circles, {}", told.iter().map(|(text, _)| text.as_str()).collect::<Vec<_>>().join("; ")),
        holds: (!decided.is_empty()).then(|| decided.iter().all(|holds| *holds)),
    })
}

/// Section IV and Fig. 5: interpolation is better than circles, high-quality splats are better still.
fn quality(rows: &[Row]) -> Option<Finding> {
    let methods = ["hqs", "paraboloid", "circles"];
    let sizes = sizes(rows, 1, &methods, 1.0);
    let errors = |size: f64| {
        methods.map(|method| row(rows, 1, method, size).and_then(|row| row.rmse_inside).unwrap_or(f64::NAN))
    };
    let (ordered, other): (Vec<f64>, Vec<f64>) = sizes.iter().partition(|size| errors(**size).is_sorted());
    let largest = *sizes.last()?;
    let [blended, interpolated, flat] = errors(largest);
    Some(Finding {
        claim: "interpolation in one pass lies between circles and high-quality splats in quality (Section IV)"
            .to_owned(),
        measured: format!(
            "{}; RMSE inside the silhouette at {largest}: circles {flat:.4}, paraboloid {interpolated:.4}, hqs {blended:.4}",
            told(&ordered, &other)
        ),
        holds: Some(other.is_empty()),
    })
}

/// Changes of the error along a path over those by as much motion without any change of order, above which a method
/// flickers.
const FLICKER: f64 = 1.25;

/// Section IV: which methods flicker as the camera turns.
fn flicker(popping: &Popping) -> Option<Finding> {
    let ratio = |method: &str| -> Option<f64> {
        let curve: &Curve = popping.curves.iter().find(|curve| curve.method == method)?;
        Some(curve.mean_rmse / curve.rolled_rmse?)
    };
    let mut ratios = [0.0; ORDER.len()];
    for (slot, method) in ratios.iter_mut().zip(ORDER) {
        *slot = ratio(method)?;
    }
    let told: Vec<_> = ORDER.iter().zip(ratios).map(|(method, ratio)| format!("{method} {ratio:.2}")).collect();
    let [squares, circles, paraboloid, hqs] = ratios.map(|ratio| ratio > FLICKER);
    Some(Finding {
        claim: "squares and circles flicker as the camera turns, since points change their order; paraboloids and \
                high-quality splats do not (Section IV)"
            .to_owned(),
        measured: format!(
            "the error changes from frame to frame by so many times what it changes by if the picture moves as much and no \
             point changes its depth: {}; above {FLICKER} is flicker",
            told.join(", ")
        ),
        holds: Some(squares && circles && !paraboloid && !hqs),
    })
}

#[cfg(test)]
pub(in super::super) mod tests {
    use super::*;
    use crate::report::stress::Spread;

    /// A row of splats, made up.
    pub fn made(method: &str, thinning: u32, size: f64, ms: f64, rmse: f64, holes: f64) -> Row {
        Row {
            method: method.into(),
            step: Some(("size".into(), size)),
            thinning,
            gpu_ms: Spread { min: ms, median: ms, max: ms },
            holes: Some(holes),
            rmse_inside: Some(rmse),
            ..Row::default()
        }
    }

    /// Rows that agree with the paper, for all points and for a quarter of them.
    fn as_claimed() -> Vec<Row> {
        let mut rows = Vec::new();
        for thinning in [1, 4] {
            for (place, method) in ORDER.iter().enumerate() {
                for size in [0.0, 0.5, 1.0, 2.0] {
                    let place = place as f64;
                    // Holes at 0 only in the thinner cloud.
                    let holes = if thinning == 1 || size >= 1.0 { 0.0 } else { 0.2 - 0.3 * size };
                    rows.push(made(method, thinning, size, 1.0 + place + size, 0.1 - 0.01 * place, holes));
                }
            }
        }
        rows
    }

    fn holds(rows: &[Row]) -> Vec<Option<bool>> {
        check_statements(rows, None).iter().map(|finding| finding.holds).collect()
    }

    #[test]
    fn statements_hold_for_rows_as_claimed() {
        let rows = as_claimed();
        let found = check_statements(&rows, None);
        assert_eq!(holds(&rows), [Some(true); 3], "{found:#?}");
        assert!(found[0].measured.starts_with("at sizes 1, 2; ms at 2: squares 3.00, circles 4.00"));
        let told = "1 point of 4: 5.00% holes with 0.5, 0.000% with 1; 3.00 ms with 1, 4.00 ms with 2";
        assert!(found[1].measured.contains(told) && found[1].measured.contains("all points: closed at any size"));
        assert!(found[2].measured.ends_with("circles 0.0900, paraboloid 0.0800, hqs 0.0700"), "{found:#?}");
    }

    #[test]
    fn statements_fail_for_rows_that_contradict_them() {
        let change = |method: &str, thinning: u32, size: f64, change: fn(&mut Row)| {
            let mut rows = as_claimed();
            let row = rows
                .iter_mut()
                .find(|row| row.method == method && row.thinning == thinning && row.step.as_ref().unwrap().1 == size);
            change(row.unwrap());
            holds(&rows)
        };
        let (yes, no) = (Some(true), Some(false));
        assert_eq!(change("circles", 1, 2.0, |row| row.gpu_ms.median = 2.9), [no, yes, yes]);
        // Below 1 nothing is claimed of times.
        assert_eq!(change("circles", 1, 0.5, |row| row.gpu_ms.median = 0.1), [yes, yes, yes]);
        assert_eq!(change("circles", 4, 1.0, |row| row.holes = Some(0.002)), [yes, no, yes]);
        assert_eq!(change("circles", 4, 0.5, |row| row.holes = Some(0.0)), [yes, no, yes]);
        assert_eq!(change("circles", 4, 2.0, |row| row.gpu_ms.median = 1.0), [yes, no, yes]);
        assert_eq!(change("paraboloid", 1, 1.0, |row| row.rmse_inside = Some(0.2)), [yes, yes, no]);
        assert_eq!(change("hqs", 1, 1.0, |row| row.rmse_inside = Some(0.085)), [yes, yes, no]);
    }

    #[test]
    fn circles_flicker_where_paraboloids_do_not() {
        let popping = |changes: [f64; 4]| {
            let curve = |(method, change): (&str, f64)| Curve {
                method: method.to_owned(),
                setting: String::new(),
                frames: Vec::new(),
                mean_error: 0.3,
                mean_rmse: change,
                worst_rmse: change,
                worst_frame: 1,
                rolled_rmse: Some(0.1),
                mean_flip: 0.0,
                worst_flip: 0.0,
            };
            let curves = ORDER.into_iter().zip(changes).map(curve).collect();
            Popping { exact: "splats".to_owned(), frames: 3, curves, refused: Vec::new() }
        };
        let holds = |changes| check_statements(&[], Some(&popping(changes))).pop().unwrap().holds;
        assert_eq!(holds([0.2, 0.15, 0.11, 0.1]), Some(true));
        assert_eq!([holds([0.2, 0.15, 0.13, 0.1]), holds([0.2, 0.12, 0.11, 0.1])], [Some(false); 2]);
        let found = flicker(&popping([0.2, 0.15, 0.11, 0.1])).unwrap();
        assert!(found.measured.contains("squares 2.00, circles 1.50, paraboloid 1.10, hqs 1.00"), "{found:?}");
        // Without one of the methods, or without a path, nothing is said.
        let mut some = popping([0.2, 0.15, 0.11, 0.1]);
        some.curves.pop();
        assert_eq!((flicker(&some), check_statements(&[], None)), (None, Vec::new()));
    }

    #[test]
    fn nothing_is_found_without_rows() {
        assert_eq!(check_statements(&[], None), []);
        let all = as_claimed();
        let circles: Vec<Row> = all.iter().filter(|row| row.method == "circles").cloned().collect();
        assert_eq!(check_statements(&circles, None).len(), 1);
        let dense: Vec<Row> = circles.into_iter().filter(|row| row.thinning == 1).collect();
        assert_eq!(holds(&dense), [None], "nothing to cover");
    }
}
