//! Colors that stay on the device are those that come to the host, and come there where the device has not all of them.

use pellucid_core::progress::Progress;
use pellucid_engine::methods::{Frame, Renderer};
use pellucid_engine::passes::project::DeviceCloud;
use pellucid_gpu::Device;
use pellucid_scene::prepare::Arranged;
use pellucid_scene::prepare::ensembles::deal;
use pellucid_scene::{Edl, Method, Shading};
use pellucid_testing::*;

const SIZE: [u32; 2] = [64, 40];

/// A renderer that leaves colors on the device, with a cloud.
fn leaving(device: &Device) -> (Renderer, DeviceCloud) {
    let points = scene(&soup(31, 400, 0.02..0.1, 0.1..0.9, false));
    let mut renderer = Renderer::new(device).expect("a renderer");
    renderer.host_colors = false;
    let cloud = renderer.upload(&points).expect("fits");
    (renderer, cloud)
}

#[test]
fn colors_that_stay_are_those_that_come() {
    with_device(|device| {
        let (mut renderer, mut cloud) = leaving(device);
        let points = scene(&soup(31, 400, 0.02..0.1, 0.1..0.9, false));
        let mut dealt = renderer.upload(&Arranged::Dealt(deal(vec![points], 1, &Progress::hidden()))).expect("fits");
        let mut brightened = 0;
        for method in Method::all() {
            let frame = frame(perspective(), SIZE, method);
            let cloud = if method.is_dealt() { &mut dealt } else { &mut cloud };
            renderer.host_colors = true;
            let image = renderer.render(cloud, &frame).expect("renders").image;
            renderer.host_colors = false;
            // Twice: the second frame of a kind knows the counts of the first.
            for _ in 0..2 {
                let left = renderer.render(cloud, &frame).expect("renders");
                let name = method.name();
                if left.image.has_colors() {
                    assert!(left.image == image && name == "spbr-simplified", "{name}");
                    brightened += 1;
                    continue;
                }
                assert_eq!(left.image.depth, image.depth, "{name}");
                let read = left.profile.passes.iter().find(|pass| pass.name == "image/read-back").expect("depths");
                assert_eq!(read.bytes, Some(u64::from(SIZE[0] * SIZE[1]) * 8), "{name}");
                let colors = renderer.read_colors().expect("can be read").expect("are there");
                assert!(bits_of(&colors) == bits_of(&image.rgba), "{name}");
                renderer.recycle(left.image);
            }
        }
        assert_eq!(brightened, 2, "one method changes colors on the host");
    });
}

fn bits_of(colors: &[[f32; 4]]) -> Vec<[u32; 4]> {
    colors.iter().map(|color| color.map(f32::to_bits)).collect()
}

#[test]
fn colors_come_where_the_device_has_not_all_of_them() {
    with_device(|device| {
        let (mut renderer, mut cloud) = leaving(device);
        let plain = frame(perspective(), SIZE, Method::ABuffer(Default::default()));
        let edl = Edl { edl: true, ..Edl::default() };
        let lit = Frame { shading: Shading { edl, ..plain.shading }, ..plain };
        let cut = Frame { size: [600, 500], memory_budget: Some(1 << 20), ..plain };
        let deep = Frame { depths: true, ..plain };
        for (frame, windows) in [(lit, 1..2), (deep, 1..2), (cut, 2..1000)] {
            let there = renderer.render(&mut cloud, &frame).expect("renders");
            assert!(windows.contains(&there.facts.windows), "{}", there.facts.windows);
            assert!(there.image.has_colors() && renderer.colors().is_none());
            renderer.host_colors = true;
            let image = renderer.render(&mut cloud, &frame).expect("renders").image;
            renderer.host_colors = false;
            assert!(there.image == image);
        }
    });
}

#[test]
fn colors_are_gone_once_anything_else_is_rendered() {
    with_device(|device| {
        let (mut renderer, mut cloud) = leaving(device);
        let frame = frame(perspective(), SIZE, Method::ABuffer(Default::default()));
        let left = |renderer: &mut Renderer, cloud: &mut DeviceCloud| {
            renderer.render(cloud, &frame).expect("renders");
            assert!(renderer.colors().is_some());
        };
        left(&mut renderer, &mut cloud);
        renderer.survey(&mut cloud, &frame).expect("surveys");
        assert!(renderer.colors().is_none());
        left(&mut renderer, &mut cloud);
        device.allow_submissions(Some(0));
        assert!(renderer.render(&mut cloud, &frame).is_err() && renderer.colors().is_none());
        device.allow_submissions(None);
    });
}
