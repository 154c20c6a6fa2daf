//! `peel-layers`: layers of point surfaces, each filtered as an image of its own, blended front to back (Dobrev,
//! Rosenthal, Linsen 2010, Sections 4 and 5).
//!
//! A layer visits every point; those nearer than what the layer before shows in their pixel after its filters, plus d̃,
//! are left out. Layers are submitted by the batch, their dispatches indirect: after a layer without a point the device
//! makes those that follow empty, and the host looks only between batches.

use super::image_space::{self, DeliverPush, Emptied, FilterJob, Filterer, Filtering};
use super::own::FamilyBuffers;
use super::peel::{Next, PeelWork, next_variant};
use crate::methods::prelude::*;
use crate::passes::project::points_dispatch;
use crate::scene::PeelLayers;

/// Layers of a submission: what is recorded beyond the last layer costs something, too.
const BATCH: u32 = 8;
/// Words of a dispatch's arguments.
const WORDS: u64 = 4;

gpu_struct! {
    /// Push constants of `peel-layers/blend`.
    pub struct BlendPush {
        columns: u32, // Columns of tiles, and all tiles.
        tiles: u32,
        left: u32, // The window's corner in the rectangle in work, and its size.
        top: u32,
        width: u32,
        height: u32,
        outer_width: u32, // Size of the rectangle in work.
        outer_height: u32,
        distance: f32, // d~ in world units.
        shown: u32, // 1 unless another layer is shown alone.
    }
}

pass! {
    /// Composes the filtered layer behind the layers of each pixel, in tiles that are not background alone, unless
    /// another layer is shown alone; and sets the limit of the next layer.
    pub Blend(BlendPush) = "peel-layers/blend" in "peel_layers/blend" {
        entries: Read<[u32; 2]>,
        depths: Read<f32>,
        colors: Read<[f32; 4]>,
        nearest: ReadWrite<[u32; 2]>,
        limits: ReadWrite<u32>,
        layers: ReadWrite<u32>,
        image: ReadWrite<[f32; 4]>,
        image_depths: ReadWrite<f32>,
    }
}

/// The variant of `peel-layers/blend`; `counted`: with layers per pixel.
fn blend_variant(counted: bool) -> Variant {
    Variant::plain().with("COUNTED", u32::from(counted))
}

/// Input and settings of a window.
#[derive(Clone, Copy)]
pub struct LayersJob<'a> {
    /// Input and settings of each layer.
    pub image: FilterJob<'a>,
    /// Layers at most.
    pub layers: u32,
    /// The only layer that is shown, counted from 1; else all are.
    pub only: Option<u32>,
    /// `true` if layers are counted per pixel.
    pub counted: bool,
    /// `true` if the window is copied to the host.
    pub read_back: bool,
}

fields! {
    /// Buffers of layers and their images, kept from frame to frame.
    pub struct LayerPeeler by device {
        images: Filterer = Filterer::new(device)?,
        limits: Scratch<u32> = Scratch::new("layer limits", Memory::Device),
        layers: Scratch<u32> = Scratch::new("layer counts", Memory::Device),
        work_host: Buffer<PeelWork> = device.buffer("layer work, host", 1, Memory::Readback)?,
        told: Told<u32> = Told::new("layer counts, host"),
        dispatches: Scratch<u32> = Scratch::new("layer dispatches", Memory::Device),
        /// Layers of the last window.
        last_layers: u32 = 0,
    }
}

/// The dispatches of a layer in one buffer: of each chunk's points, then over all tiles. What goes over lists has none
/// where these have none.
#[derive(Clone, Copy)]
struct Dispatches<'a> {
    all: Slice<'a, u32>,
    chunks: u64,
}

impl<'a> Dispatches<'a> {
    fn at(&self, place: u64) -> Slice<'a, u32> {
        self.all.skip(WORDS * (self.chunks + place)).first(3)
    }

    fn emptied(&self) -> Emptied<'a> {
        Emptied { nearest: self.all, measure: self.at(0), list: self.at(1) }
    }
}

impl FamilyBuffers for LayerPeeler {
    fn made(device: &Device) -> Result<Self, Error> {
        Ok(Self::new(device)?)
    }
}

