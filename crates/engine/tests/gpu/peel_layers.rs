//! `peel-layers` against the float64 reference, and cases with known answers.

use std::path::Path;

use glam::{DVec3, Vec3};
use pellucid_core::camera::{Camera, Projection};
use pellucid_core::points::Points;
use pellucid_core::progress::Progress;
use pellucid_engine::methods::{Frame, Rendered, Renderer};
use pellucid_gpu::Device;
use pellucid_reference as reference;
use pellucid_reference::View;
use pellucid_reference::range::{PictureRange, ROUNDING};
use pellucid_scene::{
    self as scene, ColorSpace, ImageSpace, Iterations, Method, Overrides, PeelLayers, Scene, Shading, ShadingModel,
    procedural,
};
use pellucid_testing::*;
use rand::seq::SliceRandom;

/// Renders with 64-bit atomics where the device has them, and with two passes of 32 bits.
fn render_both(device: &Device, points: &Points, frame: &Frame) -> Rendered {
    let [wide, _narrow] = rendered_by_both_atomics(device, points, frame);
    wide
}

const NONE: ImageSpace = ImageSpace {
    fill: Iterations::Count(0),
    occlusion: Iterations::Count(0),
    smooth: 0,
    antialias: false,
    antialias_threshold: 0.25,
    min_layer_distance: Some(0.2),
    cull: false,
};

fn layers(filters: ImageSpace, layers: u32) -> PeelLayers {
    PeelLayers { filters, layers, ..PeelLayers::default() }
}

/// Bound of colors: that of `image_space.rs`, which layers have in proportion to what is seen of them, and four
/// roundings for each of up to nine layers.
pub(crate) const COLOR_ERROR: f64 = (50.0 * 12.92 + 9.0 * 4.0) * ROUNDING;

fn reference_of(points: &Points, frame: &Frame, settings: &PeelLayers) -> PictureRange {
    let colors = reference::shading::shade(points, &frame.camera, &frame.shading, frame.color);
    reference::peel_layers::ranges(View::new(&frame.camera, frame.size), points, &colors, settings)
}

/// Compares images, like [`compare_ranges`], and the counts of layers too.
fn compare(rendered: &Rendered, wanted: &PictureRange) -> Result<(), String> {
    compare_ranges(&rendered.image, wanted, COLOR_ERROR)?;
    let found = rendered.image.layers.as_ref().ok_or("no counts of layers")?;
    let off = |pixel: &usize| !wanted.counts[*pixel].covers(f64::from(found[*pixel]), 0.0);
    match (0..found.len()).find(off) {
        None => Ok(()),
        Some(pixel) => Err(format!("pixel {pixel}: {} layers, not {:?}", found[pixel], wanted.counts[pixel])),
    }
}

#[test]
fn layers_equal_the_reference() {
    with_device(|device| {
        let size = [80, 60];
        let shaded = Shading { model: ShadingModel::Phong, specular: 0.3, ..Shading::default() };
        let cases = [
            (layers(NONE, 4), Shading::NONE, ColorSpace::Linear),
            (PeelLayers::default(), shaded, ColorSpace::Encoded),
            (
                layers(
                    ImageSpace {
                        fill: Iterations::Count(2),
                        occlusion: Iterations::Count(2),
                        smooth: 1,
                        cull: true,
                        ..NONE
                    },
                    9,
                ),
                shaded,
                ColorSpace::Linear,
            ),
            (
                layers(ImageSpace { occlusion: Iterations::Count(1), antialias: true, ..NONE }, 3),
                Shading::NONE,
                ColorSpace::Linear,
            ),
            (PeelLayers { only: Some(1), ..PeelLayers::default() }, shaded, ColorSpace::Linear),
            (PeelLayers { only: Some(3), ..PeelLayers::default() }, shaded, ColorSpace::Encoded),
            (
                layers(ImageSpace { fill: Iterations::Auto, occlusion: Iterations::Auto, ..NONE }, 3),
                Shading::NONE,
                ColorSpace::Linear,
            ),
            (
                layers(ImageSpace { fill: Iterations::Count(1), occlusion: Iterations::Count(1), ..NONE }, 1),
                Shading::NONE,
                ColorSpace::Linear,
            ),
        ];
        for camera in [perspective(), orthographic()] {
            for (settings, shading, color) in cases {
                let mut soup = soup(17, 8000, 0.0..0.1, 0.1..0.9, true);
                soup.iter_mut().step_by(9).for_each(|p| p.normal = Vec3::ZERO);
                let points = clear_points(&soup, &camera, size, &shading);
                let frame = Frame { shading, color, ..frame(camera, size, Method::PeelLayers(settings)) };
                let rendered = render_both(device, &points, &frame);
                let found = compare(&rendered, &reference_of(&points, &frame, &settings));
                assert!(found.is_ok(), "{settings:?}: {found:?}");
            }
        }
    });
}

