//! `abuffer`: exact order-independent transparency (MCTB12): count, scan, store, sort and blend.
//!
//! Each pixel's fragments lie together in one buffer of 8 bytes per fragment: depth key and index of the splat. Lists
//! of up to [`LOCAL_LENGTH`] fragments are sorted and blended by one invocation, in registers or in a local array, each
//! class of lengths by its own kernel. Longer ones are sorted in runs of that length, merged pairwise between two
//! buffers, blended run by run and composed, so that no invocation loops longer than a run, however long the list is.
//! Or, if asked for, one invocation sorts each of them in place, which takes half the memory and bounds their length
//! ([`in_place_length`]).
//!
//! Count, scan, bands and sorting serve other families too, which store and blend their own fragments
//! ([`StoreFragments`]): one set of buffers, whichever method a frame takes.

mod blend;
mod capacity;
mod count;
mod explain;
mod passes;
mod samples;
mod storing;

pub use blend::{Blender, Blending, CLASSES, Runs, in_place_length, least_bytes, lower_bound};
pub(crate) use blend::{CONSTANTS, Sorting, composing_variant, occurring};
pub(crate) use explain::list_bytes;
pub(crate) use explain::{
    BY_LENGTH, COUNT, count_group, counted_beside, ellipsoid_group, list_group, list_passes, lists,
};
pub use passes::*;
pub(crate) use samples::{Sampling, Taken};
pub use storing::{
    Bodies, Counting, InOrder, LINK_BYTES, Needs, RECORD_BYTES, Room, RunBuffers, SEGMENT_BYTES, Slots, StoreFragments,
    Storing,
};

use self::blend::Stored;
use self::capacity::Need;
use self::count::{Counted, measure_variant};
use crate::methods::prelude::*;
use crate::passes::bin::Lanes;
use crate::passes::scan::Scan;

/// The longest list that one invocation sorts in a local array; also the length of a run of a longer one.
pub const LOCAL_LENGTH: u32 = 256;
/// Bytes of a fragment: depth key and splat index.
pub const FRAGMENT_BYTES: u64 = 8;
/// Bytes of a fragment of a list that is stored in order: the splat's rank.
pub const INDEX_BYTES: u64 = 4;
/// Bytes per pixel of a window: count, offset, their share of the scan's levels, and place in the work list.
pub const PIXEL_BYTES: u64 = 13;
/// Bytes per pixel of a window whose lists all go in runs: a run of the list with its sums and what it is composed to,
/// and the number of bodies.
pub const RUN_PIXEL_BYTES: u64 = 4 + 12 + 16 + 48 + 32;

/// Returns the footprint of a disc's shape.
pub fn footprint(shape: DiscShape) -> Footprint {
    match shape {
        DiscShape::Flat => Footprint::Disc,
        DiscShape::Oriented => Footprint::Oriented,
    }
}

fields! {
    /// Buffers of the A-buffer, kept from frame to frame.
    pub struct ABuffer by device {
        room: Room = Room::new(device)?,
        told_offsets: Told<u32> = Told::new("fragment offsets, host"),
        scan: Scan = Scan::new(device, 0)?,
        lengths: Buffer<Lengths> = device.buffer("list lengths", 1, Memory::Device)?,
        /// Bodies of each pixel (spheres, ellipsoids, discs), where they are counted in addition to fragments, and
        /// their lengths.
        bodies: Scratch<u32> = Scratch::new("sphere counts", Memory::Device),
        /// `true` if bodies of the last window were counted.
        beside: bool = false,
        told_bodies: Told<u32> = Told::new("sphere counts, host"),
        body_lengths: Buffer<Lengths> = device.buffer("sphere lengths", 1, Memory::Device)?,
        blender: Blender = Blender::new(device)?,
        taken: samples::Buffers = samples::Buffers::default(),
    }
}

/// Depth of its list that a pixel gets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shown {
    /// The depth of the first fragment with opacity.
    First,
    /// The depth at which half of the light or less is left, +inf where more is left behind all fragments.
    Median,
    /// The mean of all depths, weighted by what each fragment adds to A; +inf where A is 0.
    Mean,
}

/// Everything that stays the same while a window is rendered.
#[derive(Clone, Copy)]
pub struct ListsJob<'a> {
    /// The projected cloud and who visits its pixels.
    pub raster: Raster<'a>,
    /// Shape, falloff, and how long lists are sorted.
    pub discs: Discs,
    /// The way in which fragments are stored.
    pub storing: &'a dyn StoreFragments,
    /// The value of `STOP` in WGSL, and the bound on colors that goes with it.
    pub stop: (u32, f32),
    /// The depths that pixels get.
    pub shown: Shown,
    /// The memory that may be used, without what tiles take.
    pub budget: Budget,
    /// Number of samples that each fragment has room for, where samples are asked for and no image.
    pub samples: Option<u32>,
}

/// Lists as the stages before blending leave them, for tests and inspection.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Lists {
    /// Prefix sums of the list lengths: one more than pixels.
    pub offsets: Vec<u32>,
    /// Depth key and splat index of each fragment, in the order of arrival within a list.
    pub fragments: Vec<[u32; 2]>,
}

