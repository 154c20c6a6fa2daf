//! Light that fades with depth as published code has it: running sums of float32, roots by formulas.

use glam::Vec3;
use pellucid_scene::Moments;

use crate::check::stage::Dot;

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

/// The most rows of the Hankel matrix.
const ROWS: usize = 5;

/// A pixel of dots between near and far.
pub fn moments(dots: &[Dot], [near, far]: [f32; 2], settings: &Moments) -> [f32; 4] {
    let count = settings.moments.get() as usize;
    let place = |dot: &Dot| 2.0 * (depth(dot).ln() - near.ln()) / (far.ln() - near.ln()) - 1.0;
    let mut sums = vec![0f32; count + 1];
    for dot in dots {
        let mut term = optical_depth(dot);
        for sum in &mut sums {
            *sum += term;
            term *= place(dot);
        }
    }
    let total = sums[0];
    let biased = |k: usize| (1.0 - settings.bias()) * sums[k] / total + settings.bias() * toward(count, k);
    let b: Vec<f32> = (0..=count).map(|k| if k == 0 { 1.0 } else { biased(k) }).collect();
    resolved(dots, total, |dot| (-total * absorbance(&b, place(dot), settings.overestimation)).exp().clamp(0.0, 1.0))
}

fn toward(count: usize, k: usize) -> f32 {
    match (count, k) {
        (4, 2 | 4) => 0.375,
        (6, 2) => 0.48,
        (6, 4) => 0.451,
        (6, 6) => 0.45,
        (8, 2) => 0.75,
        (8, 4) => 0.676_667,
        (8, 6) => 0.63,
        (8, 8) => 0.600_303,
        _ => 0.0,
    }
}

/// The share before z: that of the polynomial which is β at z, 1 at the roots before it, and 0 at those behind.
fn absorbance(b: &[f32], z: f32, overestimation: f32) -> f32 {
    let degree = b.len() / 2;
    let roots = roots(&solved(b, z));
    let places: Vec<f32> = std::iter::once(z).chain(roots).collect();
    let step = |at: &f32| if *at < z { 1.0 } else { 0.0 };
    let mut f: Vec<f32> = places.iter().map(step).collect();
    f[0] = overestimation;
    for order in 1..=degree {
        for i in (order..=degree).rev() {
            f[i] = (f[i] - f[i - 1]) / (places[i] - places[i - order]);
        }
    }
    // From Newton's form to powers.
    let mut p = [0f32; ROWS];
    for i in (0..=degree).rev() {
        for k in (1..ROWS).rev() {
            p[k] = p[k - 1] - places[i] * p[k];
        }
        p[0] = f[i] - places[i] * p[0];
    }
    p.iter().zip(b).map(|(p, b)| p * b).sum()
}

/// Solves B c = (1, z, z², …) with the Hankel matrix B = L D Lᵀ of the moments.
fn solved(b: &[f32], z: f32) -> Vec<f32> {
    let size = b.len() / 2 + 1;
    let (mut lower, mut pivots) = ([[0f32; ROWS]; ROWS], [0f32; ROWS]);
    let mut c: Vec<f32> = (0..size).map(|i| z.powi(i as i32)).collect();
    for j in 0..size {
        let scaled: Vec<f32> = (0..j).map(|k| lower[j][k] * pivots[k]).collect();
        let known = |row: &[f32; ROWS]| row.iter().zip(&scaled).map(|(l, s)| l * s).sum::<f32>();
        pivots[j] = b[2 * j] - known(&lower[j]);
        for i in j + 1..size {
            lower[i][j] = (b[i + j] - known(&lower[i])) / pivots[j];
        }
        c[j] -= (0..j).map(|k| lower[j][k] * c[k]).sum::<f32>();
    }
    for i in (0..size).rev() {
        let behind: f32 = (i + 1..size).map(|k| lower[k][i] * c[k]).sum();
        c[i] = c[i] / pivots[i] - behind;
    }
    c
}

/// The roots of a polynomial of degree 2 to 4, by its coefficients from the constant on.
fn roots(c: &[f32]) -> Vec<f32> {
    match *c {
        [c0, c1, c2] => quadratic(c1 / c2, c0 / c2).to_vec(),
        [c0, c1, c2, c3] => cubic(c2 / c3, c1 / c3, c0 / c3).to_vec(),
        [c0, c1, c2, c3, c4] => quartic([c3 / c4, c2 / c4, c1 / c4, c0 / c4]),
        _ => Vec::new(),
    }
}

/// x² + px + q.
fn quadratic(p: f32, q: f32) -> [f32; 2] {
    let root = (0.25 * p * p - q).sqrt();
    [-0.5 * p - root, -0.5 * p + root]
}

/// x³ + ax² + bx + c, three real roots, by an angle.
fn cubic(a: f32, b: f32, c: f32) -> [f32; 3] {
    let (a, b) = (a / 3.0, b / 3.0);
    let [x, y, w] = [b - a * a, c - a * b, a * c - b * b];
    let angle = (4.0 * x * w - y * y).sqrt().atan2(2.0 * a * x - y) / 3.0;
    let (sin, cos) = angle.sin_cos();
    let size = 2.0 * (-x).sqrt();
    let half = 0.75f32.sqrt() * sin;
    [size * cos - a, size * (-0.5 * cos - half) - a, size * (-0.5 * cos + half) - a]
}

/// x⁴ + ax³ + bx² + cx + d as two quadratic factors (Ferrari).
fn quartic([a, b, c, d]: [f32; 4]) -> Vec<f32> {
    let [y, ..] = cubic(-b, a * c - 4.0 * d, 4.0 * b * d - a * a * d - c * c);
    let r = (0.25 * a * a - b + y).sqrt();
    let s = (0.25 * a * y - 0.5 * c) / r;
    [quadratic(0.5 * a - r, 0.5 * y - s), quadratic(0.5 * a + r, 0.5 * y + s)].concat()
}

