//! The device layer through its public interface: memory, errors, recorder, caches, validation.

use glam::Vec3;
use pellucid_engine::passes::scan::{self, Scan, ScanPush};
use pellucid_gpu::{Device, DeviceOptions, Dispatch, Error, Format, GpuType, Memory, Preferences, Run, devices};
use pellucid_scene::{Discs, Method};
use pellucid_testing::{
    P, alone, at_pixel, frame, pixel_camera, render, scene, with_device, with_device_of, with_new_device,
    with_only_device,
};

/// Uploads, reads all and a part.
fn assert_round_trip<T: GpuType + PartialEq + std::fmt::Debug>(device: &Device, content: &[T]) {
    let buffer = device.upload("round trip", content).expect("fits");
    let len = content.len() as u64;
    assert_eq!((buffer.len(), buffer.bytes()), (len, len * size_of::<T>() as u64));
    // Not with assert_eq, which would print millions of elements.
    assert!(buffer.read(0, len).expect("readable") == content, "{len} elements");
    let (start, count) = (len / 3, len - len / 3 - len / 4);
    let part = buffer.read(start, count).expect("readable");
    assert!(part == content[start as usize..(start + count) as usize], "{count} of {len} from {start}");
}

#[test]
fn what_is_uploaded_is_read_back() {
    with_device(|device| {
        // Around the 16 MiB of a staging buffer, too: 4 Mi words.
        for len in [1usize, 2, 3, 5, 63, 64, 65, 1001, (4 << 20) - 1, 4 << 20, (4 << 20) + 1] {
            assert_round_trip(device, &(0..len as u32).map(|i| i.wrapping_mul(2_654_435_761)).collect::<Vec<_>>());
        }
        for len in [1u64, 7, 1000] {
            assert_round_trip(device, &(0..len).map(|i| i << 33 | 1).collect::<Vec<_>>());
            assert_round_trip(
                device,
                &(0..len).map(|i| [i as f32, -0.5, f32::MAX, f32::MIN_POSITIVE]).collect::<Vec<_>>(),
            );
        }
        let nothing = device.upload::<u32>("nothing", &[]).expect("room for one element");
        assert!(nothing.read(0, 0).expect("readable").is_empty());
    });
}

#[test]
fn fills_and_copies_keep_to_their_ranges() {
    with_device(|device| {
        let from = device.upload("from", &(0..100u32).collect::<Vec<_>>()).expect("fits");
        let to = device.upload("to", &[7u32; 100]).expect("fits");
        let mut recorder = device.recorder().expect("a recorder");
        recorder.fill("test/fill", to.slice(10, 5), u32::MAX).expect("recorded");
        recorder.copy("test/copy", from.slice(90, 3), to.slice(13, 3)).expect("recorded");
        recorder.copy("test/copy", to.slice(14, 1), to.slice(99, 1)).expect("recorded");
        let submitted = recorder.submit("test").expect("submitted");
        let names: Vec<_> = submitted.passes.iter().map(|pass| pass.name).collect();
        assert_eq!(names, ["test/fill", "test/copy", "test/copy"]);
        let mut expected = vec![7u32; 100];
        expected[10..13].fill(u32::MAX);
        // In the order of recording: the copy wins over the fill, and the last one sees what the second wrote.
        expected[13..16].copy_from_slice(&[90, 91, 92]);
        expected[99] = 91;
        assert_eq!(to.read(0, 100).expect("readable"), expected);
    });
}

#[test]
fn buffers_beyond_every_limit_are_clean_errors() {
    with_only_device(|device| {
        let limit = device.limits().buffer_bytes;
        for len in [u64::MAX, u64::MAX / 4, limit / 4 + 1] {
            for memory in [Memory::Device, Memory::Upload, Memory::Readback] {
                match device.buffer::<u32>("absurd", len, memory).map(drop) {
                    Err(e @ Error::TooLarge { .. }) => assert!(e.to_string().starts_with("absurd needs"), "{e}"),
                    other => panic!("{len} elements: {other:?}"),
                }
            }
        }
        assert_eq!(device.live_allocations(), [], "what failed holds nothing");
        // Twice what there is, in pieces that are allowed. Drivers that promise more than they have may give it all.
        let heap = device.limits().heap_bytes;
        let piece = limit.min(heap / 2) / 4;
        let mut held = Vec::new();
        while held.len() as u64 * piece * 4 < 2 * heap {
            match device.buffer::<u32>("piece", piece, Memory::Device) {
                Ok(buffer) => held.push(buffer),
                Err(e @ (Error::OutOfMemory { .. } | Error::TooLarge { .. })) => {
                    assert!(e.to_string().contains("piece needs"), "{e}");
                    break;
                }
                Err(other) => panic!("{other}"),
            }
        }
        drop(held);
        assert_round_trip(device, &[1u32, 2, 3]);
    });
}

