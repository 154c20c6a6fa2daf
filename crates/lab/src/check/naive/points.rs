//! Single points: the pixels that they cover, their depths and weights.

use glam::Vec3;

use crate::check::stage::Dot;

/// Column and row of a dot in the view of [`crate::check::stage::pixels`], in pixels.
fn place(dot: &Dot) -> [f32; 2] {
    [dot.position.x as f32, -dot.position.y as f32]
}

/// True if a disc covers a pixel in the view of [`crate::check::stage::pixels`]: its center is at most one radius away.
pub fn covers(dot: &Dot, [x, y]: [u32; 2]) -> bool {
    let [column, row] = place(dot);
    (column - (x as f32 + 0.5)).hypot(row - (y as f32 + 0.5)) / dot.radius <= 1.0
}

/// A pixel of an opaque disc in that view.
pub fn pixel(dot: &Dot, at: [u32; 2]) -> [f32; 4] {
    if covers(dot, at) { dot.color.extend(1.0).to_array() } else { [0.0; 4] }
}

/// The Gaussian of a disc's falloff at a distance from its center.
pub fn gaussian(distance: f32, radius: f32) -> f32 {
    let rho = distance / radius;
    (-2.0 * rho * rho).exp()
}

/// True if a depth is drawn, judged by its position between near at 0 and far at 1, both excluded.
pub fn is_between(z: f32, near: f32, far: f32) -> bool {
    let place = (z - near) / (far - near);
    place > 0.0 && place < 1.0
}

/// The mean color of opaque dots, up to `depth` behind the nearest, itself excluded, and `tolerance` (relative to its
/// depth) more.
pub fn blended(dots: &[Dot], depth: f32, tolerance: f32) -> [f32; 4] {
    let z = |dot: &Dot| -dot.position.z as f32;
    let nearest = super::nearest(dots);
    let taken = dots.iter().filter(|dot| z(dot) == nearest || z(dot) < nearest + depth + tolerance * nearest);
    let (sum, count) = taken.fold((Vec3::ZERO, 0f32), |(sum, count), dot| (sum + dot.color, count + 1.0));
    (sum / count).extend(1.0).to_array()
}

/// The mean color of weighted blending with the weights 3000 (1 − d)³ α, d from 0 at near to 1 at far; `store` rounds
/// sums to the format of the buffer that keeps them.
pub fn weighted(dots: &[Dot], [near, far]: [f32; 2], store: fn(f32) -> f32) -> [f32; 3] {
    let (mut color, mut weights) = (Vec3::ZERO, 0f32);
    for dot in dots {
        let to_far = 1.0 - (-dot.position.z as f32 - near) / (far - near);
        let weight = 3e3 * to_far.powi(3) * dot.opacity;
        color = (color + weight * dot.color).map(store);
        weights = store(weights + weight);
    }
    (color / weights).to_array()
}

/// The nearest float of 16 bits, ties to even; normal numbers and infinity.
pub fn half(x: f32) -> f32 {
    // Thirteen bits of the mantissa go; adding and taking away 2^13 times the value rounds them.
    let shifted = x * 8193.0;
    let rounded = shifted - (shifted - x);
    if rounded.abs() > 65504.0 { f32::INFINITY.copysign(x) } else { rounded }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halves_have_eleven_bits() {
        assert_eq!([1.0, 1.0 + 1.0 / 1024.0, -0.375, 65504.0].map(half), [1.0, 1.0 + 1.0 / 1024.0, -0.375, 65504.0]);
        assert_eq!([1.0 + 1.0 / 4096.0, 2049.0, 0.1].map(half), [1.0, 2048.0, 0.099_975_586]);
        assert_eq!([65536.0, -1e9].map(half), [f32::INFINITY, f32::NEG_INFINITY]);
    }
}
