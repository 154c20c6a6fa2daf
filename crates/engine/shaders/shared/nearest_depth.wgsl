// Finds each pixel's smallest depth key; all ones at the start. First of two passes where the device has no 64-bit
// atomics.
#import nearest
@group(0) @binding(NEAREST_BINDING) var<storage, read_write> nearest: array<NearestAtomic>;

// As in shared/nearest_wide.
fn offer(pixel: u32, key: u32, id: u32) -> u32 {
    atomicMin(&nearest[pixel].key, key);
    return 1u;
}
