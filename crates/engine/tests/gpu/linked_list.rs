//! `linked-list`: its lists against the float64 reference, its images against the reference and, to the byte,
//! `abuffer`'s.

use glam::Vec3;
use pellucid_core::points::Points;
use pellucid_engine::methods::{Error, Frame, Renderer};
use pellucid_reference as reference;
use pellucid_reference::View;
use pellucid_scene::{DiscShape, Discs, LongLists, Method};
use pellucid_testing::*;
use rand::seq::SliceRandom;

fn linked() -> Method {
    Method::LinkedList(Discs::default())
}

#[test]
fn gathered_lists_are_the_references_exactly() {
    with_device(|device| {
        let size = [97, 64];
        let mixed = [soup(1, 600, 0.0..0.12, 0.1..0.9, true), soup(2, 30, 0.3..1.5, 0.1..0.9, true)].concat();
        for discs in all_discs() {
            let camera = perspective();
            let points = scene(&safe(&mixed, &camera, size, discs.shape));
            let wanted = reference::abuffer::lists(View::new(&camera, size), &points, &discs);
            let mut renderer = Renderer::new(device).expect("a renderer");
            let mut cloud = renderer.upload(&points).expect("fits");
            let frame = frame(camera, size, Method::LinkedList(discs));
            let found = renderer.lists(&mut cloud, &frame, discs).expect("lists");
            for (pixel, list) in wanted.iter().enumerate() {
                let range = found.offsets[pixel] as usize..found.offsets[pixel + 1] as usize;
                let mut stored: Vec<u32> = found.fragments[range].iter().map(|f| f[1]).collect();
                let mut indices: Vec<u32> = list.iter().map(|f| f.index).collect();
                stored.sort_unstable();
                indices.sort_unstable();
                assert_eq!(stored, indices, "pixel {pixel}, {discs:?}");
            }
        }
    });
}

#[test]
fn images_equal_the_reference_and_the_abuffers_bytes() {
    with_device(|device| {
        let size = [160, 120];
        // Small and large splats: both walkers of compute, and discs that cross.
        let mixed = [soup(3, 1500, 0.0..0.1, 0.0..1.0, true), soup(4, 40, 0.2..2.0, 0.05..0.4, true)].concat();
        for camera in [perspective(), orthographic()] {
            for discs in all_discs() {
                let points = scene(&safe(&mixed, &camera, size, discs.shape));
                let image = render(device, &points, &frame(camera, size, Method::LinkedList(discs)));
                let (largest, _) = difference(&image, &exact(&points, &camera, size, &discs), 0.0);
                assert!(largest < 3e-5, "{discs:?}: {largest}");
                let other = render(device, &points, &frame(camera, size, Method::ABuffer(discs)));
                assert!(bits(&image) == bits(&other), "{discs:?}");
                assert_eq!(image.fragments, other.fragments);
            }
        }
    });
}

#[test]
fn ties_and_shuffled_input_change_no_byte() {
    with_device(|device| {
        // Depths on few levels and coincident positions: plenty of ties between different colors.
        let mut points = soup(21, 3000, 0.02..0.2, 0.1..0.9, true);
        for p in &mut points {
            p.position = (p.position * 4.0).round() / 4.0;
        }
        for discs in all_discs() {
            let [linked, slots] = [Method::LinkedList(discs), Method::ABuffer(discs)]
                .map(|method| frame(orthographic(), [96, 96], method));
            let wanted = bits(&render(device, &scene(&points), &slots));
            let mut shuffled = points.clone();
            for seed in 0..2 {
                assert!(bits(&render(device, &scene(&shuffled), &linked)) == wanted, "{discs:?}");
                shuffled.shuffle(&mut random(seed));
            }
        }
    });
}

/// Discs over the whole image, and 2000 points more in one pixel.
fn stack(size: [u32; 2], discs: u32) -> Points {
    let disc = |i: u32| P {
        position: at_pixel(f64::from(size[0]) / 2.0, f64::from(size[1]) / 2.0, 1.0 + f64::from(i)),
        color: Vec3::new((i % 2) as f32, (i % 5) as f32 / 4.0, 1.0),
        opacity: 0.02,
        radius: 1.0 + size[0].max(size[1]) as f32,
        normal: Vec3::ZERO,
    };
    let in_pixel = |i: u32| P { position: at_pixel(3.5, 5.5, 300.0 + f64::from(i)), radius: 0.0, ..disc(0) };
    scene(&(0..discs).map(disc).chain((0..2000).map(in_pixel)).collect::<Vec<_>>())
}

