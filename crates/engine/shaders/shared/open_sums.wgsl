// Sums over what is open along a ray: what begins before a place and ends behind it.
#import optical_depth

struct Terms {
    // Color times weight, and weight.
    color: vec4<f32>,
    // Optical depth of a unit of length, and what rounding took from the event's depth; concentric shells only.
    density: f32,
    rest: f32,
}

// Running sums of what is open, as sums of two floats: what was added can be taken away again.
struct Sums {
    high: vec4<f32>,
    low: vec4<f32>,
    density: vec2<f32>,
    open: f32,
}

fn no_sums() -> Sums {
    return Sums(vec4<f32>(0.0), vec4<f32>(0.0), vec2<f32>(0.0), 0.0);
}

fn plus_terms(sums: Sums, terms: Terms, sign: f32) -> Sums {
    let b = sign * terms.color;
    let s = sums.high + b;
    let bb = s - sums.high;
    let rest = (sums.high - (s - bb)) + (b - bb);
    let c = sign * terms.density;
    let t = sums.density.x + c;
    let cc = t - sums.density.x;
    let left = (sums.density.x - (t - cc)) + (c - cc);
    return Sums(s, sums.low + rest, vec2<f32>(t, sums.density.y + left), sums.open + sign);
}

// The sums after an event: nothing open leaves nothing.
fn after_event(sums: Sums, terms: Terms, exit: bool) -> Sums {
    let next = plus_terms(sums, terms, select(1.0, -1.0, exit));
    if next.open == 0.0 {
        return no_sums();
    }
    return next;
}

// Color of a segment by Eq. 11, and its opacity.
fn segment_color(sums: Sums, depth: f32) -> vec4<f32> {
    let color = sums.high + sums.low;
    let mean = select(vec3<f32>(0.0), color.rgb / color.a, color.a > 0.0);
    return vec4<f32>(mean, select(0.0, opacity_of(depth), sums.open > 0.0));
}
