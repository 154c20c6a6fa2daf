//! The renderer: from points, camera and method to an image and a profile, window by window.

mod arranged;
mod bytes;
mod filtered;
mod parts;

use std::time::{Duration, Instant};

use crate::progress::Progress;
use rayon::prelude::*;

use bytes::aggregate;
use parts::splatting_bytes;

use super::abuffer::{ABuffer, Lists, Storing};
use super::approximate::{self, Approximations};
use super::bands::{self, Budget, Window};
use super::cost::Load;
use super::image_space::{self, Filterer};
use super::peel::Peeler;
use super::peel_layers::LayerPeeler;
use super::soft::express::SoftDiscs;
use super::soft::{self, Interior, Layer};
use super::sorted::{self, Stop};
use super::spbr::{self, Ensembles, Form, stream};
use super::splat::Opaque;
use super::splats::{Pixels, Splatter};
use super::stochastic::Sampler;
use super::stochastic::hardware::{self, HeldDepths};
use super::{Error, Outcome, abuffer, peel, shadows, splat, stochastic};
use crate::camera::Camera;
use crate::cloud::shadow_texture::Casting;
use crate::gpu::{Device, Kept, Memory, PassTime, Recorder, Slice, Submitted};
use crate::image::{Image, MAX_SIDE};
use crate::passes::bin::{self, Bin, Bins};
use crate::passes::compose::Cut;
use crate::passes::project::{DeviceCloud, Footprint, Part, Projecting, Stats};
use crate::passes::raster::{self, Walker};
use crate::passes::tiles::Tiles;
use crate::points::Points;
use crate::prepare::axes::Axis;
use crate::prepare::ensembles::Dealt;
use crate::scene::{
    ColorSpace, DiscShape, Discs, Hybrid, Interpolated, LongLists, MAX_LAYERS, Method, PeelLayers, Raster,
    ScreenSplats, Shading, Shadows, SplatShape, Stochastic,
};

/// What to render of an uploaded cloud.
#[derive(Debug, Clone, Copy)]
pub struct Frame {
    /// The camera.
    pub camera: Camera,
    /// Width and height in pixels, each 1 to 16384.
    pub size: [u32; 2],
    /// Shading of points with normals.
    pub shading: Shading,
    /// Shadows of the light, of methods that take some ([`Method::takes_shadows`]) where shading has a light that casts them.
    pub shadows: Option<Shadows>,
    /// In which space colors are blended.
    pub color: ColorSpace,
    /// The method.
    pub method: Method,
    /// Device bytes beside cloud and image; `None`: what the device has, less a reserve. A cloud that was dealt and takes more
    /// than that is not kept on the device: what there is of it at a time counts.
    pub memory_budget: Option<u64>,
    /// Whether the image carries the length of each pixel's list, and the layers that were peeled from it.
    pub fragments: bool,
    /// What may be left out where nothing of it would be seen.
    pub stop: Stop,
    /// Seed of stochastic methods.
    pub seed: u64,
    /// Standard error of the whole image (root mean square over pixels and R, G, B) at which stochastic methods may do with
    /// fewer samples than their settings say.
    pub max_error: Option<f32>,
    /// Whether stochastic methods find their standard error even so.
    pub spread: bool,
    /// Draws only so many of L ensembles, at least 1, which stay those that L makes of the points; `None`: all.
    pub ensembles: Option<u32>,
    /// Factors on the uploaded radii and opacities.
    pub factors: Factors,
}

/// Factors on what was uploaded, so that another radius or opacity costs no upload.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Factors {
    /// On all radii, at least 0; on the median radius too, so that the soft methods keep their peak opacity.
    pub radius: f32,
    /// On all opacities, at least 0; the product is at most 1. The soft methods have `softness` instead.
    pub opacity: f32,
}

impl Default for Factors {
    fn default() -> Self {
        Self { radius: 1.0, opacity: 1.0 }
    }
}

impl Frame {
    /// Whether stochastic methods find their standard error.
    fn spread(&self) -> bool {
        self.samples().is_some() && (self.fragments || self.spread || self.max_error.is_some())
    }

    /// Samples of stochastic methods, or ensembles that are drawn.
    fn samples(&self) -> Option<u32> {
        match self.method {
            Method::Stochastic(settings) => Some(settings.samples),
            method => method.ensembles().map(|all| self.ensembles.map_or(all, |few| few.max(1).min(all))),
        }
    }

    fn check(&self) -> Result<(), Error> {
        let [width, height] = self.size;
        let allowed = 1..=MAX_SIDE;
        if allowed.contains(&width) && allowed.contains(&height) {
            Ok(())
        } else {
            Err(Error::ImageSize { width, height })
        }
    }
}

