//! Sorting networks written out as WGSL.

use std::fmt::Write as _;

/// Pairs of Batcher's odd-even merge sort of `n` inputs (a power of two), in order: the smaller goes to the first
/// place.
fn comparators(n: u32) -> Vec<(u32, u32)> {
    let mut pairs = Vec::new();
    let mut p = 1;
    while p < n {
        let mut k = p;
        while k >= 1 {
            for j in (k % p..n - k).step_by(2 * k as usize) {
                for i in 0..k.min(n - j - k) {
                    if (i + j) / (2 * p) == (i + j + k) / (2 * p) {
                        pairs.push((i + j, i + j + k));
                    }
                }
            }
            k /= 2;
        }
        p *= 2;
    }
    pairs
}

/// WGSL that sorts the variables x0, x1, … by the shader's function `before`.
pub(super) fn comparator_text(inputs: u32) -> String {
    let mut out = String::new();
    for (number, (a, b)) in comparators(inputs).into_iter().enumerate() {
        let _ = writeln!(out, "    let s{number} = before(x{b}, x{a});");
        let _ = writeln!(out, "    let t{number} = select(x{a}, x{b}, s{number});");
        let _ = writeln!(out, "    x{b} = select(x{b}, x{a}, s{number});");
        let _ = writeln!(out, "    x{a} = t{number};");
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn networks_sort_every_pattern_of_zeros_and_ones() {
        // By the zero-one principle that is every input.
        for n in [1u32, 2, 4, 8, 16] {
            let pairs = comparators(n);
            for pattern in 0u32..1 << n {
                let mut bits: Vec<u32> = (0..n).map(|i| pattern >> i & 1).collect();
                for &(a, b) in &pairs {
                    let (a, b) = (a as usize, b as usize);
                    (bits[a], bits[b]) = (bits[a].min(bits[b]), bits[a].max(bits[b]));
                }
                assert!(bits.is_sorted(), "{n} inputs, pattern {pattern:b}");
            }
        }
        // Knuth, TAOCP 3, 5.3.4: 191 comparators for 32 inputs.
        assert_eq!(comparators(32).len(), 191);
    }
}
