//! Shares of light point by point against float64, through the cameras of the engine's own lights: where these stand,
//! and that they hold all points, `src/methods/shadows/lights.rs` tests by itself; what shadows look like,
//! `crates/engine/tests/gpu/shadows.rs`.

use glam::{DVec3, Vec3};
use pellucid_core::points::Points;
use pellucid_engine::methods::shadows::lights;
use pellucid_engine::methods::{Frame, Renderer};
use pellucid_engine::plan::plan;
use pellucid_gpu::Device;
use pellucid_reference::range::ROUNDING;
use pellucid_reference::shadows::{Frames, share_ranges};
use pellucid_scene::{Light, Method, Shading, ShadingModel, Shadows};
use pellucid_testing::*;

const SUN: Light = Light::Direction(DVec3::new(0.5, -1.0, -0.4));
/// Before the cloud, in its midst, and so near that it needs a cube of images.
const LIGHTS: [Light; 4] = [
    SUN,
    Light::Position(DVec3::new(1.0, 6.0, 2.0)),
    Light::Position(DVec3::new(0.1, -0.2, 0.3)),
    Light::Position(DVec3::new(0.2, 1.05, -0.1)),
];

fn lit_frame(light: Light, shadows: Shadows) -> Frame {
    let shading = Shading { model: ShadingModel::Lambert, light, ..Shading::default() };
    Frame { shading, shadows: Some(shadows), seed: 4, ..frame(perspective(), [90, 70], Method::Points) }
}

fn area(light: Light) -> Shadows {
    // Degrees, or units.
    let light_radius = if matches!(light, Light::Direction(_)) { 6.0 } else { 0.2 };
    Shadows { samples: 5, light_radius, resolution: 150, min_layer_distance: Some(0.097_31) }
}

/// Spheres in one another: shadows on each other and on themselves, with normals for all but every fifth point.
fn onion(normals: bool) -> Points {
    let sphere = |radius: f64, center: DVec3, count: u32| {
        (0..count).map(move |i| {
            let (y, turn) = (1.0 - (2.0 * f64::from(i) + 1.0) / f64::from(count), 2.399_963 * f64::from(i));
            let ring = (1.0 - y * y).sqrt();
            let n = DVec3::new(ring * turn.cos(), y, ring * turn.sin());
            let normal = if normals && i % 5 != 0 { n.as_vec3().normalize() } else { Vec3::ZERO };
            P { position: center + radius * n, color: Vec3::ONE, opacity: 1.0, radius: 0.01, normal }
        })
    };
    let all = sphere(0.35, DVec3::ZERO, 3000).chain(sphere(0.2, DVec3::new(0.6, 0.7, 0.0), 2000));
    scene(&all.chain(sphere(1.0, DVec3::ZERO, 9000)).collect::<Vec<_>>())
}

/// Compares m with what roundings may make of the reference's.
fn compare(points: &Points, light: Light, shadows: Shadows, seed: u64, found: &[f32]) -> Result<(), String> {
    let bounds = points.bounds().expect("there are points");
    let casting = shadows.casting(light, seed, bounds.diagonal()).expect("it casts");
    let cameras = |i: u32| -> Frames {
        let views = lights::views(lights::light(&casting, &bounds, i), &bounds, casting.resolution);
        views.iter().map(|view| view.camera).collect()
    };
    let cameras: Vec<Frames> = (0..casting.samples).map(cameras).collect();
    let wanted = share_ranges(&cameras, casting.resolution, points, f64::from(casting.min_layer_distance));
    // A quotient of whole numbers.
    let is_off = |point: &usize| !wanted[*point].covers(f64::from(found[*point]), ROUNDING);
    match (0..found.len()).find(is_off) {
        None => Ok(()),
        Some(i) => Err(format!("point {i} at {}: {}, not {:?}", points.positions[i], found[i], wanted[i])),
    }
}

fn lit(device: &Device, points: &Points, frame: &Frame) -> Vec<f32> {
    let mut renderer = Renderer::new(device).expect("a renderer");
    let mut cloud = renderer.upload(points).expect("fits");
    assert_eq!(cloud.lit().expect("read"), vec![1.0; points.len()], "no shadows were cast");
    renderer.cast(&mut cloud, frame).expect("cast");
    cloud.lit().expect("read")
}

#[test]
fn shares_equal_the_reference() {
    with_device(|device| {
        for normals in [true, false] {
            let points = onion(normals);
            for light in LIGHTS {
                for shadows in [area(light), Shadows { light_radius: 0.0, resolution: 77, ..area(light) }] {
                    let frame = lit_frame(light, shadows);
                    let found = lit(device, &points, &frame);
                    let compared = compare(&points, light, shadows, frame.seed, &found);
                    assert!(compared.is_ok(), "{light:?}, {shadows:?}: {compared:?}");
                    let dark = found.iter().filter(|m| **m == 0.0).count();
                    assert!(dark > 500 && found.contains(&1.0), "{light:?}: {dark}");
                }
            }
        }
    });
}

