// radix/count where invocations share work: how many records of each run have each digit, counted in the memory of the
// run's workgroup first, so that no two of its records wait for one another at a counter in the device's.
#import radix
#import dispatch
@group(0) @binding(0) var<storage, read> records: array<vec2<u32>>;
@group(0) @binding(1) var<storage, read_write> counts: array<u32>;

var<workgroup> found: array<atomic<u32>, DIGIT_VALUES>;

#main {
    let run = workgroup_index(workgroup, groups);
    for (var digit = local; digit <= push.mask; digit += WG_SIZE) {
        atomicStore(&found[digit], 0u);
    }
    workgroupBarrier();
    let end = min((run + 1u) * push.run_length, push.count);
    for (var i = run * push.run_length + local; i < end; i += WG_SIZE) {
        atomicAdd(&found[digit_of(records[i].x)], 1u);
    }
    workgroupBarrier();
    if run < push.runs {
        for (var digit = local; digit <= push.mask; digit += WG_SIZE) {
            counts[digit * push.runs + run] = atomicLoad(&found[digit]);
        }
    }
}
