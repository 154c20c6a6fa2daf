// scan/reduce where invocations share work: sums of runs of GROUP_RUN elements. One workgroup per run. A sum over 32
// bits sets the flag. First half of reduce-then-scan (Harris, Sengupta, Owens 2007), without forward progress between
// workgroups.
#import scan_run

@group(0) @binding(0) var<storage, read> values: array<u32>;
@group(0) @binding(1) var<storage, read_write> sums: array<u32>;
@group(0) @binding(2) var<storage, read_write> overflow: array<atomic<u32>>;

#main {
    let run = workgroup_index(workgroup, groups);
    if run * GROUP_RUN >= push.count {
        return;
    }
    var sum = 0u;
    for (var step = 0u; step < STEPS; step++) {
        sum = plus(sum, sum_of_four(run, step, local));
    }
    sum_rows(sum, local);
    if local == 0u {
        var all = 0u;
        for (var row = 0u; row < ROWS; row++) {
            all = plus(all, rows[row]);
        }
        sums[run] = all;
    }
    if carried {
        atomicOr(&overflow[0], 1u);
    }
}
