//! Renders a picture with all ranks.

use std::path::Path;

use pellucid_session::Prepared;

use super::frame;
use super::ranks::Ranks;
use super::report::Report;
use super::stage::RankScene;
use crate::commands::Error;
use crate::commands::bar::Bar;
use crate::commands::job::RenderJob;
use crate::commands::mpi_args::SharingArgs;
use crate::commands::picture;
use crate::legend;

/// Renders the picture.
///
/// # Errors
/// Errors of rendering, on any rank.
pub fn run(job: &RenderJob, sharing: &SharingArgs, output: &Path, ranks: &Ranks, progress: &Bar) -> Result<(), Error> {
    let is_profiled = job.args.measure.is_asked();
    let prepare = || {
        let mut request = job.request.clone();
        request.frame.counts |= is_profiled;
        let prepared = Prepared::new(request, progress, progress)?;
        legend::check(&prepared, &[prepared.camera], job.args.legend, progress);
        Ok((prepared, 1))
    };
    let mut stage = RankScene::open((&job.args.device, sharing.share), ranks, progress, prepare)?;
    stage.session.renderer.timed = is_profiled || progress.console.is_verbose();
    let Some(mut shared) = frame::render(&mut stage, ranks, is_profiled)? else { return Ok(()) };
    let RankScene { mut session, share, .. } = stage;
    session.frame.depths = false;
    session.judge(&shared.rendered.image, progress)?;
    progress.finish_and_clear();
    let options = session.finish(&mut shared.rendered, Vec::new(), progress)?;
    picture::write(job, &session, &mut shared.rendered, options, output, progress)?;
    let mut report = Report::new(&session, share);
    report.add(shared);
    session.add_phases(&mut report.profile);
    progress.console.detail(report.table());
    Ok(report.write(&job.args.measure)?)
}
