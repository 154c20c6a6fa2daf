//! `image-space` against the float64 reference, and cases with known answers.

use std::path::PathBuf;

use glam::{DVec3, Vec3};
use pellucid_core::camera::Camera;
use pellucid_core::image::Image;
use pellucid_core::points::Points;
use pellucid_core::progress::Progress;
use pellucid_engine::methods::{Frame, Rendered, Renderer};
use pellucid_gpu::Device;
use pellucid_reference as reference;
use pellucid_reference::View;
use pellucid_reference::range::{PictureRange, ROUNDING};
use pellucid_scene::prepare;
use pellucid_scene::{
    self as scene, ColorSpace, Edl, ImageSpace, Iterations, Light, Method, Overrides, Scene, Shading, ShadingModel,
};
use pellucid_testing::*;
use rand::RngExt;
use rand::seq::SliceRandom;

/// Renders with 64-bit atomics where the device has them, and with two passes of 32 bits.
fn render_both(device: &Device, points: &Points, frame: &Frame) -> Rendered {
    let [wide, _narrow] = rendered_by_both_atomics(device, points, frame);
    wide
}

/// No filter at all, and layers a twentieth apart.
const NONE: ImageSpace = ImageSpace {
    fill: Iterations::Count(0),
    occlusion: Iterations::Count(0),
    smooth: 0,
    antialias: false,
    antialias_threshold: 0.25,
    min_layer_distance: Some(0.05),
    cull: true,
};

const SHADED: Shading = Shading {
    model: ShadingModel::Phong,
    ambient: 0.2,
    diffuse: 0.7,
    specular: 0.3,
    shininess: 8.0,
    light: Light::Direction(DVec3::new(0.3, -1.0, -0.8)),
    edl: Edl { edl: false, edl_strength: 1.0, edl_radius: 1.4 },
};

/// A shaded color has fewer than fifty roundings behind it, of numbers up to 1, and the curve of sRGB is 12.92 times as
/// steep as linear light.
pub(crate) const COLOR_ERROR: f64 = 50.0 * 12.92 * ROUNDING;

fn reference_of(points: &Points, camera: &Camera, frame: &Frame, filters: &ImageSpace) -> PictureRange {
    let colors = reference::shading::shade(points, camera, &frame.shading, frame.color);
    reference::image_space::ranges(View::new(camera, frame.size), points, &colors, filters)
}

#[test]
fn images_equal_the_reference() {
    with_device(|device| {
        let size = [96, 72];
        let default = ImageSpace::default();
        let cases = [
            (default, Shading::NONE, ColorSpace::Linear),
            (
                ImageSpace {
                    fill: Iterations::Count(3),
                    occlusion: Iterations::Count(3),
                    smooth: 3,
                    cull: false,
                    ..NONE
                },
                SHADED,
                ColorSpace::Encoded,
            ),
            (
                ImageSpace { fill: Iterations::Count(2), antialias: true, antialias_threshold: 0.0, ..NONE },
                SHADED,
                ColorSpace::Linear,
            ),
            (
                ImageSpace {
                    occlusion: Iterations::Count(2),
                    antialias: true,
                    antialias_threshold: 1.0,
                    min_layer_distance: Some(0.6),
                    ..NONE
                },
                Shading { model: ShadingModel::Lambert, light: Light::Position(DVec3::new(3.0, 2.0, 5.0)), ..SHADED },
                ColorSpace::Linear,
            ),
            (ImageSpace { smooth: 1, ..NONE }, Shading::NONE, ColorSpace::Linear),
            (
                ImageSpace { fill: Iterations::Auto, occlusion: Iterations::Auto, ..NONE },
                Shading::NONE,
                ColorSpace::Linear,
            ),
        ];
        for camera in [perspective(), orthographic()] {
            // Sparse ones, which leave holes, and enough for most pixels.
            for (count, normals) in [(1500, true), (9000, false), (9000, true)] {
                let mut soup = soup(count as u64, count, 0.0..0.1, 0.1..0.9, normals);
                soup.iter_mut().step_by(9).for_each(|p| p.normal = Vec3::ZERO);
                for (filters, shading, color) in cases {
                    let points = clear_points(&soup, &camera, size, &shading);
                    assert!(points.len() > count * 8 / 10, "{}", points.len());
                    let frame = Frame { shading, color, ..frame(camera, size, Method::ImageSpace(filters)) };
                    let wanted = reference_of(&points, &camera, &frame, &filters);
                    let image = render_both(device, &points, &frame).image;
                    let found = compare_ranges(&image, &wanted, COLOR_ERROR);
                    assert!(found.is_ok(), "{count} {filters:?}: {found:?}");
                }
            }
        }
    });
}

