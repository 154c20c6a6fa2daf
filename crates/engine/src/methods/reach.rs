//! Methods that a device can run.

use super::engine_of;
use crate::gpu::DeviceInfo;
use crate::scene::Method;

/// Returns the names of the methods that a device can't run because it lacks the subgroups that tiles of splats need.
/// The soft methods need them too where there are solid points.
pub fn without_subgroups(device: &DeviceInfo) -> Vec<&'static str> {
    if device.subgroup.is_some() { Vec::new() } else { need_subgroups(device) }
}

/// Returns the names of the methods that go through tiles of splats whatever they draw on this device.
pub fn need_subgroups(device: &DeviceInfo) -> Vec<&'static str> {
    let needs = |method: &Method| engine_of(method).needs_subgroups(device);
    Method::all().iter().filter(|method| needs(method)).map(Method::name).collect()
}
