//! References where roundings decide: nothing is open but that, and what is exact is never left out.

use std::sync::Arc;

use super::*;
use pellucid_reference::coverage::possible;
use pellucid_reference::range::{PictureRange, ROUNDING as ROUNDED, Range};
use pellucid_reference::shadows::{Frames, Map, frames, share_ranges, shares};
use pellucid_reference::spbr::Rule;
use pellucid_reference::{image_space, peel_layers, spbr, splats};
use pellucid_scene::prepare::ensembles::{CloudSurface, Dealt};
use pellucid_scene::{BlendedSplats, ImageSpace, Iterations, PeelLayers};
use pellucid_testing_host::{P, soup};

/// Points in the order given.
fn points(all: &[P]) -> Points {
    Points {
        positions: all.iter().map(|p| p.position).collect(),
        colors: all.iter().map(|p| p.color).collect(),
        opacities: all.iter().map(|p| p.opacity).collect(),
        radii: all.iter().map(|p| p.radius).collect(),
        normals: Some(all.iter().map(|p| p.normal).collect()),
        ..Points::default()
    }
}

fn colors(points: &Points) -> Vec<DVec3> {
    points.colors.iter().map(|c| c.as_dvec3()).collect()
}

fn point(x: f64, y: f64, z: f64, color: Vec3) -> P {
    P { position: DVec3::new(x, y, -z), color, opacity: 0.5, radius: 1.0, normal: Vec3::ZERO }
}

/// The pixel in the middle of [`SIZE`].
const MIDDLE: usize = 40;

/// Nothing but the nearest points, with layers half a unit apart.
const BARE: ImageSpace = ImageSpace {
    fill: Iterations::Count(0),
    occlusion: Iterations::Count(0),
    smooth: 0,
    antialias: false,
    antialias_threshold: 0.25,
    min_layer_distance: Some(0.5),
    cull: false,
};

/// Asserts that a picture lies within ranges, and returns in how many pixels these are wide.
#[track_caller]
fn assert_within(picture: &ReferencePicture, ranges: &PictureRange) -> usize {
    let mut wide = 0;
    for pixel in 0..picture.rgba.len() {
        let colors = picture.rgba[pixel].iter().zip(ranges.rgba[pixel]);
        assert!(colors.clone().all(|(value, range)| range.covers(*value, ROUNDING)), "pixel {pixel}");
        assert!(ranges.depth[pixel].covers(picture.depth[pixel], 0.0), "pixel {pixel}");
        assert!(ranges.counts[pixel].covers(f64::from(picture.counts[pixel]), 0.0), "pixel {pixel}");
        wide += usize::from(colors.clone().any(|(_, range)| range.high - range.low > 1e-3));
    }
    wide
}

#[test]
fn of_two_points_the_nearer_one_is_seen_unless_roundings_make_them_equal() {
    let of = |apart: f64, settings: &ImageSpace| {
        let two = points(&[point(0.1, 0.1, 5.0, Vec3::X), point(-0.1, -0.1, 5.0 + apart, Vec3::Y)]);
        image_space::ranges(View::new(&orthographic(), SIZE), &two, &colors(&two), settings)
    };
    let only = of(1e-5, &BARE);
    assert_eq!(only.rgba[MIDDLE], [1.0, 0.0, 0.0, 1.0].map(Range::only));
    assert_eq!(only.counts[MIDDLE], Range::only(1.0));
    assert_eq!(only.rgba[0], [Range::only(0.0); 4]);
    let either = Range { low: 0.0, high: 1.0 };
    // 5 has roundings of 3e-7.
    assert_eq!(of(1e-7, &BARE).rgba[MIDDLE], [either, either, Range::only(0.0), Range::only(1.0)]);
}

