//! Measurements: JSON, trace and table of a profile made by hand, and what must hold of measured ones.

use std::time::{Duration, Instant};

use glam::Vec3;
use pellucid_core::progress::{Phase, Span};
use pellucid_engine::methods::{Facts, FrameProfile, PassProfile, Renderer};
use pellucid_engine::pipelines::{PipelineFacts, Pipelines};
use pellucid_engine::profile::{Profile, copy_rate, histogram};
use pellucid_gpu::{Executable, Memory, MemoryBudget, PassTime, Submitted};
use pellucid_scene::stored::Reads;
use pellucid_scene::{Discs, Method};
use pellucid_testing::{P, at_pixel, frame, perspective, pixel_camera, scene, soup, with_device};
use serde_json::json;

/// Two frames of two passes; the second one ran twice in the first frame. Pipelines were made before the first frame
/// and within the second.
fn by_hand() -> Profile {
    let (ms, origin) = (Duration::from_millis, Instant::now());
    let span = |phase, begin, length| Span { phase, begin: origin + ms(begin), length: ms(length) };
    let pass = |name, gpu, invocations, bytes| PassProfile { name, gpu: ms(gpu), invocations, bytes };
    let run = |name, gpu, start| (PassTime { name, gpu: ms(gpu), begin: None, invocations: Some(64) }, ms(start));
    Profile {
        device: "a device".into(),
        driver: "a driver".into(),
        timestamp_period_ns: 0.5,
        method: "peel",
        pixels: 12,
        samples: 1,
        steady: Some(true),
        read: Reads { nodes: 3, bytes: 700 },
        peak_host_bytes: Some(1 << 21),
        memory: Some(MemoryBudget { budget: 6 << 20, used: 2 << 20 }),
        facts: Facts {
            points: 6,
            shown: 5,
            fragments: 30,
            max_list: 4,
            bands: 2,
            fragment_bytes: 240,
            peak_device_bytes: 1 << 20,
            ..Facts::default()
        },
        host: vec![
            span(Phase::Read, 0, 3),
            span(Phase::Frame, 3, 37),
            span(Phase::Read, 40, 2),
            span(Phase::Write, 42, 1),
            span(Phase::Compile, 4, 2),
            span(Phase::Compile, 25, 4),
        ],
        list_histogram: histogram(&[0, 4, 3, 3, 4, 4, 4, 4, 4, 0, 0, 0]),
        clouds: Vec::new(),
        pipelines: Pipelines::Unasked,
        tile_histogram: None,
        frames: vec![
            FrameProfile {
                passes: vec![pass("x/a", 1, None, None), pass("x/b", 5, Some(128), Some(1 << 20))],
                begin: origin + ms(7),
                timeline: vec![run("x/a", 1, 0), run("x/b", 2, 1), run("x/b", 3, 4)],
                submitted: ms(8),
                total: Some(ms(4)),
                wall: ms(10),
                waits: 3,
            },
            FrameProfile {
                passes: vec![pass("x/a", 3, None, None), pass("x/b", 7, Some(128), Some(1 << 20))],
                begin: origin + ms(18),
                timeline: vec![run("x/a", 3, 0), run("x/b", 7, 3)],
                submitted: ms(12),
                total: None,
                wall: ms(20),
                waits: 1,
            },
        ],
        totals: None,
    }
}

#[test]
fn the_json_is_the_documented_one() {
    let pass = |name: &str, gpu: f64, invocations: Option<u64>, bytes: Option<u64>| json!({ "name": name, "gpu_ms": gpu, "invocations": invocations, "bytes": bytes });
    let expected = json!({
        "version": 1,
        "device": { "name": "a device", "driver": "a driver", "timestamp_period_ns": 0.5 },
        "method": "peel",
        "steady": true,
        "scene": { "points": 5, "pixels": 12, "samples": 1, "fragments": 30, "max_list": 4,
                   "list_histogram": [[0, 4], [3, 2], [4, 6]], "nodes_read": 3, "bytes_read": 700 },
        "memory": { "peak_device_bytes": 1_048_576, "device_budget_bytes": 6_291_456, "device_used_bytes": 2_097_152,
                    "peak_host_bytes": 2_097_152, "fragment_bytes": 240, "bands": 2 },
        "host": [
            { "name": "read", "ms": 5.0 },
            { "name": "compile", "ms": 6.0 },
            { "name": "frame", "ms": 31.0 },
            { "name": "write", "ms": 1.0 },
        ],
        "frames": [
            { "gpu_ms": 6.0, "total_ms": 4.0, "wall_ms": 10.0, "waits": 3,
              "passes": [pass("x/a", 1.0, None, None), pass("x/b", 5.0, Some(128), Some(1_048_576))] },
            { "gpu_ms": 10.0, "total_ms": null, "wall_ms": 20.0, "waits": 1,
              "passes": [pass("x/a", 3.0, None, None), pass("x/b", 7.0, Some(128), Some(1_048_576))] },
        ],
    });
    assert_eq!(by_hand().to_json(), expected);
}