#[test]
fn allocations_larger_than_promised_are_tried_on_devices_of_that_kind_alone() {
    for prefers in [Preferences::CPU, Preferences::GPU] {
        let (allocation_bytes, prefers) = (Some(1 << 20), Some(prefers));
        with_device_of(&DeviceOptions { allocation_bytes, prefers, ..DeviceOptions::validated() }, |device| {
            let is_tried = device.info().prefers.large_allocations;
            let limits = *device.limits();
            assert_eq!(limits.allocation_bytes, 1 << 20);
            assert_eq!(limits.buffer_bytes == 1 << 20, !is_tried);
            device.buffer::<u32>("promised", 1 << 18, Memory::Device).expect("as large as is promised");
            match device.buffer::<u32>("larger", 1 << 19, Memory::Device) {
                Ok(buffer) => {
                    let numbers: Vec<u32> = (0..1 << 19).collect();
                    buffer.upload(&numbers).expect("uploaded");
                    assert!(is_tried && buffer.read(0, 1 << 19).expect("readable") == numbers);
                }
                Err(Error::TooLarge { bytes, limit, limit_name, .. }) => {
                    assert_eq!((is_tried, bytes, limit), (false, 1 << 21, 1 << 20));
                    assert_eq!(limit_name, "maxMemoryAllocationSize");
                }
                Err(other) => panic!("{other}"),
            }
        });
    }
}

#[test]
fn allocations_are_reported_by_name_until_they_are_gone() {
    with_new_device(|device| {
        device.reset_peak();
        let kept = device.buffer::<u32>("kept", 1000, Memory::Device).expect("fits");
        let gone = device.buffer::<u64>("gone", 10, Memory::Readback).expect("fits");
        let names = || device.live_allocations().into_iter().map(|(name, _)| name).collect::<Vec<_>>();
        assert_eq!(names(), ["gone", "kept"]);
        assert!(device.live_allocations()[1].1 >= 4000, "bytes as the driver rounds them");
        drop(gone);
        assert_eq!(names(), ["kept"]);
        drop(kept);
        assert_eq!(names(), [""; 0]);
        assert!(device.peak_bytes() >= 4080, "the peak stays");
    });
}

/// Old validation layers race with whoever frees a command buffer (CONTRIBUTING.md), and two recorders must not share a
/// pool.
#[test]
fn command_buffers_are_used_again_and_never_shared() {
    with_new_device(|device| {
        let buffer = device.buffer::<u32>("numbers", 64, Memory::Device).expect("fits");
        for round in 0..50 {
            let mut recorder = device.recorder().expect("a recorder");
            assert_eq!(device.idle_command_buffers(), 0, "the one there is, in use");
            recorder.fill("fill", buffer.all(), round).expect("recorded");
            recorder.submit("fill").expect("submitted");
            assert_eq!(device.idle_command_buffers(), 1);
        }
        // One that is given up while it records is whole again.
        let mut given_up = device.recorder().expect("a recorder");
        given_up.fill("fill", buffer.all(), 7).expect("recorded");
        drop(given_up);
        // Two at a time, on two threads, each record and submit for themselves.
        let barrier = std::sync::Barrier::new(2);
        std::thread::scope(|scope| {
            for word in [1u32, 2] {
                let barrier = &barrier;
                scope.spawn(move || {
                    let own = device.buffer::<u32>("own", 1000, Memory::Device).expect("fits");
                    for _ in 0..20 {
                        barrier.wait();
                        let mut recorder = device.recorder().expect("a recorder");
                        barrier.wait();
                        recorder.fill("fill", own.all(), word).expect("recorded");
                        recorder.submit("fill").expect("submitted");
                        assert_eq!(own.read(0, 1000).expect("readable"), [word; 1000]);
                    }
                });
            }
        });
        assert_eq!(device.idle_command_buffers(), 2);
        assert_eq!(buffer.read(0, 1).expect("readable"), [49]);
    });
}

