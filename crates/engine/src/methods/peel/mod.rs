//! `peel`: exact depth peeling of the discs of `abuffer`, layer after layer, in memory that does not grow with the
//! layers.
//!
//! A walk visits every splat: each pixel keeps the smallest ranks (depth key, then index) behind the last one peeled,
//! as many as it has slots, by atomic minimum; then the fragments of those ranks are blended behind what is there.
//! Coincident fragments differ in rank, so none is lost. Walks are submitted by the batch, their dispatches indirect:
//! after a walk that filled no pixel's slots the device makes those that follow empty, and the host looks only between
//! batches.

mod engine;

pub(crate) use engine::{PeelEngine, pass_group};

use super::opaque::NearestSplat;
use super::own::FamilyBuffers;
use crate::methods::prelude::*;
use crate::scene::Peel;

/// Layers of a submission. Longer ones save nothing (400 layers of 256 pixels took 0.55 s with 4 as with 128), but all
/// that are recorded beyond the last layer cost something: frames of four layers took 4, 6, 8 and 23 ms with 4, 16, 32
/// and 128 (medians of 7, lavapipe).
const BATCH: u32 = 16;
/// Walks of a submission at least.
const LEAST_WALKS: u32 = 4;
/// Layers of a submission where the last window predicts their number.
const MOST_FORESEEN: u32 = 256;
/// Numbers of layers that a walk may find: slots of each pixel. Frames of the garden with 92 layers at 384 × 384 took
/// 7.2, 3.2, 1.5, 1.1 and 1.1 s of `peel/nearest` with 1, 2, 4, 8 and 16 (least of 4, lavapipe); on a GPU the 64 bytes
/// of 8 slots are two sectors of its caches.
const SLOTS: [u32; 4] = [1, 2, 4, 8];
/// Bytes of a slot.
const SLOT_BYTES: u64 = 8;
/// Bytes per pixel of a window: last rank and one slot.
const PIXEL_BYTES: u64 = 8 + SLOT_BYTES;
/// Additional bytes per pixel where list lengths and layers are counted.
const COUNTED_BYTES: u64 = 8;

gpu_struct! {
    /// Progress of peeling.
    pub struct PeelWork {
        found: u32,
        layers: u32,
    }

    /// Push constants of `peel/blend`.
    pub struct BlendPush {
        count: u32, // Pixels of the window.
        layers: u32, // Layers to blend at most: as many as slots, or what is left of those asked for.
    }
}

pass! {
    /// Counts the fragments of each pixel as `abuffer/count` does, only where list lengths are asked for.
    pub Count(RasterPush) = "peel/count" in "abuffer/count" {
        chunk: Shared<ChunkGroup>,
        counts: ReadWrite<u32>,
    }

    /// Finds the smallest ranks, depth key and splat index, of each pixel among those behind the last one peeled: by
    /// 64-bit atomic minima, in one slot for each layer that a walk finds.
    pub Nearest(RasterPush) = "peel/nearest" with "nearest_slots" {
        chunk: Shared<ChunkGroup>,
        nearest: ReadWrite<u64>,
        last: Read<[u32; 2]>,
    }

    /// Finds the depth of one layer by a 32-bit minimum, where the device has no 64-bit atomics.
    pub NearestDepth(RasterPush) = "peel/nearest-depth" in "peel/nearest" with "nearest_depth",
    /// Finds the smallest index at the depth of `peel/nearest-depth`.
    pub NearestId(RasterPush) = "peel/nearest-id" in "peel/nearest" with "nearest_id" {
        chunk: Shared<ChunkGroup>,
        nearest: ReadWrite<NearestSplat>,
        last: Read<[u32; 2]>,
    }

    /// Blends the found fragments behind the layers of their pixel, and makes the pixel ready for the next walk.
    pub Blend(BlendPush) = "peel/blend" {
        composing: Shared<ComposingGroup>,
        nearest: ReadWrite<NearestSplat>,
        last: ReadWrite<[u32; 2]>,
        work: ReadWrite<PeelWork>,
        layers: ReadWrite<u32>,
        into: Shared<PixelsGroup>,
    }

    /// Adds up the layers, and empties the indirect arguments of everything that follows a walk that found fewer than
    /// it could in every pixel.
    pub Next = "peel/next" {
        work: ReadWrite<PeelWork>,
        arguments: ReadWrite<u32>,
    }
}

