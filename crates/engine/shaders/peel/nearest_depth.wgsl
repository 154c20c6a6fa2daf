// peel/nearest-depth: the smallest depth key of each pixel among the fragments that are left; all ones at the start. First
// of two passes where the device has no 64-bit atomics. Reference: reference::peel::next.
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
    if is_left(p, key, push.first + i) {
        atomicMin(&nearest[p].key, key);
    }
}
#walker
