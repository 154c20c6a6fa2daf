//! Compares measurements with statements of Seemann et al. (2018) on their three models and of Uchida et al. (2020) on
//! ensembles.

use super::figures::signed;
use super::{Analytic, Finding, Row};

/// Base and Concentric take at least this many times as long as Express (Section 5.2).
const EXPRESS_GAIN: f64 = 10.0;
/// Opacity and color of 8 bits: the least step that shows.
const STEP: f64 = 1.0 / 255.0;

/// Returns a finding for each statement whose rows were all measured. Statements on soft points are not judged where
/// there are none; `without` then says so.
pub(super) fn check_statements(rows: &[Row], analytic: Option<&Analytic>, without: Option<&str>) -> Vec<Finding> {
    let row = |method: &str, own: &str| rows.iter().find(|row| row.method == method && own_parts(&row.setting) == own);
    let base = row("soft-base", "");
    let concentric = row("soft-concentric", "method.shells=adaptive");
    let express = row("soft-express", "");
    let paper = row("soft-base", "method.layout=paper");
    let pairs = [
        base.zip(express).map(|(base, express)| faster(base, express, "soft-base")),
        concentric.zip(express).map(|(concentric, express)| faster(concentric, express, "soft-concentric")),
        concentric.map(|row| alike(row, "soft-concentric")),
        express.map(|row| alike(row, "soft-express")),
        base.zip(paper).map(|(base, paper)| packed(base, paper)),
    ];
    let planes = analytic.and_then(|analytic| blended(rows, analytic));
    let judged = |found: Finding| match without {
        Some(without) => Finding { measured: format!("nothing was soft: {without}"), holds: None, ..found },
        None => found,
    };
    pairs.into_iter().flatten().map(judged).chain(ensembles(rows)).chain(planes).collect()
}

/// The tolerance, as a share, for the error of the most ensembles above the value extrapolated from the fewest.
const OFF: f64 = 0.25;
/// The tolerance, as a share, for an error against alpha blending around its expected value.
const OFF_BLENDED: f64 = 0.15;

/// RMSE against the analytic image of the fewest ensembles, of the most, and between.
fn blended(rows: &[Row], analytic: &Analytic) -> Option<Finding> {
    let mut found: Vec<(f64, f64)> =
        rows.iter().filter_map(|row| Some((row.step.as_ref()?.1, row.rmse_analytic?))).collect();
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    let [(few, before), .., (many, after)] = found[..] else { return None };
    let off = found.iter().map(|(count, rmse)| (rmse / analytic.expected(*count) - 1.0).abs()).fold(0.0, f64::max);
    let slope = analytic.slope.map(|law| format!(", with slope {} up to there", signed(law.exponent, 2)));
    let Analytic { dealt_once, expected_floor, floor, .. } = *analytic;
    let [first, last] = [few, many].map(|count| analytic.expected(count));
    Some(Finding {
        claim: "planes look as alpha blending draws them (Eq. 1), except for noise".to_owned(),
        measured: format!(
            "RMSE against alpha blending is {before:.4} with {few} ensembles ({first:.4} expected) and {after:.4} with {many} \
             ({last:.4}); no point is dealt twice up to {dealt_once:.0} of them{}; points leave {floor:.4} however many there are \
             ({expected_floor:.4} expected)",
            slope.unwrap_or_default()
        ),
        holds: Some(off < OFF_BLENDED && (floor / expected_floor - 1.0).abs() < OFF_BLENDED),
    })
}

/// Compares the fewest with the most ensembles.
fn ensembles(rows: &[Row]) -> Option<Finding> {
    let step =
        |row: &Row| row.step.as_ref().filter(|_| row.method == "spbr").map(|(_, count)| (*count, row.errors.rmse));
    let mut found: Vec<(f64, f64)> = rows.iter().filter_map(step).collect();
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    let [(few, before), .., (many, after)] = found[..] else { return None };
    let scaled = [before * few.sqrt(), after * many.sqrt()];
    Some(Finding {
        claim:
            "the error against a reference of many more ensembles of the same points falls as 1/√L (Fig. 6), or faster"
                .to_owned(),
        measured: format!(
            "RMSE · √L is {:.4} with {few} and {:.4} with {many} ensembles; ensembles that share all points between them, none \
             twice, make it smaller",
            scaled[0], scaled[1]
        ),
        holds: Some(scaled[1] / scaled[0] < 1.0 + OFF),
    })
}

/// A setting without the softness that all rows share.
fn own_parts(setting: &str) -> String {
    let own: Vec<_> = setting.split(' ').filter(|part| !part.starts_with("method.softness=")).collect();
    own.join(" ")
}

fn ratio(a: &Row, b: &Row) -> f64 {
    a.gpu_ms.median / b.gpu_ms.median
}

fn faster(slow: &Row, express: &Row, name: &str) -> Finding {
    let gain = ratio(slow, express);
    let (a, b) = (slow.gpu_ms.median, express.gpu_ms.median);
    Finding {
        claim: format!("soft-express is at least 10 times as fast as {name} (Section 5.2)"),
        measured: format!("{a:.1} ms over {b:.1} ms: {gain:.1}"),
        holds: Some(gain >= EXPRESS_GAIN),
    }
}

