//! Random numbers from counters, the same on host and device (shaders/shared/random.wgsl), and the masks of stochastic
//! transparency made from them. Stateless: each number can be computed on its own, so the order of pixels doesn't
//! matter.

/// Samples of a stratum.
pub const STRATUM: u32 = 4;
/// Strata that share a call of [`threefry2x32`], one for each of its words.
pub const STRATA_OF_A_CALL: u32 = 2;

/// Rotations of the rounds, and the parity of the key's third word.
const ROTATIONS: [u32; 8] = [13, 15, 26, 6, 17, 29, 16, 24];
const PARITY: u32 = 0x1BD1_1BDA;

/// Threefry-2×32 with 20 rounds: Salmon, Moraes, Dror, Shaw, "Parallel Random Numbers: As Easy as 1, 2, 3", SC 2011.
pub fn threefry2x32(counter: [u32; 2], key: [u32; 2]) -> [u32; 2] {
    let keys = [key[0], key[1], PARITY ^ key[0] ^ key[1]];
    let [mut a, mut b] = [counter[0].wrapping_add(keys[0]), counter[1].wrapping_add(keys[1])];
    for round in 0..20 {
        a = a.wrapping_add(b);
        b = b.rotate_left(ROTATIONS[round % 8]) ^ a;
        if round % 4 == 3 {
            let step = round / 4 + 1;
            a = a.wrapping_add(keys[step % 3]);
            b = b.wrapping_add(keys[(step + 1) % 3]).wrapping_add(step as u32);
        }
    }
    [a, b]
}

/// Returns the key's words for a seed; the second one is that of the first two strata, and grows by one for each two
/// more.
pub fn key(seed: u64) -> [u32; 2] {
    [seed as u32, ((seed >> 32) as u32).wrapping_mul(0x9E37_79B9)]
}

/// Returns the random word of a fragment, a splat (by its point's id, [`Points::ids`](crate::points::Points::ids)) in a
/// pixel (column and row), for a stratum.
pub fn word(seed: u64, [x, y]: [u32; 2], splat: u32, stratum: u32) -> u32 {
    let [low, high] = key(seed);
    let words = threefry2x32([y << 16 | x, splat], [low, high.wrapping_add(stratum / STRATA_OF_A_CALL)]);
    words[(stratum % STRATA_OF_A_CALL) as usize]
}

/// Returns the samples of a stratum that a fragment of opacity `alpha` in [0, 1] covers, one bit each.
///
/// It covers 4α samples, rounded at random to give the right mean, with α in steps of 2⁻²⁸: each sample is covered with
/// probability α, none for α = 0 and all for α = 1. The choice of samples is random, too: all rotations are equally
/// likely, and two samples are neighbors with probability 11/16.
pub fn mask(alpha: f32, word: u32) -> u32 {
    // The upper 26 bits round, the lower 6 choose.
    let steps = (alpha * 268_435_456.0 + 0.5) as u32;
    let base = match ((steps + (word >> 6)) >> 26).min(STRATUM) {
        0 => 0,
        1 => 0b0001,
        2 if (word >> 2) & 15 < 5 => 0b0101,
        2 => 0b0011,
        3 => 0b0111,
        _ => 0b1111,
    };
    let turn = word & 3;
    (base << turn | base >> (STRATUM - turn)) & 15
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn threefry_gives_the_published_answers() {
        // `threefry2x32 20` of kat_vectors in Random123 1.14: counter, key, result.
        let known = [
            ([0, 0], [0, 0], [0x6b20_0159, 0x99ba_4efe]),
            ([u32::MAX; 2], [u32::MAX; 2], [0x1cb9_96fc, 0xbb00_2be7]),
            ([0x243f_6a88, 0x85a3_08d3], [0x1319_8a2e, 0x0370_7344], [0xc492_3a9c, 0x483d_f7a0]),
        ];
        for (counter, key, wanted) in known {
            assert_eq!(threefry2x32(counter, key), wanted);
        }
    }

    #[test]
    fn words_follow_from_seed_pixel_splat_and_stratum() {
        let all = |seed: u64, stratum: u32| threefry2x32([(7 << 16) | 5, 9], [seed as u32, stratum / 2]);
        assert_eq!(word(3, [5, 7], 9, 0), all(3, 0)[0]);
        assert_eq!(word(3, [5, 7], 9, 1), all(3, 0)[1]);
        assert_eq!(word(3, [5, 7], 9, 6), all(3, 6)[0]);
        let high = threefry2x32([(7 << 16) | 5, 9], [3, 2u32.wrapping_mul(0x9E37_79B9).wrapping_add(4)]);
        assert_eq!(word(3 + (2 << 32), [5, 7], 9, 9), high[1]);
    }

    #[test]
    fn no_opacity_covers_nothing_and_full_opacity_everything() {
        for word in [0, 1, 63, 64, 0x7fff_ffff, u32::MAX - 1, u32::MAX] {
            assert_eq!([0.0, f32::from_bits(1), 1e-20].map(|alpha| mask(alpha, word)), [0; 3]);
            // If exp rounds up, the remainder to 1 is negligible.
            assert_eq!([1.0, 1.0 + f32::EPSILON].map(|alpha| mask(alpha, word)), [15; 2]);
        }
        // The smallest and the largest opacity between are covered now and then.
        let least = 0.5f32.powi(28);
        assert_eq!([u32::MAX, 0].map(|word| mask(least, word).count_ones()), [1, 0]);
        let most = 1.0 - f32::EPSILON / 2.0;
        assert_eq!([u32::MAX, 0].map(|word| mask(most, word).count_ones()), [4, 3]);
    }

    #[test]
    fn as_many_samples_as_the_opacity_says_each_as_often_as_the_others() {
        for alpha in [0.01f32, 0.25, 0.3, 0.5, 0.7, 0.75, 0.99] {
            let (n, mut samples, mut counts) = (200_000u32, [0u32; 4], [0u32; 5]);
            for stratum in 0..n {
                let mask = mask(alpha, word(5, [3, 4], 6, stratum));
                counts[mask.count_ones() as usize] += 1;
                (0..4).for_each(|s| samples[s] += mask >> s & 1);
            }
            // Only the two whole numbers around 4α occur.
            let (low, high) = ((4.0 * alpha).floor() as usize, (4.0 * alpha).ceil() as usize);
            assert_eq!(counts[low] + if high > low { counts[high] } else { 0 }, n, "{alpha}: {counts:?}");
            let error = (f64::from(alpha * (1.0 - alpha)) / f64::from(n)).sqrt();
            for sample in samples {
                let share = f64::from(sample) / f64::from(n);
                assert!((share - f64::from(alpha)).abs() < 4.5 * error, "{alpha}: {share}");
            }
        }
    }

    #[test]
    fn two_samples_are_any_pair() {
        let mut pairs = [0u32; 16];
        let n = 96_000;
        (0..n).for_each(|stratum| pairs[mask(0.5, word(8, [1, 2], 3, stratum)) as usize] += 1);
        // 11/16 in four neighboring pairs, 5/16 in two opposite ones; 5 standard errors of 16 500 are 580.
        for (pair, wanted) in [(0b0011, 16_500), (0b0110, 16_500), (0b1100, 16_500), (0b1001, 16_500), (0b0101, 15_000)]
        {
            assert!(pairs[pair].abs_diff(wanted) < 600, "{pair:04b}: {}", pairs[pair]);
        }
        assert_eq!(pairs.iter().filter(|n| **n > 0).count(), 6);
    }
}
