//! Points that are not drawn: hidden by `[[cloud.class]]`, or cut off by `[[clip]]`.

use std::sync::Arc;

use glam::DVec3;
use rayon::prelude::*;

use super::clip::Clips;
use pellucid_core::parallel;
use pellucid_core::points::{Points, Unseen};

/// False for points that are not drawn, of points at these places in the scene; `None` if all are. `visible` is what
/// [`Rules::visible_points`](super::classes::Rules::visible_points) says of them.
pub(super) fn seen(visible: Option<Vec<bool>>, clips: &Clips, positions: &[DVec3]) -> Option<Vec<bool>> {
    if clips.is_empty() {
        return visible;
    }
    let is_seen = |i: usize| visible.as_ref().is_none_or(|visible| visible[i]) && clips.keep(positions[i]);
    Some(parallel::map(positions.len(), is_seen))
}

/// Drops points that are marked, and those that a huge `scale` or `translate` moved out of float64; sets those apart
/// that are not `seen`. Returns marks on the remaining ones, or `None` if all remain.
pub(super) fn leave_out(points: &mut Points, seen: Option<&[bool]>, dropped: Option<&[bool]>) -> Option<Vec<bool>> {
    if seen.is_none() && dropped.is_none() && points.positions.par_iter().all(|position| position.is_finite()) {
        return None;
    }
    let is_seen = |i: usize| seen.is_none_or(|seen| seen[i]);
    let is_there = |i: usize| dropped.is_none_or(|dropped| !dropped[i]);
    let each = points.positions.iter().enumerate();
    let keep: Vec<_> = each.map(|(i, p)| p.is_finite() && is_there(i) && is_seen(i)).collect();
    if keep.iter().all(|keep| *keep) {
        return None;
    }
    let is_unseen = |i: &usize| !keep[*i] && is_there(*i) && points.positions[*i].is_finite();
    let mut unseen: Vec<usize> = (0..points.len()).filter(is_unseen).collect();
    if !points.file_order.is_empty() {
        // They stay in the order of the file, wherever the others are.
        unseen.par_sort_unstable_by_key(|i| points.file_order[*i]);
    }
    let (positions, radii) = unseen.into_iter().map(|i| (points.positions[i], points.radii[i])).unzip();
    points.unseen = Arc::new(Unseen { positions, radii });
    points.retain(&keep);
    Some(keep)
}