#[test]
fn a_layer_ends_at_a_distance_that_roundings_decide() {
    let of = |apart: f64| {
        let two = points(&[point(0.1, 0.1, 5.0, Vec3::X), point(-0.1, -0.1, 5.5 + apart, Vec3::Y)]);
        let settings = PeelLayers { filters: BARE, layers: 2, ..PeelLayers::default() };
        let ranges = peel_layers::ranges(View::new(&orthographic(), SIZE), &two, &colors(&two), &settings);
        (ranges.counts[MIDDLE], ranges.rgba[MIDDLE][1])
    };
    assert_eq!(of(1e-4), (Range::only(2.0), Range::only(0.25)));
    assert_eq!(of(-1e-4), (Range::only(1.0), Range::only(0.0)));
    assert_eq!(of(0.0), (Range { low: 1.0, high: 2.0 }, Range { low: 0.0, high: 0.25 }));
}

#[test]
fn rims_and_borders_are_open_as_far_as_roundings_reach() {
    let found = |splat: Splat, x: u32| {
        let all = possible(View::new(&orthographic(), SIZE), &splat, 0..SIZE[1]);
        all.iter().find(|p| (p.x, p.y) == (x, 4)).map(|p| p.sure)
    };
    // The center of the pixel to the right is one unit from the middle.
    let disc = |radius: f64| found(flat(Shape::Disc, -5.0 * DVec3::Z, radius), 5);
    assert_eq!(
        [disc(1.0 + 1e-5), disc(1.0 + 1e-8), disc(1.0 - 1e-8), disc(1.0 - 1e-5)],
        [Some(true), Some(false), Some(false), None]
    );
    // Borders are decided by more digits.
    let home = |x: f64| found(flat(Shape::Point, DVec3::new(x, 0.0, -5.0), 0.0), 4);
    assert_eq!(
        [home(0.5 - 1e-8), home(0.5 - 1e-14), home(0.5 + 1e-14), home(0.5 + 1e-8)],
        [Some(true), Some(false), Some(false), None]
    );
    // Seen from the side at 60° the disc's half width is half its radius.
    let tilted = |radius: f64| found(oriented(-5.0 * DVec3::Z, radius, tilted(60.0)), 5);
    assert_eq!([tilted(2.0 + 1e-4), tilted(2.0 + 1e-8), tilted(2.0 - 1e-4)], [Some(true), Some(false), None]);
    // Edge-on nothing is known but the center's pixel.
    let edge_on = oriented(-5.0 * DVec3::Z, 3.0, DVec3::X);
    assert!(
        possible(View::new(&orthographic(), SIZE), &edge_on, 0..SIZE[1])
            .iter()
            .all(|p| p.sure == ((p.x, p.y) == (4, 4)))
    );
}

#[test]
fn a_splat_that_roundings_decide_moves_the_mean_by_its_share() {
    // The second one's rim is on the pixel's center: weights of 1 and e^−2.
    let of = |x: f64| {
        let two = points(&[point(0.0, 0.0, 5.0, Vec3::ZERO), point(x, 0.0, 5.0, Vec3::ONE)]);
        splats::ranges(View::new(&orthographic(), SIZE), &two, &colors(&two), Shape::Disc, &BlendedSplats::default())
            .rgba[MIDDLE]
    };
    let share = 1.0 / (1.0 + 2f64.exp());
    let open = of(1.0)[0];
    assert!(open.low == 0.0 && (open.high - share).abs() < 1e-5, "{open:?}");
    let inside = of(0.999)[0];
    assert!((inside.low - share).abs() < 1e-3 && inside.high - inside.low < 1e-5, "{inside:?}");
    assert!(of(1.001)[0].high < 1e-9);
}

