// spbr/nearest: the nearest point of each pixel and ensemble, by one 64-bit atomic maximum.
#import spbr
#walker
@group(0) @binding(6) var<storage, read_write> nearest: array<atomic<u64>>;

fn visit(point: u32, plane: u32, depth: u32, pixel: u32) {
    let words = key_words(point, depth);
    atomicMax(&nearest[plane * push.pixels + pixel], (u64(words.y) << 32u) | u64(words.x));
}
