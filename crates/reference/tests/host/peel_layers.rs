//! Layers of point surfaces.

use super::*;
use pellucid_reference::peel_layers::{layers, render};
use pellucid_scene::{ImageSpace, Iterations, PeelLayers};

const NO_FILTER: ImageSpace = ImageSpace {
    fill: Iterations::Count(0),
    occlusion: Iterations::Count(0),
    smooth: 0,
    antialias: false,
    antialias_threshold: 0.25,
    min_layer_distance: Some(0.5),
    cull: false,
};

/// Points at pixels' centers (0, 0 in the middle), depth, gray, opacity.
fn points(at: &[(i32, i32, f64, f32, f32)]) -> (Points, Vec<DVec3>) {
    let points = Points {
        positions: at.iter().map(|p| DVec3::new(f64::from(p.0), f64::from(p.1), -p.2)).collect(),
        colors: at.iter().map(|p| Vec3::splat(p.3)).collect(),
        opacities: at.iter().map(|p| p.4).collect(),
        radii: vec![0.0; at.len()],
        ..Points::default()
    };
    let colors = points.colors.iter().map(|c| c.as_dvec3()).collect();
    (points, colors)
}

/// A full image at one depth.
fn plane(z: f64, gray: f32, opacity: f32) -> Vec<(i32, i32, f64, f32, f32)> {
    (-4..=4).flat_map(|x| (-4..=4).map(move |y| (x, y, z, gray, opacity))).collect()
}

const MIDDLE: usize = 4 * 9 + 4;

#[test]
fn planes_are_blended_by_their_opacities() {
    let (one, two, three) = (0.5f32, 0.25, 0.75);
    let scene = [plane(4.0, 1.0, two), plane(3.0, 0.5, one), plane(7.0, 0.25, three)].concat();
    let (points, colors) = points(&scene);
    for layers in 1..=5u32 {
        let settings = PeelLayers { filters: NO_FILTER, layers, ..PeelLayers::default() };
        let picture = render(View::new(&orthographic(), SIZE), &points, &colors, &settings);
        let shown = layers.min(3) as usize;
        // 0.5·0.5, then half of 0.25·1, then 3/8 of 0.75·0.25.
        let wanted: f64 = [0.25, 0.125, 0.375 * 0.75 * 0.25][..shown].iter().sum();
        let alpha = [0.5, 0.625, 1.0 - 0.375 * 0.25][shown - 1];
        for pixel in 0..81 {
            assert_close(picture.rgba[pixel][0], wanted, ROUNDING);
            assert_close(picture.rgba[pixel][3], alpha, ROUNDING);
        }
        assert_eq!((picture.depth[MIDDLE], picture.counts[MIDDLE]), (3.0, shown as u32));
    }
}

#[test]
fn points_of_one_surface_are_one_layer() {
    // Four points on one pixel: 3.0 and 3.49 are one layer, 3.5 starts the next, 3.9 belongs to it.
    let at = |z| (0, 0, z, 1.0, 0.5);
    let (points, colors) = points(&[at(3.0), at(3.49), at(3.5), at(3.9)]);
    let found = layers(
        View::new(&orthographic(), SIZE),
        &points,
        &colors,
        &PeelLayers { filters: NO_FILTER, layers: 9, ..PeelLayers::default() },
    );
    assert_eq!(found.iter().map(|layer| layer.depth[MIDDLE]).collect::<Vec<_>>(), [3.0, 3.5]);
    let narrow = ImageSpace { min_layer_distance: Some(0.375), ..NO_FILTER };
    let found = layers(
        View::new(&orthographic(), SIZE),
        &points,
        &colors,
        &PeelLayers { filters: narrow, layers: 9, ..PeelLayers::default() },
    );
    assert_eq!(found.iter().map(|layer| layer.depth[MIDDLE]).collect::<Vec<_>>(), [3.0, 3.49, 3.9]);
}

#[test]
fn points_behind_a_filled_hole_are_not_lost() {
    // The front has a hole through which the back shows; unfiltered, the back is the first layer there.
    let front: Vec<_> = plane(3.0, 1.0, 0.5).into_iter().filter(|p| (p.0, p.1) != (0, 0)).collect();
    let scene = [front, plane(6.0, 0.0, 0.5)].concat();
    let (points, colors) = points(&scene);
    let depths = |filters| {
        let found = layers(
            View::new(&orthographic(), SIZE),
            &points,
            &colors,
            &PeelLayers { filters, layers: 9, ..PeelLayers::default() },
        );
        found.iter().map(|layer| layer.depth[MIDDLE]).collect::<Vec<_>>()
    };
    assert_eq!(depths(NO_FILTER), [6.0, f64::INFINITY]);
    assert_eq!(depths(ImageSpace { occlusion: Iterations::Count(1), ..NO_FILTER }), [3.0, 6.0]);
    // The same with background in the hole of a layer that is alone.
    let alone: Vec<_> = plane(3.0, 1.0, 0.5).into_iter().filter(|p| (p.0, p.1) != (0, 0)).collect();
    let (points, colors) = self::points(&[alone, vec![(0, 0, 6.0, 0.25, 1.0)]].concat());
    let picture = |fill, occlusion| {
        let filters =
            ImageSpace { fill: Iterations::Count(fill), occlusion: Iterations::Count(occlusion), ..NO_FILTER };
        render(
            View::new(&orthographic(), SIZE),
            &points,
            &colors,
            &PeelLayers { filters, layers: 9, ..PeelLayers::default() },
        )
    };
    assert_eq!(picture(0, 0).rgba[MIDDLE], [0.25, 0.25, 0.25, 1.0]);
    // The filled pixel has its neighbor's alpha.
    assert_eq!(picture(0, 1).rgba[MIDDLE], [0.625, 0.625, 0.625, 1.0]);
    assert_eq!(picture(0, 1).depth[MIDDLE], 3.0);
}

