// Reaching the splats of fragments while composing: color and opacity by index.
#import elementary
#import any_splat
#import over

override FALLOFF: u32 = 0u;

// Color and opacity of a splat's fragment in a pixel.
fn fragment_color(i: u32, pixel: vec2<u32>) -> vec4<f32> {
    var color = color_at(i);
    if FALLOFF == FALLOFF_GAUSSIAN {
        let rho = cover(splat_at(i), tilt_at(i), pixel, view).rho;
        color.a *= gaussian(rho);
    }
    return color;
}
