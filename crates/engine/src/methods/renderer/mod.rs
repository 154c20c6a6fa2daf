//! The renderer: from points, camera and method to an image and a profile, window by window.

mod deep;
mod depths;
mod parts;
mod supplied;
mod survey;
mod upload;
mod walk;

pub use self::upload::{PointSource, Upload};

use std::time::{Duration, Instant};

use self::walk::{Job, first_counts, largest};
use super::brightness;
use super::bytes::aggregate;
use super::edl::{self, EyeDomeLighting};
use super::engine::{Fragments, Switches};
use super::mean::{self, Mean};
use super::{Colors, FrameProfile, Outputs, shadows, spbr, stochastic};
use crate::cloud::shadow_texture::Casting;
use crate::io::has_memory;
use crate::methods::prelude::*;
use crate::passes::foresight::Foresight;

/// Frames that take longer are submitted in parts, as they wait for counts: whoever cancels one waits for a submission,
/// and some drivers end those of a few seconds.
const LONGEST: Duration = Duration::from_secs(1);

/// A rendered frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Rendered {
    /// The image.
    pub image: Image,
    /// The times.
    pub profile: FrameProfile,
    /// The counts.
    pub facts: Facts,
}

/// Renders frames on one device; keeps buffers from frame to frame.
pub struct Renderer {
    device: Device,
    buffers: Buffers,
    target: Target,
    eye_dome: EyeDomeLighting,
    /// Counts of earlier frames of one kind.
    foresight: Foresight,
    /// The kind of those frames.
    kind: Option<FrameKind>,
    /// Duration of the submissions of the last frame.
    submitted: Duration,
    /// An image that was given back.
    spare: Option<Image>,
    /// Pixels of the last frame, if their colors are all in `target` as the image has them.
    whole: Option<u64>,
    /// Observer that counts finished pixels of a frame, and may cancel it before each submission. Hidden unless the
    /// caller sets one.
    pub progress: Progress,
    /// `true` if passes are timed and their invocations counted, so that profiles have them; without, only the whole
    /// frame is timed ([`FrameProfile::total`]), and passes that have nothing to do with one another may run at once.
    pub timed: bool,
    /// `true` if [`Facts::tile_histogram`] is wanted: the counters of each window's tiles then come to the host, in
    /// submissions of their own.
    pub notes_tiles: bool,
    /// The pixels that are rendered; `None` means all. Pixels outside are arbitrary in the image. Pixels inside are as
    /// in the whole image, without eye-dome lighting, which follows from all depths ([`Self::apply_edl`]).
    pub region: Option<Window>,
    /// Features that tests switch off or limit; nothing else changes them.
    #[doc(hidden)]
    pub switches: Switches,
}

impl Renderer {
    /// Returns a renderer on a device.
    pub fn new(device: &Device) -> Result<Self, Error> {
        Ok(Self {
            device: device.clone(),
            buffers: Buffers::new(device)?,
            target: Target::new(),
            eye_dome: EyeDomeLighting::default(),
            foresight: Foresight::default(),
            kind: None,
            submitted: Duration::ZERO,
            spare: None,
            whole: None,
            progress: Progress::hidden(),
            timed: true,
            notes_tiles: false,
            region: None,
            switches: Switches::of(device.info()),
        })
    }

    /// Returns the device.
    pub fn device(&self) -> &Device {
        &self.device
    }

    /// Takes an image back, whose memory the next frame of its size uses again: memory fresh from the system costs more
    /// time than the pixels that come into it.
    pub fn recycle(&mut self, image: Image) {
        self.spare = Some(image);
    }

