//! The normal of a neighborhood: its smallest principal axis.

use bytemuck::Zeroable;
use glam::{DVec3, Vec3};
use pulp::Arch;

/// Two principal axes whose variances differ by less than this share of the largest one are indistinguishable: rounding
/// turns an axis by about 10⁻¹⁶ over that share.
const LEAST_GAP: f64 = 1e-9;

/// Sweeps of Jacobi's method at most; it converges quadratically, after four or five.
const SWEEPS: usize = 16;

/// Matrices that are worked on side by side.
const LANES: usize = 4;

/// The direction in which a neighborhood varies least.
#[derive(Debug, Clone, Copy, Default, PartialEq, Zeroable)]
pub(super) struct SmallestAxis {
    /// A unit vector whose last coordinate that is not 0 is positive.
    ///
    /// Zero where that is no single direction: all points in one place, on a line, or spread alike in the two
    /// directions in which they spread least.
    pub direction: Vec3,
    /// `true` if points lie about a surface rather than scattered, as in foliage: if their planarity (σ₂−σ₃)/σ₁ exceeds
    /// their scattering σ₃/σ₁ (Demantké et al. 2011, Dimensionality based scale selection in 3D lidar point clouds), σ
    /// being standard deviations along the principal axes.
    pub planar: bool,
}

/// Spread of points around their mean.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Moments {
    /// Σ of x², y², z².
    squares: DVec3,
    /// Σ of yz, xz, xy.
    products: DVec3,
}

impl Moments {
    /// Returns those of points by their offsets from one among them, at which there are `here`.
    ///
    /// The mean is subtracted from the sums. Where that would cancel more than two digits, as around an outlier far
    /// from its neighbors, it is subtracted from the points.
    pub fn around(here: usize, offsets: impl Iterator<Item = DVec3> + Clone) -> Self {
        let (mut count, mut sum, mut all) = (here, DVec3::ZERO, Self::default());
        for p in offsets.clone() {
            count += 1;
            sum += p;
            all.add(p);
        }
        let mean = sum / count as f64;
        let mut centered = all;
        centered.squares -= sum * mean;
        centered.products -= DVec3::new(sum.y * mean.z, sum.x * mean.z, sum.x * mean.y);
        if 100.0 * centered.squares.element_sum() >= all.squares.element_sum() {
            return centered;
        }
        let mut centered = Self::default();
        let copies = std::iter::repeat_n(DVec3::ZERO, here);
        copies.chain(offsets).for_each(|p| centered.add(p - mean));
        centered
    }

    fn add(&mut self, p: DVec3) {
        self.squares += p * p;
        self.products += DVec3::new(p.y * p.z, p.x * p.z, p.x * p.y);
    }
}

/// Returns the smallest axes of some neighborhoods, each by its own moments.
pub(super) fn smallest_axes(moments: &[Moments]) -> Vec<SmallestAxis> {
    Arch::new().dispatch(|| in_vectors(moments))
}

#[inline(always)]
fn in_vectors(moments: &[Moments]) -> Vec<SmallestAxis> {
    let mut found = Vec::with_capacity(moments.len());
    for some in moments.chunks(LANES) {
        let (mut diagonal, mut off) = ([[0.0; LANES]; 3], [[0.0; LANES]; 3]);
        for (lane, Moments { squares, products }) in some.iter().enumerate() {
            for axis in 0..3 {
                (diagonal[axis][lane], off[axis][lane]) = (squares[axis], products[axis]);
            }
        }
        let (variances, axes) = principal_axes(diagonal, off);
        for lane in 0..some.len() {
            found.push(smallest_axis(&variances, &axes, lane));
        }
    }
    found
}

/// Returns the smallest of the principal axes of a lane.
fn smallest_axis(variances: &[Lanes; 3], axes: &[[Lanes; 3]; 3], lane: usize) -> SmallestAxis {
    let mut order = [0, 1, 2];
    for (a, b) in [(0, 1), (1, 2), (0, 1)] {
        if variances[order[a]][lane] > variances[order[b]][lane] {
            order.swap(a, b);
        }
    }
    let [least, middle, most] = order.map(|axis| variances[axis][lane]);
    // The gap is not a number where offsets are beyond float64.
    let gap = middle - least;
    if gap.is_nan() || gap <= LEAST_GAP * most {
        return SmallestAxis::default();
    }
    let [x, y, z] = axes[order[0]];
    let axis = DVec3::new(x[lane], y[lane], z[lane]).normalize().as_vec3();
    let last = axis.to_array().into_iter().rfind(|x| *x != 0.0).unwrap_or_default();
    // σ₂ > 2σ₃, of variances.
    SmallestAxis { direction: if last < 0.0 { -axis } else { axis }, planar: middle > 4.0 * least }
}

/// A number of each matrix.
type Lanes = [f64; LANES];

