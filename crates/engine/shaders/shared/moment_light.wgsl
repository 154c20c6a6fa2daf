// The light before each fragment of a pixel, as far as its moments say.
#import twofloat
#import fade
#import moment
#import canonical

// Optical depth of the pixel, and the share of it before its nearest fragment.
var<private> total: f32;
var<private> least: f32;

// E[xᵏ], from the first on, of the distribution toward which moments are moved: its odd ones are 0.
fn toward(k: u32) -> f32 {
    if MOMENTS == 4u {
        return 0.375;
    }
    if MOMENTS == 6u {
        return select(select(0.45, 0.451, k == 4u), 0.48, k == 2u);
    }
    return select(select(select(0.600303, 0.63, k == 6u), 0.676667, k == 4u), 0.75, k == 2u);
}

// Computes all of a pixel's light function that does not depend on the fragment.
fn learn(p: u32) {
    let first = p * STRIDE;
    let sum = known[first];
    // Nothing asks about a pixel without fragments.
    let whole = select(ONE, sum, sum.x > 0.0);
    moments[0] = ONE;
    let rest = add2(ONE, vec2<f32>(-push.estimate.bias, 0.0));
    for (var k = 1u; k <= MOMENTS; k++) {
        let own = multiply2(rest, divide2(known[first + k], whole));
        moments[k] = add2(own, vec2<f32>(select(push.estimate.bias * toward(k), 0.0, k % 2u == 1u), 0.0));
    }
    orthogonalise();
    total = whole.x;
    least = share_before(known[first + MOMENTS + 1u].x);
}

// The share of the optical depth before a place, between its bounds.
fn share_before(place: f32) -> f32 {
    let bounds = bounds_at(place);
    return clamp(bounds.x + push.estimate.overestimation * bounds.y, 0.0, 1.0);
}

// Light over that before the nearest fragment: only its differences count, and none of it is too little for a float.
fn light_before(f: Fragment) -> f32 {
    return exponential(min(total * (least - share_before(place_of(f))), 0.0));
}
