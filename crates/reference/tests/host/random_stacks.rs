//! Random lists of one pixel, and how far an approximation of them is off.

use super::*;
use pellucid_reference::moments::place_of;
use rand::RngExt;
use rand_pcg::Pcg64;

/// Depths near and far of the lists.
pub(super) const RANGE: [f64; 2] = [1.0, 100.0];

/// `n` fragments near to far, by index as well, with places from −1 to 1 that lie more than `gap` apart, opacities of
/// 0.05 to 0.9 and random colors.
pub(super) fn stack(random: &mut Pcg64, n: usize, gap: f64) -> (Vec<Fragment>, Vec<DVec3>) {
    let places = loop {
        let mut places: Vec<f64> = (0..n).map(|_| random.random_range(-1.0..1.0)).collect();
        places.sort_by(f64::total_cmp);
        if places.windows(2).all(|pair| pair[1] - pair[0] > gap) {
            break places;
        }
    };
    let [near, far] = RANGE;
    let depth = |place: f64| near * (far / near).powf(0.5 * (place + 1.0));
    let fragment = |(i, place): (usize, &f64)| Fragment {
        z: depth(*place),
        index: i as u32,
        alpha: random.random_range(0.05..0.9),
    };
    let list = places.iter().enumerate().map(fragment).collect();
    let colors = (0..n).map(|_| DVec3::new(random.random(), random.random(), random.random())).collect();
    (list, colors)
}

/// Root mean square of the error of 400 stacks over all three components.
pub(super) fn rms_error(
    seed: u64,
    n: usize,
    gap: f64,
    approximation: impl Fn(&[Fragment], &[DVec3]) -> Composite,
) -> f64 {
    let mut random = pellucid_testing_host::random(seed);
    let mut sum = 0.0;
    for _ in 0..400 {
        let (list, colors) = stack(&mut random, n, gap);
        let (found, exact) = (approximation(&list, &colors), composite(&list, &colors));
        assert_close(found.alpha, exact.alpha, ROUNDING);
        assert_eq!(found.depth, exact.depth);
        sum += (found.color - exact.color).length_squared() / 3.0;
    }
    (sum / 400.0f64).sqrt()
}

#[test]
fn stacks_have_their_gaps() {
    let (list, colors) = stack(&mut pellucid_testing_host::random(1), 6, 0.1);
    assert_eq!((list.len(), colors.len()), (6, 6));
    assert!(list.windows(2).all(|pair| place_of(pair[1].z, RANGE) - place_of(pair[0].z, RANGE) > 0.1));
}
