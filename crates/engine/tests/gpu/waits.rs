//! How often the host waits for the device, and frames whose counts are foreseen: their bytes are those of frames that
//! wait.

use pellucid_core::camera::{Camera, Projection};
use pellucid_core::points::Points;
use pellucid_core::progress::Progress;
use pellucid_engine::methods::{Facts, Frame, Rendered, Renderer};
use pellucid_engine::passes::scan::{ScanPush, Spread, spread_variant};
use pellucid_gpu::{Buffer, Device, Dispatch, Memory, Preferences, Run};
use pellucid_scene::Method;
use pellucid_scene::prepare::{Arranged, ensembles, order};
use pellucid_testing::{frame, perspective, scene, soup, with_device, with_device_that_prefers, with_only_device};

/// Points with normals, every other one soft; some are so large that tiles list them.
fn points() -> Points {
    let mut all = soup(7, 400, 0.02..0.1, 0.1..0.9, true);
    all.extend(soup(8, 20, 0.5..0.9, 0.1..0.5, true));
    let soup = scene(&all);
    order::canonical(Points { fields: (0..soup.len()).map(|i| (i % 2) as f32).collect(), ..soup })
}

fn arranged(method: &Method) -> Arranged {
    if method.is_dealt() {
        Arranged::Dealt(ensembles::deal(vec![points()], 1, &Progress::hidden()))
    } else {
        Arranged::Canonical(points().into())
    }
}

#[test]
fn a_steady_frame_waits_once() {
    with_device(|device| {
        for method in Method::all() {
            let mut renderer = Renderer::new(device).expect("a renderer");
            let mut cloud = renderer.upload(&arranged(&method)).expect("fits");
            for fragments in [false, true] {
                let frame = Frame { fragments, ..frame(perspective(), [64, 48], method) };
                let mut render = || renderer.render(&mut cloud, &frame).expect("renders").profile.waits;
                let waits = [(); 6].map(|()| render());
                // One that took long, as by compiling, lets the next one wait.
                let steady = waits[2..].iter().copied().min().unwrap_or_default();
                let name = method.name();
                // The standard error of ensembles is copied by itself.
                let most = if method.is_dealt() && fragments { 2 } else { 1 };
                assert!(steady <= most, "{name}: {waits:?} waits, lengths: {fragments}");
            }
        }
    });
}

#[test]
fn a_frame_timed_as_a_whole_has_the_bytes_of_others_and_one_time() {
    with_device(|device| {
        for method in Method::all() {
            let mut renderer = Renderer::new(device).expect("a renderer");
            let mut cloud = renderer.upload(&arranged(&method)).expect("fits");
            let mut frame = frame(perspective(), [64, 48], method);
            frame.shading.edl.edl = method.name() == "circles";
            let name = method.name();
            // The first frame casts and compiles; the last ones wait once.
            for number in 0..4 {
                let usual = renderer.render(&mut cloud, &frame).expect("renders");
                let whole = renderer.render_whole(&mut cloud, &frame).expect("renders");
                assert_eq!(bytes(&whole), bytes(&usual), "{name}, {number}");
                assert!(whole.profile.passes.is_empty() && !usual.profile.passes.is_empty(), "{name}, {number}");
                assert_eq!(usual.profile.total, None, "{name}");
                assert!(whole.profile.total.is_some_and(|total| !total.is_zero()), "{name}, {number}");
            }
        }
    });
}

/// The numbers that do not depend on how large buffers are and how work is cut.
fn counted(facts: &Facts) -> Facts {
    Facts { peak_device_bytes: 0, tile_cells: 0, ..facts.clone() }
}

/// Color, depth and counts of each pixel, to the bit.
fn bytes(Rendered { image, .. }: &Rendered) -> [Vec<u32>; 4] {
    let bits = |values: &[f32]| values.iter().map(|value| value.to_bits()).collect();
    let counts = |counts: &Option<Vec<u32>>| counts.clone().unwrap_or_default();
    [bits(image.rgba.as_flattened()), bits(&image.depth), counts(&image.fragments), counts(&image.layers)]
}

/// A camera that is so far from the origin.
fn from(distance: f64) -> Camera {
    let (eye, fov_y) = (glam::DVec3::new(0.2, 0.3, 1.0) * distance, 45f64.to_radians());
    let projection = Projection::Perspective { fov_y };
    Camera::look_at(eye, glam::DVec3::ZERO, glam::DVec3::Y, projection, 0.01, 1000.0).expect("a valid camera")
}

