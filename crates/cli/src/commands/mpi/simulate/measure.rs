//! Times that parts of a frame take on this rank's device.

use std::time::Instant;

use pellucid_engine::Result;
use pellucid_engine::methods::SamplePart;
use pellucid_engine::passes::bands::Window;
use pellucid_engine::profile::median;

use super::super::cut::is_empty;
use super::super::share::Share;
use super::super::stage::Stage;
use super::model::{Measured, Part, Parts, Sampled};

/// Parts into which an image is cut to be measured.
const PARTS: usize = 24;
/// How often each is rendered once points and pipelines are there, and after how many seconds no more.
const TIMES: usize = 3;
const ENOUGH: f64 = 3.0;

/// Measures the session's frame, whole and in parts of the kind that ranks would share.
///
/// # Errors
/// Those of rendering.
pub fn measure(stage: &mut Stage, frames: usize) -> Result<Measured> {
    let costs = stage.costs().clone();
    let alone = window(stage, None)?;
    let parts = match stage.share {
        Share::Frames => Parts::None,
        Share::Samples => samples(stage, alone)?.map_or(Parts::None, Parts::Samples),
        Share::Windows => {
            let windows = costs.windows(PARTS, 0, 0.0).into_iter().filter(|window| !is_empty(*window));
            let part = |of: Window| Ok(Part { window: of, seconds: window(stage, Some(of))?, load: costs.of(of) });
            Parts::Windows(windows.map(part).collect::<Result<_>>()?)
        }
    };
    Ok(Measured::new(alone, costs, parts, frames))
}

/// Median seconds of the frame, or of a window of it, until its image is on the host.
fn window(stage: &mut Stage, window: Option<Window>) -> Result<f64> {
    let session = &mut stage.session;
    session.renderer.region = window;
    let seconds = time(|| {
        let rendered = session.render()?;
        session.renderer.recycle(rendered.image);
        Ok(())
    });
    session.renderer.region = None;
    seconds
}

/// Measures half of the samples of a frame, of which all take `alone`.
fn samples(stage: &mut Stage, alone: f64) -> Result<Option<Sampled>> {
    let Some([total, step]) = stage.job.samples else { return Ok(None) };
    let session = &mut stage.session;
    let half = (total / 2).next_multiple_of(step).min(total);
    let mut part = None;
    let seconds = time(|| {
        part = Some(session.draw_part(0..half)?.part);
        Ok(())
    })?;
    let Some(mut sum) = part else { return Ok(None) };
    let rest = session.draw_part(half..total)?.part;
    let mut bytes = 0;
    let copy = time(|| {
        let sent = sum.to_bytes();
        bytes = sent.len();
        // Of other samples the parts would be added; that goes once over the same bytes.
        drop(SamplePart::from_bytes(&sent));
        Ok(())
    })?;
    let added = sum.add(rest).is_ok();
    let resolve = if added { time(|| session.resolve(&sum).map(drop))? } else { 0.0 };
    Ok(Some(Sampled::new(alone, [total, step], (half, seconds), copy, resolve, bytes)))
}

/// Median seconds of some work after its first time, which brings points and makes pipelines and buffers.
fn time(mut work: impl FnMut() -> Result<()>) -> Result<f64> {
    work()?;
    let (mut seconds, all) = (Vec::new(), Instant::now());
    while seconds.is_empty() || seconds.len() < TIMES && all.elapsed().as_secs_f64() < ENOUGH {
        let begin = Instant::now();
        work()?;
        seconds.push(begin.elapsed().as_secs_f64());
    }
    Ok(median(seconds))
}
