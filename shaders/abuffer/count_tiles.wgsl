// abuffer/count for flat discs in order of depth: how many fragments each pixel gets (MCTB12).
// Reference: the lengths of reference::abuffer::lists.
#import tile_gather
@group(0) @binding(4) var<storage, read_write> counts: array<u32>;

#each held var<private> count{held}: u32;

fn begin(i: u32, pixel: vec2<u32>) {
    let p = band_pixel(pixel);
    let before = select(0u, counts[min(p, arrayLength(&counts) - 1u)], push.segment > 0u);
#each held     if i == {held}u { count{held} = before; }
}

fn visit(i: u32, hit: bool, rank: u32) {
#each held     if i == {held}u { count{held} += select(0u, 1u, hit); }
}

fn end_pixel(i: u32, pixel: vec2<u32>) {
    let p = band_pixel(pixel);
#each held     if i == {held}u && p < arrayLength(&counts) { counts[p] = count{held}; }
}
