// moments/accumulate: color A ΣcαT / ΣαT, with the light T before each fragment as far as moments say (Münstermann et al. 2018), and the
// exact A. Reference: reference::moments.
#import splat
#import twofloat
#import tile_state
#import region_fold
#import fade
#import moment
#import canonical

@group(0) @binding(23) var<storage, read> known: array<vec2<f32>>;

var<private> state: State;
// Optical depth of the pixel, and the share of it before its nearest fragment.
var<private> total: f32;
var<private> least: f32;

// E[xᵏ], from the first on, of the distribution toward which moments are moved: its odd ones are 0.
fn toward(k: u32) -> f32 {
    if MOMENTS == 4u {
        return 0.375;
    }
    if MOMENTS == 6u {
        return select(select(0.45, 0.451, k == 4u), 0.48, k == 2u);
    }
    return select(select(select(0.600303, 0.63, k == 6u), 0.676667, k == 4u), 0.75, k == 2u);
}

// What the moments of a pixel say, but for fragments.
fn learn(p: u32) {
    let first = p * STRIDE;
    let sum = known[first];
    // Nothing asks about a pixel without fragments.
    let whole = select(ONE, sum, sum.x > 0.0);
    moments[0] = ONE;
    let rest = add2(ONE, vec2<f32>(-push.bias, 0.0));
    for (var k = 1u; k <= MOMENTS; k++) {
        let own = multiply2(rest, divide2(known[first + k], whole));
        moments[k] = add2(own, vec2<f32>(select(push.bias * toward(k), 0.0, k % 2u == 1u), 0.0));
    }
    orthogonalise();
    total = whole.x;
    least = share_before(known[first + MOMENTS + 1u].x);
}

// The share of the optical depth before a place, between its bounds.
fn share_before(place: f32) -> f32 {
    let bounds = bounds_at(place);
    return clamp(bounds.x + push.overestimation * bounds.y, 0.0, 1.0);
}

fn begin(pixel: vec2<u32>) {
    state = empty_state();
    if all(pixel < view.window.zw) {
        let p = window_index(pixel, view.window);
        learn(p);
        if LATER != 0u {
            state = kept_state(p);
        }
    }
}

fn visit(pixel: vec2<u32>, f: Fragment) {
    if f.color.a > 0.0 {
        // Light over that before the nearest fragment: only its differences count, and none of it is too little for a float.
        let light = exponential(min(total * (least - share_before(place_of(f))), 0.0));
        state.sum = plus(state.sum, (f.color.a * light) * vec4<f32>(f.color.rgb, 1.0));
        state.coverage = covered(state.coverage, f.color.a);
        state = nearer(state, f);
    }
}

fn finish(pixel: vec2<u32>) {
    if all(pixel < view.window.zw) {
        leave(window_index(pixel, view.window), state, state.coverage.x * vec4<f32>(mean(state.sum), 1.0));
    }
}
