// bin/measure: the longest list of a tile. One invocation per tile.
#import dispatch

struct Push {
    tiles: u32,
    // Cells of a tile in the table of prefix sums.
    runs: u32,
}

@group(0) @binding(0) var<storage, read> starts: array<u32>;
@group(0) @binding(1) var<storage, read_write> longest: array<atomic<u32>>;
var<immediate> push: Push;

@compute @workgroup_size(WG_SIZE)
fn main(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let tile = invocation_index(workgroup, groups, local);
    if tile < push.tiles {
        atomicMax(&longest[0], starts[(tile + 1u) * push.runs] - starts[tile * push.runs]);
    }
}
