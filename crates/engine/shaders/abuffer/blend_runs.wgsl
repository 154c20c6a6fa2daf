// abuffer/blend-runs: composes each run of a sorted long list by itself. One invocation per run.
#import compose
#import sorted_runs
@group(0) @binding(20) var<storage, read_write> partials: array<Partial>;

#main item {
    if item >= atomicLoad(&work.run_count) {
        return;
    }
    let run = runs[item];
    let pixel = pixel_of_run(run);
    let first = start_of_run(run);
    let last = end_of_run(run);
    var sum = Composed(vec4<f32>(0.0), NOTHING);
    for (var i = first; i < last; i++) {
        let fragment = fragments[i];
        sum = behind(sum, shown_key(fragment.x, fragment.y), fragment_color(fragment.y, pixel));
    }
    partials[item] = Partial(sum.rgba, vec4<u32>(sum.key, 0u, 0u, 0u));
}
