//! The renderer: from points, camera and method to an image and a profile, window by window.

mod arranged;
mod deep;
mod parts;
mod supplied;

use std::cell::RefCell;
use std::ops::Range;
use std::sync::Arc;
use std::time::{Duration, Instant};

use crate::progress::Progress;

use super::abuffer::{self, ListEngine, Lists, Shown};
use super::brightness;
use super::bytes::aggregate;
use super::cost::Load;
use super::edl::{self, EyeDomeLighting, Surface};
use super::engine::{Counts, Engine, Fragments, Switches, Work, project};
use super::{
    Buffers, Error, Facts, Frame, FrameProfile, Outcome, SamplePart, Target, Timeline, engine_of, shadows, spbr,
    stochastic,
};
use crate::cloud::shadow_texture::Casting;
use crate::gpu::{Device, Slice};
use crate::image::Image;
use crate::passes::bands::{self, Budget, Window};
use crate::passes::bin::Bins;
use crate::passes::compose::Cut;
use crate::passes::foresight::{Foresight, Knowledge};
use crate::passes::project::{DeviceCloud, Stats};
use crate::points::Points;
use crate::prepare::dealt_file::DealtFile;
use crate::prepare::ensembles::Dealt;
use crate::scene::{Discs, MAX_LAYERS, Method};

/// Frames that take longer are submitted in parts, as they wait for counts: whoever cancels one waits for a submission, and some
/// drivers end those of a few seconds.
const LONGEST: Duration = Duration::from_secs(1);

/// A rendered frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Rendered {
    /// The image.
    pub image: Image,
    /// Its times.
    pub profile: FrameProfile,
    /// Its counts.
    pub facts: Facts,
}

/// Renders frames on one device; keeps buffers from frame to frame.
pub struct Renderer {
    device: Device,
    buffers: Buffers,
    target: Target,
    eye_dome: EyeDomeLighting,
    /// Facts about frames of one kind, and which kind that is.
    foresight: Foresight,
    kind: Option<Kind>,
    /// Duration of the submissions of the last frame.
    submitted: Duration,
    /// An image that was given back.
    spare: Option<Image>,
    /// Pixels of the last frame, if their colors are all in `target` as the image has them.
    whole: Option<u64>,
    /// Counts finished pixels of a frame, and is asked before each submission if the frame may go on; hidden unless the caller
    /// puts its own here.
    pub progress: Progress,
    /// `true` if passes are timed and their invocations counted, so that profiles have them; without, passes that have
    /// nothing to do with one another may run at once.
    pub timed: bool,
    /// False if nobody needs colors on the host: where the device has those of the whole image at once, they stay there
    /// ([`Self::colors`]), and [`Image::rgba`] is empty.
    pub host_colors: bool,
    /// `true` if opaque splats and layers use 64-bit atomics; follows the device unless a test switches it off.
    pub wide_atomics: bool,
    /// `true` if ensembles are drawn in one go where possible; a test may switch it off.
    pub single_pass: bool,
    /// Most bits of a key for epochs of ensembles; 31 unless a test sets fewer.
    pub epoch_bits: u32,
    /// The pixels that are rendered, all if there are none; those outside are arbitrary in the image. They are as in the whole image, but for
    /// eye-dome lighting, which follows from all depths ([`Self::apply_edl`]).
    pub region: Option<Window>,
    /// Layers after which `peel` gives up; [`MAX_LAYERS`] unless a test sets fewer.
    pub max_layers: u32,
}

impl Renderer {
    /// Returns a renderer on a device.
    pub fn new(device: &Device) -> Result<Self, Error> {
        Ok(Self {
            device: device.clone(),
            buffers: Buffers::new(device)?,
            target: Target::new(),
            eye_dome: EyeDomeLighting::new(),
            foresight: Foresight::default(),
            kind: None,
            submitted: Duration::ZERO,
            spare: None,
            whole: None,
            progress: Progress::hidden(),
            timed: true,
            host_colors: true,
            wide_atomics: device.info().int64_atomics,
            single_pass: true,
            epoch_bits: 31,
            region: None,
            max_layers: MAX_LAYERS,
        })
    }

