// shadows/share: number of lights that reach a point to m, their share of all. One invocation per point of a chunk.
#import dispatch

struct Push {
    // Points of the chunk.
    count: u32,
    lights: u32,
}

@group(0) @binding(0) var<storage, read_write> normals: array<vec4<f32>>;
var<immediate> push: Push;

@compute @workgroup_size(WG_SIZE)
fn main(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = invocation_index(workgroup, groups, local);
    if i < push.count {
        let normal = normals[i];
        normals[i] = vec4<f32>(normal.xyz, normal.w / f32(push.lights));
    }
}