/// What a frame met.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Facts {
    /// Points of the scene.
    pub points: u64,
    /// Splats whose rectangle touches the image (summed over windows; those of solid and of soft points, if a method tells
    /// them apart).
    pub visible: u64,
    /// Splats of more than 1024 pixels, which are visited tile by tile.
    pub large: u64,
    /// Windows whose lists were filled in order of depth, from sorted splats.
    pub ordered: u64,
    /// Pairs of a splat and a tile that it meets, if splats were sorted.
    pub tile_entries: u64,
    /// Counters of the tiles' splats by run in the window with most of them, if splats are sorted.
    pub tile_cells: u64,
    /// Fragments of all lists.
    pub fragments: u64,
    /// Longest list.
    pub max_list: u32,
    /// Longest list as it is sorted: a soft sphere has several fragments there, but counts once in the numbers above.
    pub max_events: u32,
    /// Layers that were peeled, the most of any window.
    pub layers: u32,
    /// Tiles of 16 × 16 pixels of all images that filters had, layer by layer and window by window.
    pub image_tiles: u64,
    /// Those that each filter ran over: background fill, occlusion fill, smoothing, antialiasing; all iterations.
    pub filtered_tiles: [u64; 4],
    /// Samples that a stochastic method took of each pixel.
    pub samples: u32,
    /// Ensembles that were drawn.
    pub ensembles: u32,
    /// Slots dealt to them: points of all clouds, each as often as it is in one.
    pub slots: u64,
    /// How the nearest points of ensembles are found.
    pub form: Option<Form>,
    /// Points of ensembles that are on the device at a time, if they are more than fit.
    pub streamed: Option<u64>,
    /// Bytes of them that went to the device during the frame.
    pub uploaded_bytes: u64,
    /// Whether a pixel's nearest point has to be cleared between ensembles.
    pub renewed: bool,
    /// Whether points of ensembles may cover more pixels than one invocation walks.
    pub listed: bool,
    /// Clouds too thin for their opacity, by their place in the list of clouds, with the thousandths that they reach of it.
    pub thin: Vec<Thin>,
    /// Points that are not soft, of methods that tell; the others are.
    pub solid_points: u64,
    /// Splats of soft points among the visible ones.
    pub soft_visible: u64,
    /// Splats of soft points among the large ones.
    pub soft_large: u64,
    /// Bytes of the fragment buffer.
    pub fragment_bytes: u64,
    /// Bands over all windows; windows with anything in them, if splats are sorted.
    pub bands: u64,
    /// Drawings of opaque splats in three passes: windows of `hqs` and `splats` with anything in them, windows of the soft
    /// methods with solid points, layers of `one-layer` over all windows.
    pub splatted: u64,
    /// Windows of `one-layer` in which a layer of soft points lies over what is opaque.
    pub layered: u64,
    /// Images through the eyes of a light that were made for shadows: 0 without shadows, and where the cloud has them.
    pub light_views: u64,
    /// Windows of the image.
    pub windows: u64,
    /// Largest number of device bytes at any time of the frame, cloud and image included.
    pub peak_device_bytes: u64,
    /// Who visited the pixels: `compute` or `hardware`.
    pub raster: &'static str,
}

/// A cloud that has fewer points on a pixel than its opacity asks for, whatever the number of ensembles.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Thin {
    /// Its place among the clouds.
    pub cloud: u32,
    /// Opacity of its surface in the image, in thousandths.
    pub reached: u32,
}

/// One pass of a frame, all its dispatches together.
#[derive(Debug, Clone, PartialEq)]
pub struct PassProfile {
    /// Name as in `plan`.
    pub name: &'static str,
    /// Device time.
    pub gpu: Duration,
    /// Shader invocations; `None` where nothing counts them.
    pub invocations: Option<u64>,
    /// Bytes that the pass must read and write at least; `None` where that is not known.
    pub bytes: Option<u64>,
}

/// Times of a frame.
#[derive(Debug, Clone, PartialEq)]
pub struct FrameProfile {
    /// The passes in order of their first run.
    pub passes: Vec<PassProfile>,
    /// Each dispatch in order with its start relative to the frame's, for the trace.
    pub timeline: Vec<(PassTime, Duration)>,
    /// From the first submission to the end of the last one's wait, without the host's work between them.
    pub submitted: Duration,
    /// From the first submission to the end of the last read-back.
    pub wall: Duration,
}

impl FrameProfile {
    /// Device time of all passes.
    pub fn gpu(&self) -> Duration {
        self.passes.iter().map(|p| p.gpu).sum()
    }
}

/// A rendered frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Rendered {
    /// The image.
    pub image: Image,
    /// Its times.
    pub profile: FrameProfile,
    /// What it met.
    pub facts: Facts,
}

/// Collects the submissions of a frame.
#[derive(Debug, Default)]
pub struct Timeline {
    start: Option<Instant>,
    passes: Vec<(PassTime, Duration)>,
    submitted: Duration,
}

impl Timeline {
    /// Adds a finished submission.
    pub fn add(&mut self, submission: Submitted) {
        self.start.get_or_insert_with(|| Instant::now() - submission.wall);
        let mut start = self.submitted;
        for pass in submission.passes {
            let gpu = pass.gpu;
            self.passes.push((pass, start));
            start += gpu;
        }
        self.submitted += submission.wall;
    }
}

/// Where a window's pixels come out.
pub struct Target {
    image: Kept<[f32; 4]>,
    depths: Kept<f32>,
    image_host: Kept<[f32; 4]>,
    depths_host: Kept<f32>,
}

impl Target {
    fn new() -> Self {
        Self {
            image: Kept::new("image", Memory::Device),
            depths: Kept::new("depths", Memory::Device),
            image_host: Kept::new("image, host", Memory::Readback),
            depths_host: Kept::new("depths, host", Memory::Readback),
        }
    }

    fn reserve(&mut self, device: &Device, pixels: u64) -> Result<(), Error> {
        self.image.reserve(device, pixels)?;
        self.depths.reserve(device, pixels)?;
        self.image_host.reserve(device, pixels)?;
        self.depths_host.reserve(device, pixels)?;
        Ok(())
    }

    /// Premultiplied color and A of the window's pixels.
    pub fn image(&self) -> Slice<'_, [f32; 4]> {
        self.image.get().all()
    }

    /// Their depths.
    pub fn depths(&self) -> Slice<'_, f32> {
        self.depths.get().all()
    }

    /// Both.
    pub fn pixels(&self) -> Pixels<'_> {
        Pixels { image: self.image(), depths: self.depths() }
    }

    /// Records the copy to the host.
    pub fn record_read_back<'a>(&'a self, recorder: &mut Recorder<'a>, pixels: u64) -> Result<(), Error> {
        recorder.copy("image/read-back", self.image.get().slice(0, pixels), self.image_host.get().slice(0, pixels))?;
        recorder.copy(
            "image/read-back",
            self.depths.get().slice(0, pixels),
            self.depths_host.get().slice(0, pixels),
        )?;
        Ok(())
    }

    /// Copies the window's rows into the image.
    fn deliver(&self, window: Window, image: &mut Image) {
        let [x0, y0, x1, y1] = window.map(|v| v as usize);
        let (width, pitch) = (x1 - x0, image.width as usize);
        // On all cores: the image is memory that nobody has touched yet, and the kernel clears every page of it first.
        let rgba = image.rgba[y0 * pitch..y1 * pitch].par_chunks_mut(pitch);
        let from = self.image_host.get().mapped_slice().par_chunks(width);
        rgba.zip(from).for_each(|(row, from)| row[x0..x1].copy_from_slice(from));
        let depth = image.depth[y0 * pitch..y1 * pitch].par_chunks_mut(pitch);
        let from = self.depths_host.get().mapped_slice().par_chunks(width);
        depth.zip(from).for_each(|(row, from)| row[x0..x1].copy_from_slice(from));
    }
}

