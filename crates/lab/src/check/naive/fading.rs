//! Light that fades with depth as published code has it: running sums of float32, roots by formulas.

mod moments;
mod wavelet;

use glam::Vec3;

use crate::check::stage::Dot;

pub use moments::moments;
pub use wavelet::wavelet;

/// −ln(1 − α), at most 10.
fn optical_depth(dot: &Dot) -> f32 {
    (-(1.0 - dot.opacity).ln()).min(10.0)
}

fn depth(dot: &Dot) -> f32 {
    -dot.position.z as f32
}

/// (1 − e^−b) · ΣcαT / ΣαT, with the optical depth b of all.
fn resolved(dots: &[Dot], total: f32, light: impl Fn(&Dot) -> f32) -> [f32; 4] {
    let (mut color, mut weights) = (Vec3::ZERO, 0f32);
    for dot in dots {
        let weight = dot.opacity * light(dot);
        color += weight * dot.color;
        weights += weight;
    }
    let alpha = 1.0 - (-total).exp();
    (alpha * color / weights).extend(alpha).to_array()
}
