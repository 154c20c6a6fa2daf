//! `abuffer`: exact order-independent transparency (MCTB12): count, scan, store, sort and blend.
//!
//! Each pixel's fragments lie together in one buffer of 8 bytes per fragment: depth key and index of the splat. Lists of up
//! to [`LOCAL_LENGTH`] fragments are sorted and blended by one invocation, in registers or in a local array, each class of
//! lengths by its own kernel. Longer ones are sorted in runs of that length, merged pairwise between two buffers, blended
//! run by run and composed, so that no invocation loops longer than a run, however long the list is. Or, if asked for, one
//! invocation sorts each of them in place, which takes half the memory and bounds their length ([`in_place_length`]).
//!
//! Everything but the store serves `linked-list` too ([`Storing`]): one set of buffers, whichever method a frame takes.

mod blend;
mod capacity;
mod count;
mod engine;
mod explain;
mod passes;
mod samples;

pub use blend::{CLASSES, in_place_length, least_bytes, long_groups, lower_bound, record_nothing};
pub(crate) use blend::{CONSTANTS, Sorting, composing_variant};
pub use engine::projecting;
pub(crate) use engine::{ListEngine, ORDERED_AREA, list_bytes};
pub(crate) use explain::{BY_LENGTH, COUNT, count_group, counted_beside, ellipsoid_group, list_group, list_passes};
pub use passes::*;
pub(crate) use samples::{Sampling, Taken};

use self::blend::{Blender, Stored};
use self::capacity::Need;
use self::count::{Counted, measure_variant};
use super::ellipsoids;
use super::engine::Work;
use super::linked_list::{self, LinkedList};
use super::soft::Spheres;
use super::told::Told;
use super::{Error, Outcome, Timeline};
use crate::choices::Choices;
use crate::gpu::shader::Shader;
use crate::gpu::{Buffer, Device, Expected, Kept, Memory, Recorder};
use crate::passes::bands::{self, Band, Budget, Window};
use crate::passes::bin::{self, Binned, Bins, Lanes};
use crate::passes::compose::Cut;
use crate::passes::foresight::Knowledge;
use crate::passes::project::Footprint;
use crate::passes::raster::{self, Chunk, Raster};
use crate::passes::scan::Scan;
use crate::scene::{DiscShape, Discs};

/// The longest list that one invocation sorts in a local array; also the length of a run of a longer one.
pub const LOCAL_LENGTH: u32 = 256;
/// Bytes of a fragment: depth key and splat index.
pub const FRAGMENT_BYTES: u64 = 8;
/// Bytes of a fragment of a list that is stored in order: the splat's rank.
pub const INDEX_BYTES: u64 = 4;
/// Bytes per pixel of a window: count, offset, their share of the scan's levels, and place in the work list.
pub const PIXEL_BYTES: u64 = 13;

/// Returns the footprint of a disc's shape.
pub fn footprint(shape: DiscShape) -> Footprint {
    match shape {
        DiscShape::Flat => Footprint::Disc,
        DiscShape::Oriented => Footprint::Oriented,
    }
}

/// Buffers of the A-buffer, kept from frame to frame.
pub struct ABuffer {
    counts: Kept<u32>,
    offsets: Kept<u32>,
    told_offsets: Told<u32>,
    scan: Option<Scan>,
    overflow: Buffer<u32>,
    lengths: Buffer<Lengths>,
    fragments: Kept<[u32; 2]>,
    /// Room for the fragments once more: nodes of linked lists, and what long lists are merged into.
    spare: Kept<[u32; 2]>,
    /// Records of packed events of spheres, at their fragments' slots.
    records: Kept<[u32; 4]>,
    /// Bodies of each pixel that events are of (spheres, ellipsoids, discs), where they are counted beside, and their lengths.
    bodies: Kept<u32>,
    /// `true` if they were, of the last window.
    beside: bool,
    told_bodies: Told<u32>,
    body_lengths: Buffer<Lengths>,
    linked: LinkedList,
    blender: Blender,
    taken: samples::Buffers,
}

/// Depth of its list that a pixel gets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shown {
    /// That of the first fragment with opacity.
    First,
    /// That at which half of the light or less is left, +inf where more is left behind all fragments.
    Median,
    /// The mean of all, weighted by what each adds to A; +inf where A is 0.
    Mean,
}