/// Renders frames whose counts are foreseen from the frames before them, and compares their bytes with those of first
/// frames; returns how many were rendered twice.
fn foreseen(device: &Device, methods: impl Iterator<Item = Method>) -> u32 {
    // At rest, a little nearer, suddenly much nearer, to where nothing is, and back.
    let distances = [6.0, 6.0, 6.0, 5.9, 2.0, 2.0, 2.0, 500.0, 500.0, 500.0, 6.0, 6.0, 6.0];
    let mut missed = 0;
    for method in methods {
        let (name, arranged) = (method.name(), arranged(&method));
        for fragments in [false, true] {
            let mut renderer = Renderer::new(device).expect("a renderer");
            // Without times barriers stand only where they must.
            renderer.timed = fragments;
            let mut cloud = renderer.upload(&arranged).expect("fits");
            let mut alone: Vec<(f64, Rendered)> = Vec::new();
            for (number, distance) in distances.into_iter().enumerate() {
                let frame = Frame { fragments, ..frame(from(distance), [64, 48], method) };
                let at = alone.iter().position(|(known, _)| *known == distance).unwrap_or_else(|| {
                    let mut renderer = Renderer::new(device).expect("a renderer");
                    let mut fresh = renderer.upload(&arranged).expect("fits");
                    alone.push((distance, renderer.render(&mut fresh, &frame).expect("renders")));
                    alone.len() - 1
                });
                let wanted = &alone[at].1;
                let found = renderer.render(&mut cloud, &frame).expect("renders");
                assert!(bytes(&found) == bytes(wanted), "{name}, frame {number} from {distance}: other bytes");
                assert_eq!(counted(&found.facts), counted(&wanted.facts), "{name}, frame {number} from {distance}");
                missed += u32::from(distance == 2.0 && found.profile.waits > wanted.profile.waits);
            }
        }
    }
    missed
}

#[test]
fn what_is_foreseen_changes_no_byte() {
    with_device(|device| {
        let missed = foreseen(device, Method::all().into_iter());
        assert!(missed > 20, "frames that were rendered twice: {missed}");
    });
}

/// The host foresees more large splats, and pairs of them with tiles, than a frame has.
#[test]
fn what_is_foreseen_of_large_splats_changes_no_byte() {
    let visiting = ["circles", "linked-list", "peel", "soft-base"];
    with_device_that_prefers(Preferences { small_area: 4, ..Preferences::CPU }, |device| {
        let missed = foreseen(device, Method::all().into_iter().filter(|method| visiting.contains(&method.name())));
        assert!(missed > 3, "frames that were rendered twice: {missed}");
    });
}

/// Six frames of a renderer of their own, within a budget.
fn six(device: &Device, points: &Points, plain: &Frame, budget: u64) -> [Rendered; 6] {
    let mut renderer = Renderer::new(device).expect("a renderer");
    let mut cloud = renderer.upload(points).expect("fits");
    let frame = Frame { memory_budget: Some(budget), ..*plain };
    [(); 6].map(|()| renderer.render(&mut cloud, &frame).expect("renders"))
}

/// The smallest budget within which the first frame of a renderer, which has no margin, is rendered in one go.
fn least_budget(device: &Device, points: &Points, plain: &Frame) -> u64 {
    let mut renderer = Renderer::new(device).expect("a renderer");
    let mut cloud = renderer.upload(points).expect("fits");
    let mut is_enough = |bytes| {
        renderer.forget();
        let frame = Frame { memory_budget: Some(bytes), ..*plain };
        let rendered = renderer.render(&mut cloud, &frame);
        rendered.is_ok_and(|rendered| (rendered.facts.bands, rendered.facts.windows) == (1, 1))
    };
    let (mut less, mut enough) = (32 << 10, 64 << 20);
    assert!(!is_enough(less) && is_enough(enough));
    while enough - less > 1 {
        let middle = less.midpoint(enough);
        *(if is_enough(middle) { &mut enough } else { &mut less }) = middle;
    }
    enough
}