#[test]
fn the_comparison_notices_other_settings() {
    with_device(|device| {
        let (camera, size) = (perspective(), [80, 60]);
        let points = clear_points(&soup(18, 8000, 0.0..0.1, 0.1..0.9, false), &camera, size, &Shading::NONE);
        let filters = ImageSpace { min_layer_distance: Some(0.3), cull: false, ..ImageSpace::default() };
        let settings = layers(filters, 4);
        let frame = frame(camera, size, Method::PeelLayers(settings));
        let rendered = render_both(device, &points, &frame);
        let compared = |settings: &PeelLayers| compare(&rendered, &reference_of(&points, &frame, settings));
        compared(&settings).expect("its own reference");
        for other in [
            layers(filters, 3),
            layers(filters, 5),
            layers(ImageSpace { fill: Iterations::Count(2), ..filters }, 4),
            layers(ImageSpace { occlusion: Iterations::Count(0), ..filters }, 4),
            layers(ImageSpace { smooth: 0, ..filters }, 4),
            layers(ImageSpace { antialias: false, ..filters }, 4),
            layers(ImageSpace { min_layer_distance: Some(0.6), ..filters }, 4),
        ] {
            compared(&other).expect_err("other settings");
        }
        // A single pixel: color, and the count of layers.
        let wanted = reference_of(&points, &frame, &settings);
        let middle = rendered.image.rgba.len() / 2 + 40;
        let mut image = rendered.image.clone();
        image.rgba[middle][2] += 3.0 * COLOR_ERROR as f32;
        compare_ranges(&image, &wanted, COLOR_ERROR).expect_err("another color");
        let found = rendered.image.layers.as_ref().expect("they were asked for")[middle];
        assert!(!wanted.counts[middle].covers(f64::from(found) + 1.0, 0.0), "another count");
    });
}

/// A full image of points at one depth.
fn plane(size: [u32; 2], z: f64, color: Vec3, opacity: f32) -> Vec<P> {
    let all = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y)));
    all.map(|(x, y)| P {
        position: at_pixel(f64::from(x) + 0.5, f64::from(y) + 0.5, z),
        color,
        opacity,
        radius: 0.0,
        normal: Vec3::ZERO,
    })
    .collect()
}

fn shown(device: &Device, points: &[P], size: [u32; 2], settings: PeelLayers) -> Rendered {
    render_both(device, &scene(points), &frame(pixel_camera(size), size, Method::PeelLayers(settings)))
}

#[test]
fn planes_are_blended_by_their_opacities() {
    with_device(|device| {
        let size = [7, 5];
        let (a, b, c) = (0.3f32, 0.6f32, 0.9f32);
        let two = [plane(size, 6.0, Vec3::Y, b), plane(size, 5.0, Vec3::X, a)].concat();
        let three = [two.clone(), plane(size, 9.0, Vec3::Z, c)].concat();
        for (points, planes) in [(&two, 2), (&three, 3)] {
            for most in 1..=5 {
                // Filters do nothing to full planes, but at the border of the image antialiasing would.
                let filters =
                    ImageSpace { fill: Iterations::Count(1), occlusion: Iterations::Count(1), smooth: 1, ..NONE };
                let rendered = shown(device, points, size, layers(filters, most));
                let count = most.min(planes);
                let of = |layer, value| if layer <= count { value } else { 0.0 };
                let wanted = [of(1, a), of(2, (1.0 - a) * b), of(3, (1.0 - a) * (1.0 - b) * c)];
                let wanted = [wanted[0], wanted[1], wanted[2], wanted.iter().sum()];
                for rgba in &rendered.image.rgba {
                    assert!(rgba.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-6), "{rgba:?} {wanted:?}");
                }
                assert!(rendered.image.depth.iter().all(|z| *z == 5.0));
                assert!(rendered.image.layers.as_ref().is_some_and(|l| l.iter().all(|l| *l == count)));
                // Nothing is left behind the last plane: the loop ends there.
                assert_eq!(rendered.facts.layers, count);
            }
        }
    });
}

