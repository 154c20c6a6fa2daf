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
