// A projected splat and the pixels it covers: the one statement of the coverage rule.
#import view

const SHAPE_DISC = 0u;
const SHAPE_ORIENTED = 1u;
const SHAPE_SQUARE = 2u;
const SHAPE_POINT = 3u;
override SHAPE: u32 = 0u;

struct Splat {
    // Projected centre in pixels, relative to the image's centre.
    center: vec2<f32>,
    // z of the centre.
    depth: f32,
    // In pixels.
    radius: f32,
}

// What an oriented disc needs besides: its unit normal in camera axes; all zero for a flat one.
struct Tilt {
    normal: vec4<f32>,
}

// Half-open rectangle of pixels that holds every covered one, within the rectangle in work; empty for a splat that is not drawn.
struct Bounds {
    // First column in the low 16 bits, one past the last in the high ones.
    columns: u32,
    rows: u32,
}

struct Coverage {
    hit: bool,
    depth: f32,
    // Distance from the centre over the radius, at most 1.
    rho: f32,
}

fn bounds_min(b: Bounds) -> vec2<u32> {
    return vec2<u32>(b.columns & 0xffffu, b.rows & 0xffffu);
}

fn bounds_max(b: Bounds) -> vec2<u32> {
    return vec2<u32>(b.columns >> 16u, b.rows >> 16u);
}

// The ray through a pixel against the disc's plane, with everything in pixels at the centre's depth and relative to the
// centre, so that nothing cancels: with o = (pixel - centre, 0), d the ray and t = n.o / n.d, the hit lies at o - d t from
// the centre and t pixels nearer than it.
fn cover_oriented(splat: Splat, normal: vec3<f32>, offset: vec2<f32>, view: View, center_pixel: bool) -> Coverage {
    let o = vec3<f32>(offset, 0.0);
    var ray = vec3<f32>(0.0, 0.0, 1.0);
    var unit = 1.0 / view.focal_px;
    if view.orthographic == 0u {
        ray = vec3<f32>((splat.center + offset) / view.focal_px, 1.0);
        unit = splat.depth / view.focal_px;
    }
    let t = dot(normal, o) / dot(normal, ray);
    let distance = length(o - ray * t);
    let depth = splat.depth - unit * t;
    // An edge-on plane gives NaN or infinity, and the comparison is then false. A ray starts at the eye.
    if distance <= splat.radius && (view.orthographic != 0u || depth > 0.0) {
        return Coverage(true, depth, relative_distance(distance, splat.radius));
    }
    return Coverage(center_pixel, splat.depth, 1.0);
}

fn relative_distance(distance: f32, radius: f32) -> f32 {
    return select(1.0, min(distance / radius, 1.0), radius > 0.0);
}

fn cover(splat: Splat, tilt: Tilt, pixel: vec2<u32>, view: View) -> Coverage {
    let offset = pixel_center(pixel, view.size) - splat.center;
    let center_pixel = all(pixel_at(splat.center, view.size) == vec2<i32>(pixel));
    if SHAPE == SHAPE_POINT {
        return Coverage(center_pixel, splat.depth, 1.0);
    }
    if SHAPE == SHAPE_SQUARE {
        let inside = all(abs(offset) <= vec2<f32>(splat.radius));
        return Coverage(inside || center_pixel, splat.depth, 1.0);
    }
    if SHAPE == SHAPE_ORIENTED && any(tilt.normal.xyz != vec3<f32>(0.0)) {
        return cover_oriented(splat, tilt.normal.xyz, offset, view, center_pixel);
    }
    let squared = dot(offset, offset);
    let inside = squared <= splat.radius * splat.radius;
    return Coverage(inside || center_pixel, splat.depth, relative_distance(sqrt(squared), splat.radius));
}

// Maps floats to integers of the same order, negative ones included.
fn depth_key(depth: f32) -> u32 {
    let bits = bitcast<u32>(depth);
    return select(bits | 0x80000000u, ~bits, (bits & 0x80000000u) != 0u);
}

fn key_depth(key: u32) -> f32 {
    return bitcast<f32>(select(~key, key & 0x7fffffffu, (key & 0x80000000u) != 0u));
}

// Splats of at most this many pixels are walked by one invocation; larger ones are cut into tiles.
const SMALL_AREA = 256u;
// Side of a tile in pixels.
const TILE = 16u;