/// Renders frames on one device; keeps buffers from frame to frame.
pub struct Renderer {
    device: Device,
    abuffer: ABuffer,
    bins: Bins,
    approximations: Approximations,
    opaque: Opaque,
    splatter: Splatter,
    peeler: Peeler,
    filterer: Filterer,
    layer_peeler: LayerPeeler,
    sampler: Sampler,
    ensembles: Ensembles,
    /// Ensembles of a round of frames that stop at an error, if fewer than the method's.
    drawn: Option<u32>,
    tiles: Tiles,
    target: Target,
    /// The solid points of a window that has soft ones.
    layer: Layer,
    discs: SoftDiscs,
    /// Whether the soft points of the last window were counted.
    soft_counted: bool,
    /// An image that was given back.
    spare: Option<Image>,
    /// Counts finished pixels of a frame; hidden unless the caller puts its own here.
    pub progress: Progress,
    /// Whether opaque splats and layers use 64-bit atomics; follows the device unless a test switches it off.
    pub wide_atomics: bool,
    /// Whether ensembles are drawn in one go where that can be; a test may switch it off.
    pub single_pass: bool,
    /// Most bits of a key for epochs of ensembles; 31 unless a test sets fewer.
    pub epoch_bits: u32,
    /// Layers after which `peel` gives up; [`MAX_LAYERS`] unless a test sets fewer.
    pub max_layers: u32,
}

impl Renderer {
    /// A renderer on a device.
    pub fn new(device: &Device) -> Result<Self, Error> {
        Ok(Self {
            device: device.clone(),
            abuffer: ABuffer::new(device)?,
            bins: Bins::new(device)?,
            approximations: Approximations::default(),
            opaque: Opaque::default(),
            splatter: Splatter::default(),
            peeler: Peeler::new(device)?,
            filterer: Filterer::new(device)?,
            layer_peeler: LayerPeeler::new(device)?,
            sampler: Sampler::new(),
            ensembles: Ensembles::default(),
            drawn: None,
            tiles: Tiles::new(device)?,
            target: Target::new(),
            layer: Layer::default(),
            discs: SoftDiscs::default(),
            soft_counted: false,
            spare: None,
            progress: Progress::hidden(),
            wide_atomics: device.info().int64_atomics,
            single_pass: true,
            epoch_bits: 31,
            max_layers: MAX_LAYERS,
        })
    }

