//! The numbers y = M d, with |y|² = dᵀ(P Pᵀ)⁻¹d, as float32 makes them of two rows P, and of an offset d.
//!
//! M is the inverse of the triangular factor of P, which is P times an orthonormal frame. A dilation is two more
//! columns of P. The columns p_k have errors of at most e_k in each component. With w = (P Pᵀ)⁻¹d, an error E of P Pᵀ
//! makes |y|² smaller by wᵀEw, and by (M E w)ᵀ(I + M E Mᵀ)⁻¹(M E w) larger. Errors of columns are kept as such: w is
//! across a needle, where |w·p_k| is small however long p_k is.

use glam::{DMat2, DVec2, DVec3};

use super::super::super::range::{ROUNDING, Range};

/// Roundings in a component of p_k, over s_k·scale·(1 + |slope|). An entry of the matrix of a quaternion has 4, and 2
/// more for the quaternion's own length; three of them are put through an axis of the camera, √3·6 and 5 for the axis,
/// products and sums; s_k takes one, slope and its product 5, scale and its product 4. That is 26; the rest is for
/// another order of operations.
pub(super) const AXIS: f64 = 40.0;

/// Roundings in the rows of P, over their lengths, where Gram and Schmidt make them orthogonal: 5 in the length of the
/// first, 1 in its direction, 5 in a product with it, 2 in what is left of the second (Higham, "Accuracy and Stability
/// of Numerical Algorithms", 19.8).
const ORTHOGONAL: f64 = 14.0;

/// Roundings in |y|² over itself, in addition to those of y: of squares and their sum, of the division by the square at
/// the end, of the way from there to the exponent, and of another form of the same.
const SQUARE: f64 = 16.0;

/// Two rows of numbers with their errors.
#[derive(Clone)]
pub(super) struct MatrixRows {
    columns: [DVec2; 5],
    errors: [DVec2; 5],
    /// Lengths of the rows.
    sides: DVec2,
}

impl MatrixRows {
    /// Factorizes the matrix of three columns and a dilation.
    pub fn new([a, b, c]: [DVec2; 3], [e, f, g]: [DVec2; 3], dilation: f64) -> Self {
        let columns = [a, b, c, dilation.sqrt() * DVec2::X, dilation.sqrt() * DVec2::Y];
        let sides = columns.iter().fold(DVec2::ZERO, |sum, p| sum + p * p).map(f64::sqrt);
        let errors = [e, f, g, DVec2::ZERO, DVec2::ZERO].map(|error| error + ORTHOGONAL * ROUNDING * sides);
        Self { columns, errors, sides }
    }

    /// det P Pᵀ, a sum of squares that can't cancel (Cauchy and Binet), and its error.
    pub fn determinant(&self) -> (f64, f64) {
        let (mut sum, mut error) = (0.0, 0.0);
        for (j, k) in (0..5).flat_map(|k| (0..k).map(move |j| (j, k))) {
            let [p, q] = [j, k].map(|i| (self.columns[i].abs(), self.errors[i]));
            let across = self.columns[j].perp_dot(self.columns[k]).abs();
            let miss = crossed(p.0, q.1) + crossed(q.0, p.1) + crossed(p.1, q.1);
            sum += across * across;
            error += miss * (2.0 * across + miss);
        }
        (sum, error)
    }
}

/// The most that a cross product of vectors with components of at most these has.
fn crossed(p: DVec2, q: DVec2) -> f64 {
    p.x * q.y + p.y * q.x
}

/// M and its errors.
pub(super) struct Factor {
    rows: MatrixRows,
    m: DMat2,
    /// ‖M E Mᵀ‖: the relative error of |y|² where it is largest.
    pub epsilon: f64,
}

/// Result of an offset.
pub(super) struct Met {
    /// |y|².
    pub rho2: Range,
    /// |y| without an error.
    pub length: f64,
    /// P⁺d of the first three columns, as long as y without a dilation.
    pub nearest: DVec3,
    /// Largest error of y, up to a turn of all y.
    pub error: f64,
}

