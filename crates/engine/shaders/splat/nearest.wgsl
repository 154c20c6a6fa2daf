// splat/nearest: depth and index of each pixel's nearest splat by one 64-bit atomic minimum; all ones at the start.
#import raster
@group(0) @binding(6) var<storage, read_write> nearest: array<atomic<u64>>;

fn visit(i: u32, splat: Splat, tilt: Tilt, pixel: vec2<u32>) {
    let coverage = cover(splat, tilt, pixel, view);
    if coverage.hit {
        let packed = (u64(depth_key(coverage.depth)) << 32u) | u64(push.first + i);
        atomicMin(&nearest[window_index(pixel, view.window)], packed);
    }
}
#walker