    /// The device.
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
        // Places of points are 32-bit numbers, and all ones is none of them.
        let (points, limit) = (dealt.points.len() as u64, u64::from(u32::MAX));
        if points > limit {
            return Err(Error::TooManyPoints { points, limit });
        }
        Ok(DeviceCloud::of_dealt(&self.device, dealt)?)
    }

    /// Takes an image back, for the next frame of its size to be put there: memory fresh from the system costs more time
    /// than the pixels that come into it.
    pub fn recycle(&mut self, image: Image) {
        self.spare = Some(image);
    }

    /// Renders a frame.
    pub fn render(&mut self, cloud: &mut DeviceCloud, frame: &Frame) -> Result<Rendered, Error> {
        frame.check()?;
        self.place(cloud, frame)?;
        self.device.reset_peak();
        if let Method::SoftExpress(soft) = frame.method
            && cloud.parts(soft.threshold).soft > 0
        {
            cloud.sort_along(&self.device, Axis::nearest(frame.camera.forward).index)?;
        }
        let mut timeline = Timeline::default();
        let light_views = self.light_views(cloud, frame);
        self.cast_shadows(cloud, frame, &mut timeline)?;
        let budget = self.budget(cloud, frame);
        let windows = initial_windows(frame, budget)?;
        let largest = windows.iter().map(|w| bands::pixels(*w)).max().unwrap_or(1);
        self.target.reserve(&self.device, largest)?;

        let mut image = blank(self.spare.take(), frame);
        let mut facts = match (frame.samples(), frame.max_error) {
            (Some(limit), Some(most)) => {
                let mut samples = limit.min(stochastic::FIRST_SAMPLES);
                loop {
                    let round = self.round(frame, samples);
                    let facts = self.draw(cloud, &round, windows.clone(), budget, &mut image, &mut timeline)?;
                    let errors = image.stderr.as_deref().unwrap_or_default();
                    match stochastic::more_samples(samples, limit, errors, most) {
                        Some(more) => samples = more,
                        None => break facts,
                    }
                }
            }
            _ => {
                self.drawn = frame.ensembles;
                self.draw(cloud, frame, windows, budget, &mut image, &mut timeline)?
            }
        };
        image.stderr = image.stderr.filter(|_| frame.fragments || frame.spread);
        facts.light_views = light_views;
        let wall = timeline.start.map_or(Duration::ZERO, |start| start.elapsed());
        facts.peak_device_bytes = self.device.peak_bytes();
        let submitted = timeline.submitted;
        // Lists of soft spheres are of events, whose numbers are not those of the image.
        let lengths = image.fragments.as_deref().filter(|_| frame.method.discs().is_some()).unwrap_or_default();
        let passes = aggregate(&timeline.passes, &facts, frame, cloud, lengths);
        let profile = FrameProfile { passes, timeline: timeline.passes, submitted, wall };
        Ok(Rendered { image, profile, facts })
    }

    /// A frame that takes so many samples. Ensembles stay those that L makes of the points: fewer of them are drawn.
    fn round(&mut self, frame: &Frame, samples: u32) -> Frame {
        match frame.method {
            Method::Stochastic(settings) => {
                Frame { method: Method::Stochastic(Stochastic { samples, ..settings }), ..*frame }
            }
            _ => {
                self.drawn = Some(samples);
                *frame
            }
        }
    }

    /// Points to the device, unless they go through it bit by bit, and room for splats, unless they are dealt to ensembles.
    fn place(&self, cloud: &mut DeviceCloud, frame: &Frame) -> Result<(), Error> {
        if !frame.method.is_dealt() {
            Cut::new(&self.device, cloud.len())?;
            cloud.make_resident(&self.device)?;
            cloud.make_room(&self.device)?;
        } else if self.streamed(cloud, frame).is_some() {
            cloud.release(&self.device)?;
        } else {
            cloud.make_resident(&self.device)?;
        }
        Ok(())
    }

    /// Points of ensembles that are on the device at a time, if not all.
    fn streamed(&self, cloud: &DeviceCloud, frame: &Frame) -> Option<u64> {
        let dealt = frame.method.is_dealt();
        dealt.then(|| stream::window_points(&self.device, cloud, frame.memory_budget)).flatten()
    }

    /// Images through the eyes of a light that a frame of a cloud needs.
    fn light_views(&self, cloud: &DeviceCloud, frame: &Frame) -> u64 {
        let casting = shadows::casting(frame, cloud).filter(|casting| cloud.casting() != Some(casting));
        casting.map_or(0, |casting| shadows::image_count(&casting, cloud))
    }

    /// Finds the light of each point for the shadows of a frame, unless it has none or the cloud has them already. Whatever the
    /// camera and the method, they stay those of the cloud until other ones are cast.
    fn cast_shadows(&self, cloud: &mut DeviceCloud, frame: &Frame, timeline: &mut Timeline) -> Result<(), Error> {
        let Some(casting) = shadows::casting(frame, cloud).filter(|casting| cloud.casting() != Some(casting)) else {
            return Ok(());
        };
        let how = projecting_of(frame, cloud, Footprint::Point, UNCLAMPED, Part::All);
        let budget = self.budget(cloud, frame).bytes;
        shadows::cast(&self.device, cloud, (&casting, &how), budget, &self.progress, timeline)
    }

    /// Finds the shadow texture that frames like this one take, without rendering any; the cloud then has it
    /// ([`DeviceCloud::lit`]). What it belongs to, or `None` if such frames have no shadows.
    ///
    /// # Errors
    /// Those of [`Renderer::render`].
    pub fn cast(&mut self, cloud: &mut DeviceCloud, frame: &Frame) -> Result<Option<Casting>, Error> {
        self.place(cloud, frame)?;
        self.cast_shadows(cloud, frame, &mut Timeline::default())?;
        Ok(shadows::casting(frame, cloud))
    }

    /// Renders windows, of which the last one comes first, into an image.
    fn draw(
        &mut self,
        cloud: &mut DeviceCloud,
        frame: &Frame,
        mut windows: Vec<Window>,
        budget: Budget,
        image: &mut Image,
        timeline: &mut Timeline,
    ) -> Result<Facts, Error> {
        self.progress.set_length(u64::from(frame.size[0]) * u64::from(frame.size[1]));
        self.progress.set_position(0);
        let mut facts = Facts { points: cloud.len(), ..Default::default() };
        while let Some(window) = windows.pop() {
            let mut work = Work { window, budget, timeline, facts: &mut facts, survey: false };
            match self.work(cloud, frame, &mut work)? {
                Outcome::Done => {
                    self.target.deliver(window, image);
                    self.deliver_counts(frame, window, image)?;
                }
                Outcome::Overflow => split(frame, window, &mut windows)?,
            }
        }
        Ok(facts)
    }

    /// The lists of a frame that fits in one window and band, before sorting: for tests and inspection.
    pub fn lists(&mut self, cloud: &mut DeviceCloud, frame: &Frame, discs: Discs) -> Result<Lists, Error> {
        frame.check()?;
        let window = [0, 0, frame.size[0], frame.size[1]];
        let stats = self.project(cloud, frame, window, &mut Timeline::default())?;
        let walker = self.walker(discs.raster, window)?;
        self.tiles.reserve(&self.device, &stats, window)?;
        let footprint = projecting(frame, cloud).footprint;
        let raster = raster::Raster { cloud, stats: &stats, tiles: &self.tiles, walker, footprint, window };
        let budget = self.budget(cloud, frame);
        let storing = if let Method::LinkedList(_) = frame.method { Storing::Links } else { Storing::Slots };
        let stop = sorted::stop(Stop::Exact, frame.color, 1.0);
        self.abuffer
            .lists(&self.device, &abuffer::WindowJob { raster, discs, storing, stop, budget, progress: &self.progress })
    }

    /// What the frame would meet, from projecting and counting alone: nothing is stored, sorted or blended.
    pub fn survey(&mut self, cloud: &mut DeviceCloud, frame: &Frame) -> Result<Facts, Error> {
        frame.check()?;
        if !frame.method.is_dealt() {
            self.place(cloud, frame)?;
        }
        self.drawn = frame.ensembles;
        let budget = self.budget(cloud, frame);
        let mut windows = initial_windows(frame, budget)?;
        let light_views = self.light_views(cloud, frame);
        let mut facts = Facts { points: cloud.len(), light_views, ..Default::default() };
        while let Some(window) = windows.pop() {
            let mut work = Work { window, budget, timeline: &mut Timeline::default(), facts: &mut facts, survey: true };
            if let Outcome::Overflow = self.work(cloud, frame, &mut work)? {
                split(frame, window, &mut windows)?;
            }
        }
        Ok(facts)
    }

    /// What the cost of a frame of discs depends on, from projecting alone.
    pub fn load(&mut self, cloud: &mut DeviceCloud, frame: &Frame) -> Result<Load, Error> {
        frame.check()?;
        let [width, height] = frame.size;
        let stats = self.project(cloud, frame, [0, 0, width, height], &mut Timeline::default())?;
        let splats = stats.iter().map(|s| u64::from(s.visible)).sum();
        Ok(Load { splats, area: Stats::area(&stats), pixels: u64::from(width) * u64::from(height) })
    }

    /// Whether the budget and a binding allow to sort all of a cloud's splats.
    pub fn can_sort(&self, cloud: &DeviceCloud, frame: &Frame) -> bool {
        let needed = Bins::most_bytes(&self.device, cloud);
        cloud.len() * 16 <= self.device.limits().binding_bytes && needed <= self.budget(cloud, frame).left(0)
    }

    /// Renders a window, or only counts it.
    fn work(&mut self, cloud: &mut DeviceCloud, frame: &Frame, work: &mut Work<'_>) -> Result<Outcome, Error> {
        let window = work.window;
        if matches!(frame.method, Method::Points) && !work.survey {
            return self.points(cloud, frame, work);
        }
        match frame.method {
            Method::Hqs(settings) | Method::Splats(settings) => return self.splats(cloud, frame, settings, work),
            Method::OneLayer(settings) => return self.one_layer(cloud, frame, settings, work),
            Method::ImageSpace(filters) => return self.filtered(cloud, frame, filters, work),
            Method::PeelLayers(peel) => return self.layered(cloud, frame, peel, work),
            Method::Spbr(_) | Method::SpbrSimplified(_) => return self.dealt(cloud, frame, work),
            _ => {}
        }
        if let Some(soft) = frame.method.soft() {
            return self.soft(cloud, frame, *soft, work);
        }
        let stats = self.project(cloud, frame, window, work.timeline)?;
        // What goes through tiles needs no lists: those are counted only where their lengths are asked for.
        let tiled = frame.method.is_tiled();
        let listed = frame.fragments || !tiled;
        let asked = if tiled { Raster::Auto } else { frame.method.raster() };
        let walker = match frame.method {
            Method::Stochastic(settings) => self.sampling_walker(settings.discs.raster, window)?,
            _ => self.walker(asked, window)?,
        };
        let tile_bytes = if listed && walker == Walker::Compute { Tiles::bytes(&stats, window) } else { 0 };
        let countable = stats.iter().all(|s| u32::try_from(s.tiles()).is_ok());
        let Some(budget) = work.budget.with_tiles(tile_bytes).filter(|_| countable) else {
            return Ok(Outcome::Overflow);
        };
        self.tiles.reserve(&self.device, if tile_bytes > 0 { &stats } else { &[] }, window)?;
        let footprint = projecting(frame, cloud).footprint;
        let projected = Projected { cloud, stats: &stats, walker, footprint, window };
        let outcome = match frame.method {
            Method::ABuffer(discs) | Method::LinkedList(discs) => {
                self.lists_of(frame, &projected, discs, budget, work)?
            }
            Method::Sorted(discs)
            | Method::Stochastic(Stochastic { discs, .. })
            | Method::Hybrid(Hybrid { discs, .. })
            | Method::Weighted(discs)
            | Method::Average(discs)
            | Method::Unsorted(discs) => self.tiles_of(frame, &projected, discs, budget, work)?,
            Method::Peel(peel) => {
                let raster = projected.raster(&self.tiles);
                let (counted, wide, limit) = (frame.fragments, self.wide_atomics, self.max_layers);
                let job = peel::WindowJob { raster, peel, counted, wide, limit, progress: &self.progress };
                if work.survey {
                    self.peeler.survey(&self.device, &job, work.timeline, work.facts)?;
                } else {
                    self.peeler.render(&self.device, &job, &self.target, work.timeline, work.facts)?;
                }
                Outcome::Done
            }
            Method::SoftBase(_) | Method::SoftConcentric(_) | Method::SoftExpress(_) => unreachable!("see Self::soft"),
            Method::Hqs(_) | Method::Splats(_) | Method::OneLayer(_) => unreachable!("rendered in three passes"),
            Method::Spbr(_) | Method::SpbrSimplified(_) => unreachable!("rendered by ensembles"),
            Method::ImageSpace(_) | Method::PeelLayers(_) => unreachable!("rendered in layers"),
            Method::Points
            | Method::Squares(_)
            | Method::Circles(_)
            | Method::Paraboloid(_)
            | Method::Cone(_)
            | Method::Sphere(_) => {
                if !work.survey {
                    let raster = projected.raster(&self.tiles);
                    let (wide, relief) = (self.wide_atomics, frame.method.relief());
                    self.opaque.render(&self.device, &raster, wide, relief, &self.target, work.timeline)?;
                    self.progress.inc(bands::pixels(window));
                }
                Outcome::Done
            }
        };
        if let Outcome::Done = outcome {
            work.facts.note(&stats, walker);
        }
        Ok(outcome)
    }

    /// A window by lists of fragments.
    fn lists_of(
        &mut self,
        frame: &Frame,
        projected: &Projected<'_>,
        discs: Discs,
        budget: Budget,
        work: &mut Work<'_>,
    ) -> Result<Outcome, Error> {
        let (device, raster) = (&self.device, projected.raster(&self.tiles));
        let most_color = raster.cloud.most_color(&projecting(frame, raster.cloud));
        let stop = sorted::stop(frame.stop, frame.color, most_color);
        let storing = if let Method::LinkedList(_) = frame.method { Storing::Links } else { Storing::Slots };
        let mut lists = abuffer::WindowJob { raster, discs, storing, stop, budget, progress: &self.progress };
        let mut ordered = 0;
        let job = bin_job(frame, raster, budget, bands::pixels(raster.window) * abuffer::PIXEL_BYTES);
        if in_order(device, &job, &frame.method)
            && let Bin::Done(binned) = self.bins.bin(device, &job, work.timeline, work.facts)?
        {
            lists.storing = Storing::Ordered(self.bins.tiles(binned));
            lists.budget.tiles += self.bins.bytes();
            ordered = 1;
        }
        let outcome = if work.survey {
            self.abuffer.survey(device, &lists, work.timeline, work.facts)?
        } else {
            self.abuffer.render(device, &lists, &self.target, work.timeline, work.facts)?
        };
        if outcome == Outcome::Done {
            work.facts.ordered += ordered;
        }
        Ok(outcome)
    }

    /// A window by tiles of splats; the lengths of lists are counted only where they are asked for.
    fn tiles_of(
        &mut self,
        frame: &Frame,
        projected: &Projected<'_>,
        discs: Discs,
        budget: Budget,
        work: &mut Work<'_>,
    ) -> Result<Outcome, Error> {
        let (device, raster) = (&self.device, projected.raster(&self.tiles));
        // A window may turn out to be too large after its lists were counted; its halves are counted again.
        let mut facts = work.facts.clone();
        let most_color = raster.cloud.most_color(&projecting(frame, raster.cloud));
        let mut counted_bytes = 0;
        if frame.fragments {
            let stop = sorted::stop(frame.stop, frame.color, most_color);
            let progress = &self.progress;
            let lists = abuffer::WindowJob { raster, discs, storing: Storing::Slots, stop, budget, progress };
            if self.abuffer.tally(device, &lists, work.timeline, &mut facts)? == Outcome::Overflow {
                return Ok(Outcome::Overflow);
            }
            counted_bytes = bands::pixels(raster.window) * abuffer::PIXEL_BYTES;
        }
        if let Method::Stochastic(settings) = frame.method {
            counted_bytes += bands::pixels(raster.window) * stochastic::pixel_bytes(frame.spread());
            facts.samples = settings.samples;
        }
        let bin = bin_job(frame, raster, budget, counted_bytes);
        let drawn = matches!(frame.method, Method::Stochastic(_)) && raster.walker == Walker::Hardware;
        let outcome = if work.survey && drawn {
            facts.bands += u64::from(hardware::is_seen(&raster));
            Outcome::Done
        } else if work.survey {
            Bins::survey(device, &bin, &mut facts)?
        } else {
            let (bins, target, timeline) = (&mut self.bins, &self.target, &mut *work.timeline);
            match frame.method {
                Method::Sorted(_) => {
                    let job = sorted::WindowJob { bin, discs, color: frame.color, most_color, stop: frame.stop };
                    sorted::render(bins, device, &job, target, timeline, &mut facts)?
                }
                Method::Stochastic(settings) => {
                    let (seed, spread, progress) = (frame.seed, frame.spread(), &self.progress);
                    let job = stochastic::WindowJob { bin, settings, seed, spread, progress };
                    if drawn {
                        let depths = HeldDepths::new(&frame.camera, raster.footprint);
                        self.sampler.draw(device, &job, depths, target, timeline, &mut facts)?;
                        Outcome::Done
                    } else {
                        self.sampler.render(bins, device, &job, target, timeline, &mut facts)?
                    }
                }
                method => {
                    let kind = approximate::Kind::of(&method).expect("a method that goes through tiles");
                    let job = approximate::WindowJob { bin, discs, kind };
                    self.approximations.render(bins, device, &job, target, timeline, &mut facts)?
                }
            }
        };
        if outcome == Outcome::Done {
            *work.facts = facts;
            self.progress.inc(bands::pixels(raster.window));
        }
        Ok(outcome)
    }

    /// Renders a window of 1-pixel points, which need no splats.
    fn points(&mut self, cloud: &mut DeviceCloud, frame: &Frame, work: &mut Work<'_>) -> Result<Outcome, Error> {
        let (window, how) = (work.window, projecting(frame, cloud));
        cloud.set_view(&frame.camera, frame.size, window, &how);
        let (device, wide) = (&self.device, self.wide_atomics);
        let stats = self.opaque.render_points(device, cloud, (window, &how), wide, &self.target, work.timeline)?;
        self.progress.inc(bands::pixels(window));
        work.facts.note(&stats, Walker::Compute);
        Ok(Outcome::Done)
    }

    fn project(
        &self,
        cloud: &mut DeviceCloud,
        frame: &Frame,
        window: Window,
        timeline: &mut Timeline,
    ) -> Result<Vec<Stats>, Error> {
        self.project_as(cloud, frame, window, &projecting(frame, cloud), timeline)
    }

    fn project_as(
        &self,
        cloud: &mut DeviceCloud,
        frame: &Frame,
        window: Window,
        how: &Projecting,
        timeline: &mut Timeline,
    ) -> Result<Vec<Stats>, Error> {
        cloud.reserve_tilts(&self.device, how.footprint)?;
        cloud.set_view(&frame.camera, frame.size, window, how);
        let mut recorder = self.device.recorder()?;
        cloud.record_project(&mut recorder, how)?;
        timeline.add(recorder.submit("splat/project")?);
        Ok(cloud.stats())
    }

    fn walker(&self, raster: Raster, window: Window) -> Result<Walker, Error> {
        let info = self.device.info();
        let [width, height] = self.device.limits().framebuffer;
        let fits = window[2] - window[0] <= width && window[3] - window[1] <= height;
        let refused = |needed: String| Err(Error::NoHardwareRaster { device: info.name.clone(), needed });
        match raster {
            Raster::Hardware if !info.fragment_atomics => refused("fragmentStoresAndAtomics".to_owned()),
            Raster::Hardware if !fits => refused(format!("a framebuffer larger than {width} × {height}")),
            Raster::Hardware => Ok(Walker::Hardware),
            // For every size of splat compute was the faster way on the devices measured (README, benches/frame.rs).
            Raster::Compute | Raster::Auto => Ok(Walker::Compute),
        }
    }

    /// Who takes the samples of stochastic transparency.
    fn sampling_walker(&self, raster: Raster, window: Window) -> Result<Walker, Error> {
        let info = self.device.info();
        match raster {
            Raster::Hardware => {}
            // Compute was the faster way wherever both were measured (README), but for devices without shuffles.
            Raster::Auto if info.subgroup.is_none() && info.multisampled.is_some() => {}
            Raster::Auto | Raster::Compute => return self.walker(Raster::Compute, window),
        }
        let [width, height] = [window[2] - window[0], window[3] - window[1]];
        match info.multisampled {
            Some([w, h]) if width <= w && height <= h => self.walker(Raster::Hardware, window),
            _ => {
                let needed = "attachments with 4 samples per pixel, and blending of floats".to_owned();
                Err(Error::NoHardwareRaster { device: info.name.clone(), needed })
            }
        }
    }

    fn budget(&self, cloud: &DeviceCloud, frame: &Frame) -> Budget {
        let limits = self.device.limits();
        let streamed = self.streamed(cloud, frame);
        let bytes = frame.memory_budget.unwrap_or_else(|| {
            // Points that were dealt may only come with the frame.
            let resident = if streamed.is_some() { 0 } else { cloud.bytes().max(cloud.column_bytes()) };
            // A quarter stays free for the system and for other programs.
            (limits.heap_bytes / 4 * 3).saturating_sub(resident).max(64 << 20)
        });
        let bytes = streamed.map_or(bytes, |points| stream::rest(bytes, cloud, points));
        Budget { bytes, tiles: 0, binding: limits.binding_bytes }
    }

    fn deliver_counts(&self, frame: &Frame, window: Window, image: &mut Image) -> Result<(), Error> {
        if let Some(stderr) = &mut image.stderr {
            let dealt = frame.method.is_dealt();
            let errors = if dealt { self.ensembles.read_stderr(window)? } else { self.sampler.read_stderr(window)? };
            place_counts(frame, window, &errors, stderr);
        }
        if let (Some(fragments), Some(layers)) = (&mut image.fragments, &mut image.layers) {
            let [lengths, peeled] = self.peeler.read_counts(window)?;
            place_counts(frame, window, &lengths, fragments);
            place_counts(frame, window, &peeled, layers);
        } else if let Some(layers) = &mut image.layers {
            place_counts(frame, window, &self.layer_peeler.read_layers(window)?, layers);
        } else if let (Some(fragments), Some(_)) = (&mut image.fragments, frame.method.soft()) {
            match Interior::of(&frame.method).filter(|_| self.soft_counted) {
                Some(interior) => {
                    place_counts(frame, window, &self.abuffer.read_spheres(window, interior)?, fragments);
                }
                None if self.soft_counted => place_counts(frame, window, self.discs.counts(), fragments),
                None => {}
            }
        } else if let Some(fragments) = &mut image.fragments {
            place_counts(frame, window, &self.abuffer.read_counts(window)?, fragments);
        }
        Ok(())
    }
}