#[test]
fn the_trace_has_phases_frames_and_dispatches_where_they_happened() {
    let found = events(&by_hand());
    let expected = [
        (0, "read", 0.0, 3000.0),
        (0, "frame", 3000.0, 37_000.0),
        (0, "compile", 4000.0, 2000.0),
        (0, "frame 0", 7000.0, 10_000.0),
        (1, "x/a", 7000.0, 1000.0),
        (1, "x/b", 8000.0, 2000.0),
        (1, "x/b", 11_000.0, 3000.0),
        (0, "frame 1", 18_000.0, 20_000.0),
        (1, "x/a", 18_000.0, 3000.0),
        (1, "x/b", 21_000.0, 7000.0),
        (0, "compile", 25_000.0, 4000.0),
        (0, "read", 40_000.0, 2000.0),
        (0, "write", 42_000.0, 1000.0),
    ];
    assert_eq!(found, expected.map(|(row, name, ts, dur)| (row, name.to_owned(), ts, dur)));
}

#[test]
fn a_trace_says_how_its_passes_are_placed() {
    let placing = |profile: &Profile| profile.to_trace()["otherData"]["device row"].as_str().unwrap().to_owned();
    let mut profile = by_hand();
    assert!(placing(&profile).ends_with("this device doesn't tell its clock"));
    for (pass, _) in profile.frames.iter_mut().flat_map(|frame| &mut frame.timeline) {
        pass.begin = Some(Instant::now());
    }
    assert!(placing(&profile).starts_with("passes at their times by the device's clock"));
}

/// The device runs nothing while the host sleeps between two submissions, whose passes lie on either side of it.
#[test]
fn passes_of_two_submissions_lie_apart_by_what_the_host_did_between_them() {
    with_device(|device| {
        let buffer = device.buffer::<u32>("numbers", 1 << 16, Memory::Device).expect("fits");
        let submitted = || {
            let mut recorder = device.recorder().expect("a recorder");
            recorder.fill("test/first", buffer.all(), 1).expect("recorded");
            recorder.fill("test/second", buffer.all(), 2).expect("recorded");
            recorder.submit("fills").expect("submitted")
        };
        let before = submitted();
        let rest = Duration::from_millis(50);
        std::thread::sleep(rest);
        let after = submitted();
        let begins =
            |submitted: &Submitted| -> Option<Vec<Instant>> { submitted.passes.iter().map(|p| p.begin).collect() };
        let (Some(early), Some(late)) = (begins(&before), begins(&after)) else {
            return assert!(before.passes.iter().chain(&after.passes).all(|pass| pass.begin.is_none()));
        };
        // Half of the time that reading both clocks takes; far less than this but on a machine that stands still.
        let slack = Duration::from_millis(10);
        for (submitted, begins) in [(&before, &early), (&after, &late)] {
            let end = submitted.begin + submitted.wall;
            assert!(begins.is_sorted(), "{begins:?}");
            assert!(begins.iter().all(|at| *at + slack >= submitted.begin && *at <= end + slack), "{submitted:?}");
        }
        assert!(late[0] - early[1] + slack >= rest, "{early:?} {late:?}");
    });
}

