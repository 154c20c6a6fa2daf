//! The least bytes that sorting and blending move.

use super::classes::{CLASSES, lower_bound};
use crate::methods::abuffer::{FRAGMENT_BYTES, LOCAL_LENGTH};

/// Returns the number of bytes that sorting and blending must at least read and write, from the lengths of all lists;
/// `None` without these, and for other passes.
pub fn least_bytes(name: &str, lengths: &[u32]) -> Option<u64> {
    // Record and splat color of each fragment; place in the work list, two offsets and result of each pixel.
    let blended = |fragments: u64, pixels: u64| fragments * (FRAGMENT_BYTES + 16) + pixels * (4 + 8 + 20);
    let between = |low: u32, high: u32| {
        let found = lengths.iter().filter(|n| (low + 1..=high).contains(*n));
        found.fold((0u64, 0u64), |(fragments, pixels), n| (fragments + u64::from(*n), pixels + 1))
    };
    if lengths.is_empty() {
        return None;
    }
    if let Some(class) = CLASSES.iter().position(|(_, class)| *class == name) {
        let (fragments, pixels) = between(lower_bound(class), CLASSES[class].0);
        return Some(blended(fragments, pixels));
    }
    let (fragments, _) = between(LOCAL_LENGTH, u32::MAX);
    let longest = lengths.iter().copied().max().unwrap_or(0);
    match name {
        "abuffer/sort-runs" => Some(fragments * 2 * FRAGMENT_BYTES),
        // Every merge moves all long lists, whether they are done already or not.
        "abuffer/merge" => {
            let merges = u64::from(longest.div_ceil(LOCAL_LENGTH).next_power_of_two().ilog2());
            Some(fragments * 2 * FRAGMENT_BYTES * merges)
        }
        "abuffer/blend-runs" => Some(blended(fragments, 0)),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn least_bytes_by_hand() {
        let lengths = [0, 1, 1, 3, 300, 600];
        assert_eq!(least_bytes("abuffer/resolve-1", &lengths), Some(2 * 24 + 2 * 32));
        assert_eq!(least_bytes("abuffer/resolve-4", &lengths), Some(3 * 24 + 32));
        assert_eq!(least_bytes("abuffer/resolve-8", &lengths), Some(0));
        assert_eq!(least_bytes("abuffer/sort-runs", &lengths), Some(900 * 16));
        // 600 fragments are three runs: two merges.
        assert_eq!(least_bytes("abuffer/merge", &lengths), Some(900 * 32));
        assert_eq!(least_bytes("abuffer/resolve-1", &[]), None);
        assert_eq!(least_bytes("project/splats", &lengths), None);
    }
}
