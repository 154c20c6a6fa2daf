// spbr/renew: nothing as the nearest point of each pixel, when there are no epochs left. One invocation per pixel.
#import dispatch

#push

// Four for each pixel, the first of which is the nearest point.
@group(0) @binding(0) var<storage, read_write> pixels: array<vec2<u32>>;

@compute @workgroup_size(WG_SIZE)
fn main(
    @builtin(local_invocation_index) local: u32,
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
) {
    let p = invocation_index(workgroup, groups, local);
    if p < push.count {
        pixels[4u * p] = vec2<u32>(0u);
    }
}
