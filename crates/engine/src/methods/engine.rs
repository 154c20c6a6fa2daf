//! The engine of a method, as the renderer sees it, and the tools an engine works with.

use std::cell::{Cell, RefCell};
use std::ops::Range;

use crate::progress::Progress;

use super::explain::Explain;
use super::parts::{Plane, SamplePart, Sums};
use super::projected::{Projected, project};
use super::several::Several;
use super::{Buffers, Error, Facts, Frame, Outcome, Target, Timeline};
use crate::gpu::{Device, DeviceInfo};
use crate::passes::bands::{self, Budget, Window};
use crate::passes::bin::{self, Binned};
use crate::passes::compose::Cut;
use crate::passes::project::{DeviceCloud, PointExtent, Projecting, Stats};
use crate::passes::raster::Walker;
use crate::passes::tiles::Tiles;
use crate::scene::MAX_LAYERS;

/// A family of methods with the settings of one of them: how its frames are cut into windows, rendered and counted.
/// Buffers that outlive a frame are in [`Buffers`].
pub(crate) trait Engine: Explain {
    /// Cuts a frame into windows whose buffers fit the budget, the first one first.
    ///
    /// # Errors
    /// Not even the smallest window fits.
    fn windows(&self, frame: &Frame, budget: Budget) -> Result<Vec<Window>, Error>;

    /// Returns `true` if four images are drawn at once where a frame has that many: if each pixel follows from what
    /// covers its sample alone, without its neighbors and without random numbers.
    fn takes_fours(&self) -> bool {
        true
    }

    /// Cuts a window that turned out to be too large; `None` for a single pixel.
    fn halves(&self, window: Window) -> Option<[Window; 2]> {
        bands::halves(window)
    }

    /// Returns how far beyond its place a point may show in a frame, for clouds whose points come to the device window
    /// by window.
    fn extent(&self, frame: &Frame, cloud: &DeviceCloud) -> PointExtent {
        let discs = PointExtent::discs(frame.factors.radius);
        match frame.method.discs().filter(|_| cloud.has_gaussians()) {
            Some(of) => discs.or(PointExtent::gaussians(&of.gaussians, &frame.camera, frame.size)),
            None => discs,
        }
    }

    /// Returns the number of points that may be on the device at once. Of more than that, those of one window at a time
    /// are.
    fn most_points(&self, device: &Device) -> u64 {
        let all = Cut::most(device);
        if self.sorts(device.info()) { bin::most_points(device).min(all) } else { all }
    }

    /// Returns `true` if frames need their splats sorted.
    fn sorts(&self, device: &DeviceInfo) -> bool {
        self.needs_subgroups(device)
    }

    /// Brings to the device what frames need of a cloud: its points, and room for their splats. A survey may do with
    /// less.
    ///
    /// # Errors
    /// No memory for them, or more of them than the device can address.
    fn place(&self, device: &Device, cloud: &mut DeviceCloud, _frame: &Frame, _survey: bool) -> Result<(), Error> {
        Cut::new(device, cloud.len())?;
        cloud.make_resident(device)?;
        if self.projects() {
            cloud.make_room(device)?;
        }
        Ok(())
    }

    /// `false` for engines that take points as they are, without splats.
    fn projects(&self) -> bool {
        true
    }

    /// Computes the data of a cloud that is computed once, before the first frame that needs it.
    ///
    /// # Errors
    /// No memory for it.
    fn prepare(&self, _device: &Device, _cloud: &mut DeviceCloud, _frame: &Frame) -> Result<(), Error> {
        Ok(())
    }

    /// The number of points on the device at a time, for a cloud that is streamed during the frame.
    fn streamed(&self, _device: &Device, _cloud: &DeviceCloud, _frame: &Frame) -> Option<u64> {
        None
    }

    /// Samples of a pixel or ensembles that the frame asks for; `None` for engines that draw no random ones.
    fn samples(&self, _frame: &Frame) -> Option<u32> {
        None
    }

    /// Returns what the samples of a pixel leave before they are resolved to an image; `None` for engines that draw no
    /// random ones.
    fn sums(&self) -> Option<Sums> {
        None
    }

