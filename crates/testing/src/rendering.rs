//! Frames on a fresh renderer.

use std::sync::Arc;

use pellucid_core::image::Image;
use pellucid_core::points::Points;
use pellucid_engine::methods::{Frame, Rendered, Renderer, Upload};
use pellucid_engine::passes::project::DeviceCloud;
use pellucid_gpu::Device;
use pellucid_scene::prepare::Arranged;

use crate::bits;

/// Renders on a fresh renderer.
pub fn rendered(device: &Device, points: &Points, frame: &Frame) -> Rendered {
    let mut renderer = Renderer::new(device).expect("a renderer");
    let mut cloud = renderer.upload(points).expect("the cloud fits");
    renderer.render(&mut cloud, frame).expect("the frame renders")
}

/// Renders on a fresh renderer; the image alone.
pub fn render(device: &Device, points: &Points, frame: &Frame) -> Image {
    rendered(device, points, frame).image
}

/// Points in memory that come to the device window by window.
pub fn by_windows(renderer: &Renderer, points: &Arc<Points>) -> DeviceCloud {
    let arranged = Arranged::Canonical(Arc::clone(points));
    renderer.upload(Upload { by_windows: true, ..(&arranged).into() }).expect("small buffers")
}

/// Renders with 64-bit atomics where the device has them, then with 32-bit ones, and asserts that the bytes are the
/// same.
pub fn rendered_by_both_atomics(device: &Device, points: &Points, frame: &Frame) -> [Rendered; 2] {
    let mut renderer = Renderer::new(device).expect("a renderer");
    let mut cloud = renderer.upload(points).expect("the cloud fits");
    let wide = renderer.render(&mut cloud, frame).expect("the frame renders");
    renderer.switches.wide_atomics = false;
    let narrow = renderer.render(&mut cloud, frame).expect("the frame renders");
    assert!(bits(&wide.image) == bits(&narrow.image), "the two kinds of atomics differ");
    assert_eq!((&wide.image.layers, wide.facts.layers), (&narrow.image.layers, narrow.facts.layers));
    [wide, narrow]
}