impl LayerPeeler {
    /// Returns layers of every pixel of the window, in its order, as the last counted window left them.
    pub fn read_layers(&self, window: Window) -> Result<Vec<u32>, Error> {
        self.told.read(self.layers.get(), bands::pixels(window))
    }

    /// Peels a window into the target.
    pub(crate) fn render(&mut self, work: &mut Work<'_>, job: &LayersJob<'_>) -> Result<(), Error> {
        let (device, target) = (work.device, work.target);
        let image = &job.image;
        let pixels = bands::pixels(image.window);
        self.images.reserve(device, image)?;
        self.limits.reserve(device, bands::pixels(image.outer))?;
        self.layers.reserve(device, if job.counted { pixels } else { 1 })?;
        self.told.reserve(device, if job.counted { pixels } else { 0 })?;
        let mut recorder = work.timeline.recorder(device)?;
        let words = Self::arguments(&recorder, image)?;
        self.dispatches.reserve(device, WORDS * words.len() as u64)?;
        recorder.update(self.dispatches.get().all(), words.as_flattened());
        self.images.record_clear(&mut recorder, image)?;
        recorder.fill("peel-layers/clear", self.layers.get().all(), 0)?;
        target.pixels().record_nothing(&mut recorder, image.window)?;
        work.timeline.go_on(recorder, "peel-layers/clear")?;

        let dispatches = self.dispatches.get().all();
        let dispatches = Dispatches { all: dispatches, chunks: image.cloud.chunks().count() as u64 };
        let layers = self.peel(work, job, dispatches)?;
        self.last_layers = layers;
        work.facts.layers = work.facts.layers.max(layers);
        self.images.note(image, layers, work.facts);
        Ok(())
    }

    fn arguments(recorder: &Recorder<'_>, job: &FilterJob<'_>) -> Result<Vec<[u32; 4]>, Error> {
        let of = |name, dispatch| recorder.arguments(name, dispatch);
        let mut words = Vec::new();
        for (_, count) in job.cloud.chunks() {
            words.push(of("points/nearest", points_dispatch(count))?);
        }
        words.push(of("image-space/measure", job.measure_dispatch())?);
        words.push(of("image-space/list", job.list_dispatch())?);
        Ok(words)
    }

    /// Batch after batch until nothing is left or enough was peeled; the number of layers.
    fn peel(&self, work: &mut Work<'_>, job: &LayersJob<'_>, dispatches: Dispatches<'_>) -> Result<u32, Error> {
        let (device, target) = (work.device, work.target);
        let (cut, images) = (Cut::new(device, job.image.cloud.len())?, &self.images);
        let foreseen = work.timeline.foresight.knowledge() == Knowledge::Bounds;
        let first = if foreseen { BATCH.max(self.last_layers + 1) } else { BATCH };
        let mut recorded = 0;
        loop {
            let batch = if recorded == 0 { first } else { BATCH }.min(job.layers - recorded);
            let mut recorder = work.timeline.recorder(device)?;
            for number in recorded..recorded + batch {
                let limits = (number > 0).then(|| self.limits.get().all());
                images.record_points(&mut recorder, &job.image, (limits, Some(dispatches.emptied())))?;
                // A layer without a point empties its own filters too.
                let next = Next { work: images.work.all(), arguments: dispatches.all };
                recorder.run(
                    &next,
                    (),
                    &Run::new(Dispatch::Groups(1)).label("peel-layers/next").variant(next_variant(1)),
                )?;
                images.record_image(&mut recorder, &job.image, cut, Some(dispatches.emptied()))?;
                let shown = job.only.is_none_or(|only| number + 1 == only);
                self.record_blend(&mut recorder, job, target, shown)?;
            }
            if recorded == 0 {
                job.image.cloud.record_stats(&mut recorder)?;
            }
            recorder.copy("peel-layers/summary", images.work.all(), self.work_host.all())?;
            images.record_summary(&mut recorder)?;
            self.told.record(&mut recorder, self.layers.get());
            if job.read_back {
                target.record_read_back(&mut recorder, bands::pixels(job.image.window))?;
            }
            work.timeline.submit(recorder, "layers of points")?;
            recorded += batch;
            let layers = self.work_host.mapped_slice()[0].layers;
            if layers < recorded || recorded == job.layers {
                return Ok(layers);
            }
        }
    }

