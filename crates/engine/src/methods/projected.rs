//! The projection of a cloud's points to the splats of a window, and what it found.

use std::ops::Deref;

use super::{Error, Frame, Timeline};
use crate::gpu::Device;
use crate::passes::bands::Window;
use crate::passes::foresight::AnswerPlace;
use crate::passes::project::{DeviceCloud, Projecting, Stats};

/// The results of a projection by chunk, or upper bounds of them.
pub(crate) struct Projected {
    stats: Vec<Stats>,
    /// The results themselves.
    pub found: PendingStats,
}

/// The results of a projection, once it was submitted.
#[derive(Clone, Copy)]
pub(crate) struct PendingStats(AnswerPlace);

impl PendingStats {
    /// Returns the results by chunk.
    pub fn stats(self, timeline: &Timeline) -> Vec<Stats> {
        stats_of(timeline.found(self.0))
    }
}

impl Deref for Projected {
    type Target = [Stats];

    fn deref(&self) -> &[Stats] {
        &self.stats
    }
}

fn stats_of(words: &[u32]) -> Vec<Stats> {
    bytemuck::pod_collect_to_vec(words)
}

/// Projects a cloud's points to splats of a window of a frame. Returns the results by chunk.
pub(crate) fn project(
    device: &Device,
    cloud: &mut DeviceCloud,
    (frame, window): (&Frame, Window),
    how: &Projecting,
    timeline: &mut Timeline,
) -> Result<Projected, Error> {
    cloud.make_room(device)?;
    cloud.reserve_tilts(device, how.footprint)?;
    cloud.set_view(&frame.camera, frame.size, window, how);
    let mut recorder = timeline.recorder(device)?;
    cloud.record_project(&mut recorder, how)?;
    let names = ("project/stats", "project/splats");
    let answer = timeline.ask(device, recorder, names, &[cloud.found().cast()])?;
    let [width, height] = [window[2] - window[0], window[3] - window[1]];
    let most = |((_, count), s): ((u64, u64), Stats)| s.at_most(count, [width, height]);
    let stats = cloud.chunks().zip(stats_of(&answer.words)).map(most).collect();
    Ok(Projected { stats, found: PendingStats(answer.place) })
}
