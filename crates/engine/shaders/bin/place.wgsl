// bin/place: a record for each drawn point of a presorted order, in that order; nobody asks for its key. One
// subgroup per run, which bin/pick counted; starts are the prefix sums.
#import presorted

@group(0) @binding(0) var<storage, read> order: array<u32>;
@group(0) @binding(1) var<storage, read> bounds: array<vec2<u32>>;
@group(0) @binding(2) var<storage, read> starts: array<u32>;
@group(0) @binding(3) var<storage, read_write> records: array<vec2<u32>>;

@compute @workgroup_size(SUBGROUP)
fn main(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(subgroup_invocation_id) lane: u32,
) {
    let run = workgroup_index(workgroup, groups);
    let start = run * push.run_length;
    let end = min(start + push.run_length, push.count);
    if start >= end {
        return;
    }
    var rank = starts[run];
    for (var next = start; next < end; next += SUBGROUP) {
        let i = point_at(min(next + lane, end - 1u));
        let drawn = next + lane < end && is_drawn(bounds[i]);
        let among = subgroupBallot(drawn).x;
        let place = rank + countOneBits(among & ((1u << lane) - 1u));
        // Both passes ask the same of the same points; should a driver ever disagree with itself, nothing is written
        // outside.
        if drawn && place < arrayLength(&records) {
            records[place] = vec2<u32>(0u, i);
        }
        rank += countOneBits(among);
    }
}
