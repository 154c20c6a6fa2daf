//! What parts of a frame take on this rank's device.

use std::time::Instant;

use pellucid_engine::Result;
use pellucid_engine::passes::bands::Window;
use pellucid_engine::profile::median;

use super::super::cut::is_empty;
use super::super::stage::Stage;
use super::model::{Measured, Part};

/// Parts into which an image is cut to be measured.
const PARTS: usize = 24;
/// How often each is rendered once points and pipelines are there.
const TIMES: usize = 3;

/// Measures the session's frame, whole and in parts.
///
/// # Errors
/// Those of rendering.
pub fn measure(stage: &mut Stage, frames: usize) -> Result<Measured> {
    let costs = stage.costs().clone();
    let alone = time(stage, None)?;
    let windows = costs.windows(PARTS, 0, 0.0).into_iter().filter(|window| !is_empty(*window));
    let part = |window: Window| Ok(Part { window, seconds: time(stage, Some(window))?, load: costs.of(window) });
    let parts = windows.map(part).collect::<Result<Vec<Part>>>()?;
    Ok(Measured::new(alone, costs, parts, frames))
}

/// Median seconds of the frame, or of a window of it, until its image is on the host.
fn time(stage: &mut Stage, window: Option<Window>) -> Result<f64> {
    let session = &mut stage.session;
    session.renderer.region = window;
    session.renderer.timed = false;
    let mut seconds = Vec::new();
    for turn in 0..=TIMES {
        let begin = Instant::now();
        let rendered = session.render()?;
        // The first brings points, and makes pipelines and buffers.
        seconds.extend((turn > 0).then(|| begin.elapsed().as_secs_f64()));
        session.renderer.recycle(rendered.image);
    }
    session.renderer.region = None;
    Ok(median(seconds))
}
