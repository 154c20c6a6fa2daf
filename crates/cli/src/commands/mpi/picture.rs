//! Renders a picture with all ranks.

use std::path::Path;

use pellucid_session::Prepared;

use super::frame;
use super::ranks::Ranks;
use super::report::Report;
use super::stage::RankScene;
use crate::commands::Error;
use crate::commands::bar::Bar;
use crate::commands::console::Console;
use crate::commands::job::RenderJob;
use crate::commands::mpi_args::SharingArgs;
use crate::commands::picture;

/// Renders the picture.
///
/// # Errors
/// Errors of rendering, on any rank.
pub fn run(
    job: &RenderJob,
    sharing: &SharingArgs,
    output: &Path,
    ranks: &Ranks,
    (console, progress): (Console, &Bar),
) -> Result<(), Error> {
    let is_profiled = job.measure.is_asked();
    let prepare = || {
        let mut request = job.request.clone();
        request.frame.counts |= is_profiled;
        Ok((Prepared::new(request, &console, progress)?, 1))
    };
    let mut stage = RankScene::open((&job.device, sharing.share), ranks, (console, progress), prepare)?;
    stage.session.renderer.timed = is_profiled || console.is_verbose();
    let Some(mut shared) = frame::render(&mut stage, ranks, is_profiled)? else { return Ok(()) };
    let RankScene { mut session, share, .. } = stage;
    session.frame.depths = false;
    session.judge(&shared.rendered.image, &console)?;
    progress.finish_and_clear();
    picture::finish(job, &mut session, &mut shared.rendered, output, Vec::new(), console)?;
    let mut report = Report::new(&session, share);
    report.add(shared);
    session.add_phases(&mut report.profile);
    console.detail(report.table());
    Ok(report.write(&job.measure)?)
}
