// Each pixel's fragments into one state: the stage defines add(state, fragment), which a fragment that misses the pixel must
// leave as it is, and result(state), premultiplied color and A. It says of its push constants what shared/tile_fold wants.
#import tile_state

#each held var<private> state{held}: State;

fn begin(i: u32, pixel: vec2<u32>) {
    var state = empty_state();
    if LATER != 0u && all(pixel < view.window.zw) {
        state = kept_state(window_index(pixel, view.window));
    }
#each held     if i == {held}u { state{held} = state; }
}

fn visit(i: u32, pixel: vec2<u32>, fragment: Fragment) {
    var state: State;
#each held     if i == {held}u { state = state{held}; }
    state = add(state, fragment);
    state.key = nearer(state.key, fragment);
#each held     if i == {held}u { state{held} = state; }
}

fn finish(i: u32, pixel: vec2<u32>) {
    var state: State;
#each held     if i == {held}u { state = state{held}; }
    if all(pixel < view.window.zw) {
        leave(window_index(pixel, view.window), state, result(state));
    }
}