#[test]
fn an_unknown_device_is_refused_with_those_present() {
    alone(|| {
        let (present, taken) = devices(None).expect("the list");
        let info = &present[taken.expect("one can be taken")];
        for wanted in ["nonsense", "4294967295"] {
            let error = devices(Some(wanted)).expect_err("no such device");
            assert!(matches!(error, Error::NoSuchDevice { .. }), "{error}");
            let options = DeviceOptions { device: Some(wanted.to_owned()), validation: false, ..Default::default() };
            let error = Device::open(&options).map(|_| ()).expect_err("no such device").to_string();
            assert!(error.contains(wanted) && present.iter().all(|d| error.contains(&d.name)), "{error}");
        }
        // By index and by a part of the name in any case.
        let part = info.name.split_whitespace().next().expect("a name").to_uppercase();
        for wanted in [info.index.to_string(), part] {
            let options = DeviceOptions { device: Some(wanted.clone()), validation: false, ..Default::default() };
            let device = Device::open(&options).unwrap_or_else(|e| panic!("{wanted}: {e}"));
            assert_eq!(device.info().name, info.name);
        }
    });
}

#[test]
fn every_pass_of_a_long_recording_is_timed() {
    with_device(|device| {
        // One pair of query pools covers 128 passes, and so does one pool of descriptor sets.
        let values = device.upload("values", &[1u32; 300]).expect("fits");
        let offsets = device.buffer::<u32>("offsets", 300, Memory::Device).expect("fits");
        let scan = Scan::new(device, 300).expect("fits");
        for count in [1, 127, 128, 129, 300] {
            let mut recorder = device.recorder().expect("a recorder");
            for i in 0..count {
                if i % 2 == 0 {
                    recorder.fill("test/fill", values.all(), i).expect("recorded");
                } else {
                    // 300 elements: one pass up, two down.
                    scan.record(&mut recorder, values.all(), offsets.all()).expect("recorded");
                }
            }
            let submitted = recorder.submit("long").expect("submitted");
            let named = |name: &str| submitted.passes.iter().filter(|pass| pass.name == name).count() as u32;
            let (fills, scans) = (count.div_ceil(2), count / 2);
            let found = ["test/fill", "scan/reduce", "scan/spread"].map(named);
            assert_eq!(found, [fills, scans, 2 * scans], "{count}");
            let total: std::time::Duration = submitted.passes.iter().map(|pass| pass.gpu).sum();
            assert!(!total.is_zero() && total <= submitted.wall, "{total:?} of {:?}", submitted.wall);
            if count > 1 {
                // The last fill was of the last even number.
                let last = if count % 2 == 0 { count - 2 } else { count - 3 };
                assert_eq!(offsets.read(299, 1).expect("readable"), [299 * last], "{count}");
            }
        }
    });
}

#[test]
fn invocations_are_counted_where_the_device_can() {
    with_device(|device| {
        let n = 100_000u64;
        let values = device.upload("values", &vec![1u32; n as usize]).expect("fits");
        let offsets = device.buffer::<u32>("offsets", n, Memory::Device).expect("fits");
        let scan = Scan::new(device, n).expect("fits");
        let mut recorder = device.recorder().expect("a recorder");
        recorder.fill("test/fill", offsets.all(), 0).expect("recorded");
        scan.record(&mut recorder, values.all(), offsets.all()).expect("recorded");
        let submitted = recorder.submit("scan").expect("submitted");
        // 64 elements for each invocation; the last workgroup is filled up.
        let wanted = n.div_ceil(64);
        for pass in [&submitted.passes[1], submitted.passes.last().expect("a pass")] {
            match pass.invocations {
                Some(count) => assert!((wanted..wanted + 256).contains(&count), "{}: {count} of {wanted}", pass.name),
                None => assert!(!device.info().pipeline_statistics, "{} is not counted", pass.name),
            }
        }
        assert_eq!(submitted.passes[0].invocations, None, "a fill has no shader");
    });
}

#[test]
fn dispatches_of_more_than_65535_workgroups_reach_the_end() {
    with_device(|device| {
        // 65 535 workgroups of 64 cover 4 194 240 pixels, one each: two rows less than this.
        let size = [2048, 2050];
        assert!(u64::from(size[0]) * u64::from(size[1]) > 65_536 * 64);
        let last = [size[0] - 1, size[1] - 1];
        let ends = [[0, 0], [17, 2047], [5, 2048], last];
        let points = ends.map(|[x, y]| P {
            position: at_pixel(f64::from(x) + 0.5, f64::from(y) + 0.5, 2.0),
            color: Vec3::new(0.25, 0.5, 1.0),
            opacity: 0.5,
            radius: 0.25,
            normal: Vec3::ZERO,
        });
        for (method, alpha) in [(Method::Points, 1.0), (Method::ABuffer(Discs::default()), 0.5)] {
            let image = render(device, &scene(&points), &frame(pixel_camera(size), size, method));
            let found: Vec<_> = (0..).zip(&image.rgba).filter(|(_, rgba)| rgba[3] != 0.0).collect();
            let pixels: Vec<[u32; 2]> = found.iter().map(|(i, _)| [i % size[0], i / size[0]]).collect();
            assert_eq!(pixels, ends, "{}", method.name());
            assert!(found.iter().all(|(_, rgba)| rgba[3] == alpha), "{found:?}");
        }
    });
}

