// peel/nearest: the smallest rank of each pixel among the fragments that are left, by one 64-bit atomic minimum; all ones
// at the start. Reference: reference::peel::next.
#import peel
@group(0) @binding(7) var<storage, read_write> nearest: array<atomic<u64>>;

fn visit(i: u32, splat: Splat, tilt: Tilt, pixel: vec2<u32>) {
    let coverage = cover(splat, tilt, pixel, view);
    if !coverage.hit {
        return;
    }
    let p = window_index(pixel, view.window);
    let key = depth_key(coverage.depth);
    let id = push.first + i;
    if is_left(p, key, id) {
        atomicMin(&nearest[p], (u64(key) << 32u) | u64(id));
    }
}
#walker