    /// Returns colors of the last frame, premultiplied R, G, B and A per pixel, row by row: where the device had those
    /// of the whole image at once, and until anything else is rendered.
    pub fn colors(&self) -> Option<Slice<'_, [f32; 4]>> {
        self.whole.map(|pixels| self.target.image().first(pixels))
    }

    /// Returns a copy of [`Self::colors`] on the host.
    ///
    /// # Errors
    /// Vulkan errors.
    pub fn read_colors(&self) -> Result<Option<Vec<[f32; 4]>>, Error> {
        let read = |pixels| self.target.read_colors(pixels);
        self.whole.map(read).transpose()
    }

    /// Notes that the device no longer has the colors of the last image.
    pub(super) fn disown_colors(&mut self) {
        self.whole = None;
    }

    /// Forgets the counts of earlier frames: the next one waits for its own. Changes no byte.
    pub fn forget(&mut self) {
        self.kind = None;
    }

    /// Renders a frame.
    ///
    /// # Errors
    /// A frame that does not fit, a device that fails, and a frame that [`Self::progress`] cancels: within one
    /// submission, after which the renderer and the cloud serve other frames as before.
    pub fn render(&mut self, cloud: &mut DeviceCloud, frame: &Frame) -> Result<Rendered, Error> {
        self.with_timeline(|renderer, timeline| renderer.render_by(cloud, frame, timeline))
    }

    /// Renders a frame like [`Self::render`], and finds its device time as a whole ([`FrameProfile::total`]) and not
    /// that of its passes, which timestamps between them would keep apart.
    ///
    /// # Errors
    /// The errors of [`Self::render`].
    pub fn render_whole(&mut self, cloud: &mut DeviceCloud, frame: &Frame) -> Result<Rendered, Error> {
        self.with_timeline(|renderer, timeline| {
            timeline.stamps = Stamps::Ends;
            renderer.render_by(cloud, frame, timeline)
        })
    }

    /// Does work whose submissions are timed, with what is known of earlier frames.
    fn with_timeline<T>(&mut self, work: impl FnOnce(&mut Self, &mut Timeline) -> T) -> T {
        let mut timeline = Timeline::with(&self.progress, std::mem::take(&mut self.foresight));
        timeline.stamps = if self.timed { Stamps::Passes } else { Stamps::Ends };
        let done = work(self, &mut timeline);
        self.submitted = timeline.submitted;
        self.foresight = timeline.foresight;
        done
    }

    /// Renders a frame by the submissions of a timeline.
    fn render_by(
        &mut self,
        cloud: &mut DeviceCloud,
        frame: &Frame,
        timeline: &mut Timeline,
    ) -> Result<Rendered, Error> {
        let engine = engine_of(&frame.method);
        let engine = engine.as_ref();
        self.check_memory(engine, frame)?;
        let begun = self.begin(engine, cloud, frame, timeline, false)?;
        let learns = self.learns(frame, cloud, &begun.windows, timeline);
        let job = Job { learns, images: self.images(frame), ..Job::new(engine, frame, begun.budget) };
        let (image, mut facts) = if frame.is_mean() && frame.shading.edl.edl {
            self.mean_of_lit(cloud, &job, &begun, timeline)?
        } else {
            self.picture(cloud, &job, &begun, timeline)?
        };
        let profile = self.end(engine, &begun, timeline, &mut facts, (frame, &image), cloud);
        Ok(Rendered { image, profile, facts })
    }

    /// Renders the mean of images that are lit each by itself, from the depths of all of its pixels: one image after
    /// the other.
    fn mean_of_lit(
        &mut self,
        cloud: &mut DeviceCloud,
        job: &Job<'_>,
        begun: &Begun,
        timeline: &mut Timeline,
    ) -> Result<(Image, Facts), Error> {
        let [width, height] = job.frame.size;
        let (mut image, mut facts) = (self.begin_image(job.engine, job.frame)?, first_counts(cloud));
        let mut mean = Mean::new(job.frame, &image);
        for (number, frame) in job.images.iter().enumerate() {
            self.recycle(image);
            let alone = Job { frame, images: vec![*frame], counted: Some(facts), ..job.clone() };
            (image, facts) = self.picture(cloud, &alone, begun, timeline)?;
            mean.add(&image, [0, 0, width, height], number == 0);
        }
        mean.finish(&mut image);
        Ok((image, facts))
    }

    /// Renders the picture of a frame that has begun.
    fn picture(
        &mut self,
        cloud: &mut DeviceCloud,
        job: &Job<'_>,
        begun: &Begun,
        timeline: &mut Timeline,
    ) -> Result<(Image, Facts), Error> {
        let (engine, frame) = (job.engine, job.frame);
        let mut image = self.begin_image(engine, frame)?;
        let facts = match (engine.samples(frame), frame.max_error) {
            (Some(limit), Some(most)) => {
                let mut samples = limit.min(stochastic::FIRST_SAMPLES);
                loop {
                    let facts = self.draw(
                        cloud,
                        &Job { samples: 0..samples, ..job.clone() },
                        &begun.windows,
                        &mut image,
                        timeline,
                    )?;
                    let errors = image.stderr.as_deref().unwrap_or_default();
                    match stochastic::more_samples(samples, limit, errors, most) {
                        Some(more) => samples = more,
                        None => break facts,
                    }
                }
            }
            (samples, _) => {
                let job = Job { samples: 0..samples.unwrap_or(0), ..job.clone() };
                self.draw(cloud, &job, &begun.windows, &mut image, timeline)?
            }
        };
        if self.target.leaves_colors() {
            image.rgba = Vec::new();
        }
        image.stderr = image.stderr.filter(|_| frame.fragments || frame.spread);
        let alone = if frame.is_mean() { frame.image(frame.samples / 2) } else { *frame };
        let frame = &alone;
        self.find_depths(cloud, frame, begun.budget, &mut image, timeline)?;
        if frame.shading.edl.edl && self.region.is_none() {
            self.light_eye_domes(frame, begun.shading, &mut image, timeline)?;
        }
        image.depth_median = image.depth_median.filter(|_| frame.depths || self.region.is_some());
        Ok((image, facts))
    }

    /// Brings to the device what a frame needs of a cloud, casts its shadows, cuts it into windows, and makes room for
    /// them. A survey needs no light, and mostly no target.
    fn begin(
        &mut self,
        engine: &dyn Engine,
        cloud: &mut DeviceCloud,
        frame: &Frame,
        timeline: &mut Timeline,
        survey: bool,
    ) -> Result<Begun, Error> {
        frame.check()?;
        self.make_ready(engine, cloud, frame, survey)?;
        self.disown_colors();
        if !survey {
            self.device.reset_peak();
        }
        if cloud.supply().is_none() && !survey {
            engine.prepare(&self.device, cloud, frame)?;
        }
        let waits = self.device.waits();
        let lights = lights(cloud, frame);
        if !survey {
            self.cast_shadows(engine, cloud, frame, timeline)?;
        }
        let budget = self.budget(engine, cloud, frame);
        let (budget, shading) = edl::divided(budget, frame);
        // Pixels of the image for one of the picture.
        let parts = if !survey && self.fours(engine, frame).is_some() { 4 } else { 1 };
        let each = Budget { bytes: budget.bytes / parts, tiles: budget.tiles, binding: budget.binding / parts };
        let windows = if survey { engine.windows(frame, budget)? } else { self.windows(engine, frame, each)? };
        if !survey || engine.renders_to_survey() {
            self.make_target(parts * largest(&windows), frame)?;
        }
        Ok(Begun { waits, lights, budget, shading, windows })
    }

    /// Makes room for windows of so many pixels, of which the host gets the outputs of a frame.
    fn make_target(&mut self, pixels: u64, frame: &Frame) -> Result<(), Error> {
        self.target.reserve(&self.device, pixels, brought(frame))?;
        self.target.follow(&self.device, frame)
    }

    /// Returns an image to draw into.
    fn begin_image(&mut self, engine: &dyn Engine, frame: &Frame) -> Result<Image, Error> {
        // Buffers of a driver for CPUs have taken some of the host's memory meanwhile.
        self.check_memory(engine, frame)?;
        Ok(blank(self.spare.take(), engine, frame))
    }

    /// Refuses an image that the host's memory can't hold.
    fn check_memory(&self, engine: &dyn Engine, frame: &Frame) -> Result<(), Error> {
        let [width, height] = frame.size;
        let outputs = brought(frame);
        let is_room = |spare: &Image| spare.has_colors() || outputs.colors != Colors::Float;
        if self.spare.as_ref().is_some_and(|spare| (spare.width, spare.height) == (width, height) && is_room(spare)) {
            return Ok(());
        }
        let channels = engine.channels();
        let is_counted = frame.fragments && channels.fragments != Fragments::Never;
        let has_spread = engine.samples(frame).is_some() && frame.wants_spread();
        // Colors that stay may come after all. Then Z, the counts, the errors and the other depths.
        let words = if outputs.colors == Colors::Bytes { 1 } else { 4 }
            + u64::from(outputs.depth)
            + u64::from(is_counted)
            + u64::from(frame.fragments && channels.layers)
            + if has_spread { 3 } else { 0 }
            + if frame.depths { 2 } else { 0 };
        let sums = if frame.is_mean() { mean::PIXEL_BYTES } else { 0 };
        let bytes = (4 * words + sums) * u64::from(width) * u64::from(height);
        if has_memory(bytes) { Ok(()) } else { Err(Error::HostMemory { width, height, bytes }) }
    }

    /// Completes the counts of a frame, and sums up its times.
    fn end(
        &self,
        engine: &dyn Engine,
        begun: &Begun,
        timeline: &mut Timeline,
        facts: &mut Facts,
        (frame, image): (&Frame, &Image),
        cloud: &DeviceCloud,
    ) -> FrameProfile {
        (facts.light_views, facts.light_resolution) = begun.lights;
        let begin = timeline.start.unwrap_or_else(Instant::now);
        let wall = begin.elapsed();
        facts.peak_device_bytes = self.device.peak_bytes();
        let (submitted, runs) = (timeline.submitted, std::mem::take(&mut timeline.passes));
        let passes = aggregate(|pass| engine.least_bytes(pass), &runs, facts, (frame, image), cloud);
        let waits = self.device.waits() - begun.waits;
        FrameProfile { passes, begin, timeline: runs, submitted, total: timeline.whole, wall, waits }
    }

    /// Returns the frames that are drawn one after the other for a frame: of each of its images alone, or of four at
    /// once.
    pub fn images(&self, frame: &Frame) -> Vec<Frame> {
        self.fours(engine_of(&frame.method).as_ref(), frame).unwrap_or_else(|| frame.images())
    }

    /// Returns the frames of four images at a time, if they are drawn like this.
    fn fours(&self, engine: &dyn Engine, frame: &Frame) -> Option<Vec<Frame>> {
        frame.fours().filter(|_| self.switches.together && engine.takes_fours())
    }

    /// Returns the windows of a frame, as far as they lie in the region.
    fn windows(&self, engine: &dyn Engine, frame: &Frame, budget: Budget) -> Result<Vec<Window>, Error> {
        let windows = engine.windows(frame, budget)?;
        Ok(match self.region {
            Some(region) => windows.into_iter().filter_map(|window| bands::within(window, region)).collect(),
            None => windows,
        })
    }

    /// Brings to the device what frames need of a cloud, unless the frame is canceled already.
    fn make_ready(
        &self,
        engine: &dyn Engine,
        cloud: &mut DeviceCloud,
        frame: &Frame,
        survey: bool,
    ) -> Result<(), Error> {
        self.progress.check()?;
        self.divide(engine, cloud, frame)?;
        self.cut(cloud, frame)?;
        if cloud.supply().is_none() {
            return engine.place(&self.device, cloud, frame, survey);
        }
        // Points of a supply come with each window.
        frame.method.threshold().map_or(Ok(()), |threshold| cloud.find_parts(threshold, &self.progress))
    }

    /// Computes the light of each point for the shadows of a frame, unless it has none or the cloud has them already.
    /// Shadows stay with the cloud, for any camera and method, until others are cast.
    fn cast_shadows(
        &self,
        engine: &dyn Engine,
        cloud: &mut DeviceCloud,
        frame: &Frame,
        timeline: &mut Timeline,
    ) -> Result<(), Error> {
        let Some(casting) = shadows::casting(frame, cloud).filter(|casting| !cloud.has_cast(casting)) else {
            return Ok(());
        };
        if cloud.supply().is_some() {
            return self.see_by_lights(cloud, frame, &casting, timeline);
        }
        let how = frame.projecting_points(cloud);
        let budget = self.budget(engine, cloud, frame).bytes;
        shadows::cast(&self.device, cloud, (&casting, &how), budget, &self.progress, timeline)
    }

    /// Computes the shadow texture for frames like this one, without rendering any; the cloud then has it
    /// ([`DeviceCloud::lit`]). Returns its settings, or `None` if such frames have no shadows.
    ///
    /// # Errors
    /// The errors of [`Renderer::render`].
    pub fn cast(&mut self, cloud: &mut DeviceCloud, frame: &Frame) -> Result<Option<Casting>, Error> {
        let engine = engine_of(&frame.method);
        self.make_ready(engine.as_ref(), cloud, frame, false)?;
        self.cast_shadows(engine.as_ref(), cloud, frame, &mut Timeline::new(&self.progress))?;
        Ok(shadows::casting(frame, cloud))
    }

    /// Returns `true` if a frame can learn its counts from earlier ones of its kind.
    fn learns(&mut self, frame: &Frame, cloud: &DeviceCloud, windows: &[Window], timeline: &mut Timeline) -> bool {
        let kind = FrameKind {
            method: frame.method,
            size: frame.size,
            samples: frame.samples,
            region: self.region,
            points: cloud.total(),
        };
        if self.kind != Some(kind) {
            timeline.foresight.forget();
            self.kind = Some(kind);
        }
        windows.len() == 1 && self.device.info().conditional && cloud.supply().is_none()
    }

    /// Returns the reason why frames like this one, which was rendered last, wait for their counts, a phrase; `None` if
    /// nothing keeps them from being foreseen.
    pub fn hindrance(&self, cloud: &DeviceCloud, rendered: &Rendered) -> Option<&'static str> {
        let images = rendered.facts.images;
        if cloud.supply().is_some() {
            Some("their points come to the device part by part")
        } else if !self.device.info().conditional {
            Some("the device can't leave commands out (VK_EXT_conditional_rendering)")
        } else if rendered.facts.windows > images || rendered.facts.bands > images {
            Some("the device's memory holds only a part of the picture's fragments at a time")
        } else if rendered.profile.submitted > LONGEST {
            Some("they take longer than a second")
        } else {
            None
        }
    }

    /// Returns `true` if the budget and a binding allow sorting all of a cloud's splats.
    pub fn can_sort(&self, cloud: &DeviceCloud, frame: &Frame) -> bool {
        let (needed, engine) = (Bins::most_bytes(&self.device, cloud), engine_of(&frame.method));
        cloud.len() * 16 <= self.device.limits().binding_bytes
            && needed <= self.budget(engine.as_ref(), cloud, frame).left(0)
    }

    fn budget(&self, engine: &dyn Engine, cloud: &DeviceCloud, frame: &Frame) -> Budget {
        let limits = self.device.limits();
        if cloud.supply().is_some() {
            let bytes = supplied::rest(&self.device, frame).saturating_sub(cloud.light_bytes());
            return Budget { bytes, tiles: 0, binding: limits.binding_bytes };
        }
        let streamed = engine.streamed(&self.device, cloud, frame);
        let bytes = frame.memory_budget.unwrap_or_else(|| {
            // A cloud in ensembles may come to the device with the frame alone.
            let resident = if streamed.is_some() { 0 } else { cloud.bytes().max(cloud.column_bytes()) };
            // A quarter stays free for the system and for other programs.
            (limits.heap_bytes / 4 * 3).saturating_sub(resident).max(64 << 20)
        });
        let bytes = streamed.map_or(bytes, |points| spbr::stream::rest(bytes, cloud, points));
        Budget { bytes, tiles: 0, binding: limits.binding_bytes }
    }
}

