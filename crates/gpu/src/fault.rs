//! Faults on demand, as results of Vulkan.

use ash::vk;
use pellucid_fault::DeviceFault;

/// Returns the Vulkan error that is due at a point.
///
/// # Errors
/// The fault.
pub fn vulkan(point: &str) -> Result<(), vk::Result> {
    pellucid_fault::device(point).map_err(|fault| match fault {
        DeviceFault::Lost => vk::Result::ERROR_DEVICE_LOST,
        DeviceFault::OutOfMemory => vk::Result::ERROR_OUT_OF_DEVICE_MEMORY,
        DeviceFault::Unknown => vk::Result::ERROR_UNKNOWN,
    })
}
