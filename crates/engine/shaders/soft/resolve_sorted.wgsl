// soft/resolve-N, N from 128, where invocations share work: blends the segments between events that abuffer/sort_lists
// sorted.
#import soft_resolve
#import stored_list

#main item {
    let p = class_pixel(item);
    if p == NOTHING {
        return;
    }
    let n = offsets[p + 1u] - offsets[p];
    let start = offsets[p] - push.first_fragment;
    let sum = blend_list(start, 0u, n, pixel_place(p));
    image[p] = sum.rgba;
    depths[p] = composed_depth(sum.key) + depth_origin();
}
