//! Evaluation of the rows: the fastest setting by mean list and wanted error, on each scene and over all of them.

use std::collections::BTreeMap;

use pellucid_session::choice::EXACT;

use crate::rows::{Measured, Row};

/// Wanted errors, and what they are called; the last one is that of exact images, up to rounding.
pub const ERRORS: [(f64, &str); 8] = [
    (0.05, "0.05"),
    (0.03, "0.03"),
    (0.02, "0.02"),
    (0.01, "0.01"),
    (0.005, "0.005"),
    (0.002, "0.002"),
    (1e-4, "1e-4"),
    (EXACT, "exact"),
];

/// Approximations that are neither averages nor samples, and lie between the two and the exact image.
const NEW: [&str; 3] = ["moments", "wavelet", "mlab"];

/// True of `moments`, `wavelet`, `mlab`, and of `hybrid` with moments behind its core.
pub fn is_new(row: &Row) -> bool {
    let family = row.family();
    let method = family.split(' ').next().unwrap_or_default();
    NEW.contains(&method) || (method == "hybrid" && family.contains("tail=moments"))
}

/// The fastest setting of a case with at most this RMSE.
pub fn fastest(case: &Measured, most: f64) -> Option<&Row> {
    let fits = case.rows.iter().filter(|row| row.rmse() <= most);
    fits.min_by(|a, b| a.ms().total_cmp(&b.ms()))
}

/// Settings that no other beats in both time and error, the fastest first, down to the fastest exact one.
pub fn front(case: &Measured) -> Vec<&Row> {
    let mut rows: Vec<&Row> = case.rows.iter().collect();
    let error = |row: &Row| row.rmse().max(EXACT);
    rows.sort_by(|a, b| a.ms().total_cmp(&b.ms()).then(error(a).total_cmp(&error(b))));
    let mut least = f64::INFINITY;
    rows.retain(|row| {
        let is_better = error(row) < least;
        least = least.min(error(row));
        is_better
    });
    rows
}

/// The part of the front between `weighted` and the exact image: more accurate than the former, faster than the latter.
pub fn between(case: &Measured) -> Vec<&Row> {
    let weighted = case.rows.iter().find(|row| row.key() == "weighted").map_or(f64::INFINITY, Row::rmse);
    front(case).into_iter().filter(|row| row.rmse() < weighted && row.rmse() > EXACT).collect()
}

/// The method that serves the scenes best where lists have one mean.
#[derive(Debug, Clone, PartialEq)]
pub struct Verdict {
    /// The method, with those keys that are not steps of a ladder.
    pub family: String,
    /// The key of its setting on most scenes.
    pub key: String,
    /// Geometric mean over the scenes of its time over that of the fastest setting.
    pub regret: f64,
    /// Geometric mean of its time over that of the fastest exact setting.
    pub of_exact: f64,
    /// The most memory that it took.
    pub bytes: u64,
    /// Scenes on which a setting of it is accurate enough.
    pub fits: usize,
}

/// Methods by their regret, the best one first: those that are accurate enough on more than half of the scenes. Where
/// one isn't, it costs as much as the exact image, which one would have to take instead.
pub fn verdicts(cases: &[&Measured], most: f64) -> Vec<Verdict> {
    let mut found: BTreeMap<String, Vec<Option<&Row>>> = BTreeMap::new();
    let known: Vec<_> =
        cases.iter().filter_map(|case| Some((*case, fastest(case, most)?.ms(), fastest(case, EXACT)?.ms()))).collect();
    for (at, (case, _, _)) in known.iter().enumerate() {
        for row in case.rows.iter().filter(|row| row.rmse() <= most) {
            let best = &mut found.entry(row.family()).or_insert_with(|| vec![None; known.len()])[at];
            if best.is_none_or(|best| row.ms() < best.ms()) {
                *best = Some(row);
            }
        }
    }
    let mut verdicts: Vec<Verdict> = found
        .into_iter()
        .filter_map(|(family, rows)| {
            let times: Vec<(f64, f64, f64)> = rows
                .iter()
                .zip(&known)
                .map(|(row, (_, best, exact))| (row.map_or(*exact, Row::ms), *best, *exact))
                .collect();
            let fitting: Vec<&Row> = rows.into_iter().flatten().collect();
            (2 * fitting.len() > known.len()).then(|| Verdict {
                key: typical(&fitting),
                regret: geometric_mean(times.iter().map(|(ms, best, _)| ms / best)),
                of_exact: geometric_mean(times.iter().map(|(ms, _, exact)| ms / exact)),
                bytes: fitting.iter().map(|row| row.bytes()).max().unwrap_or_default(),
                fits: fitting.len(),
                family,
            })
        })
        .collect();
    verdicts.sort_by(|a, b| a.regret.total_cmp(&b.regret).then_with(|| a.family.cmp(&b.family)));
    verdicts
}

