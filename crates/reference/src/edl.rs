//! Eye-dome lighting: the factor on each pixel's color, by the depths around it.

use std::f64::consts::TAU;

/// exp(−300 · strength · s) for each pixel of an image of this size: s is the mean of max(0, log₂ z − log₂ z_k) over
/// eight directions, z_k being the depth of the pixel at (round(r cos φ), round(r sin φ)) from this one, φ a multiple
/// of 45°. A pixel outside of the image, or of infinite depth, counts 0; one of infinite depth isn't shaded.
pub fn factors(depths: &[f64], [width, height]: [u32; 2], strength: f64, radius: f64) -> Vec<f64> {
    let at = |x: i64, y: i64| {
        let inside = x >= 0 && y >= 0 && x < i64::from(width) && y < i64::from(height);
        inside.then(|| depths[(y * i64::from(width) + x) as usize])
    };
    let factor = |i: usize| {
        let (x, y) = ((i % width as usize) as i64, (i / width as usize) as i64);
        let z = depths[i];
        if z == f64::INFINITY {
            return 1.0;
        }
        let sum: f64 = (0..8)
            .map(|k| f64::from(k) * TAU / 8.0)
            .filter_map(|angle| {
                at(x + (radius * angle.cos()).round() as i64, y + (radius * angle.sin()).round() as i64)
            })
            .map(|other| (z.log2() - other.log2()).max(0.0))
            .sum();
        (-300.0 * strength * sum / 8.0).exp()
    };
    (0..depths.len()).map(factor).collect()
}
