//! The vertical of a PLY file, which can't say it.

use glam::DVec3;

use pellucid_core::cloud::depth_camera::is_depth_camera;
use pellucid_core::cloud::upright::reason_for_z;
use pellucid_core::cloud::{Bounds, UpAxis};

/// Smallest coordinates of a survey that are not local ones, in its units.
const SURVEY: f64 = 1e4;

/// Points that the vertical is told from, at most twice as many: places of hundredths among them are those among all.
const SAMPLE: u64 = 1 << 17;

/// Returns n such that every n-th finite point of a file with `points` points tells the vertical.
pub(crate) fn step(points: u64) -> usize {
    (points / SAMPLE).max(1) as usize
}

/// Returns the vertical of points in a box, some of which are given: Y, as of models, but Z of what stands far from the
/// origin along X and Y alone, as surveys do whose coordinates are eastings, northings and heights, −Y in the frame of
/// a depth camera, and Z where only then the shape lies or stands as things do, with the reason.
pub(crate) fn vertical(bounds: &Bounds, sample: &[DVec3]) -> (UpAxis, Option<&'static str>) {
    let (center, diagonal) = (bounds.center().abs(), bounds.diagonal());
    let surveyed =
        center.x >= SURVEY && center.y >= SURVEY && center.z < SURVEY && diagonal < center.truncate().length();
    if surveyed {
        return (UpAxis::Z, None);
    }
    if is_depth_camera(sample) {
        return (UpAxis::NegativeY, None);
    }
    let reason = reason_for_z(sample);
    (if reason.is_some() { UpAxis::Z } else { UpAxis::Y }, reason)
}
