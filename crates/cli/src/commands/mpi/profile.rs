//! `pellucid-mpi profile`: what each pass costs, on each rank.

use pellucid_engine::profile;

use super::frame;
use super::ranks::Ranks;
use super::report::Report;
use super::share::Share;
use super::stage::RankScene;
use crate::commands::Error;
use crate::commands::console::Console;
use crate::commands::mpi_args::SharingArgs;
use crate::commands::options::refuse;
use crate::commands::profile::ProfileArgs;

/// Measures frames that all ranks render together.
///
/// # Errors
/// Errors of rendering, on any rank.
pub fn run(args: &ProfileArgs, sharing: &SharingArgs, ranks: &Ranks, console: Console) -> Result<(), Error> {
    let progress = console.progress();
    let mut cameras = Vec::new();
    let prepare = || {
        args.measure.check()?;
        let alone = args.pipelines || args.capture.is_some();
        refuse([(alone, "pellucid-mpi has no --pipelines and no --capture: use `pellucid profile` for them")])?;
        let (prepared, found) = args.prepare(&progress)?;
        cameras = found;
        Ok((prepared, if args.along.option().is_some() { cameras.len() } else { 1 }))
    };
    let mut stage = RankScene::open((&args.device, sharing.share), ranks, &progress, prepare)?;
    // The first frame pays for pipelines and buffers, and counts lists.
    let first = match stage.share {
        Share::Frames => frame::film(&mut stage, &vec![cameras[0]; ranks.count()], ranks, false)?,
        Share::Windows | Share::Samples => frame::render(&mut stage, ranks, false)?,
    };
    let counted = first.as_ref().map(|shared| {
        let lengths = shared.rendered.image.fragments.as_deref();
        (
            shared.rendered.facts.fragments,
            shared.rendered.facts.max_list,
            lengths.map(profile::histogram).unwrap_or_default(),
        )
    });
    if stage.session.frame.counts_on_demand() {
        stage.session.frame.fragments = false;
    }
    let mut report = Report::new(&stage.session, stage.share);
    report.spread = stage.spread.as_ref().map(|spread| spread.to_json());
    progress.counted("measuring", cameras.len() as u64);
    let listed = args.measure.trace.is_some();
    if stage.share == Share::Frames {
        frame::film(&mut stage, &cameras, ranks, listed)?.into_iter().for_each(|shared| drop(report.add(shared)));
    } else {
        for camera in &cameras {
            stage.session.look_through(*camera);
            if let Some(shared) = frame::render(&mut stage, ranks, listed)? {
                stage.session.renderer.recycle(report.add(shared));
            }
            progress.inc(1);
        }
    }
    progress.finish_and_clear();
    let Some((fragments, max_list, histogram)) = counted else { return Ok(()) };
    if args.along.option().is_none() {
        (report.profile.facts.fragments, report.profile.facts.max_list) = (fragments, max_list);
        report.profile.list_histogram = histogram;
    }
    stage.session.add_phases(&mut report.profile);
    report.write(&args.measure)?;
    if args.json {
        console.print_json(&report.to_json())?;
    } else {
        let passes = pellucid_lab::profile_table(&report.profile, None);
        let spread = stage.spread.as_ref().map_or_else(String::new, |spread| format!("\n{}", spread.described()));
        console.print(&format!("{passes}\n\n{}{spread}\n{}\n", report.table(), report.times()))?;
    }
    Ok(())
}
