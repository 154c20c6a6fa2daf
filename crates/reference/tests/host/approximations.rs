//! Approximations of one list.

use super::*;
use glam::DVec4;
use pellucid_reference::approximate::{average, hybrid, render, unsorted, weight, weighted};
use pellucid_reference::moments::moments;
use pellucid_scene::{Hybrid, Method, MomentCount, Moments, Tail};

const COLORS: [DVec3; 3] = [DVec3::X, DVec3::Y, DVec3::Z];

/// Red, green and blue from near to far.
fn list(depths: [f64; 3], alphas: [f64; 3]) -> Vec<Fragment> {
    (0..3).map(|i| Fragment { z: depths[i], index: i as u32, alpha: alphas[i] }).collect()
}

#[track_caller]
fn assert_composite(got: Composite, color: [f64; 3], alpha: f64, depth: f64) {
    assert!((got.color - DVec3::from(color)).abs().max_element() < ROUNDING, "{got:?} is not {color:?}");
    assert_close(got.alpha, alpha, ROUNDING);
    assert_eq!(got.depth, depth);
}

#[test]
fn nothing_is_nothing() {
    for got in [weighted(&[], &[], [1.0, 2.0]), average(&[], &[]), unsorted(&[], &[], &[]), hybrid(&[], &[], 3, 0.0)] {
        assert_composite(got, [0.0; 3], 0.0, f64::INFINITY);
    }
}

#[test]
fn weights_fall_from_near_to_far() {
    for (z, wanted) in [(1.0, 3000.0), (6.0, 375.0), (10.0, 3.0), (10.9, 0.01), (11.0, 0.01)] {
        assert_close(weight(z, [1.0, 11.0]), wanted, 1e-9);
    }
    // A tilted disc may reach before near and behind far.
    assert_eq!((weight(-4.0, [1.0, 11.0]), weight(20.0, [1.0, 11.0])), (3000.0, 0.01));
}

#[test]
fn weighted_colors_share_the_coverage() {
    // Weights 375, 3 and 3: Σwα = 187.5 + 0.75, since the third has no opacity.
    let got = weighted(&list([6.0, 10.0, 10.0], [0.5, 0.25, 0.0]), &COLORS, [1.0, 11.0]);
    assert_composite(got, [0.625 * 187.5 / 188.25, 0.625 * 0.75 / 188.25, 0.0], 0.625, 6.0);
    assert_composite(weighted(&list([6.0, 7.0, 8.0], [0.0; 3]), &COLORS, [1.0, 11.0]), [0.0; 3], 0.0, f64::INFINITY);
    // Opacities of 1 − 10⁻²⁰ lose nothing.
    let faint = weighted(&list([6.0, 6.0, 6.0], [1e-20; 3]), &COLORS, [1.0, 11.0]);
    assert_close(faint.alpha, 3e-20, 1e-32);
}

#[test]
fn averages_ask_for_no_opacity() {
    let third = 1.0 / 3.0;
    assert_composite(average(&list([1.0, 2.0, 3.0], [0.0, 0.5, 1.0]), &COLORS), [third; 3], 1.0, 2.0);
    assert_composite(average(&list([1.0, 2.0, 3.0], [0.0; 3]), &COLORS), [third; 3], 1.0, f64::INFINITY);
}

#[test]
fn the_last_of_the_files_lies_on_top() {
    let all = list([1.0, 2.0, 3.0], [0.5; 3]);
    // Blue, red over it, green over both.
    assert_composite(unsorted(&all, &COLORS, &[1, 2, 0]), [0.25, 0.5, 0.125], 0.875, 1.0);
    // Without places, as the points stand.
    assert_composite(unsorted(&all, &COLORS, &[]), [0.125, 0.25, 0.5], 0.875, 1.0);
    assert_composite(unsorted(&list([1.0, 2.0, 3.0], [0.0, 1.0, 0.5]), &COLORS, &[]), [0.0, 0.5, 0.5], 1.0, 2.0);
}

#[test]
fn a_hybrid_has_an_exact_front_and_a_mean_tail() {
    let all = list([1.0, 2.0, 3.0], [0.5, 0.5, 0.25]);
    // Behind half of red a tail of (0, 2/3, 1/3) that covers 5/8.
    assert_composite(hybrid(&all, &COLORS, 1, 0.0), [0.5, 0.5 * 0.625 * 2.0 / 3.0, 0.5 * 0.625 / 3.0], 0.8125, 1.0);
    // A tail of one fragment is exact, and so is none.
    for k in [2, 3, 64] {
        assert_composite(hybrid(&all, &COLORS, k, 0.0), [0.5, 0.25, 0.0625], 0.8125, 1.0);
    }
    // A fragment without opacity takes one of the k places.
    let clear = list([1.0, 2.0, 3.0], [0.0, 0.5, 0.5]);
    assert_composite(hybrid(&clear, &COLORS, 1, 0.0), [0.0, 0.375, 0.375], 0.75, 2.0);
    assert_composite(hybrid(&list([1.0, 2.0, 3.0], [1.0, 0.5, 0.5]), &COLORS, 1, 0.0), [1.0, 0.0, 0.0], 1.0, 1.0);
}

