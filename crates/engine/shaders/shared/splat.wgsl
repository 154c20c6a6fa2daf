// A projected splat.
#import elementary
#import view

// A value of Footprint in src/passes/project/footprint.rs. SHAPE_SPHERE is a soft sphere (shared/sphere.wgsl): no pixel
// is always covered. SHAPE_EXACT_SPHERE is one so dense that float32 would show: its tilt holds the rest of its place.
override SHAPE: u32 = 0u;

// How far the fragments of a flat splat move toward the viewer, in its radii (Schütz and Wimmer 2015): not at all, or
// by 1 - rho^2, 1 - rho, sqrt(1 - rho^2).
override RELIEF: u32 = 0u;

struct Splat {
    // Where in its pixel the projected center lies, in [0, 1); the pixel is apart, so that a fraction of a pixel is as
    // fine at the image's edge as in its middle.
    fraction_x: f32,
    fraction_y: f32,
    // Column (low 16 bits) and row of that pixel, signed; a center farther out has a fraction beyond [0, 1).
    pixel: u32,
    // z of the center, relative to that in the view.
    depth: f32,
    // In pixels; of a sphere in world units.
    radius: f32,
}

// A splat in a buffer, without its depth, which few stages read: a vector, which is loaded and stored at once, where
// lavapipe takes a struct member by member.
alias PackedSplat = vec4<u32>;

fn pack_splat(splat: Splat) -> PackedSplat {
    return vec4<u32>(bitcast<u32>(splat.fraction_x), bitcast<u32>(splat.fraction_y), splat.pixel, bitcast<u32>(splat.radius));
}

fn unpack_splat(splat: PackedSplat, depth: f32) -> Splat {
    return Splat(bitcast<f32>(splat.x), bitcast<f32>(splat.y), splat.z, depth, bitcast<f32>(splat.w));
}

// The rest of an oriented disc: its unit normal n in camera axes and n.c / z for its center c, the slope of the
// plane against the center's ray. The normal is zero for a flat disc. Of an exact sphere: what rounding took from
// fraction_x, fraction_y and depth. Of a Gaussian what shared/gaussian.wgsl says; that alone has a rest, the next
// element of the buffer.
struct Tilt {
    normal: vec4<f32>,
    rest: vec4<f32>,
}

fn no_tilt() -> Tilt {
    return Tilt(vec4<f32>(0.0), vec4<f32>(0.0));
}

// Elements of the buffer of tilts for each splat.
fn tilt_stride() -> u32 {
    return select(1u, 2u, SHAPE == SHAPE_GAUSSIAN);
}

// Half-open rectangle of pixels that holds every covered one, within the rectangle in work; empty for a splat that is
// not drawn.
// x: first column in the low 16 bits, one past the last in the high ones; y: rows. A vector, which is loaded and stored
// at once, where lavapipe takes a struct member by member.
alias Bounds = vec2<u32>;

fn bounds_min(b: Bounds) -> vec2<u32> {
    return b & vec2<u32>(0xffffu);
}

fn bounds_max(b: Bounds) -> vec2<u32> {
    return b >> vec2<u32>(16u);
}

// The pixel that contains the center.
fn center_pixel(splat: Splat) -> vec2<i32> {
    let packed = bitcast<i32>(splat.pixel);
    return vec2<i32>((packed << 16u) >> 16u, packed >> 16u);
}

// From the pixel of the projected center to another one: whole numbers.
fn whole_to(splat: Splat, pixel: vec2<u32>) -> vec2<f32> {
    return vec2<f32>(vec2<i32>(pixel) - center_pixel(splat));
}

fn is_sphere() -> bool {
    return SHAPE == SHAPE_SPHERE || SHAPE == SHAPE_EXACT_SPHERE;
}

fn has_tilts() -> bool {
    return SHAPE == SHAPE_ORIENTED || SHAPE == SHAPE_EXACT_SPHERE || has_gaussians();
}

// True if splats may be Gaussians.
fn has_gaussians() -> bool {
    return SHAPE == SHAPE_GAUSSIAN_FLAT || SHAPE == SHAPE_GAUSSIAN;
}

// True if discs may lie in their tangent planes.
fn may_tilt() -> bool {
    return SHAPE == SHAPE_ORIENTED || SHAPE == SHAPE_GAUSSIAN;
}

// True if splats have a depth for each pixel, so that they may cross.
fn may_cross() -> bool {
    return may_tilt();
}

// True if only their rectangles say which pixels splats may cover.
fn is_rectangle() -> bool {
    return may_tilt() || has_gaussians();
}

// Discs have a radius of at least 0.
fn is_gaussian(splat: Splat) -> bool {
    return has_gaussians() && splat.radius < 0.0;
}

// Maps floats to integers of the same order, negative ones included.
fn depth_key(depth: f32) -> u32 {
    let bits = bitcast<u32>(depth);
    return select(bits | 0x80000000u, ~bits, (bits & 0x80000000u) != 0u);
}

fn key_depth(key: u32) -> f32 {
    return bitcast<f32>(select(~key, key & 0x7fffffffu, (key & 0x80000000u) != 0u));
}

// Tiles of TILE x TILE pixels start at the corner of the rectangle in work.
fn tile_columns(window: vec4<u32>) -> u32 {
    return (window.z - window.x + TILE - 1u) / TILE;
}