    /// Returns the device.
    pub fn device(&self) -> &Device {
        &self.device
    }

    /// Uploads a scene's points.
    pub fn upload(&self, points: &Points) -> Result<DeviceCloud, Error> {
        Cut::new(&self.device, points.len() as u64)?;
        Ok(DeviceCloud::new(&self.device, points)?)
    }

    /// Takes points that were dealt: for `spbr` and `spbr-simplified`, but any method may render them. They go to the device
    /// with the first frame; points that don't fit [`Frame::memory_budget`] go through it while a frame of these methods is
    /// rendered. The list stays in the host's memory.
    pub fn upload_dealt(&self, dealt: &Dealt) -> Result<DeviceCloud, Error> {
        check_dealt(dealt.points.len() as u64)?;
        Ok(DeviceCloud::of_dealt(&self.device, dealt)?)
    }

    /// Returns the same of points in a file, where they stay; `sample` stands for them, with what is known of all.
    ///
    /// # Errors
    /// More points than an index tells apart, or no memory for small buffers.
    pub fn upload_dealt_file(&self, sample: &Points, file: &Arc<DealtFile>) -> Result<DeviceCloud, Error> {
        check_dealt(file.len())?;
        Ok(DeviceCloud::of_dealt_file(&self.device, sample, file)?)
    }

    /// Takes an image back, whose memory the next frame of its size uses again: memory fresh from the system costs more time
    /// than the pixels that come into it.
    pub fn recycle(&mut self, image: Image) {
        self.spare = Some(image);
    }

