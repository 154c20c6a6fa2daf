// moments/accumulate: color A ΣcαT / ΣαT, with the light T before each fragment as far as moments say (Münstermann et
// al. 2018), and the exact A. Reference: reference::moments.
#import splat
#import tile_state
#import region_fold
#import moment_light

@group(0) @binding(23) var<storage, read> known: array<vec2<f32>>;
#push

var<private> state: State;

fn begin(pixel: vec2<u32>) {
    state = empty_state();
    if all(pixel < view.window.zw) {
        let p = window_index(pixel, view.window);
        learn(p);
        if is_later() {
            state = kept_state(p);
        }
    }
}

fn visit(pixel: vec2<u32>, f: Fragment) {
    if f.color.a > 0.0 {
        state.sum = plus(state.sum, (f.color.a * light_before(f)) * vec4<f32>(f.color.rgb, 1.0));
        state.coverage = covered(state.coverage, f.color.a);
        state = nearer(state, f);
    }
}

fn finish(pixel: vec2<u32>) {
    if all(pixel < view.window.zw) {
        leave(window_index(pixel, view.window), state, state.coverage.x * vec4<f32>(mean(state.sum), 1.0));
    }
}
