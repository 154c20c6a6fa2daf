// ellipsoids/sum-runs: what the events of each run of a sorted list add to the sums over what is open. One invocation
// per run. A list of one run has no use for its sum.
#import ellipsoid_events
#import sorted_runs
@group(0) @binding(20) var<storage, read_write> sums: array<RunSums>;

#main item {
    if item >= atomicLoad(&work.run_count) {
        return;
    }
    let run = runs[item];
    if run.length <= RUN_LENGTH {
        return;
    }
    let pixel = pixel_of_run(run);
    let ray = ray_of(pixel);
    let first = start_of_run(run);
    let last = end_of_run(run);
    var found = no_sums();
    for (var i = first; i < last; i++) {
        let event = event_at(fragments[i], pixel, ray);
        if !event.surface {
            found = plus_terms(found, terms_of(event), select(1.0, -1.0, is_exit(fragments[i].y)));
        }
    }
    sums[item] = RunSums(found.high, found.low, vec4<f32>(found.density, found.open, 0.0));
}
