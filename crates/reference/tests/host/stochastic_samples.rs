//! Stochastic transparency from masks given by hand.

use pellucid_reference::stochastic::{Estimate, Stratum, estimate, strata, stratum};

use super::*;

const COLORS: [DVec3; 3] = [DVec3::X, DVec3::Y, DVec3::Z];

/// Fragments at depths 1, 2, 3 with opacities 1/2, 1/4 and 1, of red, green and blue.
fn three() -> [Fragment; 3] {
    [(1.0, 0.5), (2.0, 0.25), (3.0, 1.0)]
        .into_iter()
        .enumerate()
        .map(|(i, (z, alpha))| Fragment { z, index: i as u32, alpha })
        .collect::<Vec<_>>()
        .try_into()
        .unwrap()
}

#[test]
fn a_fragment_is_visible_where_nothing_nearer_is_held() {
    // Red holds samples 0 and 2, green sample 1 (and covers 2 behind red), blue sample 3.
    let found = stratum(&three(), &COLORS, &[0b0101, 0b0110, 0b1111], 4);
    // Red is visible in all four, green in those that red doesn't hold, blue in the last: 1/2, 1/4·2/4, 1·1/4.
    assert_eq!(found.color, DVec3::new(0.5, 0.125, 0.25));
    assert_eq!((found.alpha, found.weight, found.depth), (0.875, 1.0, 1.0));
}

#[test]
fn splats_that_cover_no_sample_are_visible_all_the_same() {
    let found = stratum(&three(), &COLORS, &[0, 0, 0b1111], 4);
    // Blue holds all; the others lie before it. The sum is not clamped.
    assert_eq!((found.color, found.alpha, found.depth), (DVec3::new(0.5, 0.25, 1.0), 1.75, 3.0));
    // Nothing held at all: no depth.
    assert_eq!(stratum(&three(), &COLORS, &[0; 3], 4).depth, f64::INFINITY);
    let nothing = stratum(&[], &COLORS, &[], 4);
    assert_eq!((nothing.color, nothing.alpha, nothing.depth), (DVec3::ZERO, 0.0, f64::INFINITY));
}

#[test]
fn the_last_stratum_takes_only_the_samples_left() {
    // Samples 0 and 1 alone: red holds 0, green 1.
    let found = stratum(&three(), &COLORS, &[0b0101, 0b0110, 0b1111], 2);
    assert_eq!(found.color, DVec3::new(0.5, 0.125, 0.0));
    assert_eq!((found.alpha, found.weight), (0.625, 0.5));
    // 6 samples: a whole stratum and half of one. α = 1 covers all whatever the words.
    let opaque = [Fragment { z: 5.0, index: 1, alpha: 1.0 }, Fragment { z: 6.0, index: 0, alpha: 1.0 }];
    let found = strata(&opaque, &COLORS, 6, |splat, p| splat * 77 + p);
    let all = |weight| Stratum { color: DVec3::Y, alpha: 1.0, weight, depth: 5.0 };
    assert_eq!(found, [all(1.0), all(0.5)]);
}

#[test]
fn words_are_those_of_fragment_and_stratum() {
    // α = 1/2 and no bits but those that choose: two neighbors from 0101 (the upper four bits below 5) or 0011.
    let list = [Fragment { z: 1.0, index: 2, alpha: 0.5 }, Fragment { z: 2.0, index: 1, alpha: 1.0 }];
    let found = strata(&list, &COLORS, 8, |splat, p| if splat == 2 && p == 1 { 0b010_100 } else { 0 });
    // In both strata two samples of four let blue through to green.
    for s in &found {
        assert_eq!((s.color, s.alpha, s.depth), (DVec3::new(0.0, 0.5, 0.5), 1.0, 1.0));
    }
}

fn red_stratum(color: f64, alpha: f64, weight: f64, depth: f64) -> Stratum {
    Stratum { color: DVec3::X * color, alpha, weight, depth }
}

#[test]
fn means_and_their_errors() {
    let Estimate { color, alpha, depth, stderr } = estimate(
        &[
            red_stratum(0.5, 1.0, 1.0, 4.0),
            red_stratum(0.25, 0.5, 1.0, 3.0),
            red_stratum(0.75, 0.75, 1.0, f64::INFINITY),
        ],
        None,
    );
    assert_eq!((color, alpha, depth), (DVec3::X * 0.5, 0.75, 3.0));
    // Deviations 0, −1/4, 1/4: sqrt((2/16) / 6).
    assert_close(stderr.x, (0.125f64 / 6.0).sqrt(), ROUNDING);
    assert_eq!([stderr.y, stderr.z], [0.0; 2]);
    // A last stratum of two samples counts half.
    let partial = estimate(&[red_stratum(0.5, 1.0, 1.0, 4.0), red_stratum(0.2, 0.4, 0.5, 5.0)], None);
    assert_close(partial.color.x, 0.4, ROUNDING);
    assert_close(partial.alpha, 0.8, ROUNDING);
    // Weighted deviations 0.1 and −0.1 over the mean weight 3/4.
    assert_close(partial.stderr.x, (0.02f64 / 2.0).sqrt() / 0.75, ROUNDING);
}

#[test]
fn alpha_correction_scales_by_exact_over_sampled() {
    let exact = estimate(&[red_stratum(0.5, 1.0, 1.0, 4.0), red_stratum(0.25, 0.5, 1.0, 4.0)], Some(0.6));
    // Color and alpha of the strata are in proportion: the ratio is certain.
    assert_close(exact.color.x, 0.6 * 0.5, ROUNDING);
    assert_close(exact.stderr.x, 0.0, ROUNDING);
    assert_eq!(exact.alpha, 0.6);
    // R = 1/2: deviations 0.5 − 0.25 and 0.25 − 0.5, over the mean alpha 3/4.
    let spread = estimate(&[red_stratum(0.5, 0.5, 1.0, 4.0), red_stratum(0.25, 1.0, 1.0, 4.0)], Some(0.6));
    assert_close(spread.color.x, 0.6 * 0.5, ROUNDING);
    assert_close(spread.stderr.x, 0.6 / 0.75 * (0.125f64 / 2.0).sqrt(), ROUNDING);
}

#[test]
fn one_stratum_knows_no_error_and_nothing_sampled_is_nothing() {
    for exact in [None, Some(0.5)] {
        assert_eq!(estimate(&[red_stratum(0.5, 0.5, 1.0, 4.0)], exact).stderr, DVec3::INFINITY);
        let nothing = estimate(&[red_stratum(0.0, 0.0, 1.0, f64::INFINITY); 2], exact);
        assert_eq!((nothing.color, nothing.stderr), (DVec3::ZERO, DVec3::ZERO));
        assert_eq!((nothing.alpha, nothing.depth), (exact.unwrap_or(0.0), f64::INFINITY));
    }
}
