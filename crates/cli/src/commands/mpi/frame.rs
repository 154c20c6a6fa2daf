//! Renders a frame with all ranks.

use std::time::{Duration, Instant};

use pellucid_core::camera::StatedCamera;
use pellucid_engine::Result;
use pellucid_engine::methods::Rendered;

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
