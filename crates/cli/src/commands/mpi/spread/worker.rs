//! A rank that does as the first one orders.

use std::process::ExitCode;
use std::sync::Arc;
use std::time::Instant;

use pellucid_core::points::{Points, Unreadable};
use pellucid_engine::Result;
use pellucid_engine::methods::{Frame, Renderer};
use pellucid_engine::passes::bands::Window;
use pellucid_engine::passes::portion::{Portion, Runs};
use pellucid_engine::passes::project::{DeviceCloud, Parts};

use super::super::ranks::{Ranks, decoded, encoded};
use super::super::turn::Turn;
use super::super::work::RankWork;
use super::frame::Own;
use super::orders::Order;
use super::supplied_from_nowhere;
use crate::commands::options::DeviceArgs;

/// The device of a rank, with what it knows of the scene.
struct Worker {
    renderer: Renderer,
    cloud: DeviceCloud,
    /// Points that stand for all.
    sample: Arc<Points>,
}

/// Does what the first rank orders until that has nothing more to do.
///
/// # Errors
/// Errors of the device and of rendering.
pub fn serve(device: &DeviceArgs, ranks: &Ranks) -> Result<ExitCode> {
    let (mut worker, mut portion) = (None, Portion::default());
    loop {
        match decoded(0, ranks) {
            Order::Open { known, parts, .. } => {
                let sample = read(ranks, |mut bytes| Points::unpack(&mut bytes)).standing_for(&known, String::new());
                worker = Some(Worker::open(device, ranks, sample, parts)?);
            }
            Order::Keep => read(ranks, |mut bytes| {
                while !bytes.is_empty() {
                    portion.add(Runs::unpack(&mut bytes)?);
                }
                Ok(())
            }),
            Order::Render { frame, rounds, timed, listed } => match &mut worker {
                Some(worker) => worker.render(ranks, (&frame, &rounds), &portion, (timed, listed))?,
                None => ranks.fail("rank 0 asked for a picture before it sent the scene", 1),
            },
            Order::Stop => return Ok(ExitCode::SUCCESS),
        }
    }
}

/// Reads an order from the bytes of the first rank.
fn read<T>(ranks: &Ranks, from: impl FnOnce(&[u8]) -> std::result::Result<T, Unreadable>) -> T {
    let bytes = ranks.received(0);
    from(&bytes).unwrap_or_else(|error| ranks.fail(&format!("points of rank 0: {error}"), 1))
}

impl Worker {
    fn open(asked: &DeviceArgs, ranks: &Ranks, sample: Points, parts: Option<(f32, Parts)>) -> Result<Self> {
        let renderer = Renderer::new(&ranks.device(asked)?)?;
        let sample = Arc::new(sample);
        let mut cloud = renderer.upload(&supplied_from_nowhere(&sample))?;
        if let Some((threshold, parts)) = parts {
            cloud.know_parts(threshold, parts);
        }
        Ok(Self { renderer, cloud, sample })
    }

    /// Renders this rank's regions, and sends them to the first rank.
    fn render(
        &mut self,
        ranks: &Ranks,
        (frame, rounds): (&Frame, &[Vec<Window>]),
        portion: &Portion,
        (timed, listed): (bool, bool),
    ) -> Result<()> {
        let before = ranks.traffic();
        ranks.meet();
        ranks.begin("rendering");
        let mut turn = Turn { begin: Instant::now(), work: RankWork::of(ranks), listed, ranks };
        let Self { renderer, cloud, sample } = self;
        renderer.timed = timed;
        let rendered = Own { renderer, cloud, frame, portion, sample }.rounds(&mut turn, rounds)?;
        ranks.begin("bringing parts together");
        turn.hand_in(rendered).into_iter().for_each(|image| renderer.recycle(image));
        let mut work = turn.work;
        work.note(ranks.traffic().since(before));
        ranks.send(0, &encoded(&work));
        Ok(())
    }
}
