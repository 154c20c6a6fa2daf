// points/nearest-depth: the smallest depth of each pixel, by atomic minimum of its key; all ones at the start. First of two
// passes where the device has no 64-bit atomics.
#import points
#import nearest
@group(0) @binding(6) var<storage, read_write> nearest: array<NearestAtomic>;

fn visit(i: u32, hit: Hit) -> u32 {
    atomicMin(&nearest[hit.pixel].key, hit.key);
    return 1u;
}