#[test]
fn layers_end_where_there_is_background() {
    let (points, colors) = points(&[plane(3.0, 1.0, 0.5), vec![(2, 0, 5.0, 0.0, 0.5), (2, 0, 8.0, 0.0, 0.5)]].concat());
    let settings = PeelLayers { filters: NO_FILTER, layers: 9, ..PeelLayers::default() };
    assert_eq!(layers(View::new(&orthographic(), SIZE), &points, &colors, &settings).len(), 3);
    let picture = render(View::new(&orthographic(), SIZE), &points, &colors, &settings);
    assert_eq!([picture.counts[MIDDLE], picture.counts[MIDDLE + 2], picture.counts.iter().sum()], [1, 3, 83]);
    let empty = self::points(&[]);
    assert!(layers(View::new(&orthographic(), SIZE), &empty.0, &empty.1, &settings).is_empty());
}

#[test]
fn a_layer_that_cannot_be_seen_gives_no_depth() {
    let (points, colors) = points(&[plane(3.0, 1.0, 0.0), plane(5.0, 1.0, 0.5)].concat());
    let picture = render(
        View::new(&orthographic(), SIZE),
        &points,
        &colors,
        &PeelLayers { filters: NO_FILTER, layers: 4, ..PeelLayers::default() },
    );
    assert_eq!((picture.depth[MIDDLE], picture.counts[MIDDLE], picture.rgba[MIDDLE][3]), (5.0, 2, 0.5));
    let one = render(
        View::new(&orthographic(), SIZE),
        &points,
        &colors,
        &PeelLayers { filters: NO_FILTER, layers: 1, ..PeelLayers::default() },
    );
    assert_eq!((one.depth[MIDDLE], one.counts[MIDDLE], one.rgba[MIDDLE]), (f64::INFINITY, 1, [0.0; 4]));
}

#[test]
fn each_layer_is_softened_by_itself() {
    // A bar in front of a plane, both opaque: beside the bar the first layer is half of a quarter of it, the plane
    // behind.
    let bar = (-4..=4).map(|y| (0, y, 3.0, 1.0, 1.0)).collect();
    let (points, colors) = points(&[bar, plane(6.0, 0.0, 1.0)].concat());
    let filters = ImageSpace { antialias: true, ..NO_FILTER };
    let found = layers(
        View::new(&orthographic(), SIZE),
        &points,
        &colors,
        &PeelLayers { filters, layers: 4, ..PeelLayers::default() },
    );
    // All pixels have points in the first layer; the plane is the second one under the bar alone.
    assert_eq!(found.len(), 2);
    assert_eq!(found[0].rgba[MIDDLE + 1], [0.125, 0.125, 0.125, 1.0]);
    assert_eq!(found[1].depth[MIDDLE], 6.0);
    // The second layer is a line of black: half of it is left, beside it an eighth.
    assert_eq!(found[1].rgba[MIDDLE], [0.0, 0.0, 0.0, 0.75]);
    assert_eq!(found[1].rgba[MIDDLE + 1], [0.0, 0.0, 0.0, 0.125]);
}

#[test]
fn a_layer_shown_alone_has_its_own_color_alpha_and_depth() {
    let (points, colors) =
        points(&[plane(3.0, 0.5, 0.5), plane(4.0, 1.0, 0.25), vec![(1, 0, 7.0, 0.25, 0.75)]].concat());
    let alone = |only| {
        let settings = PeelLayers { filters: NO_FILTER, only: Some(only), ..PeelLayers::default() };
        render(View::new(&orthographic(), SIZE), &points, &colors, &settings)
    };
    for (only, rgba, z) in [(1, [0.25, 0.25, 0.25, 0.5], 3.0), (2, [0.25, 0.25, 0.25, 0.25], 4.0)] {
        let picture = alone(only);
        assert!(picture.rgba.iter().all(|found| *found == rgba), "{only}: {:?}", picture.rgba[MIDDLE]);
        assert!(picture.depth.iter().all(|found| *found == z) && picture.counts.iter().all(|count| *count == 1));
    }
    // The third is one pixel of background's; there is no fourth.
    let third = alone(3);
    assert_eq!(third.rgba[MIDDLE + 1], [0.1875, 0.1875, 0.1875, 0.75]);
    assert_eq!((third.depth[MIDDLE + 1], third.counts.iter().sum::<u32>()), (7.0, 1));
    assert_eq!((third.depth[MIDDLE], third.rgba[MIDDLE]), (f64::INFINITY, [0.0; 4]));
    let fourth = alone(4);
    assert!(fourth.counts.iter().all(|count| *count == 0) && fourth.rgba.iter().all(|rgba| *rgba == [0.0; 4]));
}
