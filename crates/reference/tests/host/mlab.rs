//! Multi-layer alpha blending of one list.

use super::random_stacks::{rms_error, stack};
use super::*;
use pellucid_reference::approximate::render;
use pellucid_reference::mlab::{Layer, insert, merged, mlab};
use pellucid_scene::{Method, Mlab};
use rand::seq::SliceRandom;

const COLORS: [DVec3; 3] = [DVec3::X, DVec3::Y, DVec3::Z];

/// Red, green and blue at 1, 2 and 3.
fn list(alphas: [f64; 3]) -> Vec<Fragment> {
    (0..3).map(|i| Fragment { z: f64::from(i) + 1.0, index: i, alpha: alphas[i as usize] }).collect()
}

#[track_caller]
fn assert_composite(got: Composite, color: [f64; 3], alpha: f64, depth: f64) {
    assert!((got.color - DVec3::from(color)).abs().max_element() < ROUNDING, "{got:?} is not {color:?}");
    assert_close(got.alpha, alpha, ROUNDING);
    assert_eq!(got.depth, depth);
}

#[test]
fn two_layers_become_one() {
    let layer = |z, color, through| Layer { z, color, through };
    let (front, back) = (layer(1.0, 0.5 * DVec3::X, 0.5), layer(3.0, 0.25 * DVec3::Z, 0.75));
    let both = layer(1.0, DVec3::new(0.5, 0.0, 0.125), 0.375);
    assert_eq!(merged(&front, &back), both);
    let mut layers = vec![front, back];
    // In front of what is as far, and the last two of three become one.
    let found = layer(3.0, 0.5 * DVec3::Y, 0.5);
    insert(&mut layers, found, 2);
    assert_eq!(layers, [front, merged(&found, &back)]);
}

#[test]
fn a_late_fragment_lies_behind_all_of_a_layer_or_before_it() {
    let all = list([0.5; 3]);
    // Blue, red before it, and green, which belongs between them, behind both.
    assert_composite(mlab(&all, &COLORS, &[1, 2, 0], 1), [0.5, 0.125, 0.25], 0.875, 1.0);
    // Green, blue behind it, red before both.
    assert_composite(mlab(&all, &COLORS, &[2, 0, 1], 1), [0.5, 0.25, 0.125], 0.875, 1.0);
    // Two layers and one in transit hold three fragments.
    assert_composite(mlab(&all, &COLORS, &[1, 2, 0], 2), [0.5, 0.25, 0.125], 0.875, 1.0);
    // Without places, as the points stand.
    assert_composite(mlab(&all, &COLORS, &[], 1), [0.5, 0.25, 0.125], 0.875, 1.0);
}

#[test]
fn opacities_of_0_and_1_and_nothing() {
    assert_composite(mlab(&[], &[], &[], 4), [0.0; 3], 0.0, f64::INFINITY);
    assert_composite(mlab(&list([0.0; 3]), &COLORS, &[], 4), [0.0; 3], 0.0, f64::INFINITY);
    // A fragment without opacity takes no layer from the two others.
    assert_composite(mlab(&list([0.0, 0.5, 0.5]), &COLORS, &[1, 2, 0], 1), [0.0, 0.5, 0.25], 0.75, 2.0);
    assert_composite(mlab(&list([0.5, 1.0, 1.0]), &COLORS, &[2, 1, 0], 1), [0.5, 0.5, 0.0], 1.0, 1.0);
    let faint = mlab(&list([1e-20; 3]), &COLORS, &[2, 0, 1], 1);
    assert!((faint.color - DVec3::splat(1e-20)).abs().max_element() < 1e-32);
    assert_close(faint.alpha, 3e-20, 1e-32);
}

#[test]
fn of_equal_depths_the_last_to_come_lies_in_front() {
    let mut all = list([0.5, 0.5, 0.5]);
    all[1].z = 1.0;
    assert_composite(mlab(&all, &COLORS, &[0, 1, 2], 4), [0.25, 0.5, 0.125], 0.875, 1.0);
    assert_composite(mlab(&all, &COLORS, &[1, 0, 2], 4), [0.5, 0.25, 0.125], 0.875, 1.0);
}

#[test]
fn fragments_in_order_are_exact_whatever_their_number() {
    let mut random = pellucid_testing_host::random(5);
    for n in [1, 2, 7, 60] {
        let (list, colors) = stack(&mut random, n, 0.0);
        let exact = composite(&list, &colors);
        let onward: Vec<u32> = (0..n as u32).collect();
        let backward: Vec<u32> = onward.iter().rev().copied().collect();
        for (places, nodes) in [&onward, &backward].into_iter().flat_map(|places| [1, 3, 16].map(|k| (places, k))) {
            let found = mlab(&list, &colors, places, nodes);
            assert!((found.color - exact.color).abs().max_element() < ROUNDING, "{n} fragments, {nodes} layers");
            assert_eq!((found.alpha, found.depth), (exact.alpha, exact.depth));
        }
    }
}

#[test]
fn as_many_fragments_as_layers_and_one_more_are_exact() {
    for nodes in [1, 2, 4, 16] {
        let error = |n: usize| {
            rms_error(7, n, 0.0, |list, colors| {
                let mut places: Vec<u32> = (0..n as u32).collect();
                places.shuffle(&mut pellucid_testing_host::random(list[0].z.to_bits()));
                mlab(list, colors, &places, nodes)
            })
        };
        assert!(error(nodes as usize + 1) < ROUNDING);
        assert!(error(nodes as usize + 2) > 1e-6);
    }
}

#[test]
fn images_follow_the_order_of_the_files() {
    let points = Points {
        positions: [3.0, 4.0, 5.0].map(|z| -z * DVec3::Z).to_vec(),
        colors: vec![Vec3::ONE; 3],
        opacities: vec![0.5; 3],
        radii: vec![2.0; 3],
        file_order: vec![1, 2, 0],
        ..Points::default()
    };
    let of = |nodes| {
        let method = Method::Mlab(Mlab { nodes, ..Mlab::default() });
        render(View::new(&orthographic(), SIZE), &points, &COLORS, &method).unwrap()
    };
    let on = 4 * 9 + 4;
    assert_eq!((of(1).rgba[on], of(1).depth[on], of(1).counts[on]), ([0.5, 0.125, 0.25, 0.875], 3.0, 3));
    assert_eq!(of(2).rgba[on], [0.5, 0.25, 0.125, 0.875]);
    assert_eq!((of(1).rgba[0], of(1).depth[0], of(1).counts[0]), ([0.0; 4], f64::INFINITY, 0));
}