    /// Returns colors of the last frame, premultiplied R, G, B and A per pixel, row by row: where the device had those
    /// of the whole image at once, and until anything else is rendered.
    pub fn colors(&self) -> Option<Slice<'_, [f32; 4]>> {
        self.whole.map(|pixels| self.target.image().first(pixels))
    }

    /// Returns a copy of them on the host.
    ///
    /// # Errors
    /// Vulkan errors.
    pub fn read_colors(&self) -> Result<Option<Vec<[f32; 4]>>, Error> {
        let read = |pixels| self.target.read_colors(pixels);
        self.whole.map(read).transpose()
    }

    /// The device has no colors any more that are those of the last image.
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
    /// A frame that does not fit, a device that fails, and a frame that [`Self::progress`] cancels: within one submission, after
    /// which the renderer and the cloud serve other frames as before.
    pub fn render(&mut self, cloud: &mut DeviceCloud, frame: &Frame) -> Result<Rendered, Error> {
        self.with_timeline(|renderer, timeline| renderer.render_by(cloud, frame, timeline))
    }

    /// Does work whose submissions are timed, with what is known of earlier frames.
    fn with_timeline<T>(&mut self, work: impl FnOnce(&mut Self, &mut Timeline) -> T) -> T {
        let mut timeline = Timeline::with(&self.progress, std::mem::take(&mut self.foresight));
        timeline.timed = self.timed;
        let done = work(self, &mut timeline);
        self.submitted = timeline.submitted;
        self.foresight = timeline.foresight;
        done
    }

    /// The same, by the submissions of a timeline.
    fn render_by(
        &mut self,
        cloud: &mut DeviceCloud,
        frame: &Frame,
        timeline: &mut Timeline,
    ) -> Result<Rendered, Error> {
        let engine = engine_of(&frame.method);
        let engine = engine.as_ref();
        let begun = self.begin(engine, cloud, frame, timeline)?;
        let mut image = self.begin_image(engine, frame);
        let learns = self.learns(frame, cloud, &begun.windows, timeline);
        let drawing = begun.drawing(engine, frame, learns, None);
        let mut facts = match (engine.samples(frame), frame.max_error) {
            (Some(limit), Some(most)) => {
                let mut samples = limit.min(stochastic::FIRST_SAMPLES);
                loop {
                    let facts = self.draw(cloud, &drawing, 0..samples, &mut image, timeline)?;
                    let errors = image.stderr.as_deref().unwrap_or_default();
                    match stochastic::more_samples(samples, limit, errors, most) {
                        Some(more) => samples = more,
                        None => break facts,
                    }
                }
            }
            (samples, _) => self.draw(cloud, &drawing, 0..samples.unwrap_or(0), &mut image, timeline)?,
        };
        if self.target.keeps_colors {
            image.rgba = Vec::new();
        }
        image.stderr = image.stderr.filter(|_| frame.fragments || frame.spread);
        self.find_depths(cloud, frame, begun.budget, &mut image, timeline)?;
        if frame.shading.edl.edl && self.region.is_none() {
            self.light_eye_domes(frame, begun.shading, &mut image, timeline)?;
        }
        image.depth_median = image.depth_median.filter(|_| frame.depths || self.region.is_some());
        let profile = self.end(engine, &begun, timeline, &mut facts, (frame, &image), cloud);
        Ok(Rendered { image, profile, facts })
    }

    /// Brings to the device what a frame needs of a cloud, casts its shadows, cuts it into windows, and makes room for them.
    fn begin(
        &mut self,
        engine: &dyn Engine,
        cloud: &mut DeviceCloud,
        frame: &Frame,
        timeline: &mut Timeline,
    ) -> Result<Begun, Error> {
        frame.check()?;
        self.place(engine, cloud, frame, false)?;
        self.disown_colors();
        self.device.reset_peak();
        if cloud.supply().is_none() {
            engine.prepare(&self.device, cloud, frame)?;
        }
        let waits = self.device.waits();
        let light_views = light_views(cloud, frame);
        self.cast_shadows(engine, cloud, frame, timeline)?;
        let budget = self.budget(engine, cloud, frame);
        let (budget, shading) = edl::divided(budget, frame);
        let windows = self.windows(engine, frame, budget)?;
        self.target.reserve(&self.device, largest(&windows))?;
        Ok(Begun { waits, light_views, budget, shading, windows })
    }

    /// An image to draw into; decides if its colors come to the host.
    fn begin_image(&mut self, engine: &dyn Engine, frame: &Frame) -> Image {
        self.target.keeps_colors =
            !self.host_colors && !frame.shading.edl.edl && !frame.depths && !brightness::is_applied(&frame.method);
        blank(self.spare.take(), engine, frame)
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
        facts.light_views = begun.light_views;
        let begin = timeline.start.unwrap_or_else(Instant::now);
        let wall = begin.elapsed();
        facts.peak_device_bytes = self.device.peak_bytes();
        let (submitted, runs) = (timeline.submitted, std::mem::take(&mut timeline.passes));
        let passes = aggregate(engine, &runs, facts, (frame, image), cloud);
        let waits = self.device.waits() - begun.waits;
        FrameProfile { passes, begin, timeline: runs, submitted, wall, waits }
    }

    /// The windows of a frame, as far as they lie in the region.
    fn windows(&self, engine: &dyn Engine, frame: &Frame, budget: Budget) -> Result<Vec<Window>, Error> {
        let windows = engine.windows(frame, budget)?;
        Ok(match self.region {
            Some(region) => windows.into_iter().filter_map(|window| bands::within(window, region)).collect(),
            None => windows,
        })
    }

    /// Eye-dome lighting of an image that was put together from regions ([`Self::region`]).
    ///
    /// # Errors
    /// Those of [`Self::render`].
    pub fn apply_edl(&mut self, cloud: &DeviceCloud, frame: &Frame, image: &mut Image) -> Result<(), Error> {
        let budget = self.budget(engine_of(&frame.method).as_ref(), cloud, frame);
        let (_, shading) = edl::divided(budget, frame);
        self.light_eye_domes(frame, shading, image, &mut Timeline::new(&self.progress))?;
        image.depth_median = image.depth_median.take().filter(|_| frame.depths);
        Ok(())
    }

    fn light_eye_domes(
        &mut self,
        frame: &Frame,
        budget: u64,
        image: &mut Image,
        timeline: &mut Timeline,
    ) -> Result<(), Error> {
        let Image { rgba, depth, depth_median, .. } = image;
        let surface = Surface { size: frame.size, depths: depth_median.as_deref().unwrap_or(depth) };
        self.whole = None;
        self.eye_dome.apply(&self.device, &frame.shading.edl, budget, surface, rgba, timeline)
    }

    /// Brings to the device what frames need of a cloud, unless the frame is cancelled already.
    fn place(&self, engine: &dyn Engine, cloud: &mut DeviceCloud, frame: &Frame, survey: bool) -> Result<(), Error> {
        self.progress.check()?;
        self.cut(cloud, frame)?;
        if cloud.supply().is_none() {
            return engine.place(&self.device, cloud, frame, survey);
        }
        // Those of which some come at a time come with each window.
        frame.method.threshold().map_or(Ok(()), |threshold| Ok(cloud.find_parts(threshold, &self.progress)?))
    }

    /// Computes the light of each point for the shadows of a frame, unless it has none or the cloud has them already.
    /// They stay with the cloud, for any camera and method, until others are cast.
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
    /// Those of [`Renderer::render`].
    pub fn cast(&mut self, cloud: &mut DeviceCloud, frame: &Frame) -> Result<Option<Casting>, Error> {
        let engine = engine_of(&frame.method);
        self.place(engine.as_ref(), cloud, frame, false)?;
        self.cast_shadows(engine.as_ref(), cloud, frame, &mut Timeline::new(&self.progress))?;
        Ok(shadows::casting(frame, cloud))
    }

    /// Renders the windows of a frame into an image, or keeps their sums, with these samples or ensembles.
    fn draw(
        &mut self,
        cloud: &mut DeviceCloud,
        drawing: &Drawing<'_>,
        samples: Range<u32>,
        image: &mut Image,
        timeline: &mut Timeline,
    ) -> Result<Facts, Error> {
        let Drawing { engine, frame, windows, budget, learns, sums } = *drawing;
        let mut facts = self.begin_windows(cloud, frame);
        let mut windows = last_first(windows);
        while let Some(window) = windows.pop() {
            self.target.keeps_colors &= is_whole(window, frame);
            let samples = samples.clone();
            let part = Part { engine, frame, window, budget, samples, sums, survey: false, learns };
            match self.window(cloud, &part, timeline, &mut facts)? {
                Outcome::Done if sums.is_some() => self.progress.check()?,
                Outcome::Done => self.deliver(engine, frame, window, image)?,
                Outcome::Overflow => split(engine, cloud, window, &mut windows)?,
            }
        }
        Ok(facts)
    }

    /// Begins to go through the windows of a frame: its first counts.
    fn begin_windows(&mut self, cloud: &DeviceCloud, frame: &Frame) -> Facts {
        self.progress.set_length(u64::from(frame.size[0]) * u64::from(frame.size[1]));
        self.progress.set_position(0);
        self.whole = None;
        Facts { points: cloud.drawn(), gaussians: cloud.gaussian_count(), ..Default::default() }
    }

    /// Copies a window that is in the target into the image, with its counts.
    fn deliver(&mut self, engine: &dyn Engine, frame: &Frame, window: Window, image: &mut Image) -> Result<(), Error> {
        self.progress.check()?;
        self.whole = is_whole(window, frame).then(|| bands::pixels(window));
        self.target.deliver(window, image);
        place(frame, window, engine.counts(&self.buffers, frame, window)?, image);
        Ok(())
    }

    /// Returns `true` if a frame can learn its counts from earlier ones of its kind.
    fn learns(&mut self, frame: &Frame, cloud: &DeviceCloud, windows: &[Window], timeline: &mut Timeline) -> bool {
        let kind = Kind { method: frame.method, size: frame.size, region: self.region, points: cloud.total() };
        if self.kind != Some(kind) {
            timeline.foresight.forget();
            self.kind = Some(kind);
        }
        windows.len() == 1 && self.device.info().conditional && cloud.supply().is_none()
    }

    /// Renders or surveys a window; of one that has to be cut the facts don't count. One that was not as foreseen is rendered once
    /// more.
    fn window(
        &mut self,
        cloud: &mut DeviceCloud,
        part: &Part<'_>,
        timeline: &mut Timeline,
        facts: &mut Facts,
    ) -> Result<Outcome, Error> {
        timeline.foresight.begin(!part.learns || self.submitted > LONGEST);
        loop {
            let before = facts.clone();
            let outcome = self.attempt(cloud, part, timeline, facts);
            timeline.drop_paused();
            let waited = timeline.foresight.knowledge() == Knowledge::None;
            match outcome {
                Ok(Outcome::Done) => {
                    if part.learns {
                        timeline.foresight.finish();
                    }
                    return outcome;
                }
                // An upper bound may not fit where a count does.
                Ok(Outcome::Overflow) if !waited => {}
                Err(ref error) if !waited && error.is_refusal() => {}
                _ => {
                    *facts = before;
                    return outcome;
                }
            }
            *facts = before;
            timeline.foresight.miss();
        }
    }

    fn attempt(
        &mut self,
        cloud: &mut DeviceCloud,
        part: &Part<'_>,
        timeline: &mut Timeline,
        facts: &mut Facts,
    ) -> Result<Outcome, Error> {
        if self.bring(cloud, part, timeline)? == Outcome::Overflow {
            return Ok(Outcome::Overflow);
        }
        let (mut work, buffers) = self.work(part, timeline, facts);
        let outcome = part.engine.render(cloud, buffers, &mut work)?;
        if outcome == Outcome::Done {
            for note in std::mem::take(&mut work.later) {
                note(work.facts, work.timeline);
            }
        }
        Ok(outcome)
    }

    /// A window in work, and the buffers for it.
    fn work<'a>(
        &'a mut self,
        part: &Part<'a>,
        timeline: &'a mut Timeline,
        facts: &'a mut Facts,
    ) -> (Work<'a>, &'a mut Buffers) {
        let work = Work {
            device: &self.device,
            frame: part.frame,
            window: part.window,
            budget: part.budget,
            samples: part.samples.clone(),
            sums: part.sums,
            target: &self.target,
            timeline,
            facts,
            progress: &self.progress,
            switches: Switches {
                wide_atomics: self.wide_atomics,
                single_pass: self.single_pass,
                epoch_bits: self.epoch_bits,
                max_layers: self.max_layers,
            },
            survey: part.survey,
            later: Vec::new(),
        };
        (work, &mut self.buffers)
    }

    /// Returns the lists of a frame that fits in one window and band, before sorting: for tests and inspection.
    pub fn lists(&mut self, cloud: &mut DeviceCloud, frame: &Frame, discs: Discs) -> Result<Lists, Error> {
        frame.check()?;
        let engine = ListEngine { discs, linked: matches!(frame.method, Method::LinkedList(_)), shown: Shown::First };
        let budget = self.budget(&engine, cloud, frame);
        let mut timeline = Timeline::new(&self.progress);
        engine.lists(&self.device, cloud, &mut self.buffers, (frame, budget), &mut timeline)
    }

    /// Finds the depths that a frame asks for beside those of first fragments, as far as its method has them: medians, where eye-dome
    /// lighting goes by them too, and means.
    fn find_depths(
        &mut self,
        cloud: &mut DeviceCloud,
        frame: &Frame,
        budget: Budget,
        image: &mut Image,
        timeline: &mut Timeline,
    ) -> Result<(), Error> {
        if frame.depths || frame.shading.edl.edl {
            image.depth_median = self.depths_of(cloud, frame, Shown::Median, budget, timeline)?;
        }
        if frame.depths {
            image.depth_mean = self.depths_of(cloud, frame, Shown::Mean, budget, timeline)?;
        }
        Ok(())
    }

    /// One of them for each pixel; `None` for methods whose images don't follow from sorted lists of all fragments.
    fn depths_of(
        &mut self,
        cloud: &mut DeviceCloud,
        frame: &Frame,
        shown: Shown,
        budget: Budget,
        timeline: &mut Timeline,
    ) -> Result<Option<Vec<f32>>, Error> {
        let Some(engine) = ListEngine::showing(&frame.method, shown) else { return Ok(None) };
        if !matches!(frame.method, Method::ABuffer(_) | Method::LinkedList(_)) {
            // The budget is for the buffers of lists as it was for those of the image.
            self.buffers = Buffers::new(&self.device)?;
        }
        let frame = Frame { fragments: false, ..*frame };
        let windows = self.windows(&engine, &frame, budget)?;
        self.target.reserve(&self.device, largest(&windows))?;
        let mut image = blank(None, &engine, &frame);
        let drawing = Drawing { engine: &engine, frame: &frame, windows: &windows, budget, learns: false, sums: None };
        let drawn = self.draw(cloud, &drawing, 0..0, &mut image, timeline);
        self.disown_colors();
        drawn.map(|_| Some(image.depth))
    }

    /// The expected counts of the frame, from projecting and counting alone: nothing is stored, sorted or blended.
    pub fn survey(&mut self, cloud: &mut DeviceCloud, frame: &Frame) -> Result<Facts, Error> {
        frame.check()?;
        let engine = engine_of(&frame.method);
        let engine = engine.as_ref();
        self.place(engine, cloud, frame, true)?;
        self.disown_colors();
        let budget = self.budget(engine, cloud, frame);
        let (budget, _) = edl::divided(budget, frame);
        let windows = engine.windows(frame, budget)?;
        if engine.renders_to_survey() {
            self.target.reserve(&self.device, largest(&windows))?;
        }
        let (light_views, samples) = (light_views(cloud, frame), engine.samples(frame).unwrap_or(0));
        let (points, gaussians) = (cloud.drawn(), cloud.gaussian_count());
        let mut facts = Facts { points, gaussians, light_views, ..Default::default() };
        let (mut windows, mut timeline) = (last_first(&windows), Timeline::new(&self.progress));
        while let Some(window) = windows.pop() {
            let samples = 0..samples;
            let part = Part { engine, frame, window, budget, samples, sums: None, survey: true, learns: false };
            if let Outcome::Overflow = self.window(cloud, &part, &mut timeline, &mut facts)? {
                split(engine, cloud, window, &mut windows)?;
            }
        }
        Ok(facts)
    }

    /// Returns the factors of the cost of a frame of discs, from projecting alone.
    pub fn load(&mut self, cloud: &mut DeviceCloud, frame: &Frame, discs: &Discs) -> Result<Load, Error> {
        frame.check()?;
        let [width, height] = frame.size;
        let (window, how) = ([0, 0, width, height], abuffer::projecting(frame, cloud, discs));
        let stats = project(&self.device, cloud, (frame, window), &how, &mut Timeline::new(&self.progress))?;
        let splats = stats.iter().map(|s| u64::from(s.visible)).sum();
        Ok(Load { splats, area: Stats::area(&stats), pixels: u64::from(width) * u64::from(height) })
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
            // Points that were dealt may only come with the frame.
            let resident = if streamed.is_some() { 0 } else { cloud.bytes().max(cloud.column_bytes()) };
            // A quarter stays free for the system and for other programs.
            (limits.heap_bytes / 4 * 3).saturating_sub(resident).max(64 << 20)
        });
        let bytes = streamed.map_or(bytes, |points| spbr::stream::rest(bytes, cloud, points));
        Budget { bytes, tiles: 0, binding: limits.binding_bytes }
    }
}

