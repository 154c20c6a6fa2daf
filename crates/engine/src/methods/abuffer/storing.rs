//! The ways in which fragments get into the lists of pixels, and out of them again.

use super::blend::{Blender, Blending};
use super::passes::{Count, CountTiles, RunSums, Sampled, Store, StoreTiles};
use super::{FRAGMENT_BYTES, INDEX_BYTES};
use crate::methods::prelude::*;

/// Bytes of a node's link to the next.
pub const LINK_BYTES: u64 = 4;
/// Bytes of a fragment's record.
pub const RECORD_BYTES: u64 = 16;
/// Device bytes of a fragment's segment.
pub const SEGMENT_BYTES: u64 = 4;

/// Fills the lists of pixels with what a family of methods draws, and blends them.
///
/// The A-buffer counts, reserves and sorts in the same way for every implementation. It owns the buffers of [`Room`]
/// and of [`Blender`]; [`Self::needs`] says which of them an implementation uses.
pub trait StoreFragments {
    /// Returns the name of the pass that stores.
    fn name(&self) -> &'static str {
        "abuffer/store"
    }

    /// Returns how the bodies of a pixel follow from its fragments.
    fn bodies(&self) -> Bodies {
        Bodies::Fragments
    }

    /// Returns the buffers that it uses.
    fn needs(&self) -> Needs {
        Needs::default()
    }

    /// Returns device bytes of a pixel in addition to those of its list.
    fn pixel_bytes(&self) -> u64 {
        0
    }

    /// Returns the largest number of samples of so many fragments and bodies.
    fn most_samples(&self, _fragments: u64, bodies: u64) -> u64 {
        bodies
    }

    /// Records the count of a window's fragments, of splats that are visited one by one unless an implementation counts
    /// otherwise. `bodies` is counted only with [`Bodies::Counted`].
    ///
    /// # Errors
    /// Vulkan errors.
    fn record_count<'a>(&'a self, recorder: &mut Recorder<'a>, counting: Counting<'a>) -> Result<(), Error> {
        let Counting { raster, counts, .. } = counting;
        raster.record_tiles(recorder)?;
        let whole = Band::whole(raster.window, 0);
        Ok(raster.record(recorder, &whole, |chunk: Chunk<'a>| Count { chunk, counts })?)
    }

    /// Records a band's fragments to their pixels' ranges.
    ///
    /// # Errors
    /// Vulkan errors.
    fn record_store<'a>(&'a self, recorder: &mut Recorder<'a>, storing: Storing<'a>) -> Result<(), Error>;

    /// Records everything from a band's stored fragments to its pixels in the target; of fragments of splats unless an
    /// implementation blends otherwise.
    ///
    /// # Errors
    /// Vulkan errors.
    fn record_blend<'a>(&'a self, recorder: &mut Recorder<'a>, blending: &Blending<'a>) -> Result<(), Error> {
        blending.blender.record_fragments(recorder, blending)
    }

    /// Records the samples of a band's stored fragments, of every list in order. `bodies` asks for one per body.
    ///
    /// # Errors
    /// Vulkan errors.
    fn record_samples<'a>(
        &'a self,
        recorder: &mut Recorder<'a>,
        blending: &Blending<'a>,
        _bodies: bool,
        samples: Sampled<'a>,
    ) -> Result<(), Error> {
        blending.blender.record_fragment_samples(recorder, blending, samples)
    }

    /// Records what lies behind all lists of a window.
    ///
    /// # Errors
    /// Vulkan errors.
    fn record_behind<'a>(
        &'a self,
        _recorder: &mut Recorder<'a>,
        _target: &'a Target,
        _pixels: u64,
    ) -> Result<(), Error> {
        Ok(())
    }
}

/// The count of a window's fragments.
#[derive(Clone, Copy)]
pub struct Counting<'a> {
    /// The projected cloud and who visits its pixels.
    pub raster: Raster<'a>,
    /// Fragments of each pixel.
    pub counts: Slice<'a, u32>,
    /// Bodies of each pixel.
    pub bodies: Slice<'a, u32>,
}

/// The storing of a band's fragments.
#[derive(Clone, Copy)]
pub struct Storing<'a> {
    /// The projected cloud and who visits its pixels.
    pub raster: Raster<'a>,
    /// The band.
    pub band: Band,
    /// The buffers.
    pub room: &'a Room,
    /// Length of the longest list.
    pub longest: u32,
}

/// The relation of a pixel's bodies to the fragments of its list.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Bodies {
    /// Each fragment is a body.
    Fragments,
    /// A body has two fragments.
    Halves,
    /// The count pass counts them, because bodies differ in their number of fragments.
    Counted,
}

