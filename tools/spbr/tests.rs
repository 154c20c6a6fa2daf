//! The experiments at a small scale, against what equations say.

use std::path::Path;

use clap::Parser;
use pellucid_io::output::read_image;
use pellucid_testing::has_device;

use crate::stage::Stage;
use crate::{Args, run, scans, series};

/// Runs an experiment and returns the rows of its table.
fn measured(name: &str, scale: &str, folder: &Path) -> Vec<Vec<f64>> {
    let words = ["spbr-experiments", "--only", name, "--scale", scale, "-o", folder.to_str().unwrap()];
    run(&Args::try_parse_from(words).unwrap()).unwrap();
    let Ok(text) = std::fs::read_to_string(folder.join(format!("{name}.csv"))) else { return Vec::new() };
    text.lines().skip(1).map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect()).collect()
}

/// Asserts that a value is within a share of another one.
#[track_caller]
fn assert_near(found: f64, wanted: f64, share: f64) {
    assert!((found / wanted - 1.0).abs() < share, "{found} for {wanted}");
}

#[test]
fn k_of_table_1_times_n_raw_is_n_l() {
    if !has_device() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let rows = measured("tables", "0.02", folder.path());
    assert_eq!(rows.len(), 5);
    for row in &rows {
        let [number, alpha, inner, ensembles, _, _, n_raw, original, adjusted, k, seconds, fps] = row[..] else {
            panic!("{row:?}")
        };
        assert!(seconds > 0.0 && fps > 0.0 && adjusted > 0.0, "{row:?}");
        assert_near(k, adjusted / original, 1e-12);
        // The fused picture has two clouds; its k is that of both.
        assert_eq!(inner.is_nan(), number != 4.0);
        if number == 3.0 {
            assert_eq!((k, alpha.is_nan()), (1.0, false));
            assert_near(alpha, 1.0 - (-n_raw / ensembles).exp(), 1e-9);
        } else if number != 4.0 {
            assert_near(k * n_raw, ensembles * -(1.0 - alpha).ln(), 1e-4);
        }
    }
    // The papers' own figures: k of Tanaka et al. is 1.64 and 20.8.
    let text = std::fs::read_to_string(folder.path().join("tables.md")).unwrap();
    for told in
        ["| Fig. 1 | 0.20 | 500 | 1024 × 1024 | 2.620e8 | 4.290e8 | 1.64 | 58.400 | 3.55 |", "| 20.79 | 80.700 |"]
    {
        assert!(text.contains(told), "{told} in {text}");
    }
}

/// The standard error of NMSE over 65 536 pixels is √(29 / 65 536) = 2.1% with one image, where a tenth of the pixels
/// has noise; less with more.
#[test]
fn color_noise_falls_as_expected() {
    if !has_device() {
        return;
    }
    let rows = measured("colors", "0.25", tempfile::tempdir().unwrap().path());
    for row in &rows {
        assert_near(row[1], row[2], 0.084);
    }
    let of = |ensembles: f64, column: usize| rows.iter().find(|row| row[0] == ensembles).unwrap()[column];
    // In the garden as well noise is about gone with 50 ensembles.
    assert!(of(1.0, 3) > 3.0 * of(50.0, 3), "{rows:?}");
}

/// 64² pixels tell a standard deviation to 1.1%, and the estimate of the density is good for a percent.
#[test]
fn noise_with_the_ensembles_of_eq_9_is_beta_over_the_root_of_alpha() {
    if !has_device() {
        return;
    }
    let rows = measured("choice", "0.125", tempfile::tempdir().unwrap().path());
    assert_eq!(rows.len(), 12);
    for row in &rows {
        let [_, beta, _, found, expected, over] = row[..] else { panic!("{row:?}") };
        assert_near(found, expected, 0.06);
        assert_near(over, found / beta, 1e-12);
    }
    // L = 11, α = 0.3: 3.3 images are hit, and 10 would be needed.
    assert!(rows[0][5] > 1.7, "{rows:?}");
}

#[test]
fn series_and_pairs_are_sheets_of_equal_pictures() {
    if !has_device() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let rows = measured("series", "0.06", folder.path());
    // Moved points leave the image, as the number of ensembles grows.
    for kind in [0, 4] {
        assert!(rows[kind][2] > 2.0 * rows[kind + 3][2], "{rows:?}");
        assert_eq!(rows[kind][3], 1.0, "a single ensemble is as bright as itself");
    }
    measured("pairs", "0.06", folder.path());
    for (name, rows) in [("series-noise", 2), ("series-outliers", 2), ("pair-garden", 1), ("pair-terrain", 1)] {
        let sheet = read_image(&folder.path().join(format!("{name}.png"))).unwrap();
        assert_eq!((sheet.width, sheet.height), (2 * 61, rows * 61), "{name}");
        let lit = sheet.pixels.iter().filter(|pixel| pixel[1] > 0.0).count();
        assert!(lit > sheet.pixels.len() / 20, "{name}: {lit}");
    }
}

/// "SPBR with L = 1, which is equivalent to the conventional opaque point-based rendering" (Section 4.2.2).
#[test]
fn a_single_ensemble_is_the_picture_of_opaque_points() {
    if !has_device() {
        return;
    }
    let mut stage = Stage::open(1).unwrap();
    let garden = scans::merged(scans::built_in("garden", 30_000.0, 1).unwrap());
    let [ensemble, points] = series::opaque(&mut stage, garden, 80).unwrap();
    for (a, b) in ensemble.rgba.iter().zip(&points.rgba) {
        assert!((0..4).all(|c| (a[c] - b[c]).abs() < 1e-5), "{a:?} {b:?}");
    }
}