/// Eigenvalues and unit eigenvectors of symmetric matrices, by Jacobi's method: one rotation after the other makes an
/// element off the diagonal 0 (Golub, Van Loan, 8.5.2). As accurate for small eigenvalues as for large ones, without
/// special cases. A matrix needs some thirty divisions and roots, one after the other: side by side, those of several
/// overlap.
///
/// `off` are the elements off the diagonal, each by the index that neither its row nor its column has. The vectors come
/// by their coordinates.
#[inline(always)]
fn principal_axes(mut values: [Lanes; 3], mut off: [Lanes; 3]) -> ([Lanes; 3], [[Lanes; 3]; 3]) {
    let (one, zero) = ([1.0; LANES], [0.0; LANES]);
    let mut axes = [[one, zero, zero], [zero, one, zero], [zero, zero, one]];
    for _ in 0..SWEEPS {
        let mut done = true;
        for (p, q, other) in [(0, 1, 2), (0, 2, 1), (1, 2, 0)] {
            let (mut sin, mut cos) = ([0.0; LANES], [1.0; LANES]);
            for i in 0..LANES {
                let element = off[other][i];
                let is_zero = element.abs() <= f64::EPSILON * 0.25 * (values[p][i].abs() + values[q][i].abs());
                done &= is_zero;
                // tan of the angle, the smaller of two solutions; tau is at most 2/ε where it counts.
                let tau = (values[q][i] - values[p][i]) / (2.0 * element);
                let tan = 1.0_f64.copysign(tau) / (tau.abs() + (tau * tau + 1.0).sqrt());
                let tan = if is_zero { 0.0 } else { tan };
                cos[i] = 1.0 / (tan * tan + 1.0).sqrt();
                sin[i] = tan * cos[i];
                values[p][i] -= tan * element;
                values[q][i] += tan * element;
                off[other][i] = if is_zero { element } else { 0.0 };
            }
            let [off_p, off_q] = [off[p], off[q]];
            (off[q], off[p]) = rotated(off_q, off_p, sin, cos);
            let [axis_p, axis_q] = [axes[p], axes[q]];
            for coordinate in 0..3 {
                (axes[p][coordinate], axes[q][coordinate]) = rotated(axis_p[coordinate], axis_q[coordinate], sin, cos);
            }
        }
        if done {
            break;
        }
    }
    (values, axes)
}

/// (cos·a − sin·b, sin·a + cos·b).
#[inline(always)]
fn rotated(a: Lanes, b: Lanes, sin: Lanes, cos: Lanes) -> (Lanes, Lanes) {
    let (mut first, mut second) = (a, b);
    for i in 0..LANES {
        (first[i], second[i]) = (cos[i] * a[i] - sin[i] * b[i], sin[i] * a[i] + cos[i] * b[i]);
    }
    (first, second)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DMat3;
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64Mcg;

    /// The direction of a neighborhood around its first point, among others.
    fn normal(points: &[[f64; 3]]) -> Vec3 {
        let Some(first) = points.first() else { return smallest_axes(&[Moments::default()])[0].direction };
        let offsets = points[1..].iter().map(|p| DVec3::from(*p) - DVec3::from(*first));
        let moments = Moments::around(1, offsets);
        let slab = Moments { squares: DVec3::new(1.0, 0.5, 2.0), products: DVec3::splat(0.25) };
        let beside = smallest_axes(&[slab, moments, slab, slab, moments]);
        assert_eq!(beside[1], beside[4]);
        beside[1].direction
    }

    #[test]
    fn eigenvalues_and_vectors_satisfy_their_equation() {
        let mut rng = Pcg64Mcg::seed_from_u64(1);
        for _ in 0..2000 {
            let mut number = || (rng.random::<f64>() - 0.5) * 10f64.powi(rng.random_range(-9..4));
            let [a, b, c, d, e, f] = [(); 6].map(|()| number());
            let matrix = DMat3::from_cols_array(&[a, b, c, b, d, e, c, e, f]);
            let beside = |own: f64| std::array::from_fn(|lane| if lane == 2 { own } else { lane as f64 });
            let (values, axes) = principal_axes([a, d, f].map(beside), [e, c, b].map(beside));
            let values = values.map(|lanes| lanes[2]);
            let axes = DMat3::from_cols_array_2d(&axes.map(|axis| axis.map(|lanes| lanes[2])));
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
        assert_eq!(normal(&[[0.0, 0.0, 0.0], [1e-150, 0.0, 0.0], [0.0, 3e-150, 0.0]]), Vec3::Z);
        assert_eq!(normal(&[[0.0, 0.0, 0.0], [1e150, 0.0, 0.0], [0.0, 3e150, 0.0]]), Vec3::Z);
    }

    #[test]
    fn places_lines_and_balls_have_none() {
        assert_eq!(normal(&[[1.0, 2.0, 3.0]; 5]), Vec3::ZERO);
        assert_eq!(normal(&[]), Vec3::ZERO);
        let line: Vec<_> = (0..25).map(|i| [0.1, -0.7, 0.3].map(|x| x * f64::from(i * i))).collect();
        assert_eq!(normal(&line), Vec3::ZERO);
        // An outlier and many points at one place, or about one.
        let far = [[0.0; 3]].into_iter().chain(std::iter::repeat_n([1.0, 0.7, 0.3], 65_535)).collect::<Vec<_>>();
        assert_eq!(normal(&far), Vec3::ZERO);
        let cross = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        assert_eq!(normal(&cross.into_iter().chain(cross.map(|p| p.map(|x| -x))).collect::<Vec<_>>()), Vec3::ZERO);
    }
}
