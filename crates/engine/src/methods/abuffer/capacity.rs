//! Number of fragments that the memory has room for, and the bands of pixels that follow from it.

use super::samples::{COLOR_BYTES, MOST_SAMPLES, SAMPLE_BYTES};
use super::{
    ABuffer, Counted, FRAGMENT_BYTES, LINK_BYTES, ListsJob, PIXEL_BYTES, RECORD_BYTES, SEGMENT_BYTES, in_place_length,
};
use crate::gpu;
use crate::methods::prelude::*;

impl ABuffer {
    /// Fragments that fit at a time: within the budget, and within a binding.
    fn capacity(device: &Device, job: &ListsJob<'_>, counted: &Counted) -> u64 {
        let pixel_bytes = PIXEL_BYTES + job.storing.pixel_bytes() + job.run_bytes();
        let left = job.budget.left(bands::pixels(job.raster.window) * pixel_bytes);
        let need = Need::for_window(job, counted);
        let widest = if need.records { RECORD_BYTES } else { need.fragment };
        let widest = widest.max(need.samples * COLOR_BYTES);
        // Samples are on the host as well, more than once while they are packed.
        let most = match need.samples {
            0 => u64::MAX,
            samples => (MOST_SAMPLES / samples).max(counted.lengths.longest.into()),
        };
        (left / need.bytes()).min(most).min(device.limits().binding_bytes.saturating_sub(gpu::guard_bytes()) / widest)
    }

    pub(super) fn plan_bands(
        &self,
        work: &Work<'_>,
        job: &ListsJob<'_>,
        counted: &Counted,
    ) -> Result<Vec<Band>, Error> {
        let (device, window) = (work.device, job.raster.window);
        let (length, most) = (counted.lengths.longest, in_place_length());
        if job.discs.long_lists == LongLists::InPlace && length > most {
            return Err(Error::ListTooLong { length, most });
        }
        let capacity = Self::capacity(device, job, counted);
        if u64::from(counted.total) <= capacity {
            return Ok(vec![Band::whole(window, u64::from(counted.total))]);
        }
        if work.timeline.foresight.knowledge() != Knowledge::None {
            // Lists that fit by their bounds need no offsets. Those of this window may not be there yet.
            return Err(Error::Unforeseen);
        }
        work.progress.check()?;
        let offsets = self.room.offsets.get().read(0, bands::pixels(window) + 1)?;
        bands::bands(&offsets, capacity).map_err(|_| {
            let (pixel, length) = bands::longest(&offsets);
            let [x, y] = bands::place(window, pixel);
            let need = Need::for_window(job, counted);
            let widest = need.fragment.max(need.samples * COLOR_BYTES);
            let (bytes, limit) = (u64::from(length) * widest, device.limits().binding_bytes);
            if bytes > limit {
                let name = format!("the list of pixel ({x}, {y}) with {length} fragments");
                return gpu::Error::TooLarge { name, bytes, limit, limit_name: "maxStorageBufferRange" }.into();
            }
            let each = need.bytes();
            let needed = u64::from(length) * each;
            Error::PixelOverBudget { x, y, length, needed, available: capacity * each, budget: Budget::wanted(needed) }
        })
    }

    pub(super) fn reserve_fragments(
        &mut self,
        device: &Device,
        job: &ListsJob<'_>,
        bands: &[Band],
        counted: &Counted,
    ) -> Result<(), Error> {
        let most = bands.iter().map(|b| b.fragments).max().unwrap_or(0).max(1);
        // An earlier frame may have left more than this one's budget allows.
        let limit = Self::capacity(device, job, counted).max(most);
        let need = Need::for_window(job, counted);
        // Buffers that this frame does not need go first, since the budget is for all of them.
        if !need.spare {
            self.room.spare.release();
        }
        if !need.links {
            self.room.links.release();
        }
        // In records of eight bytes.
        let records = |fragments: u64| (fragments * need.fragment).div_ceil(FRAGMENT_BYTES);
        self.room.fragments.reserve_within(device, records(most), records(limit))?;
        if need.records {
            self.room.records.reserve_within(device, most, limit)?;
        } else {
            // Bound, but not looked at.
            self.room.records.release();
            self.room.records.reserve(device, 1)?;
        }
        if need.spare {
            self.room.spare.reserve_within(device, most, limit)?;
        }
        if need.links {
            self.room.links.reserve_within(device, most, limit)?;
        }
        let pixels = bands::pixels(job.raster.window);
        if let Some(samples) = job.samples {
            self.taken.reserve(device, [most, limit].map(|fragments| fragments * u64::from(samples)))?;
        }
        if job.storing.needs().every_run || job.samples.is_some() {
            return self.blender.reserve_events(device, pixels, most);
        }
        let long = if need.runs { most.min(counted.lengths.in_long_lists.into()) } else { 0 };
        let events = if need.segments { [most, limit] } else { [0, 0] };
        self.blender.reserve_sums(device, (need.runs && job.storing.needs().sums).then_some(long), events)?;
        Ok(self.blender.reserve(device, pixels, long)?)
    }
}

/// Buffers that a window's fragments need beside the fragment buffer.
#[derive(Clone, Copy)]
pub(super) struct Need {
    /// Bytes of a fragment itself: ordered lists hold only indices.
    fragment: u64,
    /// Room for the fragments once more.
    pub(super) spare: bool,
    /// Links of nodes.
    links: bool,
    /// Records of long lists and their runs.
    runs: bool,
    /// Optical depths of segments.
    segments: bool,
    /// Records of packed events.
    pub(super) records: bool,
    /// Samples.
    samples: u64,
}

impl Need {
    pub(super) fn for_window(job: &ListsJob<'_>, counted: &Counted) -> Self {
        let needs = job.storing.needs();
        let (links, records) = (needs.links, needs.records);
        let runs = !needs.in_order && counted.lengths.in_long_lists > 0;
        let (fragment, segments) = (needs.fragment(), runs && needs.segments);
        let spare = links || (runs && job.discs.long_lists == LongLists::Merge);
        Self { fragment, spare, links, runs, segments, records, samples: job.samples.unwrap_or(0).into() }
    }

    /// Returns the number of bytes of so many fragments as they are stored.
    pub(super) fn stored_bytes(self, fragments: u64) -> u64 {
        let records = if self.records { fragments * RECORD_BYTES } else { 0 };
        (fragments * self.fragment).next_multiple_of(FRAGMENT_BYTES) + records
    }

    /// Bytes for each fragment of a band, those in the fragment buffer included.
    fn bytes(self) -> u64 {
        let spare = if self.spare { FRAGMENT_BYTES } else { 0 };
        let links = if self.links { LINK_BYTES } else { 0 };
        let segments = if self.segments { SEGMENT_BYTES } else { 0 };
        let records = if self.records { RECORD_BYTES } else { 0 };
        let samples = self.samples * SAMPLE_BYTES;
        self.fragment + spare + links + segments + records + samples + u64::from(self.runs)
    }
}
