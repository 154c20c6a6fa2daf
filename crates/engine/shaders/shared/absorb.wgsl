// Optical depths of soft spheres, in units of their radius, and what follows from them.
#import optical_depth

// Integral of ρ / r = 1 - sqrt(x² + δ²) from x0 to x1 (Seemann et al., Eq. 5 and 6), x from the middle of the chord;
// both within the chord. `edge` = 1 - δ. Where the integrand is smooth on the piece, a Gauss-Legendre rule; else the
// antiderivative with differences of roots as quotients and one logarithm. Relative error about 1e-5 or less, except
// for thin segments at the very rim, where x itself is not known so well.
fn integral(edge: f32, x0: f32, x1: f32) -> f32 {
    // Mirrored so that the farther end is positive.
    let mirrored = x0 + x1 < 0.0;
    let a = select(x0, -x1, mirrored);
    let b = select(x1, -x0, mirrored);
    let width = b - a;
    let squared = (1.0 - edge) * (1.0 - edge);
    let near = max(a, 0.0);
    // The roots of x² + δ² lie at ± δ i: far enough for five points.
    if near * near + squared >= 0.5625 * width * width {
        let half = sqrt(edge * (2.0 - edge));
        let middle = 0.5 * (a + b);
        let inner = 0.26923466 * width;
        let outer = 0.45308992 * width;
        let s = 0.28444445 * density(middle, half, squared)
            + 0.23931433 * (density(middle - inner, half, squared) + density(middle + inner, half, squared))
            + 0.11846344 * (density(middle - outer, half, squared) + density(middle + outer, half, squared));
        return width * s;
    }
    let root_a = sqrt(a * a + squared);
    let root_b = sqrt(b * b + squared);
    // a + root_a; squared over something tiny has the limit 0.
    let low = select(a + root_a, squared / (root_a - a), a < 0.0);
    let area = width * (root_b + a * (b + a) / (root_b + root_a));
    return max(width - 0.5 * area - 0.5 * squared * logarithm((b + root_b) / max(low, 1e-30)), 0.0);
}

fn density(x: f32, half: f32, squared: f32) -> f32 {
    return max((half - x) * (half + x), 0.0) / (1.0 + sqrt(x * x + squared));
}

// Optical depth of a whole chord under modulation (Eq. 22): `plain` is the model's, `peak` the opacity that stands for
// λ.
fn modulated(plain: f32, edge: f32, peak: f32, w: f32) -> f32 {
    let opacity = peak * edge * (1.0 - w) + opacity_of(plain) * w;
    let transmittance = (1.0 - peak * edge) * (1.0 - w) + exponential(-plain) * w;
    return depth_of(opacity, transmittance);
}
