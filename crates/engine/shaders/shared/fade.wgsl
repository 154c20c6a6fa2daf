// How much light a fragment takes, and where it lies: for stages that know of each pixel how its light fades with
// depth.
#import elementary

// Most optical depth of a fragment: that of an opaque one.
const MOST_DEPTH = 10.0;

// -ln(1 - α), at most MOST_DEPTH; α in [0, 1].
fn optical_depth(alpha: f32) -> f32 {
    // -ln(1 - α) α / (1 - (1 - α)): the rounding of 1 - α falls out. e^-10 is more than 4.5e-5.
    let rest = max(1.0 - alpha, 4.5e-5);
    let depth = -logarithm(rest) * (alpha / (1.0 - rest));
    return select(min(depth, MOST_DEPTH), alpha, rest == 1.0);
}

// ln(b / a) for 0 < a <= b, as precise where they are close to each other.
fn log_ratio(a: f32, b: f32) -> f32 {
    let x = (b - a) / a;
    let whole = 1.0 + x;
    // ln(1 + x) x / ((1 + x) - 1): the rounding of 1 + x falls out.
    return select(logarithm(whole) * (x / (whole - 1.0)), x, whole == 1.0);
}

// The depth that a fragment shows, between near and far.
fn seen_depth(f: Fragment) -> f32 {
    return clamp(key_depth(f.shown_key), view.depth_range.x, view.depth_range.y);
}