#[test]
fn faint_fragments_are_in_the_tail_of_a_hybrid_wherever_they_lie() {
    let all = list([1.0, 2.0, 3.0], [0.25, 0.5, 0.5]);
    // Half of green, and behind it a tail that covers 1 − 3/4 · 1/2 = 5/8: a third of it is red, from before green.
    let wanted = [0.5 * 0.625 / 3.0, 0.5, 0.5 * 0.625 * 2.0 / 3.0];
    assert_composite(hybrid(&all, &COLORS, 1, 0.3), wanted, 0.8125, 1.0);
    assert_composite(hybrid(&all, &COLORS, 1, 0.5), wanted, 0.8125, 1.0);
    // A core of two: green and blue, and the red one alone behind them.
    assert_composite(hybrid(&all, &COLORS, 2, 0.3), [0.25 * 0.25, 0.5, 0.25], 0.8125, 1.0);
    // As opaque as the least is opaque enough; with none opaque enough all are averaged.
    assert_eq!(hybrid(&all, &COLORS, 1, 0.25), hybrid(&all, &COLORS, 1, 0.0));
    assert_composite(hybrid(&all, &COLORS, 3, 0.6), [0.2, 0.4, 0.4].map(|share| share * 0.8125), 0.8125, 1.0);
}

#[test]
fn a_tail_by_moments_is_that_method_behind_an_exact_front() {
    // Three discs of radius 2 over the middle, green, red and blue from near to far, and a fainter white one before
    // all.
    let points = Points {
        positions: [4.0, 5.0, 6.0, 3.0].map(|z| -z * DVec3::Z).to_vec(),
        colors: vec![Vec3::ONE; 4],
        opacities: vec![0.5, 0.5, 0.5, 0.125],
        radii: vec![2.0; 4],
        ..Points::default()
    };
    let colors = [DVec3::Y, DVec3::X, DVec3::Z, DVec3::ONE];
    let on = 4 * 9 + 4;
    let of = |k, core_alpha_min, moments| {
        let hybrid = Hybrid { k, core_alpha_min, tail: Tail::Moments, moments, ..Hybrid::default() };
        DVec4::from(
            render(View::new(&orthographic(), SIZE), &points, &colors, &Method::Hybrid(hybrid)).unwrap().rgba[on],
        )
    };
    let at = |index: u32| Fragment {
        z: -points.positions[index as usize].z,
        index,
        alpha: points.opacities[index as usize].into(),
    };
    let near_far = [orthographic().near, orthographic().far];
    for count in MomentCount::ALL {
        let tail = |indices: &[u32]| {
            let list: Vec<Fragment> = indices.iter().map(|index| at(*index)).collect();
            moments(&list, &colors, near_far, &Moments { moments: count, ..Moments::default() }).color
        };
        let white = DVec3::splat(0.125);
        let alpha = 1.0 - 0.875 / 8.0;
        assert!((of(1, 0.0, count) - (white + 0.875 * tail(&[0, 1, 2])).extend(alpha)).abs().max_element() < ROUNDING);
        // White is too faint to be in front, and stands before the others in the tail.
        let gated = (DVec3::Y * 0.5 + 0.5 * tail(&[3, 1, 2])).extend(alpha);
        assert!((of(1, 0.25, count) - gated).abs().max_element() < ROUNDING);
        // A tail of one, and none.
        let exact = (white + 0.875 * DVec3::new(0.25, 0.5, 0.125)).extend(alpha);
        assert!([3, 4].iter().all(|k| (of(*k, 0.0, count) - exact).abs().max_element() < ROUNDING));
        assert!((of(1, 0.0, count) - exact).abs().max_element() > 1e-4, "more than one are estimated");
    }
}

#[test]
fn images_of_approximations() {
    // Three discs of radius 2 over the middle.
    let points = Points {
        positions: [5.0, 4.0, 3.0].map(|z| -z * DVec3::Z).to_vec(),
        colors: vec![Vec3::ONE; 3],
        opacities: vec![0.5; 3],
        radii: vec![2.0; 3],
        file_order: vec![2, 0, 1],
        ..Points::default()
    };
    let discs = Discs::default();
    let of = |method| render(View::new(&orthographic(), SIZE), &points, &COLORS, &method);
    assert_eq!(of(Method::ABuffer(discs)), None);
    let on = 4 * 9 + 4;
    let picture = of(Method::Unsorted(discs)).unwrap();
    // Green, blue over it, red over both, whatever their depths.
    assert_eq!((picture.rgba[on], picture.depth[on], picture.counts[on]), ([0.5, 0.125, 0.25, 0.875], 3.0, 3));
    assert_eq!((picture.rgba[0], picture.depth[0], picture.counts[0]), ([0.0; 4], f64::INFINITY, 0));
    assert_close(of(Method::Average(discs)).unwrap().rgba[on][1], 1.0 / 3.0, ROUNDING);
    // Blue, then green and red in equal parts.
    let hybrid = of(Method::Hybrid(Hybrid { discs, k: 1, ..Hybrid::default() })).unwrap().rgba[on];
    assert!(hybrid.iter().zip([0.1875, 0.1875, 0.5, 0.875]).all(|(a, b)| (a - b).abs() < ROUNDING), "{hybrid:?}");
    // Near is 0.5, far 100.
    let weights = [5.0, 4.0, 3.0].map(|z| weight(z, [0.5, 100.0]));
    let wanted = 0.875 * weights[2] / weights.iter().sum::<f64>();
    assert_close(of(Method::Weighted(discs)).unwrap().rgba[on][2], wanted, ROUNDING);
}