fn alike(row: &Row, name: &str) -> Finding {
    let errors = row.errors;
    Finding {
        claim: format!("the picture of {name} is hard to tell from that of soft-base (Fig. 6 and 7)"),
        measured: format!("RMSE {:.4}, SSIM {:.4}, FLIP {:.4}", errors.rmse, errors.ssim, errors.flip),
        holds: None,
    }
}

fn packed(precise: &Row, paper: &Row) -> Finding {
    let bytes = paper.fragment_bytes as f64 / (precise.fragment_bytes.max(1)) as f64;
    let errors = paper.errors;
    Finding {
        claim: "8 bits are enough for a ray's distance from a sphere's center (Section 4)".to_owned(),
        measured: format!(
            "layout=paper: {:.2} times the time and {bytes:.2} times the bytes of events, RMSE {:.1e}, largest error {:.1e}",
            ratio(paper, precise),
            errors.rmse,
            errors.max
        ),
        // Half a step rounds to the same 8 bits nearly everywhere.
        holds: Some(errors.rmse < 0.5 * STEP),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::stress::Spread;
    use crate::report::tradeoff::Errors;

    fn row(method: &str, setting: &str, ms: f64, rmse: f64, fragment_bytes: u64) -> Row {
        let spread = Spread { min: ms, median: ms, max: ms };
        let errors = Errors { rmse, ssim: 1.0, max: rmse, ..Errors::default() };
        let (method, setting) = (method.into(), setting.into());
        Row { method, setting, gpu_ms: spread, fragment_bytes, errors, thinning: 1, ..Row::default() }
    }

    #[test]
    fn claims_hold_or_don_t() {
        let rows = [
            row("soft-base", "method.softness=0.5", 100.0, 0.0, 800),
            row("soft-base", "method.layout=paper method.softness=0.5", 120.0, 0.01, 1600),
            row("soft-concentric", "method.shells=2 method.softness=0.5", 1.0, 0.0, 1),
            row("soft-concentric", "method.shells=adaptive method.equalize=false method.softness=0.5", 40.0, 0.01, 1),
            row("soft-concentric", "method.shells=adaptive method.softness=0.5", 50.0, 0.02, 1),
            row("soft-express", "method.softness=0.5", 8.0, 0.03, 0),
        ];
        let found = check_statements(&rows, None, None);
        let holds: Vec<_> = found.iter().map(|finding| finding.holds).collect();
        assert_eq!(holds, [Some(true), Some(false), None, None, Some(false)], "{found:#?}");
        assert!(found[0].measured.ends_with(": 12.5") && found[1].measured.ends_with(": 6.2"), "{found:#?}");
        assert!(found[2].measured.starts_with("RMSE 0.0200") && found[4].measured.contains("2.00 times the bytes"));
        assert_eq!(check_statements(&rows[..1], None, None), []);
        // Where nothing was soft, nothing is judged.
        let none = check_statements(&rows, None, Some("0 of 9 points are soft"));
        assert_eq!(none.len(), found.len());
        for (none, found) in none.iter().zip(&found) {
            assert_eq!((&none.claim, none.holds), (&found.claim, None));
            assert_eq!(none.measured, "nothing was soft: 0 of 9 points are soft");
        }
    }

    #[test]
    fn errors_of_ensembles_fall_or_don_t() {
        let from_errors = |errors: [(f64, f64); 3]| {
            let step = |(count, rmse): (f64, f64)| Row {
                step: Some(("ensembles".into(), count)),
                ..row("spbr", "", 1.0, rmse, 0)
            };
            check_statements(&errors.map(step), None, None)
        };
        let found = from_errors([(1.0, 0.4), (100.0, 0.04), (10.0, 0.2)]);
        assert_eq!((found.len(), found[0].holds), (1, Some(true)), "{found:?}");
        assert!(found[0].measured.contains("0.4000 with 1 and 0.4000 with 100"), "{found:?}");
        assert_eq!(from_errors([(1.0, 0.4), (10.0, 0.2), (100.0, 0.1)])[0].holds, Some(false));
        // Being faster is fine, too.
        assert_eq!(from_errors([(1.0, 0.4), (10.0, 0.1), (100.0, 0.02)])[0].holds, Some(true));
    }

    #[test]
    fn planes_are_as_blended_or_aren_t() {
        let analytic = Analytic {
            opacities: vec![0.5],
            points_per_pixel: vec![20.0],
            color: [0.5; 3],
            dealt_once: 28.85,
            expected_of_one: 0.5,
            expected_floor: 0.078,
            floor: 0.08,
            slope: None,
        };
        let finding = |floor: f64, factor: f64| {
            let analytic = Analytic { floor, ..analytic.clone() };
            let row = |count: f64| Row {
                step: Some(("ensembles".into(), count)),
                rmse_analytic: Some(factor * analytic.expected(count)),
                ..row("spbr", "", 1.0, 0.4 / count.sqrt(), 0)
            };
            check_statements(&[1.0, 10.0, 1000.0].map(row), Some(&analytic), None).pop().unwrap()
        };
        let found = finding(0.08, 1.0);
        assert!(
            found.measured.starts_with("RMSE against alpha blending is 0.5000 with 1 ensembles (0.5000"),
            "{found:?}"
        );
        let holds = [finding(0.08, 1.1), finding(0.08, 1.2), finding(0.1, 1.0)].map(|found| found.holds);
        assert_eq!(holds, [Some(true), Some(false), Some(false)]);
    }
}
