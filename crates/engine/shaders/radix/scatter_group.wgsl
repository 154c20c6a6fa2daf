// radix/scatter where invocations share work: the same with TEAM subgroups in a workgroup, each with a run of
// its own. The places of a run's digits stay in the workgroup's memory meanwhile, so that no step waits for the
// device's.
#import digit_rank
#import dispatch
@group(0) @binding(0) var<storage, read> records: array<vec2<u32>>;
@group(0) @binding(1) var<storage, read_write> cursors: array<u32>;
#piece

var<workgroup> places: array<atomic<u32>, TEAM * DIGIT_VALUES>;

@compute @workgroup_size(SUBGROUP * TEAM)
fn main(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(subgroup_id) member: u32,
    @builtin(subgroup_invocation_id) lane: u32,
) {
    let run = workgroup_index(workgroup, groups) * TEAM + member;
    let own = member * DIGIT_VALUES;
    let start = min(run * push.run_length, push.count);
    let end = min(start + push.run_length, push.count);
    if run < push.runs {
        for (var digit = lane; digit <= push.mask; digit += SUBGROUP) {
            atomicStore(&places[own + digit], cursors[digit * push.runs + run]);
        }
    }
    workgroupBarrier();
    for (var step = start; step < end; step += SUBGROUP) {
        let present = step + lane < end;
        let record = records[min(step + lane, end - 1u)];
        let digit = select(push.mask + 1u, digit_of(record.x), present);
        let equals = equals_of(digit, present, lane);
        var place = 0u;
        if present && equals.before == 0u {
            place = atomicAdd(&places[own + digit], equals.all);
        }
        place = subgroupShuffle(place, equals.first & (SUBGROUP - 1u)) + equals.before;
        if present && place < arrayLength(&moved) {
            put(place, record);
        }
    }
    workgroupBarrier();
    // Debug builds compare them with the counts.
    if run < push.runs {
        for (var digit = lane; digit <= push.mask; digit += SUBGROUP) {
            cursors[digit * push.runs + run] = atomicLoad(&places[own + digit]);
        }
    }
}