/// The key of most rows; of several the one with the least error, which serves more scenes.
fn typical(rows: &[&Row]) -> String {
    let mut counts: BTreeMap<&str, (usize, f64)> = BTreeMap::new();
    for row in rows {
        let (count, error) = counts.entry(row.key()).or_insert((0, f64::INFINITY));
        *count += 1;
        *error = error.min(row.rmse());
    }
    let most = counts.into_iter().max_by(|(_, (a, x)), (_, (b, y))| a.cmp(b).then(y.total_cmp(x)));
    most.map_or_else(String::new, |(key, _)| key.to_owned())
}

fn geometric_mean(values: impl Iterator<Item = f64>) -> f64 {
    let (mut sum, mut count) = (0.0, 0u32);
    for value in values {
        sum += value.ln();
        count += 1;
    }
    (sum / f64::from(count)).exp()
}

#[cfg(test)]
pub mod tests {
    use super::*;
    use crate::rows::Case;

    /// A case of settings with an RMSE and a time each.
    pub fn case(scene: &str, target: u32, rows: &[(&str, f64, f64)]) -> Measured {
        let case = Case {
            scene: scene.to_owned(),
            target,
            mean: target.into(),
            longest: 2 * target,
            covered: 100,
            points: 1000,
            radius_factor: 1.0,
            opacity: None,
        };
        let row = |(key, rmse, ms): &(&str, f64, f64)| Row((*key).to_owned(), *rmse, *ms, (ms * 1e6) as u64);
        Measured { case, rows: rows.iter().map(row).collect(), done: true }
    }

    fn tori() -> Measured {
        let rows = [
            ("abuffer", 0.0, 10.0),
            ("sorted", 2e-7, 8.0),
            ("hybrid method.k=4", 0.02, 5.0),
            ("hybrid method.k=8", 0.004, 6.0),
            ("mlab method.nodes=4", 0.015, 4.0),
            ("moments method.moments=4", 0.03, 7.0),
            ("weighted", 0.1, 2.0),
            ("average", 0.3, 1.0),
        ];
        case("tori", 50, &rows)
    }

    #[test]
    fn the_fastest_of_a_case() {
        let tori = tori();
        let key = |most| fastest(&tori, most).map_or("", |row| row.key());
        assert_eq!(
            [key(0.2), key(0.05), key(0.01), key(1e-4)],
            ["weighted", "mlab method.nodes=4", "hybrid method.k=8", "sorted"]
        );
        let keys = |rows: Vec<&Row>| rows.iter().map(|row| row.key().to_owned()).collect::<Vec<_>>();
        assert_eq!(keys(front(&tori)), ["average", "weighted", "mlab method.nodes=4", "hybrid method.k=8", "sorted"]);
        assert_eq!(keys(between(&tori)), ["mlab method.nodes=4", "hybrid method.k=8"]);
        let new: Vec<bool> = tori.rows.iter().map(is_new).collect();
        assert_eq!(new, [false, false, false, false, true, true, false, false]);
        assert!(is_new(&Row("hybrid method.k=8 method.tail=moments".to_owned(), 0.0, 1.0, 1)));
    }

    #[test]
    fn over_scenes_the_least_geometric_regret_counts() {
        let garden = [
            ("abuffer", 0.0, 20.0),
            ("hybrid method.k=4", 0.009, 10.0),
            ("hybrid method.k=8", 0.001, 12.0),
            ("mlab method.nodes=4", 0.03, 5.0),
        ];
        let stack = [("abuffer", 0.0, 4.0), ("hybrid method.k=8", 0.002, 3.0), ("mlab method.nodes=4", 0.5, 1.0)];
        let (garden, stack, tori) = (case("garden", 50, &garden), case("stack", 50, &stack), tori());
        let found = verdicts(&[&garden, &stack, &tori], 0.01);
        let families: Vec<&str> = found.iter().map(|verdict| verdict.family.as_str()).collect();
        // mlab is accurate enough nowhere, sorted on one scene of three.
        assert_eq!(families, ["hybrid", "abuffer"]);
        let hybrid = &found[0];
        // It is the fastest of all three: 10 of 20, 3 of 4, 6 of 8.
        assert!((hybrid.regret - 1.0).abs() < 1e-12 && hybrid.fits == 3);
        assert!((hybrid.of_exact - (0.5f64 * 0.75 * 0.75).cbrt()).abs() < 1e-12);
        assert_eq!((hybrid.key.as_str(), hybrid.bytes), ("hybrid method.k=8", 10_000_000));
        let found = verdicts(&[&garden, &stack, &tori], 0.03);
        // mlab: 5 and 4, the fastest twice; on the stack the exact image in its place, 4 of 3.
        assert_eq!((found[0].family.as_str(), found[0].fits), ("mlab", 2));
        assert!((found[0].regret - (4f64 / 3.0).cbrt()).abs() < 1e-12);
        assert!(verdicts(&[], 0.1).is_empty());
    }
}
