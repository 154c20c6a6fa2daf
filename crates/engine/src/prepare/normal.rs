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

/// That of points around the origin, which are scaled to size 1.
pub(super) fn smallest_axis(offsets: &mut [DVec3]) -> SmallestAxis {
    let largest = offsets.iter().fold(DVec3::ZERO, |largest, p| largest.max(p.abs())).max_element();
    if largest == 0.0 || !largest.is_finite() {
        return SmallestAxis::default();
    }
    let mut sum = DVec3::ZERO;
    for p in offsets.iter_mut() {
        *p /= largest;
        sum += *p;
    }
    let mean = sum / offsets.len() as f64;
    // Σ of x², y², z², and of yz, xz, xy.
    let (mut squares, mut products) = (DVec3::ZERO, DVec3::ZERO);
    for p in offsets {
        let p = *p - mean;
        squares += p * p;
        products += DVec3::new(p.y * p.z, p.x * p.z, p.x * p.y);
    }
    let (variances, axes) = principal_axes(squares, products);
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
/// makes an element off the diagonal 0 (Golub, Van Loan, 8.5.2). As accurate for small eigenvalues as for large ones, without
/// special cases.
///
/// `off` are the elements off the diagonal, each by the index that neither its row nor its column has.
fn principal_axes(diagonal: DVec3, off: DVec3) -> ([f64; 3], DMat3) {
    let (mut values, mut off) = (diagonal.to_array(), off.to_array());
    let mut axes = [DVec3::X, DVec3::Y, DVec3::Z];
    for _ in 0..SWEEPS {
        let mut done = true;
        for (p, q, other) in [(0, 1, 2), (0, 2, 1), (1, 2, 0)] {
            let element = off[other];
            if element.abs() <= f64::EPSILON * 0.25 * (values[p].abs() + values[q].abs()) {
                continue;
            }
            done = false;
            // tan of the angle, the smaller of two solutions; tau is at most 2/ε.
            let tau = (values[q] - values[p]) / (2.0 * element);
            let tan = tau.signum() / (tau.abs() + (tau * tau + 1.0).sqrt());
            let cos = 1.0 / (tan * tan + 1.0).sqrt();
            let sin = tan * cos;
            values[p] -= tan * element;
            values[q] += tan * element;
            off[other] = 0.0;
            (off[q], off[p]) = (cos * off[q] - sin * off[p], sin * off[q] + cos * off[p]);
            (axes[p], axes[q]) = (cos * axes[p] - sin * axes[q], sin * axes[p] + cos * axes[q]);
        }
        if done {
            break;
        }
    }
    (values, DMat3::from_cols(axes[0], axes[1], axes[2]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64Mcg;

    fn normal(points: &[[f64; 3]]) -> Vec3 {
        smallest_axis(&mut points.iter().map(|p| DVec3::from(*p)).collect::<Vec<_>>()).direction
    }

    #[test]
    fn eigenvalues_and_vectors_satisfy_their_equation() {
        let mut rng = Pcg64Mcg::seed_from_u64(1);
        for _ in 0..2000 {
            let mut number = || (rng.random::<f64>() - 0.5) * 10f64.powi(rng.random_range(-9..4));
            let [a, b, c, d, e, f] = [(); 6].map(|()| number());
            let matrix = DMat3::from_cols_array(&[a, b, c, b, d, e, c, e, f]);
            let (values, axes) = principal_axes(DVec3::new(a, d, f), DVec3::new(e, c, b));
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
