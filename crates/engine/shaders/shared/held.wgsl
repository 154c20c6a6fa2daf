// Contents of the multisampled attachments for a sample: depth and index of its nearest fragment, both as normal
// floats, whose bits no driver changes and whose order is that of the integers.
#import splat

// 2^-126 and the largest float below 1, where empty samples lie.
const LEAST_DEPTH = 0x00800000u;
const MOST_DEPTH = 0x3f7fffffu;

// Depth keys from `base` on in steps of 2^shift, as a depth for the test; the rest at the ends. A key has more bits
// than there are depths: the host chooses the two so that none is lost where depths are positive.
fn held_depth(key: u32, base: u32, shift: u32) -> f32 {
    let steps = (max(key, base) - base) >> shift;
    return bitcast<f32>(min(steps, MOST_DEPTH - LEAST_DEPTH) + LEAST_DEPTH);
}

// The depth of a sample, +inf for an empty one.
fn depth_of_held(held: f32, base: u32, shift: u32) -> f32 {
    let bits = bitcast<u32>(held);
    let key = ((max(bits, LEAST_DEPTH) - LEAST_DEPTH) << shift) + base;
    return bitcast<f32>(select(bitcast<u32>(key_depth(key)), 0x7f800000u, bits > MOST_DEPTH));
}

// An index as a float; empty samples hold the largest float instead.
fn held_index(index: u32) -> f32 {
    return bitcast<f32>(index + LEAST_DEPTH);
}
