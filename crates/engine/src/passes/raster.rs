//! Visiting the pixels of splats, in compute shaders or by the rasterizer, for any stage that binds what
//! shaders/shared/raster.wgsl states.

use super::bands::{Band, Window};
use super::project::{Bounds, DeviceCloud, Footprint, Splat, Stats, Tilt, View};
use super::tiles::{PAIR_RUN, Tiles};
use crate::gpu::{Dispatch, Draw, Error, Pass, Recorder, Run, Slice, Targets, Variant, Vertices};
use crate::{gpu_struct, group};

gpu_struct! {
    /// Push constants of a stage that visits splats.
    pub struct RasterPush {
        count: u32, // Splats of this chunk.
        first: u32, // Index of the chunk's first splat among all.
        band_start: u32, // The band of pixels in work: [band_start, band_end) in the order of window_index.
        band_end: u32,
        first_fragment: u32, // The band's first fragment among the window's.
        chunk: u32, // Number of this chunk.
    }

    /// Push constants: a number of elements.
    pub struct CountPush {
        count: u32,
    }
}

/// The visitor of pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Walker {
    /// Compute: one invocation per small splat, one workgroup for a few tiles of a large one.
    Compute,
    /// The rasterizer.
    Hardware,
}

group! {
    /// Bindings of one chunk.
    pub Chunk as ChunkGroup {
        /// The camera.
        camera: Uniform<View>,
        /// The chunk's splats.
        splats: Read<Splat>,
        /// Tilts of the splats.
        tilts: Read<Tilt>,
        /// Rectangles of the splats.
        bounds: Read<Bounds>,
        /// Large splats of the chunk.
        large: Read<u32>,
        /// First pair of each large splat with a tile.
        pair_offsets: Read<u32>,
        /// Depths of the chunk's splats.
        splat_depths: Read<f32>,
        /// Statistics of all chunks.
        stats: Read<Stats>,
    }

    /// Bindings of a stage that draws a chunk's splats into attachments.
    pub Quads as QuadsGroup {
        /// The camera.
        camera: Uniform<View>,
        /// The chunk's splats.
        splats: Read<Splat>,
        /// Tilts of the splats.
        tilts: Read<Tilt>,
        /// Rectangles of the splats.
        bounds: Read<Bounds>,
        /// Colors as blended, and opacities.
        colors: Read<[f32; 4]>,
        /// Depths of the splats.
        splat_depths: Read<f32>,
    }
}

/// One dispatch or draw of a stage.
struct Visit {
    chunk: usize,
    push: RasterPush,
    walker: &'static str,
    amount: Amount,
}

/// Amount that a pass runs.
enum Amount {
    Compute(Dispatch<'static>),
    Vertices(u32),
}

/// A projected cloud whose pixels are visited.
#[derive(Clone, Copy)]
pub struct Raster<'a> {
    /// The cloud.
    pub cloud: &'a DeviceCloud,
    /// Statistics of its projection into the window.
    pub stats: &'a [Stats],
    /// Pairs of large splats and tiles; recorded before, if the walker is [`Walker::Compute`].
    pub tiles: &'a Tiles,
    /// The visitor of pixels.
    pub walker: Walker,
    /// Shape of the pixels that a splat covers.
    pub footprint: Footprint,
    /// The rectangle of pixels in work.
    pub window: Window,
}

impl<'a> Raster<'a> {
    /// Records the pairs of large splats and tiles, if the walker asks for them.
    pub fn record_tiles(&self, recorder: &mut Recorder<'a>) -> Result<(), Error> {
        match self.walker {
            Walker::Compute => self.tiles.record(recorder, self.cloud, self.stats),
            Walker::Hardware => Ok(()),
        }
    }

    /// Records a stage over all splats and the pixels of a band.
    pub fn record<P: Pass<Push = RasterPush> + 'a>(
        &self,
        recorder: &mut Recorder<'a>,
        band: &Band,
        stage: impl Fn(Chunk<'a>) -> P,
    ) -> Result<(), Error> {
        self.record_with(recorder, band, stage, None, |variant| variant)
    }

    /// Indirect arguments of a stage's dispatches or draws, in order; without workgroups or vertices where the first
    /// word is 0.
    pub fn arguments(&self, recorder: &Recorder<'_>, band: &Band) -> Result<Vec<[u32; 4]>, Error> {
        let of = |visit: Visit| match visit.amount {
            Amount::Compute(dispatch) => recorder.arguments(visit.walker, dispatch),
            Amount::Vertices(count) => Ok([count, 1, 0, 0]),
        };
        self.visits(band).map(of).collect()
    }

