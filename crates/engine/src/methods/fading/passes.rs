//! The passes of `moments` and `wavelet`, and the variants of their shaders.

use crate::methods::prelude::*;
use crate::methods::tiled::{SumPush, SumsGroup};
use crate::scene::{MAX_RANK, MomentCount, Moments};

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
    pub FindRange(SumPush) = "wavelet/range" in "wavelet/range" {
        tiles: Shared<TiledGroup>,
        ranges: ReadWrite<[f32; 2]>,
    }

    /// Sums optical depths by cells between those two, as `moments/gather` goes through a tile.
    pub GatherCells(SumPush) = "wavelet/gather" in "wavelet/gather" {
        tiles: Shared<TiledGroup>,
        ranges: Read<[f32; 2]>,
        cells: ReadWrite<[f32; 2]>,
    }

    /// Sums colors weighted by the light before them, which follows from the cells, as `moments/gather` goes through a
    /// tile.
    pub WeighByCells(SumPush) = "wavelet/accumulate" in "wavelet/accumulate" {
        tiles: Shared<TiledGroup>,
        sums: Shared<SumsGroup>,
        ranges: Read<[f32; 2]>,
        cells: Read<[f32; 2]>,
    }
}

/// Adds the number of moments.
pub(in crate::methods) fn with_moments(variant: Variant, moments: u32) -> Variant {
    variant.constant("MOMENTS", moments).each("moment", moments + 1)
}

/// Adds the number of cells.
pub(super) fn with_cells(variant: Variant, cells: u32) -> Variant {
    variant.constant("CELLS", cells)
}

/// Returns the variants of a stage with moments.
pub(in crate::methods) fn by_moments() -> Vec<Variant> {
    bin::tile_variants(compose::variants(), &MomentCount::ALL, |shape, lanes, count| {
        with_moments(bin::region_variant(shape, lanes), count.get())
    })
}

/// Returns the variants of a stage with cells.
fn by_cells() -> Vec<Variant> {
    let ranks: Vec<u32> = (1..=MAX_RANK).collect();
    bin::tile_variants(compose::variants(), &ranks, |shape, lanes, rank| {
        with_cells(bin::region_variant(shape, lanes), 2 << rank)
    })
}

/// Returns the passes with their variants.
pub fn shaders() -> Vec<Shader> {
    vec![
        Shader::new::<GatherMoments>(by_moments()),
        Shader::new::<WeighByMoments>(by_moments()),
        Shader::new::<FindRange>(bin::tile_variants(compose::variants(), &[()], |shape, lanes, ()| {
            bin::region_variant(shape, lanes)
        })),
        Shader::new::<GatherCells>(by_cells()),
        Shader::new::<WeighByCells>(by_cells()),
    ]
}
