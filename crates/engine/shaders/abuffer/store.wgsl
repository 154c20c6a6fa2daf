// abuffer/store: puts each fragment into a slot of its pixel. Pixel p owns the slots offsets[p] .. offsets[p + 1], less
// the band's first; cursors, a copy of the offsets, hands them out. The order inside is arbitrary until the sort.
// Relies on abuffer/count visiting the same pixels. Reference: reference::abuffer::lists, after sorting.
#import raster
@group(0) @binding(8) var<storage, read_write> cursors: array<atomic<u32>>;
// Depth key and index of the splat: their order is the order of blending.
@group(0) @binding(9) var<storage, read_write> fragments: array<vec2<u32>>;

fn visit(i: u32, splat: Splat, tilt: Tilt, pixel: vec2<u32>) {
    let p = window_index(pixel, view.window);
    if p < push.band_start || p >= push.band_end {
        return;
    }
    let coverage = cover(splat, tilt, pixel);
    if !coverage.hit {
        return;
    }
    let slot = atomicAdd(&cursors[p], 1u) - push.first_fragment;
    // Both passes run the same test on the same numbers; should a driver ever disagree with itself, nothing is written
    // outside.
    if slot < arrayLength(&fragments) {
        fragments[slot] = vec2<u32>(depth_key(coverage.depth), push.first + i);
    }
}
#walker
