// abuffer/store for flat discs in order of depth: each pixel's slots are filled in the order of blending. cursors, a copy of
// the offsets, say where each pixel's next slot is.
// Relies on abuffer/count visiting the same pixels. Reference: reference::abuffer::lists, sorted.
#import tile_gather
@group(0) @binding(5) var<storage, read_write> cursors: array<u32>;
// Depth key and index of the splat.
@group(0) @binding(6) var<storage, read_write> fragments: array<vec2<u32>>;

// The next slot of a pixel, NOTHING outside the band.
#each held var<private> slot{held}: u32;

fn begin(i: u32, pixel: vec2<u32>) {
    let p = band_pixel(pixel);
    let first = cursors[min(p, arrayLength(&cursors) - 1u)] - push.first_fragment;
#each held     if i == {held}u { slot{held} = select(first, 0xffffffffu, p == 0xffffffffu); }
}

fn visit(i: u32, hit: bool, key: u32, splat: u32) {
    // Both passes run the same test on the same numbers; should a driver ever disagree with itself, nothing is written outside.
#each held     if i == {held}u && hit && slot{held} < arrayLength(&fragments) { fragments[slot{held}] = vec2<u32>(key, splat); slot{held} += 1u; }
}

fn end_pixel(i: u32, pixel: vec2<u32>) {
    let p = band_pixel(pixel);
#each held     if i == {held}u && p < arrayLength(&cursors) { cursors[p] = slot{held} + push.first_fragment; }
}
