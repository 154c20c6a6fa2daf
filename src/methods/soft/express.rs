//! `soft-express` (Seemann et al. 2018, Section 3.3): soft points as discs that face the viewer, blended front to back in the
//! order in which they lie along the axis nearest to the viewing direction. That order is made once for a cloud, so that a frame
//! sorts nothing; it is the order of depth for orthographic views along an axis, and close to it otherwise.

use super::SoftModel;
use crate::gpu::{Device, Dispatch, Recorder, Run, Slice, Variant};
use crate::methods::abuffer::record_nothing;
use crate::methods::renderer::{Facts, Target, Timeline};
use crate::methods::sorted::{self, Stop};
use crate::methods::{Error, Outcome};
use crate::passes::bin::{self, Bin, Binned, Bins, FoldPush, FoldingGroup};
use crate::passes::project::Footprint;
use crate::scene::ColorSpace;
use crate::{gpu_struct, pass};

gpu_struct! {
    /// Push constants of `soft/express`; the shader says what the members are.
    pub struct ExpressPush {
        columns: u32,
        tiles: u32,
        runs: u32,
        nearest: u32,
        segment: u32,
        peak: f32,
        most_color: f32,
    }
}

pass! {
    /// Tiles to pixels.
    pub Express(ExpressPush) = "soft/express" {
        tiles: Shared<FoldingGroup>,
        solid: Read<f32>,
        image: ReadWrite<[f32; 4]>,
        depths: ReadWrite<f32>,
    }
}

/// Everything that stays the same while a window is rendered.
#[derive(Clone, Copy)]
pub struct WindowJob<'a> {
    /// What is binned: the soft points, along an axis ([`bin::Order::Along`]).
    pub bin: bin::Job<'a>,
    /// λ, the opacity in the middle of a disc.
    pub model: SoftModel,
    /// Whether any point may have a W below 1 (Eq. 22).
    pub modulated: bool,
    /// Depths of the window's solid points, +inf where there is none. Discs count where their depth is less.
    pub solid: Option<Slice<'a, f32>>,
    /// In which space colors are blended.
    pub color: ColorSpace,
    /// Upper bound of the color components that are blended.
    pub most_color: f32,
    /// When to stop.
    pub stop: Stop,
}

/// Bins a window's soft points and blends them into the target, which is not read back yet.
pub fn render(
    bins: &mut Bins,
    device: &Device,
    job: &WindowJob<'_>,
    target: &Target,
    timeline: &mut Timeline,
    facts: &mut Facts,
) -> Result<Outcome, Error> {
    let mut recorder;
    match bins.bin(device, &job.bin, timeline, facts)? {
        Bin::TooLarge => return Ok(Outcome::Overflow),
        Bin::Nothing => {
            recorder = device.recorder()?;
            record_nothing(&mut recorder, target, job.bin.raster.window)?;
        }
        Bin::Done(binned) => {
            facts.bands += 1;
            recorder = device.recorder()?;
            record_blend(bins, &mut recorder, job, binned, target)?;
        }
    }
    timeline.add(recorder.submit("soft/express")?);
    Ok(Outcome::Done)
}

/// Records the blending of all tiles.
fn record_blend<'a>(
    bins: &'a Bins,
    recorder: &mut Recorder<'a>,
    job: &WindowJob<'a>,
    binned: Binned,
    target: &'a Target,
) -> Result<(), Error> {
    let cloud = job.bin.raster.cloud;
    // Without solid points the shader does not look at their depths.
    let solid = job.solid.unwrap_or_else(|| cloud.fields.all());
    let tiles = bins.tiles(binned).folding(cloud.view());
    let express = Express { tiles, solid, image: target.image(), depths: target.depths() };
    let (stop, most_color) = sorted::stop(job.stop, job.color, job.most_color);
    for segment in 0..binned.segments() {
        let FoldPush { columns, tiles, runs, nearest, segment } = binned.fold_push(segment);
        let push = ExpressPush { columns, tiles, runs, nearest, segment, peak: job.model.lambda, most_color };
        let way = Way { stop, cut: job.solid.is_some(), modulated: job.modulated, later: segment > 0 };
        let run = Run::new(Dispatch::Groups(tiles.into())).push(&push);
        recorder.run(&express, &run.variant(express_variant(way, binned.subgroup())))?;
    }
    Ok(())
}

/// What a variant of `soft/express` depends on.
#[derive(Debug, Clone, Copy)]
pub struct Way {
    /// `STOP` in WGSL, from [`sorted::stop`].
    pub stop: u32,
    /// Whether solid points cut it.
    pub cut: bool,
    /// Whether some W are below 1.
    pub modulated: bool,
    /// A run that goes on from the image.
    pub later: bool,
}

/// A variant of `soft/express`.
pub fn express_variant(way: Way, subgroup: u32) -> Variant {
    let flat = Variant::plain().with("SHAPE", Footprint::Disc as u32);
    let variant = bin::fold_variant(flat, way.later, subgroup).with("STOP", way.stop);
    variant.with("CUT", u32::from(way.cut)).with("MODULATED", u32::from(way.modulated))
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    /// The shader's polynomial, with its rounding.
    fn profile(x: f32) -> f32 {
        let root = (1.0 - x) * (1.0 + x * (-0.233_699_32 + x * (0.019_957_643 - 0.000_863_812_3 * x)));
        root * root
    }

    #[test]
    fn the_polynomial_is_the_raised_cosine() {
        assert_eq!([profile(0.0), profile(1.0)], [1.0, 0.0]);
        let steps = 1 << 20;
        let mut worst = 0f64;
        for i in 0..=steps {
            let x = i as f32 / steps as f32;
            let exact = 0.5 * ((PI * f64::from(x).sqrt()).cos() + 1.0);
            worst = worst.max((f64::from(profile(x)) - exact).abs());
        }
        assert!(worst < 3e-7, "{worst}");
        // It falls all the way, but for rounding, and never beyond [0, 1].
        let falls = (0..steps).all(|i| profile((i + 1) as f32 / steps as f32) <= profile(i as f32 / steps as f32) + 1e-6);
        assert!(falls);
        // The numbers are those of the shader.
        let shader = include_str!("../../../shaders/shared/profile.wgsl");
        for digits in ["0.233699319", "0.0199576433", "0.000863812306"] {
            assert!(shader.contains(digits));
        }
    }
}
