// State of a pixel while an approximation goes through its tile's splats, and how the pixel comes out. The members that
// a stage does not use cost nothing.
#import sums
#import over
@group(0) @binding(20) var<storage, read_write> image: array<vec4<f32>>;
@group(0) @binding(21) var<storage, read_write> depths: array<f32>;
// State that a run leaves to the next: four vectors for each pixel.
@group(0) @binding(22) var<storage, read_write> kept: array<vec4<f32>>;

struct State {
    // Color times weight, and weight.
    sum: Sum,
    // 1 - ∏(1 - α), and by how much it is too large.
    coverage: vec2<f32>,
    // Color of the fragments composed in order, premultiplied, and their number.
    front: vec4<f32>,
    count: f32,
    // Depth key of the nearest fragment with opacity, and, where splats may be Gaussians, that of the depth that it
    // shows.
    key: u32,
    shown: u32,
}

fn empty_state() -> State {
    return State(Sum(vec4<f32>(0.0), vec4<f32>(0.0)), vec2<f32>(0.0), vec4<f32>(0.0), 0.0, NOTHING, NOTHING);
}

fn kept_state(p: u32) -> State {
    let rest = kept[4u * p + 3u];
    let sum = Sum(kept[4u * p], kept[4u * p + 1u]);
    return State(sum, rest.xy, kept[4u * p + 2u], rest.z, bitcast<u32>(rest.w), depth_key(depths[p]));
}

// Initial state behind the front that other stages left in the image.
fn behind_front(p: u32) -> State {
    var state = empty_state();
    state.front = image[p];
    state.key = depth_key(depths[p]);
    state.shown = state.key;
    if has_gaussians() && depths[p] <= 3.4e38 {
        // Nothing behind is nearer, whatever depth shows.
        state.key = 0u;
    }
    return state;
}

// The pixel as it is if nothing comes after this run, and what the next one goes on from.
fn leave(p: u32, state: State, rgba: vec4<f32>) {
    image[p] = rgba;
    depths[p] = composed_depth(select(state.key, state.shown, has_gaussians()));
    if is_one_of_several() {
        kept[4u * p] = state.sum.total;
        kept[4u * p + 1u] = state.sum.excess;
        kept[4u * p + 2u] = state.front;
        kept[4u * p + 3u] = vec4<f32>(state.coverage, state.count, bitcast<f32>(state.key));
    }
}

// The state with a fragment's depth, if that is nearer.
fn nearer(before: State, f: Fragment) -> State {
    var state = before;
    let key = select(NOTHING, f.depth_key, f.color.a > 0.0);
    if has_gaussians() {
        state.shown = select(before.shown, f.shown_key, key < before.key);
    }
    state.key = min(before.key, key);
    return state;
}

// Color times weight over weight, black without weight.
fn mean(sum: Sum) -> vec3<f32> {
    return select(vec3<f32>(0.0), sum.total.rgb / sum.total.w, sum.total.w > 0.0);
}
