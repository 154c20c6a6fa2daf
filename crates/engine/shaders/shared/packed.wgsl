// Events of soft spheres in the paper's 16 bytes (Seemann et al., Section 4): color and 255 d / r, of 8 bits each;
// depth along the axis, negative for an exit; radius; depth of the middle of the chord. The stage has `records`, one
// for each slot.
#import sphere

fn pack_record(chord: Chord, radius: f32, color: vec3<f32>, depth: f32) -> vec4<u32> {
    let bytes = vec4<u32>(clamp(vec4<f32>(color, 1.0 - chord.edge), vec4<f32>(0.0), vec4<f32>(1.0)) * 255.0 + 0.5);
    let rgbd = bytes.x | (bytes.y << 8u) | (bytes.z << 16u) | (bytes.w << 24u);
    return vec4<u32>(rgbd, bitcast<u32>(depth), bitcast<u32>(radius), bitcast<u32>(chord.middle + depth_origin()));
}

// Depth of an event, relative to the origin.
fn packed_depth(record: vec4<u32>) -> f32 {
    return abs(bitcast<f32>(record.y)) - depth_origin();
}

fn packed_radius(record: vec4<u32>) -> f32 {
    return bitcast<f32>(record.z);
}

fn packed_chord(record: vec4<u32>, ray: vec4<f32>) -> Chord {
    let edge = f32(255u - (record.x >> 24u)) / 255.0;
    return Chord(edge, bitcast<f32>(record.w) - depth_origin(), packed_radius(record) / ray.w);
}

// Color times weight and weight as whole numbers: their sums are exact, in whatever order events came.
fn packed_terms(record: vec4<u32>) -> vec4<f32> {
    let bytes = (vec4<u32>(record.x) >> vec4<u32>(0u, 8u, 16u, 24u)) & vec4<u32>(0xffu);
    let weight = 255u - bytes.w;
    return vec4<f32>(weight * vec4<u32>(bytes.xyz, 255u));
}

// Optical depths as whole numbers of this, for the same reason. Sums end at 31, behind which nothing is seen.
const DEPTH_UNIT = 1.4901161e-8;
const MOST_UNITS = 2080374784u;

fn units_of(depth: f32) -> u32 {
    return u32(min(depth, 31.0) * 67108864.0 + 0.5);
}

fn plus_units(a: u32, b: u32) -> u32 {
    return min(a + b, MOST_UNITS);
}