/// Whether an A-buffer is filled tile by tile from sorted splats: only flat discs come in the order of blending then, and
/// it pays where splats are large enough.
fn in_order(device: &Device, job: &bin::Job<'_>, method: &Method) -> bool {
    let Method::ABuffer(discs) = method else { return false };
    let visible: u64 = job.raster.stats.iter().map(|s| u64::from(s.visible)).sum();
    discs.shape == DiscShape::Flat
        && discs.long_lists == LongLists::Merge
        && job.raster.walker == Walker::Compute
        && device.info().subgroup.is_some()
        && Stats::area(job.raster.stats) >= visible.max(1) * ORDERED_AREA
        && Bins::least_bytes(device, job) <= job.budget.left(0) / 4
}

/// The binning of a window's splats, in the order that the method asks for.
fn bin_job<'a>(frame: &Frame, raster: raster::Raster<'a>, budget: Budget, counted_bytes: u64) -> bin::Job<'a> {
    bin::Job { raster, order: frame.method.order(), depth_range: depth_range(frame), budget, counted_bytes }
}

/// Pixels of a splat's rectangle, on average, from which on an A-buffer is filled tile by tile (measured on lavapipe).
pub(super) const ORDERED_AREA: u64 = 32;

/// Copies one value for each of the window's pixels into those of the image.
fn place_counts<T: Copy>(frame: &Frame, window: Window, counts: &[T], image: &mut [T]) {
    let width = (window[2] - window[0]) as usize;
    for (row, counts) in counts.chunks(width).enumerate() {
        let to = (window[1] as usize + row) * frame.size[0] as usize + window[0] as usize;
        image[to..to + width].copy_from_slice(counts);
    }
}

