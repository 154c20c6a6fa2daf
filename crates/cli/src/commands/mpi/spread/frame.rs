//! A frame of points that are distributed over all ranks.

use std::sync::Arc;

use pellucid_core::points::Points;
use pellucid_engine::Result;
use pellucid_engine::methods::{Frame, Rendered, Renderer};
use pellucid_engine::passes::bands::Window;
use pellucid_engine::passes::portion::{Portion, joined};
use pellucid_engine::passes::project::DeviceCloud;
use pellucid_scene::supply::HeldPoints;

use super::super::cut::is_empty;
use super::super::ranks::Ranks;
use super::super::stage::RankScene;
use super::super::turn::{GatheredFrame, Turn};
use super::super::work::ms;
use super::exchange::exchanged;
use super::orders::{self, Order};
use super::{PIECE, nowhere, rounds};

/// A rank's device, and its part of the points.
pub struct Own<'a> {
    pub renderer: &'a mut Renderer,
    pub cloud: &'a mut DeviceCloud,
    pub frame: &'a Frame,
    pub portion: &'a Portion,
    /// Points that stand for all.
    pub sample: &'a Points,
}

/// Orders the others to render the stage's frame; the regions of all, round by round. `None` where points are not
/// distributed.
pub fn order(stage: &mut RankScene, ranks: &Ranks, listed: bool) -> Option<Vec<Vec<Window>>> {
    let all = ranks.led()?;
    let (frame, timed) = (stage.session.frame, stage.session.renderer.timed);
    let room = stage.session.renderer.room(&stage.session.uploaded.cloud, &frame);
    let points = stage.session.uploaded.cloud.total();
    let rounds = rounds::rounds(stage.costs(), all.count(), points, room);
    orders::send_to_others(all, &Order::Render { frame, rounds: rounds.clone(), timed, listed }, None);
    Some(rounds)
}

/// The first rank's turn: its own regions, and those of all put together.
///
/// # Errors
/// Errors of rendering.
pub fn lead(stage: &mut RankScene, turn: &mut Turn<'_>, rounds: &[Vec<Window>]) -> Result<GatheredFrame> {
    let RankScene { session, spread, .. } = stage;
    let Some(spread) = spread else { return Ok(None) };
    let mut own = Own {
        renderer: &mut session.renderer,
        cloud: &mut session.uploaded.cloud,
        frame: &session.frame,
        portion: &spread.portion,
        sample: session.prepared.points(),
    };
    let rendered = own.rounds(turn, rounds)?.map_or_else(|| own.window(turn, [0; 4]), Ok)?;
    let whole = turn.put_together(session, rendered)?;
    session.renderer.region = None;
    Ok(Some(whole))
}

impl Own<'_> {
    /// Renders this rank's regions of all rounds into one image; `None` if all are empty.
    ///
    /// # Errors
    /// Errors of rendering.
    pub fn rounds(&mut self, turn: &mut Turn<'_>, rounds: &[Vec<Window>]) -> Result<Option<Rendered>> {
        let mut whole = None;
        for windows in rounds {
            self.bring(turn.ranks, windows);
            let window = windows[turn.ranks.own()];
            if is_empty(window) {
                continue;
            }
            let part = self.window(turn, window)?;
            turn.keep(&mut whole, part, window, self.renderer);
        }
        turn.work.work_ms = ms(turn.begin.elapsed());
        Ok(whole)
    }

    /// Has the points of a round here, those of other ranks too.
    fn bring(&mut self, ranks: &Ranks, windows: &[Window]) {
        // Before others come, the memory of those of the last round is given back.
        self.cloud.supply_by(Arc::new(nowhere(self.sample)));
        let beam = |window| self.renderer.beam(self.cloud, self.frame, window);
        let parts = exchanged(ranks, windows, self.portion, beam, PIECE);
        let parts = parts.unwrap_or_else(|error| ranks.fail(&format!("points of another rank: {error}"), 1));
        let Some(bounds) = self.sample.bounds().filter(|_| !parts.is_empty()) else { return };
        self.cloud.supply_by(Arc::new(HeldPoints::new(Arc::new(joined(parts, &bounds)))));
    }

    /// Renders a region. Of an empty one there is an image, too.
    pub fn window(&mut self, turn: &mut Turn<'_>, window: Window) -> Result<Rendered> {
        self.renderer.region = Some(window);
        let part = self.renderer.render(self.cloud, self.frame)?;
        self.renderer.device().check_validation()?;
        turn.work.add((&part.facts, &part.profile), turn.begin, turn.listed);
        Ok(part)
    }
}