/// Returns device bytes per pixel of a window with one slot for each; `counted`: with list lengths and layers.
pub fn pixel_bytes(counted: bool) -> u64 {
    PIXEL_BYTES + if counted { COUNTED_BYTES } else { 0 }
}

/// The variant of `peel/blend`; `counted`: with layers per pixel.
fn blend_variant(cut: Cut, footprint: Footprint, falloff: Falloff, counted: bool, slots: u32) -> Variant {
    slots_variant(compose::variant(cut, footprint, falloff).with("COUNTED", u32::from(counted)), slots)
}

/// The variant of a pass for so many slots per pixel.
fn slots_variant(variant: Variant, slots: u32) -> Variant {
    variant.with("SLOTS", slots)
}

/// The variant of `peel/next` after a walk that finds so many layers.
pub(super) fn next_variant(slots: u32) -> Variant {
    slots_variant(Variant::plain(), slots)
}

/// Returns the slots of each pixel: no more than the layers that are asked for need, and than fit into a quarter of the
/// budget and into a binding. A window was cut so that one fits.
fn slots(work: &Work<'_>, layers: u32) -> u32 {
    if !work.switches.wide_atomics {
        return 1;
    }
    let (most, budget) = (work.switches.layers_of_a_walk, work.budget);
    let asked = if layers == 0 { u32::MAX } else { layers.checked_next_power_of_two().unwrap_or(u32::MAX) };
    let fixed = pixel_bytes(work.frame.fragments) - SLOT_BYTES;
    let pixels = bands::pixels(work.window);
    let fits = |slots: u32| {
        let bytes = u64::from(slots) * SLOT_BYTES;
        pixels * (fixed + bytes) <= budget.bytes / 4 && pixels * bytes <= budget.binding
    };
    let fitting = SLOTS.into_iter().rev().find(|slots| *slots <= most.min(asked) && fits(*slots));
    fitting.unwrap_or(1)
}

/// Everything that stays the same while a window is peeled.
#[derive(Clone, Copy)]
pub struct PeelJob<'a> {
    /// The projected cloud and who visits its pixels.
    pub raster: Raster<'a>,
    /// Discs and layers.
    pub peel: Peel,
    /// `true` if list lengths and layers are counted.
    pub counted: bool,
    /// `true` if 64-bit atomics are used.
    pub wide: bool,
    /// Layers that a walk finds; 1 without 64-bit atomics.
    pub slots: u32,
    /// Layers after which all of them are too many.
    pub limit: u32,
}

impl PeelJob<'_> {
    /// Layers to record at most: one more than the limit shows whether there are more.
    fn most(&self) -> u64 {
        if self.peel.layers == 0 { u64::from(self.limit) + 1 } else { u64::from(self.peel.layers) }
    }
}

fields! {
    /// Buffers of peeling, kept from frame to frame.
    pub struct Peeler by device {
        nearest: Scratch<NearestSplat> = Scratch::new("nearest fragments", Memory::Device),
        last: Scratch<[u32; 2]> = Scratch::new("last fragments", Memory::Device),
        counts: Scratch<u32> = Scratch::new("fragment counts", Memory::Device),
        layers: Scratch<u32> = Scratch::new("layer counts", Memory::Device),
        work: Buffer<PeelWork> = device.buffer("peel work", 1, Memory::Device)?,
        work_host: Buffer<PeelWork> = device.buffer("peel work, host", 1, Memory::Readback)?,
        told_counts: Told<u32> = Told::new("fragment counts, host"),
        told_layers: Told<u32> = Told::new("layer counts, host"),
        /// Indirect arguments of the passes of a layer.
        arguments: Scratch<u32> = Scratch::new("layer dispatches", Memory::Device),
        /// Layers of the last window.
        last_layers: u32 = 0,
    }
}

impl FamilyBuffers for Peeler {
    fn made(device: &Device) -> Result<Self, Error> {
        Ok(Self::new(device)?)
    }
}

impl Peeler {
    /// Peels a window into the target.
    pub(crate) fn render(&mut self, work: &mut Work<'_>, job: &PeelJob<'_>) -> Result<(), Error> {
        let (device, target) = (work.device, work.target);
        let pixels = bands::pixels(job.raster.window);
        self.reserve(device, job)?;
        let mut recorder = work.timeline.recorder(device)?;
        let mut dispatches = vec![recorder.arguments("peel/blend", Dispatch::Invocations(pixels))?];
        dispatches.extend(job.raster.arguments(&recorder, &Band::whole(job.raster.window, 0))?);
        self.arguments.reserve(device, 4 * dispatches.len() as u64)?;
        recorder.update(self.arguments.get().all(), dispatches.as_flattened());
        self.record_count(&mut recorder, job)?;
        self.record_nothing(&mut recorder, job, target)?;
        work.timeline.go_on(recorder, "peel/clear")?;

        let layers = self.peel(work, job)?;
        self.last_layers = layers;
        self.note_counts(job, work.facts)?;
        work.facts.layers = work.facts.layers.max(layers);
        work.finish();
        Ok(())
    }

