//! Digits of Morton codes: a line through space on which neighbors in space are mostly neighbors.

/// Bits of a coordinate; those of three axes fill 63 bits.
#[doc(hidden)]
pub const BITS: u32 = 21;

/// Moves the lowest 21 bits three places apart.
#[doc(hidden)]
pub fn spread(x: u64) -> u64 {
    let x = x & 0x1f_ffff;
    let x = (x | x << 32) & 0x001f_0000_0000_ffff;
    let x = (x | x << 16) & 0x001f_0000_ff00_00ff;
    let x = (x | x << 8) & 0x100f_00f0_0f00_f00f;
    let x = (x | x << 4) & 0x10c3_0c30_c30c_30c3;
    (x | x << 2) & 0x1249_2492_4924_9249
}

/// Returns the largest cells with at most so many points each, as far as codes of so many levels tell them apart: the
/// level of each below the cell of all codes, its first code, and its points, along the curve. `counts` are the points
/// of each code, ascending.
pub fn divided(levels: u32, counts: &[(u64, u64)], most: u64) -> Vec<(u32, u64, u64)> {
    let (mut found, mut waiting) = (Vec::new(), vec![(0, counts)]);
    while let Some((level, counts)) = waiting.pop() {
        let points = counts.iter().map(|(_, points)| points).sum();
        let cell = |code: u64, level: u32| code >> (3 * (levels - level));
        if points <= most || level == levels {
            found.extend(counts.first().map(|(code, _)| (level, cell(*code, level) << (3 * (levels - level)), points)));
        } else {
            let same = |a: &(u64, u64), b: &(u64, u64)| cell(a.0, level + 1) == cell(b.0, level + 1);
            waiting.extend(counts.chunk_by(same).rev().map(|part| (level + 1, part)));
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_are_three_places_apart() {
        for bit in 0..BITS {
            assert_eq!(spread(1 << bit), 1 << (3 * bit), "bit {bit}");
        }
        assert_eq!(spread(0x1f_ffff).count_ones(), BITS);
    }
}
