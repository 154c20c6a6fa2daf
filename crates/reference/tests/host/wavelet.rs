//! Transparency by wavelets of one list.

use super::random_stacks::{RANGE, rms_error, stack};
use super::*;
use pellucid_reference::approximate::render;
use pellucid_reference::wavelet::{Absorption, places, wavelet};
use pellucid_scene::{Method, Wavelet};
use rand::RngExt;

#[test]
fn coefficients_by_hand() {
    let of = |place| Absorption::new(&[(place, 1.0)], 1).coefficients().to_vec();
    // All of the light is gone from the start: nothing but the constant.
    assert_eq!(of(0.0), [0.0, 0.0, 0.0, 1.0]);
    // From 3/4 on: a quarter on average. The widest wavelet sees half of the right half, the finest on the right the
    // right half of its own.
    let quarter = 0.25 * 2f64.sqrt();
    for (found, wanted) in of(1.0).into_iter().zip([0.25, 0.0, quarter, 0.25]) {
        assert_close(found, wanted, ROUNDING);
    }
}

#[test]
fn places_go_from_the_nearest_to_the_farthest() {
    assert_eq!(places(&[4.0], RANGE), [0.0]);
    assert_eq!(places(&[4.0, 4.0], RANGE), [0.0, 0.0]);
    let found = places(&[2.0, 4.0, 8.0, 32.0], RANGE);
    found.iter().zip([0.0, 0.25, 0.5, 1.0]).for_each(|(found, wanted)| assert_close(*found, wanted, ROUNDING));
}

/// All wavelets together know the mean over each cell, so that nothing but the sums of a cell and of those before it
/// counts.
#[test]
fn a_place_sees_what_lies_before_it_smoothed_over_cells() {
    let mut random = pellucid_testing_host::random(3);
    for rank in 1..=5 {
        let last = f64::from((2u32 << rank) - 1);
        let pairs: Vec<(f64, f64)> =
            (0..50).map(|_| (random.random_range(0.0..1.0), random.random_range(0.0..3.0))).collect();
        let absorption = Absorption::new(&pairs, rank);
        // The mean of a cell: what lies in it counts from there on.
        let mean = |cell: f64| -> f64 { pairs.iter().map(|(x, a)| a * (cell + 1.0 - last * x).clamp(0.0, 1.0)).sum() };
        for _ in 0..50 {
            let at: f64 = random.random_range(0.0..last);
            let [before, here] = [at.floor() - 1.0, at.floor()].map(|cell| if cell < 0.0 { 0.0 } else { mean(cell) });
            assert_close(absorption.before(at / last), before + at.fract() * (here - before), 1e-10);
        }
    }
}

#[test]
fn nothing_opaque_and_equal_colors() {
    let of = |list: &[Fragment], colors: &[DVec3]| wavelet(list, colors, RANGE, 3);
    let clear = Fragment { z: 2.0, index: 0, alpha: 0.0 };
    for list in [&[][..], &[clear, clear]] {
        let found = of(list, &[DVec3::ONE]);
        assert_eq!((found.color, found.alpha, found.depth), (DVec3::ZERO, 0.0, f64::INFINITY));
    }
    // One is itself; of several at one depth nothing lies before another.
    let two = |alphas: [f64; 2]| alphas.map(|alpha| Fragment { z: 3.0, index: u32::from(alpha == 0.25), alpha });
    assert_eq!(of(&two([0.5, 0.0]), &[DVec3::X, DVec3::Y]).color, 0.5 * DVec3::X);
    let found = of(&two([0.5, 0.25]), &[DVec3::X, DVec3::Y]).color;
    assert!((found - 0.625 * DVec3::new(2.0 / 3.0, 1.0 / 3.0, 0.0)).abs().max_element() < ROUNDING, "{found}");
    let mut random = pellucid_testing_host::random(9);
    for n in [2, 5, 40] {
        let (mut list, _) = stack(&mut random, n, 0.0);
        list[n / 2].alpha = 1.0;
        let found = of(&list, &vec![DVec3::new(0.2, 0.4, 0.8); n]);
        assert!((found.color - DVec3::new(0.2, 0.4, 0.8)).abs().max_element() < ROUNDING, "{found:?}");
        assert_eq!(found.alpha, 1.0);
    }
}

#[test]
fn fragments_at_the_edges_of_cells_are_exact() {
    let mut random = pellucid_testing_host::random(5);
    for rank in 1..=5 {
        let last = (2u32 << rank) - 1;
        let colors: Vec<DVec3> =
            (0..=last).map(|_| DVec3::new(random.random(), random.random(), random.random())).collect();
        // Some edges have none.
        let list: Vec<Fragment> = (0..=last)
            .filter(|i| i % 6 != 2)
            .map(|i| Fragment {
                z: 100f64.powf(f64::from(i) / f64::from(last)),
                index: i,
                alpha: random.random_range(0.05..0.9),
            })
            .collect();
        let (found, exact) = (wavelet(&list, &colors, RANGE, rank), composite(&list, &colors));
        assert!((found.color - exact.color).abs().max_element() < 1e-11, "rank {rank}: {found:?} {exact:?}");
        assert_close(found.alpha, exact.alpha, ROUNDING);
    }
}

/// RMSE of random stacks by the published formulas, for 8 and 32 fragments; the nearest and the farthest of a list are
/// exact here, so that errors are smaller than with a range that is given beforehand.
#[test]
fn errors_fall_with_the_rank() {
    let mut before = [f64::INFINITY; 2];
    for (rank, known) in
        [(1, [f64::INFINITY; 2]), (2, [0.043, 0.071]), (3, [0.032, 0.055]), (4, [0.022, 0.047]), (5, [0.024, 0.031])]
    {
        let found = [8, 32].map(|n| rms_error(17, n, 0.0, |list, colors| wavelet(list, colors, RANGE, rank)));
        for i in 0..2 {
            assert!(found[i] < before[i] && found[i] < 1.2 * known[i], "rank {rank}: {found:?}, {known:?} known");
            assert!(found[i] > 0.4 * known[i] || rank == 1, "rank {rank}: {found:?}, {known:?} known");
        }
        before = found;
    }
}

#[test]
fn images_by_wavelets() {
    let points = Points {
        positions: [3.0, 4.0].map(|z| -z * DVec3::Z).to_vec(),
        colors: vec![Vec3::ONE; 2],
        opacities: vec![0.5, 1.0],
        radii: vec![2.0; 2],
        ..Points::default()
    };
    let method = Method::Wavelet(Wavelet::default());
    let picture = render(View::new(&orthographic(), SIZE), &points, &[DVec3::X, DVec3::Y], &method).unwrap();
    let on = 4 * 9 + 4;
    // Two fragments are exact: they lie at the first and the last edge. That of the opaque one counts e⁻¹⁰ behind it
    // alone.
    let found = picture.rgba[on];
    assert!(found.iter().zip([0.5, 0.5, 0.0, 1.0]).all(|(a, b)| (a - b).abs() < ROUNDING), "{found:?}");
    assert_eq!((picture.depth[on], picture.counts[on]), (3.0, 2));
    assert_eq!((picture.rgba[0], picture.depth[0], picture.counts[0]), ([0.0; 4], f64::INFINITY, 0));
}
