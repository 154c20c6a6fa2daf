// soft/samples: the samples of a deep EXR, of each run of a sorted list of events of concentric shells: the piece of
// the ray that each event begins. What is not there has the opacity NO_SAMPLE. One invocation per run.
// Reference: reference::soft.
#push
#import soft_terms
#import sample
#import run_sums
#import sorted_runs
@group(0) @binding(20) var<storage, read> sums: array<RunSums>;
@group(0) @binding(21) var<storage, read_write> sample_colors: array<vec4<f32>>;
// Where a sample begins and ends.
@group(0) @binding(22) var<storage, read_write> sample_depths: array<vec2<f32>>;
@group(0) @binding(23) var<storage, read> records: array<vec4<u32>>;

#main item {
    if item >= atomicLoad(&work.run_count) {
        return;
    }
    let run = runs[item];
    let pixel = pixel_of_run(run);
    let ray = ray_of(pixel);
    let start = start_of_run(run);
    let end = end_of_run(run);
    let final_event = run.start + run.length - 1u;
    // A list of one run has no sums.
    var open = no_sums();
    if run.run > 0u {
        let before = sums[item];
        open = Sums(before.high, before.low, before.rest.xy, before.rest.z);
    }
    var event = fragments[start];
    var terms = terms_of(event, pixel, ray);
    for (var i = start; i < end; i++) {
        let first = vec2<f32>(key_depth(event.x), terms.rest);
        open = after_event(open, terms, is_exit(event.y));
        event = fragments[min(i + 1u, final_event)];
        terms = terms_of(event, pixel, ray);
        let last = vec2<f32>(key_depth(event.x), terms.rest);
        let color = segment_color(open, segment_depth(open, first, last, ray));
        sample_colors[i] = sample_of(color, color.a > 0.0);
        let depth = first.x + depth_origin();
        sample_depths[i] = vec2<f32>(depth, max(last.x + depth_origin(), depth));
    }
}
