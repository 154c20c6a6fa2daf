//! One picture: each rank renders a band of its rows.

use std::path::Path;
use std::process::ExitCode;

use pellucid_engine::Result;
use pellucid_engine::methods::{Facts, Rendered};

use super::super::console::Console;
use super::super::loaded::read;
use super::super::opacity_notes;
use super::super::render::{self, RenderArgs};
use super::super::session::Session;
use super::bands::bands;
use super::planes::{bytes_of, packed, unpack};
use super::ranks::Ranks;
use super::stage::Stage;

/// Renders the picture.
///
/// # Errors
/// Those of rendering, on any rank.
pub fn run(args: &RenderArgs, output: &Path, ranks: &Ranks, console: Console) -> Result<ExitCode> {
    let progress = console.progress();
    let resolve = || {
        let loaded = read(&args.input, None, console, &progress)?.with_legend(args.draws_legend(output));
        loaded.resolve(None, console, &progress)
    };
    let stage = match Stage::open(args, output, ranks, (console, &progress), resolve) {
        Ok(stage) => stage,
        Err(status) => return Ok(status),
    };
    let Stage { resolved, mut session } = stage;
    let Some(mut rendered) = share(args, &mut session, ranks)? else { return Ok(ExitCode::SUCCESS) };
    if session.frame.shading.edl.edl {
        let Session { renderer, cloud, frame, .. } = &mut session;
        renderer.apply_edl(cloud, frame, &mut rendered.image)?;
    }
    opacity_notes::judge(&mut session, &resolved, &rendered.image, console)?;
    progress.finish_and_clear();
    render::finish(args, &resolved, &mut session, &mut rendered, output, Vec::new(), console)?;
    Ok(ExitCode::SUCCESS)
}

/// Renders this rank's band; the first rank puts all of them together.
fn share(args: &RenderArgs, session: &mut Session, ranks: &Ranks) -> Result<Option<Rendered>> {
    session.renderer.timed = args.is_profiled();
    let bands = bands(session, ranks.count())?;
    let [first, last] = bands[ranks.own()];
    let width = session.frame.size[0];
    // A band without rows still makes an image, into which the others are put.
    session.renderer.region = Some([0, first, width, last.max(first + u32::from(ranks.is_first()))]);
    if first == last && !ranks.is_first() {
        return Ok(None);
    }
    let mut rendered = session.render()?;
    session.renderer.region = None;
    if !ranks.is_first() {
        let Facts { fragments, max_list, .. } = rendered.facts;
        ranks.send(0, &bytes_of(&[fragments, u64::from(max_list)]));
        ranks.send(0, &packed(&mut rendered.image, [first, last]));
        return Ok(None);
    }
    for (rank, rows) in bands.iter().enumerate().skip(1).filter(|(_, rows)| rows[0] < rows[1]) {
        take(&mut rendered, rank, *rows, ranks);
    }
    Ok(Some(rendered))
}

/// Takes a rank's rows.
fn take(rendered: &mut Rendered, rank: usize, rows: [u32; 2], ranks: &Ranks) {
    let counts = ranks.received(rank);
    let count =
        |at: usize| counts.get(8 * at..8 * at + 8).and_then(|b| b.try_into().ok()).map_or(0, u64::from_le_bytes);
    rendered.facts.fragments += count(0);
    rendered.facts.max_list = rendered.facts.max_list.max(count(1) as u32);
    let bytes = ranks.received(rank);
    if unpack(&mut rendered.image, rows, &bytes).is_none() {
        ranks.fail(&format!("rank {rank} sent {} bytes for rows {} to {}", bytes.len(), rows[0], rows[1]), 1);
    }
}