    /// Resolves a window of sums that were put together, and copies it to the host, as [`Self::render`] does
    /// with its own.
    ///
    /// # Errors
    /// The device failed, or lacks memory.
    fn resolve(
        &self,
        _cloud: &DeviceCloud,
        _buffers: &mut Buffers,
        work: &mut Work<'_>,
        _sums: &SamplePart,
    ) -> Result<(), Error> {
        Err(Error::NoParts { method: work.frame.method.name() })
    }

    /// Returns `true` if no frame can do without subgroups of 8 to 32 invocations on this device, because tiles of
    /// splats need them.
    fn needs_subgroups(&self, _device: &DeviceInfo) -> bool {
        false
    }

    /// Returns `true` if a survey renders into the target, because only rendering yields the frame's counts.
    fn renders_to_survey(&self) -> bool {
        false
    }

    /// Returns the values that the engine can count for each pixel.
    fn channels(&self) -> Channels {
        Channels::NONE
    }

    /// Renders a window into the target and copies it to the host, or only counts it ([`Work::survey`]).
    ///
    /// # Errors
    /// The device lacks a feature or memory, even for the smallest window.
    fn render(&self, cloud: &mut DeviceCloud, buffers: &mut Buffers, work: &mut Work<'_>) -> Result<Outcome, Error>;

    /// Returns counts of the window that was rendered last, where the frame asks for them.
    ///
    /// # Errors
    /// The device failed.
    fn counts(&self, buffers: &Buffers, frame: &Frame, window: Window) -> Result<Counts, Error> {
        match self.channels().fragments {
            Fragments::Never => Ok(Counts::default()),
            Fragments::Beside | Fragments::Within => buffers.resources.lists.counts(frame, window),
        }
    }
}

/// Values that an engine can count for each pixel, in addition to color and depth.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Channels {
    /// Lengths of lists.
    pub fragments: Fragments,
    /// `true` if it counts peeled layers.
    pub layers: bool,
}

/// Source of the lengths of a pixel's lists.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Fragments {
    /// Lengths are not counted.
    Never,
    /// Separate passes count, if a frame asks for it: images don't need the counts.
    Beside,
    /// The passes that render count.
    Within,
}

impl Channels {
    /// No values.
    pub const NONE: Self = Self { fragments: Fragments::Never, layers: false };
    /// Lengths of lists alone, by the passes that render.
    pub const LISTS_WITHIN: Self = Self { fragments: Fragments::Within, layers: false };
    /// Lengths of lists alone, by passes of their own.
    pub const LISTS_BESIDE: Self = Self { fragments: Fragments::Beside, layers: false };
}

/// The values counted for each pixel of a window, in its order; `None` for others.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Counts {
    /// Lengths of lists.
    pub fragments: Option<Vec<u32>>,
    /// Layers that were peeled.
    pub layers: Option<Vec<u32>>,
    /// Standard errors of R, G and B.
    pub stderr: Option<Vec<[f32; 3]>>,
}

/// Features that tests switch off or limit.
#[doc(hidden)]
#[derive(Debug, Clone, Copy)]
pub struct Switches {
    /// `true` if opaque splats and layers use 64-bit atomics.
    pub wide_atomics: bool,
    /// `true` if ensembles are drawn in one go where possible.
    pub single_pass: bool,
    /// `true` if images of a frame with samples are drawn several at a time, where the method can.
    pub together: bool,
    /// The largest number of bits of a key for epochs of ensembles.
    pub epoch_bits: u32,
    /// Layers after which `peel` gives up.
    pub max_layers: u32,
    /// Layers that a walk of `peel` finds at most: 1, 2, 4 or 8.
    pub layers_of_a_walk: u32,
}

impl Switches {
    /// Returns the switches as every frame has them unless a test changes them.
    pub(super) fn of(device: &DeviceInfo) -> Self {
        Self {
            wide_atomics: device.int64_atomics,
            single_pass: true,
            together: true,
            epoch_bits: 31,
            max_layers: MAX_LAYERS,
            layers_of_a_walk: 8,
        }
    }
}

