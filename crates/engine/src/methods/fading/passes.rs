//! The passes of `moments` and `wavelet`, and the variants of their shaders.

use crate::choices::Choices;
use crate::gpu::Variant;
use crate::gpu::shader::Shader;
use crate::methods::approximate::SumsGroup;
use crate::passes::bin::{self, Lanes, TileWalk, TiledGroup};
use crate::passes::compose::{self, Cut};
use crate::passes::project::DISCS;
use crate::scene::{Falloff, MAX_RANK, MomentCount, Moments};
use crate::{gpu_struct, pass};

gpu_struct! {
    /// Estimate of light from moments; shaders/shared/moment.wgsl explains the members.
    pub struct Estimate {
        scale: f32,
        overestimation: f32,
        bias: f32,
    }
}

impl Estimate {
    /// Creates the constants of the estimate from settings, for depths from near to far.
    pub fn new(settings: &Moments, depth_range: [f32; 2]) -> Self {
        let [near, far] = depth_range.map(f64::from);
        let scale = (2.0 / (far / near).ln()) as f32;
        Self { scale, overestimation: settings.overestimation, bias: settings.bias() }
    }
}

gpu_struct! {
    /// Push constants of `moments`.
    pub struct MomentPush {
        walk: TileWalk,
        estimate: Estimate,
    }
}

gpu_struct! {
    /// Push constants of `wavelet`.
    pub struct WaveletPush {
        walk: TileWalk,
    }
}

pass! {
    /// Sums powers of the depths of each pixel's fragments, weighted by their optical depths: one subgroup per block of
    /// a tile goes through it region by region.
    pub GatherMoments(MomentPush) = "moments/gather" in "moments/gather" {
        tiles: Shared<TiledGroup>,
        known: ReadWrite<[f32; 2]>,
    }
}

pass! {
    /// Sums colors weighted by the light before them, which the moments bound, as `moments/gather` goes through a tile.
    pub WeighByMoments(MomentPush) = "moments/accumulate" in "moments/accumulate" {
        tiles: Shared<TiledGroup>,
        sums: Shared<SumsGroup>,
        known: Read<[f32; 2]>,
    }
}

pass! {
    /// Finds the nearest and the farthest fragment of each pixel, as `moments/gather` goes through a tile.
    pub FindRange(WaveletPush) = "wavelet/range" in "wavelet/range" {
        tiles: Shared<TiledGroup>,
        ranges: ReadWrite<[f32; 2]>,
    }
}

pass! {
    /// Sums optical depths by cells between those two, as `moments/gather` goes through a tile.
    pub GatherCells(WaveletPush) = "wavelet/gather" in "wavelet/gather" {
        tiles: Shared<TiledGroup>,
        ranges: Read<[f32; 2]>,
        cells: ReadWrite<[f32; 2]>,
    }
}

pass! {
    /// Sums colors weighted by the light before them, which follows from the cells, as `moments/gather` goes through a
    /// tile.
    pub WeighByCells(WaveletPush) = "wavelet/accumulate" in "wavelet/accumulate" {
        tiles: Shared<TiledGroup>,
        sums: Shared<SumsGroup>,
        ranges: Read<[f32; 2]>,
        cells: Read<[f32; 2]>,
    }
}

/// A run of several that together process the tiles' splats.
#[derive(Debug, Clone, Copy)]
pub(in crate::methods) struct OneRun {
    /// `true` if it goes on from the result of others.
    pub(in crate::methods) later: bool,
    /// `true` if there are several, so that each leaves what it knows.
    pub(in crate::methods) kept: bool,
    /// The invocations that go through the tiles.
    pub(in crate::methods) lanes: Lanes,
}

/// Returns a variant of the stages that only learn of a pixel.
pub(in crate::methods) fn learning(shape: Variant, run: OneRun) -> Variant {
    bin::region_variant(shape, run.later, run.lanes)
}

/// Returns a variant of the stages that leave colors.
pub(in crate::methods) fn leaving(shape: Variant, run: OneRun) -> Variant {
    learning(shape, run).with("KEPT", u32::from(run.kept))
}

/// Adds the number of moments.
pub(in crate::methods) fn with_moments(variant: Variant, moments: u32) -> Variant {
    variant.constant("MOMENTS", moments).each("moment", moments + 1)
}

/// Adds the number of cells.
pub(super) fn with_cells(variant: Variant, cells: u32) -> Variant {
    variant.constant("CELLS", cells)
}

/// The variants of a stage: all discs with all of some numbers, each with the first of one run, and the first and the
/// second of two.
fn variants<N: Copy>(numbers: &[N], of: impl Fn(Variant, OneRun, N) -> Variant) -> Vec<Variant> {
    let runs: Vec<OneRun> = [(false, false), (false, true), (true, true)]
        .into_iter()
        .flat_map(|(later, kept)| Lanes::all().into_iter().map(move |lanes| OneRun { later, kept, lanes }))
        .collect();
    let discs = DISCS.into_iter().flat_map(|disc| <(Cut, Falloff)>::all().into_iter().map(move |o| (disc, o)));
    let mut all = Vec::new();
    for (footprint, (cut, falloff)) in discs {
        let shape = compose::variant(cut, footprint, falloff);
        for number in numbers {
            all.extend(runs.iter().map(|run| of(shape.clone(), *run, *number)));
        }
    }
    all
}

/// Returns those of a stage with moments.
pub(in crate::methods) fn by_moments(of: fn(Variant, OneRun) -> Variant) -> Vec<Variant> {
    variants(&MomentCount::ALL, |shape, run, count| with_moments(of(shape, run), count.get()))
}

/// Returns the variants of a stage with cells.
fn by_cells(of: fn(Variant, OneRun) -> Variant) -> Vec<Variant> {
    let ranks: Vec<u32> = (1..=MAX_RANK).collect();
    variants(&ranks, |shape, run, rank| with_cells(of(shape, run), 2 << rank))
}

/// Returns the passes with their variants.
pub fn shaders() -> Vec<Shader> {
    vec![
        Shader::new::<GatherMoments>(by_moments(learning)),
        Shader::new::<WeighByMoments>(by_moments(leaving)),
        Shader::new::<FindRange>(variants(&[()], |shape, run, ()| learning(shape, run))),
        Shader::new::<GatherCells>(by_cells(learning)),
        Shader::new::<WeighByCells>(by_cells(leaving)),
    ]
}