#[test]
fn the_comparison_notices_other_settings() {
    with_device(|device| {
        let (camera, size) = (perspective(), [96, 72]);
        let points = clear_points(&soup(5, 9000, 0.0..0.1, 0.1..0.9, true), &camera, size, &SHADED);
        let filters = ImageSpace { min_layer_distance: Some(0.3), ..ImageSpace::default() };
        let frame = Frame { shading: SHADED, ..frame(camera, size, Method::ImageSpace(filters)) };
        let image = render_both(device, &points, &frame).image;
        let compared = |filters: &ImageSpace| {
            compare_ranges(&image, &reference_of(&points, &camera, &frame, filters), COLOR_ERROR)
        };
        compared(&filters).expect("its own reference");
        for other in [
            ImageSpace { fill: Iterations::Count(0), ..filters },
            ImageSpace { fill: Iterations::Count(2), ..filters },
            ImageSpace { occlusion: Iterations::Count(0), ..filters },
            ImageSpace { occlusion: Iterations::Count(2), ..filters },
            ImageSpace { smooth: 0, ..filters },
            ImageSpace { smooth: 2, ..filters },
            ImageSpace { antialias: false, ..filters },
            ImageSpace { antialias_threshold: 0.9, ..filters },
            ImageSpace { min_layer_distance: Some(0.6), ..filters },
            ImageSpace { cull: false, ..filters },
        ] {
            compared(&other).expect_err("other settings");
        }
        // A single pixel: color, alpha, depth.
        let wanted = reference_of(&points, &camera, &frame, &filters);
        let middle = image.rgba.len() / 2 + 48;
        for change in [
            |image: &mut Image, pixel: usize| image.rgba[pixel][1] += 3.0 * COLOR_ERROR as f32,
            |image: &mut Image, pixel: usize| image.rgba[pixel][3] -= 3.0 * COLOR_ERROR as f32,
            |image: &mut Image, pixel: usize| image.depth[pixel] *= 1.0 + 1e-6,
        ] {
            let mut image = image.clone();
            change(&mut image, middle);
            compare_ranges(&image, &wanted, COLOR_ERROR).expect_err("another pixel");
        }
    });
}

/// A point in pixel coordinates for [`pixel_camera`]: center of a pixel, depth, color.
fn at(x: u32, y: u32, z: f64, color: Vec3) -> P {
    P {
        position: at_pixel(f64::from(x) + 0.5, f64::from(y) + 0.5, z),
        color,
        opacity: 0.3,
        radius: 0.0,
        normal: Vec3::ZERO,
    }
}

/// The pixels of an image for which `is_there` holds, as points of one color at depth 4.
fn drawn(size: [u32; 2], is_there: impl Fn(u32, u32) -> bool) -> Points {
    let all = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| [x, y]));
    let there: Vec<P> = all.filter(|[x, y]| is_there(*x, *y)).map(|[x, y]| at(x, y, 4.0, Vec3::X)).collect();
    scene(&there)
}

fn shown(device: &Device, points: &Points, size: [u32; 2], filters: ImageSpace) -> Image {
    render_both(device, points, &frame(pixel_camera(size), size, Method::ImageSpace(filters))).image
}

#[test]
fn holes_are_filled_by_as_many_iterations_as_they_take() {
    with_device(|device| {
        for (side, iterations) in [(1u32, 1u32), (2, 1), (3, 2), (4, 3), (5, 5), (6, 6), (7, 8), (11, 14)] {
            let size = [side + 8, side + 6];
            let hole = |at: u32, from: u32| (from..from + side).contains(&at);
            let points = drawn(size, |x, y| !(hole(x, 4) && hole(y, 3)));
            let left = |fill| {
                let image = shown(device, &points, size, ImageSpace { fill: Iterations::Count(fill), ..NONE });
                assert!(image.rgba.iter().all(|c| *c == [1.0, 0.0, 0.0, 1.0] || *c == [0.0; 4]));
                assert!(image.depth.iter().zip(&image.rgba).all(|(z, c)| (*z == 4.0) == (c[3] == 1.0)));
                image.rgba.iter().filter(|c| c[3] == 0.0).count()
            };
            assert!(left(iterations - 1) > 0, "{side}");
            assert_eq!(left(iterations), 0, "{side}");
            assert_eq!(left(0), (side * side) as usize);
            assert_eq!(left(100), 0);
        }
    });
}

