// splat/nearest-id: among the splats at a pixel's smallest depth the one of the smallest index. Second of two passes.
#import raster
#import nearest
@group(0) @binding(6) var<storage, read_write> nearest: array<NearestAtomic>;

fn visit(i: u32, splat: Splat, tilt: Tilt, pixel: vec2<u32>) {
    let coverage = cover(splat, tilt, pixel, view);
    let p = window_index(pixel, view.window);
    if coverage.hit && depth_key(coverage.depth) == atomicLoad(&nearest[p].key) {
        atomicMin(&nearest[p].id, push.first + i);
    }
}
#walker
