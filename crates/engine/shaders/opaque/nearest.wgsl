// opaque/nearest, opaque/nearest-depth, opaque/nearest-id: depth and index of each pixel's nearest splat.
#import raster
#piece

const NEAREST_BINDING = 8;

fn visit(i: u32, splat: Splat, tilt: Tilt, pixel: vec2<u32>) {
    let coverage = cover(splat, tilt, pixel);
    if coverage.hit {
        offer(window_index(pixel, view.window), depth_key(coverage.depth), push.first + i);
    }
}
#walker
