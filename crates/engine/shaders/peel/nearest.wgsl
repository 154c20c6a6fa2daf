// peel/nearest, peel/nearest-depth, peel/nearest-id: the smallest ranks of each pixel among the fragments that are
// left, as many as it has slots.
// Reference: reference::peel::next.
#import peel
#piece

const NEAREST_BINDING = 8;

fn visit(i: u32, splat: Splat, tilt: Tilt, pixel: vec2<u32>) {
    let coverage = cover(splat, tilt, pixel);
    if !coverage.hit {
        return;
    }
    let p = window_index(pixel, view.window);
    let key = depth_key(coverage.depth);
    let id = push.first + i;
    if is_left(p, key, id) {
        offer(p, key, id);
    }
}
#walker