#[test]
fn bands_and_windows_and_the_way_of_sorting_change_no_byte() {
    with_device(|device| {
        let size = [64, 48];
        let points = stack(size, 200);
        let wanted =
            bits(&render(device, &points, &frame(pixel_camera(size), size, Method::ABuffer(Discs::default()))));
        for long_lists in [LongLists::Merge, LongLists::InPlace] {
            let method = Method::LinkedList(Discs { long_lists, ..Discs::default() });
            let mut frame = frame(pixel_camera(size), size, method);
            for (budget, bands) in [(None, 1), (Some(4u64 << 20), 4), (Some(512 << 10), 35), (Some(256 << 10), 66)] {
                frame.memory_budget = budget;
                let cut = rendered(device, &points, &frame);
                assert!(cut.facts.bands >= bands, "{:?}", cut.facts);
                assert!(bits(&cut.image) == wanted, "{long_lists:?}, budget {budget:?}");
            }
        }
        let mut frame = frame(pixel_camera(size), size, linked());
        frame.memory_budget = Some(100 << 10);
        let mut renderer = Renderer::new(device).expect("a renderer");
        let mut cloud = renderer.upload(&points).expect("fits");
        match renderer.render(&mut cloud, &frame) {
            // Nodes, links, and the fragments in their places; a byte for the records of long lists.
            Err(Error::PixelOverBudget { length: 2200, needed, budget, .. }) => {
                assert_eq!(needed, 2200 * 21);
                frame.memory_budget = Some(budget);
                let cut = renderer.render(&mut cloud, &frame).expect("the budget that the error names does");
                assert!(bits(&cut.image) == wanted);
            }
            other => panic!("expected the pixel over budget, got {:?}", other.map(|r| r.facts)),
        }
    });
}

#[test]
#[ignore = "long: 34 million fragments, four times"]
fn whichever_method_ran_before_the_budget_holds() {
    with_new_device(|device| {
        let size = [512, 512];
        let points = stack(size, 130);
        let budget = 40u64 << 20;
        let mut renderer = Renderer::new(device).expect("a renderer");
        let mut cloud = renderer.upload(&points).expect("fits");
        let in_place = Method::ABuffer(Discs { long_lists: LongLists::InPlace, ..Discs::default() });
        for method in [Method::ABuffer(Discs::default()), linked(), in_place, linked()] {
            let frame = Frame { memory_budget: Some(budget), ..frame(pixel_camera(size), size, method) };
            let facts = renderer.render(&mut cloud, &frame).expect("renders").facts;
            // Image and depth, on the device and on the host.
            let allowed = budget + cloud.bytes() + u64::from(size[0] * size[1]) * 40;
            assert!(facts.bands > 5 && facts.peak_device_bytes <= allowed, "{method:?}: {facts:?}, {allowed}");
            let kept = device.live_allocations();
            let has = |name: &str| kept.iter().any(|(buffer, _)| buffer == name);
            assert_eq!(
                (has("spare fragments"), has("list links")),
                // Flat discs as large as these make ordered lists, which are not merged.
                (method == linked(), method == linked()),
                "{kept:?}"
            );
        }
    });
}

#[test]
fn a_million_fragments_in_one_pixel_are_in_order() {
    with_device(|device| {
        let n = 1_000_000;
        let mut points: Vec<P> = (0..n)
            .map(|i| P {
                position: at_pixel(0.5, 0.5, 1.0 + f64::from(i)),
                color: if i < n / 2 { Vec3::X } else { Vec3::Z },
                opacity: 1e-6,
                radius: 0.0,
                normal: Vec3::ZERO,
            })
            .collect();
        points.shuffle(&mut random(7));
        let points = scene(&points);
        let found = rendered(device, &points, &frame(pixel_camera([1, 1]), [1, 1], linked()));
        assert_eq!(found.facts.max_list, n as u32);
        let opacity = |n: i32| 1.0 - (1.0 - f64::from(1e-6f32)).powi(n);
        let (front, all) = (opacity(n / 2), opacity(n));
        for (found, wanted) in found.image.rgba[0].iter().zip([front, 0.0, all - front, all]) {
            // 256 additions in each run and 3907 of runs, each rounding a value below 1 by half an ulp.
            assert!((f64::from(*found) - wanted).abs() < 1e-4, "{found} {wanted}");
        }
        let other = render(device, &points, &frame(pixel_camera([1, 1]), [1, 1], Method::ABuffer(Discs::default())));
        assert!(bits(&found.image) == bits(&other));
    });
}

#[test]
fn the_comparison_notices_a_fragment_too_few() {
    with_device(|device| {
        let mut points = soup(14, 300, 0.05..0.2, 0.2..0.8, false);
        let discs = Discs { shape: DiscShape::Oriented, ..Discs::default() };
        let frame = |method| frame(perspective(), [64, 64], method);
        let all = bits(&render(device, &scene(&points), &frame(Method::ABuffer(discs))));
        points.truncate(299);
        assert!(bits(&render(device, &scene(&points), &frame(Method::LinkedList(discs)))) != all);
    });
}
