// When fragments behind can be left out.
#import over

// STOP_NEVER: nothing is left out; STOP_EXACT: only what changes no bit; STOP_SRGB: what changes no 8-bit sRGB value by
// more than a quarter step; STOP_ENCODED: the same for values blended as they are.
override STOP: u32 = 1u;

// True if fragments behind cannot change a pixel's output, given the largest opacity and the largest color component,
// background included, that may still come.
fn done(sum: Composed, max_opacity: f32, max_color: f32) -> bool {
    if STOP == STOP_NEVER {
        return false;
    }
    if STOP == STOP_EXACT {
        let most = (1.0 - sum.rgba.a) * max_opacity;
        return all(sum.rgba + most * vec4<f32>(vec3<f32>(max_color), 1.0) == sum.rgba);
    }
    // A quarter of 1/255. The sRGB curve's slope at c is at most 12.92, and 0.711 / sqrt(c) beyond its linear part.
    const QUARTER = 1.0 / 1020.0;
    let rest = (1.0 - sum.rgba.a) * max_color;
    if STOP == STOP_SRGB {
        let least = min(sum.rgba.r, min(sum.rgba.g, sum.rgba.b));
        return rest * 12.92 < QUARTER || (rest * rest * (0.711 * 0.711) < QUARTER * QUARTER * least && least > 0.0031309);
    }
    return rest < QUARTER;
}