impl Factor {
    /// `None` where roundings leave nothing of M.
    pub fn new(rows: MatrixRows) -> Option<Self> {
        let across: f64 = rows.columns.iter().map(|p| p.x * p.y).sum();
        // L = [l₁₁ 0; l₂₁ l₂₂], inverted.
        let (l11, l21) = (rows.sides.x, across / rows.sides.x);
        let l22 = rows.determinant().0.sqrt() / l11;
        let m = DMat2::from_cols(DVec2::new(1.0 / l11, -l21 / (l11 * l22)), DVec2::new(0.0, 1.0 / l22));
        let mut factor = Self { rows, m, epsilon: f64::INFINITY };
        factor.epsilon = factor.of_columns().map(|(p, error)| error * (2.0 * p + error)).sum();
        // NaN of a determinant of 0 leaves nothing either.
        (factor.epsilon < 0.125).then_some(factor)
    }

    /// |M p_k|, and the most that |M e_k| is.
    fn of_columns(&self) -> impl Iterator<Item = (f64, f64)> {
        let each = self.rows.columns.iter().zip(&self.rows.errors);
        each.map(|(p, error)| ((self.m * *p).length(), self.largest(*error).length()))
    }

    /// |M| v.
    fn largest(&self, v: DVec2) -> DVec2 {
        self.m.abs() * v
    }

    /// Returns the largest tilt of the plane of the rows of P, in radians: ‖M δP‖.
    pub fn tilt(&self) -> f64 {
        self.of_columns().map(|(_, error)| error * error).sum::<f64>().sqrt()
    }

    /// Returns the directions of the rows that y is measured along.
    pub fn directions(&self) -> [DVec3; 2] {
        let turned = [0, 1, 2].map(|k| self.m * self.rows.columns[k]);
        [0, 1].map(|i| DVec3::from(turned.map(|column| column[i])))
    }

    /// y of an offset with its error: offsets have half a rounding for the fraction of a pixel, and one for the sum.
    pub fn meet(&self, d: DVec2, screen_error: DVec2) -> Met {
        let u = ROUNDING;
        let (slack, y) = (1.0 + 4.0 * self.epsilon, self.m * d);
        let w = self.m.transpose() * y;
        let (w_abs, d_abs) = (w.abs(), d.abs());
        // Up to six roundings in each entry of M, which ρ at the end divides, two products and a sum.
        let d_error = u * (DVec2::ONE + d_abs) + screen_error;
        let own = slack * self.largest(d_error + 9.0 * u * d_abs).length();
        let (mut first, mut second, mut moved) = (0.0, 0.0, DVec2::ZERO);
        for ((p, error), (p_length, error_length)) in
            self.rows.columns.iter().zip(self.rows.errors).zip(self.of_columns())
        {
            let (along, miss) = (w.dot(*p).abs(), w_abs.dot(error));
            first += miss * (2.0 * along + miss);
            second += p_length * miss + error_length * (along + miss);
            moved += error * (along + miss);
        }
        let of_form = first + second * second / (1.0 - self.epsilon);
        let length = y.length();
        let low = (length - own).max(0.0).powi(2) - of_form;
        let high = (length + own).powi(2) + of_form;
        let rho2 = Range { low: (low * (1.0 - SQUARE * u)).max(0.0), high: high * (1.0 + SQUARE * u) };
        let nearest = DVec3::from([0, 1, 2].map(|k| self.rows.columns[k].dot(w)));
        Met { rho2, length, nearest, error: own + slack * self.largest(moved).length() }
    }

    /// Returns the most that y of an offset within a box has as error of its own.
    pub fn most_error(&self, half: DVec2) -> f64 {
        16.0 * ROUNDING * self.largest(DVec2::ONE + half).length()
    }
}
