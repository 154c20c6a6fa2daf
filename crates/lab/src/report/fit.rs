//! Slopes: how a cost grows.

/// y = factor · x^exponent, fitted by least squares to the logarithms.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct PowerLaw {
    /// The slope in a plot with two logarithmic axes: 1 if y grows as x does.
    pub exponent: f64,
    /// y at x = 1.
    pub factor: f64,
    /// Share of the variance of ln y that the law explains, in [0, 1]; 1 if y is constant.
    pub r_squared: f64,
}

/// The power law through some points (x, y); `None` where logarithms or the slope don't exist: a value that is not
/// finite and above 0, or fewer than two different x.
pub fn power_law(points: &[(f64, f64)]) -> Option<PowerLaw> {
    let has_logarithm = |value: f64| value > 0.0 && value.is_finite();
    let &(first, _) = points.first()?;
    if !points.iter().all(|&(x, y)| has_logarithm(x) && has_logarithm(y)) || points.iter().all(|&(x, _)| x == first) {
        return None;
    }
    let n = points.len() as f64;
    let logs: Vec<(f64, f64)> = points.iter().map(|(x, y)| (x.ln(), y.ln())).collect();
    let mean_x = logs.iter().map(|l| l.0).sum::<f64>() / n;
    let mean_y = logs.iter().map(|l| l.1).sum::<f64>() / n;
    let sum = |f: fn(f64, f64) -> f64| logs.iter().map(|(x, y)| f(x - mean_x, y - mean_y)).sum::<f64>();
    let (xx, xy, yy) = (sum(|x, _| x * x), sum(|x, y| x * y), sum(|_, y| y * y));
    let exponent = xy / xx;
    let r_squared = if yy > 0.0 { xy * xy / (xx * yy) } else { 1.0 };
    Some(PowerLaw { exponent, factor: (mean_y - exponent * mean_x).exp(), r_squared })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn law(points: &[(f64, f64)]) -> PowerLaw {
        power_law(points).unwrap()
    }

    #[test]
    fn a_power_law_is_found_to_rounding() {
        let points: Vec<(f64, f64)> = (0..13).map(|i| f64::from(1 << i)).map(|x| (x, 3.0 * x.powf(1.25))).collect();
        let PowerLaw { exponent, factor, r_squared } = law(&points);
        assert!((exponent - 1.25).abs() < 1e-12 && (factor - 3.0).abs() < 1e-11 && (r_squared - 1.0).abs() < 1e-12);
        // And is not found in another one.
        assert!((law(&points).exponent - 1.0).abs() > 0.2);
        let PowerLaw { exponent, factor, r_squared } = law(&[(1.0, 5.0), (10.0, 5.0), (100.0, 5.0)]);
        assert!(exponent.abs() < 1e-12 && (factor - 5.0).abs() < 1e-11 && r_squared == 1.0);
    }

    #[test]
    fn least_squares_by_hand() {
        // ln x = 0, 1, 2 and ln y = 0, 3, 3: slope ((-1)(-2) + 0 + 1·1) / 2 = 1.5, intercept 2 − 1.5 = 0.5,
        // R² = 3² / (2 · 6) = 0.75.
        let points = [(0.0f64, 0.0f64), (1.0, 3.0), (2.0, 3.0)].map(|(x, y)| (x.exp(), y.exp()));
        let PowerLaw { exponent, factor, r_squared } = law(&points);
        assert!((exponent - 1.5).abs() < 1e-12 && (factor.ln() - 0.5).abs() < 1e-12);
        assert!((r_squared - 0.75).abs() < 1e-12);
    }

    #[test]
    fn points_without_a_slope_get_none() {
        for points in [&[][..], &[(2.0, 1.0)], &[(3.0, 1.0), (3.0, 3.0), (3.0, 2.0)]] {
            assert_eq!(power_law(points), None, "{points:?}");
        }
        for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert_eq!(power_law(&[(1.0, 1.0), (2.0, bad)]), None, "y = {bad}");
            assert_eq!(power_law(&[(1.0, 1.0), (bad, 2.0)]), None, "x = {bad}");
        }
    }
}
