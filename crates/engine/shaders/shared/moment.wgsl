// Declarations that the stages share which know a pixel's light by moments. Of each pixel MOMENTS + 1 sums of optical
// depth a times powers of place z, Σ a zᵏ, as sums of two floats: close fragments show in the last digits of the
// moments alone, which float32 would round away (docs/numerics.md). Behind them the place of the nearest fragment. The
// stage binds `known` and has a push constant `estimate`.
struct Estimate {
    // 2 over the logarithm of far over near.
    scale: f32,
    // Where between its bounds the light before a fragment is taken to be, from 0 (most light) to 1.
    overestimation: f32,
    // Share by which moments are moved toward those of a smooth distribution.
    bias: f32,
}

// Elements of `known` of a pixel.
const STRIDE = MOMENTS + 2u;

// Place from -1 at near to 1 at far.
fn place_of(f: Fragment) -> f32 {
    return clamp(push.estimate.scale * log_ratio(view.depth_range.x, seen_depth(f)) - 1.0, -1.0, 1.0);
}
