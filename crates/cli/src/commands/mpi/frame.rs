//! One frame by all ranks.

use std::time::{Duration, Instant};

use pellucid_engine::Result;
use pellucid_engine::methods::Rendered;
use pellucid_engine::passes::bands::Window;

use super::cut::is_empty;
use super::desk::Desk;
use super::pixels;
use super::ranks::Ranks;
use super::share::Share;
use super::spread;
use super::stage::Stage;
use super::work::{Work, joined, ms};
use crate::commands::session::Session;

/// A frame, on the first rank.
pub struct Shared {
    pub rendered: Rendered,
    /// What each rank did.
    pub work: Vec<Work>,
    /// From the moment at which all ranks began until the image was whole.
    pub wall: Duration,
    /// The first rank's time for bringing the parts together, without that of waiting for them.
    pub gather: Duration,
}

/// Renders a frame with all ranks; the first one gets it.
///
/// # Errors
/// Those of rendering.
pub fn render(stage: &mut Stage, ranks: &Ranks, listed: bool) -> Result<Option<Shared>> {
    let (rounds, ranks) = (spread::frame::order(stage, ranks, listed)?, ranks.led().unwrap_or(ranks));
    ranks.meet();
    let mut turn = Turn { begin: Instant::now(), work: Work::of(ranks), listed, ranks };
    let (before, read) = (ranks.traffic(), stage.bytes_read());
    let own = match stage.share {
        _ if rounds.is_some() => spread::frame::lead(stage, &mut turn, rounds.as_deref().unwrap_or_default())?,
        _ if ranks.count() == 1 => Some(turn.alone(&mut stage.session)?),
        _ => turn.windows(stage)?,
    };
    let Turn { begin, mut work, .. } = turn;
    work.read = stage.bytes_read() - read;
    work.note(ranks.traffic().since(before));
    let Some((mut rendered, gather)) = own else {
        ranks.send(0, &encoded(&work));
        return Ok(None);
    };
    let mut all = vec![work];
    all.extend((1..ranks.count()).map(|rank| decoded(rank, ranks)));
    if ranks.count() > 1 {
        joined(&mut rendered.facts, &all);
    }
    Ok(Some(Shared { rendered, work: all, wall: begin.elapsed(), gather }))
}

/// A rank's turn in a frame.
pub(super) struct Turn<'a> {
    pub(super) begin: Instant,
    pub(super) work: Work,
    pub(super) listed: bool,
    pub(super) ranks: &'a Ranks,
}

/// The whole frame, and the time for bringing it together.
pub(super) type Whole = Option<(Rendered, Duration)>;

impl Turn<'_> {
    /// The whole frame by one rank.
    fn alone(&mut self, session: &mut Session) -> Result<(Rendered, Duration)> {
        let rendered = session.render()?;
        self.work.add(&rendered, self.begin, self.listed);
        self.work.work_ms = ms(self.begin.elapsed());
        Ok((rendered, Duration::ZERO))
    }

    /// Renders windows as long as there are some; the first rank puts those of all together.
    fn windows(&mut self, stage: &mut Stage) -> Result<Whole> {
        let windows = stage.windows(self.ranks.count());
        let session = &mut stage.session;
        let (mut desk, mut own) = (Desk::open(self.ranks, windows.len()), None);
        for window in desk.by_ref().map(|unit| windows[unit]).filter(|window| !is_empty(*window)) {
            let mut part = self.window(session, window)?;
            match &mut own {
                None => own = Some(part),
                Some(Rendered { image, .. }) => {
                    pixels::copy(image, &mut part.image, window);
                    session.renderer.recycle(part.image);
                }
            }
            self.work.windows.push(window);
        }
        self.work.work_ms = ms(self.begin.elapsed());
        let whole = if self.ranks.is_first() {
            let own = own.map_or_else(|| self.window(session, [0; 4]), Ok)?;
            Some(self.put_together(session, own)?)
        } else {
            self.hand_in(own);
            None
        };
        desk.close();
        session.renderer.region = None;
        Ok(whole)
    }

    /// Renders a window. Of an empty one there is an image, too, into which the others are put.
    fn window(&mut self, session: &mut Session, window: Window) -> Result<Rendered> {
        session.renderer.region = Some(window);
        let part = session.render()?;
        self.work.add(&part, self.begin, self.listed);
        Ok(part)
    }

    /// Sends this rank's windows to the first one.
    pub(super) fn hand_in(&self, own: Option<Rendered>) {
        let kinds = own.as_ref().map(|own| pixels::kinds(&own.image));
        self.ranks.send(0, &encoded(&(&self.work.windows, &kinds)));
        if let Some(mut own) = own {
            self.work.windows.iter().for_each(|window| pixels::send(&mut own.image, *window, self.ranks));
        }
    }

    /// Takes the windows of the other ranks.
    pub(super) fn put_together(&self, session: &mut Session, mut own: Rendered) -> Result<(Rendered, Duration)> {
        let (begin, waited) = (Instant::now(), self.ranks.traffic().waited);
        let size = [own.image.width, own.image.height];
        for rank in 1..self.ranks.count() {
            let (windows, kinds): (Vec<Window>, Option<Vec<bool>>) = decoded(rank, self.ranks);
            let fits = windows.iter().all(|w| !is_empty(*w) && w[2] <= size[0] && w[3] <= size[1]);
            if !fits || kinds.is_some_and(|kinds| kinds != pixels::kinds(&own.image)) {
                self.ranks.fail(&format!("rank {rank} sent other pixels than were asked for: {windows:?}"), 1);
            }
            windows.iter().for_each(|window| pixels::receive(&mut own.image, *window, rank, self.ranks));
        }
        if session.frame.shading.edl.edl {
            let Session { renderer, cloud, frame, .. } = session;
            renderer.apply_edl(cloud, frame, &mut own.image)?;
        }
        Ok((own, begin.elapsed().saturating_sub(self.ranks.traffic().waited - waited)))
    }
}

/// A value as bytes for another rank.
pub(super) fn encoded(value: &impl serde::Serialize) -> Vec<u8> {
    serde_json::to_vec(value).unwrap_or_default()
}

/// The value that a rank sends; another one than expected ends all ranks.
pub(super) fn decoded<T: serde::de::DeserializeOwned>(from: usize, ranks: &Ranks) -> T {
    serde_json::from_slice(&ranks.received(from))
        .unwrap_or_else(|error| ranks.fail(&format!("rank {from} sent something else than expected: {error}"), 1))
}