    fn record_blend<'a>(
        &'a self,
        recorder: &mut Recorder<'a>,
        job: &LayersJob<'a>,
        target: &'a Target,
        shown: bool,
    ) -> Result<(), Error> {
        let (image, images) = (&job.image, &self.images);
        let blend = Blend {
            entries: images.entries.get().all(),
            depths: images.depths(image),
            colors: images.colors(image),
            nearest: images.nearest(image).cast(),
            limits: self.limits.get().all(),
            layers: self.layers.get().all(),
            image: target.image(),
            image_depths: target.depths(),
        };
        let DeliverPush { columns, tiles, left, top, width, height } = image.deliver_push();
        let [outer_width, outer_height] = image.outer_size();
        let (distance, shown) = (image.distance, shown.into());
        let push = BlendPush { columns, tiles, left, top, width, height, outer_width, outer_height, distance, shown };
        let run = Run::new(images.deliver_dispatch(image)).variant(blend_variant(job.counted));
        Ok(recorder.run(&blend, push, &run)?)
    }
}

/// Returns the passes with their variants.
pub fn shaders() -> Vec<Shader> {
    vec![Shader::new::<Blend>([false, true].map(blend_variant))]
}

/// Layers of filtered images of points, blended.
pub(crate) struct PeelLayersEngine {
    /// Filters and layers.
    pub settings: PeelLayers,
}

impl PeelLayersEngine {
    fn filtering(&self) -> Filtering {
        Filtering { filters: self.settings.filters, layers: Some(self.settings.peeled()) }
    }
}

impl Engine for PeelLayersEngine {
    fn windows(&self, frame: &Frame, budget: Budget) -> Result<Vec<Window>, Error> {
        self.filtering().windows(frame, budget)
    }

    /// Filters look at the pixels around.
    fn takes_fours(&self) -> bool {
        false
    }

    fn renders_to_survey(&self) -> bool {
        true
    }

    fn extent(&self, _frame: &Frame, _cloud: &DeviceCloud) -> PointExtent {
        PointExtent::pixels(self.filtering().halo().into())
    }

    fn projects(&self) -> bool {
        false
    }

    fn channels(&self) -> Channels {
        Channels { layers: true, ..Channels::NONE }
    }

    /// Only peeling finds the number of layers, so a survey peels, too.
    fn render(&self, cloud: &mut DeviceCloud, buffers: &mut Buffers, work: &mut Work<'_>) -> Result<Outcome, Error> {
        let how = work.frame.projecting_points(cloud);
        let image = self.filtering().job(cloud, work, &how);
        let (layers, only) = (self.settings.peeled(), self.settings.only);
        let (counted, read_back) = (work.frame.fragments, !work.survey);
        let peeler = buffers.resources.own.of::<LayerPeeler>(work.device)?;
        peeler.render(work, &LayersJob { image, layers, only, counted, read_back })?;
        image_space::finish(cloud, work);
        Ok(Outcome::Done)
    }

    fn counts(&self, buffers: &Buffers, frame: &Frame, window: Window) -> Result<Counts, Error> {
        let peeler = buffers.resources.own.there::<LayerPeeler>().filter(|_| frame.fragments);
        let layers = peeler.map(|peeler| peeler.read_layers(window)).transpose()?;
        Ok(Counts { layers, ..Counts::default() })
    }
}

impl Explain for PeelLayersEngine {
    fn least_bytes(&self, pass: &PassRuns<'_>) -> Option<u64> {
        image_space::least_bytes(pass.name, pass.facts, pass.cloud, self.settings.filters.cull)
    }

    fn explain(&self, plan: &mut FramePlan<'_>) {
        self.filtering().explain(plan);
    }
}

/// Returns the passes that layers of filtered images have besides those of one.
pub(crate) fn pass_group() -> PassGroup {
    let names = ["peel-layers/clear", "peel-layers/next", "peel-layers/blend", "peel-layers/summary"];
    PassGroup::new(&names, Absent::Method("no layers of point surfaces"))
}
