// hybrid/weigh: the tail behind the front that hybrid/accumulate left, its color weighted by the light before each of
// its fragments as far as moments say. Reference: reference::approximate::hybrid.
#import splat
#import tile_state
#import region_fold
#import tail
#import moment_light

@group(0) @binding(23) var<storage, read> lasts: array<vec2<u32>>;
@group(0) @binding(24) var<storage, read> known: array<vec2<f32>>;
#push

var<private> state: State;

fn begin(pixel: vec2<u32>) {
    state = empty_state();
    front_end = NO_RANK;
    if all(pixel < view.window.zw) {
        let p = window_index(pixel, view.window);
        front_end = lasts[p];
        learn(p);
        if is_later() {
            state = kept_state(p);
        } else {
            state = behind_front(p);
        }
    }
}

fn visit(pixel: vec2<u32>, f: Fragment) {
    if is_in_tail(f) {
        state.sum = plus(state.sum, (f.color.a * light_before(f)) * vec4<f32>(f.color.rgb, 1.0));
        state.coverage = covered(state.coverage, f.color.a);
    }
}

fn finish(pixel: vec2<u32>) {
    if all(pixel < view.window.zw) {
        let tail = state.coverage.x * vec4<f32>(mean(state.sum), 1.0);
        leave(window_index(pixel, view.window), state, state.front + (1.0 - state.front.a) * tail);
    }
}