#[test]
fn filters_run_until_nothing_changes() {
    with_device(|device| {
        let rendered = |points: &Points, size, filters| {
            render_both(device, points, &frame(pixel_camera(size), size, Method::ImageSpace(filters)))
        };
        // A hole of 11 pixels takes 14 iterations, of background or of what lies behind; what follows has no tiles.
        let size = [40, 36];
        let is_hole = |x: u32, y: u32| (9..20).contains(&x) && (7..18).contains(&y);
        let front = drawn(size, |x, y| !is_hole(x, y));
        let all = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| [x, y]));
        let behind = all.map(|[x, y]| if is_hole(x, y) { at(x, y, 9.0, Vec3::Y) } else { at(x, y, 4.0, Vec3::X) });
        let behind = scene(&behind.collect::<Vec<_>>());
        let fill = |fill| ImageSpace { fill, ..NONE };
        // Fewer iterations before those of the other filter must not count as its own.
        let occlusion = |occlusion| ImageSpace { fill: Iterations::Count(3), occlusion, ..NONE };
        for (points, of, place) in [(&front, &fill as &dyn Fn(Iterations) -> ImageSpace, 0), (&behind, &occlusion, 1)] {
            let auto = rendered(points, size, of(Iterations::Auto));
            assert!(auto.image.depth.iter().all(|z| *z == 4.0));
            let counted = |count| rendered(points, size, of(Iterations::Count(count)));
            assert!(bits(&counted(13).image) != bits(&auto.image));
            for count in [14, 64, 200] {
                let counted = counted(count);
                assert!(bits(&counted.image) == bits(&auto.image), "{count}");
                assert_eq!(counted.facts.closing_runs, auto.facts.closing_runs);
            }
            assert_eq!(auto.facts.closing_runs[place], 14);
        }
        // A hole of 50 pixels takes 72: they end after 64.
        let size = [58, 58];
        let large = drawn(size, |x, y| !((4..54).contains(&x) && (4..54).contains(&y)));
        let auto = rendered(&large, size, fill(Iterations::Auto));
        assert_eq!(auto.facts.closing_runs, [64, 0]);
        assert!(bits(&rendered(&large, size, fill(Iterations::Count(64))).image) == bits(&auto.image));
        assert!(bits(&rendered(&large, size, fill(Iterations::Count(65))).image) != bits(&auto.image));
    });
}

#[test]
fn silhouettes_do_not_grow() {
    with_device(|device| {
        let size = [20, 18];
        let shapes: [fn(u32, u32) -> bool; 6] = [
            |x, _| x >= 7,
            |_, y| y < 11,
            |x, y| x + y >= 19,
            |x, y| x >= 5 && y < 9,
            |x, y| (4..9).contains(&x) && (5..16).contains(&y),
            |x, y| x == 10 && y > 3,
        ];
        for (which, is_there) in shapes.into_iter().enumerate() {
            let points = drawn(size, is_there);
            let plain = shown(device, &points, size, NONE);
            for fill in [1, 3, 40] {
                let filled = shown(device, &points, size, ImageSpace { fill: Iterations::Count(fill), ..NONE });
                assert!(bits(&filled) == bits(&plain), "shape {which}, {fill} iterations");
            }
        }
    });
}

