// abuffer/count for flat discs in order of depth: how many fragments each pixel gets (MCTB12).
// Reference: the lengths of reference::abuffer::lists.
#import tile_gather
@group(0) @binding(20) var<storage, read_write> counts: array<u32>;

fn begin(pixel: vec2<u32>) -> u32 {
    let p = band_pixel(pixel);
    return select(0u, counts[min(p, arrayLength(&counts) - 1u)], push.walk.segment > 0u);
}

fn visit(count: u32, hit: bool, index: u32) -> u32 {
    return count + select(0u, 1u, hit);
}

fn finish(count: u32, pixel: vec2<u32>) {
    let p = band_pixel(pixel);
    if p < arrayLength(&counts) {
        counts[p] = count;
    }
}
