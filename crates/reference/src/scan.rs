//! Exclusive prefix sums: where each pixel's fragments begin.

/// `offsets[i]` is the sum of the counts before `i`; the last of the `counts.len() + 1` entries is the total. Pixel p
/// owns the fragments `offsets[p]..offsets[p + 1]`. In u64, which no image's counts can overflow: 2²⁸ pixels times 2³²
/// fragments stay below 2⁶⁴.
pub fn exclusive(counts: &[u32]) -> Vec<u64> {
    let sums = counts.iter().scan(0u64, |sum, &count| {
        *sum += u64::from(count);
        Some(*sum)
    });
    std::iter::once(0).chain(sums).collect()
}
