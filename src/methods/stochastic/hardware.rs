//! `raster = "hardware"`: stochastic transparency as its paper has it, by multisampled rasterisation.
//!
//! A stratum is two draws of all splats. The first one lets the depth test keep the nearest fragment of each sample among
//! those whose mask has the sample; the second one compares every fragment with what the samples of its pixel hold, and sums
//! by blending. A compute pass then takes the stratum into means and spread. Splats are drawn in canonical order, so that
//! the depth test settles ties by index, and sums come in the same order every time.

use indicatif::ProgressBar;

use crate::camera::{Camera, Projection};
use crate::gpu::{
    Blend, DepthSamples, Device, Dispatch, Format, Kept, KeptAttachment, Memory, NumberSamples, Pixels, Recorder, Run,
    SAMPLES, Targets, Variant,
};
use crate::methods::abuffer::record_nothing;
use crate::methods::Error;
use crate::methods::bands::{self, Window};
use crate::methods::renderer::{Facts, Target, Timeline};
use crate::passes::compose;
use crate::passes::project::Footprint;
use crate::passes::raster::{QuadsGroup, Raster};
use crate::random::{self, STRATA_OF_A_CALL, STRATUM};
use crate::scene::{Falloff, Stochastic};
use crate::{gpu_struct, pass};

/// Strata of a submission: drivers stop one that takes too long.
const BATCH: u32 = 16;
/// Device bytes per pixel of a window: depths and indices of the samples, sums, total opacity, moments, standard error.
pub const PIXEL_BYTES: u64 = 16 + 16 + 16 + 4 + 48 + 16;

gpu_struct! {
    /// Push constants of the draws; shaders/shared/stochastic_quad.wgsl says what the members are.
    pub struct StratumPush {
        first: u32,
        key_low: u32,
        key_high: u32,
        word: u32,
        samples: u32,
        base: u32,
        shift: u32,
    }
}

gpu_struct! {
    /// Push constants of the passes over pixels; shaders/shared/moments.wgsl says what the members are.
    pub struct MomentsPush {
        width: u32,
        count: u32,
        stratum: u32,
        samples: u32,
        weight: f32,
        corrected: u32,
        base: u32,
        shift: u32,
    }
}

pass! {
    /// Total opacity of each pixel.
    pub Alpha(StratumPush) = "stochastic/alpha" in "stochastic/alpha.frag" {
        quads: Shared<QuadsGroup>,
    }
}

pass! {
    /// The nearest fragment of each sample.
    pub Hold(StratumPush) = "stochastic/hold" in "stochastic/hold.frag" {
        quads: Shared<QuadsGroup>,
    }
}

pass! {
    /// What is visible of each fragment, summed.
    pub Accumulate(StratumPush) = "stochastic/accumulate" in "stochastic/accumulate.frag" {
        quads: Shared<QuadsGroup>,
        depths: Texture<DepthSamples>,
        indices: Texture<NumberSamples>,
    }
}

pass! {
    /// A stratum into means and spread.
    pub Fold(MomentsPush) = "stochastic/fold" {
        depths: Texture<DepthSamples>,
        sums: Texture<Pixels>,
        means: ReadWrite<[f32; 4]>,
        squares: ReadWrite<[f32; 4]>,
        products: ReadWrite<[f32; 4]>,
    }
}

pass! {
    /// Means and spread to the image.
    pub Estimate(MomentsPush) = "stochastic/estimate" {
        alphas: Texture<Pixels>,
        means: Read<[f32; 4]>,
        squares: Read<[f32; 4]>,
        products: Read<[f32; 4]>,
        image: ReadWrite<[f32; 4]>,
        depths: ReadWrite<f32>,
        errors: ReadWrite<[f32; 4]>,
    }
}

/// The variant of a draw.
pub fn quad_variant(footprint: Footprint, falloff: Falloff) -> Variant {
    compose::shape_variant(footprint, falloff)
}

/// How depth keys become depths for the test, which has 2³⁰ of them for 2³² keys: `held_depth` in WGSL.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct HeldDepths {
    base: u32,
    shift: u32,
}

impl HeldDepths {
    /// Where all depths are positive, 126 octaves of them, beginning 40 before the near plane: none is lost. Only tilted
    /// discs in orthographic views reach depths of both signs, which lose the key's last two bits.
    fn new(camera: &Camera, footprint: Footprint) -> Self {
        let near = camera.near as f32;
        let orthographic = matches!(camera.projection, Projection::Orthographic { .. });
        if near <= 0.0 || (orthographic && footprint == Footprint::Oriented) {
            return Self { base: 0, shift: 2 };
        }
        let least = near.to_bits().saturating_sub(40 << 23).max(f32::MIN_POSITIVE.to_bits());
        Self { base: least | 1 << 31, shift: 0 }
    }
}

