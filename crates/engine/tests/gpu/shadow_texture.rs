//! Shares of light point by point against float64, through the cameras of the engine's own lights: where these stand,
//! and that they hold all points, `src/methods/shadows/lights.rs` tests by itself; what shadows look like,
//! `crates/engine/tests/gpu/shadows.rs`.

use glam::{DVec3, Vec3};
use pellucid_core::cloud::light_image::{Holes, automatic_resolution, hole_block, natural_resolution};
use pellucid_core::cloud::shadow_texture::Casting;
use pellucid_core::points::Points;
use pellucid_engine::methods::shadows::lights;
use pellucid_engine::methods::{Frame, Renderer};
use pellucid_engine::plan::plan;
use pellucid_gpu::Device;
use pellucid_reference::range::ROUNDING;
use pellucid_reference::shadows::{Frames, Map, covered, holes, share_ranges};
use pellucid_scene::{Iterations, Light, MapResolution, Method, Shading, ShadingModel, Shadows};
use pellucid_testing::*;
use rand::RngExt;

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
    let resolution = MapResolution::Pixels(150);
    Shadows { samples: 5, light_radius, resolution, min_layer_distance: Some(0.097_31), ..Shadows::default() }
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

/// How the reference makes the image of a light.
fn map(casting: &Casting) -> Map {
    let Casting { resolution, fill, occlusion, min_layer_distance, .. } = *casting;
    Map { resolution, fill, occlusion, distance: min_layer_distance.into() }
}

/// Compares m with what roundings may make of the reference's.
fn compare(points: &Points, light: Light, shadows: Shadows, seed: u64, found: &[f32]) -> Result<(), String> {
    let bounds = points.bounds().expect("there are points");
    let casting = shadows.casting(light, seed, (&bounds, points.len() as u64)).expect("it casts");
    let cameras = |i: u32| -> Frames {
        let light = lights::light(&casting, &bounds, i);
        let views = lights::views(light, &bounds, casting.resolution, casting.reach());
        views.iter().map(|view| view.camera).collect()
    };
    let cameras: Vec<Frames> = (0..casting.samples).map(cameras).collect();
    let wanted = share_ranges(&cameras, map(&casting), points);
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
                let hard = Shadows { light_radius: 0.0, resolution: MapResolution::Pixels(77), ..area(light) };
                let filtered = |fill, occlusion| {
                    let [fill, occlusion] = [fill, occlusion].map(Iterations::Count);
                    Shadows { fill, occlusion, ..hard }
                };
                let auto = Shadows { fill: Iterations::Auto, resolution: MapResolution::Auto, ..hard };
                let all = [area(light), hard, filtered(0, 0), filtered(0, 1), filtered(1, 0), filtered(3, 2), auto];
                for shadows in all {
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
            Shadows { resolution: MapResolution::Pixels(149), ..shadows },
            Shadows { fill: Iterations::Count(0), ..shadows },
            Shadows { occlusion: Iterations::Count(0), ..shadows },
            Shadows { fill: Iterations::Count(3), ..shadows },
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
        let before = ["shadows/start", "shadows/clear", "shadows/nearest", "shadows/reset", "shadows/blocks"];
        for (fill, occlusion, filters) in [
            (1, 1, &["shadows/fill", "shadows/occlusion"][..]),
            (0, 2, &["shadows/occlusion"]),
            (2, 0, &["shadows/fill"]),
            // A run that makes depths of keys.
            (0, 0, &["shadows/occlusion"]),
        ] {
            let [fill, occlusion] = [fill, occlusion].map(Iterations::Count);
            let frame = Frame { shadows: hard.shadows.map(|shadows| Shadows { fill, occlusion, ..shadows }), ..hard };
            let wanted = [&before, filters, &["shadows/leaks", "shadows/lit"]].concat();
            let facts = renderer.survey(&mut cloud, &frame).expect("surveyed");
            let steps = plan(device, &frame, &facts, true, "a reason");
            let on = steps.iter().filter(|step| step.on && step.name.starts_with("shadows/"));
            assert_eq!(on.map(|step| step.name).collect::<Vec<_>>(), wanted);
            assert_eq!(names(&frame, &mut renderer, &mut cloud), wanted);
        }
        renderer.render(&mut cloud, &hard).expect("renders");
        let elsewhere = Frame { camera: orthographic(), size: [30, 20], ..hard };
        assert_eq!(names(&elsewhere, &mut renderer, &mut cloud), [""; 0]);
    });
}

