// abuffer/resolve-N, N from 128, second half where invocations share work: blends lists that abuffer/sort_lists sorted.
// Reference: reference::abuffer::composite.
#import resolve
#import stored_list
#import blend_sorted

#main item {
    let p = class_pixel(item);
    if p == NOTHING {
        return;
    }
    let n = offsets[p + 1u] - offsets[p];
    let start = offsets[p] - push.first_fragment;
    let sum = blend_sorted(start, 0u, n, pixel_place(p));
    image[p] = sum.rgba;
    depths[p] = list_depth(sum);
}