#[test]
fn a_plane_is_as_it_was_after_the_filter_of_occluded_pixels() {
    with_device(|device| {
        let size = [40, 30];
        let mut r = random(4);
        // Depths by gradients along x and y; d̃ above the difference of neighbors where they are not those of an axis.
        for (gx, gy, distance) in [(0.0, 0.0, 0.01), (0.5, 0.0, 0.01), (0.25, -0.25, 0.1), (0.125, 0.25, 0.5)] {
            let plane: Vec<P> = (0..size[1])
                .flat_map(|y| (0..size[0]).map(move |x| (x, y)))
                .map(|(x, y)| {
                    let z = 50.0 + gx * f64::from(x) + gy * f64::from(y);
                    at(x, y, z, Vec3::new(r.random(), r.random(), r.random()))
                })
                .collect();
            let points = scene(&plane);
            let of = |occlusion, distance| {
                shown(
                    device,
                    &points,
                    size,
                    ImageSpace { occlusion: Iterations::Count(occlusion), min_layer_distance: Some(distance), ..NONE },
                )
            };
            let plain = of(0, distance);
            assert!(plain.rgba.iter().all(|c| c[3] == 1.0));
            for occlusion in [1, 5] {
                assert!(bits(&of(occlusion, distance)) == bits(&plain), "{gx} {gy}, {occlusion} iterations");
            }
            // Steep and askew: a d̃ below the difference of two neighbors takes it for several surfaces.
            if gx == 0.125 {
                assert!(bits(&of(1, 0.1)) != bits(&plain));
            }
        }
    });
}

#[test]
fn what_shows_through_a_hole_is_replaced() {
    with_device(|device| {
        let size = [12, 12];
        // A sheet at depth 4 with holes of one pixel, of two, and a large one, in front of a wall at 9.
        let is_hole = |x: u32, y: u32| {
            [(2, 2), (5, 2), (6, 2)].contains(&(x, y)) || ((5..10).contains(&x) && (5..10).contains(&y))
        };
        let all = (0..12u32).flat_map(|y| (0..12u32).map(move |x| (x, y)));
        let front = all.clone().filter(|(x, y)| !is_hole(*x, *y)).map(|(x, y)| at(x, y, 4.0, Vec3::X));
        let points = scene(&front.chain(all.map(|(x, y)| at(x, y, 9.0, Vec3::Y))).collect::<Vec<_>>());
        let of = |occlusion, distance| {
            let filters =
                ImageSpace { occlusion: Iterations::Count(occlusion), min_layer_distance: Some(distance), ..NONE };
            let image = shown(device, &points, size, filters);
            image.depth.iter().filter(|z| **z == 9.0).count()
        };
        assert_eq!(of(0, 1.0), 28);
        // The small ones at once, and the large one's corners; the rest as holes of background are filled.
        assert_eq!([of(1, 1.0), of(2, 1.0), of(4, 1.0), of(5, 1.0)], [21, 13, 5, 0]);
        // Layers nearer than d̃ are one.
        assert_eq!(of(3, 5.5), 28);
        let filters = ImageSpace { occlusion: Iterations::Count(5), min_layer_distance: Some(1.0), ..NONE };
        let image = shown(device, &points, size, filters);
        assert!(image.rgba.iter().all(|c| *c == [1.0, 0.0, 0.0, 1.0]));
    });
}

#[test]
fn steps_are_smoothed_and_edges_softened() {
    with_device(|device| {
        let size = [8, 5];
        let step: Vec<P> = (0..5)
            .flat_map(|y| (0..6).map(move |x| (x, y)))
            .map(|(x, y)| at(x, y, if x < 3 { 4.0 } else { 6.0 }, if x < 3 { Vec3::ZERO } else { Vec3::X }))
            .collect();
        let points = scene(&step);
        let row = |filters| -> Vec<[f32; 4]> { shown(device, &points, size, filters).rgba[16..24].to_vec() };
        let close = |found: f32, wanted: f32| assert!((found - wanted).abs() < 1e-6, "{found} {wanted}");
        let smooth = row(ImageSpace { smooth: 1, ..NONE });
        // 2 + 2·1 of 28 are across the step; the right border has 16 + 3·2 + 2·1 = 24 over itself, all of them 1.
        for (found, wanted) in smooth.iter().zip([0.0, 0.0, 4.0 / 28.0, 24.0 / 28.0, 1.0, 1.0]) {
            close(found[0], wanted);
            close(found[3], 1.0);
        }
        assert_eq!(smooth[6], [0.0; 4]);
        // d̃ = 2: L is 2 at the step, a quarter; at the border to the background (far is 10⁷) all of it.
        let soft = |threshold| {
            row(ImageSpace { antialias: true, antialias_threshold: threshold, min_layer_distance: Some(2.0), ..NONE })
        };
        let low = soft(0.25);
        for (found, wanted) in low.iter().zip([
            [0.0, 0.875],
            [0.0, 1.0],
            [0.125 * 0.25, 1.0],
            [0.875 + 0.125 * 0.75, 1.0],
            [1.0, 1.0],
            [0.875, 0.875],
            [0.125, 0.125],
            [0.0, 0.0],
        ]) {
            close(found[0], wanted[0]);
            close(found[3], wanted[1]);
        }
        // A high threshold leaves what is within the object.
        let high = soft(0.3);
        assert_eq!((high[2], high[3]), ([0.0, 0.0, 0.0, 1.0], [1.0, 0.0, 0.0, 1.0]));
        close(high[6][0], 0.125);
        let image = shown(device, &points, size, ImageSpace { antialias: true, ..NONE });
        assert_eq!(image.depth[16..24], [4.0, 4.0, 4.0, 6.0, 6.0, 6.0, f32::INFINITY, f32::INFINITY]);
    });
}

