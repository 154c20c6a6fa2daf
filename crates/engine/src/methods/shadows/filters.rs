//! The filters of a light's image, and the count of the holes that they leave.

use super::{FILL_ROWS, light_bytes, pitch};
use crate::cloud::light_image::{Holes, hole_block};
use crate::cloud::shadow_texture::Casting;
use crate::gpu::shader::Shader;
use crate::gpu::{Buffer, Device, Dispatch, Memory, Recorder, Run, Variant};
use crate::methods::Error;
use crate::{gpu_struct, pass};

gpu_struct! {
    /// Push constants of the filters.
    pub struct FilterPush {
        columns: u32, // Columns by four, and rows.
        rows: u32,
        apart: f32, // Smallest distance of surfaces.
    }

    /// Push constants of the count of holes.
    pub struct HolesPush {
        resolution: u32, // Columns and rows of the image.
        pitch: u32, // Pixels of a row in memory.
        block: u32, // Columns and rows of a block.
        side: u32, // Columns and rows of blocks.
        apart: f32, // Smallest distance of surfaces.
    }
}

pass! {
    /// Gives background between the points of a light's image the depth of the nearest of its 3 × 3 pixels; once for
    /// each iteration. An invocation has four columns and eight rows.
    pub Fill(FilterPush) = "shadows/fill",
    /// Closes holes of surfaces in a light's image by the occlusion filter, so that no light falls through them; once
    /// for each iteration. An invocation has four columns and eight rows.
    pub Occlusion(FilterPush) = "shadows/occlusion" {
        before: Read<[u32; 4]>,
        depths: ReadWrite<[f32; 4]>,
    }

    /// Finds the smallest depth of each block of the first light's image, by 32-bit atomic minimum of its key.
    pub Blocks(HolesPush) = "shadows/blocks" {
        nearest: Read<u32>,
        blocks: ReadWrite<u32>,
    }

    /// Counts the holes that the filters leave in the surfaces of the first light's image.
    pub Leaks(HolesPush) = "shadows/leaks" {
        depths: Read<f32>,
        blocks: Read<u32>,
        counts: ReadWrite<u32>,
    }
}

/// Pixels of an invocation of the passes that count holes.
const RUN: u64 = 32;

/// A filter of a light's image.
#[derive(Clone, Copy)]
enum Filter {
    Fill,
    Occlusion,
    /// No filter: keys become depths.
    Nothing,
}

/// The filters of a casting in the order of their runs, at least one.
fn filters(casting: &Casting) -> impl Iterator<Item = Filter> + use<> {
    let of = |filter, count: u32| std::iter::repeat_n(filter, count as usize);
    let nothing = of(Filter::Nothing, u32::from(casting.reach() == 0));
    of(Filter::Fill, casting.fill).chain(of(Filter::Occlusion, casting.occlusion)).chain(nothing)
}

/// Index of that image of [`record`] that holds the depths after all filters.
pub(super) fn last(casting: &Casting) -> usize {
    casting.reach().max(1) as usize % 2
}

/// Records the surfaces of an image, whose keys are in the first of both; [`last`] tells where they are then.
pub(super) fn record<'a>(
    recorder: &mut Recorder<'a>,
    images: [&'a Buffer<u32>; 2],
    casting: &Casting,
) -> Result<(), Error> {
    let (columns, rows) = (pitch(casting.resolution) / 4, u64::from(casting.resolution));
    let invocations = Dispatch::Invocations(columns * rows.div_ceil(FILL_ROWS));
    for (i, filter) in filters(casting).enumerate() {
        let (before, depths) = (images[i % 2].all().cast(), images[(i + 1) % 2].all().cast());
        let run = Run::new(invocations).variant(variant(i == 0));
        let push = FilterPush { columns: columns as u32, rows: casting.resolution, apart: casting.min_layer_distance };
        match filter {
            Filter::Fill => recorder.run(&Fill { before, depths }, push, &run)?,
            Filter::Occlusion => recorder.run(&Occlusion { before, depths }, push, &run)?,
            // Nothing lies so far before anything.
            Filter::Nothing => {
                recorder.run(&Occlusion { before, depths }, FilterPush { apart: f32::MAX, ..push }, &run)?;
            }
        }
    }
    Ok(())
}