/// A window in work, with everything that all engines need.
pub(crate) struct Work<'a> {
    /// The device.
    pub device: &'a Device,
    /// The frame.
    pub frame: &'a Frame,
    /// The window.
    pub window: Window,
    /// Images whose nearest points were found last in this window, of frames that are drawn image by image; `None` if
    /// there is one image.
    pub several: Option<&'a Cell<Option<Several>>>,
    /// The memory that may be used.
    pub budget: Budget,
    /// Samples or ensembles to draw; none where the engine draws no random ones.
    pub samples: Range<u32>,
    /// Sums of the samples, which then are kept and not resolved.
    pub sums: Option<&'a RefCell<SamplePart>>,
    /// The target of the pixels, large enough for the window.
    pub target: &'a Target,
    /// Times of the submissions.
    pub timeline: &'a mut Timeline,
    /// The frame's counts; only those of finished windows are kept.
    pub facts: &'a mut Facts,
    /// Counts finished pixels.
    pub progress: &'a Progress,
    /// Switches set by tests.
    pub switches: Switches,
    /// `true` if counting is enough.
    pub survey: bool,
    /// Numbers that are added to the counts once the window has been submitted.
    pub later: Vec<Later>,
}

/// Adds to the counts of a frame, from what was found.
pub(crate) type Later = Box<dyn FnOnce(&mut Facts, &Timeline)>;

impl Work<'_> {
    /// Returns the number of pixels of the window.
    pub fn pixels(&self) -> u64 {
        bands::pixels(self.window)
    }

    /// Keeps words of the window's pixels, in its order, if sums are kept.
    pub fn keep(&self, plane: Plane, words: &[u32]) {
        if let Some(sums) = self.sums {
            sums.borrow_mut().place(plane, self.window, words);
        }
    }

    /// Projects a cloud's points to splats of the window. Returns the results by chunk.
    pub fn project(&mut self, cloud: &mut DeviceCloud, how: &Projecting) -> Result<Projected, Error> {
        project(self.device, cloud, (self.frame, self.window), how, self.timeline)
    }

    /// Makes room for the pairs of large splats and tiles, if `needed`; the budget beside them, or `None` if the window
    /// must be cut.
    pub fn reserve_tiles(&self, tiles: &mut Tiles, stats: &[Stats], needed: bool) -> Result<Option<Budget>, Error> {
        let bytes = if needed { Tiles::bytes(stats) } else { 0 };
        let countable = stats.iter().all(|s| u32::try_from(s.tiles()).is_ok());
        let budget = self.budget.with_tiles(bytes).filter(|_| countable);
        if budget.is_some() {
            tiles.reserve(self.device, if bytes > 0 { stats } else { &[] })?;
        }
        Ok(budget)
    }

    /// Adds to the frame's counts once the window was submitted: only then counts are known.
    pub fn note_later(&mut self, note: impl FnOnce(&mut Facts, &Timeline) + 'static) {
        self.later.push(Box::new(note));
    }

    /// Adds a binned window to the frame's counts.
    pub fn note_binned(&mut self, binned: Binned) {
        self.note_later(move |facts, timeline| facts.note_binned(binned.cells(), binned.found_entries(timeline)));
    }

    /// Adds a window to the frame's counts.
    pub fn note(&mut self, projected: &Projected, walker: Walker) {
        let found = projected.found;
        self.note_later(move |facts, timeline| facts.note(&found.stats(timeline), walker));
    }

    /// Copies a finished window to the host.
    pub fn read_back(&mut self) -> Result<(), Error> {
        if !self.survey {
            let mut recorder = self.timeline.recorder(self.device)?;
            self.target.record_read_back(&mut recorder, self.pixels())?;
            self.timeline.submit(recorder, "image/read-back")?;
            self.finish();
        }
        Ok(())
    }

    /// Counts the window's pixels as finished, unless it was only surveyed.
    pub fn finish(&self) {
        if !self.survey {
            self.progress.inc(self.pixels());
        }
    }
}

/// Returns windows for a method that needs `pixel_bytes` per pixel.
pub(crate) fn windows_of(frame: &Frame, budget: Budget, pixel_bytes: u64) -> Vec<Window> {
    bands::windows(frame.size, budget.window_pixels(pixel_bytes))
}