/// Everything that stays the same while a window is rendered.
#[derive(Clone, Copy)]
pub struct WindowJob<'a> {
    /// The projected cloud.
    pub raster: Raster<'a>,
    /// The camera.
    pub camera: &'a Camera,
    /// Discs and samples.
    pub stochastic: Stochastic,
    /// Seed of the masks.
    pub seed: u64,
    /// Says how far it is.
    pub progress: &'a ProgressBar,
}

impl WindowJob<'_> {
    /// Whether the window shows anything.
    pub fn is_seen(&self) -> bool {
        self.raster.stats.iter().any(|s| s.visible > 0)
    }

    fn strata(&self) -> u32 {
        self.stochastic.samples.div_ceil(STRATUM)
    }

    /// Samples of a stratum that count.
    fn samples(&self, stratum: u32) -> u32 {
        (self.stochastic.samples - stratum * STRATUM).min(STRATUM)
    }

    fn size(&self) -> [u32; 2] {
        let [x0, y0, x1, y1] = self.raster.window;
        [x1 - x0, y1 - y0]
    }

    fn push(&self, stratum: u32) -> StratumPush {
        let [key_low, key_high] = random::key(self.seed);
        let HeldDepths { base, shift } = HeldDepths::new(self.camera, self.raster.footprint);
        StratumPush {
            first: 0,
            key_low,
            key_high: key_high.wrapping_add(stratum / STRATA_OF_A_CALL),
            word: stratum % STRATA_OF_A_CALL,
            samples: self.samples(stratum),
            base,
            shift,
        }
    }

    fn moments(&self, stratum: u32) -> MomentsPush {
        let HeldDepths { base, shift } = HeldDepths::new(self.camera, self.raster.footprint);
        let samples = self.stochastic.samples.min((stratum + 1) * STRATUM);
        MomentsPush {
            width: self.size()[0],
            count: bands::pixels(self.raster.window) as u32,
            stratum: stratum + 1,
            samples: self.samples(stratum),
            weight: samples as f32 / (STRATUM * (stratum + 1)) as f32,
            corrected: u32::from(self.stochastic.alpha_correction),
            base,
            shift,
        }
    }
}

/// Bytes that a pass must at least read and write in its `runs`: `quads` those of all splats, `pixels` those of the image.
pub fn least_bytes(name: &str, runs: u64, strata: u64, quads: u64, pixels: u64) -> Option<u64> {
    let (held, sum, moments) = (32, 16, 48);
    match name {
        "stochastic/alpha" => Some(runs * quads + pixels * 4),
        "stochastic/hold" => Some(runs * quads + strata * pixels * held),
        "stochastic/accumulate" => Some(runs * quads + strata * pixels * (held + sum)),
        // The first stratum reads no moments.
        "stochastic/fold" => Some(strata * pixels * (held / 2 + sum + moments) + (strata - 1) * pixels * moments),
        "stochastic/estimate" => Some(pixels * (4 + moments + 20 + 16)),
        _ => None,
    }
}

/// Images and buffers, kept from frame to frame.
pub struct Hardware {
    depths: KeptAttachment,
    indices: KeptAttachment,
    sums: KeptAttachment,
    alphas: KeptAttachment,
    means: Kept<[f32; 4]>,
    squares: Kept<[f32; 4]>,
    products: Kept<[f32; 4]>,
    errors: Kept<[f32; 4]>,
}

impl Default for Hardware {
    fn default() -> Self {
        Self {
            depths: KeptAttachment::new("sample depths", Format::Depth, SAMPLES),
            indices: KeptAttachment::new("sample indices", Format::Number, SAMPLES),
            sums: KeptAttachment::new("stratum sums", Format::Color, 1),
            alphas: KeptAttachment::new("total opacity", Format::Number, 1),
            means: Kept::new("stratum means", Memory::Device),
            squares: Kept::new("stratum squares", Memory::Device),
            products: Kept::new("stratum products", Memory::Device),
            errors: Kept::new("standard errors", Memory::Device),
        }
    }
}

