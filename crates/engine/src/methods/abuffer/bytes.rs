//! Bytes that passes over lists move.

use super::{FRAGMENT_BYTES, LINK_BYTES};
use crate::methods::bytes::PassRuns;

/// Returns the least number of bytes that a pass over lists must move, for any lengths; `tilted` if discs lie in their
/// tangent planes.
pub(crate) fn list_bytes(pass: &PassRuns<'_>, tilted: bool) -> Option<u64> {
    let (facts, pixels) = (pass.facts, pass.pixels());
    let stored = |fragment: u64| {
        let splats = facts.points * 8 * facts.bands + facts.visible * pass.splat(tilted);
        splats + facts.fragments * (8 + fragment)
    };
    match pass.name {
        "abuffer/clear" | "abuffer/measure" | "abuffer/classify" => Some(pixels * 4),
        "abuffer/cursors" | "abuffer/order" => Some(pixels * 8),
        "abuffer/count" => Some(pass.walks(tilted) + facts.fragments * 8),
        "abuffer/store" => Some(stored(FRAGMENT_BYTES)),
        // Besides the node, its link and the counter of nodes, read and written.
        "linked-list/store" => Some(stored(FRAGMENT_BYTES + LINK_BYTES + 8)),
        // Every run looks at all offsets.
        "linked-list/gather" => Some(pixels * 8 + facts.fragments * (2 * FRAGMENT_BYTES + LINK_BYTES)),
        _ => None,
    }
}
