// abuffer/sort-runs: sorts each run of a long list by itself. One invocation per run, in a local array.
#import long_list
#import local_sort
#import dispatch

@group(0) @binding(0) var<storage, read_write> work: LongWork;
@group(0) @binding(1) var<storage, read> runs: array<ListRun>;
@group(0) @binding(2) var<storage, read_write> fragments: array<vec2<u32>>;

#main item {
    if item >= atomicLoad(&work.run_count) {
        return;
    }
    let run = runs[item];
    let start = run.start + run.run * RUN_LENGTH;
    let n = min(RUN_LENGTH, run.length - run.run * RUN_LENGTH);
    var list: array<vec2<u32>, 2u * CAPACITY>;
    for (var i = 0u; i < n; i++) {
        list[i] = fragments[start + i];
    }
    var place = sort_local(&list, n);
    for (var i = 0u; i < n; i++) {
        fragments[start + i] = taken(&list, &place);
    }
}