#[test]
fn ranges_contain_the_exact_values_and_most_are_closed() {
    let all = points(&soup(3, 600, 0.05..0.3, 0.1..0.9, true));
    let camera = Camera::look_at(
        DVec3::new(1.0, 1.5, 4.0),
        DVec3::ZERO,
        DVec3::Y,
        Projection::Perspective { fov_y: 0.8 },
        0.1,
        100.0,
    )
    .unwrap();
    let (size, colors) = ([48, 40], colors(&all));
    let filters = ImageSpace {
        fill: Iterations::Count(2),
        occlusion: Iterations::Count(2),
        smooth: 2,
        min_layer_distance: Some(0.1),
        ..ImageSpace::default()
    };
    let exact = image_space::render(View::new(&camera, size), &all, &colors, &filters);
    assert_eq!(assert_within(&exact, &image_space::ranges(View::new(&camera, size), &all, &colors, &filters)), 0);
    let layers = PeelLayers { filters, layers: 5, ..PeelLayers::default() };
    let exact = peel_layers::render(View::new(&camera, size), &all, &colors, &layers);
    assert_eq!(assert_within(&exact, &peel_layers::ranges(View::new(&camera, size), &all, &colors, &layers)), 0);
    for shape in [Shape::Disc, Shape::Square, Shape::Oriented] {
        let settings = BlendedSplats::default();
        let exact = splats::render(View::new(&camera, size), &all, &colors, shape, &settings);
        let wide = assert_within(&exact, &splats::ranges(View::new(&camera, size), &all, &colors, shape, &settings));
        assert!(wide < 20, "{shape:?}: {wide} pixels");
    }
    let bounds = all.bounds().unwrap();
    let lights: Vec<Frames> = [Light::Direction(DVec3::NEG_Y), Light::Position(DVec3::new(0.1, 0.2, 0.0))]
        .map(|light| frames(&light, &bounds, 40))
        .to_vec();
    let map = Map { resolution: 40, fill: 2, occlusion: 3, distance: 0.1 };
    let (exact, ranges) = (shares(&lights, map, &all), share_ranges(&lights, map, &all));
    assert!(exact.iter().zip(&ranges).all(|(m, range)| range.covers(*m, ROUNDED)));
    let map = Map { fill: 0, occlusion: 1, ..map };
    let (exact, ranges) = (shares(&lights, map, &all), share_ranges(&lights, map, &all));
    assert!(exact.iter().zip(&ranges).all(|(m, range)| range.covers(*m, ROUNDED)));
    // The frame of a light puts the sides of the box on borders of pixels; nothing else is open.
    let on_side = |p: DVec3| p.cmpeq(bounds.min).any() || p.cmpeq(bounds.max).any();
    assert!(ranges.iter().zip(&all.positions).all(|(range, p)| range.low == range.high || on_side(*p)));
    assert!(exact.contains(&0.0) && exact.contains(&0.5) && exact.contains(&1.0));
}

/// A cloud of one point of this opacity before a camera of one pixel per unit, one of L copies of it in each ensemble.
fn lone(opacity: f32, at: DVec3) -> Dealt {
    let mut dealt = Dealt::default();
    *Arc::make_mut(&mut dealt.points) = points(&[P { position: at, opacity, ..point(0.0, 0.0, 0.0, Vec3::ONE) }]);
    dealt.surfaces.push(CloudSurface { points: 0..1, center: at, density: 1e-9, opacity: 0.5 });
    dealt
}

#[test]
fn points_on_a_border_are_on_one_of_two_pixels() {
    let rule = Rule { ensembles: 3, adjust: true, cos_theta: true };
    let of = |x: f64| {
        let dealt = lone(0.5, DVec3::new(x, 0.0, -5.0));
        let ranges = spbr::ranges(View::new(&orthographic(), SIZE), &dealt, &[DVec3::ONE], &rule, 1);
        let (exact, errors) = spbr::render(View::new(&orthographic(), SIZE), &dealt, &[DVec3::ONE], &rule, 1);
        for pixel in 0..exact.rgba.len() {
            assert!(exact.rgba[pixel].iter().zip(ranges.rgba[pixel]).all(|(v, range)| range.covers(*v, ROUNDING)));
            assert!(ranges.depth[pixel].covers(exact.depth[pixel], 0.0));
            let errors = errors[pixel].to_array();
            assert!(errors.iter().zip(ranges.stderr[pixel]).all(|(v, range)| range.covers(*v, 1e-7)));
        }
        [ranges.rgba[MIDDLE][3], ranges.rgba[MIDDLE + 1][3]]
    };
    let (none, all, open) = (Range::only(0.0), Range::only(1.0), Range { low: 0.0, high: 1.0 });
    assert_eq!(of(0.2), [all, none]);
    assert_eq!(of(0.5 - 1e-8), [open, open]);
    assert_eq!(of(0.8), [none, all]);
}