/// Way in which fragments get to their pixels' ranges of the buffer.
#[derive(Clone, Copy)]
pub enum Storing<'a> {
    /// Each into a slot that its pixel hands out.
    Slots,
    /// Tile by tile, in the order of blending: flat discs alone have one.
    Ordered(&'a Bins, Binned),
    /// Through linked lists: `linked-list`.
    Links,
    /// Events of soft spheres, into slots as they come.
    Spheres(Spheres<'a>),
    /// Events of ellipsoids and surfaces, into slots, or through linked lists.
    Ellipsoids {
        /// Through linked lists.
        linked: bool,
    },
}

impl<'a> Storing<'a> {
    fn spheres(&self) -> Option<&Spheres<'a>> {
        match self {
            Self::Spheres(spheres) => Some(spheres),
            _ => None,
        }
    }

    fn are_ellipsoids(&self) -> bool {
        matches!(self, Self::Ellipsoids { .. })
    }

    fn are_linked(&self) -> bool {
        matches!(self, Self::Links | Self::Ellipsoids { linked: true })
    }

    /// Of events, whether what they are of is counted beside them: where some have two, and others another number.
    fn counted_beside(&self) -> Option<bool> {
        match self {
            Self::Spheres(spheres) => Some(spheres.kind.interior.counted()),
            Self::Ellipsoids { .. } => Some(true),
            _ => None,
        }
    }

    /// Device bytes of a pixel beside those of lists.
    fn pixel_bytes(&self) -> u64 {
        match self {
            Self::Spheres(spheres) => spheres.pixel_bytes(),
            Self::Ellipsoids { .. } => ellipsoids::PIXEL_BYTES,
            _ => 0,
        }
    }
}

