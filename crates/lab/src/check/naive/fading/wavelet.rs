//! Transparency by wavelets after Aizenshtein et al. (2022).

use super::{depth, optical_depth, resolved};
use crate::check::stage::Dot;

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
    use glam::Vec3;

    use super::*;
    use crate::check::stage::{apart, composed, dot};

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
