// hybrid/accumulate for flat discs, which come in order of depth: the first k fragments composed exactly, and behind
// them a tail of color Σαc / Σα and coverage 1 - ∏(1 - α) (MCTB13). Fragments that are too faint for the first k belong
// to the tail, too (HTGS, Hahlbohm et al. 2025). Reference: reference::approximate::hybrid.
#import splat
#import accumulate

#push

fn add(before: State, f: Fragment) -> State {
    var state = before;
    let exact = before.count < f32(push.k) && f.color.a >= push.core_alpha_min;
    let in_front = select(0.0, f.color.a, exact);
    let in_tail = select(f.color.a, 0.0, exact);
    state.front += (1.0 - before.front.a) * in_front * vec4<f32>(f.color.rgb, 1.0);
    state.sum = plus(before.sum, in_tail * vec4<f32>(f.color.rgb, 1.0));
    state.coverage = covered(before.coverage, in_tail);
    // Up to k, which a float counts exactly.
    state.count += select(0.0, 1.0, f.hit && exact);
    return state;
}

fn result(state: State) -> vec4<f32> {
    let tail = state.coverage.x * vec4<f32>(mean(state.sum), 1.0);
    return state.front + (1.0 - state.front.a) * tail;
}
