// Opacities from optical depths, and the other way.
#import elementary

// At most: more is as opaque, and products with it stay finite.
const MOST_DEPTH = 1e30;

// 1 - exp(-x) for x >= 0, as precise for small x.
fn opacity_of(depth: f32) -> f32 {
    let x = min(depth, 1.0);
    let series = x * (1.0 - x / 2.0 * (1.0 - x / 3.0 * (1.0 - x / 4.0 * (1.0 - x / 5.0 * (1.0 - x / 6.0 * (1.0 - x / 7.0
        * (1.0 - x / 8.0 * (1.0 - x / 9.0))))))));
    return select(1.0 - exponential(-depth), series, depth < 0.5);
}

// The inverse, from the opacity and from the transmittance, each precise where the other is not.
fn depth_of(opacity: f32, transmittance: f32) -> f32 {
    // -ln(1 - x) x / (1 - (1 - x)): the rounding of 1 - x falls out.
    let rest = 1.0 - opacity;
    let small = select(-logarithm(rest) * (opacity / (1.0 - rest)), opacity, rest == 1.0);
    let large = select(-logarithm(transmittance), MOST_DEPTH, transmittance < 1e-37);
    return select(large, small, opacity < 0.5);
}
