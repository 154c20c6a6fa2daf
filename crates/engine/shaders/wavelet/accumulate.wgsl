// wavelet/accumulate: color A ΣcαT / ΣαT, with the light T before each fragment as far as wavelets say (Aizenshtein et
// al. 2022), and the exact A. Reference: reference::wavelet.
#import splat
#import tile_state
#import region_fold
#import fade
#import cell

@group(0) @binding(23) var<storage, read> ranges: array<vec2<f32>>;
@group(0) @binding(24) var<storage, read> cells: array<vec2<f32>>;

var<private> state: State;
var<private> range: Range;
// Mean optical depth over each cell.
var<private> means: array<f32, CELLS>;

fn learn(p: u32) {
    range = range_of(ranges[p]);
    var sum = vec2<f32>(0.0);
    for (var k = 0u; k < CELLS; k++) {
        let cell = cells[p * CELLS + k];
        let wanted = (cell.x - cell.y) - sum.y;
        let total = sum.x + wanted;
        sum = vec2<f32>(total, (total - sum.x) - wanted);
        means[k] = total;
    }
}

// The optical depth before a place, linear between cells.
fn depth_before(place: f32) -> f32 {
    let cell = min(u32(place), CELLS - 1u);
    let last = select(0.0, means[max(cell, 1u) - 1u], cell > 0u);
    return last + (place - f32(cell)) * (means[cell] - last);
}

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
        // No light is lost before the nearest fragment.
        let light = exponential(-depth_before(place_in(range, f)));
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
