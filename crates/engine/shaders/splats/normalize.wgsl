// splats/normalize: sums to colors, in place; A = 1 where anything was summed (Botsch et al. 2004, the third pass). One
// invocation per pixel. Reference: reference::splats::blend.
#import dispatch

#push

@group(0) @binding(0) var<storage, read_write> image: array<vec4<f32>>;

@compute @workgroup_size(WG_SIZE)
fn main(
    @builtin(local_invocation_index) local: u32,
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
) {
    let p = invocation_index(workgroup, groups, local);
    if p >= push.count {
        return;
    }
    let sum = image[p];
    image[p] = select(vec4<f32>(0.0), vec4<f32>(sum.rgb / sum.a, 1.0), sum.a > 0.0);
}
