//! Renders a frame with all ranks.

use std::time::{Duration, Instant};

use pellucid_core::camera::StatedCamera;
use pellucid_core::image::Image;
use pellucid_engine::Result;
use pellucid_engine::methods::{Frame, Mean, Rendered};
use pellucid_engine::passes::bands::Window;

use super::desk::Desk;
use super::ranks::Ranks;
use super::share::Share;
use super::spread;
use super::stage::RankScene;
use super::turn::{FrameTiming, Shared, Turn};
use super::work::{RankWork, imbalance, ms};

/// Renders a frame with all ranks; the first one gets it.
///
/// # Errors
/// Errors of rendering.
pub fn render(stage: &mut RankScene, ranks: &Ranks, listed: bool) -> Result<Option<Shared>> {
    let whole = stage.session.frame;
    // Eye-dome lighting needs all depths of an image, and random samples are summed up before they make one.
    let by_images = whole.is_mean() && (whole.shading.edl.edl || stage.share == Share::Samples);
    if !by_images || ranks.led().unwrap_or(ranks).count() == 1 {
        return image(stage, ranks, listed);
    }
    let mut mean: Option<MeanOfImages> = None;
    for frame in whole.images() {
        stage.session.frame = frame;
        let drawn = image(stage, ranks, listed);
        stage.session.frame = whole;
        let Some(shared) = drawn? else { continue };
        match &mut mean {
            None => mean = Some(MeanOfImages::new(&whole, shared)),
            Some(mean) => stage.session.renderer.recycle(mean.add(shared)),
        }
    }
    Ok(mean.map(MeanOfImages::finish))
}

/// The images of a frame that all ranks render one after the other, on the first rank: the sums of one process, in its
/// order.
struct MeanOfImages {
    sums: Mean,
    last: Shared,
}

impl MeanOfImages {
    /// Begins with the first image.
    fn new(whole: &Frame, first: Shared) -> Self {
        let mut sums = Mean::new(whole, &first.rendered.image);
        sums.add(&first.rendered.image, all_of(&first.rendered.image), true);
        Self { sums, last: first }
    }

    /// Adds another image; returns the one before, which is not needed any more.
    fn add(&mut self, next: Shared) -> Image {
        self.sums.add(&next.rendered.image, all_of(&next.rendered.image), false);
        let mut before = std::mem::replace(&mut self.last, next);
        self.last.follow(&mut before);
        before.rendered.image
    }

    /// Returns the mean, with the depths of the last image.
    fn finish(mut self) -> Shared {
        self.sums.finish(&mut self.last.rendered.image);
        self.last
    }
}

/// The window that is all of an image.
fn all_of(image: &Image) -> Window {
    [0, 0, image.width, image.height]
}

/// Renders a frame, or one of the images of which it is the mean, with all ranks.
fn image(stage: &mut RankScene, ranks: &Ranks, listed: bool) -> Result<Option<Shared>> {
    let (rounds, ranks) = (spread::frame::order(stage, ranks, listed), ranks.led().unwrap_or(ranks));
    ranks.meet();
    ranks.begin("rendering");
    let mut turn = Turn { begin: Instant::now(), work: RankWork::of(ranks), listed, ranks };
    let (before, read) = (ranks.traffic(), stage.bytes_read());
    let own = match stage.share {
        _ if rounds.is_some() => spread::frame::lead(stage, &mut turn, rounds.as_deref().unwrap_or_default())?,
        _ if ranks.count() == 1 => Some(turn.alone(&mut stage.session)?),
        Share::Samples => turn.samples(stage)?,
        Share::Windows | Share::Frames => turn.windows(stage)?,
    };
    turn.work.read = stage.bytes_read() - read;
    turn.work.note(ranks.traffic().since(before));
    let shared = turn.end(own);
    if let Some(Shared { measured: FrameTiming { work, .. }, .. }) = &shared
        && ranks.count() > 1
        && stage.share == Share::Windows
    {
        stage.learn(work, imbalance(work));
    }
    Ok(shared)
}

/// Renders the frames of cameras, each by one rank, which keeps it; the first one gets its last one, and what all did.
///
/// # Errors
/// Errors of rendering.
pub fn film(stage: &mut RankScene, cameras: &[StatedCamera], ranks: &Ranks, listed: bool) -> Result<Option<Shared>> {
    ranks.meet();
    let mut turn = Turn { begin: Instant::now(), work: RankWork::of(ranks), listed, ranks };
    let (before, read) = (ranks.traffic(), stage.bytes_read());
    let (mut desk, mut last, session) = (Desk::open(ranks, cameras.len()), None::<Rendered>, &mut stage.session);
    for number in desk.by_ref() {
        session.look_through(cameras[number]);
        last.into_iter().for_each(|last| session.renderer.recycle(last.image));
        let rendered = session.render()?;
        turn.work.add((&rendered.facts, &rendered.profile), turn.begin, listed);
        turn.work.frames.push(number as u32);
        last = Some(rendered);
    }
    desk.close();
    turn.work.work_ms = ms(turn.begin.elapsed());
    turn.work.read = stage.bytes_read() - read;
    turn.work.note(ranks.traffic().since(before));
    Ok(turn.end(last.filter(|_| ranks.is_first()).map(|last| (last, Duration::ZERO))))
}