/// A disc of scattered points over a floor, seen from straight above, and the places of the floor's points that lie in
/// its shadow, clear of its border.
fn disc_over_a_floor(disc: usize, floor: usize) -> (Points, Vec<usize>) {
    let mut random = random(6);
    let point = |position| P { position, color: Vec3::ONE, opacity: 1.0, radius: 0.01, normal: Vec3::ZERO };
    let mut all = Vec::new();
    while all.len() < disc {
        let place = DVec3::new(random.random_range(-0.4..0.4), 0.4, random.random_range(-0.4..0.4));
        if place.x.hypot(place.z) < 0.4 {
            all.push(point(place));
        }
    }
    let on_floor = |_| point(DVec3::new(random.random_range(-1.0..1.0), 0.0, random.random_range(-1.0..1.0)));
    all.extend((0..floor).map(on_floor));
    let points = scene(&all);
    let is_below = |p: &DVec3| p.y == 0.0 && p.x.hypot(p.z) < 0.37;
    let below = (0..points.len()).filter(|i| is_below(&points.positions[*i])).collect();
    (points, below)
}

const DOWN: Light = Light::Direction(DVec3::NEG_Y);

#[test]
fn a_disc_of_scattered_points_lets_through_what_the_reference_says() {
    with_device(|device| {
        let (points, below) = disc_over_a_floor(800, 10_200);
        let bounds = points.bounds().expect("there are points");
        // The floor fills the image: half of all points are one a pixel at √5500 columns. A pixel of the disc, which is
        // π 0.2² of the image, then has 1.2 points, and 0.16 at 200 columns.
        assert_eq!(automatic_resolution(&DOWN, &bounds, 11_000), 74);
        let mut before = f64::INFINITY;
        for (resolution, fill, occlusion) in [
            (MapResolution::Pixels(200), 0, 1),
            (MapResolution::Pixels(200), 1, 1),
            (MapResolution::Pixels(200), 2, 2),
            (MapResolution::Pixels(200), 4, 4),
            (MapResolution::Auto, 1, 1),
        ] {
            let [fill, occlusion] = [fill, occlusion].map(Iterations::Count);
            let shadows = Shadows { resolution, fill, occlusion, min_layer_distance: Some(0.1), ..Shadows::default() };
            let found = lit(device, &points, &lit_frame(DOWN, shadows));
            let casting = shadows.casting(DOWN, 4, (&bounds, points.len() as u64)).expect("it casts");
            let views = lights::views(DOWN, &bounds, casting.resolution, casting.reach());
            let cameras: Vec<Frames> = vec![views.iter().map(|view| view.camera).collect()];
            let wanted = share_ranges(&cameras, map(&casting), &points);
            let share = |m: &dyn Fn(usize) -> f64| below.iter().map(|i| m(*i)).sum::<f64>() / below.len() as f64;
            let leak = share(&|i| f64::from(found[i]));
            let [least, most] = [share(&|i| wanted[i].low), share(&|i| wanted[i].high)];
            assert!(leak >= least && leak <= most, "{shadows:?}: {leak}, not {least} to {most}");
            // Each step closes more, and the last lets nearly nothing through.
            assert!(leak <= 0.7 * before, "{shadows:?}: {leak} after {before}");
            before = leak;
        }
        assert!(before < 0.01, "{before}");
    });
}