/// The buffers that a way of storing uses.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Needs {
    /// `true` if fragments are stored in the order of blending, as indices: nothing is sorted.
    pub in_order: bool,
    /// `true` if fragments are stored through linked lists, whose heads are in place of the cursors.
    pub links: bool,
    /// `true` if each fragment has a record.
    pub records: bool,
    /// `true` if long lists have running sums.
    pub sums: bool,
    /// `true` if long lists have a value for each segment.
    pub segments: bool,
    /// `true` if every list goes in runs, short ones too.
    pub every_run: bool,
}

impl Needs {
    /// Bytes of a fragment itself.
    pub(super) fn fragment(self) -> u64 {
        if self.in_order { INDEX_BYTES } else { FRAGMENT_BYTES }
    }
}

fields! {
    /// Buffers that fragments are stored in, kept from frame to frame.
    pub struct Room by device {
        /// Counts of the pixels of a window, and then the cursors that hand out slots, or the heads of linked lists.
        pub counts: Scratch<u32> = Scratch::new("fragment counts", Memory::Device),
        /// Prefix sums of the window's list lengths.
        pub offsets: Scratch<u32> = Scratch::new("fragment offsets", Memory::Device),
        /// The fragments of a band.
        pub fragments: Scratch<[u32; 2]> = Scratch::new("fragments", Memory::Device),
        /// Room for the fragments once more: nodes of linked lists, and what long lists are merged into.
        pub spare: Scratch<[u32; 2]> = Scratch::new("spare fragments", Memory::Device),
        /// Records of fragments, at their slots.
        pub records: Scratch<[u32; 4]> = Scratch::new("event records", Memory::Device),
        /// Links of the nodes of linked lists.
        pub links: Scratch<u32> = Scratch::new("list links", Memory::Device),
        /// Counter of those nodes.
        pub node_count: Buffer<u32> = device.buffer("node count", 1, Memory::Device)?,
    }
}

fields! {
    /// Running sums of long lists, and values of their segments, kept from frame to frame.
    pub struct RunBuffers {
        /// Sums of runs.
        pub sums: Scratch<RunSums> = Scratch::new("sums of runs", Memory::Device),
        /// Values of segments.
        pub segments: Scratch<f32> = Scratch::new("segments", Memory::Device),
    }
}

/// Stores each fragment in a slot that its pixel hands out: `abuffer`.
#[derive(Debug, Clone, Copy)]
pub struct Slots;

impl StoreFragments for Slots {
    fn record_store<'a>(&'a self, recorder: &mut Recorder<'a>, storing: Storing<'a>) -> Result<(), Error> {
        let Storing { raster, band, room, .. } = storing;
        let (cursors, fragments) = (room.counts.get().all(), room.fragments.get().all());
        Ok(raster.record(recorder, &band, |chunk: Chunk<'a>| Store { chunk, cursors, fragments })?)
    }
}

/// Stores fragments tile by tile, in the order of blending. Only flat discs have one.
#[derive(Clone, Copy)]
pub struct InOrder<'a> {
    /// The buffers of the binned splats.
    pub bins: &'a Bins,
    /// The binned splats.
    pub binned: Binned,
}

impl StoreFragments for InOrder<'_> {
    fn needs(&self) -> Needs {
        Needs { in_order: true, ..Needs::default() }
    }

    fn record_count<'a>(&'a self, recorder: &mut Recorder<'a>, counting: Counting<'a>) -> Result<(), Error> {
        let Counting { raster, counts, .. } = counting;
        let tiles = self.bins.record_tiles(recorder, raster.cloud, self.binned)?;
        let whole = Band::whole(raster.window, 0);
        tiles.record(recorder, raster.window, &whole, |tiles| CountTiles { tiles, counts })
    }

    fn record_store<'a>(&'a self, recorder: &mut Recorder<'a>, storing: Storing<'a>) -> Result<(), Error> {
        let Storing { raster, band, room, .. } = storing;
        let (cursors, indices) = (room.counts.get().all(), room.fragments.get().all().cast());
        let tiles = self.bins.tiles(raster.cloud, self.binned);
        tiles.record(recorder, raster.window, &band, |tiles| StoreTiles { tiles, cursors, indices })
    }

    fn record_blend<'a>(&'a self, recorder: &mut Recorder<'a>, blending: &Blending<'a>) -> Result<(), Error> {
        let tiles = self.bins.tiles(blending.job.raster.cloud, self.binned);
        Ok(Blender::record_ordered(recorder, blending, &tiles)?)
    }
}