/// The windows of a frame, the first one last.
fn initial_windows(frame: &Frame, budget: Budget) -> Result<Vec<Window>, Error> {
    let listed = if frame.fragments { abuffer::PIXEL_BYTES } else { 0 };
    let pixel_bytes = match frame.method {
        Method::Stochastic(_) => {
            let bytes = listed + bin::PIXEL_BYTES + stochastic::pixel_bytes(frame.spread());
            let most = stochastic::window_pixels(budget, bytes, frame.spread());
            return Ok(last_first(bands::windows(frame.size, most)));
        }
        method if method.is_dealt() => {
            return Ok(last_first(bands::windows(frame.size, spbr::window_pixels(budget, frame.spread()))));
        }
        Method::ImageSpace(filters) | Method::PeelLayers(PeelLayers { filters, .. }) => {
            return Ok(last_first(image_space::frame_windows(frame, &filters, budget)?));
        }
        Method::ABuffer(_) | Method::LinkedList(_) => abuffer::PIXEL_BYTES,
        Method::Peel(_) => peel::pixel_bytes(frame.fragments),
        method if method.soft().is_some() => {
            let own = Interior::of(&method).map_or(soft::LAYER_BYTES, |interior| soft::pixel_bytes(interior, true));
            abuffer::PIXEL_BYTES.max(bin::PIXEL_BYTES) + own
        }
        method if splatting_bytes(&method) > 0 => bin::PIXEL_BYTES + splatting_bytes(&method),
        method if method.is_tiled() => {
            let counted = if frame.fragments { abuffer::PIXEL_BYTES } else { bin::PIXEL_BYTES };
            counted + approximate::pixel_bytes(&method)
        }
        _ => splat::PIXEL_BYTES,
    };
    let capacity = budget.window_pixels(pixel_bytes);
    if let Method::Sorted(_) = frame.method {
        // Splats of a tile are composed in runs of 2048: another tile would group them in another way.
        return Ok(last_first(bands::tile_windows(frame.size, capacity)));
    }
    Ok(last_first(bands::windows(frame.size, capacity)))
}

