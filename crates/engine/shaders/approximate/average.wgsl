// average/accumulate: the mean color of all fragments, whatever their opacity; opaque where there is any (the naive
// picture of Tanaka et al. 2016, Fig. 6). Reference: reference::approximate::average.
#import splat
#import accumulate

#push

fn add(before: State, f: Fragment) -> State {
    var state = before;
    state.sum = plus(before.sum, select(0.0, 1.0, f.hit) * vec4<f32>(f.color.rgb, 1.0));
    return state;
}

fn result(state: State) -> vec4<f32> {
    return vec4<f32>(mean(state.sum), select(0.0, 1.0, state.sum.total.w > 0.0));
}