#[test]
fn a_trace_without_phases_begins_with_its_first_frame() {
    let found = events(&Profile { host: Vec::new(), ..by_hand() });
    assert_eq!(found[0], (0, "frame 0".to_owned(), 0.0, 10_000.0));
    assert_eq!(found[4], (0, "frame 1".to_owned(), 11_000.0, 20_000.0));
    assert_eq!(events(&Profile { host: Vec::new(), frames: Vec::new(), ..by_hand() }), []);
}

/// The events of a trace: the number of the row, the name, start and length in microseconds.
fn events(profile: &Profile) -> Vec<(u64, String, f64, f64)> {
    let trace = profile.to_trace();
    let event = |event: &serde_json::Value| {
        let micros = |key: &str| event[key].as_f64().unwrap();
        (event["tid"].as_u64().unwrap(), event["name"].as_str().unwrap().to_owned(), micros("ts"), micros("dur"))
    };
    let all = trace["traceEvents"].as_array().unwrap();
    all.iter().filter(|event| event["ph"] == "X").map(event).collect()
}

#[test]
fn making_pipelines_counts_for_no_other_phase() {
    let ms = Duration::from_millis;
    // 37 ms of frames, in which 2 ms and 4 ms went into pipelines.
    assert_eq!(by_hand().host_times(), [5, 0, 0, 0, 6, 31, 1].map(ms));
    assert_eq!(by_hand().host_text(), "host: read 5.0 ms, compile 6.0 ms, frame 31.0 ms, write 1.0 ms");
}

#[test]
fn the_table_has_least_median_and_greatest_times_and_rates() {
    // 2^20 bytes in a median of 6 ms are 174.76 MB/s: 35% of 0.5 GB/s.
    let table = pellucid_lab::profile_table(&by_hand(), Some(0.5e9));
    let columns = |name: &str| -> Vec<String> {
        let row = table.lines().find(|line| line.split_whitespace().next() == Some(name)).expect(name);
        row.split_whitespace().map(str::to_owned).collect()
    };
    assert_eq!(columns("x/a"), ["x/a", "1.000", "2.000", "3.000", "25.0%"]);
    assert_eq!(columns("x/b"), ["x/b", "5.000", "6.000", "7.000", "75.0%", "128", "1.0", "0.17", "35%"]);
    // Medians of 6 and 10, of 8 and 12, of 10 and 20.
    for part in [
        "passes 8.00 ms of 10.00 ms submitted (80.0%)",
        "read-back 15.00 ms",
        // Of the frame that was measured so, and of 3 and 1 waits.
        "without timestamps between passes: 4.00 ms on the device; 2 wait(s) a frame",
        "2 frame(s)",
        // 6 MiB less 2 MiB.
        "in 2 band(s); 4.0 MiB were free before",
        "12 pixels",
        "host: read 5.0 ms",
    ] {
        assert!(table.contains(part), "{part:?} in {table}");
    }
    assert!(!pellucid_lab::profile_table(&by_hand(), None).contains("copy rate of this device"));
}

#[test]
fn the_table_has_what_the_compiler_says_if_it_was_asked() {
    let last_columns = |profile: &Profile| {
        let table = pellucid_lab::profile_table(profile, Some(0.5e9));
        let row = table.lines().find(|line| line.trim_start().starts_with("x/b")).expect("a row");
        let columns = row.split_whitespace().skip(9).map(str::to_owned).collect::<Vec<_>>();
        (table.contains("registers"), columns, table.contains("a device doesn't tell"))
    };
    let mut profile = by_hand();
    assert_eq!(last_columns(&profile), (false, vec![], false), "nobody asked");
    profile.pipelines = Pipelines::Untold;
    assert_eq!(last_columns(&profile), (false, vec![], true));
    assert_eq!(profile.to_json()["pipelines"], json!(null));
    let statistics = [("VGPRs", 48.0), ("Spilled VGPRs", 3.0), ("LDS size", 1024.0), ("Code size", 2560.0)];
    let statistics = statistics.map(|(name, value)| (name.to_owned(), value)).to_vec();
    let executables = vec![Executable { name: "compute".into(), subgroup: 64, statistics }];
    profile.pipelines = Pipelines::Told(vec![PipelineFacts { pass: "x/b", title: "x/b (A=1)".into(), executables }]);
    // 2560 bytes are 2.5 KiB.
    let wanted = ["48", "3", "1024", "2.5"].map(str::to_owned).to_vec();
    assert_eq!(last_columns(&profile), (true, wanted, false));
    assert_eq!(profile.to_json()["pipelines"][0]["code_bytes"], 2560.0);
}