#[test]
fn holes_are_counted_as_the_reference_does() {
    with_device(|device| {
        // Points in the middle of pixels of the light, so that roundings decide nothing: a lid on most of them, and a
        // floor on most of all.
        let resolution = 90;
        let half = DVec3::new(1.0, 0.5, 1.0);
        let bounds = pellucid_core::cloud::Bounds { min: -half, max: half };
        let camera = lights::views(DOWN, &bounds, resolution, 2)[0].camera;
        let unit = 1.0 / camera.pixels_per_unit(1.0, resolution);
        let place = |x: u32, y: u32, height: f64| {
            let [right, up] = [x, y].map(|at| (f64::from(at) + 0.5 - 0.5 * f64::from(resolution)) * unit);
            let flat = right * camera.right - up * camera.up;
            DVec3::new(flat.x, height, flat.z)
        };
        let mut random = random(8);
        let mut positions = bounds.corners().to_vec();
        for (x, y) in (2..88).flat_map(|y| (2..88).map(move |x| (x, y))) {
            let is_lid = (20..70).contains(&x) && (15..60).contains(&y);
            if is_lid && random.random_bool(0.4) {
                positions.push(place(x, y, 0.3));
            }
            if random.random_bool(0.5) {
                positions.push(place(x, y, -0.3));
            }
        }
        let point = |position| P { position, color: Vec3::ONE, opacity: 1.0, radius: 0.01, normal: Vec3::ZERO };
        let points = scene(&positions.into_iter().map(point).collect::<Vec<_>>());
        let mut renderer = Renderer::new(device).expect("a renderer");
        let mut cloud = renderer.upload(&points).expect("fits");
        assert_eq!(cloud.light_holes(), None);
        let mut seen = Vec::new();
        for (fill, occlusion) in [(0, 0), (0, 1), (1, 0), (1, 1), (3, 3)] {
            let shadows = Shadows {
                resolution: MapResolution::Pixels(resolution),
                fill: Iterations::Count(fill),
                occlusion: Iterations::Count(occlusion),
                min_layer_distance: Some(0.1),
                ..Shadows::default()
            };
            let casting = renderer.cast(&mut cloud, &lit_frame(DOWN, shadows)).expect("cast").expect("it casts");
            let camera = lights::views(DOWN, &bounds, resolution, casting.reach())[0].camera;
            let natural = natural_resolution(&DOWN, &bounds, points.len() as u64);
            let block = hole_block(resolution, natural);
            let [covered, holes, shown, leaks] = holes(&camera, map(&casting), &points, block);
            assert_eq!(cloud.light_holes(), Some(Holes { covered, holes, shown, leaks }), "{fill}, {occlusion}");
            assert!(covered > 5000, "{covered}");
            seen.push((holes, leaks));
        }
        // Without filters holes are many, over the floor and over nothing; filters close nearly all.
        assert!(seen[0].0 > 1000 && seen[0].1 > 100 && seen[4].0 < seen[0].0 / 50, "{seen:?}");
        // Only the shares of that light have them.
        cloud.reserve_shares(device).expect("room");
        assert_eq!(cloud.light_holes(), None);
    });
}

#[test]
fn automatic_resolution_is_that_of_the_reference() {
    let bounds = pellucid_core::cloud::Bounds { min: DVec3::new(-1.0, -0.2, 3.0), max: DVec3::new(2.0, 0.5, 3.7) };
    for light in [
        Light::Direction(DVec3::new(0.5, -1.0, -0.4).normalize()),
        Light::Direction(DVec3::new(-0.1, 0.2, 0.9).normalize()),
        Light::Position(DVec3::new(0.4, 3.0, 1.0)),
        Light::Position(DVec3::new(9.0, 0.1, 3.1)),
        Light::Position(DVec3::new(0.4, 0.1, 3.3)),
        Light::Position(DVec3::new(0.4, 0.6, 3.3)),
    ] {
        // The margin of an image so large is nothing.
        let views = lights::views(light, &bounds, 1 << 20, 2);
        let cameras: Vec<_> = views.iter().map(|view| view.camera).collect();
        let wanted = (0.5 * 500_000.0 / covered(&cameras, &bounds)).sqrt();
        let found = natural_resolution(&light, &bounds, 500_000);
        assert!((found / wanted - 1.0).abs() < 1e-5, "{light:?}: {found} {wanted}");
        let auto = f64::from(automatic_resolution(&light, &bounds, 500_000));
        assert!((auto - wanted).abs() < 0.51, "{light:?}: {auto} {wanted}");
    }
}
