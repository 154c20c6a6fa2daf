// splat/project: points to splats on the screen, shaded, with the rectangle of pixels that each may cover.
// One workgroup per WG_SIZE * RUN points of a chunk, so that few atomics meet. Points outside near and far, or whose rectangle misses the part of the image in
// work, get empty bounds. Splats of more than SMALL_AREA pixels are listed apart, with the number of tiles they meet.
#import splat
#import twofloat
#import dispatch

struct Point {
    // Position minus the cloud's origin as a sum of two floats.
    hi: vec3<f32>,
    // World radius.
    radius: f32,
    lo: vec3<f32>,
    opacity: f32,
}

struct Stats {
    visible: atomic<u32>,
    large: atomic<u32>,
    // Tiles of all large splats, 64 bits.
    tiles_low: atomic<u32>,
    tiles_high: atomic<u32>,
    // Most columns and rows of pixels of a splat.
    widest: atomic<u32>,
    tallest: atomic<u32>,
    // Pixels of all rectangles, 64 bits.
    area_low: atomic<u32>,
    area_high: atomic<u32>,
}

struct Push {
    // Points of the chunk, and its number.
    count: u32,
    chunk: u32,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<storage, read> points: array<Point>;
@group(0) @binding(2) var<storage, read> point_colors: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read> normals: array<vec4<f32>>;
@group(0) @binding(4) var<storage, read_write> splats: array<Splat>;
@group(0) @binding(5) var<storage, read_write> tilts: array<Tilt>;
@group(0) @binding(6) var<storage, read_write> bounds: array<Bounds>;
@group(0) @binding(7) var<storage, read_write> colors: array<vec4<f32>>;
@group(0) @binding(8) var<storage, read_write> large: array<u32>;
@group(0) @binding(9) var<storage, read_write> tile_counts: array<u32>;
@group(0) @binding(10) var<storage, read_write> stats: array<Stats>;
var<immediate> push: Push;

const SHADING_NONE = 0u;
const SHADING_LAMBERT = 1u;
const SHADING_PHONG = 2u;
override SHADING: u32 = 0u;
// 1: blending runs on sRGB-encoded values.
override ENCODED: u32 = 0u;
// 1: the buffer of normals is filled.
override NORMALS: u32 = 0u;

// Beyond any image, and with a square that stays finite.
const HUGE = 1e18;

// Points of one invocation.
override RUN: u32 = 8u;

// A vector in camera axes, each component a sum of two floats.
fn in_camera(v: array<vec2<f32>, 3>) -> array<vec2<f32>, 3> {
    return array<vec2<f32>, 3>(
        dot2(v, axis(view.right, view.right_lo)),
        dot2(v, axis(view.down, view.down_lo)),
        dot2(v, axis(view.forward, view.forward_lo)),
    );
}

fn axis(hi: vec4<f32>, lo: vec4<f32>) -> array<vec2<f32>, 3> {
    return array<vec2<f32>, 3>(vec2<f32>(hi.x, lo.x), vec2<f32>(hi.y, lo.y), vec2<f32>(hi.z, lo.z));
}

fn minus_eye(hi: vec3<f32>, lo: vec3<f32>) -> array<vec2<f32>, 3> {
    return array<vec2<f32>, 3>(
        add2(vec2<f32>(hi.x, lo.x), -vec2<f32>(view.eye_hi.x, view.eye_lo.x)),
        add2(vec2<f32>(hi.y, lo.y), -vec2<f32>(view.eye_hi.y, view.eye_lo.y)),
        add2(vec2<f32>(hi.z, lo.z), -vec2<f32>(view.eye_hi.z, view.eye_lo.z)),
    );
}

fn rounded(v: array<vec2<f32>, 3>) -> vec3<f32> {
    return vec3<f32>(v[0].x, v[1].x, v[2].x);
}

// Pixel of a screen coordinate relative to the image's middle, and the fraction within it.
struct Screen {
    pixel: i32,
    fraction: f32,
}

fn on_screen(relative: vec2<f32>, size: u32) -> Screen {
    // An even image's middle is a border of pixels, an odd one's lies half a pixel in.
    let shifted = add2(relative, vec2<f32>(0.5 * f32(size % 2u), 0.0));
    let whole = clamp(floor(shifted.x), -16000.0, 16000.0);
    var screen = Screen(i32(whole), (shifted.x - whole) + shifted.y);
    if screen.fraction < 0.0 && whole > -16000.0 {
        screen.pixel -= 1;
        screen.fraction = ((shifted.x - whole) + 1.0) + shifted.y;
    }
    screen.pixel += i32(size / 2u);
    // Rounded up to the next pixel, it would lie in none.
    if screen.fraction == 1.0 {
        screen.fraction = 0.99999994;
    }
    return screen;
}

fn encode(c: vec3<f32>) -> vec3<f32> {
    let curve = 1.055 * pow(max(c, vec3<f32>(0.0)), vec3<f32>(1.0 / 2.4)) - 0.055;
    return select(curve, c * 12.92, c <= vec3<f32>(0.0031308));
}

// Interface: c(ambient + diffuse max(0, n.l)), two-sided; Phong adds specular max(0, r.v)^shininess.
fn shade(color: vec3<f32>, position: vec3<f32>, normal: vec3<f32>) -> vec3<f32> {
    var to_eye = vec3<f32>(0.0, 0.0, -1.0);
    if view.orthographic == 0u {
        to_eye = normalize(-position);
    }
    let n = select(-normal, normal, dot(normal, to_eye) >= 0.0);
    var l = view.light.xyz;
    if view.light.w != 0.0 {
        let toward = view.light.xyz - position;
        let reach = length(toward);
        l = select(to_eye, toward / reach, reach > 0.0);
    }
    let facing = dot(n, l);
    var shaded = color * (view.material.x + view.material.y * max(facing, 0.0));
    if SHADING == SHADING_PHONG && facing > 0.0 {
        let along = max(dot(2.0 * facing * n - l, to_eye), 0.0);
        // pow(0, 0) is 1 by definition here.
        shaded += vec3<f32>(view.material.z * select(pow(along, view.material.w), 1.0, view.material.w == 0.0));
    }
    return shaded;
}

// Half extent of a tilted disc along one axis of the screen, at depth 1, as (below, above) the projected centre.
// e solves A e^2 - 2 e r^2 b - r^2 c = 0 with A = Z^2 - r^2 (1 - n_z^2): the plane through the eye and a line x = const
// touches the disc. A <= 0: the disc reaches the eye's plane and may cover any part of the screen.
fn extent_perspective(slope: f32, n: f32, n_z: f32, depth: f32, radius: f32) -> vec2<f32> {
    let squared = radius * radius;
    let a = depth * depth - squared * (1.0 - n_z * n_z);
    let m = n - slope * n_z;
    let b = slope + m * n_z;
    let c = max(1.0 + slope * slope - m * m, 0.0);
    if !(a > 1e-6 * depth * depth) {
        return vec2<f32>(HUGE);
    }
    let root = sqrt(max(squared * squared * b * b + a * squared * c, 0.0));
    return vec2<f32>(max((root - squared * b) / a, 0.0), max((root + squared * b) / a, 0.0));
}

// Distances from the projected centre to the left, top, right and bottom of the covered area, in pixels.
fn extents(splat: Splat, tilt: Tilt, center: vec2<f32>) -> vec4<f32> {
    if SHAPE == SHAPE_POINT {
        return vec4<f32>(0.0);
    }
    if SHAPE == SHAPE_ORIENTED && any(tilt.normal.xyz != vec3<f32>(0.0)) {
        let n = tilt.normal.xyz;
        // Rounding of the centre and of the extents themselves: the exact test follows per pixel.
        let margin = 0.01 + 1e-5 * splat.radius;
        if view.orthographic != 0u {
            let half = splat.radius * sqrt(max(vec2<f32>(1.0) - n.xy * n.xy, vec2<f32>(0.0))) + margin;
            return half.xyxy;
        }
        let radius = splat.radius * splat.depth / view.focal.x;
        let slope = center / view.focal.x;
        let x = extent_perspective(slope.x, n.x, n.z, splat.depth, radius) * view.focal.x + margin;
        let y = extent_perspective(slope.y, n.y, n.z, splat.depth, radius) * view.focal.x + margin;
        return vec4<f32>(x.x, y.x, x.y, y.y);
    }
    return vec4<f32>(splat.radius);
}

fn rectangle(splat: Splat, tilt: Tilt, center: vec2<f32>) -> Bounds {
    let reach = extents(splat, tilt, center);
    let pixel = center_pixel(splat);
    let fraction = vec2<f32>(splat.fraction_x, splat.fraction_y);
    // Pixel i of the neighborhood has its centre at i + 0.5: those within reach, and always the centre's own.
    let limit = vec2<f32>(65536.0);
    let low = pixel + vec2<i32>(clamp(ceil(fraction - reach.xy - 0.5), -limit, limit));
    let high = pixel + vec2<i32>(clamp(floor(fraction + reach.zw - 0.5), -limit, limit));
    let window_low = vec2<i32>(view.window.xy);
    let window_high = vec2<i32>(view.window.zw);
    let l = vec2<u32>(clamp(min(low, pixel), window_low, window_high));
    let h = vec2<u32>(clamp(max(high, pixel) + 1, window_low, window_high));
    if any(l >= h) {
        return Bounds(0u, 0u);
    }
    return Bounds(l.x | h.x << 16u, l.y | h.y << 16u);
}

// Adds to a 64-bit counter made of two words.
fn add_tiles(n: u32) {
    let old = atomicAdd(&stats[push.chunk].tiles_low, n);
    if old + n < old {
        atomicAdd(&stats[push.chunk].tiles_high, 1u);
    }
}

// Projects a point; returns the columns and rows of pixels that it may cover, zero if none.
fn project(i: u32) -> vec2<u32> {
    let point = points[i];
    let place = in_camera(minus_eye(point.hi, point.lo));
    let position = rounded(place);
    // Written so that NaN is not drawn.
    if !(position.z >= view.depth_range.x && position.z <= view.depth_range.y) {
        bounds[i] = Bounds(0u, 0u);
        return vec2<u32>(0u);
    }
    var scale = view.focal;
    if view.orthographic == 0u {
        scale = divide2(view.focal, place[2]);
    }
    let x = multiply2(place[0], scale);
    let y = multiply2(place[1], scale);
    if !(abs(x.x) <= HUGE && abs(y.x) <= HUGE) {
        bounds[i] = Bounds(0u, 0u);
        return vec2<u32>(0u);
    }
    let column = on_screen(x, view.size.x);
    let row = on_screen(y, view.size.y);
    let pixel = bitcast<u32>(column.pixel & 0xffff | row.pixel << 16u);
    let radius = min(min(point.radius * view.radius_limits.x * scale.x, view.radius_limits.y), HUGE);
    let splat = Splat(column.fraction, row.fraction, pixel, position.z, radius);
    var tilt = Tilt(vec4<f32>(0.0));
    if NORMALS != 0u {
        let n = normals[i].xyz;
        let turned = in_camera(array<vec2<f32>, 3>(vec2<f32>(n.x, 0.0), vec2<f32>(n.y, 0.0), vec2<f32>(n.z, 0.0)));
        var facing = turned[2].x;
        if view.orthographic == 0u {
            facing = dot2(turned, place).x / position.z;
        }
        tilt.normal = vec4<f32>(rounded(turned), facing);
    }
    let rect = rectangle(splat, tilt, vec2<f32>(x.x, y.x));
    bounds[i] = rect;
    let extent = bounds_max(rect) - bounds_min(rect);
    let area = extent.x * extent.y;
    if area == 0u {
        return vec2<u32>(0u);
    }
    splats[i] = splat;
    if SHAPE == SHAPE_ORIENTED {
        tilts[i] = tilt;
    }
    var color = point_colors[i].rgb;
    if SHADING != SHADING_NONE && any(tilt.normal.xyz != vec3<f32>(0.0)) {
        color = shade(color, position, normalize(tilt.normal.xyz));
    }
    if ENCODED != 0u {
        color = encode(color);
    }
    colors[i] = vec4<f32>(color, point.opacity);
    if area > SMALL_AREA {
        let first = (bounds_min(rect) - view.window.xy) / TILE;
        let last = (bounds_max(rect) - 1u - view.window.xy) / TILE;
        let tiles = last - first + 1u;
        let place = atomicAdd(&stats[push.chunk].large, 1u);
        large[place] = i;
        tile_counts[place] = tiles.x * tiles.y;
        add_tiles(tiles.x * tiles.y);
    }
    return extent;
}

@compute @workgroup_size(WG_SIZE)
fn main(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let first = workgroup_index(workgroup, groups) * WG_SIZE * RUN + local;
    var visible = 0u;
    var most = vec2<u32>(0u);
    var area = 0u;
    for (var k = 0u; k < RUN; k++) {
        let i = first + k * WG_SIZE;
        if i < push.count {
            let extent = project(i);
            visible += select(0u, 1u, extent.x > 0u);
            most = max(most, extent);
            // No image has more than 2^28 pixels, so that eight of them stay within 32 bits.
            area += extent.x * extent.y;
        }
    }
    if visible > 0u {
        atomicAdd(&stats[push.chunk].visible, visible);
        let old = atomicAdd(&stats[push.chunk].area_low, area);
        if old + area < old {
            atomicAdd(&stats[push.chunk].area_high, 1u);
        }
        atomicMax(&stats[push.chunk].widest, most.x);
        atomicMax(&stats[push.chunk].tallest, most.y);
    }
}