#[test]
fn only_what_looks_at_the_viewer_is_drawn() {
    with_device(|device| {
        let size = [3, 1];
        let turned = |x, z, color, normal| P { normal, ..at(x, 0, z, color) };
        let points = scene(&[
            turned(0, 2.0, Vec3::X, Vec3::NEG_Z),
            turned(0, 3.0, Vec3::Y, Vec3::Z),
            turned(1, 2.0, Vec3::X, Vec3::ZERO),
            turned(1, 3.0, Vec3::Y, Vec3::Z),
            turned(2, 2.0, Vec3::X, Vec3::NEG_Z),
        ]);
        let depths = |cull| shown(device, &points, size, ImageSpace { cull, ..NONE }).depth;
        assert_eq!(depths(true), [3.0, 2.0, f32::INFINITY]);
        assert_eq!(depths(false), [2.0, 2.0, 2.0]);
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
        for filters in [
            ImageSpace::default(),
            ImageSpace { fill: Iterations::Count(3), occlusion: Iterations::Count(2), smooth: 2, cull: false, ..NONE },
        ] {
            let frame = Frame { shading: SHADED, ..frame(camera, [70, 70], Method::ImageSpace(filters)) };
            let first = bits(&render_both(device, &scene(&points), &frame).image);
            points.shuffle(&mut random(9));
            assert!(bits(&render_both(device, &scene(&points), &frame).image) == first, "{filters:?}");
        }
    });
}

