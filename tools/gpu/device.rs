//! The device and its limits.

use pellucid_engine::Result;
use pellucid_gpu::{Device, checks};
use serde_json::json;

use crate::lines;

/// Prints one line.
pub fn run(device: &Device) -> Result<bool> {
    let (info, limits) = (device.info(), device.limits());
    lines::put(
        "device",
        json!({
            "name": info.name, "driver": info.driver, "type": info.kind, "pellucid": env!("CARGO_PKG_VERSION"),
            // A debug build does more than is measured.
            "checks": checks(),
            "timestamp_period_ns": info.timestamp_period_ns, "subgroup": info.subgroup,
            "int64_atomics": info.int64_atomics, "fragment_atomics": info.fragment_atomics,
            "pipeline_statistics": info.pipeline_statistics, "conditional": info.conditional,
            "multisampled": info.multisampled, "prefers": format!("{:?}", info.prefers),
            "binding_bytes": limits.binding_bytes, "allocation_bytes": limits.allocation_bytes,
            "buffer_bytes": limits.buffer_bytes, "heap_bytes": limits.heap_bytes, "groups_x": limits.groups_x, "shared_bytes": limits.shared_bytes,
            "storage_buffers": limits.storage_buffers,
        }),
    );
    Ok(true)
}
