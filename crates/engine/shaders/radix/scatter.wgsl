// radix/scatter: moves each record to its place among those of its digit, in order (stable). One subgroup per run takes
// its records in order, one per invocation at a time. cursors are the prefix sums of the counts before; a run owns its
// own.
//
// The first invocation of each digit takes places for all of its equals, and they get them by a shuffle. Each step
// waits for the result of the step before, so that a run's records take their places in order without a barrier. Who
// has an equal digit a small subgroup finds by a shuffle for each invocation, a large one by a ballot for each bit.
#import radix
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
        // Invocations beyond the end have a digit of their own.
        let digit = select(push.mask + 1u, digit_of(record.x), present);
        var equal_before = 0u;
        var equals = 0u;
        var first = SUBGROUP;
        if SUBGROUP >= MOST_SHUFFLED {
            var equal = subgroupBallot(present).x;
            for (var bits = push.mask; bits != 0u; bits &= bits - 1u) {
                let bit = bits & (~bits + 1u);
                let holders = subgroupBallot((digit & bit) != 0u).x;
                equal &= select(~holders, holders, (digit & bit) != 0u);
            }
            equals = countOneBits(equal);
            equal_before = countOneBits(equal & ((1u << lane) - 1u));
            first = firstTrailingBit(equal);
        } else {
#repeat             let other{i} = subgroupShuffle(digit, {i}u);
#repeat             equals += select(0u, 1u, other{i} == digit);
#repeat             equal_before += select(0u, 1u, other{i} == digit && {i}u < lane);
#repeat             first = select(first, min(first, {i}u), other{i} == digit);
        }
        var place = 0u;
        if present && equal_before == 0u {
            place = atomicAdd(&cursors[digit * push.runs + run], equals);
        }
        place = subgroupShuffle(place, first & (SUBGROUP - 1u)) + equal_before;
        if present && place < arrayLength(&moved) {
            put(place, record);
        }
    }
}
