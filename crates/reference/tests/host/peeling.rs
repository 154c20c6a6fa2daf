//! Layers peeled one after another.

use super::*;
use pellucid_reference::peel;

fn fragment(z: f64, index: u32) -> Fragment {
    Fragment { z, index, alpha: 0.5 }
}

fn indices(peeled: &[Fragment]) -> Vec<u32> {
    peeled.iter().map(|f| f.index).collect()
}

#[test]
fn the_next_layer_is_the_nearest_behind_the_last() {
    let fragments = [fragment(7.0, 0), fragment(3.0, 1), fragment(7.0, 2), fragment(5.0, 3), fragment(3.0, 4)];
    assert_eq!(peel::next(&fragments, None), Some(fragments[1]));
    // At the same depth the greater index is behind, the smaller one in front.
    assert_eq!(peel::next(&fragments, Some(fragments[1])), Some(fragments[4]));
    assert_eq!(peel::next(&fragments, Some(fragments[4])), Some(fragments[3]));
    assert_eq!(peel::next(&fragments, Some(fragments[2])), None);
    // Nothing need be there where the last one lay.
    assert_eq!(peel::next(&fragments, Some(fragment(4.0, 9))), Some(fragments[3]));
    assert_eq!(peel::next(&[], None), None);
    assert_eq!(indices(&peel::peel(&fragments, 0)), [1, 4, 3, 0, 2]);
    assert_eq!(indices(&peel::peel(&fragments, 3)), [1, 4, 3]);
    assert_eq!(indices(&peel::peel(&fragments, 9)), [1, 4, 3, 0, 2]);
}

/// Three discs on the middle pixel: red at 6, green at 4, blue at 5, half transparent.
fn three() -> (Points, [DVec3; 3]) {
    let points = Points {
        positions: [6.0, 4.0, 5.0].map(|z| -z * DVec3::Z).to_vec(),
        colors: vec![Vec3::ONE; 3],
        opacities: vec![0.5; 3],
        radii: vec![0.9; 3],
        ..Points::default()
    };
    (points, [DVec3::X, DVec3::Y, DVec3::Z])
}

#[test]
fn layers_are_blended_front_to_back() {
    let (points, colors) = three();
    let on = 4 * 9 + 4;
    let rendered = |layers| peel::render(View::new(&orthographic(), SIZE), &points, &colors, &Discs::default(), layers);
    // Green lets half through, blue half of that: 1/2, 1/4, 1/8.
    for (layers, wanted, count) in [
        (0, [0.125, 0.5, 0.25, 0.875], 3),
        (1, [0.0, 0.5, 0.0, 0.5], 1),
        (2, [0.0, 0.5, 0.25, 0.75], 2),
        (5, [0.125, 0.5, 0.25, 0.875], 3),
    ] {
        let picture = rendered(layers);
        assert_eq!((picture.rgba[on], picture.depth[on], picture.counts[on]), (wanted, 4.0, count), "{layers}");
        assert_eq!((picture.rgba[0], picture.depth[0], picture.counts[0]), ([0.0; 4], f64::INFINITY, 0));
    }
}

#[test]
fn a_layer_without_opacity_takes_a_layer_but_no_depth() {
    let (mut points, colors) = three();
    points.opacities[1] = 0.0;
    let on = 4 * 9 + 4;
    let one = peel::render(View::new(&orthographic(), SIZE), &points, &colors, &Discs::default(), 1);
    assert_eq!((one.rgba[on], one.depth[on], one.counts[on]), ([0.0; 4], f64::INFINITY, 1));
    let two = peel::render(View::new(&orthographic(), SIZE), &points, &colors, &Discs::default(), 2);
    assert_eq!((two.rgba[on], two.depth[on]), ([0.0, 0.0, 0.5, 0.5], 5.0));
}

/// Tilted discs of all sizes that cross, some at one place and some at equal depths.
fn crossing() -> (Points, Vec<DVec3>) {
    let number = |i: usize, modulus: usize| (i * 7919 % modulus) as f64 / modulus as f64;
    let count = 60;
    let points = Points {
        positions: (0..count)
            .map(|i| DVec3::new(8.0 * number(i, 13) - 4.0, 8.0 * number(i, 11) - 4.0, -2.0 - (i % 7) as f64))
            .collect(),
        colors: vec![Vec3::ONE; count],
        opacities: (0..count).map(|i| number(i, 17) as f32).collect(),
        radii: (0..count).map(|i| 6.0 * number(i, 19) as f32).collect(),
        normals: Some((0..count).map(|i| tilted(80.0 * number(i, 23)).as_vec3()).collect()),
        ..Points::default()
    };
    let colors = (0..count).map(|i| DVec3::new(number(i, 29), number(i, 31), number(i, 37))).collect();
    (points, colors)
}

#[test]
fn all_layers_are_the_sorted_lists_and_n_layers_their_first() {
    let (points, colors) = crossing();
    for camera in [orthographic(), perspective()] {
        for shape in [DiscShape::Flat, DiscShape::Oriented] {
            for falloff in [Falloff::Flat, Falloff::Gaussian] {
                let discs = Discs { shape, falloff, ..Discs::default() };
                let sorted = lists(View::new(&camera, SIZE), &points, &discs);
                let longest = sorted.iter().map(Vec::len).max().unwrap();
                assert!(longest > 8, "{longest}");
                let unsorted = peel::fragments(View::new(&camera, SIZE), &points, &discs);
                for layers in [0, 1, 3, 8] {
                    let most = if layers == 0 { usize::MAX } else { layers as usize };
                    for (fragments, list) in unsorted.iter().zip(&sorted) {
                        assert_eq!(peel::peel(fragments, layers), list[..list.len().min(most)]);
                    }
                    let picture = peel::render(View::new(&camera, SIZE), &points, &colors, &discs, layers);
                    for (pixel, list) in sorted.iter().enumerate() {
                        let wanted = composite(&list[..list.len().min(most)], &colors);
                        assert_close(picture.rgba[pixel][3], wanted.alpha, ROUNDING);
                        assert!((DVec3::from_slice(&picture.rgba[pixel]) - wanted.color).length() < ROUNDING);
                        assert_eq!(picture.depth[pixel], wanted.depth);
                    }
                }
                let all = peel::render(View::new(&camera, SIZE), &points, &colors, &discs, 0);
                assert_eq!(all.counts, abuffer::render(View::new(&camera, SIZE), &points, &colors, &discs).counts);
            }
        }
    }
}
