// abuffer/resolve-N, N up to 32: sorts and blends short lists in registers, by Batcher's odd-even merge network. The
// host writes the network out for the class's capacity: no loop, no array, the same work for every invocation.
// Reference: reference::abuffer::composite.
#import resolve
#import fragments

fn slot(start: u32, i: u32, n: u32) -> vec2<u32> {
    return select(vec2<u32>(NOTHING), fragments[start + min(i, n - 1u)], i < n);
}

// Of Gaussians: true once the list has ended early.
var<private> ended: bool = false;

fn blend(front: Composed, fragment: vec2<u32>, present: bool, pixel: vec2<u32>) -> Composed {
    // The first splat stands in for none. It need not be drawn, and then nothing was written there: not even a number.
    let i = select(0u, fragment.y, present);
    let color = fragment_color(i, pixel);
    let next = behind(front, shown_key(fragment.x, i), select(vec4<f32>(0.0), color, present));
    if !has_gaussians() {
        return next;
    }
    ended = ended || is_end(next.rgba.a);
    return Composed(select(next.rgba, front.rgba, ended), select(next.key, front.key, ended));
}

#main item {
    let p = class_pixel(item);
    if p == NOTHING {
        return;
    }
    let n = offsets[p + 1u] - offsets[p];
    let start = offsets[p] - push.first_fragment;
    let pixel = pixel_place(p);
#repeat     var x{i} = slot(start, {i}u, n);
#comparators
    var sum = Composed(vec4<f32>(0.0), NOTHING);
#repeat     sum = blend(sum, x{i}, {i}u < n, pixel);
    image[p] = sum.rgba;
    depths[p] = list_depth(sum);
}