/// Refuses more points than an index tells apart: it has 32 bits, and all ones marks none of them.
fn check_dealt(points: u64) -> Result<(), Error> {
    let limit = u64::from(u32::MAX);
    if points > limit { Err(Error::TooManyPoints { points, limit }) } else { Ok(()) }
}

/// A drawing, perhaps repeated with ever more samples.
struct Drawing<'a> {
    engine: &'a dyn Engine,
    frame: &'a Frame,
    windows: &'a [Window],
    budget: Budget,
    /// `true` if its windows learn from earlier frames.
    learns: bool,
    /// Place for sums of samples, which then are not resolved to an image.
    sums: Option<&'a RefCell<SamplePart>>,
}

/// A frame that has begun.
struct Begun {
    /// Submissions that were waited for before.
    waits: u64,
    light_views: u64,
    budget: Budget,
    /// Bytes of the budget for shading.
    shading: u64,
    windows: Vec<Window>,
}

impl Begun {
    fn drawing<'a>(
        &'a self,
        engine: &'a dyn Engine,
        frame: &'a Frame,
        learns: bool,
        sums: Option<&'a RefCell<SamplePart>>,
    ) -> Drawing<'a> {
        Drawing { engine, frame, windows: &self.windows, budget: self.budget, learns, sums }
    }
}

