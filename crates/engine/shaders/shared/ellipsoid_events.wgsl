// Events along a ray: it enters an ellipsoid, leaves it, or meets a surface. The densities of the ellipsoids that are
// open add up (Mai et al. 2025, "EVER"), and each gives of its color as much as of the density.
#import compose
#import ellipsoid
#import open_sums
#import run_sums

struct Event {
    // A sum of two floats.
    depth: vec2<f32>,
    // Of a surface color and opacity; of an ellipsoid color times density, and density per unit of length.
    color: vec4<f32>,
    surface: bool,
}

fn event_at(fragment: vec2<u32>, pixel: vec2<u32>, ray: vec4<f32>) -> Event {
    let depth = key_depth(fragment.x);
    let i = event_splat(fragment.y);
    let splat = splat_at(i);
    if !is_gaussian(splat) {
        return Event(vec2<f32>(depth, 0.0), fragment_color(i, pixel), true);
    }
    let tilt = tilt_at(i);
    let color = color_at(i);
    if tilt.rest.x == BODY_FLAT {
        return Event(vec2<f32>(depth, 0.0), color, true);
    }
    if tilt.rest.x == BODY_OPAQUE {
        return Event(vec2<f32>(depth, 0.0), vec4<f32>(color.rgb, 1.0), true);
    }
    let chord = chord_of(splat, tilt, pixel);
    if met_of(chord, tilt).events == 1u {
        let opacity = opacity_of(color.a * (2.0 * chord.half * ray.w));
        return Event(vec2<f32>(depth, 0.0), vec4<f32>(color.rgb, opacity), true);
    }
    let rest = rest_of(chord.middle, chord.half, is_exit(fragment.y), depth);
    return Event(vec2<f32>(depth, rest), color.a * vec4<f32>(color.rgb, 1.0), false);
}

fn terms_of(event: Event) -> Terms {
    return Terms(event.color, 0.0, 0.0);
}

// A piece of a ray between two events: color and opacity, optical depth, and what it goes through along the axis.
struct Segment {
    color: vec4<f32>,
    depth: f32,
    length: f32,
}

fn between(open: Sums, first: vec2<f32>, last: vec2<f32>, ray: vec4<f32>) -> Segment {
    let length = max((last.x - first.x) + (last.y - first.y), 0.0);
    let depth = max(open.high.a + open.low.a, 0.0) * (length * ray.w);
    return Segment(segment_color(open, depth), depth, length);
}

// Where on a ray the next event is, and what is open there.
struct Walk {
    open: Sums,
    event: Event,
}

// An event: the surface that it is, if it is one, and the segment that it begins.
struct Step {
    surface: vec4<f32>,
    segment: Segment,
}

// Goes from a fragment's event to the next one. Behind the last event nothing is open.
fn step_on(walk: ptr<function, Walk>, fragment: vec2<u32>, next: vec2<u32>, pixel: vec2<u32>, ray: vec4<f32>) -> Step {
    let event = (*walk).event;
    if !event.surface {
        (*walk).open = after_event((*walk).open, terms_of(event), is_exit(fragment.y));
    }
    (*walk).event = event_at(next, pixel, ray);
    let segment = between((*walk).open, event.depth, (*walk).event.depth, ray);
    return Step(select(vec4<f32>(0.0), event.color, event.surface), segment);
}

// The sums before a run.
fn open_before(before: RunSums, run: u32) -> Sums {
    if run == 0u {
        return no_sums();
    }
    return Sums(before.high, before.low, before.rest.xy, before.rest.z);
}