/// Everything that stays the same while a window is rendered.
#[derive(Clone, Copy)]
pub struct WindowJob<'a> {
    /// The projected cloud and who visits its pixels.
    pub raster: Raster<'a>,
    /// Shape, falloff, and how long lists are sorted.
    pub discs: Discs,
    /// Way in which fragments are stored.
    pub storing: Storing<'a>,
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
    /// No buffers but the small ones yet.
    pub fn new(device: &Device) -> Result<Self, Error> {
        Ok(Self {
            counts: Kept::new("fragment counts", Memory::Device),
            offsets: Kept::new("fragment offsets", Memory::Device),
            told_offsets: Told::new("fragment offsets, host"),
            scan: None,
            overflow: device.buffer("scan overflow", 1, Memory::Device)?,
            lengths: device.buffer("list lengths", 1, Memory::Device)?,
            fragments: Kept::new("fragments", Memory::Device),
            spare: Kept::new("spare fragments", Memory::Device),
            records: Kept::new("event records", Memory::Device),
            bodies: Kept::new("sphere counts", Memory::Device),
            beside: false,
            told_bodies: Told::new("sphere counts, host"),
            body_lengths: device.buffer("sphere lengths", 1, Memory::Device)?,
            linked: LinkedList::new(device)?,
            blender: Blender::new(device)?,
            taken: samples::Buffers::new(),
        })
    }

    /// Counts, then stores, sorts and blends band by band into the target.
    pub(crate) fn render(&mut self, work: &mut Work<'_>, job: &WindowJob<'_>) -> Result<Outcome, Error> {
        let (device, target) = (work.device, work.target);
        let counted = self.count(device, job, work.frame.fragments, work.timeline)?;
        if counted.overflow {
            return Ok(Outcome::Overflow);
        }
        let bands = self.plan_bands(work, job, &counted)?;
        if bands.len() > 1 && work.timeline.foresight.knowledge() != Knowledge::None {
            return Err(Error::Unforeseen);
        }
        self.reserve_fragments(device, job, &bands, &counted)?;
        let cut = Cut::of(device, job.raster.cloud, job.raster.footprint)?;
        let stored = Stored {
            cut,
            offsets: self.offsets.get().all(),
            fragments: self.fragments.get().all(),
            spare: Need::for_window(job, &counted).spare.then(|| self.spare.get().all()),
            records: self.records.get().all(),
        };
        for (i, band) in bands.iter().enumerate() {
            let mut recorder = work.timeline.recorder(device)?;
            if i == 0 {
                record_nothing(&mut recorder, target, job.raster.window)?;
            }
            if band.fragments > 0 {
                self.record_store(&mut recorder, job, band, &counted)?;
                self.blender.record(&mut recorder, job, stored, target, band, &counted)?;
            }
            if i + 1 == bands.len() {
                let pixels = bands::pixels(job.raster.window);
                if let Some(spheres) = job.storing.spheres() {
                    spheres.record_compose(&mut recorder, target, pixels)?;
                }
                target.record_read_back(&mut recorder, pixels)?;
            }
            work.timeline.submit(recorder, "abuffer/store and blend")?;
            work.progress.inc(u64::from(band.pixels[1] - band.pixels[0]));
        }
        work.note_later(counted.noting(job, bands));
        Ok(Outcome::Done)
    }

    /// Counts and plans the bands; stores nothing.
    pub(crate) fn survey(&mut self, work: &mut Work<'_>, job: &WindowJob<'_>) -> Result<Outcome, Error> {
        let counted = self.count(work.device, job, false, work.timeline)?;
        if counted.overflow {
            return Ok(Outcome::Overflow);
        }
        let bands = self.plan_bands(work, job, &counted)?;
        counted.note(&bands, work.facts);
        Ok(Outcome::Done)
    }

    /// Counts the lists of a window for a method that renders without them.
    pub(crate) fn tally(&mut self, work: &mut Work<'_>, job: &WindowJob<'_>) -> Result<Outcome, Error> {
        let counted = self.count(work.device, job, true, work.timeline)?;
        if counted.overflow {
            return Ok(Outcome::Overflow);
        }
        work.note_later(counted.noting(job, Vec::new()));
        Ok(Outcome::Done)
    }

    /// Fragment counts of every pixel of the window, in its order; what the last count left, read from the prefix sums.
    pub fn read_counts(&self, window: Window) -> Result<Vec<u32>, Error> {
        let offsets = self.told_offsets.read(self.offsets.get(), bands::pixels(window) + 1)?;
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
    pub fn lists(&mut self, device: &Device, job: &WindowJob<'_>, timeline: &mut Timeline) -> Result<Lists, Error> {
        let counted = self.count(device, job, false, timeline)?;
        let pixels = bands::pixels(job.raster.window);
        let band = Band::whole(job.raster.window, u64::from(counted.total));
        self.reserve_fragments(device, job, &[band], &counted)?;
        let mut recorder = device.recorder()?;
        self.record_store(&mut recorder, job, &band, &counted)?;
        timeline.submit(recorder, "abuffer/store")?;
        Ok(Lists {
            offsets: self.offsets.get().read(0, pixels + 1)?,
            fragments: self.fragments.get().read(0, u64::from(counted.total))?,
        })
    }

    /// Records a band's fragments to their pixels' ranges.
    fn record_store<'a>(
        &'a self,
        recorder: &mut Recorder<'a>,
        job: &WindowJob<'a>,
        band: &Band,
        counted: &Counted,
    ) -> Result<(), Error> {
        let (counts, fragments) = (self.counts.get().all(), self.fragments.get().all());
        match job.storing {
            Storing::Slots => {
                job.raster.record(recorder, band, |chunk: Chunk<'a>| Store { chunk, cursors: counts, fragments })?;
            }
            Storing::Spheres(spheres) => {
                let to = (fragments, self.records.get().all());
                spheres.record_store(recorder, &job.raster, band, counts, to)?;
            }
            Storing::Ordered(bins, binned) => {
                let tiles = bins.tiles(job.raster.cloud, binned);
                tiles.record(recorder, job.raster.window, band, |tiles| StoreTiles {
                    tiles,
                    cursors: counts,
                    indices: fragments.cast(),
                })?;
            }
            Storing::Ellipsoids { linked: false } => {
                ellipsoids::record_store(recorder, &job.raster, band, counts, fragments)?;
            }
            Storing::Links | Storing::Ellipsoids { linked: true } => {
                let (offsets, nodes) = (self.offsets.get().all(), self.spare.get().all());
                let through = linked_list::Through { offsets, heads: counts, nodes, fragments };
                let through = (through, job.storing.are_ellipsoids());
                return Ok(self.linked.record(recorder, &job.raster, through, band, counted.lengths.longest)?);
            }
        }
        let [start, end] = band.pixels.map(u64::from);
        let (ends, next) =
            (self.counts.get().slice(start, end - start), self.offsets.get().slice(start + 1, end - start));
        let name = match job.storing {
            Storing::Spheres(_) => "soft/store",
            Storing::Ellipsoids { .. } => "ellipsoids/store",
            _ => "abuffer/store",
        };
        Ok(recorder.agree(name, "pixel", ends, Expected::Words(next))?)
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
