// Events along a ray: it enters an ellipsoid, leaves it, or meets a surface. The densities of the ellipsoids that are open add up (Mai et al. 2025,
// "EVER"), and each gives of its color as much as of the density.
#import compose
#import ellipsoid
#import open_sums

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

// Color and opacity between two depths.
fn between(open: Sums, first: vec2<f32>, last: vec2<f32>, ray: vec4<f32>) -> vec4<f32> {
    let length = max((last.x - first.x) + (last.y - first.y), 0.0);
    return segment_color(open, max(open.high.a + open.low.a, 0.0) * (length * ray.w));
}