    /// Records a draw of all splats into attachments, in the order of their indices. `push` makes the push constants
    /// from the index of a chunk's first splat; `stage` also gets the ids of the chunk's points. At least one splat
    /// must be visible, or nothing is drawn, not even what is cleared.
    pub fn draw<P: Pass + 'a>(
        &self,
        recorder: &mut Recorder<'a>,
        variant: &Variant,
        mut targets: Targets<'a>,
        stage: impl Fn(Quads<'a>, Slice<'a, u32>) -> P,
        push: impl Fn(u32) -> P::Push,
    ) -> Result<(), Error> {
        let [x0, y0, x1, y1] = self.window;
        for ((first, count), _) in self.cloud.chunks().zip(self.stats).filter(|(_, stats)| stats.visible > 0) {
            let cloud = self.cloud;
            let quads = Quads {
                camera: cloud.view(),
                splats: cloud.splats.slice(first, count),
                tilts: self.tilts(first, count),
                bounds: cloud.bounds.slice(first, count),
                colors: cloud.colors.slice(first, count),
                splat_depths: cloud.splat_depths.slice(first, count),
            };
            let pass = stage(quads, cloud.ids.slice(first, count));
            let draw = Draw { vertices: Vertices::Count(6 * count as u32), area: [x1 - x0, y1 - y0], targets };
            recorder.draw(&pass, push(first as u32), variant, draw)?;
            targets.clear = None;
        }
        Ok(())
    }

    /// Records a stage as [`Self::record`] does, in a variant that `with` adds overrides to. With `arguments` the sizes
    /// of dispatches or draws are there: as many records of four words as [`Self::arguments`] has.
    pub fn record_with<P: Pass<Push = RasterPush> + 'a>(
        &self,
        recorder: &mut Recorder<'a>,
        band: &Band,
        stage: impl Fn(Chunk<'a>) -> P,
        arguments: Option<Slice<'a, u32>>,
        with: impl Fn(Variant) -> Variant,
    ) -> Result<(), Error> {
        let [x0, y0, x1, y1] = self.window;
        for (number, visit) in self.visits(band).enumerate() {
            let arguments = arguments.map(|all| all.skip(4 * number as u64).first(4));
            let pass = stage(self.chunk(visit.chunk, u64::from(visit.push.first), u64::from(visit.push.count)));
            let variant = with(variant(self.footprint, visit.walker));
            match visit.amount {
                Amount::Compute(dispatch) => {
                    let dispatch = arguments.map_or(dispatch, Dispatch::Indirect);
                    recorder.run(&pass, visit.push, &Run::new(dispatch).variant(variant))?;
                }
                Amount::Vertices(count) => {
                    let vertices = arguments.map_or(Vertices::Count(count), Vertices::Indirect);
                    let draw = Draw { vertices, area: [x1 - x0, y1 - y0], targets: Targets::default() };
                    recorder.draw(&pass, visit.push, &variant, draw)?;
                }
            }
        }
        Ok(())
    }

    /// Returns colors of a chunk's splats.
    pub fn colors_of(&self, chunk: &Chunk<'a>) -> Slice<'a, [f32; 4]> {
        self.cloud.colors.slice(chunk.splats.start(), chunk.splats.len())
    }

    /// The dispatches or draws that visit all splats: chunks without visible ones have none.
    fn visits(&self, band: &Band) -> impl Iterator<Item = Visit> {
        let chunks = self.cloud.chunks().zip(self.stats).enumerate().filter(|(_, (_, stats))| stats.visible > 0);
        chunks
            .flat_map(move |(chunk, ((first, count), stats))| {
                let push = RasterPush {
                    count: count as u32,
                    first: first as u32,
                    band_start: band.pixels[0],
                    band_end: band.pixels[1],
                    first_fragment: band.first_fragment,
                    chunk: chunk as u32,
                };
                let visit = |walker, amount| Visit { chunk, push, walker, amount };
                let small = || visit(WALK_SMALL, Amount::Compute(Dispatch::Invocations(count)));
                let groups = stats.tiles().div_ceil(u64::from(PAIR_RUN));
                let large = || visit(WALK_PAIRS, Amount::Compute(Dispatch::Groups(groups)));
                match self.walker {
                    Walker::Compute => [Some(small()), (stats.large > 0).then(large)],
                    Walker::Hardware => [Some(visit(WALK_FRAGMENT, Amount::Vertices(6 * count as u32))), None],
                }
            })
            .flatten()
    }

    fn tilts(&self, first: u64, count: u64) -> Slice<'a, Tilt> {
        self.cloud.tilts_of(self.footprint, first, count)
    }

    fn chunk(&self, chunk: usize, first: u64, count: u64) -> Chunk<'a> {
        let cloud = self.cloud;
        Chunk {
            camera: cloud.view(),
            splats: cloud.splats.slice(first, count),
            tilts: self.tilts(first, count),
            bounds: cloud.bounds.slice(first, count),
            large: cloud.large.slice(first, count),
            pair_offsets: self.tiles.offsets_of(self.stats, chunk),
            splat_depths: cloud.splat_depths.slice(first, count),
            stats: cloud.found(),
        }
    }
}

/// One invocation per small splat.
const WALK_SMALL: &str = "walk_small";
/// One workgroup per few pairs of a large splat and a tile.
const WALK_PAIRS: &str = "walk_pairs";
/// The rasterizer.
const WALK_FRAGMENT: &str = "walk_fragment";

/// The variant of a stage for a footprint and a walker.
fn variant(footprint: Footprint, walker: &'static str) -> Variant {
    Variant::plain().with("SHAPE", footprint as u32).walker(walker)
}

/// Returns the variants of a stage for some footprints, without the rasteriser.
pub(crate) fn computed_variants(footprints: &[Footprint]) -> Vec<Variant> {
    variants(footprints, &[WALK_SMALL, WALK_PAIRS])
}

fn variants(footprints: &[Footprint], walkers: &[&'static str]) -> Vec<Variant> {
    footprints.iter().flat_map(|shape| walkers.iter().map(|walker| variant(*shape, walker))).collect()
}

/// Footprints whose pixels are visited one by one, spheres apart.
pub(crate) const FLAT: [Footprint; 6] = [
    Footprint::Disc,
    Footprint::Oriented,
    Footprint::Square,
    Footprint::Point,
    Footprint::FlatGaussian,
    Footprint::Gaussian,
];

/// Returns the variants of a stage that visits whatever is flat.
pub(crate) fn flat_variants() -> Vec<Variant> {
    variants(&FLAT, &[WALK_SMALL, WALK_PAIRS, WALK_FRAGMENT])
}
