// How opacity falls over the pixels of a splat.
#import coverage
#import elementary
#import splat

override FALLOFF: u32 = 0u;

// Opacity of a fragment of a splat, given the splat's own and what its coverage says of the distance.
fn fallen(splat: Splat, opacity: f32, rho: f32) -> f32 {
    if is_gaussian(splat) {
        return gaussian_opacity(opacity, rho);
    }
    if FALLOFF == FALLOFF_GAUSSIAN {
        return opacity * gaussian(rho);
    }
    return opacity;
}
