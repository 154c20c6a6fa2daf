//! Discs in the order of their centers.

use super::*;

/// Two discs of radius 4 over the middle, by depth, tilt in degrees and opacity.
fn two(depths: [f64; 2], tilts: [f64; 2], opacity: f32) -> Points {
    Points {
        positions: depths.iter().map(|z| -*z * DVec3::Z).collect(),
        colors: vec![Vec3::X, Vec3::Y],
        opacities: vec![opacity; 2],
        radii: vec![4.0; 2],
        normals: Some(tilts.iter().map(|degrees| tilted(*degrees).as_vec3()).collect()),
        ..Points::default()
    }
}

fn oriented_discs() -> Discs {
    Discs { shape: DiscShape::Oriented, ..Discs::default() }
}

const COLORS: [DVec3; 2] = [DVec3::X, DVec3::Y];

#[test]
fn centers_decide_and_equal_ones_keep_the_order_of_the_points() {
    assert_eq!(sorted::order(&orthographic(), &two([6.0, 5.0], [0.0; 2], 0.5), &GaussianSettings::default()), [1, 0]);
    assert_eq!(sorted::order(&orthographic(), &two([5.0, 6.0], [0.0; 2], 0.5), &GaussianSettings::default()), [0, 1]);
    assert_eq!(sorted::order(&perspective(), &two([5.0, 5.0], [0.0; 2], 0.5), &GaussianSettings::default()), [0, 1]);
}

#[test]
fn crossing_discs_keep_their_places_and_their_own_depths() {
    // z = 5 + x on the first, 5.5 − x on the second: they cross at x = 0.25, to the right of which the second is
    // nearer.
    let points = two([5.0, 5.5], [45.0, -45.0], 0.5);
    let lists = sorted::lists(View::new(&orthographic(), SIZE), &points, &oriented_discs());
    for (column, depths) in [(3, [4.0, 6.5]), (5, [6.0, 4.5])] {
        let list = &lists[4 * 9 + column];
        assert_eq!(list.iter().map(|f| f.index).collect::<Vec<_>>(), [0, 1]);
        for (fragment, depth) in list.iter().zip(depths) {
            assert_close(fragment.z, depth, 1e-6);
        }
    }
    let picture = sorted::render(View::new(&orthographic(), SIZE), &points, &COLORS, &oriented_discs());
    let exact = abuffer::render(View::new(&orthographic(), SIZE), &points, &COLORS, &oriented_discs());
    // Red 0.5, green 0.5·0.5 on both sides; exactly it is the other way round on the right.
    for column in [3, 5] {
        let [red, green, _, alpha] = picture.rgba[4 * 9 + column];
        assert_close(red, 0.5, ROUNDING);
        assert_close(green, 0.25, ROUNDING);
        assert_close(alpha, 0.75, ROUNDING);
    }
    assert_eq!(picture.rgba[4 * 9 + 3], exact.rgba[4 * 9 + 3]);
    assert_close(exact.rgba[4 * 9 + 5][1] - picture.rgba[4 * 9 + 5][1], 0.25, ROUNDING);
    // The depth is that of the first that is blended, not of the nearest.
    assert_close(picture.depth[4 * 9 + 5], 6.0, 1e-6);
    assert_close(exact.depth[4 * 9 + 5], 4.5, 1e-6);
    assert_eq!(picture.counts, exact.counts);
}

#[test]
fn flat_discs_equal_the_order_of_fragments() {
    let places = [(1.0, 0.5, 7.0), (-0.7, 0.2, 3.0), (0.1, -1.3, 7.0), (0.4, 0.4, 5.0), (2.0, 2.0, 3.0)];
    let points = Points {
        positions: places.iter().map(|&(x, y, z)| DVec3::new(x, y, -z)).collect(),
        colors: vec![Vec3::ONE; 5],
        opacities: vec![0.3, 0.0, 1.0, 0.5, 0.7],
        radii: vec![2.5, 1.5, 0.0, 4.0, 3.0],
        ..Points::default()
    };
    let colors: Vec<DVec3> = (0..5).map(|i| DVec3::new(f64::from(i), 1.0, 0.5)).collect();
    for camera in [orthographic(), perspective()] {
        for falloff in [Falloff::Flat, Falloff::Gaussian] {
            let discs = Discs { falloff, ..Discs::default() };
            let found = sorted::lists(View::new(&camera, SIZE), &points, &discs);
            let wanted = lists(View::new(&camera, SIZE), &points, &discs);
            assert!(found.iter().map(Vec::len).max() > Some(2), "lists with an order");
            for (found, wanted) in found.iter().zip(&wanted) {
                assert_eq!(
                    found.iter().map(|f| (f.z, f.index)).collect::<Vec<_>>(),
                    wanted.iter().map(|f| (f.z, f.index)).collect::<Vec<_>>()
                );
            }
            let found = sorted::render(View::new(&camera, SIZE), &points, &colors, &discs);
            let wanted = abuffer::render(View::new(&camera, SIZE), &points, &colors, &discs);
            for (a, b) in found.rgba.iter().flatten().zip(wanted.rgba.iter().flatten()) {
                assert_close(*a, *b, ROUNDING);
            }
            assert_eq!((found.depth, found.counts), (wanted.depth, wanted.counts));
        }
    }
}

#[test]
fn gaussian_falloff_of_sorted_discs() {
    let mut points = two([5.0, 6.0], [0.0; 2], 0.8);
    points.normals = None;
    let discs = Discs { falloff: Falloff::Gaussian, ..Discs::default() };
    // ρ = 1/2: exp(−1/2).
    let lists = sorted::lists(View::new(&orthographic(), SIZE), &points, &discs);
    assert_close(lists[4 * 9 + 6][1].alpha, f64::from(0.8f32) * (-0.5f64).exp(), ROUNDING);
}