fn last_first(mut windows: Vec<Window>) -> Vec<Window> {
    windows.reverse();
    windows
}

/// Puts the halves of a window that overflowed back on the list.
fn split(frame: &Frame, window: Window, windows: &mut Vec<Window>) -> Result<(), Error> {
    let halves = if matches!(frame.method, Method::Sorted(_)) { bands::tile_halves } else { bands::halves };
    let [a, b] = halves(window).ok_or(Error::PixelOverflow { x: window[0], y: window[1] })?;
    windows.extend([b, a]);
    Ok(())
}

impl Facts {
    /// Adds a finished window.
    fn note(&mut self, stats: &[Stats], walker: Walker) {
        self.windows += 1;
        self.raster = match walker {
            Walker::Compute => "compute",
            Walker::Hardware => "hardware",
        };
        self.meet(stats);
    }

    /// Adds what was projected.
    fn meet(&mut self, stats: &[Stats]) {
        for s in stats {
            self.visible += u64::from(s.visible);
            self.large += u64::from(s.large);
        }
    }
}

/// A window whose splats are projected.
struct Projected<'a> {
    cloud: &'a DeviceCloud,
    stats: &'a [Stats],
    walker: Walker,
    footprint: Footprint,
    window: Window,
}

impl Projected<'_> {
    /// For passes that visit pixels; `tiles` are those of its large splats.
    fn raster<'a>(&'a self, tiles: &'a Tiles) -> raster::Raster<'a> {
        let Self { cloud, stats, walker, footprint, window } = *self;
        raster::Raster { cloud, stats, tiles, walker, footprint, window }
    }
}

