//! Merges in place: cut so that no invocation loops too long.

use crate::methods::abuffer::LOCAL_LENGTH;
use crate::methods::abuffer::passes::InPlacePush;

/// Iterations of all loops of an invocation together: one driver ends loops silently after 65 535.
const MOST_ITERATIONS: u32 = 60_000;

/// Iterations of one step of an in-place merge: half as many comparisons as fragments, and the loop over steps.
fn step_iterations(length: u32) -> u32 {
    length.div_ceil(2) + 1
}

/// Returns the longest list that is sorted in place: one step of a merge must stay within the iterations of an
/// invocation.
pub fn in_place_length() -> u32 {
    2 * (MOST_ITERATIONS - 1)
}

/// Returns the runs of `abuffer/merge-in-place` for lists of up to `longest` fragments: each level of merges is cut
/// where its iterations would be too many.
pub(super) fn in_place_merges(longest: u32) -> Vec<InPlacePush> {
    let at_once = (MOST_ITERATIONS / step_iterations(longest)).max(1);
    let mut found = Vec::new();
    for width_log in LOCAL_LENGTH.ilog2()..=(longest.max(2) - 1).ilog2() {
        // A level takes one step more than the logarithm of its width.
        for first in (0..=width_log).step_by(at_once as usize) {
            let distance_log = width_log - first;
            found.push(InPlacePush { width_log, distance_log, steps: at_once.min(distance_log + 1) });
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn merges_in_place_are_complete_and_within_the_iterations() {
        for longest in [257, 512, 513, 4000, 8192, 8193, 65_536, 65_537, in_place_length()] {
            let merges = in_place_merges(longest);
            let steps: Vec<_> =
                merges.iter().flat_map(|m| (0..m.steps).map(|s| (m.width_log, m.distance_log - s))).collect();
            let widths = 8..u32::BITS - (longest - 1).leading_zeros();
            assert_eq!(steps, widths.flat_map(|w| (0..=w).rev().map(move |d| (w, d))).collect::<Vec<_>>(), "{longest}");
            assert!(merges.iter().all(|m| m.steps * step_iterations(longest) <= MOST_ITERATIONS), "{longest}");
        }
        assert!(step_iterations(in_place_length() + 1) > MOST_ITERATIONS);
    }
}