impl ABuffer {
    /// Counts, then stores, sorts and blends band by band into the target.
    pub(crate) fn render(&mut self, work: &mut Work<'_>, job: &ListsJob<'_>) -> Result<Outcome, Error> {
        let (device, target) = (work.device, work.target);
        let counted = self.count(device, job, work.frame.fragments, work.timeline)?;
        if counted.overflow {
            return Ok(Outcome::Overflow);
        }
        let bands = self.plan_bands(work, job, &counted)?;
        self.reserve_fragments(device, job, &bands, &counted)?;
        let cut = Cut::of(device, job.raster.cloud, job.raster.footprint)?;
        let stored = Stored::of(&self.room, cut, Need::for_window(job, &counted).spare);
        for (i, band) in bands.iter().enumerate() {
            let mut recorder = work.timeline.recorder(device)?;
            if i == 0 {
                target.pixels().record_nothing(&mut recorder, job.raster.window)?;
            }
            if band.fragments > 0 {
                self.record_store(&mut recorder, job, band, &counted)?;
                let (blender, lengths) = (&self.blender, counted.lengths);
                let blending = Blending { job: *job, stored, band: *band, lengths, blender, target };
                job.storing.record_blend(&mut recorder, &blending)?;
            }
            if i + 1 == bands.len() {
                let pixels = bands::pixels(job.raster.window);
                job.storing.record_behind(&mut recorder, target, pixels)?;
                target.record_read_back(&mut recorder, pixels)?;
            }
            work.timeline.submit(recorder, "abuffer/store and blend")?;
            work.progress.inc(u64::from(band.pixels[1] - band.pixels[0]));
        }
        work.note_later(counted.noting(job, bands));
        Ok(Outcome::Done)
    }

    /// Counts and plans the bands; stores nothing.
    pub(crate) fn survey(&mut self, work: &mut Work<'_>, job: &ListsJob<'_>) -> Result<Outcome, Error> {
        let counted = self.count(work.device, job, false, work.timeline)?;
        if counted.overflow {
            return Ok(Outcome::Overflow);
        }
        let bands = self.plan_bands(work, job, &counted)?;
        counted.note(&bands, work.facts);
        Ok(Outcome::Done)
    }

    /// Counts the lists of a window for a method that renders without them.
    pub(crate) fn tally(&mut self, work: &mut Work<'_>, raster: Raster<'_>) -> Result<Outcome, Error> {
        let (discs, storing, budget) = (Discs::default(), &Slots, work.budget);
        let job = &ListsJob { raster, discs, storing, stop: (0, 1.0), shown: Shown::First, budget, samples: None };
        let counted = self.count(work.device, job, true, work.timeline)?;
        if counted.overflow {
            return Ok(Outcome::Overflow);
        }
        work.note_later(counted.noting(job, Vec::new()));
        Ok(Outcome::Done)
    }

    /// Fragment counts of every pixel of the window, in its order; what the last count left, read from the prefix sums.
    pub fn read_counts(&self, window: Window) -> Result<Vec<u32>, Error> {
        let offsets = self.told_offsets.read(self.room.offsets.get(), bands::pixels(window) + 1)?;
        Ok(offsets.windows(2).map(|w| w[1] - w[0]).collect())
    }

    /// Bodies of every pixel of the window, in its order, as [`Self::read_counts`].
    pub fn read_bodies(&self, window: Window) -> Result<Vec<u32>, Error> {
        if self.beside {
            return self.told_bodies.read(self.bodies.get(), bands::pixels(window));
        }
        Ok(self.read_counts(window)?.into_iter().map(|events| events / 2).collect())
    }

    /// Count, scan and store of a window that fits as one band, without sorting or blending.
    pub fn lists(&mut self, device: &Device, job: &ListsJob<'_>, timeline: &mut Timeline) -> Result<Lists, Error> {
        let counted = self.count(device, job, false, timeline)?;
        let pixels = bands::pixels(job.raster.window);
        let band = Band::whole(job.raster.window, u64::from(counted.total));
        self.reserve_fragments(device, job, &[band], &counted)?;
        let mut recorder = device.recorder()?;
        self.record_store(&mut recorder, job, &band, &counted)?;
        timeline.submit(recorder, "abuffer/store")?;
        Ok(Lists {
            offsets: self.room.offsets.get().read(0, pixels + 1)?,
            fragments: self.room.fragments.get().read(0, u64::from(counted.total))?,
        })
    }

    /// Records a band's fragments to their pixels' ranges.
    fn record_store<'a>(
        &'a self,
        recorder: &mut Recorder<'a>,
        job: &ListsJob<'a>,
        band: &Band,
        counted: &Counted,
    ) -> Result<(), Error> {
        let (raster, longest) = (job.raster, counted.lengths.longest);
        job.storing.record_store(recorder, Storing { raster, band: *band, room: &self.room, longest })?;
        if job.storing.needs().links {
            return Ok(());
        }
        let [start, end] = band.pixels.map(u64::from);
        let ends = self.room.counts.get().slice(start, end - start);
        let next = self.room.offsets.get().slice(start + 1, end - start);
        Ok(recorder.agree(job.storing.name(), "pixel", ends, Expected::Words(next))?)
    }

    /// List lengths of the window that was counted last, if the frame asks for them.
    pub(crate) fn counts(&self, frame: &Frame, window: Window) -> Result<Counts, Error> {
        let fragments = match frame.fragments {
            true if self.beside => Some(self.read_bodies(window)?),
            true => Some(self.read_counts(window)?),
            false => None,
        };
        Ok(Counts { fragments, ..Counts::default() })
    }
}

/// Returns the passes with their variants.
pub fn shaders() -> Vec<Shader> {
    let gather = || <(Cut, Lanes)>::all().into_iter().map(|(cut, lanes)| bin::gather_variant(cut, lanes));
    let mut all = vec![
        Shader::new::<Count>(raster::flat_variants()),
        Shader::new::<Store>(raster::flat_variants()),
        Shader::new::<Measure>([0, LOCAL_LENGTH].map(measure_variant)),
        Shader::new::<CountTiles>(gather()),
        Shader::new::<StoreTiles>(gather()),
    ];
    all.extend(blend::shaders());
    all
}
