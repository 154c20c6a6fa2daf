// soft/sum-runs: the sums that the events of each run of a sorted long list add to the running ones. One invocation per
// run.
#push
#import soft_terms
#import run_sums
#import sorted_runs
@group(0) @binding(20) var<storage, read_write> sums: array<RunSums>;
@group(0) @binding(21) var<storage, read> records: array<vec4<u32>>;

#main item {
    if item >= atomicLoad(&work.run_count) {
        return;
    }
    let run = runs[item];
    let pixel = pixel_of_run(run);
    let ray = ray_of(pixel);
    let first = start_of_run(run);
    let last = end_of_run(run);
    var found = no_sums();
    for (var i = first; i < last; i++) {
        let event = fragments[i];
        found = plus_terms(found, terms_of(event, pixel, ray), select(1.0, -1.0, is_exit(event.y)));
    }
    sums[item] = RunSums(found.high, found.low, vec4<f32>(found.density, found.open, 0.0));
}
