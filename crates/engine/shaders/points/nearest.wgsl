// points/nearest: depth and index of each pixel's nearest point by one 64-bit atomic minimum; all ones at the start.
#import points
@group(0) @binding(6) var<storage, read_write> nearest: array<atomic<u64>>;

fn visit(i: u32, hit: Hit) -> u32 {
    atomicMin(&nearest[hit.pixel], (u64(hit.key) << 32u) | u64(i));
    return 1u;
}
