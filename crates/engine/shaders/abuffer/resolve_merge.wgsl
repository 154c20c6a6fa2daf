// abuffer/resolve-N, N from 32 to 256: sorts and blends lists of up to CAPACITY fragments by merge sort in a local
// array. Reference: reference::abuffer::composite.
#import resolve
#import local_sort
#import blend_sorted

#main item {
    let p = class_pixel(item);
    if p == NOTHING {
        return;
    }
    let n = offsets[p + 1u] - offsets[p];
    let start = offsets[p] - push.first_fragment;
    var list: array<vec2<u32>, 2u * CAPACITY>;
    for (var i = 0u; i < n; i++) {
        list[i] = fragments[start + i];
    }
    let sorted = sort_local(&list, n);
    let sum = blend_sorted(&list, sorted, n, pixel_place(p));
    image[p] = sum.rgba;
    depths[p] = list_depth(sum);
}
