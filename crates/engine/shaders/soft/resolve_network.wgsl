// soft/resolve-N, N up to 32: sorts the events of short lists in registers, as abuffer/resolve-N does, and blends the
// segments between them.
#import soft_resolve
#import fragments
#import private_list

fn slot(start: u32, i: u32, n: u32) -> vec2<u32> {
    return select(vec2<u32>(NOTHING), fragments[start + min(i, n - 1u)], i < n);
}

#main item {
    let p = class_pixel(item);
    if p == NOTHING {
        return;
    }
    let n = offsets[p + 1u] - offsets[p];
    let start = offsets[p] - push.first_fragment;
#repeat     var x{i} = slot(start, {i}u, n);
#comparators
    var list: array<vec2<u32>, CAPACITY>;
#repeat     list[{i}u] = x{i};
    let sum = blend_list(&list, 0u, n, pixel_place(p));
    image[p] = sum.rgba;
    depths[p] = composed_depth(sum.key) + depth_origin();
}
