// bin/pick: how many points of each run of a presorted order are drawn. One subgroup per run.
#import presorted

@group(0) @binding(0) var<storage, read> order: array<u32>;
@group(0) @binding(1) var<storage, read> bounds: array<vec2<u32>>;
@group(0) @binding(2) var<storage, read_write> counts: array<u32>;

@compute @workgroup_size(SUBGROUP)
fn main(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(subgroup_invocation_id) lane: u32,
) {
    let run = workgroup_index(workgroup, groups);
    let start = run * push.run_length;
    let end = min(start + push.run_length, push.count);
    var drawn = 0u;
    for (var place = start + lane; place < end; place += SUBGROUP) {
        drawn += u32(is_drawn(bounds[point_at(place)]));
    }
    let all = subgroupAdd(drawn);
    if lane == 0u && start < end {
        counts[run] = all;
    }
}