#[test]
fn a_validation_message_is_an_error() {
    alone(|| {
        let options = DeviceOptions {
            device: std::env::var("PELLUCID_TEST_DEVICE").ok(),
            validation: true,
            ..Default::default()
        };
        let device = Device::open(&options).expect("a device");
        device.check_validation().expect("nothing was said yet");
        let buffer = device.upload("overlapping", &[0u32; 16]).expect("fits");
        let mut recorder = device.recorder().expect("a recorder");
        // Ranges of one copy must not overlap: VUID-vkCmdCopyBuffer-pRegions-00117.
        recorder.copy("test/overlap", buffer.slice(0, 8), buffer.slice(4, 8)).expect("recorded");
        recorder.submit("overlap").expect("submitted");
        let error = device.check_validation().expect_err("a message");
        assert!(matches!(&error, Error::Validation(messages) if messages.len() == 1), "{error}");
        assert!(error.to_string().contains("00117"), "{error}");
        // The object that it is about, by the name that it has on the host.
        assert!(error.to_string().contains("overlapping"), "{error}");
    });
}

#[test]
fn shaders_with_names_and_source_give_the_same_pixels() {
    let size = [24, 16];
    let points: Vec<P> = (0..40u16)
        .map(|i| P {
            position: at_pixel(f64::from(i * 7 % 24) + 0.5, f64::from(i * 5 % 16) + 0.5, 3.0 + f64::from(i)),
            color: Vec3::new(0.25, 0.5, 1.0),
            opacity: 0.5,
            radius: 0.25,
            normal: Vec3::ZERO,
        })
        .collect();
    alone(|| {
        let [plain, debug] = [false, true].map(|debug_shaders| {
            let device = std::env::var("PELLUCID_TEST_DEVICE").ok();
            let options = DeviceOptions { device, debug_shaders, ..DeviceOptions::validated() };
            Device::open(&options).expect("a device")
        });
        for method in [Method::Points, Method::ABuffer(Discs::default()), Method::Sorted(Discs::default())] {
            let frame = frame(pixel_camera(size), size, method);
            let [expected, found] = [&plain, &debug].map(|device| render(device, &scene(&points), &frame).rgba);
            assert!(expected.iter().any(|rgba| rgba[3] > 0.0));
            assert!(expected == found, "{}", method.name());
        }
        debug.check_validation().expect("no message about names or source");
    });
}

/// A prefix sum of `count` words into a buffer, or into the front of one of `room` + 64 words, where only `room` fit.
fn spread(device: &Device, count: u32, room: u64, within: bool) -> Result<(), Error> {
    let values = device.upload("values", &vec![1u32; count as usize]).expect("fits");
    let offsets = device.upload("offsets", &vec![3u32; room as usize + if within { 64 } else { 0 }]).expect("fits");
    let overflow = device.upload("flag", &[0u32]).expect("fits");
    let top = scan::spread_variant(true);
    let run = Run::new(Dispatch::Invocations(1)).variant(top);
    let (values, offsets) = (values.all(), offsets.slice(0, room));
    let mut recorder = device.recorder()?;
    recorder.run(
        &scan::Spread { values, starts: values, offsets, overflow: overflow.all() },
        ScanPush { count },
        &run,
    )?;
    recorder.submit("a scan").map(drop)
}

#[test]
fn one_element_too_far_is_found_with_and_without_robust_access() {
    alone(|| {
        for (robust, within) in [(false, false), (false, true), (true, false), (true, true)] {
            let options = DeviceOptions { robust, gpu_assisted: false, ..DeviceOptions::validated() };
            let device = Device::open(&options).expect("a device");
            for count in [40, 48] {
                spread(&device, count, 48, within).expect("within bounds");
            }
            let error = spread(&device, 49, 48, within).expect_err("49 words in a place for 48").to_string();
            // The 49th prefix sum of ones.
            let wanted =
                "scan/spread: something was written 0 bytes behind the end of offsets (bound as offsets): 0x00000030";
            assert_eq!(error, wanted);
        }
    });
}

