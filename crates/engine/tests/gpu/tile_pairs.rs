//! Lists of tiles by sorted pairs of tile and splat, and run by run: the same images, whatever else is shaped how, and
//! the passes that the plan tells.

use pellucid_core::camera::{Camera, Projection};
use pellucid_core::points::Points;
use pellucid_engine::methods::{Frame, Renderer};
use pellucid_engine::plan::plan;
use pellucid_gpu::{Device, Preferences};
use pellucid_scene::prepare::order;
use pellucid_scene::{BlendedSplats, Discs, Method, Soft, Stochastic};
use pellucid_testing::{bits, frame, perspective, scene, soup, with_device_that_prefers};

/// Lists of tiles in every way, with both shapes of the other work.
const SHAPES: [Preferences; 4] = [
    Preferences::CPU,
    Preferences { tile_pairs: true, ..Preferences::CPU },
    Preferences { tile_pairs: false, ..Preferences::GPU },
    Preferences::GPU,
];

/// Every order of splats, and lists of solid points before those of soft ones.
fn methods() -> [Method; 6] {
    [
        Method::Sorted(Discs::default()),
        Method::Unsorted(Discs::default()),
        Method::Weighted(Discs::default()),
        Method::Stochastic(Stochastic::default()),
        Method::Hqs(BlendedSplats::default()),
        Method::SoftExpress(Soft::default()),
    ]
}

/// Every other point is soft. Some cover one pixel, some all tiles.
fn points() -> Points {
    let mut all = soup(31, 3000, 0.001..0.1, 0.1..0.9, true);
    all.extend(soup(32, 20, 0.5..3.0, 0.1..0.5, true));
    let soup = scene(&all);
    order::canonical(Points { fields: (0..soup.len()).map(|i| (i % 2) as f32).collect(), ..soup })
}

/// Runs a test with a device of each shape, and asserts that it found the same with all.
fn assert_alike<T: PartialEq>(test: impl Fn(&Device, Preferences) -> Vec<(String, T)>) {
    let mut first: Option<Vec<(String, T)>> = None;
    for prefers in SHAPES {
        with_device_that_prefers(prefers, |device| {
            let found = test(device, prefers);
            for ((name, a), (_, b)) in first.iter().flatten().zip(&found) {
                assert!(a == b, "{name}: other bytes with {prefers:?}");
            }
            first.get_or_insert(found);
        });
    }
}

#[test]
fn lists_by_pairs_have_the_bytes_of_lists_run_by_run_in_windows_too() {
    let points = points();
    assert_alike(|device, prefers| {
        let mut all = Vec::new();
        for method in methods() {
            for memory_budget in [None, Some(1_500_000)] {
                let frame = Frame { memory_budget, ..frame(perspective(), [300, 200], method) };
                let mut renderer = Renderer::new(device).expect("a renderer");
                let mut cloud = renderer.upload(&points).expect("fits");
                let name = format!("{}, {memory_budget:?}", method.name());
                let found = renderer.render(&mut cloud, &frame).unwrap_or_else(|error| panic!("{name}: {error}"));
                assert!(memory_budget.is_none() || found.facts.windows > 1, "{name}: one window");
                assert!(memory_budget.is_some() || found.facts.windows == 1, "{name}: {prefers:?}");
                all.push((name, bits(&found.image)));
            }
        }
        all
    });
}

#[test]
fn pairs_that_are_foreseen_have_the_bytes_of_those_that_are_counted() {
    let (points, fov_y) = (points(), 45f64.to_radians());
    // At rest, nearer, suddenly much nearer, to where nothing is, and back.
    let distances = [6.0, 6.0, 6.0, 5.9, 2.0, 2.0, 2.0, 500.0, 500.0, 6.0, 6.0];
    assert_alike(|device, _| {
        let mut all = Vec::new();
        for method in methods() {
            let mut renderer = Renderer::new(device).expect("a renderer");
            renderer.timed = false;
            let mut cloud = renderer.upload(&points).expect("fits");
            for (number, distance) in distances.into_iter().enumerate() {
                let eye = glam::DVec3::new(0.2, 0.3, 1.0) * distance;
                let projection = Projection::Perspective { fov_y };
                let camera = Camera::look_at(eye, glam::DVec3::ZERO, glam::DVec3::Y, projection, 0.01, 1000.0);
                let frame = frame(camera.expect("valid"), [64, 48], method);
                let found = renderer.render(&mut cloud, &frame).expect("renders");
                all.push((format!("{}, frame {number}", method.name()), bits(&found.image)));
            }
        }
        all
    });
}

#[test]
fn the_plan_lists_the_passes_that_make_lists_of_tiles() {
    let points = points();
    for prefers in SHAPES {
        with_device_that_prefers(prefers, |device| {
            for method in methods() {
                let frame = frame(perspective(), [300, 200], method);
                let mut renderer = Renderer::new(device).expect("a renderer");
                let mut cloud = renderer.upload(&points).expect("fits");
                let found = renderer.render(&mut cloud, &frame).expect("renders");
                let is_of_lists = |name: &&str| ["bin/", "radix/", "scan/"].iter().any(|stem| name.starts_with(stem));
                let mut ran: Vec<&str> =
                    found.profile.passes.iter().map(|pass| pass.name).filter(is_of_lists).collect();
                let steps = plan(device, &frame, &found.facts, device.info().int64_atomics, "a reason");
                let on = steps.iter().filter(|step| step.on).map(|step| step.name);
                let mut told: Vec<&str> = on.filter(is_of_lists).collect();
                ran.sort_unstable();
                told.sort_unstable();
                assert_eq!(ran, told, "{}, {prefers:?}", method.name());
                assert_eq!(ran.contains(&"bin/pairs"), prefers.tile_pairs, "{}", method.name());
                assert_eq!(ran.contains(&"bin/tile-store"), !prefers.tile_pairs, "{}", method.name());
            }
        });
    }
}
