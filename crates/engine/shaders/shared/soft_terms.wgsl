// Terms that an event adds to the running sums along a ray, or takes from them (Seemann et al., Eq. 11, 13, 15). The
// stage has `push`.
#import compose
#import sphere
#import absorb
#import open_sums
#import packed

// 1: some points are modulated (Eq. 22).
override MODULATED: u32 = 0u;

// Optical depth of a sphere for a unit of its integral over the squared radius.
fn absorption(chord: Chord, radius: f32, w: f32) -> f32 {
    let plain = min(push.lambda * radius * radius, MOST_DEPTH);
    if MODULATED == 0u {
        return plain;
    }
    let half = half_chord(chord.edge, 0.0);
    let whole = max(integral(chord.edge, -half, half), 1e-30);
    let wanted = modulated(plain * whole, chord.edge, push.peak, w);
    return select(plain, min(wanted / whole, MOST_DEPTH), w < 1.0);
}

// μ' of a shell: r / (N r_i) (1 - d / r_i), with r_i / r = 1 - place. Not equalized, μ: r / (N r_i) wherever the ray
// meets it.
fn shell_density(edge: f32, place: f32, shells: f32) -> f32 {
    let radius = 1.0 - place;
    if push.equalize == 0u {
        return select(0.0, 1.0 / (shells * radius), edge > place);
    }
    return max(edge - place, 0.0) / (shells * radius * radius);
}

// Optical depth for a unit of a shell's density, as above, and of length.
fn shell_absorption(chord: Chord, shells: u32, radius: f32, w: f32) -> f32 {
    let plain = min(push.lambda, MOST_DEPTH);
    if MODULATED == 0u {
        return plain;
    }
    var whole = 0.0;
    for (var shell = 0u; shell < shells; shell++) {
        let place = f32(shell) / f32(shells);
        whole += 2.0 * half_chord(chord.edge, place) * shell_density(chord.edge, place, f32(shells));
    }
    whole = max(whole * radius, 1e-30);
    let wanted = modulated(min(plain * whole, MOST_DEPTH), chord.edge, push.peak, w);
    return select(plain, min(wanted / whole, MOST_DEPTH), w < 1.0);
}

// A sphere of the base model: edge, middle, reach and absorption; color times weight, and weight.
struct Opened {
    sphere: vec4<f32>,
    terms: vec4<f32>,
}

// The sphere that an event's index, or its slot if it is packed, tells of.
fn opened(id: u32, pixel: vec2<u32>, ray: vec4<f32>) -> Opened {
    if PACKED != 0u {
        let record = records[id];
        let chord = packed_chord(record, ray);
        let absorbed = absorption(chord, packed_radius(record), 1.0);
        return Opened(vec4<f32>(chord.edge, chord.middle, chord.reach, absorbed), packed_terms(record));
    }
    let i = event_splat(id);
    let splat = splat_at(i);
    let color = color_at(i);
    let chord = chord_of(splat, tilt_at(i), pixel, ray);
    let absorbed = absorption(chord, splat.radius, color.a);
    return Opened(vec4<f32>(chord.edge, chord.middle, chord.reach, absorbed), chord.edge * vec4<f32>(color.rgb, 1.0));
}

// Depth of an event, relative to the origin.
fn event_depth(event: vec2<u32>) -> f32 {
    if PACKED != 0u {
        return packed_depth(records[event.y]);
    }
    return key_depth(event.x);
}

fn terms_of(event: vec2<u32>, pixel: vec2<u32>, ray: vec4<f32>) -> Terms {
    let id = event.y;
    if PACKED != 0u {
        return Terms(packed_terms(records[id]), 0.0, 0.0);
    }
    let i = event_splat(id);
    let splat = splat_at(i);
    let color = color_at(i);
    let chord = chord_of(splat, tilt_at(i), pixel, ray);
    if MODEL == MODEL_BASE {
        return Terms(chord.edge * vec4<f32>(color.rgb, 1.0), 0.0, 0.0);
    }
    let shells = shells_of(splat);
    let place = f32(event_shell(id)) / f32(shells);
    let weight = max(chord.edge - place, 0.0) / (1.0 - place);
    let density = shell_absorption(chord, shells, splat.radius, color.a) * shell_density(chord.edge, place, f32(shells));
    let half = chord.reach * half_chord(chord.edge, place);
    let rest = rest_of(chord.middle, half, is_exit(id), key_depth(event.x));
    return Terms(weight * vec4<f32>(color.rgb, 1.0), density, rest);
}

// Optical depth of a segment of concentric shells, between two depths that are sums of two floats.
fn segment_depth(sums: Sums, first: vec2<f32>, last: vec2<f32>, ray: vec4<f32>) -> f32 {
    let length = max((last.x - first.x) + (last.y - first.y), 0.0);
    return max(sums.density.x + sums.density.y, 0.0) * (length * ray.w);
}
