//! The passes of `moments` and `wavelet`, and the variants of their shaders.

use crate::gpu::Variant;
use crate::gpu::shader::{Choices, Shader};
use crate::methods::approximate::SumsGroup;
use crate::passes::bin::{self, Lanes, TileWalk, TiledGroup};
use crate::passes::compose::{self, Cut};
use crate::passes::project::DISCS;
use crate::scene::{Falloff, MAX_RANK, MomentCount};
use crate::{gpu_struct, pass};

gpu_struct! {
    /// Push constants of `moments`; shaders/shared/moment.wgsl explains the members.
    pub struct MomentPush {
        walk: TileWalk,
        scale: f32,
        overestimation: f32,
        bias: f32,
    }
}

gpu_struct! {
    /// Push constants of `wavelet`.
    pub struct WaveletPush {
        walk: TileWalk,
    }
}

pass! {
    /// Sums powers of the depths of each pixel's fragments, weighted by their optical depths: one subgroup per block of a tile goes
    /// through it region by region.
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
    /// Sums colors weighted by the light before them, which follows from the cells, as `moments/gather` goes through a tile.
    pub WeighByCells(WaveletPush) = "wavelet/accumulate" in "wavelet/accumulate" {
        tiles: Shared<TiledGroup>,
        sums: Shared<SumsGroup>,
        ranges: Read<[f32; 2]>,
        cells: Read<[f32; 2]>,
    }
}

/// One of the runs that it takes to get through the tiles' splats.
#[derive(Debug, Clone, Copy)]
pub(super) struct OneRun {
    /// True if it goes on from the result of others.
    pub(super) later: bool,
    /// True if there are several, so that each leaves what it knows.
    pub(super) kept: bool,
    /// The invocations that go through the tiles.
    pub(super) lanes: Lanes,
}

/// A variant of the stages that only learn of a pixel.
pub(super) fn learning(shape: Variant, run: OneRun) -> Variant {
    bin::region_variant(shape, run.later, run.lanes)
}

/// A variant of the stages that leave colors.
pub(super) fn leaving(shape: Variant, run: OneRun) -> Variant {
    learning(shape, run).with("KEPT", u32::from(run.kept))
}

/// Adds the number of moments.
pub(super) fn with_moments(variant: Variant, moments: u32) -> Variant {
    variant.constant("MOMENTS", moments).each("moment", moments + 1)
}

/// Adds the number of cells.
pub(super) fn with_cells(variant: Variant, cells: u32) -> Variant {
    variant.constant("CELLS", cells)
}

/// The variants of a stage over all discs, with the first of one run, and the first and the second of two.
fn variants(of: impl Fn(Variant, OneRun) -> Vec<Variant>) -> Vec<Variant> {
    let runs: Vec<OneRun> = [(false, false), (false, true), (true, true)]
        .into_iter()
        .flat_map(|(later, kept)| Lanes::all().into_iter().map(move |lanes| OneRun { later, kept, lanes }))
        .collect();
    let mut all = Vec::new();
    for (footprint, (cut, falloff)) in
        DISCS.into_iter().flat_map(|disc| <(Cut, Falloff)>::all().into_iter().map(move |o| (disc, o)))
    {
        let shape = compose::variant(cut, footprint, falloff);
        runs.iter().for_each(|run| all.extend(of(shape.clone(), *run)));
    }
    all
}

/// The passes with their variants.
pub fn shaders() -> Vec<Shader> {
    let moments = |of: fn(Variant, OneRun) -> Variant| {
        variants(move |shape, run| {
            MomentCount::ALL.map(|count| with_moments(of(shape.clone(), run), count.get())).to_vec()
        })
    };
    let cells = |of: fn(Variant, OneRun) -> Variant| {
        variants(move |shape, run| (1..=MAX_RANK).map(|rank| with_cells(of(shape.clone(), run), 2 << rank)).collect())
    };
    vec![
        Shader::new::<GatherMoments>(moments(learning)),
        Shader::new::<WeighByMoments>(moments(leaving)),
        Shader::new::<FindRange>(variants(|shape, run| vec![learning(shape, run)])),
        Shader::new::<GatherCells>(cells(learning)),
        Shader::new::<WeighByCells>(cells(leaving)),
    ]
}
