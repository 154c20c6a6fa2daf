// abuffer/sort-runs where invocations share work: sorts each run of a long list by itself. One workgroup per run.
#import long_list
#import group_sort
#import dispatch

@group(0) @binding(0) var<storage, read_write> work: LongWork;
@group(0) @binding(1) var<storage, read> runs: array<ListRun>;
@group(0) @binding(2) var<storage, read_write> fragments: array<vec2<u32>>;

#main {
    let item = workgroup_index(workgroup, groups);
    if local == 0u {
        range = vec2<u32>(0u);
        if item < atomicLoad(&work.run_count) {
            let run = runs[item];
            range = vec2<u32>(run.start + run.run * RUN_LENGTH, min(RUN_LENGTH, run.length - run.run * RUN_LENGTH));
        }
    }
    sort_range(local);
}
