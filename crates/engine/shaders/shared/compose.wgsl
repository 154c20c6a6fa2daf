// Reaching the splats of fragments while composing: color and opacity by index.
#import elementary
#import any_splat
#import falloff
#import over

// Color and opacity of a splat's fragment in a pixel.
fn fragment_color(i: u32, pixel: vec2<u32>) -> vec4<f32> {
    var color = color_at(i);
    if FALLOFF == FALLOFF_GAUSSIAN || has_gaussians() {
        let splat = splat_at(i);
        color.a = fallen(splat, color.a, cover(splat, tilt_at(i), pixel).rho);
    }
    return color;
}

// The key of the depth that a fragment shows, given that by which it is ordered.
fn shown_key(key: u32, i: u32) -> u32 {
    if !has_gaussians() || view.order != ORDER_DISTANCE {
        return key;
    }
    return depth_key(shown_depth(splat_at(i), tilt_at(i), key_depth(key)));
}
