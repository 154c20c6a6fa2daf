//! One picture: each rank renders a band of its rows.

use std::path::Path;
use std::process::ExitCode;

use pellucid_engine::image::Image;
use pellucid_engine::methods::{Facts, Rendered, Stop};
use pellucid_engine::scene::Error;
use pellucid_engine::{Result, plan};

use super::super::bar::Bar;
use super::super::console::Console;
use super::super::loaded::{Resolved, read};
use super::super::opacity_notes;
use super::super::render::{self, RenderArgs, Target};
use super::super::session::Session;
use super::bands::bands;
use super::planes::{bytes_of, packed, unpack};
use super::ranks::Ranks;
use super::together;
use crate::legend;

pub fn run(args: &RenderArgs, ranks: &Ranks, console: Console) -> Result<ExitCode> {
    let progress = console.progress();
    let prepared = together(ranks, prepare(args, ranks, &progress, console));
    let (output, resolved) = match prepared {
        Ok(prepared) => prepared,
        Err(status) => return Ok(status),
    };
    let identity = identity(&resolved);
    let all = ranks.all_told(&identity);
    if let Some(other) = all.iter().position(|one| *one != all[0]) {
        let problem = format!(
            "rank {other} has another scene, other points or another version of pellucid than rank 0; all ranks have to see the same files"
        );
        return together::<()>(ranks, Err(Error::Usage(problem).into())).map_or_else(Ok, |()| Ok(ExitCode::FAILURE));
    }
    let mut session = match together(ranks, open(args, &output, &resolved, ranks, &progress)) {
        Ok(session) => session,
        Err(status) => return Ok(status),
    };
    agree(&mut session, &resolved, ranks);
    if ranks.is_first() {
        session.describe(console);
        session.warn(&resolved, console);
    }
    let rendered = share(args, &mut session, ranks)?;
    let Some(mut rendered) = rendered else { return Ok(ExitCode::SUCCESS) };
    if session.frame.shading.edl.edl {
        let Session { renderer, cloud, frame, .. } = &mut session;
        renderer.apply_edl(cloud, frame, &mut rendered.image)?;
    }
    opacity_notes::judge(&mut session, &resolved, &rendered.image, console)?;
    progress.finish_and_clear();
    render::finish(args, &resolved, &mut session, &mut rendered, &output, Vec::new(), console)?;
    Ok(ExitCode::SUCCESS)
}

/// Reads scene and points, and checks that the first rank can write the picture.
fn prepare(
    args: &RenderArgs,
    ranks: &Ranks,
    progress: &Bar,
    console: Console,
) -> Result<(std::path::PathBuf, Resolved)> {
    let usage = |problem: &str| Err(Error::Usage(problem.to_owned()).into());
    if args.chooses() {
        return usage(
            "--max-error, --budget and --recalibrate measure one device; choose with pellucid, and give the method here",
        );
    }
    if args.deep.is_asked() {
        return usage("--deep is for pellucid: a deep file is written row by row while it is rendered");
    }
    let Target::One(output) = Target::from_args(args)? else {
        return usage("pellucid-mpi renders one picture yet; frames are for pellucid");
    };
    let _ = ranks;
    let loaded = read(&args.input, None, console, progress)?.with_legend(args.draws_legend(&output));
    let resolved = loaded.resolve(None, console, progress)?;
    legend::check(&resolved, console)?;
    Ok((output, resolved))
}

/// What has to be the same on all ranks.
fn identity(resolved: &Resolved) -> Vec<u8> {
    let Resolved { scene, camera, seed, .. } = resolved;
    let points = resolved.points();
    let written = format!(
        "{} {} {camera:?} {seed} {} {:?}",
        env!("CARGO_PKG_VERSION"),
        scene.settings,
        points.positions.len(),
        points.bounds()
    );
    blake3::hash(written.as_bytes()).as_bytes().to_vec()
}

/// Brings the points to the device; the first rank decides the method and the opacity, too.
fn open(args: &RenderArgs, output: &Path, resolved: &Resolved, ranks: &Ranks, progress: &Bar) -> Result<Session> {
    let stop: Stop = args.stop(output);
    let counted = args.aov || args.is_profiled();
    let mut session = if ranks.is_first() {
        Session::open(args.device(), resolved, counted, stop, progress)?
    } else {
        Session::upload(args.device(), resolved, counted, stop, progress)?
    };
    session.frame.depths = args.aov && !render::is_png(output);
    Ok(session)
}

/// Takes over what the first rank has decided.
fn agree(session: &mut Session, resolved: &Resolved, ranks: &Ranks) {
    let own = [session.frame.method.name().as_bytes(), &session.frame.factors.opacity.to_le_bytes()].concat();
    let said = ranks.told(own);
    let (name, factor) = said.split_at(said.len().saturating_sub(4));
    if let Ok(factor) = factor.try_into() {
        session.frame.factors.opacity = f32::from_le_bytes(factor);
    }
    let choice = resolved.scene.method;
    let methods = [plan::resolve(choice, resolved.points()).0, choice.representative()];
    if let Some(method) = methods.into_iter().find(|method| method.name().as_bytes() == name) {
        session.frame.method = method;
    }
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
    let image: &mut Image = &mut rendered.image;
    if unpack(image, rows, &bytes).is_none() {
        ranks.fail(&format!("rank {rank} sent {} bytes for rows {} to {}", bytes.len(), rows[0], rows[1]), 1);
    }
}
