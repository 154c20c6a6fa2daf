//! Harmonics in turned axes.
//!
//! A color over directions that is turned is one of harmonics of the same degrees. Its coefficients are integrals over
//! the sphere of the turned function times each harmonic; Gauss's rule finds them exactly, since both are polynomials.

use std::f64::consts::PI;

use glam::{DQuat, DVec3, Vec3};

/// Harmonics of degrees 1 to 4.
const COUNT: usize = 24;

/// Heights of directions with their weights: exact up to degree 9.
const HEIGHTS: [[f64; 2]; 5] = [
    [-0.906_179_845_938_664, 0.236_926_885_056_189_08],
    [-0.538_469_310_105_683_1, 0.478_628_670_499_366_47],
    [0.0, 0.568_888_888_888_888_9],
    [0.538_469_310_105_683_1, 0.478_628_670_499_366_47],
    [0.906_179_845_938_664, 0.236_926_885_056_189_08],
];

/// Directions of a height: exact up to degree 8.
const AROUND: u32 = 9;

/// Turns the coefficients of splats.
#[derive(Debug)]
pub(crate) struct Turn {
    /// Each new coefficient as a sum of the old ones.
    rows: [[f64; COUNT]; COUNT],
}

impl Turn {
    pub fn new(rotation: DQuat) -> Self {
        let mut rows = [[0.0; COUNT]; COUNT];
        for [z, weight] in HEIGHTS {
            for step in 0..AROUND {
                let (sin, cos) = (2.0 * PI * f64::from(step) / f64::from(AROUND)).sin_cos();
                let radius = (1.0 - z * z).sqrt();
                let direction = DVec3::new(radius * cos, radius * sin, z);
                let (here, there) = (harmonics(direction), harmonics(rotation.inverse() * direction));
                let weight = weight * 2.0 * PI / f64::from(AROUND);
                for (row, here) in rows.iter_mut().zip(here) {
                    row.iter_mut().zip(there).for_each(|(sum, there)| *sum += weight * here * there);
                }
            }
        }
        Self { rows }
    }

    /// Turns the coefficients of a splat.
    pub fn apply(&self, coefficients: &mut [Vec3]) {
        let old: Vec<_> = coefficients.iter().map(|color| color.as_dvec3()).collect();
        for (new, row) in coefficients.iter_mut().zip(&self.rows) {
            *new = old.iter().zip(row).map(|(old, weight)| *old * *weight).sum::<DVec3>().as_vec3();
        }
    }
}

/// The harmonics of a direction, as Kerbl et al. 2023 order and sign them, and SPZ those of degree 4.
fn harmonics(d: DVec3) -> [f64; COUNT] {
    let (x, y, z) = (d.x, d.y, d.z);
    let (xx, yy, zz) = (x * x, y * y, z * z);
    let one = 0.488_602_511_902_919_9;
    let (two, flat, square) = (1.092_548_430_592_079, 0.315_391_565_252_520_05, 0.546_274_215_296_039_6);
    let (corner, edge, side) = (0.590_043_589_926_643_5, 2.890_611_442_640_554, 0.457_045_799_464_465_8);
    let (four, three) = (2.503_342_941_796_704_6, 1.770_130_769_779_930_4);
    let (belt, near, middle) = (0.946_174_695_757_560_1, 0.669_046_543_557_289_2, 0.105_785_546_915_204_31);
    [
        -one * y,
        one * z,
        -one * x,
        two * x * y,
        -two * y * z,
        flat * (2.0 * zz - xx - yy),
        -two * x * z,
        square * (xx - yy),
        -corner * y * (3.0 * xx - yy),
        edge * x * y * z,
        -side * y * (4.0 * zz - xx - yy),
        0.373_176_332_590_115_4 * z * (2.0 * zz - 3.0 * xx - 3.0 * yy),
        -side * x * (4.0 * zz - xx - yy),
        0.5 * edge * z * (xx - yy),
        -corner * x * (xx - 3.0 * yy),
        four * x * y * (xx - yy),
        -three * y * z * (3.0 * xx - yy),
        belt * x * y * (7.0 * zz - 1.0),
        -near * y * z * (7.0 * zz - 3.0),
        middle * (zz * (35.0 * zz - 30.0) + 3.0),
        -near * x * z * (7.0 * zz - 3.0),
        0.5 * belt * (xx - yy) * (7.0 * zz - 1.0),
        -three * x * z * (xx - 3.0 * yy),
        0.25 * four * (xx * (xx - 3.0 * yy) - yy * (3.0 * xx - yy)),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The turned color in a direction is the color where that direction comes from.
    #[test]
    fn colors_turn_with_the_axes() {
        let old: Vec<Vec3> = (0..COUNT).map(|i| Vec3::new(i as f32, (i * i % 7) as f32, 1.0) - 3.0).collect();
        let color = |coefficients: &[Vec3], direction: DVec3| {
            coefficients.iter().zip(harmonics(direction)).map(|(c, y)| c.as_dvec3() * y).sum::<DVec3>()
        };
        let rotation = DQuat::from_array([0.3, -0.5, 0.1, 0.8]).normalize();
        let turn = Turn::new(rotation);
        for count in [3, 8, 15, COUNT] {
            let mut new = old[..count].to_vec();
            turn.apply(&mut new);
            for direction in [DVec3::X, DVec3::Y, DVec3::new(0.6, -0.64, 0.48)] {
                let off = color(&new, direction).distance(color(&old[..count], rotation.inverse() * direction));
                // Twenty-four coefficients of up to 20 are rounded to float32.
                assert!(off < 1e-5, "{count}: {off}");
            }
        }
        let mut same = old.clone();
        Turn::new(DQuat::IDENTITY).apply(&mut same);
        assert!(same.iter().zip(&old).all(|(a, b)| a.distance(*b) < 1e-5));
    }
}
