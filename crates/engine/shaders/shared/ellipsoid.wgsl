// An ellipsoid of constant density and the ray through a pixel's center. The stage has `view`.
#import body
#import pixel_ray

// Where a ray is within an ellipsoid: middle and half length as depths along the axis.
struct Chord {
    meets: bool,
    middle: f32,
    half: f32,
}

// With the names of shared/gaussian.wgsl and B = w^2 + t^2 |v|^2 the chord's middle is at the depth z w / B, and half
// of it goes through the depth z t sqrt(1 - rho^2) / sqrt(B). Both are found as parts of z, relative to the center:
// small ellipsoids may be far.
fn chord_of(splat: Splat, tilt: Tilt, pixel: vec2<u32>) -> Chord {
    let d = offset_of(splat, whole_to(splat, pixel), pixel);
    let v = vec2<f32>(tilt.normal.x * d.x, tilt.normal.y * d.x - splat.radius * d.y);
    let squared = dot(v, v);
    let along = v.x * tilt.rest.y + v.y * tilt.rest.z;
    let steep = abs(tilt.rest.w);
    if view.orthographic != 0u {
        return Chord(squared <= 1.0, splat.depth + along, steep * sqrt(max(1.0 - squared, 0.0)));
    }
    let z = tilt.normal.w;
    let w = 1.0 - along;
    let across = (steep * steep) * squared;
    let below = w * w + across;
    let middle = splat.depth + z * ((w * along - across) / below);
    return Chord(squared <= below, middle, z * (steep * sqrt(max(below - squared, 0.0)) / below));
}

// Events of a splat on a pixel's ray, with their depths: none, one on a surface, or two where the ray enters and
// leaves. The part in front of the near plane is cut off.
struct Met {
    events: u32,
    entry: f32,
    exit: f32,
}

fn met_by(splat: Splat, tilt: Tilt, pixel: vec2<u32>) -> Met {
    if !is_gaussian(splat) {
        let coverage = cover(splat, tilt, pixel);
        return Met(u32(coverage.hit), coverage.depth, coverage.depth);
    }
    return met_of(chord_of(splat, tilt, pixel), tilt);
}

fn met_of(chord: Chord, tilt: Tilt) -> Met {
    let near = view.eye_lo.w;
    let entry = max(chord.middle - chord.half, near);
    let exit = chord.middle + chord.half;
    // Of a flat one the two are the same; false for NaN.
    if !chord.meets || !(exit >= near) {
        return Met(0u, 0.0, 0.0);
    }
    // A body too thin for two depths is a surface.
    return Met(select(1u, 2u, tilt.rest.x == BODY_DENSE && entry < exit), entry, exit);
}

// The second word of an event: splat and exit. An entry comes before its exit.
fn event_id(splat: u32, exit: u32) -> u32 {
    return (splat << 1u) | exit;
}

fn event_splat(id: u32) -> u32 {
    return id >> 1u;
}

fn is_exit(id: u32) -> bool {
    return (id & 1u) != 0u;
}
