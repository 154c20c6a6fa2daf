// The pixels that a splat covers: the one statement of the coverage rule. The stage binds `view`.
#import splat
#import gaussian
#import middle
#import sample_place

struct Coverage {
    hit: bool,
    depth: f32,
    // Distance from the center over the radius, at most 1 but in a square's corners. Of a Gaussian the square of its
    // Mahalanobis distance over that at which it ends.
    rho: f32,
}

// Numbers of `view` that a flat splat's coverage needs. They are read once, outside all branches: drivers merge no
// loads that stand in branches, and move none out of them.
struct Lens {
    // Where the viewing axis meets the image, in pixels.
    middle: vec2<f32>,
    focal: f32,
    // Depth that those of splats are relative to.
    origin: f32,
    orthographic: bool,
}

// That of stages that go through tiles, which read it before their loops: CPU drivers would load each number again for
// every splat, one lane after the other. shared/hand_over and shared/region_fold set it.
var<private> tile_lens: Lens;

fn lens_of_view() -> Lens {
    return Lens(middle_of_image(), view.focal.x, view.eye_hi.w, view.orthographic != 0u);
}

// From the projected center to a pixel's sample, in pixels: exact up to one rounding.
fn offset_of(splat: Splat, whole: vec2<f32>, pixel: vec2<u32>) -> vec2<f32> {
    return whole + (sample_in(pixel) - vec2<f32>(splat.fraction_x, splat.fraction_y));
}

// True if the pixel of the picture around a sample contains a center: the center's own pixel, unless pixels are
// quarters. Its right and lower border lie outside.
fn contains(whole: vec2<f32>, offset: vec2<f32>) -> bool {
    if QUARTERS == 0u {
        return all(whole == vec2<f32>(0.0));
    }
    return all(offset > vec2<f32>(-1.0)) && all(offset <= vec2<f32>(1.0));
}

// The ray through a pixel against the disc's plane, with everything in pixels at the center's depth and relative to the
// center, so that nothing cancels: with o = (pixel - center, 0), d the ray and t = n.o / n.d, the hit lies at o - d t
// from the center and t pixels nearer than it.
fn cover_oriented(splat: Splat, tilt: vec4<f32>, whole: vec2<f32>, pixel: vec2<u32>, lens: Lens) -> Coverage {
    let normal = tilt.xyz;
    let o = offset_of(splat, whole, pixel);
    let along = normal.x * o.x + normal.y * o.y;
    var ray = vec3<f32>(0.0, 0.0, 1.0);
    var unit = 1.0 / lens.focal;
    var facing = tilt.w;
    if !lens.orthographic {
        let from_middle = vec2<f32>(pixel) + sample_in(pixel) - lens.middle;
        ray = vec3<f32>(from_middle / lens.focal, 1.0);
        unit = (splat.depth + lens.origin) / lens.focal;
        facing += along / lens.focal;
    }
    let t = along / facing;
    let from_center = vec3<f32>(o, 0.0) - ray * t;
    let squared = dot3(from_center, from_center);
    let depth = splat.depth - unit * t;
    // An edge-on plane gives NaN or infinity, and the comparison is then false. A ray starts at the eye.
    if squared <= splat.radius * splat.radius && (lens.orthographic || depth + lens.origin > 0.0) {
        return Coverage(true, depth, relative_distance(sqrt(squared), splat.radius));
    }
    return Coverage(contains(whole, o), splat.depth, 1.0);
}

fn relative_distance(distance: f32, radius: f32) -> f32 {
    return select(1.0, min(distance / radius, 1.0), radius > 0.0);
}

// Depth of a flat splat where the distance from its center over its radius has this square.
fn moved_depth(splat: Splat, squared: f32, lens: Lens) -> f32 {
    if RELIEF == RELIEF_FLAT {
        return splat.depth;
    }
    var w = 1.0 - squared;
    if RELIEF == RELIEF_CONE {
        w = 1.0 - sqrt(squared);
    } else if RELIEF != RELIEF_PARABOLOID {
        w = sqrt(max(w, 0.0));
    }
    let unit = select(splat.depth + lens.origin, 1.0, lens.orthographic) / lens.focal;
    return splat.depth - w * (splat.radius * unit);
}

fn cover(splat: Splat, tilt: Tilt, pixel: vec2<u32>) -> Coverage {
    return cover_from(splat, tilt, whole_to(splat, pixel), pixel, lens_of_view());
}

// The same where the way from the center's pixel is known, and the lens.
fn cover_from(splat: Splat, tilt: Tilt, whole: vec2<f32>, pixel: vec2<u32>, lens: Lens) -> Coverage {
    let offset = offset_of(splat, whole, pixel);
    let in_center = contains(whole, offset);
    if SHAPE == SHAPE_POINT {
        return Coverage(in_center, splat.depth, 1.0);
    }
    if is_gaussian(splat) {
        return cover_gaussian(splat, tilt, offset);
    }
    if may_tilt() && any(tilt.normal.xyz != vec3<f32>(0.0)) {
        return cover_oriented(splat, tilt.normal, whole, pixel, lens);
    }
    if SHAPE == SHAPE_SQUARE {
        let inside = all(abs(offset) <= vec2<f32>(splat.radius));
        // The rim counts where only the center's own pixel is covered.
        let relative = select(1.0, dot(offset, offset) / (splat.radius * splat.radius), inside && splat.radius > 0.0);
        return Coverage(inside || in_center, moved_depth(splat, relative, lens), sqrt(relative));
    }
    let squared = dot(offset, offset);
    let inside = squared <= splat.radius * splat.radius;
    let rho = relative_distance(sqrt(squared), splat.radius);
    return Coverage(inside || in_center, moved_depth(splat, rho * rho, lens), rho);
}