    /// Only counts, if that is asked for.
    pub(crate) fn survey(&mut self, work: &mut Work<'_>, job: &PeelJob<'_>) -> Result<(), Error> {
        let device = work.device;
        self.reserve(device, job)?;
        let mut recorder = work.timeline.recorder(device)?;
        self.record_count(&mut recorder, job)?;
        work.timeline.submit(recorder, "peel/count")?;
        self.note_counts(job, work.facts)
    }

    /// List length and peeled layers of every pixel of the window, in its order, as the last counted window left them.
    pub fn read_counts(&self, window: Window) -> Result<[Vec<u32>; 2], Error> {
        let pixels = bands::pixels(window);
        let counts = self.told_counts.read(self.counts.get(), pixels)?;
        Ok([counts, self.told_layers.read(self.layers.get(), pixels)?])
    }

    fn reserve(&mut self, device: &Device, job: &PeelJob<'_>) -> Result<(), Error> {
        let pixels = bands::pixels(job.raster.window);
        let counted = if job.counted { pixels } else { 1 };
        self.nearest.reserve(device, pixels * u64::from(job.slots))?;
        self.last.reserve(device, pixels)?;
        self.counts.reserve(device, counted)?;
        self.layers.reserve(device, counted)?;
        let told = if job.counted { pixels } else { 0 };
        self.told_counts.reserve(device, told)?;
        self.told_layers.reserve(device, told)
    }