/// A window of a frame.
struct Part<'a> {
    engine: &'a dyn Engine,
    frame: &'a Frame,
    window: Window,
    budget: Budget,
    samples: Range<u32>,
    sums: Option<&'a RefCell<SamplePart>>,
    survey: bool,
    /// `true` if it learns from earlier frames.
    learns: bool,
}

/// Frames that learn from one another: those of a kind mostly have counts of much the same size.
#[derive(Clone, Copy, PartialEq)]
struct Kind {
    method: Method,
    size: [u32; 2],
    region: Option<Window>,
    points: u64,
}

/// Images through the eyes of a light that a frame of a cloud needs.
fn light_views(cloud: &DeviceCloud, frame: &Frame) -> u64 {
    let casting = shadows::casting(frame, cloud).filter(|casting| !cloud.has_cast(casting));
    casting.map_or(0, |casting| shadows::image_count(&casting, cloud))
}

/// True for the window that is the whole image.
fn is_whole(window: Window, frame: &Frame) -> bool {
    window == [0, 0, frame.size[0], frame.size[1]]
}

/// Pixels of the largest window.
fn largest(windows: &[Window]) -> u64 {
    windows.iter().map(|w| bands::pixels(*w)).max().unwrap_or(1)
}

fn last_first(windows: &[Window]) -> Vec<Window> {
    windows.iter().rev().copied().collect()
}