/// A frame that has begun.
struct Begun {
    /// Submissions that were waited for before.
    waits: u64,
    /// Images of lights, and their columns and rows.
    lights: (u64, u32),
    budget: Budget,
    /// Bytes of the budget for shading.
    shading: u64,
    windows: Vec<Window>,
}

/// Frames that predict each other's counts: counts of a kind are mostly of much the same size.
#[derive(Clone, Copy, PartialEq)]
struct FrameKind {
    method: Method,
    size: [u32; 2],
    samples: u32,
    region: Option<Window>,
    points: u64,
}

/// Returns the number of images from a light's point of view that a frame of a cloud needs, and their columns and rows.
fn lights(cloud: &DeviceCloud, frame: &Frame) -> (u64, u32) {
    let casting = shadows::casting(frame, cloud).filter(|casting| !cloud.has_cast(casting));
    casting.map_or((0, 0), |casting| (shadows::image_count(&casting, cloud), casting.resolution))
}

/// Returns an image of a frame's size, in the memory of a spare one if that is as large. The values are arbitrary,
/// because the windows cover all of it.
fn blank(spare: Option<Image>, engine: &dyn Engine, frame: &Frame) -> Image {
    let [width, height] = frame.size;
    let pixels = width as usize * height as usize;
    let channels = engine.channels();
    let fragments = (frame.fragments && channels.fragments != Fragments::Never).then(|| vec![0; pixels]);
    let layers = (frame.fragments && channels.layers).then(|| vec![0; pixels]);
    let stderr = (engine.samples(frame).is_some() && frame.wants_spread()).then(|| vec![[0.0; 3]; pixels]);
    let outputs = brought(frame);
    let is_bytes = outputs.colors == Colors::Bytes;
    let spare = spare.unwrap_or_default();
    let rgba = room(spare.rgba, if is_bytes { 0 } else { pixels });
    let bytes = is_bytes.then(|| room(spare.bytes.unwrap_or_default(), pixels));
    let depth = room(spare.depth, if outputs.depth { pixels } else { 0 });
    Image { width, height, rgba, bytes, depth, samples: 1, fragments, layers, stderr, ..Image::default() }
}

/// Returns so many elements of any value, in the memory of spare ones if those are as many.
fn room<T: bytemuck::Zeroable + Clone>(spare: Vec<T>, len: usize) -> Vec<T> {
    if spare.len() == len { spare } else { bytemuck::zeroed_vec(len) }
}

/// Returns the outputs of a frame that come to the host: those that are wanted, or all where the host goes on with
/// them.
pub(crate) fn brought(frame: &Frame) -> Outputs {
    let by_host = frame.is_mean() || frame.shading.edl.edl || frame.depths || brightness::is_applied(&frame.method);
    if by_host { Outputs::default() } else { frame.outputs }
}
