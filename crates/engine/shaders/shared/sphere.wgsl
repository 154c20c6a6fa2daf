// A soft sphere and the ray through a pixel's center. Everything is relative to the sphere's center, so that nothing
// cancels. The stage has `view`. A splat's radius is here in world units, as SHAPE_SPHERE asks for, and depths are
// relative to depth_origin(), so that neither far spheres that overlap nor thin segments between them lose digits.
#import pixel_ray

// MODEL_BASE: a sphere whose density falls off; MODEL_CONCENTRIC: shells of constant density, as many as the view says.
override MODEL: u32 = 0u;
// 1: events carry what the paper stores of them, and a fragment's second word is their slot.
override PACKED: u32 = 0u;
// Smaller radii are none.
const LEAST_RADIUS = 1e-30;

struct Chord {
    // 1 - d / r for the ray's distance d from the center: 1 through it, 0 at the rim, negative beside the sphere.
    edge: f32,
    // Depth along the axis where the ray is nearest to the center.
    middle: f32,
    // The radius along the ray, as depth along the axis.
    reach: f32,
}

fn chord_of(splat: Splat, tilt: Tilt, pixel: vec2<u32>, ray: vec4<f32>) -> Chord {
    if SHAPE == SHAPE_EXACT_SPHERE {
        return exact_chord(splat, tilt.normal, pixel, ray);
    }
    let unit = select(splat.depth + depth_origin(), 1.0, view.orthographic != 0u) / view.focal.x;
    let from_center = vec3<f32>(offset_of(splat, whole_to(splat, pixel), pixel) * unit, 0.0);
    let distance = length3(cross3(from_center, ray.xyz));
    let middle = splat.depth - dot3(from_center, ray.xyz) / ray.w;
    let edge = (splat.radius - distance) / splat.radius;
    // False for NaN too.
    let meets = edge > 0.0 && splat.radius > LEAST_RADIUS;
    return Chord(select(-1.0, edge, meets), middle, splat.radius / ray.w);
}

// The same where a sphere is so dense that it is opaque unless a ray passes within 10^-4 of its rim: what float32 knows
// of the distance is no more than a few thousandths of that.
fn exact_chord(splat: Splat, low: vec4<f32>, pixel: vec2<u32>, ray: vec4<f32>) -> Chord {
    let whole = vec2<f32>(vec2<i32>(pixel) - center_pixel(splat)) + sample_in(pixel);
    let x = add2(vec2<f32>(whole.x, 0.0), -vec2<f32>(splat.fraction_x, low.x));
    let y = add2(vec2<f32>(whole.y, 0.0), -vec2<f32>(splat.fraction_y, low.y));
    var depth = vec2<f32>(1.0, 0.0);
    var slopes = array<vec2<f32>, 2>(vec2<f32>(0.0), vec2<f32>(0.0));
    if view.orthographic == 0u {
        depth = add2(vec2<f32>(splat.depth, low.z), vec2<f32>(depth_origin(), 0.0));
        let from_middle = vec2<f32>(pixel) + sample_in(pixel) - middle_of_image();
        slopes[0] = divide2(vec2<f32>(from_middle.x, 0.0), view.focal);
        slopes[1] = divide2(vec2<f32>(from_middle.y, 0.0), view.focal);
    }
    let unit = divide2(depth, view.focal);
    // From the center to where the ray crosses its depth, and the ray's direction: ray × offset over the ray's length.
    let a = multiply2(x, unit);
    let b = multiply2(y, unit);
    let turn = add2(multiply2(a, slopes[1]), -multiply2(b, slopes[0]));
    let stretched = add2(vec2<f32>(1.0, 0.0), add2(square2(slopes[0]), square2(slopes[1])));
    let squared = divide2(add2(square2(turn), add2(square2(a), square2(b))), stretched);
    // 1 - d / r = (r² - d²) / (r (r + d)).
    let gap = add2(two_product(splat.radius, splat.radius), -squared).x;
    let edge = gap / (splat.radius * (splat.radius + sqrt(max(squared.x, 0.0))));
    let along = divide2(add2(multiply2(a, slopes[0]), multiply2(b, slopes[1])), stretched);
    let middle = add2(vec2<f32>(splat.depth, low.z), -along).x;
    let meets = edge > 0.0 && splat.radius > LEAST_RADIUS;
    return Chord(select(-1.0, edge, meets), middle, splat.radius / ray.w);
}

fn square2(x: vec2<f32>) -> vec2<f32> {
    return multiply2(x, x);
}

// Half of the chord of shell `place` = i / N, over the radius: sqrt((r_i - d)(r_i + d)) / r.
fn half_chord(edge: f32, place: f32) -> f32 {
    return sqrt(max(edge - place, 0.0) * (2.0 - edge - place));
}

// N of Seemann et al., Section 3.2.
fn shells_of(splat: Splat) -> u32 {
    let most = most_shells();
    if most == 1u || view.down.w == 0.0 {
        return most;
    }
    let pixels = splat.radius * view.focal.x / select(splat.depth + depth_origin(), 1.0, view.orthographic != 0u);
    return u32(clamp(ceil(pixels / view.down.w), 1.0, f32(most)));
}

fn most_shells() -> u32 {
    if MODEL == MODEL_BASE {
        return 1u;
    }
    return u32(view.right.w);
}

// Bits of a shell's number in a fragment's second word, above the bit that tells its exit from its entry.
fn shell_bits() -> u32 {
    return 32u - countLeadingZeros(most_shells() - 1u);
}

// How many of a sphere's shells the ray meets between two depths, from the outermost on; 0 if it misses the sphere
// there.
fn shells_met(chord: Chord, shells: u32, near: f32, far: f32) -> u32 {
    let half = chord.reach * half_chord(chord.edge, 0.0);
    if !(chord.edge > 0.0 && chord.middle + half > near && chord.middle - half < far) {
        return 0u;
    }
    // The point nearest to the center between the depths decides.
    let beside = max(max(near - chord.middle, chord.middle - far), 0.0) / chord.reach;
    let across = 1.0 - chord.edge;
    let edge = select(chord.edge, 1.0 - sqrt(across * across + beside * beside), beside > 0.0);
    return u32(clamp(ceil(edge * f32(shells)), 1.0, f32(shells)));
}

// The second word of an event: splat, shell, exit. Their order is any, but an entry comes before its exit.
fn event_id(splat: u32, shell: u32, exit: u32) -> u32 {
    return (splat << (shell_bits() + 1u)) | (shell << 1u) | exit;
}

fn event_splat(id: u32) -> u32 {
    return id >> (shell_bits() + 1u);
}

fn event_shell(id: u32) -> u32 {
    return (id >> 1u) & ((1u << shell_bits()) - 1u);
}

fn is_exit(id: u32) -> bool {
    return (id & 1u) != 0u;
}
