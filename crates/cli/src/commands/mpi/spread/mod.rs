//! `--spread`: each rank has a part of the points in memory, and the first one alone reads files.
//!
//! The first rank runs the command as if it was alone, and orders the others what to do. It distributes the points,
//! run by run, as it reads them. For each frame every rank sends the points that may show in another rank's region to
//! that rank, and renders its own region from what it received.

pub mod deal;
mod exchange;
pub mod frame;
pub mod orders;
mod rounds;
pub mod worker;

use std::sync::Arc;

use pellucid_core::points::Points;
use pellucid_core::progress::Phase;
use pellucid_engine::{Result, methods};
use pellucid_scene::prepare::{Arranged, Supplied};
use pellucid_scene::supply::HeldPoints;
use pellucid_scene::{Error, MethodChoice};
use pellucid_session::{Prepared, Session};

use self::deal::{Dealer, Spread};
use self::orders::Order;
use super::ranks::Ranks;
use crate::commands::bar::Bar;
use crate::commands::mpi_args::Wanted;
use crate::commands::options::DeviceArgs;

/// Bytes of a message with points, about: with that many the next message begins.
const PIECE: usize = 16 << 20;

/// Opens the device of the first rank as if it was alone, decides the method, and deals the points to all ranks.
///
/// # Errors
/// Settings that don't work with distributed points; errors of reading points and of the device.
pub fn open(
    (device, wanted): (&DeviceArgs, Wanted),
    prepared: Prepared,
    all: &Ranks,
    progress: &Bar,
) -> Result<(Session, Spread)> {
    refuse(wanted, &prepared)?;
    // Method and opacity are those of a rank alone, which has all points at once.
    let by_windows = matches!(prepared.scene().method, MethodChoice::Fixed(_)) && prepared.see_through().is_none();
    progress.begin(Phase::Upload);
    let mut session = Session::upload(&all.device(device)?, prepared, by_windows, progress)?;
    session.decide(progress)?;
    session.settle(progress)?;
    session.frame.depths = session.prepared.request.frame.depths;
    let parts = session.frame.method.threshold().map(|threshold| {
        session.uploaded.cloud.find_parts(threshold, progress)?;
        Ok::<_, methods::Error>((threshold, session.uploaded.cloud.parts(threshold)))
    });
    let parts = parts.transpose()?;
    progress.stage("dealing points to ranks");
    let points = session.points();
    let known = points.known().ok_or_else(|| Error::Usage("--spread: the scene has no points".to_owned()))?;
    let sample = sample(&session.prepared)?;
    orders::send_to_others(
        all,
        &Order::Open { known: known.clone(), frame: session.frame, parts },
        Some(&packed(&sample)),
    );
    let mut dealer = Dealer::new(all, &known, PIECE);
    let identity = dealer.deal(session.assembled(), progress)?;
    let read = session.assembled().stored().map_or(0, |stored| stored.bytes_read()[0]);
    let spread = dealer.finish(read);
    // The points themselves are not needed here any more.
    let sample = Arc::new(sample.standing_for(&known, identity));
    session.uploaded.cloud = session.renderer.upload(&supplied_from_nowhere(&sample))?;
    if let Some((threshold, parts)) = parts {
        session.uploaded.cloud.know_parts(threshold, parts);
    }
    match session.assembled().stored() {
        Some(stored) => stored.forget(),
        None => {
            let supply = Arc::new(HeldPoints::new(Arc::default()));
            session.prepared.assembled.replace(Arranged::Supplied(Supplied { supply, sample, dealt: None }));
        }
    }
    Ok((session, spread))
}

/// Refuses what needs all points in one place.
fn refuse(wanted: Wanted, prepared: &Prepared) -> Result<()> {
    let scene = prepared.scene();
    let problem = match wanted {
        Wanted::Ensembles | Wanted::Frames => Some("each rank has points for its windows alone: --share windows"),
        _ if scene.method.is_dealt() => Some("the method deals all points to ensembles, which each rank has to see"),
        _ if scene.shadows.is_some() || prepared.assembled.shadow_texture.is_some() => {
            Some("shadows fall from points of other ranks")
        }
        _ if !scene.detail.is_whole() => {
            Some("which points are left out follows from all of them (--detail, --max-points)")
        }
        _ => None,
    };
    problem.map_or(Ok(()), |problem| Err(Error::Usage(format!("--spread: {problem}")).into()))
}

/// Points that stand for all, at least one.
fn sample(prepared: &Prepared) -> Result<Points> {
    let sample = prepared.points().sampled_points();
    let Some(stored) = prepared.assembled.stored().filter(|_| sample.is_empty()) else { return Ok(sample) };
    let origin = prepared.points().anchor().origin;
    for block in 0..stored.blocks().len() {
        let points = stored.block(block).map_err(deal::failed)?;
        if !points.is_empty() {
            return Ok(sample.with_one(origin, || points.subset(&[0], 1.0)));
        }
    }
    Ok(sample)
}

fn packed(points: &Points) -> Vec<u8> {
    let mut bytes = Vec::new();
    points.pack(&mut bytes);
    bytes
}

/// Points that come from other ranks; a sample stands for them.
fn supplied_from_nowhere(sample: &Arc<Points>) -> Arranged {
    Arranged::Supplied(Supplied { supply: Arc::new(nowhere(sample)), sample: Arc::clone(sample), dealt: None })
}

/// Streams a single point of the scene, for regions in which no point shows.
fn nowhere(sample: &Points) -> HeldPoints {
    let first: Vec<u32> = (0..sample.len().min(1) as u32).collect();
    HeldPoints::new(Arc::new(Points { unseen: Arc::default(), whole: None, ..sample.subset(&first, 1.0) }))
}