/// A pixel of dots.
pub fn wavelet(dots: &[Dot], rank: u32) -> [f32; 4] {
    let logs: Vec<f32> = dots.iter().map(|dot| depth(dot).ln()).collect();
    let near = logs.iter().copied().fold(f32::INFINITY, f32::min);
    let far = logs.iter().copied().fold(f32::NEG_INFINITY, f32::max);
    let place = |dot: &Dot| (depth(dot).ln() - near) / (far - near);
    let cells = 2usize << rank;
    let mut coefficients = vec![0f32; cells];
    let mut total = 0f32;
    for dot in dots {
        add(&mut coefficients, rank, place(dot), optical_depth(dot));
        total += optical_depth(dot);
    }
    resolved(dots, total, |dot| (-before(&coefficients, rank, place(dot))).exp())
}

/// Cell of a place, and how far it lies in it. No number is in the first.
fn cell_of(cells: usize, place: f32) -> (f32, usize) {
    let squeezed = place * (cells - 1) as f32 / cells as f32;
    (squeezed, (squeezed * cells as f32) as usize)
}

/// The wavelets at a cell, finest first: level, number and sign.
fn wavelets(cell: usize, rank: u32) -> impl Iterator<Item = (u32, usize, f32)> {
    let mut i = cell + (2 << rank) - 1;
    (0..=rank).rev().map(move |level| {
        let sign = if i & 1 == 1 { 1.0 } else { -1.0 };
        i = (i - 1) >> 1;
        (level, i, sign)
    })
}

fn height(level: u32) -> f32 {
    ((1u32 << level) as f32).sqrt()
}

fn add(coefficients: &mut [f32], rank: u32, place: f32, depth: f32) {
    let (d, cell) = cell_of(coefficients.len(), place);
    for (level, j, sign) in wavelets(cell, rank) {
        let width = 1.0 / (1u32 << level) as f32;
        let k = (j + 1) & ((1 << level) - 1);
        let phase = if sign < 0.0 { width } else { 0.0 };
        coefficients[j] += ((d - width * k as f32) * sign + phase) * height(level) * depth;
    }
    if let Some(constant) = coefficients.last_mut() {
        *constant += depth * (1.0 - d);
    }
}

fn value(coefficients: &[f32], rank: u32, cell: usize) -> f32 {
    let details = wavelets(cell, rank).map(|(level, j, sign)| height(level) * coefficients[j] * sign);
    coefficients.last().copied().unwrap_or_default() - details.sum::<f32>()
}

fn before(coefficients: &[f32], rank: u32, place: f32) -> f32 {
    let (squeezed, cell) = cell_of(coefficients.len(), place);
    let last = if cell == 0 { 0.0 } else { value(coefficients, rank, cell - 1) };
    let way = squeezed * coefficients.len() as f32 - cell as f32;
    last + way * (value(coefficients, rank, cell) - last)
}

#[cfg(test)]
mod tests {
    use pellucid_scene::MomentCount;

    use super::*;
    use crate::check::stage::{apart, composed, dot, fragments};

    fn is_close(found: &[f32], wanted: &[f32]) -> bool {
        let mut found = found.to_vec();
        found.sort_by(f32::total_cmp);
        found.len() == wanted.len() && found.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-4)
    }

    #[test]
    fn roots_are_those_of_the_factors() {
        assert!(is_close(&roots(&[-6.0, 1.0, 1.0]), &[-3.0, 2.0]));
        // 2 (x + 1)(x - 1)(x - 2).
        assert!(is_close(&roots(&[4.0, -2.0, -4.0, 2.0]), &[-1.0, 1.0, 2.0]));
        // (x² - 1)(x² - 4).
        assert!(is_close(&roots(&[4.0, 0.0, -5.0, 0.0, 1.0]), &[-2.0, -1.0, 1.0, 2.0]));
        // x (x + 2)(x - 1)(x - 3).
        assert!(is_close(&roots(&[0.0, 6.0, -5.0, -2.0, 1.0]), &[-2.0, 0.0, 1.0, 3.0]));
    }

    /// Compares with float64 where nothing is near singular: there the formulas are right, and cases are about their
    /// roundings.
    #[test]
    fn smooth_distributions_are_as_in_float64() {
        let dots: Vec<Dot> = (0..24).map(|i| dot(1.1f64.powi(i), Vec3::splat(i as f32 / 24.0), 0.2)).collect();
        let (list, colors) = fragments(&dots);
        for moments in MomentCount::ALL {
            let settings = Moments { moments, ..Moments::default() };
            let wanted = pellucid_reference::moments::moments(&list, &colors, [1.0, 10.0], &settings);
            let found = super::moments(&dots, [1.0, 10.0], &settings);
            assert!((f64::from(found[0]) - wanted.color.x).abs() < 2e-3, "{moments:?}: {found:?} {wanted:?}");
            assert!((f64::from(found[3]) - wanted.alpha).abs() < 1e-5, "{moments:?}: {found:?} {wanted:?}");
        }
    }

    /// Compares at the edges of cells that lie far apart: there the formulas are exact, and cases are about their
    /// roundings.
    #[test]
    fn edges_of_cells_are_exact() {
        for rank in 1..=3 {
            let last = (2 << rank) - 1;
            let at = |i: i32| dot(2f64.powi(i), Vec3::new((i % 3) as f32, (i % 2) as f32, 0.5), 0.3);
            let dots: Vec<Dot> = (0..=last).map(at).collect();
            let off = apart(&wavelet(&dots, rank), &composed(&dots));
            assert!(off < 1e-4, "rank {rank}: {off}");
        }
    }
}
