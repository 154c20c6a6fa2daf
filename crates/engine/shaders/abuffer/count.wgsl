// abuffer/count: how many fragments each pixel gets (MCTB12). counts is zero before the first chunk.
// Reference: the lengths of reference::abuffer::lists.
#import raster
@group(0) @binding(8) var<storage, read_write> counts: array<atomic<u32>>;

fn visit(i: u32, splat: Splat, tilt: Tilt, pixel: vec2<u32>) {
    if cover(splat, tilt, pixel).hit {
        atomicAdd(&counts[window_index(pixel, view.window)], 1u);
    }
}
#walker
