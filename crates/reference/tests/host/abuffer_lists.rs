//! Fragment lists and the image they make.

use super::*;

/// Discs of radius 0.9 on the middle pixel, one per depth, with the given opacity.
fn stack(depths: &[f64], opacity: f32) -> Points {
    Points {
        positions: depths.iter().map(|&z| -z * DVec3::Z).collect(),
        colors: (0..depths.len()).map(|i| Vec3::splat(i as f32)).collect(),
        opacities: vec![opacity; depths.len()],
        radii: vec![0.9; depths.len()],
        ..Points::default()
    }
}

#[test]
fn sorted_by_depth_then_by_index() {
    let points = stack(&[7.0, 3.0, 7.0, 5.0, 3.0], 0.5);
    let lists = lists(View::new(&orthographic(), SIZE), &points, &Discs::default());
    let order: Vec<_> = lists[4 * 9 + 4].iter().map(|f| (f.z, f.index)).collect();
    assert_eq!(order, [(3.0, 1), (3.0, 4), (5.0, 3), (7.0, 0), (7.0, 2)]);
}

#[test]
fn every_fragment_is_on_its_pixel() {
    let mut points = stack(&[5.0, 5.0], 0.5);
    points.positions[1] = DVec3::new(4.0, -4.0, -5.0);
    points.radii[1] = 1.2;
    let lengths: Vec<(usize, usize)> = lists(View::new(&orthographic(), SIZE), &points, &Discs::default())
        .iter()
        .enumerate()
        .filter_map(|(pixel, list)| (!list.is_empty()).then_some((pixel, list.len())))
        .collect();
    // The lower right pixel (8, 8), and of its neighbors those inside the image: (8, 7) and (7, 8).
    assert_eq!(lengths, [(4 * 9 + 4, 1), (7 * 9 + 8, 1), (8 * 9 + 7, 1), (8 * 9 + 8, 1)]);
}

#[test]
fn some_pixels_are_those_of_the_whole() {
    let mut points = stack(&[5.0, 3.0], 0.5);
    points.radii[1] = 2.0;
    let all = lists(View::new(&orthographic(), SIZE), &points, &Discs::default());
    let wanted = [0, 3 * 9 + 4, 4 * 9 + 4, 8 * 9 + 8];
    let some = lists_at(View::new(&orthographic(), SIZE), &points, &Discs::default(), &wanted);
    assert_eq!(some, wanted.map(|pixel| all[pixel].clone()));
    assert_eq!(some.iter().map(Vec::len).collect::<Vec<_>>(), [0, 1, 2, 0]);
}

#[test]
fn gaussian_falloff() {
    let mut points = stack(&[5.0], 0.8);
    points.radii[0] = 2.0;
    let discs = Discs { falloff: Falloff::Gaussian, ..Discs::default() };
    let lists = lists(View::new(&orthographic(), SIZE), &points, &discs);
    let alpha = |x: usize, y: usize| lists[y * 9 + x][0].alpha;
    // ρ = 0, 1/2 and 1.
    assert_close(alpha(4, 4), f64::from(0.8f32), ROUNDING);
    assert_close(alpha(5, 4), f64::from(0.8f32) * (-0.5f64).exp(), ROUNDING);
    assert_close(alpha(4, 6), f64::from(0.8f32) * (-2f64).exp(), ROUNDING);
}

#[test]
fn oriented_discs_that_cross_change_places_from_pixel_to_pixel() {
    let mut points = stack(&[5.0, 5.0], 0.5);
    points.radii = vec![4.0; 2];
    points.normals = Some(vec![tilted(45.0).as_vec3(), tilted(-45.0).as_vec3()]);
    let discs = Discs { shape: DiscShape::Oriented, ..Discs::default() };
    let lists = lists(View::new(&orthographic(), SIZE), &points, &discs);
    let order = |x: usize| -> Vec<u32> { lists[4 * 9 + x].iter().map(|f| f.index).collect() };
    // z grows to the right on the first, to the left on the second.
    assert_eq!((order(3), order(5)), (vec![0, 1], vec![1, 0]));
}

#[test]
fn depth_margin_is_the_smallest_relative_gap() {
    let fragment = |z| Fragment { z, index: 0, alpha: 1.0 };
    let lists = [vec![fragment(1.0), fragment(2.0), fragment(2.0)], vec![fragment(7.0), fragment(8.0)], vec![]];
    assert_close(depth_margin(&lists), 0.125, ROUNDING);
    assert_eq!(depth_margin(&lists[2..]), f64::INFINITY);
}

#[test]
fn a_list_ends_before_the_fragment_that_would_leave_too_little() {
    let list: Vec<Fragment> = [0.5, 0.5, 0.75, 0.25]
        .iter()
        .zip(0..)
        .map(|(alpha, index)| Fragment { z: 1.0, index, alpha: *alpha })
        .collect();
    let length = |stop: f64| abuffer::before_end(&list, stop).len();
    // 1/2, 1/4, 1/16 and 3/64 are left. What is left may be as little as the least; nothing comes behind an end, were
    // it ever so faint.
    assert_eq!([0.0, 0.04, 0.05, 0.0625, 0.07, 0.25, 0.3, 0.5, 0.6].map(length), [4, 4, 3, 3, 2, 2, 1, 1, 0]);
    assert_eq!(abuffer::before_end(&[], 0.5).len(), 0);
}

#[test]
fn whole_image() {
    let points = stack(&[6.0, 4.0], 0.5);
    let picture = abuffer::render(View::new(&orthographic(), SIZE), &points, &[DVec3::X, DVec3::Y], &Discs::default());
    let on = 4 * 9 + 4;
    // Green before red: 0.5 of the one, 0.5·0.5 of the other.
    assert_close(picture.rgba[on][0], 0.25, ROUNDING);
    assert_close(picture.rgba[on][1], 0.5, ROUNDING);
    assert_close(picture.rgba[on][2], 0.0, ROUNDING);
    assert_close(picture.rgba[on][3], 0.75, ROUNDING);
    assert_eq!((picture.depth[on], picture.counts[on]), (4.0, 2));
    assert_eq!((picture.rgba[0], picture.depth[0], picture.counts[0]), ([0.0; 4], f64::INFINITY, 0));
    assert_eq!(picture.counts.iter().sum::<u32>(), 2);
    let composed = picture.composed(DVec3::new(0.4, 0.4, 1.0));
    assert!((composed[on] - DVec3::new(0.35, 0.6, 0.25)).length() < ROUNDING);
    assert_eq!(composed[0], DVec3::new(0.4, 0.4, 1.0));
}
