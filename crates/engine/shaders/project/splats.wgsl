// project/splats: points to splats on the screen, shaded, with the rectangle of pixels that each may cover.
// One workgroup per WG_SIZE * RUN points of a chunk, so that few atomics meet. Points outside near and far, or whose
// rectangle misses the part of the image in work, get empty bounds. Splats of more than view.small_area pixels are
// listed apart, with the number of tiles they meet.
#import splat
#import locate
#import projected
#import shade
#import dispatch

@group(0) @binding(1) var<storage, read> points_hi: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read> points_lo: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read> point_colors: array<vec4<f32>>;
@group(0) @binding(4) var<storage, read> normals: array<vec4<f32>>;
@group(0) @binding(5) var<storage, read> fields: array<f32>;

// 1: the buffer of normals is filled. The fourth component is the share of light.
override NORMALS: u32 = 0u;

// Which points: all, those whose field is at most the threshold, or those above; or all, with a mark on the former.
override PART: u32 = 0u;

// Half extent of a tilted disc along one axis of the screen, at depth 1, as (below, above) the projected center.
// e solves A e^2 - 2 e q^2 b - q^2 c = 0 with A = 1 - q^2 (1 - n_z^2) and q = r / Z, in whatever units: the plane
// through the eye and a line x = const touches the disc. A <= 0: the disc reaches the eye's plane and may cover any
// part of the screen.
fn extent_perspective(slope: f32, n: f32, n_z: f32, ratio: f32) -> vec2<f32> {
    let squared = ratio * ratio;
    let a = 1.0 - squared * (1.0 - n_z * n_z);
    let m = n - slope * n_z;
    let b = slope + m * n_z;
    let c = max(1.0 + slope * slope - m * m, 0.0);
    if !(a > 1e-6) {
        return vec2<f32>(HUGE);
    }
    let root = ratio * sqrt(max(squared * b * b + a * c, 0.0));
    return vec2<f32>(max((root - squared * b) / a, 0.0), max((root + squared * b) / a, 0.0));
}

// Half extent of a sphere along one axis of the screen, at depth 1, as (below, above) the projected center: the planes
// through the eye and a line x = const that touch it. `ratio` = r / z.
fn extent_sphere(slope: f32, ratio: f32) -> vec2<f32> {
    // A sphere that reaches the eye's plane may cover any part of the screen.
    if !(ratio < 0.999) {
        return vec2<f32>(HUGE);
    }
    let squared = ratio * ratio;
    let shift = slope * squared;
    let half = ratio * sqrt(1.0 + slope * slope - squared);
    return vec2<f32>(max(half - shift, 0.0), max(half + shift, 0.0)) / ((1.0 - ratio) * (1.0 + ratio));
}

// Distances from the projected center to the left, top, right and bottom of the covered area, in pixels.
fn extents(splat: Splat, tilt: Tilt, center: vec2<f32>) -> vec4<f32> {
    if SHAPE == SHAPE_POINT {
        return vec4<f32>(0.0);
    }
    if is_sphere() {
        var reach = vec4<f32>(splat.radius * view.focal.x);
        if view.orthographic == 0u {
            let depth = splat.depth + view.eye_hi.w;
            let slope = center / view.focal.x;
            let x = extent_sphere(slope.x, splat.radius / depth);
            let y = extent_sphere(slope.y, splat.radius / depth);
            reach = vec4<f32>(x.x, y.x, x.y, y.y) * view.focal.x;
        }
        // The exact test follows per pixel.
        return reach + (0.01 + 1e-5 * (reach + abs(center.xyxy)));
    }
    if may_tilt() && any(tilt.normal.xyz != vec3<f32>(0.0)) {
        let n = tilt.normal.xyz;
        // Rounding of the center and of the extents themselves: the exact test follows per pixel.
        let margin = 0.01 + 1e-5 * splat.radius;
        if view.orthographic != 0u {
            let half = splat.radius * sqrt(max(vec2<f32>(1.0) - n.xy * n.xy, vec2<f32>(0.0))) + margin;
            return half.xyxy;
        }
        let ratio = splat.radius / view.focal.x;
        let slope = center / view.focal.x;
        let x = extent_perspective(slope.x, n.x, n.z, ratio) * view.focal.x + margin;
        let y = extent_perspective(slope.y, n.y, n.z, ratio) * view.focal.x + margin;
        return vec4<f32>(x.x, y.x, x.y, y.y);
    }
    return vec4<f32>(splat.radius);
}

