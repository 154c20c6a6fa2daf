//! The passes of `moments` and `wavelet`, and the variants of their shaders.

use crate::choices::Choices;
use crate::gpu::Variant;
use crate::gpu::shader::Shader;
use crate::methods::approximate::SumsGroup;
use crate::passes::bin::{self, Lanes, TileWalk, TiledGroup};
use crate::passes::compose::{self, Cut};
use crate::passes::project::{DISCS, Footprint};
use crate::scene::{Falloff, MAX_RANK, MomentCount, Moments};
use crate::{gpu_struct, pass};

gpu_struct! {
    /// Estimate of light from moments.
    pub struct Estimate {
        scale: f32,
        overestimation: f32,
        bias: f32,
    }

    /// Push constants of `moments`.
    pub struct MomentPush {
        walk: TileWalk,
        estimate: Estimate,
    }

    /// Push constants of `wavelet`.
    pub struct WaveletPush {
        walk: TileWalk,
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

pass! {
    /// Sums powers of the depths of each pixel's fragments, weighted by their optical depths: one subgroup per block of
    /// a tile goes through it region by region.
    pub GatherMoments(MomentPush) = "moments/gather" in "moments/gather" {
        tiles: Shared<TiledGroup>,
        known: ReadWrite<[f32; 2]>,
    }

    /// Sums colors weighted by the light before them, which the moments bound, as `moments/gather` goes through a tile.
    pub WeighByMoments(MomentPush) = "moments/accumulate" in "moments/accumulate" {
        tiles: Shared<TiledGroup>,
        sums: Shared<SumsGroup>,
        known: Read<[f32; 2]>,
    }

    /// Finds the nearest and the farthest fragment of each pixel, as `moments/gather` goes through a tile.
    pub FindRange(WaveletPush) = "wavelet/range" in "wavelet/range" {
        tiles: Shared<TiledGroup>,
        ranges: ReadWrite<[f32; 2]>,
    }

    /// Sums optical depths by cells between those two, as `moments/gather` goes through a tile.
    pub GatherCells(WaveletPush) = "wavelet/gather" in "wavelet/gather" {
        tiles: Shared<TiledGroup>,
        ranges: Read<[f32; 2]>,
        cells: ReadWrite<[f32; 2]>,
    }

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

/// Returns the variants of a stage: footprints with all cuts, falloffs and some ways, each with the first of one run, and
/// the first and the second of two.
pub(in crate::methods) fn variants<W>(
    footprints: &[Footprint],
    ways: &[W],
    of: impl Fn(Variant, OneRun, &W) -> Variant,
) -> Vec<Variant> {
    let runs: Vec<OneRun> = [(false, false), (false, true), (true, true)]
        .into_iter()
        .flat_map(|(later, kept)| Lanes::all().into_iter().map(move |lanes| OneRun { later, kept, lanes }))
        .collect();
    let choices = || <(Cut, Falloff)>::all().into_iter();
    let mut all = Vec::new();
    for (footprint, (cut, falloff)) in footprints.iter().flat_map(|footprint| choices().map(move |o| (*footprint, o))) {
        let shape = compose::variant(cut, footprint, falloff);
        for way in ways {
            all.extend(runs.iter().map(|run| of(shape.clone(), *run, way)));
        }
    }
    all
}

/// Returns those of a stage with moments.
pub(in crate::methods) fn by_moments(of: fn(Variant, OneRun) -> Variant) -> Vec<Variant> {
    variants(&DISCS, &MomentCount::ALL, |shape, run, count| with_moments(of(shape, run), count.get()))
}

/// Returns the variants of a stage with cells.
fn by_cells(of: fn(Variant, OneRun) -> Variant) -> Vec<Variant> {
    let ranks: Vec<u32> = (1..=MAX_RANK).collect();
    variants(&DISCS, &ranks, |shape, run, rank| with_cells(of(shape, run), 2 << rank))
}

/// Returns the passes with their variants.
pub fn shaders() -> Vec<Shader> {
    vec![
        Shader::new::<GatherMoments>(by_moments(learning)),
        Shader::new::<WeighByMoments>(by_moments(leaving)),
        Shader::new::<FindRange>(variants(&DISCS, &[()], |shape, run, ()| learning(shape, run))),
        Shader::new::<GatherCells>(by_cells(learning)),
        Shader::new::<WeighByCells>(by_cells(leaving)),
    ]
}
