// spbr/nearest-depth: the smallest depth of each pixel and ensemble. First of two passes where the device has no 64-bit
// atomics; complements of depths and indices, as in key_words without epochs.
#import spbr
#import nearest
#walker
@group(0) @binding(6) var<storage, read_write> nearest: array<NearestAtomic>;

fn visit(point: u32, plane: u32, depth: u32, pixel: u32) {
    atomicMax(&nearest[plane * push.pixels + pixel].key, ~depth);
}