#[test]
fn points_nearer_than_the_distance_are_one_layer() {
    with_device(|device| {
        let size = [4, 3];
        let gray = |z, opacity| plane(size, z, Vec3::ONE, opacity);
        // Powers of two, so that the border is exact: 4.25 belongs to the second layer, just before does not.
        let points = [gray(4.0, 0.5), gray(4.2499, 1.0), gray(4.25, 0.5), gray(4.3, 1.0), gray(7.0, 0.5)].concat();
        let of = |distance| {
            let rendered =
                shown(device, &points, size, layers(ImageSpace { min_layer_distance: Some(distance), ..NONE }, 9));
            (rendered.facts.layers, rendered.image.rgba[5][3])
        };
        assert_eq!(of(0.25), (3, 0.875));
        assert_eq!(of(0.3125), (2, 0.75));
        assert_eq!(of(4.0), (1, 0.5));
    });
}

#[test]
fn the_back_is_not_lost_behind_filled_holes() {
    with_device(|device| {
        let size = [9, 9];
        let front: Vec<P> = plane(size, 4.0, Vec3::X, 0.5)
            .into_iter()
            .enumerate()
            .filter(|(i, _)| i % 5 != 0)
            .map(|(_, p)| p)
            .collect();
        let points = [front, plane(size, 8.0, Vec3::Y, 0.5)].concat();
        let unfilled = shown(device, &points, size, layers(NONE, 4));
        assert!(unfilled.image.rgba[40] == [0.0, 0.5, 0.0, 0.5], "{:?}", unfilled.image.rgba[40]);
        let filled = shown(device, &points, size, layers(ImageSpace { occlusion: Iterations::Count(1), ..NONE }, 4));
        // Those inside, where no mask reaches over the image's border.
        for y in 1..8 {
            for x in 1..8 {
                assert_eq!(filled.image.rgba[y * 9 + x], [0.5, 0.25, 0.0, 0.75], "({x}, {y})");
            }
        }
        assert_eq!(filled.facts.layers, 2);
    });
}

#[test]
fn layers_without_opacity_give_no_depth_and_nothing_ends_early() {
    with_device(|device| {
        let size = [5, 5];
        let points = [plane(size, 4.0, Vec3::X, 0.0), plane(size, 6.0, Vec3::Y, 1.0), plane(size, 8.0, Vec3::Z, 0.5)];
        let of = |most| shown(device, &points.concat(), size, layers(NONE, most)).image;
        assert_eq!((of(1).rgba[12], of(1).depth[12]), ([0.0; 4], f32::INFINITY));
        for most in [2, 3, 9] {
            assert_eq!((of(most).rgba[12], of(most).depth[12]), ([0.0, 1.0, 0.0, 1.0], 6.0));
        }
        let none = shown(device, &[P { position: DVec3::Z, ..points[0][0] }], size, PeelLayers::default());
        assert_eq!(none.facts.layers, 0);
        assert!(none.image.rgba.iter().all(|c| *c == [0.0; 4]));
    });
}

/// The built-in scene of so many points, with its camera.
fn tori(points: u32, size: [u32; 2]) -> (Points, Camera) {
    let generated = procedural::build("tori", &[("points".into(), f64::from(points))], 0).expect("it is built in");
    let scene = Scene::from_toml_with(&generated.scene_toml, Path::new("tori"), &Overrides::default()).expect("valid");
    let clouds = scene::take_generated(&scene, &generated).expect("its own");
    let points = scene::assemble(&scene, clouds, false, &Progress::hidden()).expect("points");
    let fov_y = 38f64.to_radians();
    let camera = Camera::look_at(
        DVec3::new(0.0, -3.3, 3.3),
        DVec3::new(0.0, -0.1, 0.0),
        DVec3::Z,
        Projection::Perspective { fov_y },
        1.0,
        8.0,
    )
    .expect("valid");
    assert!(size[0] == size[1]);
    (points, camera)
}

const TUBES: [f64; 3] = [0.15, 0.30, 0.45];

/// The depths at which the ray through an image position meets the three tori, nearest first, and how near it comes to
/// touching one: the least distance between a tube's radius and an extremum of the distance from the circle, over the
/// radius.
fn hits(camera: &Camera, size: [u32; 2], x: f64, y: f64) -> (Vec<f64>, f64) {
    const STEPS: usize = 3000;
    let focal = camera.focal_px(size[1]);
    let (right, down) = ((x - 0.5 * f64::from(size[0])) / focal, (y - 0.5 * f64::from(size[1])) / focal);
    let ray = camera.forward + right * camera.right - down * camera.up;
    let z_at = |step: usize| 2.5 + 4.5 * step as f64 / STEPS as f64;
    let from_circle = |z: f64| {
        let p = camera.eye + z * ray;
        (p.x.hypot(p.y) - 1.0).hypot(p.z)
    };
    let distances: Vec<f64> = (0..=STEPS).map(|step| from_circle(z_at(step))).collect();
    let crosses = |step: &usize, tube: f64| (distances[*step] < tube) != (distances[step + 1] < tube);
    let mut found: Vec<f64> =
        TUBES.iter().flat_map(|&tube| (0..STEPS).filter(move |step| crosses(step, tube)).map(z_at)).collect();
    found.sort_by(f64::total_cmp);
    let extrema = distances.windows(3).filter(|d| (d[1] - d[0]) * (d[2] - d[1]) <= 0.0).map(|d| d[1]);
    let touching = extrema.flat_map(|d| TUBES.map(|tube| (d - tube).abs() / tube)).fold(f64::INFINITY, f64::min);
    (found, touching)
}

