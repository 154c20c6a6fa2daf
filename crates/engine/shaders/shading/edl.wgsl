// shading/edl: how much darker eye-dome lighting makes a pixel, by how far its surface lies behind those around it
// (Boucheny 2009). One invocation per pixel of some rows of the image; `depths` holds these rows and those above and
// below that they look at, as far as there are any. Reference: reference::edl.
#import elementary
#import dispatch

#push

@group(0) @binding(0) var<storage, read> depths: array<f32>;
@group(0) @binding(1) var<storage, read_write> factors: array<f32>;

// Positive depths that are no normal numbers count as this one, and so do those at the eye and behind it.
const LEAST = 1.2e-38;
const INFINITY_BITS = 0x7f800000u;

// Logarithm of depth over that of a neighbor, where this is nearer; 0 outside of the image and where nothing is.
fn behind(depth: f32, x: i32, y: i32) -> f32 {
    if x < 0 || y < 0 || u32(x) >= push.width || u32(y) >= push.rows {
        return 0.0;
    }
    let other = max(depths[u32(y) * push.width + u32(x)], LEAST);
    if other >= depth {
        return 0.0;
    }
    // Finite, however far apart the two are.
    return logarithm(min(depth / other, 3.4e38));
}

#main p {
    if p >= push.count {
        return;
    }
    let place = push.first * push.width + p;
    let depth = max(depths[place], LEAST);
    if bitcast<u32>(depth) == INFINITY_BITS {
        factors[p] = 1.0;
        return;
    }
    let x = i32(place % push.width);
    let y = i32(place / push.width);
    let a = i32(push.straight);
    let b = i32(push.diagonal);
    var sum = behind(depth, x + a, y);
    sum += behind(depth, x + b, y + b);
    sum += behind(depth, x, y + a);
    sum += behind(depth, x - b, y + b);
    sum += behind(depth, x - a, y);
    sum += behind(depth, x - b, y - b);
    sum += behind(depth, x, y - a);
    sum += behind(depth, x + b, y - b);
    // Infinity, if the strength is so large, gives 0 all the same.
    factors[p] = select(exponential(-push.strength * sum), 1.0, sum == 0.0);
}
