// soft/blend-runs: composes the segments that the events of each run of a sorted long list begin, with the running sums
// that the runs before have left. One invocation per run.
#push
#import soft_terms
#import run_sums
#import sorted_runs
@group(0) @binding(20) var<storage, read> sums: array<RunSums>;
@group(0) @binding(21) var<storage, read> segments: array<f32>;
@group(0) @binding(22) var<storage, read_write> partials: array<Partial>;
@group(0) @binding(23) var<storage, read> records: array<vec4<u32>>;

#main item {
    if item >= atomicLoad(&work.run_count) {
        return;
    }
    let run = runs[item];
    let pixel = pixel_of_run(run);
    let ray = ray_of(pixel);
    let before = sums[item];
    var open = Sums(before.high, before.low, before.rest.xy, before.rest.z);
    var sum = Composed(vec4<f32>(0.0), NOTHING);
    let start = start_of_run(run);
    let end = end_of_run(run);
    let final_event = run.start + run.length - 1u;
    for (var i = start; i < end; i++) {
        let event = fragments[i];
        open = after_event(open, terms_of(event, pixel, ray), is_exit(event.y));
        var depth = 0.0;
        if MODEL == MODEL_BASE {
            depth = segments[i];
            if PACKED != 0u {
                depth = f32(bitcast<u32>(depth)) * DEPTH_UNIT;
            }
        } else {
            let next = fragments[min(i + 1u, final_event)].x;
            depth = segment_depth(open, vec2<f32>(key_depth(event.x), 0.0), vec2<f32>(key_depth(next), 0.0), ray);
        }
        sum = behind(sum, event.x, segment_color(open, depth));
    }
    let key = select(depth_key(key_depth(sum.key) + depth_origin()), NOTHING, sum.key == NOTHING);
    partials[item] = Partial(sum.rgba, vec4<u32>(key, 0u, 0u, 0u));
}
