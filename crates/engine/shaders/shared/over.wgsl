// Front-to-back composition: the running sum.
#import splat

// Which depth a list shows. Without a value that of its first fragment with opacity; SHOWN_MEDIAN: that of the fragment
// at which T first is a half or less; SHOWN_MEAN: the mean of all, each weighted by what it adds to A.
override SHOWN: u32 = 0u;

// Premultiplied color and A = 1 - T of what lies in front, and the depth key of the fragment that shows.
// A is summed as it is, not as one minus a product: a thousand fragments of 1e-7 would round away in the product.
struct Composed {
    rgba: vec4<f32>,
    // By SHOWN_MEAN the bits of the sum of depths times weights.
    key: u32,
}

const NOTHING = 0xffffffffu;

fn behind(front: Composed, key: u32, color: vec4<f32>) -> Composed {
    let weight = (1.0 - front.rgba.a) * color.a;
    let rgba = front.rgba + weight * vec4<f32>(color.rgb, 1.0);
    if SHOWN == SHOWN_MEAN {
        let sum = depth_sum(front.key) + weight * key_depth(key);
        return Composed(rgba, select(front.key, bitcast<u32>(sum), weight > 0.0));
    }
    let counts = select(color.a > 0.0, rgba.a >= 0.5, SHOWN == SHOWN_MEDIAN);
    return Composed(rgba, select(front.key, key, front.key == NOTHING && counts));
}

// Fragments that were composed by themselves, behind those in front of them.
fn run_behind(front: Composed, run: Composed) -> Composed {
    let through = 1.0 - front.rgba.a;
    let rgba = front.rgba + through * run.rgba;
    if SHOWN == SHOWN_MEAN {
        let sum = depth_sum(front.key) + through * depth_sum(run.key);
        return Composed(rgba, select(bitcast<u32>(sum), front.key, run.key == NOTHING));
    }
    return Composed(rgba, select(front.key, run.key, front.key == NOTHING));
}

// The sum of depths times weights in a key by SHOWN_MEAN.
fn depth_sum(key: u32) -> f32 {
    return bitcast<f32>(select(key, 0u, key == NOTHING));
}

// The depth that a composed list shows, +inf for nothing.
fn list_depth(list: Composed) -> f32 {
    if SHOWN == SHOWN_MEAN && list.key != NOTHING {
        return depth_sum(list.key) / list.rgba.a;
    }
    return composed_depth(list.key);
}

// Depth of a key, +inf for nothing.
fn composed_depth(key: u32) -> f32 {
    return bitcast<f32>(select(bitcast<u32>(key_depth(key)), 0x7f800000u, key == NOTHING));
}
