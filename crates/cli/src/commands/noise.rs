//! Decides if times differ by more than their noise.
//!
//! The noise is that of the median: x₍ₖ₎ and x₍ₙ₊₁₋ₖ₎ of n sorted times enclose the true median with probability 1 −
//! 2·P(X < k), X binomial over n tosses of a coin, whatever the times' distribution (David and Nagaraja 2003, "Order
//! Statistics", section 7.1). k is the largest value that reaches 95%, or 1 for n = 5, which gives 93.75%. The ratio of
//! two medians then lies between the ratios of opposite ends. If nothing changed, and neither side has more than three
//! times the frames of the other, at most 1 comparison in 252 calls a pass slower, and as many call it faster
//! (enumerated over all orders of the times; the worst case is 5 against 5 frames). A table of passes therefore seldom
//! contains a false alarm. The worst rate of all is 1 in 32, for 5 frames against very many.
//!
//! This assumes independent frames. Effects between runs (heat, other work on the machine) are noticed only if the runs
//! of both sides alternate and their frames are pooled.

/// Fewer times say nothing about their noise.
pub const MIN_TIMES: usize = 5;

/// Level of the interval of a median.
const CONFIDENCE: f64 = 0.95;

/// The result of comparing B with A.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    Slower,
    Faster,
    Same,
}

impl Verdict {
    /// Returns the verdict for an interval of the ratio B/A.
    pub fn from_interval([low, high]: [f64; 2]) -> Self {
        if low > 1.0 {
            Self::Slower
        } else if high < 1.0 {
            Self::Faster
        } else {
            Self::Same
        }
    }

    pub fn name(self) -> &'static str {
        match self {
            Self::Slower => "slower",
            Self::Faster => "faster",
            Self::Same => "same",
        }
    }
}

/// Times in milliseconds, ascending.
#[derive(Debug, PartialEq)]
pub struct Times(Vec<f64>);

impl Times {
    pub fn new(mut times: Vec<f64>) -> Self {
        times.sort_by(f64::total_cmp);
        Self(times)
    }

    pub fn count(&self) -> usize {
        self.0.len()
    }

    /// The middle one, or the mean of the middle two.
    pub fn median(&self) -> Option<f64> {
        let middle = self.0.len() / 2;
        let upper = *self.0.get(middle)?;
        if self.0.len() % 2 == 1 { Some(upper) } else { Some(0.5 * (self.0.get(middle - 1)? + upper)) }
    }

    /// The interval that should contain the true median; `None` for fewer than [`MIN_TIMES`].
    fn interval(&self) -> Option<[f64; 2]> {
        let count = self.0.len();
        if count < MIN_TIMES {
            return None;
        }
        let cut = left_out(count);
        Some([*self.0.get(cut)?, *self.0.get(count - 1 - cut)?])
    }

    /// The interval that should contain the ratio of the medians, `self` over `base`.
    pub fn ratio_interval(&self, base: &Self) -> Option<[f64; 2]> {
        let ([low, high], [base_low, base_high]) = (self.interval()?, base.interval()?);
        Some([low / base_high, high / base_low])
    }
}

/// The number of sorted values, out of `count`, to leave out at each end: the largest for which P(X ≤ that number)
/// stays within bounds.
fn left_out(count: usize) -> usize {
    // The logarithm of P(X = k), since 2⁻ⁿ is no float64 for n > 1074.
    let mut ln_term = -(count as f64) * std::f64::consts::LN_2;
    let mut up_to_k = 0.0;
    for k in 0..count / 2 {
        up_to_k += ln_term.exp();
        if 2.0 * up_to_k > 1.0 - CONFIDENCE {
            return k.saturating_sub(1);
        }
        ln_term += ((count - k) as f64 / (k + 1) as f64).ln();
    }
    0
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64;

    use super::*;

    #[test]
    fn ranks_of_published_tables() {
        // Ranks of the 95% interval of a median, as tables of the sign test have them, counted from 1; for 5 the ends.
        for (count, rank) in [(5, 1), (6, 1), (8, 1), (9, 2), (11, 2), (12, 3), (20, 6), (50, 18), (100, 40)] {
            assert_eq!(left_out(count) + 1, rank, "{count}");
        }
        // For large counts, (n − 1.96·√n) / 2.
        assert!((left_out(100_000) as f64 - 49_690.0).abs() < 2.0, "{}", left_out(100_000));
    }

    #[test]
    fn medians_and_intervals_by_hand() {
        let times = |times: &[f64]| Times::new(times.to_vec());
        assert_eq!(times(&[]).median(), None);
        assert_eq!(times(&[3.0, 6.0]).median(), Some(4.5));
        let (a, b) = (times(&[10.0, 9.0, 11.0, 10.0, 10.0]), times(&[15.0, 14.0, 15.0, 22.0, 15.0]));
        assert_eq!(b.ratio_interval(&a), Some([14.0 / 11.0, 22.0 / 9.0]));
        assert_eq!(b.ratio_interval(&a).map(Verdict::from_interval), Some(Verdict::Slower));
        assert_eq!(a.ratio_interval(&b).map(Verdict::from_interval), Some(Verdict::Faster));
        assert_eq!(a.ratio_interval(&a).map(Verdict::from_interval), Some(Verdict::Same));
        assert_eq!(a.ratio_interval(&times(&[1.0; 4])), None);
        // From nine times, one is left out at each end.
        let nine = times(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 100.0]);
        assert_eq!(nine.interval(), Some([2.0, 8.0]));
    }

    #[test]
    fn equal_distributions_are_seldom_called_different_and_shifted_ones_mostly() {
        let mut random = Pcg64::seed_from_u64(1);
        // A least time and a tail, as frames have it.
        let mut sample = |count: usize, scale: f64| {
            Times::new((0..count).map(|_| scale * (1.0 - 0.1 * random.random::<f64>().ln())).collect())
        };
        const TRIALS: usize = 20_000;
        for (a, b) in [(5, 5), (5, 15), (10, 10), (15, 15), (30, 12)] {
            let mut slower = |scale: f64| {
                let one = |_: &usize| {
                    let (a, b) = (sample(a, 1.0), sample(b, scale));
                    b.ratio_interval(&a).map(Verdict::from_interval) == Some(Verdict::Slower)
                };
                (0..TRIALS).filter(one).count() as f64 / TRIALS as f64
            };
            // At most 1 in 252 is called slower and as many faster; four standard errors of such a share are 0.0018.
            assert!(slower(1.0) < 1.0 / 252.0 + 0.0018, "{a} and {b} frames");
            assert!(slower(1.5) > 0.75, "{a} and {b} frames");
        }
    }
}
