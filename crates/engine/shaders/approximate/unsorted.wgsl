// unsorted/accumulate: fragments over one another in the order of the files, whatever their depth. The splats come last
// first, so that what comes lies behind what is there. Reference: reference::approximate::unsorted.
#import splat
#import accumulate

#push

// The sum is that of premultiplied color and A.
fn add(before: State, f: Fragment) -> State {
    var state = before;
    let through = (1.0 - before.sum.total.a) + before.sum.excess.a;
    state.sum = plus(before.sum, f.color.a * through * vec4<f32>(f.color.rgb, 1.0));
    return state;
}

fn result(state: State) -> vec4<f32> {
    return state.sum.total;
}
