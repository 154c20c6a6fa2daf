// scan/spread where invocations share work: exclusive prefix sums of each run of GROUP_RUN elements, begun at the run's
// own offset. One workgroup per run. Second half of reduce-then-scan; at the top level there is one run, and it begins
// at zero.
#import scan_run

@group(0) @binding(0) var<storage, read> values: array<u32>;
@group(0) @binding(1) var<storage, read> starts: array<u32>;
@group(0) @binding(2) var<storage, read_write> offsets: array<u32>;
@group(0) @binding(3) var<storage, read_write> overflow: array<atomic<u32>>;
override TOP: u32 = 0u;

// Sums of four elements, and then where each of them begins, step by step.
var<workgroup> fours: array<u32, FOURS>;

fn put(i: u32, offset: u32) {
    if i < push.count {
        offsets[i] = offset;
    }
}

#main {
    let run = workgroup_index(workgroup, groups);
    if run * GROUP_RUN >= push.count {
        return;
    }
    for (var step = 0u; step < STEPS; step++) {
        fours[step * WG_SIZE + local] = sum_of_four(run, step, local);
    }
    workgroupBarrier();
    // Each invocation takes as many of them in a row as there are steps.
    var own = 0u;
    for (var i = 0u; i < STEPS; i++) {
        own = plus(own, fours[local * STEPS + i]);
    }
    sum_rows(own, local);
    var start = lanes[local];
    if TOP == 0u {
        start = plus(start, starts[run]);
    }
    for (var row = 0u; row < local / ROW; row++) {
        start = plus(start, rows[row]);
    }
    for (var i = 0u; i < STEPS; i++) {
        let four = fours[local * STEPS + i];
        fours[local * STEPS + i] = start;
        start = plus(start, four);
    }
    workgroupBarrier();
    for (var step = 0u; step < STEPS; step++) {
        let first = first_of_four(run, step, local);
        let offset = fours[step * WG_SIZE + local];
        let second = offset + value_at(first);
        let third = second + value_at(first + 1u);
        put(first, offset);
        put(first + 1u, second);
        put(first + 2u, third);
        put(first + 3u, third + value_at(first + 2u));
    }
    if carried {
        atomicOr(&overflow[0], 1u);
    }
}
