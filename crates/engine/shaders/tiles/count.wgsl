// tiles/count: how many large splats meet each tile. One invocation per pair. counts is zero before.
#import tiles
@group(0) @binding(5) var<storage, read_write> counts: array<atomic<u32>>;

@compute @workgroup_size(WG_SIZE)
fn main(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let pair = invocation_index(workgroup, groups, local);
    if pair < pairs() {
        atomicAdd(&counts[pair_at(pair).tile], 1u);
    }
}
