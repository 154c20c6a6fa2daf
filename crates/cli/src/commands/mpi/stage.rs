//! The scene on the devices of all ranks: the same everywhere, as the first rank decides it.

use std::path::Path;
use std::process::ExitCode;

use pellucid_engine::scene::Error;
use pellucid_engine::{Result, plan};

use super::super::bar::Bar;
use super::super::console::Console;
use super::super::loaded::Resolved;
use super::super::render::{RenderArgs, is_png};
use super::super::session::Session;
use super::ranks::Ranks;
use super::together;
use crate::legend;

/// A scene on this rank's device.
pub struct Stage {
    pub resolved: Resolved,
    pub session: Session,
}

impl Stage {
    /// Brings what `resolve` reads to the device.
    ///
    /// # Errors
    /// The exit status, once the first rank has said what went wrong.
    pub fn open(
        args: &RenderArgs,
        output: &Path,
        ranks: &Ranks,
        (console, progress): (Console, &Bar),
        resolve: impl FnOnce() -> Result<Resolved>,
    ) -> std::result::Result<Self, ExitCode> {
        let checked = || {
            let resolved = resolve()?;
            legend::check(&resolved, console)?;
            Ok(resolved)
        };
        let resolved = together(ranks, checked())?;
        let all = ranks.all_told(&identity(&resolved));
        let other = all.iter().position(|one| *one != all[0]);
        let same = other.map_or(Ok::<_, pellucid_engine::Error>(()), |other| {
            Err(Error::Usage(format!(
                "rank {other} found another scene, other points or another version of pellucid than rank 0: all ranks have to see the \
                 same files"
            ))
            .into())
        });
        together(ranks, same)?;
        let mut session = together(ranks, open(args, output, &resolved, ranks, progress))?;
        agree(&mut session, &resolved, ranks);
        if ranks.is_first() {
            session.describe(console);
            session.warn(&resolved, console);
        }
        Ok(Self { resolved, session })
    }
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
    let stop = args.stop(output);
    let counted = args.aov || args.is_profiled();
    let mut session = if ranks.is_first() {
        Session::open(args.device(), resolved, counted, stop, progress)?
    } else {
        Session::upload(args.device(), resolved, counted, stop, progress)?
    };
    session.frame.depths = args.aov && !is_png(output);
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
