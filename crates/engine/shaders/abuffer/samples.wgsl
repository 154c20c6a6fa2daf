// abuffer/samples: the samples of a deep EXR, of each run of a sorted list: color times opacity, and depth. One
// invocation per run.
#import compose
#import sample
#import sorted_runs
@group(0) @binding(20) var<storage, read_write> sample_colors: array<vec4<f32>>;
// Where a sample begins and ends.
@group(0) @binding(21) var<storage, read_write> sample_depths: array<vec2<f32>>;

#main item {
    if item >= atomicLoad(&work.run_count) {
        return;
    }
    let run = runs[item];
    let pixel = pixel_of_run(run);
    let first = start_of_run(run);
    let last = end_of_run(run);
    for (var i = first; i < last; i++) {
        let fragment = fragments[i];
        let color = fragment_color(fragment.y, pixel);
        sample_colors[i] = sample_of(color, true);
        sample_depths[i] = vec2<f32>(key_depth(shown_key(fragment.x, fragment.y)));
    }
}
