//! A rank's turn in a frame: its own part, and the parts of all put together.

use std::time::{Duration, Instant};

use pellucid_core::image::Image;
use pellucid_engine::Result;
use pellucid_engine::methods::{Rendered, Renderer, SamplePart};
use pellucid_engine::passes::bands::Window;
use pellucid_session::Session;

use super::cut::is_empty;
use super::desk::Desk;
use super::pixels;
use super::ranks::{Ranks, decoded, encoded};
use super::stage::RankScene;
use super::work::{RankWork, joined, ms};

/// A frame, on the first rank.
pub struct Shared {
    pub rendered: Rendered,
    pub measured: FrameTiming,
}

/// Measurements of a frame.
pub struct FrameTiming {
    /// Work of each rank.
    pub work: Vec<RankWork>,
    /// Time from the moment at which all ranks began until the image was whole.
    pub wall: Duration,
    /// The first rank's time for bringing the parts together, without that of waiting for them.
    pub gather: Duration,
}

impl Shared {
    /// Adds what was done for an image before this one, of the same frame.
    pub fn follow(&mut self, before: &mut Self) {
        let Self { rendered, measured } = self;
        let earlier = ms(before.measured.wall);
        for (work, before) in measured.work.iter_mut().zip(std::mem::take(&mut before.measured.work)) {
            work.follow(before, earlier);
        }
        measured.wall += before.measured.wall;
        measured.gather += before.measured.gather;
        joined(&mut rendered.facts, &measured.work);
    }
}

/// A rank's turn in a frame.
pub struct Turn<'a> {
    pub begin: Instant,
    pub work: RankWork,
    pub listed: bool,
    pub ranks: &'a Ranks,
}

/// The whole frame, and the time for bringing it together.
pub type GatheredFrame = Option<(Rendered, Duration)>;