// The rectangle of a splat that reaches so far.
fn rectangle(splat: Splat, tilt: Tilt, center: vec2<f32>) -> vec4<u32> {
    return rectangle_of(splat, extents(splat, tilt, center), !is_sphere());
}

// W of Seemann et al., Eq. 22: 1 where the model alone says how transparent a soft point is.
fn modulation(field: f32) -> f32 {
    let range = view.modulation - view.threshold;
    return select(1.0, clamp((field - view.threshold) / range, 0.0, 1.0), range > 0.0);
}

// Projects a point; returns the columns and rows of its rectangle.
fn project(i: u32) -> vec2<u32> {
    let hi = points_hi[i];
    let lo = points_lo[i];
    var point = locate(hi.xyz, lo.xyz);
    let position = rounded(point.place);
    let pixel = bitcast<u32>(point.column.pixel & 0xffff | point.row.pixel << 16u);
    var radius = min(hi.w * view.radius_limits.x, HUGE);
    let depth = add2(point.place[2], vec2<f32>(-view.eye_hi.w, 0.0));
    if !is_sphere() {
        radius = min(min(hi.w * view.radius_limits.x * point.scale, view.radius_limits.y), HUGE);
        radius = select(radius, min(view.radius_limits.y, HUGE), view.radius_limits.x < 0.0);
    }
    let splat = Splat(point.column.fraction, point.row.fraction, pixel, depth.x, radius);
    var tilt = no_tilt();
    var m = 1.0;
    var normal = vec3<f32>(0.0);
    if NORMALS != 0u {
        let stored = normals[i];
        m = stored.w;
        let turn = turned(stored.xyz);
        normal = rounded(turn);
        if !is_estimated(stored.xyz) {
            var facing = turn[2].x;
            if view.orthographic == 0u {
                facing = dot2(turn, point.place).x / position.z;
            }
            tilt.normal = vec4<f32>(normal, facing);
        }
    }
    if SHAPE == SHAPE_EXACT_SPHERE {
        tilt.normal = vec4<f32>(point.column.rest, point.row.rest, depth.y, 0.0);
    }
    if has_gaussians() {
        // Of a Gaussian project/gaussians takes care.
        point.drawn = point.drawn && hi.w >= 0.0;
        if view.tilted == 0u {
            tilt = no_tilt();
        }
    }
    var drawn = point.drawn;
    if PART == PART_SOLID || PART == PART_SOFT {
        drawn = drawn && (fields[i] > view.threshold) == (PART == PART_SOFT);
    }
    let rect = select(vec4<u32>(0u), rectangle(splat, tilt, point.center), drawn);
    let extent = rect.zw - rect.xy;
    // Bounds of a Gaussian are not written twice.
    if !has_gaussians() || hi.w >= 0.0 {
        bounds[i] = rect.xy | rect.zw << vec2<u32>(16u);
    }
    if extent.x * extent.y > 0u {
        put_splat(i, splat, tilt);
        var a = min(lo.w * view.opacity_factor, 1.0);
        if PART == PART_SOFT {
            a = modulation(fields[i]);
        }
        if PART == PART_MARKED {
            a = select(1.0, 0.0, fields[i] > view.threshold);
        }
        colors[i] = vec4<f32>(lit_color(point_colors[i].rgb, position, normal, m), a);
    }
    return extent;
}

#walker
