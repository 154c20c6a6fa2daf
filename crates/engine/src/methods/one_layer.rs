//! `one-layer`: the nearest soft points make a transparent layer before everything else, which is opaque (Seemann et
//! al. 2018). Three-pass splats ([`super::splats`]) of the soft points give the layer; those of all points, soft ones
//! only where they lie behind it, give the rest.
//!
//! Reference: `pellucid_reference::one_layer`.

use super::tiled;
use crate::methods::abuffer::{self, list_bytes};
use crate::methods::prelude::*;
use crate::methods::splats::{self, Onto, SOLID_BYTES, draw_solid, solid_projecting};
use crate::scene::OneLayer;

gpu_struct! {
    /// Push constants of `one-layer/compose`: pixels of the window, and the layer's opacity.
    pub struct ComposePush {
        count: u32,
        softness: f32, // Opacity of the layer.
    }
}

pass! {
    /// Composes the splats of the soft points over those of all others in each pixel, where they lie before the solid
    /// ones.
    pub Compose(ComposePush) = "one-layer/compose" in "one_layer/compose" {
        layer: Read<[f32; 4]>,
        layer_depths: Read<f32>,
        into: Shared<PixelsGroup>,
    }
}

/// Records the layer of a window over the opaque pixels.
pub fn record<'a>(
    recorder: &mut Recorder<'a>,
    layer: Pixels<'a>,
    onto: Pixels<'a>,
    window: Window,
    softness: f32,
) -> Result<(), Error> {
    let pixels = bands::pixels(window);
    let pass = Compose { layer: layer.image, layer_depths: layer.depths, into: onto };
    let push = ComposePush { count: pixels as u32, softness };
    Ok(recorder.run(&pass, push, &Run::new(Dispatch::Invocations(pixels)))?)
}

/// Returns the pass.
pub fn shaders() -> Vec<Shader> {
    vec![Shader::plain::<Compose>()]
}

/// The nearest soft points as a transparent layer over everything else.
pub(crate) struct OneLayerEngine {
    /// The threshold of soft points, and the opacity of the layer.
    pub settings: OneLayer,
}

/// Counts the splats of each pixel.
fn count(
    cloud: &DeviceCloud,
    buffers: &mut Buffers,
    work: &mut Work<'_>,
    (stats, footprint): (&[Stats], Footprint),
) -> Result<Outcome, Error> {
    let Buffers { tiles, resources } = buffers;
    let Some(budget) = work.reserve_tiles(tiles, stats, true)? else { return Ok(Outcome::Overflow) };
    work.budget = budget;
    let raster = Raster { cloud, stats, tiles, walker: Walker::Compute, footprint, window: work.window };
    resources.lists.tally(work, raster)
}

impl Engine for OneLayerEngine {
    fn needs_subgroups(&self, _device: &DeviceInfo) -> bool {
        true
    }

    fn windows(&self, frame: &Frame, budget: Budget) -> Result<Vec<Window>, Error> {
        Ok(windows_of(frame, budget, tiled::counted_bytes(frame) + SOLID_BYTES))
    }

    fn channels(&self) -> Channels {
        Channels::LISTS_BESIDE
    }

    /// Draws soft points into the layer, then all points, soft ones only behind the layer, and lays the layer over
    /// them. Without a layer it draws the solid points. The last projection holds every splat that covers a pixel, so
    /// that it is the one to be counted.
    fn render(&self, cloud: &mut DeviceCloud, buffers: &mut Buffers, work: &mut Work<'_>) -> Result<Outcome, Error> {
        let OneLayer { threshold, softness } = self.settings;
        if work.frame.fragments {
            // Large splats are binned behind the layer: memory for their tiles is set aside.
            work.budget.tiles = work.budget.bytes / 8;
        }
        let counted = if work.frame.fragments { abuffer::PIXEL_BYTES } else { 0 };
        let mut met = None;
        if cloud.parts(threshold).soft > 0 {
            let how = solid_projecting(work.frame, cloud, CloudPart::Soft { threshold, modulation: None });
            let stats = work.project(cloud, &how)?;
            if !work.survey {
                buffers.resources.layer.reserve(work.device, work.pixels())?;
            }
            let splats = (&*stats, how.footprint, Onto::Layer);
            if draw_solid(cloud, buffers, work, splats, counted)? == Outcome::Overflow {
                return Ok(Outcome::Overflow);
            }
            met = Some(stats);
        }
        let layered = met.iter().any(|stats| stats.iter().any(|s| s.visible > 0));
        let (part, onto) = if layered {
            (CloudPart::Marked(threshold), Onto::TargetBehindLayer)
        } else {
            (CloudPart::Solid(threshold), Onto::Target)
        };
        let how = solid_projecting(work.frame, cloud, part);
        let stats = work.project(cloud, &how)?;
        if work.frame.fragments && count(cloud, buffers, work, (&stats, how.footprint))? == Outcome::Overflow {
            return Ok(Outcome::Overflow);
        }
        if draw_solid(cloud, buffers, work, (&stats, how.footprint, onto), counted)? == Outcome::Overflow {
            return Ok(Outcome::Overflow);
        }
        work.facts.layered += u64::from(layered);
        if let Some(found) = met.map(|met| met.found) {
            work.note_later(move |facts, timeline| facts.meet(&found.stats(timeline)));
        }
        work.note(&stats, Walker::Compute);
        if layered && !work.survey {
            let mut recorder = work.timeline.recorder(work.device)?;
            let layer = &buffers.resources.layer;
            record(&mut recorder, layer.pixels(), work.target.pixels(), work.window, softness)?;
            work.timeline.go_on(recorder, "one-layer/compose")?;
        }
        work.read_back()?;
        Ok(Outcome::Done)
    }
}

impl Explain for OneLayerEngine {
    /// The number of solid splats is unknown.
    fn least_bytes(&self, pass: &PassRuns<'_>) -> Option<u64> {
        let counted = || list_bytes(pass, false).filter(|_| pass.name != "abuffer/count");
        pass.projected(false).or_else(counted)
    }

    fn explain(&self, plan: &mut FramePlan<'_>) {
        plan.projected();
        splats::explain_windows(plan, abuffer::counted_beside);
    }
}

/// Returns the pass that lays the layer over everything else.
pub(crate) fn pass_group() -> PassGroup {
    PassGroup::new(&["one-layer/compose"], Absent::Always("no layer of soft points"))
}
