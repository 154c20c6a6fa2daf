//! Some points of a cloud that stand for all of them: chosen by where they are, whatever their order and whichever part
//! of the cloud is at hand.

use glam::DVec3;

/// Points up to which all of them are taken.
const ALL: u64 = 1 << 18;
/// Points that are taken of more of them, at most, on average.
const MOST: u64 = 1 << 17;

/// Rule that selects points of a cloud of some size.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Sampling {
    /// Stride of the sample less 1; the stride is a power of two.
    mask: u32,
}

impl Sampling {
    /// Chooses the sample of a cloud with so many points: all of up to 2¹⁸, of more of them about 2¹⁶ to 2¹⁷. Whoever
    /// is taken of a cloud is taken of any smaller one, too.
    pub fn of(points: u64) -> Self {
        let every = if points <= ALL { 1 } else { points.div_ceil(MOST).next_power_of_two().min(1 << 31) };
        Self { mask: every as u32 - 1 }
    }

    /// Returns the number of points that each stands for, on average.
    pub fn every(self) -> u64 {
        u64::from(self.mask) + 1
    }

    /// Returns `true` if all points are taken.
    pub fn takes_all(self) -> bool {
        self.mask == 0
    }

    /// Returns `true` if the points in a place are taken.
    pub fn takes(self, position: DVec3) -> bool {
        self.mask == 0 || scattered(position) & self.mask == 0
    }
}

/// Returns a number that has nothing to do with where a position lies, nor with those of other seeds and of
/// [`Sampling`]; the same for equal positions.
pub fn word(position: DVec3, seed: u64) -> u32 {
    // The high half of a product depends on all bits.
    (folded(position, (!seed).wrapping_mul(GOLDEN)).wrapping_mul(GOLDEN) >> 32) as u32
}

/// 2⁶⁴ over the golden ratio.
const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;

/// A number that has nothing to do with where a position lies, the same for equal positions: each coordinate's bits are
/// mixed, and multiplied once more by another odd number, since neighbors on a grid are told apart by few bits.
fn scattered(position: DVec3) -> u32 {
    (folded(position, 0).wrapping_mul(0xd6e8_feb8_6659_fd93) >> 32) as u32
}

fn folded(position: DVec3, first: u64) -> u64 {
    position.to_array().into_iter().map(f64::to_bits).fold(first, mix)
}

/// A number that depends on all bits of another one and of a word: their product with 2⁶⁴ over the golden ratio, whose
/// high half does so, folded (Knuth, The Art of Computer Programming 3, 6.4).
pub(crate) fn mix(all: u64, word: u64) -> u64 {
    let product = (all ^ word).wrapping_mul(GOLDEN);
    product ^ product >> 32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_spread_evenly_and_differ_by_seed() {
        let places = || (0..1u32 << 16).map(|i| DVec3::new(f64::from(i % 256), f64::from(i / 256), 0.5));
        // Sixteenths of the range hold 4096 of 65,536 words, to some standard errors of 62.
        for seed in [0, 1, u64::MAX] {
            let mut counts = [0u32; 16];
            places().for_each(|p| counts[(word(p, seed) >> 28) as usize] += 1);
            assert!(counts.iter().all(|count| count.abs_diff(4096) < 300), "{seed}: {counts:?}");
        }
        // Of the half that one seed puts first another one puts a half first, and so does the sampling.
        let first = |seed: u64| move |p: &DVec3| word(*p, seed) < 1 << 31;
        let both = places().filter(first(3)).filter(first(4)).count();
        assert!(both.abs_diff(1 << 14) < 600, "{both}");
        let sampled = places().filter(first(0)).filter(|p| scattered(*p) & 1 == 0).count();
        assert!(sampled.abs_diff(1 << 14) < 600, "{sampled}");
        assert_eq!(word(DVec3::ONE, 5), word(DVec3::ONE, 5));
    }

    #[test]
    fn few_points_stand_for_many() {
        assert!(Sampling::of(0).takes_all() && Sampling::of(ALL).takes_all());
        let grid = |count: u32| (0..count).map(|i| DVec3::new(f64::from(i % 1000), 0.5, f64::from(i / 1000)));
        // 2²⁰ of them: every eighth, to some standard errors of 2^8.5.
        let sampling = Sampling::of(1 << 20);
        let taken: Vec<DVec3> = grid(1 << 20).filter(|p| sampling.takes(*p)).collect();
        assert!(taken.len().abs_diff(1 << 17) < 1500, "{}", taken.len());
        // As many on the one side as on the other.
        let left = taken.iter().filter(|p| p.x < 500.0).count();
        assert!(left.abs_diff(taken.len() / 2) < 1500, "{left}");
        // Their number lets all of them stand for themselves.
        assert!(Sampling::of(taken.len() as u64).takes_all());
        // Those of more points are among those of fewer.
        let fewer = Sampling::of(1 << 30);
        assert!(grid(1 << 22).filter(|p| fewer.takes(*p)).all(|p| sampling.takes(p)));
        assert_eq!(Sampling::of(u64::MAX).mask, (1 << 31) - 1);
    }
}
