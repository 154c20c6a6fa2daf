//! Blending one list.

use super::*;

fn blend(alphas: &[f64]) -> Composite {
    let fragment = |(i, &alpha): (usize, &f64)| Fragment { z: 1.0 + i as f64, index: i as u32, alpha };
    let list: Vec<Fragment> = alphas.iter().enumerate().map(fragment).collect();
    composite(&list, &vec![DVec3::ONE; alphas.len()])
}

#[test]
fn n_coincident_discs() {
    for (n, alpha) in [(1, 0.3), (2, 0.3), (17, 0.05), (255, 0.01)] {
        let got = blend(&vec![alpha; n]);
        let want = 1.0 - (1.0 - alpha).powi(n as i32);
        assert_close(got.alpha, want, ROUNDING);
        // White on all of them: the color is the coverage.
        assert_close(got.color.y, want, ROUNDING);
    }
}

#[test]
fn many_faint_layers_lose_nothing() {
    let got = blend(&vec![1e-7; 100_000]);
    // 1 − (1 − 1e-7)^100000 = 1 − exp(−0.01 − 5e-10).
    assert_close(got.alpha, 0.009_950_17, 1e-8);
    assert_close(got.color.x, got.alpha, ROUNDING);
    // 1 − 1e-20 rounds to 1.
    assert_close(blend(&[1e-20; 3]).alpha, 3e-20, 1e-32);
}

#[test]
fn alpha_0_and_1() {
    let clear = blend(&[0.0, 0.0]);
    assert_eq!(clear, Composite { color: DVec3::ZERO, alpha: 0.0, depth: f64::INFINITY });
    assert!(clear.alpha.is_sign_positive());
    let covered = blend(&[0.0, 0.25, 1.0, 0.5, 1.0]);
    assert_eq!((covered.alpha, covered.depth), (1.0, 2.0));
    assert_close(covered.color.x, 1.0, ROUNDING);
    assert_eq!(blend(&[]).depth, f64::INFINITY);
}

#[test]
fn near_over_far() {
    let list = [Fragment { z: 1.0, index: 1, alpha: 0.5 }, Fragment { z: 2.0, index: 0, alpha: 0.4 }];
    let got = composite(&list, &[DVec3::X, DVec3::Z]);
    assert!((got.color - DVec3::new(0.2, 0.0, 0.5)).length() < ROUNDING);
    assert_close(got.alpha, 0.7, ROUNDING);
}
