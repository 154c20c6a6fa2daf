// peel/nearest-id: among the fragments that are left at a pixel's smallest depth the one of the smallest index. Second of
// two passes. Reference: reference::peel::next.
#import peel
#import nearest
@group(0) @binding(7) var<storage, read_write> nearest: array<NearestAtomic>;

fn visit(i: u32, splat: Splat, tilt: Tilt, pixel: vec2<u32>) {
    let coverage = cover(splat, tilt, pixel, view);
    if !coverage.hit {
        return;
    }
    let p = window_index(pixel, view.window);
    let key = depth_key(coverage.depth);
    let id = push.first + i;
    if key == atomicLoad(&nearest[p].key) && is_left(p, key, id) {
        atomicMin(&nearest[p].id, id);
    }
}
#walker
