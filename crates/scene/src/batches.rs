//! Work in batches that take a bounded amount of memory.

use std::ops::Range;

/// Returns runs of blocks with these numbers of points: at most `count` of them, that have at most `most` points
/// together if they are several.
pub(crate) fn batches(points: impl IntoIterator<Item = u64>, most: u64, count: usize) -> Vec<Range<usize>> {
    let (mut found, mut first, mut end, mut sum) = (Vec::new(), 0, 0, 0);
    for own in points {
        if end > first && (sum + own > most || end - first == count) {
            found.push(first..end);
            (first, sum) = (end, 0);
        }
        (end, sum) = (end + 1, sum + own);
    }
    if first < end {
        found.push(first..end);
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn batches_hold_all_blocks_and_few_points() {
        assert_eq!(batches([3, 3, 3, 9, 1], 6, 64), [0..2, 2..3, 3..4, 4..5]);
        assert_eq!(batches([5], 1, 64), vec![0..1]);
        assert!(batches([], 1, 64).is_empty());
        assert_eq!(batches([3, 3, 5, 20, 1, 1, 9, 2], 10, 64), [0..2, 2..3, 3..4, 4..6, 6..7, 7..8]);
        assert_eq!(batches([1; 150], 1000, 64), [0..64, 64..128, 128..150]);
    }
}
