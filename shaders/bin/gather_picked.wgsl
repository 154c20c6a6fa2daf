// bin/gather out of a presorted order: what stages that go through tiles need of each drawn splat, in that order. One subgroup
// per run, which bin/pick counted; starts are the prefix sums.
#import presorted
#import gather

@group(0) @binding(19) var<storage, read> order: array<u32>;
@group(0) @binding(20) var<storage, read> starts: array<u32>;

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
        let rectangle = bounds[i];
        let drawn = next + lane < end && is_drawn(rectangle);
        let among = subgroupBallot(drawn).x;
        if drawn {
            gather(rank + countOneBits(among & ((1u << lane) - 1u)), i, rectangle);
        }
        rank += countOneBits(among);
    }
}
