//! The frames of a path, dealt to the ranks in turn.

use std::process::ExitCode;

use pellucid_engine::Result;
use pellucid_engine::scene::Error;

use super::super::along::Along;
use super::super::console::Console;
use super::super::frames::Pattern;
use super::super::interrupt;
use super::super::render::RenderArgs;
use super::super::sequence::{Frames, Records};
use super::ranks::Ranks;
use super::stage::Stage;
use super::together;

/// Renders the frames that are not there yet.
///
/// # Errors
/// Those of rendering, on any rank.
pub fn run(args: &RenderArgs, along: &Along, pattern: &Pattern, ranks: &Ranks, console: Console) -> Result<ExitCode> {
    if args.is_profiled() || args.popping.is_some() {
        let problem = "--profile, --trace and --popping follow frames one after the other: they are for pellucid";
        return Err(Error::Usage(problem.to_owned()).into());
    }
    let progress = console.progress();
    let mut cameras = Vec::new();
    let output = pattern.file(0);
    let resolve = || {
        let (resolved, found) = along.resolve(&args.input, args.draws_legend(&output), console, &progress)?;
        cameras = found;
        Ok(resolved)
    };
    let stage = match Stage::open(args, &output, ranks, (console, &progress), resolve) {
        Ok(stage) => stage,
        Err(status) => return Ok(status),
    };
    let Stage { resolved, mut session } = stage;
    session.renderer.timed = false;
    let mut frames = Frames::named(args, cameras, pattern, &resolved, &session);
    let found = if ranks.is_first() { frames.find(args.overwrite, pattern) } else { Ok(()) };
    if let Err(status) = together(ranks, found) {
        return Ok(status);
    }
    // Before anybody renders one: who looks later would find those of others.
    let there = ranks.told(frames.there.iter().map(|there| u8::from(*there)).collect());
    frames.there = dealt(&there, ranks.own(), ranks.count());
    let mut records = Records::open(args, &frames, &resolved, &session)?;
    interrupt::defer();
    let rendered = frames.render(args, &resolved, &mut session, &mut records, &progress, console)?;
    progress.finish_and_clear();
    let all = ranks.all_told(&(rendered as u64).to_le_bytes());
    let rendered: u64 = all.iter().filter_map(|one| one.as_slice().try_into().ok()).map(u64::from_le_bytes).sum();
    let (count, before) = (there.len() as u64, there.iter().filter(|there| **there != 0).count() as u64);
    console.note(format_args!("{count} frames: {before} were there already, {rendered} were rendered"));
    Ok(if before + rendered < count { ExitCode::from(interrupt::STATUS) } else { ExitCode::SUCCESS })
}

/// For each frame, if a rank has nothing to do with it: those that are not there are dealt in turn.
fn dealt(there: &[u8], own: usize, count: usize) -> Vec<bool> {
    let mut next = (0..count).cycle();
    there.iter().map(|there| *there != 0 || next.next() != Some(own)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_frame_that_is_missing_goes_to_one_rank() {
        let there = [0, 1, 0, 0, 1, 0, 0];
        let all: Vec<Vec<bool>> = (0..3).map(|own| dealt(&there, own, 3)).collect();
        for (number, there) in there.iter().enumerate() {
            let takers = all.iter().filter(|rank| !rank[number]).count();
            assert_eq!(takers, usize::from(*there == 0));
        }
        assert_eq!(all[0], [false, true, true, true, true, false, true]);
    }
}