#[test]
fn nested_tori_have_a_layer_for_each_surface_that_a_ray_meets() {
    with_device(|device| {
        const SIDE: usize = 192;
        let size = [SIDE as u32; 2];
        let (points, camera) = tori(600_000, size);
        // A spacing of 0.008 and pixels of 0.018: up to 60° the depths of neighbors differ by less than this, and the
        // tubes are 0.15 apart.
        let distance = 0.08;
        let filters = ImageSpace {
            fill: Iterations::Count(2),
            occlusion: Iterations::Count(2),
            min_layer_distance: Some(distance),
            ..NONE
        };
        let frame = frame(camera, size, Method::PeelLayers(layers(filters, 16)));
        let rendered = render_both(device, &points, &frame);
        let counts = rendered.image.layers.as_ref().expect("they were asked for");
        let place = |pixel: usize| [pixel % SIDE, pixel / SIDE].map(|at| at as f64 + 0.5);
        let rays: Vec<(Vec<f64>, f64)> =
            (0..SIDE * SIDE).map(|pixel| hits(&camera, size, place(pixel)[0], place(pixel)[1])).collect();
        // Away from silhouettes, where a surface is steeper than that, and where two are nearer than layers may be.
        let is_clear = |pixel: usize| {
            let (depths, touching) = &rays[pixel];
            let apart = depths.windows(2).all(|pair| pair[1] - pair[0] > 1.5 * f64::from(distance));
            // At the inner corners of a silhouette's steps the filters take what is nearer for one surface with its
            // surroundings.
            let mut around = (0..81).map(|i| pixel + (i / 9) * SIDE + i % 9 - 4 * SIDE - 4);
            // A ray 13/15 of a tube's radius from its middle meets it at asin(13/15) = 60°.
            *touching > 2.0 / 15.0 && apart && around.all(|other| rays[other].0.len() == depths.len())
        };
        let mut seen = [0; 20];
        let inside = |pixel: &usize| place(*pixel).iter().all(|at| (5.0..SIDE as f64 - 5.0).contains(at));
        for pixel in (0..SIDE * SIDE).filter(inside).filter(|pixel| is_clear(*pixel)) {
            let (depths, _) = &rays[pixel];
            assert_eq!(counts[pixel] as usize, depths.len(), "{:?}: {depths:?}", place(pixel));
            if let Some(nearest) = depths.first() {
                let z = f64::from(rendered.image.depth[pixel]);
                assert!((z - nearest).abs() < f64::from(distance), "{:?}: {z} {depths:?}", place(pixel));
            }
            seen[depths.len()] += 1;
        }
        println!("pixels by number of surfaces: {seen:?}, {} layers", rendered.facts.layers);
        assert!(seen[6] > 1000 && seen[4] > 200 && seen[2] > 200 && seen[0] > 1000, "{seen:?}");
    });
}

#[test]
fn shuffled_input_changes_no_byte_although_depths_tie() {
    with_device(|device| {
        let mut points = soup(3, 6000, 0.0..0.1, 0.1..0.9, true);
        for p in &mut points {
            p.position.z = (p.position.z * 4.0).round() / 4.0;
        }
        let camera = Camera {
            eye: DVec3::new(0.0, 0.0, 4.0),
            right: DVec3::X,
            up: DVec3::Y,
            forward: DVec3::NEG_Z,
            ..orthographic()
        };
        let settings = layers(ImageSpace { min_layer_distance: Some(0.25), ..PeelLayers::default().filters }, 8);
        let frame = frame(camera, [70, 70], Method::PeelLayers(settings));
        let first = bits(&render_both(device, &scene(&points), &frame).image);
        points.shuffle(&mut random(9));
        assert!(bits(&render_both(device, &scene(&points), &frame).image) == first);
    });
}

