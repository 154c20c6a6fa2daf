// radix/scatter: moves each record to its place among those of its digit, in order (stable). One subgroup per run takes
// its records in order, one per invocation at a time. cursors are the prefix sums of the counts before; a run owns its
// own.
//
// The first invocation of each digit takes places for all of its equals, and they get them by a shuffle. Each step
// waits for the result of the step before, so that a run's records take their places in order without a barrier.
#import digit_rank
#import dispatch
@group(0) @binding(0) var<storage, read> records: array<vec2<u32>>;
@group(0) @binding(1) var<storage, read_write> cursors: array<atomic<u32>>;
#piece

@compute @workgroup_size(SUBGROUP)
fn main(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(subgroup_invocation_id) lane: u32,
) {
    let run = workgroup_index(workgroup, groups);
    let start = run * push.run_length;
    let end = min(start + push.run_length, push.count);
    for (var step = start; step < end; step += SUBGROUP) {
        let present = step + lane < end;
        let record = records[min(step + lane, end - 1u)];
        let digit = select(push.mask + 1u, digit_of(record.x), present);
        let equals = equals_of(digit, present, lane);
        var place = 0u;
        if present && equals.before == 0u {
            place = atomicAdd(&cursors[digit * push.runs + run], equals.all);
        }
        place = subgroupShuffle(place, equals.first & (SUBGROUP - 1u)) + equals.before;
        if present && place < arrayLength(&moved) {
            put(place, record);
        }
    }
}
