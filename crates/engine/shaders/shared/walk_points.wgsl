// The walk over the points of a chunk, each straight to its pixel. A pass says which points it wants, wherever they
// show (is_kept(index in the chunk, place relative to the eye in world axes)) and where (is_behind(hit)), and defines
// visit(index among all points, hit); it is called for each of those that shows, and what it returns is added to the
// visible ones if is_counted(). One workgroup per WG_SIZE * RUN points.
#import elementary
#import locate
#import splat
#import stats
#import dispatch

// Positions minus the cloud's origin as sums of two floats.
@group(0) @binding(1) var<storage, read> points_hi: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read> points_lo: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read_write> stats: array<Stats>;
#push

// Points of one invocation, at most 32.
override RUN: u32 = 8u;
// 1: points are shown in several images of a frame with samples, from the push constants' first turn on. What is
// offered to pixels of one stands `stride` behind what is offered to those of the one before.
override SEVERAL: u32 = 0u;

// Bound on the error of a float32 coordinate on the screen, in pixels, over scale * (|x| + |y| + |z|) + 1 of the place
// relative to the eye. In units of 2^-24: 5 roundings on the way to the dot product with an axis, 4 more to the product
// with the scale, 1 for the shift by half a pixel, 1 in the comparisons below; another stands for what is of second
// order.
const ERROR = 12.0 / 16777216.0;

struct Hit {
    // In the part of the image in work.
    seen: bool,
    // Too near to a pixel's border for float32; seen says nothing then.
    unsure: bool,
    key: u32,
    // In the order of window_index.
    pixel: u32,
}

fn images() -> u32 {
    return select(1u, push.images, SEVERAL != 0u);
}

// Pixels by which positions are moved in an image in work: those of Hammersley's points, in units of 1/128. The image
// whose depths the picture has, number samples / 2, is the last one.
fn shift_of(image: u32) -> vec2<f32> {
    if SEVERAL == 0u {
        return view.shift;
    }
    let turn = push.first_turn + image;
    let middle = push.samples / 2u;
    var number = select(turn, turn + 1u, turn >= middle);
    number = select(number, middle, turn + 1u == push.samples);
    let x = (2u * number + 1u) * (64u / push.samples);
    let y = (reverseBits(number) >> 25u) + 64u / push.samples;
    return (64.0 - vec2<f32>(vec2<u32>(x, y))) / 128.0;
}

// Where a point shows, and how near, without doubt.
fn exact_hit(i: u32, image: u32) -> Hit {
    view.shift = shift_of(image);
    let point = locate(points_hi[i].xyz, points_lo[i].xyz);
    let pixel = vec2<i32>(point.column.pixel, point.row.pixel);
    let window = vec4<i32>(view.window);
    let inside = point.drawn && all(pixel >= window.xy) && all(pixel < window.zw);
    let kept = is_kept(i, rounded(minus_eye(points_hi[i].xyz, points_lo[i].xyz)));
    return Hit(inside && kept, false, depth_key(point.place[2].x), place_in(image, vec2<u32>(pixel)));
}

// Place of an image's pixel among those of all images in work.
fn place_in(image: u32, pixel: vec2<u32>) -> u32 {
    return window_index(pixel, view.window) + select(0u, image * push.stride, SEVERAL != 0u);
}

// A point's place without doubt about its depth, but about the rest within an error.
struct QuickPlace {
    depth: f32,
    // Relative to the eye, in world axes.
    place: vec3<f32>,
    // Pixels from where the viewing axis meets the image.
    at: vec2<f32>,
    error: f32,
}

// In less time than locate takes: only the depth takes two-float arithmetic.
fn quick_place(i: u32) -> QuickPlace {
    let from_eye = minus_eye(points_hi[i].xyz, points_lo[i].xyz);
    let depth = dot2(from_eye, axis(view.forward, view.forward_lo)).x;
    let place = rounded(from_eye);
    let scale = view.focal.x / select(1.0, depth, view.orthographic == 0u);
    let at = vec2<f32>(dot3(place, view.right.xyz), dot3(place, view.down.xyz)) * scale;
    let reach = abs(place);
    return QuickPlace(depth, place, at, ERROR * ((reach.x + reach.y + reach.z) * scale + 1.0));
}

// Where a point shows for most points.
fn quick_hit(i: u32, found: QuickPlace, image: u32) -> Hit {
    let middle = view.size / 2u;
    // Pixels from there.
    let at = found.at + (0.5 * vec2<f32>(view.size % 2u) + shift_of(image));
    let error = found.error;
    let whole = floor(at);
    let fraction = at - whole;
    let low = vec2<f32>(vec2<i32>(view.window.xy - middle));
    let high = vec2<f32>(vec2<i32>(view.window.zw - middle));
    let within = found.depth >= view.depth_range.x && found.depth <= view.depth_range.y;
    let outside = any(at + error < low) || any(at - error > high);
    let sure = all(fraction > vec2<f32>(error)) && all(fraction < vec2<f32>(1.0 - error));
    let inside = all(whole >= low) && all(whole < high);
    let pixel = vec2<u32>(vec2<i32>(whole)) + middle;
    let seen = within && inside && sure && is_kept(i, found.place);
    return Hit(seen, within && !outside && !sure, depth_key(found.depth), place_in(image, pixel));
}

#main {
    view = camera;
    let start = workgroup_index(workgroup, groups) * WG_SIZE * RUN + local;
    var visible = 0u;
    // One bit for each step: invocations in step would all take both ways.
    var unsure = 0u;
    for (var k = 0u; k < RUN; k++) {
        let i = start + k * WG_SIZE;
        if i < push.count {
            let place = quick_place(i);
            for (var image = 0u; image < images(); image++) {
                let hit = quick_hit(i, place, image);
                if hit.seen && is_behind(hit) {
                    visible += visit(push.first + i, hit);
                }
                unsure |= u32(hit.unsure) << k;
            }
        }
    }
    while unsure != 0u {
        let i = start + firstTrailingBit(unsure) * WG_SIZE;
        for (var image = 0u; image < images(); image++) {
            // Images in which there was no doubt have the point already.
            if SEVERAL == 0u || quick_hit(i, quick_place(i), image).unsure {
                let hit = exact_hit(i, image);
                if hit.seen && is_behind(hit) {
                    visible += visit(push.first + i, hit);
                }
            }
        }
        unsure &= unsure - 1u;
    }
    if is_counted() && visible > 0u {
        atomicAdd(&stats[push.chunk].visible, visible);
    }
}
