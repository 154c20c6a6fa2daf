//! Renders a picture with all ranks.

use std::path::Path;
use std::process::ExitCode;

use pellucid_engine::Result;
use pellucid_session::Prepared;

use super::frame;
use super::ranks::Ranks;
use super::report::Report;
use super::setting::Setting;
use super::stage::Stage;
use crate::commands::console::Console;
use crate::commands::mpi_args::SharingArgs;
use crate::commands::render::{self, RenderArgs};

/// Renders the picture.
///
/// # Errors
/// Errors of rendering, on any rank.
pub fn run(
    args: &RenderArgs,
    sharing: &SharingArgs,
    output: &Path,
    ranks: &Ranks,
    console: Console,
) -> Result<ExitCode> {
    let progress = console.progress();
    let prepare = || {
        let mut request = args.request(output, &progress, console)?;
        request.frame.counts |= args.measure.is_asked();
        Ok((Prepared::new(request, &console, &progress)?, 1))
    };
    let setting = Setting { device: &args.device, share: sharing.share };
    let mut stage = match Stage::open(&setting, ranks, (console, &progress), prepare) {
        Ok(stage) => stage,
        Err(status) => return Ok(status),
    };
    let is_profiled = args.measure.is_asked();
    stage.session.renderer.timed = is_profiled || console.is_verbose();
    let Some(mut shared) = frame::render(&mut stage, ranks, is_profiled)? else { return Ok(ExitCode::SUCCESS) };
    let Stage { mut session, share, .. } = stage;
    session.frame.depths = false;
    session.judge(&shared.rendered.image, &console)?;
    progress.finish_and_clear();
    render::finish(args, &mut session, &mut shared.rendered, output, Vec::new(), console)?;
    let mut report = Report::new(&session, share);
    report.add(&shared);
    session.add_phases(&mut report.profile);
    console.detail(report.table());
    report.write(&args.measure)?;
    Ok(ExitCode::SUCCESS)
}
