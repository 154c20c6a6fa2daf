// weighted/accumulate: color Σwαc / Σwα with weights w that fall with depth, A = 1 - ∏(1 - α) (McGuire, Bavoil 2013,
// Eq. 10). Reference: reference::approximate::weighted.
#import splat
#import accumulate

#push

fn add(before: State, f: Fragment) -> State {
    var state = before;
    // 1 - d, where d goes from 0 at near to 1 at far.
    let range = view.depth_range;
    let to_far = clamp((range.y - key_depth(f.shown_key)) / (range.y - range.x), 0.0, 1.0);
    let weight = max(1e-2, 3e3 * (to_far * to_far * to_far)) * f.color.a;
    state.sum = plus(before.sum, weight * vec4<f32>(f.color.rgb, 1.0));
    state.coverage = covered(before.coverage, f.color.a);
    return state;
}

fn result(state: State) -> vec4<f32> {
    return state.coverage.x * vec4<f32>(mean(state.sum), 1.0);
}