#[test]
fn work_of_tiles_and_pixels_is_told_if_it_was_asked_for() {
    let mut profile = by_hand();
    assert_eq!((profile.work_line(), profile.to_json().get("work")), (None, None));
    profile.tile_histogram = Some(vec![(0, 1), (2, 2), (7, 1)]);
    // The lists of `by_hand`: four are empty, two have 3 fragments, six have 4.
    assert_eq!(
        profile.to_json()["work"],
        json!({
            "tile_splats": { "busy": 3, "empty": 1, "min": 2, "median": 2.0, "max": 7 },
            "pixel_fragments": { "busy": 8, "empty": 4, "min": 3, "median": 4.0, "max": 4 },
        })
    );
    let line = "work, least / median / most: 2 / 2 / 7 splats in a tile (of 3, 1 more are empty); 3 / 4 / 4 fragments \
                in a pixel (of 8, 4 more are empty)";
    assert!(pellucid_lab::profile_table(&profile, None).lines().any(|found| found == line));
    profile.tile_histogram = Some(Vec::new());
    assert_eq!(profile.to_json()["work"]["tile_splats"], json!(null));
}

/// Three splats at the center of tile (0, 0) and one in tile (2, 1), of 3 × 2 tiles; each is a pixel large.
#[test]
fn tiles_are_noted_with_the_splats_that_meet_them() {
    with_device(|device| {
        let size = [48, 32];
        let points = [[8, 8], [8, 8], [8, 8], [40, 24]].map(|[x, y]: [u16; 2]| P {
            position: at_pixel(f64::from(x) + 0.5, f64::from(y) + 0.5, 2.0),
            color: Vec3::ONE,
            opacity: 0.5,
            radius: 0.001,
            normal: Vec3::ZERO,
        });
        let frame = frame(pixel_camera(size), size, Method::Sorted(Discs::default()));
        let mut renderer = Renderer::new(device).expect("a renderer");
        let mut cloud = renderer.upload(&scene(&points)).expect("fits");
        let mut noted = |notes: bool| {
            renderer.notes_tiles = notes;
            renderer.render(&mut cloud, &frame).expect("rendered").facts.tile_histogram
        };
        assert_eq!(noted(true), [(0, 4), (1, 1), (3, 1)]);
        assert_eq!(noted(false), []);
    });
}

#[test]
fn passes_add_up_to_the_submissions() {
    with_device(|device| {
        let points = scene(&soup(21, 60_000, 0.05..0.2, 0.1..0.9, false));
        let frame = frame(perspective(), [640, 480], Method::ABuffer(Discs::default()));
        let mut renderer = Renderer::new(device).expect("a renderer");
        let mut cloud = renderer.upload(&points).expect("fits");
        let mut shares = Vec::new();
        for _ in 0..5 {
            let profile = renderer.render(&mut cloud, &frame).expect("rendered").profile;
            assert!(profile.gpu() <= profile.submitted && profile.submitted <= profile.wall, "{profile:?}");
            let timeline: Duration = profile.timeline.iter().map(|(pass, _)| pass.gpu).sum();
            assert_eq!(timeline, profile.gpu(), "the passes are their dispatches");
            shares.push(profile.gpu().as_secs_f64() / profile.submitted.as_secs_f64());
        }
        // A submission takes time of its own, some tenths of a millisecond. Other work on the machine may push in
        // between, hence the best of some frames; on a CPU driver these frames take a good part of a second.
        let best = shares.iter().copied().fold(0.0, f64::max);
        let cpu = device.info().kind == "CPU";
        assert!(best > if cpu { 0.95 } else { 0.5 }, "{shares:?}");
    });
}

#[test]
fn the_copy_rate_is_one_that_memory_can_have() {
    with_device(|device| {
        let rate = copy_rate(device).expect("measured");
        // From a slow single board to a few times the fastest memory of today.
        assert!((1e8..1e14).contains(&rate), "{rate} bytes/s");
    });
}
