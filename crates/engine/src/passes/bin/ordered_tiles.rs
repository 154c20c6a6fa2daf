//! Tiles with their splats in order, and the stages that go through them.

use super::binning::{BLOCK_SIDE, BLOCKS, Binned, TILE_SIDE, pattern};
use super::passes::{TileWalk, Tiled, TilesPush};
use super::{Lanes, SEGMENT, region_segment};
use crate::gpu::{Dispatch, Pass, Recorder, Run, Variant};
use crate::passes::Error;
use crate::passes::bands::{Band, Window};
use crate::passes::compose::{self, Cut};

/// Tiles with their splats in order, and what a stage binds that goes through them.
#[derive(Clone, Copy)]
pub struct OrderedTiles<'a> {
    /// Binning that they were made by.
    pub binned: Binned,
    /// Bindings.
    pub tiled: Tiled<'a>,
}

impl<'a> OrderedTiles<'a> {
    /// Records a stage that collects the fragments of a band's pixels.
    pub fn record<P: Pass<Push = TilesPush> + 'a>(
        &self,
        recorder: &mut Recorder<'a>,
        window: Window,
        band: &Band,
        stage: impl Fn(Tiled<'a>) -> P,
    ) -> Result<(), Error> {
        let Self { binned, tiled, .. } = *self;
        let binning = binned.binning;
        let pass = stage(tiled);
        let row = |pixel: u32| pixel / (window[2] - window[0]) / TILE_SIDE;
        let (first, last) = (row(band.pixels[0]), row(band.pixels[1].max(1) - 1));
        let tiles = (last - first + 1) * binning.columns;
        let segments = binned.segments();
        for segment in 0..segments {
            let push = TilesPush {
                walk: TileWalk { first_tile: first * binning.columns, tiles, ..binned.walk(segment, segments) },
                band_start: band.pixels[0],
                band_end: band.pixels[1],
                first_fragment: band.first_fragment,
            };
            let over = Dispatch::Groups(binning.lanes.groups(tiles.into()));
            let run = Run::new(over).variant(gather_variant(binning.cut, binning.lanes));
            recorder.run(&pass, push, &run)?;
        }
        Ok(())
    }
}

/// Returns the variant of stages that go through tiles with whole splats, from that of shape and falloff.
pub(crate) fn fold_variant(shape: Variant, lanes: Lanes) -> Variant {
    blocks(shape, SEGMENT, lanes)
}

/// Returns the variant of stages that go through each tile region by region (shaders/shared/region_fold.wgsl), like
/// [`fold_variant`].
pub(crate) fn region_variant(shape: Variant, lanes: Lanes) -> Variant {
    let taken = region_segment(lanes.subgroup);
    blocks(shape, taken, lanes).constant("PICKED", taken).constant("REGION_COLUMNS", pattern(lanes.subgroup)[0])
}

/// Returns the same where each block of a tile has a subgroup of its own ([`Binned::over_blocks`]): for stages that
/// hold much for each pixel.
pub(crate) fn fold_blocks_variant(shape: Variant, lanes: Lanes) -> Variant {
    let mut variant = fold_variant(shape, lanes).with("SHARED", BLOCKS);
    for (_, count) in variant.counts.iter_mut().filter(|(name, _)| *name == "block") {
        *count = 1;
    }
    variant
}

/// Returns the variant of stages that go through ordered tiles.
pub(crate) fn gather_variant(cut: Cut, lanes: Lanes) -> Variant {
    fold_variant(compose::disc_variant(cut), lanes)
}

/// Adds the constants of shaders/shared/blocks.wgsl, and the number of a tile's splats that a run takes.
fn blocks(variant: Variant, taken: u32, lanes: Lanes) -> Variant {
    variant
        .with("TAKEN", taken)
        .subgroup(lanes.subgroup)
        .constant("TEAM", lanes.team)
        .each("block", BLOCKS)
        .each("held", BLOCK_SIDE * BLOCK_SIDE / lanes.subgroup)
}