/// The variant of a filter, the first one of an image or a later one.
fn variant(first: bool) -> Variant {
    Variant::plain().with("RUN", FILL_ROWS as u32).with("KEYS", u32::from(first))
}

/// The variant of the passes that count holes.
fn run_variant() -> Variant {
    Variant::plain().with("RUN", RUN as u32)
}

/// Count of the holes in the images of a light.
pub(super) struct HoleCount {
    push: HolesPush,
    blocks: Buffer<u32>,
    counts: Buffer<u32>,
}

impl HoleCount {
    /// Makes room for it, with `budget` bytes for it and the images; `None` if these leave too few. `natural` is the
    /// resolution at which a pixel holds a point.
    pub fn new(device: &Device, casting: &Casting, natural: f64, budget: u64) -> Result<Option<Self>, Error> {
        let resolution = casting.resolution;
        let block = hole_block(resolution, natural);
        let side = resolution.div_ceil(block);
        let blocks = u64::from(side) * u64::from(side);
        if light_bytes(blocks) > budget {
            return Ok(None);
        }
        let pitch = pitch(resolution) as u32;
        let blocks = device.buffer("blocks of a light's image", blocks, Memory::Device)?;
        let counts = device.buffer("holes of a light's image", 4, Memory::Device)?;
        let push = HolesPush { resolution, pitch, block, side, apart: casting.min_layer_distance };
        Ok(Some(Self { push, blocks, counts }))
    }

    /// Records that nothing is counted yet.
    pub fn record_clear<'a>(&'a self, recorder: &mut Recorder<'a>) -> Result<(), Error> {
        Ok(recorder.fill("shadows/reset", self.counts.all(), 0)?)
    }

    /// Records the surfaces of an image of keys, before the filters.
    pub fn record_blocks<'a>(&'a self, recorder: &mut Recorder<'a>, nearest: &'a Buffer<u32>) -> Result<(), Error> {
        recorder.fill("shadows/reset", self.blocks.all(), u32::MAX)?;
        let blocks = Blocks { nearest: nearest.all(), blocks: self.blocks.all() };
        Ok(recorder.run(&blocks, self.push, &self.run())?)
    }

    /// Records the count of holes in that image after the filters.
    pub fn record_leaks<'a>(&'a self, recorder: &mut Recorder<'a>, depths: &'a Buffer<u32>) -> Result<(), Error> {
        let leaks = Leaks { depths: depths.all().cast(), blocks: self.blocks.all(), counts: self.counts.all() };
        Ok(recorder.run(&leaks, self.push, &self.run())?)
    }

    fn run<'a>(&self) -> Run<'a> {
        let resolution = u64::from(self.push.resolution);
        Run::new(Dispatch::Invocations(resolution.div_ceil(RUN) * resolution)).variant(run_variant())
    }

    /// Returns the holes of all images counted.
    pub fn found(&self) -> Result<Holes, Error> {
        let counts: Vec<u64> = self.counts.read(0, 4)?.into_iter().map(u64::from).collect();
        let of = |i: usize| counts.get(i).copied().unwrap_or(0);
        Ok(Holes { covered: of(0), holes: of(1), shown: of(2), leaks: of(3) })
    }
}

/// Returns the passes with their variants.
pub(super) fn shaders() -> Vec<Shader> {
    vec![
        Shader::new::<Fill>([true, false].map(variant)),
        Shader::new::<Occlusion>([true, false].map(variant)),
        Shader::new::<Blocks>([run_variant()]),
        Shader::new::<Leaks>([run_variant()]),
    ]
}
