// soft/resolve-N, N from 128, where invocations share work: blends the segments between events that abuffer/sort_lists
// sorted.
#import soft_resolve
#import stored_list

@compute @workgroup_size(WG_SIZE)
fn main(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let p = class_pixel(invocation_index(workgroup, groups, local));
    if p == NOTHING {
        return;
    }
    let n = offsets[p + 1u] - offsets[p];
    let start = offsets[p] - push.first_fragment;
    let sum = blend_list(start, 0u, n, pixel_place(p));
    image[p] = sum.rgba;
    depths[p] = composed_depth(sum.key) + depth_origin();
}
