// Each pixel's fragments into one state: the stage defines add(state, fragment), which a fragment that misses the pixel
// must leave as it is, and result(state), premultiplied color and A. It says of its push constants what
// shared/tile_fold wants.
#import tile_state
#import tile_fold

alias PixelState = State;

fn begin(pixel: vec2<u32>) -> PixelState {
    if is_later() && all(pixel < view.window.zw) {
        return kept_state(window_index(pixel, view.window));
    }
    return empty_state();
}

fn visit(before: PixelState, fragment: Fragment) -> PixelState {
    return nearer(add(before, fragment), fragment);
}

fn finish(state: PixelState, pixel: vec2<u32>) {
    if all(pixel < view.window.zw) {
        leave(window_index(pixel, view.window), state, result(state));
    }
}
