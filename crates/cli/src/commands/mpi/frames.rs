//! The frames of a path: whole frames by each rank, or each frame by all.

use std::process::ExitCode;

use pellucid_engine::Result;
use pellucid_engine::methods::Rendered;
use pellucid_session::Session;

use super::desk::Desk;
use super::frame;
use super::ranks::{Ranks, together, told};
use super::share::Share;
use super::stage::RankScene;
use crate::commands::Error;
use crate::commands::along::Along;
use crate::commands::bar::Bar;
use crate::commands::frames::Pattern;
use crate::commands::interrupt;
use crate::commands::job::RenderJob;
use crate::commands::limit::usage;
use crate::commands::mpi_args::SharingArgs;
use crate::commands::sequence::{Due, Frames, Records};
use crate::legend;

/// Renders the frames that are not there yet.
///
/// # Errors
/// Errors of rendering, on any rank.
pub fn run(
    job: &RenderJob,
    sharing: &SharingArgs,
    (along, pattern): (&Along, &Pattern),
    ranks: &Ranks,
    progress: &Bar,
) -> Result<ExitCode, Error> {
    if job.args.measure.is_asked() || job.args.popping.is_some() {
        return Err(usage(
            "--profile, --trace and --popping of many frames are for pellucid; pellucid-mpi profile measures the frames of a path",
        )
        .into());
    }
    let mut cameras = Vec::new();
    let prepare = || {
        let (prepared, found) = along.prepare(job.request.clone(), progress)?;
        legend::check(&prepared, &found, job.args.legend, progress);
        cameras = found;
        Ok((prepared, cameras.len()))
    };
    let mut stage = RankScene::open((&job.args.device, sharing.share), ranks, progress, prepare)?;
    stage.session.renderer.timed = false;
    let mut frames = Frames::named(job, cameras, pattern, &stage.session);
    let found = if ranks.is_first() { frames.find(pattern) } else { Ok(()) };
    together(ranks, found)?;
    // Before anybody renders one: who looks later would find those of others.
    frames.there = told(frames.there, ranks);
    interrupt::defer();
    let rendered = match stage.share {
        Share::Frames => each_its_own(&frames, &mut stage, ranks, progress)?,
        Share::Windows | Share::Samples => each_by_all(&frames, &mut stage, ranks, progress)?,
    };
    progress.finish_and_clear();
    let all = ranks.all_told(&(rendered as u64).to_le_bytes());
    let rendered: u64 = all.iter().filter_map(|one| one.as_slice().try_into().ok()).map(u64::from_le_bytes).sum();
    let (count, before) = (frames.there.len() as u64, frames.there.iter().filter(|there| **there).count() as u64);
    progress.console.note(format_args!("{count} frames: {before} were there already, {rendered} were rendered"));
    Ok(if before + rendered < count { ExitCode::from(interrupt::STATUS) } else { ExitCode::SUCCESS })
}

/// Renders and writes, on each rank, frames as long as there are some; returns their number.
fn each_its_own(frames: &Frames<'_>, stage: &mut RankScene, ranks: &Ranks, progress: &Bar) -> Result<usize> {
    let missing = frames.missing();
    let session = &mut stage.session;
    let mut desk = Desk::open(ranks, missing.len());
    let mut numbers = desk.by_ref().map(|unit| missing[unit]);
    let due = Due { numbers: &mut numbers, count: missing.len(), render: &mut Session::render };
    let rendered = frames.render(session, &mut Records::default(), due, progress, progress.console)?;
    // Whoever was interrupted leaves the rest to nobody.
    desk.by_ref().for_each(drop);
    desk.close();
    Ok(rendered)
}

/// Renders each frame with all ranks, and writes it on the first one; returns the number of frames there.
fn each_by_all(frames: &Frames<'_>, stage: &mut RankScene, ranks: &Ranks, progress: &Bar) -> Result<usize> {
    let mut rendered = 0;
    progress.counted("frames", frames.missing().len() as u64);
    for number in frames.missing() {
        if told(interrupt::asked(), ranks) {
            break;
        }
        stage.session.look_through(frames.cameras[number]);
        let Some(shared) = frame::render(stage, ranks, false)? else { continue };
        let mut whole = Some(shared.rendered);
        let mut render =
            |session: &mut Session| -> Result<Rendered> { whole.take().map_or_else(|| session.render(), Ok) };
        let session = &mut stage.session;
        let due = Due { numbers: &mut std::iter::once(number), count: 1, render: &mut render };
        let console = if rendered == 0 { progress.console } else { progress.console.without_repeats() };
        rendered += frames.render(session, &mut Records::default(), due, progress, console)?;
    }
    Ok(rendered)
}
