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

// Where a point shows, and how near, without doubt.
fn exact_hit(i: u32) -> Hit {
    let point = locate(points_hi[i].xyz, points_lo[i].xyz);
    let pixel = vec2<i32>(point.column.pixel, point.row.pixel);
    let window = vec4<i32>(view.window);
    let inside = point.drawn && all(pixel >= window.xy) && all(pixel < window.zw);
    let kept = is_kept(i, rounded(minus_eye(points_hi[i].xyz, points_lo[i].xyz)));
    return Hit(inside && kept, false, depth_key(point.place[2].x), window_index(vec2<u32>(pixel), view.window));
}

// The same in less time for most points: only the depth takes two-float arithmetic, as in locate.
fn quick_hit(i: u32) -> Hit {
    let from_eye = minus_eye(points_hi[i].xyz, points_lo[i].xyz);
    let depth = dot2(from_eye, axis(view.forward, view.forward_lo)).x;
    let place = rounded(from_eye);
    let scale = view.focal.x / select(1.0, depth, view.orthographic == 0u);
    let middle = view.size / 2u;
    // Pixels from there.
    let half = 0.5 * vec2<f32>(view.size % 2u) + view.shift.xy;
    let at = vec2<f32>(dot3(place, view.right.xyz), dot3(place, view.down.xyz)) * scale + half;
    let reach = abs(place);
    let error = ERROR * ((reach.x + reach.y + reach.z) * scale + 1.0);
    let whole = floor(at);
    let fraction = at - whole;
    let low = vec2<f32>(vec2<i32>(view.window.xy - middle));
    let high = vec2<f32>(vec2<i32>(view.window.zw - middle));
    let within = depth >= view.depth_range.x && depth <= view.depth_range.y;
    let outside = any(at + error < low) || any(at - error > high);
    let sure = all(fraction > vec2<f32>(error)) && all(fraction < vec2<f32>(1.0 - error));
    let inside = all(whole >= low) && all(whole < high);
    let pixel = vec2<u32>(vec2<i32>(whole)) + middle;
    let seen = within && inside && sure && is_kept(i, place);
    return Hit(seen, within && !outside && !sure, depth_key(depth), window_index(pixel, view.window));
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
            let hit = quick_hit(i);
            if hit.seen && is_behind(hit) {
                visible += visit(push.first + i, hit);
            }
            unsure |= u32(hit.unsure) << k;
        }
    }
    while unsure != 0u {
        let i = start + firstTrailingBit(unsure) * WG_SIZE;
        let hit = exact_hit(i);
        if hit.seen && is_behind(hit) {
            visible += visit(push.first + i, hit);
        }
        unsure &= unsure - 1u;
    }
    if is_counted() && visible > 0u {
        atomicAdd(&stats[push.chunk].visible, visible);
    }
}
