// splat/project: points to splats on the screen, shaded, with the rectangle of pixels that each may cover.
// One invocation per point of a chunk. Points outside near and far, or whose rectangle misses the part of the image in
// work, get empty bounds. Splats of more than SMALL_AREA pixels are listed apart, with the number of tiles they need.
#import splat
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

fn in_camera(v: vec3<f32>) -> vec3<f32> {
    return vec3<f32>(dot(v, view.right.xyz), dot(v, view.down.xyz), dot(v, view.forward.xyz));
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
fn extents(splat: Splat, tilt: Tilt) -> vec4<f32> {
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
        let radius = splat.radius * splat.depth / view.focal_px;
        let slope = splat.center / view.focal_px;
        let x = extent_perspective(slope.x, n.x, n.z, splat.depth, radius) * view.focal_px + margin;
        let y = extent_perspective(slope.y, n.y, n.z, splat.depth, radius) * view.focal_px + margin;
        return vec4<f32>(x.x, y.x, x.y, y.y);
    }
    return vec4<f32>(splat.radius);
}

// First pixel whose centre is not before a position, and last one whose centre is not behind it.
fn pixel_from(position: vec2<f32>) -> vec2<i32> {
    return on_image(ceil(position + 0.5 * vec2<f32>(view.size % 2u) - 0.5));
}

fn pixel_to(position: vec2<f32>) -> vec2<i32> {
    return on_image(floor(position + 0.5 * vec2<f32>(view.size % 2u) - 0.5));
}

fn on_image(relative: vec2<f32>) -> vec2<i32> {
    let limit = vec2<f32>(view.size);
    return vec2<i32>(clamp(relative, -limit, limit)) + vec2<i32>(view.size / 2u);
}

fn rectangle(splat: Splat, tilt: Tilt) -> Bounds {
    let reach = extents(splat, tilt);
    let center = pixel_at(splat.center, view.size);
    let low = min(pixel_from(splat.center - reach.xy), center);
    let high = max(pixel_to(splat.center + reach.zw), center) + 1;
    let window_low = vec2<i32>(view.window.xy);
    let window_high = vec2<i32>(view.window.zw);
    let l = vec2<u32>(clamp(low, window_low, window_high));
    let h = vec2<u32>(clamp(high, window_low, window_high));
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

fn add_area(n: u32) {
    let old = atomicAdd(&stats[push.chunk].area_low, n);
    if old + n < old {
        atomicAdd(&stats[push.chunk].area_high, 1u);
    }
}

@compute @workgroup_size(WG_SIZE)
fn main(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = invocation_index(workgroup, groups, local);
    if i >= push.count {
        return;
    }
    let point = points[i];
    let position = in_camera((point.hi - view.eye_hi.xyz) + (point.lo - view.eye_lo.xyz));
    // Written so that NaN is not drawn.
    if !(position.z >= view.near && position.z <= view.far) {
        bounds[i] = Bounds(0u, 0u);
        return;
    }
    var scale = view.focal_px;
    if view.orthographic == 0u {
        scale = view.focal_px / position.z;
    }
    let radius = min(min(point.radius * view.radius_factor * scale, view.max_radius_px), HUGE);
    let splat = Splat(clamp(position.xy * scale, vec2<f32>(-HUGE), vec2<f32>(HUGE)), position.z, radius);
    var tilt = Tilt(vec4<f32>(0.0));
    if NORMALS != 0u {
        tilt.normal = vec4<f32>(in_camera(normals[i].xyz), 0.0);
    }
    let rect = rectangle(splat, tilt);
    bounds[i] = rect;
    let extent = bounds_max(rect) - bounds_min(rect);
    let area = extent.x * extent.y;
    if area == 0u {
        return;
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
    atomicAdd(&stats[push.chunk].visible, 1u);
    add_area(area);
    if area > SMALL_AREA {
        let tiles = (extent + TILE - 1u) / TILE;
        let place = atomicAdd(&stats[push.chunk].large, 1u);
        large[place] = i;
        tile_counts[place] = tiles.x * tiles.y;
        add_tiles(tiles.x * tiles.y);
    }
}