#[test]
fn no_budget_and_no_other_frame_changes_a_byte() {
    with_device(|device| {
        let points = scene(&soup(31, 12_000, 0.0..0.1, 0.1..0.9, true));
        let filters = ImageSpace {
            fill: Iterations::Count(2),
            occlusion: Iterations::Count(2),
            smooth: 2,
            min_layer_distance: Some(0.1),
            ..PeelLayers::default().filters
        };
        let mut frame = frame(perspective(), [100, 74], Method::PeelLayers(layers(filters, 6)));
        let mut renderer = Renderer::new(device).expect("a renderer");
        let mut cloud = renderer.upload(&points).expect("fits");
        let whole = renderer.render(&mut cloud, &frame).expect("renders");
        assert_eq!(whole.facts.windows, 1);
        let mut cuts = 0;
        for budget in [512 << 10, 384 << 10, 256 << 10] {
            frame.memory_budget = Some(budget);
            let cut = renderer.render(&mut cloud, &frame).expect("renders");
            cuts += usize::from(cut.facts.windows > 1);
            assert!(bits(&cut.image) == bits(&whole.image), "budget {budget}: {:?}", cut.facts);
            assert_eq!((&cut.image.layers, cut.facts.layers), (&whole.image.layers, whole.facts.layers));
        }
        assert!(cuts > 0, "some budget cuts the image");
        frame.memory_budget = None;
        let other = Frame { size: [64, 200], camera: orthographic(), ..frame };
        renderer.render(&mut cloud, &other).expect("renders");
        renderer.render(&mut cloud, &Frame { method: Method::Points, ..frame }).expect("renders");
        assert!(bits(&renderer.render(&mut cloud, &frame).expect("renders").image) == bits(&whole.image));
    });
}

#[test]
fn one_opaque_layer_is_image_space() {
    with_device(|device| {
        let mut soup = soup(8, 6000, 0.0..0.1, 0.1..0.9, true);
        soup.iter_mut().for_each(|p| p.opacity = 1.0);
        let points = scene(&soup);
        for filters in [ImageSpace::default(), ImageSpace { fill: Iterations::Count(2), smooth: 2, ..NONE }] {
            let of = |method| bits(&render_both(device, &points, &frame(perspective(), [80, 60], method)).image);
            assert!(of(Method::PeelLayers(layers(filters, 1))) == of(Method::ImageSpace(filters)));
        }
    });
}

#[test]
fn a_layer_shown_alone_is_as_it_is_behind_the_others() {
    with_device(|device| {
        let size = [30, 20];
        let sheets = [(3.0, Vec3::X, 0.5), (4.0, Vec3::Y, 1.0), (5.0, Vec3::Z, 0.25), (6.0, Vec3::ONE, 0.0)];
        let all: Vec<P> = sheets.iter().flat_map(|(z, color, opacity)| plane(size, *z, *color, *opacity)).collect();
        let points = scene(&all);
        let alone = |only, layers| {
            let settings = PeelLayers { filters: NONE, layers, only: Some(only) };
            render_both(device, &points, &frame(pixel_camera(size), size, Method::PeelLayers(settings)))
        };
        for (number, (z, color, opacity)) in (1..).zip(sheets) {
            let found = alone(number, 9);
            let wanted = (opacity * color).extend(opacity).to_array();
            let depth = if opacity > 0.0 { z as f32 } else { f32::INFINITY };
            assert!(found.image.rgba.iter().all(|rgba| *rgba == wanted), "{number}: {:?}", found.image.rgba[0]);
            assert!(found.image.depth.iter().all(|z| *z == depth), "{number}: {}", found.image.depth[0]);
            assert!(found.image.layers.expect("asked for").iter().all(|layers| *layers == 1));
            // None is peeled behind it.
            assert_eq!(found.facts.layers, number);
            assert!(bits(&alone(number, number).image) == bits(&alone(number, 9).image));
        }
        let none = alone(5, 5);
        assert!(none.image.rgba.iter().all(|rgba| *rgba == [0.0; 4]));
        assert!(none.image.depth.iter().all(|z| *z == f32::INFINITY));
        // Beyond a batch of layers.
        let many: Vec<P> =
            (0..12u8).flat_map(|i| plane(size, 3.0 + f64::from(i), Vec3::splat(f32::from(i) / 16.0), 0.5)).collect();
        let points = scene(&many);
        let settings = PeelLayers { filters: NONE, layers: 12, only: Some(11) };
        let found = render_both(device, &points, &frame(pixel_camera(size), size, Method::PeelLayers(settings)));
        assert_eq!((found.image.rgba[77], found.image.depth[77]), ([0.3125, 0.3125, 0.3125, 0.5], 13.0));
    });
}
