//! Percentiles of the values of a cloud.

/// Returns some percentiles of the finite values: for a share p of n values the number at place p·(n − 1) of their
/// order, linear between two places. Shares lie in [0, 1]. `None` if no value is finite.
pub fn percentiles<const N: usize>(mut values: Vec<f64>, shares: [f64; N]) -> Option<[f64; N]> {
    values.retain(|value| value.is_finite());
    let last = values.len().checked_sub(1)?;
    Some(shares.map(|share| {
        let place = share * last as f64;
        let below = (place as usize).min(last);
        let (_, lower, above) = values.select_nth_unstable_by(below, f64::total_cmp);
        let lower = *lower;
        let upper = above.iter().copied().min_by(f64::total_cmp).unwrap_or(lower);
        between(lower, upper, place - below as f64)
    }))
}

/// The number a share of the way from one to another.
fn between(from: f64, to: f64, share: f64) -> f64 {
    // The difference of the largest float64 values overflows.
    if (to - from).is_finite() { from + share * (to - from) } else { from * (1.0 - share) + to * share }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_between_two_values_are_linear() {
        // Place 0.01·4 = 0.04 lies between 1 and 2, place 0.99·4 = 3.96 between 8 and 16.
        let [low, high] = percentiles(vec![4.0, 1.0, 16.0, 2.0, 8.0], [0.01, 0.99]).unwrap();
        assert!((low - 1.04).abs() < 1e-15 && (high - 15.68).abs() < 1e-14, "{low} {high}");
        assert_eq!(percentiles(vec![4.0, 1.0, 16.0, 2.0, 8.0], [0.0, 0.5, 1.0]), Some([1.0, 4.0, 16.0]));
    }

    #[test]
    fn percentiles_ignore_values_that_are_not_finite() {
        let values = vec![f64::NAN, 3.0, f64::INFINITY, 1.0, f64::NEG_INFINITY];
        assert_eq!(percentiles(values, [0.0, 0.5, 1.0]), Some([1.0, 2.0, 3.0]));
        assert_eq!(percentiles(vec![f64::NAN], [0.5]), None);
        assert_eq!(percentiles(vec![7.0; 9], [0.01, 0.99]), Some([7.0; 2]));
        assert_eq!(percentiles(vec![-f64::MAX, f64::MAX], [0.5]), Some([0.0]));
    }
}
