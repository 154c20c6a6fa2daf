//! The normal of a neighborhood: its smallest principal axis.

use glam::{DMat3, DVec3, Vec3};

/// Two principal axes whose variances differ by less than this share of the largest one are indistinguishable: rounding
/// turns an axis by about 10⁻¹⁶ over that share.
const LEAST_GAP: f64 = 1e-9;

/// Sweeps of Jacobi's method at most; it converges quadratically, after four or five.
const SWEEPS: usize = 16;

/// The direction in which a neighborhood varies least.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct SmallestAxis {
    /// A unit vector whose last coordinate that is not 0 is positive.
    ///
    /// Zero where that is no single direction: all points in one place, on a line, or spread alike in the two directions in
    /// which they spread least.
    pub direction: Vec3,
    /// True if points lie about a surface rather than scattered, as in foliage: if their planarity (σ₂−σ₃)/σ₁ exceeds their
    /// scattering σ₃/σ₁ (Demantké et al. 2011, Dimensionality based scale selection in 3D lidar point clouds), σ being
    /// standard deviations along the principal axes.
    pub planar: bool,
}

/// That of points around the origin.
pub(super) fn smallest_axis(offsets: impl Iterator<Item = DVec3> + Clone) -> SmallestAxis {
    let largest = offsets.clone().fold(0.0, |largest: f64, p| largest.max(p.abs().max_element()));
    if largest == 0.0 || !largest.is_finite() {
        return SmallestAxis::default();
    }
    let unit = offsets.map(|p| p / largest);
    let (count, sum) = unit.clone().fold((0.0, DVec3::ZERO), |(count, sum), p| (count + 1.0, sum + p));
    let mean = sum / count;
    let covariance = unit.fold(DMat3::ZERO, |sum, p| {
        let p = p - mean;
        sum + DMat3::from_cols(p * p.x, p * p.y, p * p.z)
    });
    let (variances, axes) = principal_axes(covariance);
    let mut order = [0, 1, 2];
    order.sort_by(|&a, &b| variances[a].total_cmp(&variances[b]));
    let [least, middle, most] = order.map(|axis| variances[axis]);
    if middle - least <= LEAST_GAP * most {
        return SmallestAxis::default();
    }
    let axis = axes.col(order[0]).normalize().as_vec3();
    let last = axis.to_array().into_iter().rfind(|x| *x != 0.0).unwrap_or_default();
    // σ₂ > 2σ₃, of variances.
    SmallestAxis { direction: if last < 0.0 { -axis } else { axis }, planar: middle > 4.0 * least }
}

/// Eigenvalues and unit eigenvectors (columns) of a symmetric matrix, by Jacobi's method: one rotation after the other
/// makes an element off the diagonal 0. As accurate for small eigenvalues as for large ones, without special cases.
fn principal_axes(mut a: DMat3) -> ([f64; 3], DMat3) {
    let mut axes = DMat3::IDENTITY;
    for _ in 0..SWEEPS {
        let mut done = true;
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            let (off, scale) = (a.col(q)[p], a.col(p)[p].abs() + a.col(q)[q].abs());
            if off.abs() <= f64::EPSILON * 0.25 * scale {
                continue;
            }
            done = false;
            // tan of the angle, the smaller of two solutions (Golub, Van Loan, 8.5.2).
            let tau = (a.col(q)[q] - a.col(p)[p]) / (2.0 * off);
            let tan = tau.signum() / (tau.abs() + tau.hypot(1.0));
            let cos = 1.0 / tan.hypot(1.0);
            let sin = tan * cos;
            let mut turn = DMat3::IDENTITY;
            turn.col_mut(p)[p] = cos;
            turn.col_mut(q)[q] = cos;
            turn.col_mut(q)[p] = sin;
            turn.col_mut(p)[q] = -sin;
            a = turn.transpose() * a * turn;
            // Zero except for rounding.
            a.col_mut(q)[p] = 0.0;
            a.col_mut(p)[q] = 0.0;
            axes *= turn;
        }
        if done {
            break;
        }
    }
    ([0, 1, 2].map(|i| a.col(i)[i]), axes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64Mcg;

    fn normal(points: &[[f64; 3]]) -> Vec3 {
        smallest_axis(points.iter().map(|p| DVec3::from(*p))).direction
    }

    #[test]
    fn eigenvalues_and_vectors_satisfy_their_equation() {
        let mut rng = Pcg64Mcg::seed_from_u64(1);
        for _ in 0..2000 {
            let mut number = || (rng.random::<f64>() - 0.5) * 10f64.powi(rng.random_range(-9..4));
            let [a, b, c, d, e, f] = [(); 6].map(|()| number());
            let matrix = DMat3::from_cols_array(&[a, b, c, b, d, e, c, e, f]);
            let (values, axes) = principal_axes(matrix);
            let size = values.iter().fold(0f64, |size, x| size.max(x.abs()));
            for (i, value) in values.into_iter().enumerate() {
                let off = matrix * axes.col(i) - value * axes.col(i);
                // Some ten rotations, each rounding by a few units in the last place of the largest eigenvalue.
                assert!(off.length() <= 1e-14 * size, "{matrix}: {off}");
            }
            assert!((axes.transpose() * axes - DMat3::IDENTITY).to_cols_array().iter().all(|x| x.abs() < 1e-14));
        }
    }

    #[test]
    fn planes_have_their_normal() {
        // x + y + z = 0.
        let plane = normal(&[[1.0, -1.0, 0.0], [0.0, 1.0, -1.0], [2.0, 0.0, -2.0], [0.5, 0.25, -0.75]]);
        assert!((plane - Vec3::splat(3f32.sqrt().recip())).abs().max_element() < 1e-7, "{plane}");
        assert_eq!(normal(&[[0.0, 0.0, 5.0], [1.0, 0.0, 5.0], [0.0, 3.0, 5.0]]), Vec3::Z);
        assert_eq!(normal(&[[0.0, 0.0, 0.0], [1e-200, 0.0, 0.0], [0.0, 3e-200, 0.0]]), Vec3::Z);
        assert_eq!(normal(&[[0.0, 0.0, 0.0], [1e200, 0.0, 0.0], [0.0, 3e200, 0.0]]), Vec3::Z);
    }

    #[test]
    fn places_lines_and_balls_have_none() {
        assert_eq!(normal(&[[1.0, 2.0, 3.0]; 5]), Vec3::ZERO);
        assert_eq!(normal(&[]), Vec3::ZERO);
        let line: Vec<_> = (0..25).map(|i| [0.1, -0.7, 0.3].map(|x| x * f64::from(i * i))).collect();
        assert_eq!(normal(&line), Vec3::ZERO);
        let cross = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        assert_eq!(normal(&cross.into_iter().chain(cross.map(|p| p.map(|x| -x))).collect::<Vec<_>>()), Vec3::ZERO);
    }
}
