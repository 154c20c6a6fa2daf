// splat/nearest-depth: the smallest depth of each pixel, by atomic minimum of its key; all ones at the start. First of two
// passes where the device has no 64-bit atomics.
#import raster
#import nearest
@group(0) @binding(6) var<storage, read_write> nearest: array<NearestAtomic>;

fn visit(i: u32, splat: Splat, tilt: Tilt, pixel: vec2<u32>) {
    let coverage = cover(splat, tilt, pixel, view);
    if coverage.hit {
        atomicMin(&nearest[window_index(pixel, view.window)].key, depth_key(coverage.depth));
    }
}
#walker