    /// Records the tiles that every visit of the window needs, and the fragments of each pixel if they are counted.
    fn record_count<'a>(&'a self, recorder: &mut Recorder<'a>, job: &PeelJob<'a>) -> Result<(), Error> {
        job.raster.record_tiles(recorder)?;
        if job.counted {
            let counts = self.counts.get().slice(0, bands::pixels(job.raster.window));
            recorder.fill("peel/clear", counts, 0)?;
            let all = &Band::whole(job.raster.window, 0);
            job.raster.record(recorder, all, |chunk: Chunk<'a>| Count { chunk, counts })?;
            self.told_counts.record(recorder, self.counts.get());
        }
        Ok(())
    }

    fn note_counts(&self, job: &PeelJob<'_>, facts: &mut Facts) -> Result<(), Error> {
        if job.counted {
            let lengths = self.told_counts.read(self.counts.get(), bands::pixels(job.raster.window))?;
            facts.fragments += lengths.iter().map(|n| u64::from(*n)).sum::<u64>();
            facts.max_list = facts.max_list.max(lengths.iter().copied().max().unwrap_or(0));
        }
        Ok(())
    }

    /// Records that nothing is peeled yet in a window.
    fn record_nothing<'a>(
        &'a self,
        recorder: &mut Recorder<'a>,
        job: &PeelJob<'_>,
        target: &'a Target,
    ) -> Result<(), Error> {
        let window = job.raster.window;
        let pixels = bands::pixels(window);
        let last = self.last.get().slice(0, pixels).cast();
        let zeros = [last, self.layers.get().all(), self.work.all().cast()].map(|words| (words, 0));
        recorder.fill_all("peel/clear", &[&[(self.slots(job).cast(), u32::MAX)], &zeros[..]].concat())?;
        target.pixels().record_nothing(recorder, window)
    }

    /// The slots of a window's pixels.
    fn slots(&self, job: &PeelJob<'_>) -> Slice<'_, NearestSplat> {
        self.nearest.get().slice(0, bands::pixels(job.raster.window) * u64::from(job.slots))
    }

    /// Layers of the first submission: where the last window predicts their number, as many and one that is empty.
    fn first_batch(&self, work: &Work<'_>) -> u32 {
        let foreseen = work.timeline.foresight.knowledge() == Knowledge::Bounds;
        if foreseen { BATCH.max((self.last_layers + 1).min(MOST_FORESEEN)) } else { BATCH }
    }

    /// Batch after batch until nothing is left or enough was peeled; the number of layers.
    fn peel(&self, work: &mut Work<'_>, job: &PeelJob<'_>) -> Result<u32, Error> {
        let (device, target, arguments) = (work.device, work.target, self.arguments.get().all());
        let cut = Cut::of(device, job.raster.cloud, job.raster.footprint)?;
        let most = job.most();
        let mut batch = self.first_batch(work);
        let mut recorded = 0;
        loop {
            let mut recorder = work.timeline.recorder(device)?;
            for _ in 0..batch.div_ceil(job.slots).max(LEAST_WALKS) {
                let layers = u64::from(job.slots).min(most - recorded);
                if layers == 0 {
                    break;
                }
                self.record_walk(&mut recorder, job, (cut, layers as u32), arguments, target)?;
                recorded += layers;
            }
            recorder.copy("peel/summary", self.work.all(), self.work_host.all())?;
            self.told_layers.record(&mut recorder, self.layers.get());
            target.record_read_back(&mut recorder, bands::pixels(job.raster.window))?;
            work.timeline.submit(recorder, "peel/nearest and blend")?;
            let layers = self.work_host.mapped_slice()[0].layers;
            if job.peel.layers == 0 && layers > job.limit {
                return Err(Error::TooManyLayers { limit: job.limit });
            }
            if u64::from(layers) < recorded || recorded == most {
                return Ok(layers);
            }
            work.progress.set_message(format!("rendering, {layers} layers"));
            batch = BATCH;
        }
    }

    /// Records one walk and the layers of it that are blended at most. It does nothing if the one before found fewer
    /// than it could.
    fn record_walk<'a>(
        &'a self,
        recorder: &mut Recorder<'a>,
        job: &PeelJob<'a>,
        (cut, layers): (Cut, u32),
        arguments: Slice<'a, u32>,
        target: &'a Target,
    ) -> Result<(), Error> {
        let PeelJob { raster, slots, .. } = *job;
        let (nearest, last, work) = (self.slots(job), self.last.get().all(), self.work.all());
        let all = &Band::whole(raster.window, 0);
        let (visits, same) = (Some(arguments.skip(4)), |variant| variant);
        if job.wide {
            let wide = nearest.cast();
            raster.record_with(
                recorder,
                all,
                |chunk: Chunk<'a>| Nearest { chunk, last, nearest: wide },
                visits,
                |variant| slots_variant(variant, slots),
            )?;
        } else {
            raster.record_with(
                recorder,
                all,
                |chunk: Chunk<'a>| NearestDepth { chunk, last, nearest },
                visits,
                same,
            )?;
            raster.record_with(recorder, all, |chunk: Chunk<'a>| NearestId { chunk, last, nearest }, visits, same)?;
        }
        let composing = Composing::new(raster.cloud, cut);
        let blend = Blend { composing, nearest, last, work, layers: self.layers.get().all(), into: target.pixels() };
        let push = BlendPush { count: bands::pixels(raster.window) as u32, layers };
        let variant = blend_variant(cut, raster.footprint, job.peel.discs.falloff, job.counted, slots);
        recorder.run(&blend, push, &Run::new(Dispatch::Indirect(arguments.first(3))).variant(variant))?;
        let run = Run::new(Dispatch::Groups(1)).variant(next_variant(slots));
        Ok(recorder.run(&Next { work, arguments }, (), &run)?)
    }
}

/// The variants of `peel/blend` for so many slots.
fn blend_variants(slots: u32) -> Vec<Variant> {
    let choices = <(Cut, (Falloff, bool))>::all();
    let of = |disc: Footprint| {
        let variant = move |(cut, (falloff, counted)): &(Cut, (Falloff, bool))| {
            blend_variant(*cut, disc, *falloff, *counted, slots)
        };
        choices.iter().map(variant).collect::<Vec<_>>()
    };
    DISCS.into_iter().flat_map(of).collect()
}

/// Returns the passes with their variants.
pub fn shaders() -> Vec<Shader> {
    let nearest = |slots| raster::flat_variants().into_iter().map(move |variant| slots_variant(variant, slots));
    vec![
        Shader::new::<Count>(raster::flat_variants()),
        Shader::new::<Nearest>(SLOTS.into_iter().flat_map(nearest)),
        Shader::new::<NearestDepth>(raster::flat_variants()),
        Shader::new::<NearestId>(raster::flat_variants()),
        Shader::new::<Blend>(SLOTS.into_iter().flat_map(blend_variants)),
        Shader::new::<Next>(SLOTS.map(next_variant)),
    ]
}
