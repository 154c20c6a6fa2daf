// ellipsoids/blend-runs: composes the events of each run of a sorted list, and the segments that they begin, with the
// sums over what is open that the runs before have left. One invocation per run.
// Reference: reference::gaussians::ellipsoid.
#import ellipsoid_events
#import sorted_runs
@group(0) @binding(20) var<storage, read> sums: array<RunSums>;
@group(0) @binding(21) var<storage, read_write> partials: array<Partial>;

#main item {
    if item >= atomicLoad(&work.run_count) {
        return;
    }
    let run = runs[item];
    let pixel = pixel_of_run(run);
    let ray = ray_of(pixel);
    var sum = Composed(vec4<f32>(0.0), NOTHING);
    let start = start_of_run(run);
    let end = end_of_run(run);
    let final_event = run.start + run.length - 1u;
    var walk = Walk(open_before(sums[item], run.run), event_at(fragments[start], pixel, ray));
    for (var i = start; i < end; i++) {
        let fragment = fragments[i];
        let step = step_on(&walk, fragment, fragments[min(i + 1u, final_event)], pixel, ray);
        let depth = key_depth(fragment.x) + depth_origin();
        sum = behind(sum, depth_key(depth), step.surface);
        sum = behind(sum, depth_key(depth + shown_place(step.segment)), step.segment.color);
    }
    partials[item] = Partial(sum.rgba, vec4<u32>(sum.key, 0u, 0u, 0u));
}

// How far behind its beginning a segment shows: nothing, or, for the mean, where light ends in it on average,
// length (1 / x - 1 / (exp(x) - 1)) for its optical depth x.
fn shown_place(segment: Segment) -> f32 {
    if SHOWN != SHOWN_MEAN {
        return 0.0;
    }
    let x = segment.depth;
    let a = segment.color.a;
    return segment.length * select(1.0 / x - (1.0 - a) / a, 0.5 - x / 12.0, x < 0.05);
}
