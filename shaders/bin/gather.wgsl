// bin/gather: what stages that go through tiles need of each drawn splat, in order; its record gets the
// depth in place of the key. One invocation per drawn splat.
#import gather
#import dispatch

struct Push {
    count: u32,
    // Key of the nearest depth.
    nearest: u32,
}

var<immediate> push: Push;

@compute @workgroup_size(WG_SIZE)
fn main(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let rank = invocation_index(workgroup, groups, local);
    if rank < push.count {
        let i = records[rank].y;
        gather(rank, i, bounds[i]);
    }
}
