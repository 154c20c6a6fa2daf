//! Shared parts of the tests: devices with validation, frames, browsers, and all of [`pellucid_testing_host`].

pub mod browser;
pub mod signals;

mod devices;
mod rendering;

use pellucid_core::camera::Camera;
use pellucid_engine::methods::Frame;
use pellucid_gpu::Device;
use pellucid_scene::Method;

pub use devices::{
    alone, has_device, with_device, with_device_of, with_device_that_binds, with_device_that_prefers, with_new_device,
    with_only_device,
};
pub use pellucid_testing_host::*;
pub use rendering::{by_windows, render, rendered, rendered_by_both_atomics};

/// True if a device is llvmpipe, for which the tests know the results to the last case.
pub fn is_llvmpipe(device: &Device) -> bool {
    device.info().name.contains("llvmpipe")
}

/// A frame without shading or budget, in linear color.
pub fn frame(camera: Camera, size: [u32; 2], method: Method) -> Frame {
    Frame { fragments: true, ..Frame::new(camera, size, method) }
}