/// A window in work.
struct Work<'a> {
    window: Window,
    budget: Budget,
    timeline: &'a mut Timeline,
    facts: &'a mut Facts,
    /// Whether counting is enough.
    survey: bool,
}

/// An image of a frame's size, in the memory of a spare one if that is as large. Whatever it holds: the windows cover all of it.
fn blank(spare: Option<Image>, frame: &Frame) -> Image {
    let [width, height] = frame.size;
    let pixels = width as usize * height as usize;
    let listed = frame.method.discs().is_some() || frame.method.soft().is_some();
    let fragments = (frame.fragments && listed).then(|| vec![0; pixels]);
    let layers =
        (frame.fragments && matches!(frame.method, Method::Peel(_) | Method::PeelLayers(_))).then(|| vec![0; pixels]);
    let stderr = frame.spread().then(|| vec![[0.0; 3]; pixels]);
    match spare {
        Some(image) if (image.width, image.height) == (width, height) => Image { fragments, layers, stderr, ..image },
        _ => Image { width, height, rgba: vec![[0.0; 4]; pixels], depth: vec![0.0; pixels], fragments, layers, stderr },
    }
}

/// Near and far, as the device compares depths with them.
pub fn depth_range(frame: &Frame) -> [f32; 2] {
    [frame.camera.near as f32, frame.camera.far as f32]
}

/// How a method's splats are made.
fn projecting(frame: &Frame, cloud: &DeviceCloud) -> Projecting {
    let (footprint, settings) = match (frame.method, frame.method.discs()) {
        (_, Some(discs)) => (abuffer::footprint(discs.shape), UNCLAMPED),
        (Method::Squares(splats), _) => (Footprint::Square, splats),
        (Method::Circles(splats) | Method::Sphere(splats), _) => (Footprint::Disc, splats),
        (Method::Paraboloid(Interpolated { splats, shape }) | Method::Cone(Interpolated { splats, shape }), _) => {
            (outlined(shape), splats)
        }
        (Method::Hqs(blended), _) => (outlined(blended.shape), blended.splats),
        (Method::Splats(blended), _) => (Footprint::Oriented, blended.splats),
        _ => (Footprint::Point, UNCLAMPED),
    };
    projecting_of(frame, cloud, footprint, settings, Part::All)
}

fn outlined(shape: SplatShape) -> Footprint {
    match shape {
        SplatShape::Circle => Footprint::Disc,
        SplatShape::Square => Footprint::Square,
    }
}

fn projecting_of(
    frame: &Frame,
    cloud: &DeviceCloud,
    footprint: Footprint,
    settings: ScreenSplats,
    part: Part,
) -> Projecting {
    // Without normals there are no tilts either, and every disc is flat.
    let footprint = if footprint == Footprint::Oriented && !cloud.has_normals() { Footprint::Disc } else { footprint };
    Projecting {
        footprint,
        radius_factor: settings.size * frame.factors.radius,
        max_radius_px: settings.max_pixel_radius,
        opacity_factor: frame.factors.opacity,
        part,
        relative_depth: Interior::of(&frame.method).is_some(),
        shading: frame.shading,
        color: frame.color,
        lit: cloud.casting().is_some() && cloud.casting() == shadows::casting(frame, cloud).as_ref(),
    }
}

/// Radii as they are.
const UNCLAMPED: ScreenSplats = ScreenSplats { size: 1.0, max_pixel_radius: f32::MAX, raster: Raster::Auto };