#[test]
fn a_margin_that_the_budget_lacks_is_done_without() {
    with_device(|device| {
        // So many fragments, and so many splats, that they take most of the budget, which a margin makes more of.
        for (method, points, size) in [
            (Method::ABuffer(Default::default()), soup(7, 400, 0.3..0.6, 0.1..0.5, false), [128, 96]),
            (Method::Sorted(Default::default()), soup(7, 4000, 0.1..0.3, 0.1..0.5, false), [16, 12]),
        ] {
            let (points, plain) = (scene(&points), frame(perspective(), size, method));
            let least = least_budget(device, &points, &plain);
            let budgets = [least, least + least / 16, least + least / 4, least * 2];
            let all = budgets.map(|budget| six(device, &points, &plain, budget));
            let [tight, .., roomy] = &all;
            let name = method.name();
            for (frame, budget) in
                all.iter().zip(budgets).flat_map(|(frames, budget)| frames.iter().map(move |f| (f, budget)))
            {
                assert!(bytes(frame) == bytes(&tight[0]), "{name}, {budget} bytes: other bytes");
            }
            let [waits, roomy_waits] = [tight, roomy].map(|frames| frames.each_ref().map(|f| f.profile.waits));
            // Frames that wait have no margin, and take what the first one takes.
            assert!(waits.iter().all(|n| *n >= waits[0]), "{name}, {least} bytes: {waits:?} waits");
            let peaks = tight.each_ref().map(|frame| frame.facts.peak_device_bytes);
            assert!(peaks.iter().all(|peak| *peak <= peaks[0]), "{name}, {least} bytes: {peaks:?}");
            // One that took long, as by compiling, lets the next one wait.
            let fewest = roomy_waits[2..].iter().min();
            assert!(fewest < Some(&waits[0]), "{name}, {least} bytes twice: {roomy_waits:?} waits");
        }
    });
}

/// Writes prefix sums of ten ones into a buffer, unless a word is more than foreseen; what is in the buffer then.
fn summed(device: &Device, word: u32, most: u32) -> Vec<u32> {
    let ones = device.upload("ones", &[1u32; 10]).expect("fits");
    let buffer = |name| device.upload(name, &[0u32]).expect("fits");
    let (words, bounds, go, overflow) = (buffer("words"), buffer("most"), buffer("go"), buffer("overflow"));
    let sums: Buffer<u32> = device.buffer("sums", 10, Memory::Device).expect("fits");
    let mut recorder = device.recorder().expect("a recorder");
    recorder.update(go.all(), &[1]);
    recorder.update(words.all(), &[word]);
    recorder.update(bounds.all(), &[most]);
    recorder.fill("test/fill", sums.all(), 77).expect("recorded");
    recorder.only_within(words.all(), bounds.all(), go.all()).expect("recorded");
    let paused = recorder.pause();
    let mut recorder = paused.resume();
    let (values, offsets, overflow) = (ones.all(), sums.all(), overflow.all());
    let spread = Spread { values, starts: values, offsets, overflow };
    let run = Run::new(Dispatch::Invocations(1)).variant(spread_variant(true));
    recorder.run(&spread, ScanPush { count: 10 }, &run).expect("recorded");
    recorder.submit("test").expect("submitted");
    sums.read(0, 10).expect("readable")
}

#[test]
fn what_follows_a_count_that_is_larger_than_foreseen_is_left_out() {
    with_device(|device| {
        let done: Vec<u32> = (0..10).collect();
        assert_eq!(summed(device, 5, 5), done);
        assert_eq!(summed(device, 0, 5), done);
        assert_eq!(summed(device, 6, 5), [77; 10]);
        assert_eq!(summed(device, u32::MAX, 5), [77; 10]);
    });
}

/// A recording that was interrupted keeps what it was given, even if that is dropped; nothing stays behind it.
#[test]
fn what_an_interrupted_recording_was_given_may_be_dropped() {
    with_only_device(|device| {
        let to = device.upload("to", &[0u32; 4]).expect("fits");
        for submits in [true, false] {
            let before = device.live_allocations().len();
            let from = device.upload("dropped on the way", &[1u32, 2, 3, 4]).expect("fits");
            let mut recorder = device.recorder().expect("a recorder");
            recorder.copy("test/copy", from.all(), to.all()).expect("recorded");
            let paused = recorder.pause();
            drop(from);
            let named = |name: &str| device.live_allocations().iter().any(|(n, _)| n == name);
            assert!(named("dropped on the way"), "it is still needed");
            if submits {
                paused.resume().submit("test").expect("submitted");
                assert_eq!(to.read(0, 4).expect("readable"), [1, 2, 3, 4]);
            } else {
                drop(paused);
            }
            assert!(!named("dropped on the way"));
            assert_eq!(device.live_allocations().len(), before);
        }
    });
}