#[test]
fn the_comparison_notices_other_settings() {
    with_device(|device| {
        let points = onion(true);
        let shadows = area(SUN);
        let found = lit(device, &points, &lit_frame(SUN, shadows));
        assert!(compare(&points, SUN, shadows, 4, &found).is_ok());
        // A single point, by one of five lights.
        let mut changed = found.clone();
        changed[2000] += if found[2000] > 0.5 { -0.2 } else { 0.2 };
        assert!(compare(&points, SUN, shadows, 4, &changed).is_err());
        for other in [
            Shadows { min_layer_distance: Some(0.098), ..shadows },
            Shadows { resolution: 149, ..shadows },
            Shadows { light_radius: 6.1, ..shadows },
        ] {
            assert!(compare(&points, SUN, other, 4, &found).is_err(), "{other:?}");
        }
        assert!(compare(&points, SUN, shadows, 5, &found).is_err());
        assert!(compare(&points, Light::Direction(DVec3::new(0.5, -1.0, -0.41)), shadows, 4, &found).is_err());
        let mut points = points;
        points.normals = None;
        assert!(compare(&points, SUN, shadows, 4, &found).is_err());
    });
}

#[test]
fn chunks_do_not_show() {
    // More points than a chunk has at least.
    let points = scene(&soup(31, 70_000, 0.0..0.1, 0.1..0.9, true));
    for light in [SUN, LIGHTS[2]] {
        let frame = lit_frame(light, Shadows { samples: 2, ..area(light) });
        let (mut whole, mut cut) = (Vec::new(), Vec::new());
        with_device(|device| whole = lit(device, &points, &frame));
        with_device_that_binds(Some(2 << 20), |device| cut = lit(device, &points, &frame));
        assert!(whole == cut, "{light:?}");
        // Skipped without a device.
        assert!(whole.is_empty() || (whole.contains(&0.0) && whole.contains(&0.5) && whole.contains(&1.0)));
    }
}

#[test]
fn a_point_where_the_light_is_is_lit() {
    with_device(|device| {
        let place = DVec3::new(0.2, 0.1, -0.3);
        let mut points = soup(32, 500, 0.0..0.1, 0.1..0.9, true);
        points[0].position = place;
        let points = scene(&points);
        let at = points.positions.iter().position(|p| *p == place).expect("it is one of them");
        let shadows = Shadows { light_radius: 0.0, ..area(SUN) };
        assert_eq!(lit(device, &points, &lit_frame(Light::Position(place), shadows))[at], 1.0);
        // Nor does it matter whether there are others.
        let alone = scene(&[P { position: place, color: Vec3::ONE, opacity: 1.0, radius: 0.1, normal: Vec3::ZERO }]);
        for light in [SUN, Light::Position(place), Light::Position(DVec3::ZERO)] {
            assert_eq!(lit(device, &alone, &lit_frame(light, shadows)), [1.0]);
        }
    });
}

#[test]
fn the_plan_says_what_the_next_frame_runs() {
    with_device(|device| {
        let points = onion(true);
        let mut renderer = Renderer::new(device).expect("a renderer");
        let mut cloud = renderer.upload(&points).expect("fits");
        for (light, views) in [(SUN, 5), (LIGHTS[2], 30)] {
            let frame = lit_frame(light, area(light));
            for views in [views, 0] {
                let facts = renderer.survey(&mut cloud, &frame).expect("surveyed");
                assert_eq!(facts.light_views, views);
                let steps = plan(device, &frame, &facts, true, "a reason");
                let rendered = renderer.render(&mut cloud, &frame).expect("renders");
                assert_eq!(rendered.facts.light_views, views);
                for step in steps.iter().filter(|step| step.name.starts_with("shadows/")) {
                    let pass = rendered.profile.passes.iter().find(|pass| pass.name == step.name);
                    assert_eq!(step.on, pass.is_some(), "{step:?}");
                    assert!(pass.is_none_or(|pass| pass.bytes.is_some()), "{pass:?}");
                }
            }
        }
        // A single light has no share to find.
        let hard = lit_frame(SUN, Shadows { light_radius: 0.0, ..area(SUN) });
        let names = |frame: &Frame, renderer: &mut Renderer, cloud: &mut _| {
            let passes = renderer.render(cloud, frame).expect("renders").profile.passes;
            passes.iter().map(|pass| pass.name).filter(|name| name.starts_with("shadows/")).collect::<Vec<_>>()
        };
        let first = ["shadows/start", "shadows/clear", "shadows/nearest", "shadows/fill", "shadows/lit"];
        assert_eq!(names(&hard, &mut renderer, &mut cloud), first);
        let elsewhere = Frame { camera: orthographic(), size: [30, 20], ..hard };
        assert_eq!(names(&elsewhere, &mut renderer, &mut cloud), [""; 0]);
    });
}
