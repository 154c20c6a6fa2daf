//! The samples' passes over the splats as their paper has them: by multisampled rasterization (`raster = "hardware"`).
//!
//! A stratum is two draws of all splats. In the first one the depth test keeps the nearest fragment of each sample
//! among those whose mask has the sample; the second one compares every fragment with what the samples of its pixel
//! hold, and sums by blending. Splats are drawn in canonical order, so that the depth test settles ties by index, and
//! sums come in the same order every time.

use super::{Batch, SampleJob, SampleKind, Sampler, most_strata};
use crate::gpu::{Blend, DepthSamples, Format, NumberSamples, Pixels, SAMPLES, ScratchAttachment, Targets};
use crate::methods::prelude::*;
use crate::passes::raster::QuadsGroup;
use crate::random::{STRATA_OF_A_CALL, STRATUM};

gpu_struct! {
    /// Push constants of the draws.
    pub struct StratumPush {
        first: u32, // Index of the chunk's first splat among all.
        key_low: u32, // The key of the stratum's random words, and which of the two it takes.
        key_high: u32,
        word: u32,
        samples: u32, // Samples of the stratum that count, 1 to 4.
        base: u32, // Scale of held depths.
        shift: u32,
    }

    /// Push constants of `stochastic/fold`.
    pub struct FoldPush {
        width: u32, // Columns and pixels of the window.
        pixels: u32,
        stratum: u32, // This stratum among the run's.
        samples: u32, // Its samples that count, 1 to 4.
        first: u32, // 1 for the very first stratum.
        base: u32, // Scale of held depths.
        shift: u32,
    }
}

pass! {
    /// Draws all splats and blends the total opacity of each pixel; only for alpha correction.
    pub DrawAlpha(StratumPush) = "stochastic/draw-alpha" in "stochastic/draw_alpha" {
        quads: Shared<QuadsGroup>,
    }

    /// Draws all splats once for each 4 samples; the depth test keeps the nearest fragment of each sample among those
    /// whose mask has it.
    pub DrawHeld(StratumPush) = "stochastic/draw-held" in "stochastic/draw_held" {
        quads: Shared<QuadsGroup>,
        ids: Read<u32>,
    }

    /// Draws all splats once for each 4 samples, and blends color and opacity over the samples that hold nothing
    /// nearer.
    pub DrawSums(StratumPush) = "stochastic/draw-sums" in "stochastic/draw_sums" {
        quads: Shared<QuadsGroup>,
        depths: Texture<DepthSamples>,
        indices: Texture<NumberSamples>,
    }

    /// Moves 4 samples of each pixel from the attachments into the buffers that compute shaders fill elsewhere, with
    /// the nearest depth.
    pub Fold(FoldPush) = "stochastic/fold" {
        held_depths: Texture<DepthSamples>,
        drawn: Texture<Pixels>,
        drawn_alpha: Texture<Pixels>,
        sums: ReadWrite<[f32; 4]>,
        exact: ReadWrite<f32>,
        depths: ReadWrite<f32>,
    }
}

/// The variant of `stochastic/fold`.
fn fold_variant(kind: SampleKind) -> Variant {
    kind.apply_to(Variant::plain())
}

/// Map from depth keys to depths for the test, which has 2³⁰ of them for 2³² keys: `held_depth` in WGSL.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct HeldDepths {
    base: u32,
    shift: u32,
}

impl HeldDepths {
    /// Returns the map for a camera and a footprint. Where all depths are positive, it holds 126 octaves of them,
    /// beginning 40 before the near plane: none is lost. Only tilted discs in orthographic views and Gaussians along a
    /// ray reach depths of both signs, and lose the key's last two bits.
    pub fn new(camera: &Camera, footprint: Footprint) -> Self {
        let near = camera.near as f32;
        let orthographic = matches!(camera.projection, Projection::Orthographic { .. });
        if near <= 0.0 || footprint == Footprint::Gaussian || (orthographic && footprint == Footprint::Oriented) {
            return Self { base: 0, shift: 2 };
        }
        let least = near.to_bits().saturating_sub(40 << 23).max(f32::MIN_POSITIVE.to_bits());
        Self { base: least | 1 << 31, shift: 0 }
    }
}

/// One stratum of a batch.
#[derive(Clone, Copy)]
struct Stratum {
    batch: Batch,
    /// Number of the stratum in the batch.
    number: u32,
    depths: HeldDepths,
}

