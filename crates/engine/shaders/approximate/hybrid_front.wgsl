// hybrid/accumulate for flat discs, which come in order of depth, before a tail by moments: the first k fragments
// composed exactly, but for those that are too faint, and the rank of the last of them. Reference:
// reference::approximate::hybrid.
#import splat
#import tile_state
#import rank
#import tile_fold

// Rank of the last fragment that is composed; the least if none is.
@group(0) @binding(23) var<storage, read_write> lasts: array<vec2<u32>>;
#push

struct PixelState {
    state: State,
    last: Rank,
}

fn begin(pixel: vec2<u32>) -> PixelState {
    if is_later() && all(pixel < view.window.zw) {
        let p = window_index(pixel, view.window);
        return PixelState(kept_state(p), lasts[p]);
    }
    return PixelState(empty_state(), Rank(0u, 0u));
}

fn visit(held: PixelState, f: Fragment) -> PixelState {
    var state = held.state;
    let exact = f.hit && state.count < f32(push.k) && f.color.a >= push.core_alpha_min;
    state.front += (1.0 - state.front.a) * select(0.0, f.color.a, exact) * vec4<f32>(f.color.rgb, 1.0);
    // Up to k, which a float counts exactly.
    state.count += select(0.0, 1.0, exact);
    return PixelState(nearer(state, f), select(held.last, rank_of(f), exact));
}

fn finish(held: PixelState, pixel: vec2<u32>) {
    if all(pixel < view.window.zw) {
        let p = window_index(pixel, view.window);
        lasts[p] = held.last;
        leave(p, held.state, held.state.front);
    }
}
