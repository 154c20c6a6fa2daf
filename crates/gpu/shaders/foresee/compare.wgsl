// foresee/compare: whether words that the device counted are at most what the host took for granted. One invocation per
// word; go is set to 0 if one is more.
#import dispatch

struct Push {
    count: u32,
}

@group(0) @binding(0) var<storage, read> words: array<u32>;
@group(0) @binding(1) var<storage, read> most: array<u32>;
@group(0) @binding(2) var<storage, read_write> go: array<atomic<u32>>;
var<immediate> push: Push;

@compute @workgroup_size(WG_SIZE)
fn main(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = invocation_index(workgroup, groups, local);
    if i < push.count && words[i] > most[i] {
        atomicStore(&go[0], 0u);
    }
}