impl Stratum {
    /// Samples that count.
    fn samples(&self) -> u32 {
        (self.batch.left - self.number * STRATUM).min(STRATUM)
    }

    fn push(&self, job: &SampleJob<'_>) -> StratumPush {
        let stratum = self.batch.before / STRATUM + self.number;
        let [key_low, key_high] = job.key(stratum / STRATA_OF_A_CALL);
        let HeldDepths { base, shift } = self.depths;
        StratumPush {
            first: 0,
            key_low,
            key_high,
            word: stratum % STRATA_OF_A_CALL,
            samples: self.samples(),
            base,
            shift,
        }
    }

    fn fold_push(&self, job: &SampleJob<'_>) -> FoldPush {
        let HeldDepths { base, shift } = self.depths;
        FoldPush {
            width: size(job.bin.raster.window)[0],
            pixels: job.pixels() as u32,
            stratum: self.number,
            samples: self.samples(),
            first: u32::from(self.batch.before == job.first && self.number == 0),
            base,
            shift,
        }
    }
}

fn size([x0, y0, x1, y1]: Window) -> [u32; 2] {
    [x1 - x0, y1 - y0]
}

/// Returns `true` if a window shows anything.
pub fn is_seen(raster: &Raster<'_>) -> bool {
    raster.stats.iter().any(|s| s.visible > 0)
}

fields! {
    /// Attachments, kept from frame to frame: 52 bytes per pixel.
    pub struct Attachments {
        depths: ScratchAttachment = ScratchAttachment::new("sample depths", Format::Depth, SAMPLES),
        indices: ScratchAttachment = ScratchAttachment::new("sample indices", Format::Number, SAMPLES),
        sums: ScratchAttachment = ScratchAttachment::new("stratum sums", Format::Color, 1),
        alphas: ScratchAttachment = ScratchAttachment::new("total opacity", Format::Number, 1),
    }
}

impl Attachments {
    fn reserve(&mut self, device: &Device, size: [u32; 2]) -> Result<(), Error> {
        for image in [&mut self.depths, &mut self.indices, &mut self.sums, &mut self.alphas] {
            image.reserve(device, size)?;
        }
        Ok(())
    }

    /// Frees them.
    pub(super) fn release(&mut self) {
        for image in [&mut self.depths, &mut self.indices, &mut self.sums, &mut self.alphas] {
            image.release();
        }
    }
}

impl Sampler {
    /// Renders a window into the target by the rasterizer, or keeps its sums.
    pub(crate) fn draw(&mut self, work: &mut Work<'_>, job: &SampleJob<'_>, depths: HeldDepths) -> Result<(), Error> {
        let (device, target) = (work.device, work.target);
        self.keys.release();
        self.indices.release();
        self.reserve_sums(device, job.pixels(), job.kind(), most_strata(job.batches()))?;
        self.attachments.reserve(device, size(job.bin.raster.window))?;
        if !is_seen(&job.bin.raster) {
            return self.end_empty(work, job);
        }
        work.facts.bands += 1;
        for batch in job.batches() {
            let mut recorder = work.timeline.recorder(device)?;
            if batch.before == 0 && job.finds_exact() {
                let stratum = Stratum { batch: Batch { before: 0, left: STRATUM, strata: 1 }, number: 0, depths };
                let color = Some((self.attachments.alphas.get(), Blend::Cover));
                let targets = Targets { color, depth: None, clear: Some(0.0) };
                let push = |first| StratumPush { first, ..stratum.push(job) };
                job.bin.raster.draw(
                    &mut recorder,
                    &draw_variant(job),
                    targets,
                    |quads, _| DrawAlpha { quads },
                    push,
                )?;
            }
            for number in 0..batch.left.div_ceil(STRATUM) {
                self.record_stratum(&mut recorder, job, Stratum { batch, number, depths }, target)?;
            }
            self.end_batch(recorder, work, (job, batch), "stochastic/draw-held and draw-sums")?;
        }
        self.end(work, job)
    }