#[test]
fn what_a_pass_may_write_behind_another_range_is_no_error() {
    with_device(|device| {
        let (values, flag) = (device.upload("values", &[1u32; 64]).unwrap(), device.upload("flag", &[0u32]).unwrap());
        let offsets = device.upload("offsets", &[7u32; 128]).unwrap();
        let top = scan::spread_variant(true);
        let run = Run::new(Dispatch::Invocations(1)).variant(top);
        let mut recorder = device.recorder().unwrap();
        for offsets in [offsets.slice(0, 64), offsets.slice(64, 64)] {
            let pass = scan::Spread { values: values.all(), starts: values.all(), offsets, overflow: flag.all() };
            recorder.run(&pass, ScanPush { count: 64 }, &run).unwrap();
        }
        recorder.submit("two halves").expect("each half is written by its own pass");
        assert_eq!(offsets.read(0, 128).unwrap(), (0..64).chain(0..64).collect::<Vec<u32>>());
    });
}

/// A dispatch of two words would read its third one from whatever lies behind them.
#[test]
fn indirect_arguments_of_fewer_than_three_words_are_refused() {
    with_device(|device| {
        let (values, flag) = (device.upload("values", &[1u32; 64]).unwrap(), device.upload("flag", &[0u32]).unwrap());
        let offsets = device.upload("offsets", &[7u32; 64]).unwrap();
        let arguments = device.upload("arguments", &[1u32; 3]).unwrap();
        let recorded = |words: u64| {
            let mut recorder = device.recorder().unwrap();
            let pass = scan::Spread {
                values: values.all(),
                starts: values.all(),
                offsets: offsets.all(),
                overflow: flag.all(),
            };
            let top = scan::spread_variant(true);
            let run = Run::new(Dispatch::Indirect(arguments.slice(0, words))).variant(top);
            recorder.run(&pass, ScanPush { count: 64 }, &run).unwrap();
            recorder.submit("an indirect dispatch").unwrap();
        };
        recorded(3);
        assert_eq!(offsets.read(0, 64).unwrap(), (0..64).collect::<Vec<u32>>());
        let refused = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| recorded(2))).expect_err("two words");
        let message = refused.downcast_ref::<String>().expect("a formatted message");
        assert_eq!(message, "scan/spread: a dispatch takes three words");
    });
}

/// GPU-assisted validation sees what shaders do: CONTRIBUTING.md says how it is run.
#[test]
#[ignore = "needs validation layers that instrument shaders: 1.4.309 does, Debian 12's 1.3.239 does not"]
fn gpu_assisted_validation_reports_an_index_out_of_bounds() {
    alone(|| {
        let options = DeviceOptions { validation: true, gpu_assisted: true, ..DeviceOptions::default() };
        let device = Device::open(&options).expect("a device");
        spread(&device, 48, 48, false).expect("within bounds");
        assert_eq!(device.validation_messages(), Vec::<String>::new());
        // Far behind the guard too.
        let _ = spread(&device, 1000, 48, false);
        let messages = device.validation_messages();
        let reported = |m: &String| m.contains("scan/spread") && m.contains("out of bounds");
        assert!(messages.iter().any(reported), "that of Vulkan 1.3.239 reports nothing, 1.4.309 does: {messages:?}");
    });
}

#[test]
fn dispatches_and_images_beyond_what_a_device_has_are_refused_before_they_are_recorded() {
    with_device(|device| {
        let recorder = device.recorder().expect("a recorder");
        let refused = |dispatch| match recorder.arguments("absurd", dispatch) {
            Err(e @ Error::TooLarge { .. }) => assert!(e.to_string().starts_with("absurd needs"), "{e}"),
            other => panic!("{other:?}"),
        };
        // Numbers of invocations have 32 bits: beyond, the first ones would run twice.
        for count in [(1 << 32) + 1, 1 << 40, u64::MAX] {
            refused(Dispatch::Invocations(count));
        }
        refused(Dispatch::Groups(u64::MAX));
        recorder.arguments("large", Dispatch::Invocations(1 << 31)).expect("room for 2^31");
        let [width, height] = device.limits().framebuffer;
        for size in [[0, 1], [1, 0], [width + 1, 1], [1, height + 1], [u32::MAX; 2]] {
            match device.attachment("absurd", Format::Number, 1, size).map(drop) {
                Err(e @ Error::Framebuffer { .. }) => assert!(e.to_string().starts_with("absurd: "), "{e}"),
                other => panic!("{size:?}: {other:?}"),
            }
        }
        drop(recorder);
    });
}