impl Hardware {
    /// Renders a window into the target.
    pub fn render(
        &mut self,
        device: &Device,
        job: &WindowJob<'_>,
        target: &Target,
        timeline: &mut Timeline,
        facts: &mut Facts,
    ) -> Result<(), Error> {
        let window = job.raster.window;
        self.reserve(device, job)?;
        let mut recorder = device.recorder()?;
        if !job.is_seen() {
            record_nothing(&mut recorder, target, window)?;
            recorder.fill("image/clear", self.errors.get().all(), 0)?;
        } else {
            if job.stochastic.alpha_correction {
                self.record_alpha(&mut recorder, job)?;
            }
            for stratum in 0..job.strata() {
                if stratum > 0 && stratum % BATCH == 0 {
                    timeline.add(recorder.submit("stochastic/accumulate")?);
                    job.progress.set_message(format!("rendering, {} samples", stratum * STRATUM));
                    recorder = device.recorder()?;
                }
                self.record_stratum(&mut recorder, job, stratum)?;
            }
            self.record_estimate(&mut recorder, job, target)?;
            facts.bands += 1;
        }
        target.record_read_back(&mut recorder, bands::pixels(window))?;
        timeline.add(recorder.submit("stochastic/estimate")?);
        Ok(())
    }

    fn reserve(&mut self, device: &Device, job: &WindowJob<'_>) -> Result<(), Error> {
        let (size, pixels) = (job.size(), bands::pixels(job.raster.window));
        self.depths.reserve(device, size)?;
        self.indices.reserve(device, size)?;
        self.sums.reserve(device, size)?;
        self.alphas.reserve(device, size)?;
        self.means.reserve(device, pixels)?;
        self.squares.reserve(device, pixels)?;
        self.products.reserve(device, pixels)?;
        self.errors.reserve(device, pixels)?;
        Ok(())
    }

    /// Standard errors of R, G and B of every pixel of the window, in its order; what the last rendered window left.
    pub fn read_errors(&self, window: Window) -> Result<Vec<[f32; 3]>, Error> {
        let errors = self.errors.get().read(0, bands::pixels(window))?;
        Ok(errors.into_iter().map(|[r, g, b, _]| [r, g, b]).collect())
    }

    fn record_alpha<'a>(&'a self, recorder: &mut Recorder<'a>, job: &WindowJob<'a>) -> Result<(), Error> {
        let targets =
            Targets { color: Some((self.alphas.get(), Blend::Cover)), depth: None, clear: Some(0.0) };
        let variant = quad_variant(job.raster.footprint, job.stochastic.discs.falloff);
        let push = |first| StratumPush { first, ..job.push(0) };
        job.raster.draw(recorder, &variant, targets, |quads| Alpha { quads }, push)?;
        Ok(())
    }

    fn record_stratum<'a>(
        &'a self,
        recorder: &mut Recorder<'a>,
        job: &WindowJob<'a>,
        stratum: u32,
    ) -> Result<(), Error> {
        let variant = quad_variant(job.raster.footprint, job.stochastic.discs.falloff);
        let push = |first| StratumPush { first, ..job.push(stratum) };
        let (depths, indices, sums) = (self.depths.get(), self.indices.get(), self.sums.get());
        let held =
            Targets { color: Some((indices, Blend::Replace)), depth: Some(depths), clear: Some(f32::MAX) };
        job.raster.draw(recorder, &variant, held, |quads| Hold { quads }, push)?;
        let summed = Targets { color: Some((sums, Blend::Add)), depth: None, clear: Some(0.0) };
        job.raster.draw(recorder, &variant, summed, |quads| Accumulate { quads, depths, indices }, push)?;
        let (means, squares, products) = (self.means.get().all(), self.squares.get().all(), self.products.get().all());
        let push = job.moments(stratum);
        let run = Run::new(Dispatch::Invocations(push.count.into())).push(&push);
        recorder.run(&Fold { depths, sums, means, squares, products }, &run)?;
        Ok(())
    }

    fn record_estimate<'a>(
        &'a self,
        recorder: &mut Recorder<'a>,
        job: &WindowJob<'a>,
        target: &'a Target,
    ) -> Result<(), Error> {
        let push = job.moments(job.strata() - 1);
        // Without correction the total opacity was never drawn; something must be bound in its place.
        let alphas = if job.stochastic.alpha_correction { self.alphas.get() } else { self.sums.get() };
        let (means, squares, products) = (self.means.get().all(), self.squares.get().all(), self.products.get().all());
        let (image, depths, errors) = (target.image(), target.depths(), self.errors.get().all());
        let estimate = Estimate { alphas, means, squares, products, image, depths, errors };
        recorder.run(&estimate, &Run::new(Dispatch::Invocations(push.count.into())).push(&push))?;
        Ok(())
    }
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
}