    fn record_stratum<'a>(
        &'a self,
        recorder: &mut Recorder<'a>,
        job: &SampleJob<'a>,
        stratum: Stratum,
        target: &'a Target,
    ) -> Result<(), Error> {
        let Attachments { depths, indices, sums, alphas } = &self.attachments;
        let (depths, indices, drawn) = (depths.get(), indices.get(), sums.get());
        let (raster, variant) = (job.bin.raster, draw_variant(job));
        let push = |first| StratumPush { first, ..stratum.push(job) };
        let held = Targets { color: Some((indices, Blend::Replace)), depth: Some(depths), clear: Some(f32::MAX) };
        raster.draw(recorder, &variant, held, |quads, ids| DrawHeld { quads, ids }, push)?;
        let summed = Targets { color: Some((drawn, Blend::Add)), depth: None, clear: Some(0.0) };
        raster.draw(recorder, &variant, summed, |quads, _| DrawSums { quads, depths, indices }, push)?;
        let fold = Fold {
            held_depths: depths,
            drawn,
            // Without correction total opacity was never drawn; something must be bound in its place.
            drawn_alpha: if job.finds_exact() { alphas.get() } else { drawn },
            sums: self.sums.get().all(),
            exact: self.exact.get().all(),
            depths: target.depths(),
        };
        let push = stratum.fold_push(job);
        let kind = SampleKind { exact: job.finds_exact(), ..job.kind() };
        let run = Run::new(Dispatch::Invocations(job.pixels())).variant(fold_variant(kind));
        Ok(recorder.run(&fold, push, &run)?)
    }
}

fn draw_variant(job: &SampleJob<'_>) -> Variant {
    compose::shape_variant(job.bin.raster.footprint, job.settings.discs.falloff)
}

/// Returns the number of bytes that a pass must at least read and write in its `runs`: `quads` those of all splats,
/// `pixels` those of the image.
pub fn least_bytes(name: &str, runs: u64, strata: u64, quads: u64, pixels: u64) -> Option<u64> {
    // Depths and indices of the samples, and a color.
    let (held, color) = (32, 16);
    match name {
        "stochastic/draw-alpha" => Some(runs * quads + pixels * 4),
        "stochastic/draw-held" => Some(runs * quads + strata * pixels * held),
        "stochastic/draw-sums" => Some(runs * quads + strata * pixels * (held + color)),
        "stochastic/fold" => Some(strata * pixels * (held / 2 + 2 * color + 4)),
        _ => None,
    }
}

/// Returns the passes with their variants.
pub(super) fn shaders() -> Vec<Shader> {
    vec![
        Shader::new::<DrawAlpha>(compose::shape_variants()),
        Shader::new::<DrawHeld>(compose::shape_variants()),
        Shader::new::<DrawSums>(compose::shape_variants()),
        Shader::new::<Fold>(SampleKind::all().into_iter().map(fold_variant)),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    #[test]
    fn the_depth_test_tells_all_positive_depths_apart() {
        let camera = |projection, near| {
            Camera::look_at(DVec3::ZERO, DVec3::Z, DVec3::Y, projection, near, 1e6).expect("a valid camera")
        };
        let perspective = Projection::Perspective { fov_y: 1.0 };
        let orthographic = Projection::Orthographic { height: 1.0 };
        let near = 0.5f32.to_bits() | 1 << 31;
        for footprint in [Footprint::Disc, Footprint::Oriented] {
            let found = HeldDepths::new(&camera(perspective, 0.5), footprint);
            assert_eq!(found, HeldDepths { base: near - (40 << 23), shift: 0 });
        }
        // 2⁻¹⁰⁰ is 26 octaves above the smallest.
        let tiny = HeldDepths::new(&camera(perspective, 0.5f64.powi(100)), Footprint::Disc);
        assert_eq!(tiny, HeldDepths { base: 0x8080_0000, shift: 0 });
        assert_eq!(HeldDepths::new(&camera(orthographic, 0.5), Footprint::Disc).shift, 0);
        for (near, footprint) in [(0.5, Footprint::Oriented), (0.0, Footprint::Disc), (-3.0, Footprint::Disc)] {
            assert_eq!(HeldDepths::new(&camera(orthographic, near), footprint), HeldDepths { base: 0, shift: 2 });
        }
    }

    #[test]
    fn drawing_takes_no_more_memory_than_the_windows_leave() {
        for spread in [false, true] {
            let drawn = 52 + 16 * SampleKind { exact: true, spread }.sums(super::super::MOST_STRATA);
            assert!(drawn + 4 + if spread { 32 } else { 0 } <= super::super::pixel_bytes(spread));
        }
    }
}