/// Puts the halves of a window that overflowed back on the list.
fn split(engine: &dyn Engine, cloud: &DeviceCloud, window: Window, windows: &mut Vec<Window>) -> Result<(), Error> {
    // Points at the border of two windows come with both.
    let halves = if cloud.supply().is_some() { bands::square_halves(window) } else { engine.halves(window) };
    let [a, b] = halves.ok_or(Error::PixelOverflow { x: window[0], y: window[1] })?;
    windows.extend([b, a]);
    Ok(())
}

/// Copies a window's counts into those of the image.
fn place(frame: &Frame, window: Window, counts: Counts, image: &mut Image) {
    place_values(frame, window, counts.fragments, image.fragments.as_mut());
    place_values(frame, window, counts.layers, image.layers.as_mut());
    place_values(frame, window, counts.stderr, image.stderr.as_mut());
}

fn place_values<T: Copy>(frame: &Frame, window: Window, values: Option<Vec<T>>, image: Option<&mut Vec<T>>) {
    let (Some(values), Some(image)) = (values, image) else { return };
    let width = (window[2] - window[0]) as usize;
    for (row, values) in values.chunks(width).enumerate() {
        let to = (window[1] as usize + row) * frame.size[0] as usize + window[0] as usize;
        image[to..to + width].copy_from_slice(values);
    }
}

/// An image of a frame's size, in the memory of a spare one if that is as large. Its values are arbitrary: the windows cover all
/// of it.
fn blank(spare: Option<Image>, engine: &dyn Engine, frame: &Frame) -> Image {
    let [width, height] = frame.size;
    let pixels = width as usize * height as usize;
    let channels = engine.channels();
    let fragments = (frame.fragments && channels.fragments != Fragments::Never).then(|| vec![0; pixels]);
    let layers = (frame.fragments && channels.layers).then(|| vec![0; pixels]);
    let stderr = (engine.samples(frame).is_some() && frame.wants_spread()).then(|| vec![[0.0; 3]; pixels]);
    let (rgba, depth) = match spare {
        Some(image) if image.has_colors() && (image.width, image.height) == (width, height) => {
            (image.rgba, image.depth)
        }
        _ => (vec![[0.0; 4]; pixels], vec![0.0; pixels]),
    };
    Image { width, height, rgba, depth, depth_median: None, depth_mean: None, fragments, layers, stderr }
}