impl Turn<'_> {
    /// Tells the first rank, which has the frame, what all did.
    pub fn end(self, own: GatheredFrame) -> Option<Shared> {
        let Self { begin, work, ranks, .. } = self;
        let Some((mut rendered, gather)) = own else {
            ranks.send(0, &encoded(&work));
            return None;
        };
        let mut all = vec![work];
        all.extend((1..ranks.count()).map(|rank| decoded(rank, ranks)));
        if ranks.count() > 1 {
            joined(&mut rendered.facts, &all);
        }
        Some(Shared { rendered, measured: FrameTiming { work: all, wall: begin.elapsed(), gather } })
    }

    /// The whole frame by one rank.
    pub fn alone(&mut self, session: &mut Session) -> Result<(Rendered, Duration)> {
        let rendered = session.render()?;
        self.work.add((&rendered.facts, &rendered.profile), self.begin, self.listed);
        self.work.work_ms = ms(self.begin.elapsed());
        Ok((rendered, Duration::ZERO))
    }

    /// Draws samples as long as there are some; the first rank gets the sums of all, and resolves them.
    pub fn samples(&mut self, stage: &mut RankScene) -> Result<GatheredFrame> {
        let ranges = stage.samples(self.ranks.count());
        let session = &mut stage.session;
        let (mut desk, mut own) = (Desk::open(self.ranks, ranges.len()), None::<SamplePart>);
        for range in desk.by_ref().map(|unit| ranges[unit].clone()).filter(|range| !range.is_empty()) {
            self.work.samples.push([range.start, range.end]);
            let drawn = session.draw_part(range)?;
            self.work.add((&drawn.facts, &drawn.profile), self.begin, self.listed);
            own = Some(self.sum(own, drawn.part));
        }
        self.work.work_ms = ms(self.begin.elapsed());
        self.ranks.begin("bringing parts together");
        let (begin, waited) = (Instant::now(), self.ranks.traffic().waited);
        let all = self.sum_of_all(own);
        let gather = begin.elapsed().saturating_sub(self.ranks.traffic().waited - waited);
        desk.close();
        let Some(all) = all else { return Ok(None) };
        let rendered = session.resolve(&all)?;
        self.work.add((&rendered.facts, &rendered.profile), self.begin, self.listed);
        Ok(Some((rendered, gather)))
    }

    /// The sums of two parts.
    fn sum(&self, own: Option<SamplePart>, other: SamplePart) -> SamplePart {
        let Some(mut sum) = own else { return other };
        sum.add(other).unwrap_or_else(|error| self.ranks.fail(&error.to_string(), 1));
        sum
    }

    /// Brings the sums of all ranks to the first one, by a tree: in each round half of the ranks that are left hand
    /// theirs to another one. Sums are exact, so that their order changes nothing.
    fn sum_of_all(&self, mut own: Option<SamplePart>) -> Option<SamplePart> {
        let (rank, count) = (self.ranks.own(), self.ranks.count());
        for distance in (0..).map(|power| 1 << power).take_while(|distance| *distance < count) {
            if rank % (2 * distance) != 0 {
                self.ranks.send(rank - distance, &encoded(&own));
                return None;
            }
            if rank + distance < count {
                let other: Option<SamplePart> = decoded(rank + distance, self.ranks);
                own = match other {
                    Some(other) => Some(self.sum(own, other)),
                    None => own,
                };
            }
        }
        own
    }

    /// Renders windows as long as there are some; the first rank puts those of all together.
    pub fn windows(&mut self, stage: &mut RankScene) -> Result<GatheredFrame> {
        let windows = stage.windows(self.ranks);
        let session = &mut stage.session;
        let (mut desk, mut own) = (Desk::open(self.ranks, windows.len()), None);
        for window in desk.by_ref().map(|unit| windows[unit]).filter(|window| !is_empty(*window)) {
            let part = self.window(session, window)?;
            self.keep(&mut own, part, window, &mut session.renderer);
        }
        self.work.work_ms = ms(self.begin.elapsed());
        self.ranks.begin("bringing parts together");
        let whole = if self.ranks.is_first() {
            let own = own.map_or_else(|| self.window(session, [0; 4]), Ok)?;
            Some(self.put_together(session, own)?)
        } else {
            self.hand_in(own).into_iter().for_each(|image| session.renderer.recycle(image));
            None
        };
        desk.close();
        session.renderer.region = None;
        Ok(whole)
    }

    /// Adds a rendered window to those before, if there are any.
    pub fn keep(&mut self, own: &mut Option<Rendered>, mut part: Rendered, window: Window, renderer: &mut Renderer) {
        match own {
            None => *own = Some(part),
            Some(Rendered { image, .. }) => {
                pixels::copy(image, &mut part.image, window);
                renderer.recycle(part.image);
            }
        }
        self.work.windows.push(window);
    }

    /// Renders a window. Of an empty one there is an image, too, into which the others are put.
    fn window(&mut self, session: &mut Session, window: Window) -> Result<Rendered> {
        session.renderer.region = Some(window);
        let part = session.render()?;
        self.work.add((&part.facts, &part.profile), self.begin, self.listed);
        Ok(part)
    }

    /// Sends this rank's windows to the first one; the image is not needed any more.
    pub fn hand_in(&self, own: Option<Rendered>) -> Option<Image> {
        let kinds = own.as_ref().map(|own| pixels::kinds(&own.image));
        self.ranks.send(0, &encoded(&(&self.work.windows, &kinds)));
        own.map(|mut own| {
            self.work.windows.iter().for_each(|window| pixels::send(&mut own.image, *window, self.ranks));
            own.image
        })
    }

    /// Takes the windows of the other ranks.
    pub fn put_together(&self, session: &mut Session, mut own: Rendered) -> Result<(Rendered, Duration)> {
        let (begin, waited) = (Instant::now(), self.ranks.traffic().waited);
        let size = [own.image.width, own.image.height];
        for rank in 1..self.ranks.count() {
            let (windows, kinds): (Vec<Window>, Option<Vec<bool>>) = decoded(rank, self.ranks);
            let fits = windows.iter().all(|w| !is_empty(*w) && w[2] <= size[0] && w[3] <= size[1]);
            if !fits || kinds.is_some_and(|kinds| kinds != pixels::kinds(&own.image)) {
                self.ranks.fail(&format!("rank {rank} sent other pixels than requested: {windows:?}"), 1);
            }
            windows.iter().for_each(|window| pixels::receive(&mut own.image, *window, rank, self.ranks));
        }
        if session.frame.shading.edl.edl {
            let Session { renderer, uploaded, frame, .. } = session;
            renderer.apply_edl(&uploaded.cloud, frame, &mut own.image)?;
        }
        Ok((own, begin.elapsed().saturating_sub(self.ranks.traffic().waited - waited)))
    }
}
