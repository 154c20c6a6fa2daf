// Front-to-back composition: the running sum.
#import splat

// 1: the key is that of the fragment at which T first is a half or less, instead of the first with opacity.
override MEDIAN: u32 = 0u;

// Premultiplied color and A = 1 - T of what lies in front, and the depth key of its first fragment with opacity.
// A is summed as it is, not as one minus a product: a thousand fragments of 1e-7 would round away in the product.
struct Composed {
    rgba: vec4<f32>,
    key: u32,
}

const NOTHING = 0xffffffffu;

fn behind(front: Composed, key: u32, color: vec4<f32>) -> Composed {
    let weight = (1.0 - front.rgba.a) * color.a;
    let rgba = front.rgba + weight * vec4<f32>(color.rgb, 1.0);
    let counts = select(color.a > 0.0, rgba.a >= 0.5, MEDIAN == 1u);
    return Composed(rgba, select(front.key, key, front.key == NOTHING && counts));
}

// Depth of a key, +inf for nothing.
fn composed_depth(key: u32) -> f32 {
    return bitcast<f32>(select(bitcast<u32>(key_depth(key)), 0x7f800000u, key == NOTHING));
}
