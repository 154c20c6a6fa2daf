// radix/count: how many records of each run have each digit. One workgroup per run. counts is zero before.
#import radix
#import dispatch
@group(0) @binding(0) var<storage, read> records: array<vec2<u32>>;
@group(0) @binding(1) var<storage, read_write> counts: array<atomic<u32>>;

#main {
    let run = workgroup_index(workgroup, groups);
    let end = min((run + 1u) * push.run_length, push.count);
    for (var i = run * push.run_length + local; i < end; i += WG_SIZE) {
        atomicAdd(&counts[digit_of(records[i].x) * push.runs + run], 1u);
    }
}