#[test]
fn no_budget_and_no_other_frame_changes_a_byte() {
    with_device(|device| {
        let points = scene(&soup(31, 12_000, 0.0..0.1, 0.1..0.9, true));
        let filters = ImageSpace {
            fill: Iterations::Count(3),
            occlusion: Iterations::Count(3),
            smooth: 3,
            ..ImageSpace::default()
        };
        let mut frame = Frame { shading: SHADED, ..frame(perspective(), [150, 110], Method::ImageSpace(filters)) };
        let mut renderer = Renderer::new(device).expect("a renderer");
        let mut cloud = renderer.upload(&points).expect("fits");
        let whole = renderer.render(&mut cloud, &frame).expect("renders");
        assert_eq!(whole.facts.windows, 1);
        let mut cuts = 0;
        for budget in [1 << 20, 512 << 10, 256 << 10] {
            frame.memory_budget = Some(budget);
            let cut = renderer.render(&mut cloud, &frame).expect("renders");
            cuts += usize::from(cut.facts.windows > 1);
            assert!(bits(&cut.image) == bits(&whole.image), "budget {budget}: {:?}", cut.facts);
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
fn no_budget_changes_filters_that_run_until_nothing_changes() {
    with_device(|device| {
        // The halo of both filters is 128 pixels to each side, of an image that is wide enough for it.
        let points = scene(&soup(32, 60_000, 0.0..0.1, 0.1..0.9, true));
        let filters =
            ImageSpace { fill: Iterations::Auto, occlusion: Iterations::Auto, smooth: 0, antialias: false, ..NONE };
        let mut frame = frame(perspective(), [900, 40], Method::ImageSpace(filters));
        let mut renderer = Renderer::new(device).expect("a renderer");
        let mut cloud = renderer.upload(&points).expect("fits");
        let whole = renderer.render(&mut cloud, &frame).expect("renders");
        frame.memory_budget = Some(3 << 20);
        let cut = renderer.render(&mut cloud, &frame).expect("renders");
        assert!(whole.facts.windows == 1 && cut.facts.windows > 1, "{} windows", cut.facts.windows);
        assert!(bits(&cut.image) == bits(&whole.image), "{:?}", cut.facts);
    });
}

#[test]
fn without_filters_it_is_points() {
    with_device(|device| {
        let points = scene(&soup(8, 5000, 0.0..0.1, 0.1..0.9, true));
        for size in [[1, 1], [1, 64], [64, 1], [80, 60]] {
            let of = |method| Frame { shading: SHADED, ..frame(perspective(), size, method) };
            let plain = render_both(device, &points, &of(Method::Points)).image;
            let unfiltered = of(Method::ImageSpace(ImageSpace { cull: false, ..NONE }));
            assert!(bits(&render_both(device, &points, &unfiltered).image) == bits(&plain), "{size:?}");
        }
    });
}

#[test]
fn nothing_to_draw_leaves_background() {
    with_device(|device| {
        // All behind the camera.
        let points = scene(&[P { position: DVec3::new(2.0, 3.0, 9.0), ..at(0, 0, 0.0, Vec3::ONE) }]);
        let image =
            render_both(device, &points, &frame(perspective(), [9, 7], Method::ImageSpace(ImageSpace::default())));
        assert!(image.image.rgba.iter().all(|c| *c == [0.0; 4]));
        assert!(image.image.depth.iter().all(|z| *z == f32::INFINITY));
    });
}

#[test]
fn a_scanned_surface_equals_the_reference_and_is_closed() {
    for clouds in clouds() {
        // Two points to a pixel, less where it is steep: holes of background and of what lies behind.
        let (file, size, holes) = match clouds.is_subset() {
            true => ("models/turbine_blade_6k.ply", [72, 54], 10),
            false => ("models/stanford_dragon_437k.ply", [600, 450], 1000),
        };
        let path = clouds.file(file).expect("it is there");
        with_device(|device| assert_scan(device, path, size, holes));
    }
}

/// Asserts that a surface equals the reference, and that more than so many holes of one pixel are filled.
fn assert_scan(device: &Device, path: PathBuf, size: [u32; 2], enough: usize) {
    let mut scene = Scene::from_clouds(&[path], &Overrides::default()).expect("a scene");
    // From here both have steep parts, where there are holes.
    scene.camera.view.azimuth = Some(20.0);
    let progress = Progress::hidden();
    let clouds = scene::load_clouds(&scene, &progress).expect("it can be read");
    let up = scene::up_axis(&clouds);
    let all = scene::assemble(&scene, clouds, false, &progress).expect("points");
    let (camera, _) = scene::camera(&scene, &all, up).expect("a camera");
    let distance = prepare::layer_distance::suggest(&all).expect("a surface") as f32;
    let filters =
        ImageSpace { fill: Iterations::Count(2), min_layer_distance: Some(distance), ..ImageSpace::default() };
    let points = clear_of(&all, &camera, size, &Shading::NONE);
    let frame = frame(camera, size, Method::ImageSpace(filters));
    let wanted = reference_of(&points, &camera, &frame, &filters);
    let image = render_both(device, &points, &frame).image;
    compare_ranges(&image, &wanted, COLOR_ERROR).expect("the reference");
    // Background in a ring of eight.
    let holes = |filters: ImageSpace| {
        let frame = Frame { method: Method::ImageSpace(ImageSpace { antialias: false, ..filters }), ..frame };
        let depth = render_both(device, &all, &frame).image.depth;
        let there = |pixel: usize| depth[pixel].is_finite();
        let [w, h] = size.map(|side| side as usize);
        let inside = (w + 1..w * (h - 1) - 1).filter(|pixel| pixel % w > 0 && pixel % w < w - 1);
        let ring = [1, w - 1, w, w + 1];
        inside.filter(|p| !there(*p) && ring.iter().all(|o| there(p - o) && there(p + o))).count()
    };
    // An iteration more than the reference's: the last ones have their ring since the second only.
    let (before, after) = (
        holes(ImageSpace { fill: Iterations::Count(0), ..filters }),
        holes(ImageSpace { fill: Iterations::Count(3), ..filters }),
    );
    println!("holes of one pixel: {before}, filled: {after}");
    assert!(before > enough && after == 0, "{before} {after}");
}
