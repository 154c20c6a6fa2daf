// abuffer/store for flat discs in order of depth: each pixel's slots take the indices of its splats in the order of
// blending. cursors, a copy of the offsets, say where each pixel's next slot is.
// Relies on abuffer/count visiting the same pixels. Reference: reference::abuffer::lists, sorted.
#import tile_gather
@group(0) @binding(20) var<storage, read_write> cursors: array<u32>;
@group(0) @binding(21) var<storage, read_write> indices: array<u32>;

// The next slot of a pixel, NOTHING outside the band.
fn begin(pixel: vec2<u32>) -> u32 {
    let p = band_pixel(pixel);
    let first = cursors[min(p, arrayLength(&cursors) - 1u)] - push.first_fragment;
    return select(first, 0xffffffffu, p == 0xffffffffu);
}

fn visit(slot: u32, hit: bool, index: u32) -> u32 {
    // Both passes run the same test on the same numbers; should a driver ever disagree with itself, nothing is written
    // outside.
    if hit && slot < arrayLength(&indices) {
        indices[slot] = index;
        return slot + 1u;
    }
    return slot;
}

fn finish(slot: u32, pixel: vec2<u32>) {
    let p = band_pixel(pixel);
    if p < arrayLength(&cursors) {
        cursors[p] = slot + push.first_fragment;
    }
}
