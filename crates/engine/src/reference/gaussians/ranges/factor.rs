//! The numbers y = M d, with |y|² = dᵀ(P Pᵀ + dilation·I)⁻¹d, as float32 makes them of the columns of P, and of an offset d.
//!
//! M is the inverse of the Cholesky factor of Σ′ = P Pᵀ + dilation·I. The columns p_k have errors of at most e_k in each component.
//! Put through the quadratic form as w = Σ′⁻¹d, an error E of Σ′ makes |y|² smaller by wᵀEw, and by (M E w)ᵀ(I + M E Mᵀ)⁻¹(M E w)
//! larger. Errors of columns are kept as such: w is across a needle, where |w·p_k| is small however long p_k is.

use glam::{DMat2, DVec2, DVec3};

use super::super::super::range::{ROUNDING, Range};

/// Roundings in a component of p_k, over s_k·scale·(1 + |slope|). An entry of the matrix of a quaternion has 4, and 2 more for
/// the quaternion's own length; three of them are put through an axis of the camera, √3·6 and 5 for the axis, products and
/// sums; s_k takes one, slope and its product 5, scale and its product 4. That is 26; the rest is for another order of operations.
pub(super) const AXIS: f64 = 40.0;

/// Roundings in an entry of Σ′, over √(Σ′₁₁Σ′₂₂) or the entry's own: 5 for three products, their sum and the dilation; 4 for
/// Cholesky's factor (Higham, "Accuracy and Stability of Numerical Algorithms", Theorem 10.3).
const GRAM: f64 = 9.0;

/// Roundings in the rows of P, over their lengths, where they are made orthogonal in place of Σ′ (Higham, Section 19.3).
const ORTHOGONAL: f64 = 8.0;

/// The way from P to M.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum By {
    /// Sums of products, Cholesky's factor, its inverse.
    Gram,
    /// Rows that are made orthogonal.
    Rows,
}

/// M and its errors.
pub(super) struct Factor {
    m: DMat2,
    columns: [DVec2; 3],
    errors: [DVec2; 3],
    /// Square roots of Σ′₁₁ and Σ′₂₂.
    sides: DVec2,
    /// Roundings in the entries of Σ′.
    gram: f64,
    /// ‖M E Mᵀ‖: the relative error of |y|² where it is largest.
    pub epsilon: f64,
}

/// What an offset becomes.
pub(super) struct Met {
    /// |y|².
    pub rho2: Range,
    /// |y| without an error.
    pub length: f64,
    /// P⁺d, as long as y.
    pub nearest: DVec3,
    /// How far y may be off, up to a turn of all y.
    pub error: f64,
}

impl Factor {
    /// `None` where roundings leave nothing of M.
    pub fn new(columns: [DVec2; 3], mut errors: [DVec2; 3], dilation: f64, by: By) -> Option<Self> {
        let sides = columns.iter().fold(DVec2::splat(dilation), |sum, p| sum + p * p).map(f64::sqrt);
        let [a, b, c] = columns;
        let squares: f64 = [a.perp_dot(b), b.perp_dot(c), c.perp_dot(a)].iter().map(|cross| cross * cross).sum();
        let trace: f64 = columns.iter().map(|p| p.length_squared()).sum();
        let determinant = squares + dilation * (trace + dilation);
        if by == By::Rows {
            errors.iter_mut().for_each(|error| *error += ORTHOGONAL * ROUNDING * sides);
        }
        let across: f64 = columns.iter().map(|p| p.x * p.y).sum();
        // L = [l₁₁ 0; l₂₁ l₂₂], inverted.
        let (l11, l21, l22) = (sides.x, across / sides.x, determinant.sqrt() / sides.x);
        let m = DMat2::from_cols(DVec2::new(1.0 / l11, -l21 / (l11 * l22)), DVec2::new(0.0, 1.0 / l22));
        let gram = if by == By::Gram { GRAM * ROUNDING } else { 0.0 };
        let mut factor = Self { m, columns, errors, sides, gram, epsilon: f64::INFINITY };
        let of_column = |k: usize| {
            let error = factor.largest(errors[k]).length();
            error * (2.0 * (m * columns[k]).length() + error)
        };
        let of_columns: f64 = (0..3).map(of_column).sum();
        factor.epsilon = of_columns + gram * factor.largest(sides).length_squared();
        // NaN of a determinant of 0 leaves nothing either.
        (factor.epsilon < 0.125).then_some(factor)
    }

    /// |M| v.
    fn largest(&self, v: DVec2) -> DVec2 {
        self.m.abs() * v
    }

    /// How far the plane of the rows of P may be tilted, in radians: ‖M δP‖.
    pub fn tilt(&self) -> f64 {
        self.errors.iter().map(|error| self.largest(*error).length_squared()).sum::<f64>().sqrt()
    }

    /// The directions of the rows that y is measured along.
    pub fn directions(&self) -> [DVec3; 2] {
        let turned = self.columns.map(|p| self.m * p);
        [0, 1].map(|i| DVec3::from(turned.map(|column| column[i])))
    }

    /// y of an offset with its error: offsets have half a rounding for the fraction of a pixel, and one for the sum.
    pub fn meet(&self, d: DVec2, screen_error: DVec2) -> Met {
        let u = ROUNDING;
        let (slack, y) = (1.0 + 4.0 * self.epsilon, self.m * d);
        let w = self.m.transpose() * y;
        let (w_abs, d_abs) = (w.abs(), d.abs());
        // Two to three roundings in each entry of M, two products and a sum.
        let d_error = u * (DVec2::ONE + d_abs) + screen_error;
        let own = slack * self.largest(d_error + 7.0 * u * d_abs).length();
        let gram = self.gram * w_abs.dot(self.sides);
        let (mut first, mut second) = (gram * w_abs.dot(self.sides), gram * self.largest(self.sides).length());
        let mut moved = DVec2::ZERO;
        for (p, error) in self.columns.iter().zip(self.errors) {
            let (along, miss) = (w.dot(*p).abs(), w_abs.dot(error));
            first += miss * (2.0 * along + miss);
            second += (self.m * *p).length() * miss + self.largest(error).length() * (along + miss);
            moved += error * (along + miss);
        }
        let of_form = first + second * second / (1.0 - self.epsilon);
        let length = y.length();
        let low = (length - own).max(0.0).powi(2) - of_form;
        let high = (length + own).powi(2) + of_form;
        // Two squares and a sum, which may stand for another form of the same.
        let rho2 = Range { low: (low * (1.0 - 6.0 * u)).max(0.0), high: high * (1.0 + 6.0 * u) };
        let nearest = DVec3::from(self.columns.map(|p| p.dot(w)));
        Met { rho2, length, nearest, error: own + slack * self.largest(moved).length() }
    }

    /// The most that y of an offset within a box has as error of its own.
    pub fn most_error(&self, half: DVec2) -> f64 {
        16.0 * ROUNDING * self.largest(DVec2::ONE + half).length()
    }
}
