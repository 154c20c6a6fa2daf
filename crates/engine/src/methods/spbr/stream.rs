//! Points that pass through the device while a window is rendered, for clouds that don't fit.
//!
//! The host keeps all points, in memory or in a file, the device some of them at a time, column behind column in one
//! buffer. The order of the dispatches determines which ones: a submission contains as many dispatches as can have all
//! of their points on the device.

use std::ops::Range;

use super::rounds::ALIGNED;
use crate::fields;
use crate::gpu::{Device, Error, Memory, Recorder, Scratch, Slice};
use crate::passes::project::{COLUMN_BYTES, Column, DeviceCloud};

/// Fewest points on the device at a time: more than any dispatch must have at least.
const LEAST_POINTS: u64 = 1 << 16;
/// Most points on the device at a time: the rows of a later pass, and as many again.
const MOST_POINTS: u64 = 1 << 23;
/// The budget's fraction for points is 1/`PART`, and the same for their source.
const PART: u64 = 8;
/// Bytes for the allocator's rounding to blocks, or a quarter of a smaller budget.
const OVERHEAD_BYTES: u64 = 16 << 20;

/// Returns the number of a dealt cloud's points on the device at a time; `None` for all of them, if they fit the
/// budget, or three quarters of the device's memory, and the largest allocation.
pub fn window_points(device: &Device, cloud: &DeviceCloud, memory_budget: Option<u64>) -> Option<u64> {
    let limits = device.limits();
    let budget = memory_budget.unwrap_or(limits.heap_bytes / 4 * 3);
    let fits = cloud.column_bytes() <= budget && cloud.len() * COLUMN_BYTES <= limits.allocation_bytes;
    if cloud.surfaces().is_none() || cloud.len() <= LEAST_POINTS || fits {
        return None;
    }
    let point = cloud.columns().len() as u64 * COLUMN_BYTES + 4;
    let most = cloud.longest().min(limits.allocation_bytes / point).min(MOST_POINTS);
    Some((budget / PART / point).max(LEAST_POINTS).min(most) / ALIGNED * ALIGNED)
}

/// Returns the rest of a budget beside this many points at a time.
pub fn rest(budget: u64, cloud: &DeviceCloud, points: u64) -> u64 {
    let both = 2 * points * (cloud.columns().len() as u64 * COLUMN_BYTES + 4);
    budget.saturating_sub(both + OVERHEAD_BYTES.min(budget / 4)).max(budget / PART)
}

/// Consecutive points, and where the first one is among those on the device.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Resident {
    points: Range<u64>,
    place: u64,
}

/// Points that are on the device.
#[derive(Debug, Default)]
struct Shelf {
    /// The number of points that fit.
    capacity: u64,
    /// Ranges of points, one behind the other.
    resident: Vec<Resident>,
    /// Ranges added since [`Self::begin`].
    fresh: Vec<Resident>,
}

impl Shelf {
    fn new(capacity: u64) -> Self {
        Self { capacity, ..Self::default() }
    }

    /// The place of a range's first point, if the whole range is present.
    fn place(&self, points: &Range<u64>) -> Option<u64> {
        let around = |resident: &&Resident| resident.points.start <= points.start && points.end <= resident.points.end;
        self.resident.iter().rev().find(around).map(|resident| resident.place + (points.start - resident.points.start))
    }

    /// Begins with these points: earlier ones are dropped if there is no room beside them.
    fn begin(&mut self, points: &Range<u64>) -> bool {
        self.fresh.clear();
        if self.admit(points) {
            return true;
        }
        self.resident.clear();
        self.admit(points)
    }

    /// Finds room for missing points; false if none is left.
    fn admit(&mut self, points: &Range<u64>) -> bool {
        if self.place(points).is_some() {
            return true;
        }
        let end = self.resident.last().map_or(0, |last| last.place + (last.points.end - last.points.start));
        if let Some(last) = self.resident.last_mut()
            && (last.points.start..=last.points.end).contains(&points.start)
        {
            let more = last.points.end..points.end;
            if end + (more.end - more.start) > self.capacity {
                return false;
            }
            last.points.end = points.end;
            self.fresh.push(Resident { points: more, place: end });
            return true;
        }
        let place = end.next_multiple_of(ALIGNED);
        if place + (points.end - points.start) > self.capacity {
            return false;
        }
        let resident = Resident { points: points.clone(), place };
        self.fresh.push(resident.clone());
        self.resident.push(resident);
        true
    }
}

fields! {
    /// Points on the device, and their source; kept from frame to frame.
    pub struct Stream {
        window: Scratch<[f32; 4]> = Scratch::new("streamed points", Memory::Device),
        staging: Scratch<[f32; 4]> = Scratch::new("streamed points, host", Memory::Upload),
        packed: Vec<[f32; 4]> = Vec::new(),
        ids: Scratch<u32> = Scratch::new("streamed ids", Memory::Device),
        staging_ids: Scratch<u32> = Scratch::new("streamed ids, host", Memory::Upload),
        packed_ids: Vec<u32> = Vec::new(),
        columns: u64 = 0,
        shelf: Shelf = Shelf::default(),
        /// Bytes that were copied to the device since [`Self::reserve`].
        pub uploaded: u64 = 0,
    }
}

impl Stream {
    /// Allocates room for this many points of a cloud, initially empty; without `points` frees it.
    pub fn reserve(&mut self, device: &Device, cloud: &DeviceCloud, points: Option<u64>) -> Result<(), Error> {
        (self.columns, self.uploaded) = (cloud.columns().len() as u64, 0);
        self.shelf = Shelf::new(points.unwrap_or(0));
        let Some(points) = points else {
            self.window.release();
            self.staging.release();
            self.packed = Vec::new();
            self.ids.release();
            self.staging_ids.release();
            self.packed_ids = Vec::new();
            return Ok(());
        };
        let vectors = points * self.columns;
        self.window.reserve_within(device, vectors, vectors)?;
        self.ids.reserve_within(device, points, points)?;
        self.staging_ids.reserve_within(device, points, points)?;
        self.staging.reserve_within(device, vectors, vectors)
    }

    /// Begins a submission whose first dispatch binds these points.
    pub fn begin(&mut self, points: &Range<u64>) {
        let fits = self.shelf.begin(points);
        assert!(fits, "{points:?}: a dispatch binds no more points than there is room for");
    }

    /// Returns `true` if a dispatch that binds these points may join the submission.
    pub fn admit(&mut self, points: &Range<u64>) -> bool {
        self.shelf.admit(points)
    }

    /// Packs the new points, for [`Self::record`].
    pub fn pack(&mut self, cloud: &DeviceCloud) -> Result<(), crate::passes::Error> {
        self.packed.clear();
        self.packed_ids.clear();
        for resident in &self.shelf.fresh {
            cloud.pack(resident.points.clone(), &mut self.packed, &mut self.packed_ids)?;
        }
        self.staging.get_mut().write(&self.packed);
        self.staging_ids.get_mut().write(&self.packed_ids);
        self.uploaded += self.packed.len() as u64 * COLUMN_BYTES + 4 * self.packed_ids.len() as u64;
        Ok(())
    }

    /// Records the copies of the new points.
    pub fn record<'a>(&'a self, recorder: &mut Recorder<'a>) -> Result<(), Error> {
        let (mut from, mut first) = (0, 0);
        for Resident { points, place } in &self.shelf.fresh {
            let count = points.end - points.start;
            let ids = self.staging_ids.get().slice(first, count);
            recorder.copy("spbr/upload", ids, self.ids.get().slice(*place, count))?;
            first += count;
            for column in 0..self.columns {
                let to = self.window.get().slice(column * self.shelf.capacity + place, count);
                recorder.copy("spbr/upload", self.staging.get().slice(from, count), to)?;
                from += count;
            }
        }
        Ok(())
    }

    /// Returns a column of some points of the submission.
    pub fn column(&self, column: Column, points: &Range<u64>) -> Slice<'_, [f32; 4]> {
        let place = self.shelf.place(points).expect("points of the submission are there");
        self.window.get().slice(column as u64 * self.shelf.capacity + place, points.end - points.start)
    }

    /// Returns the ids of some points of the submission.
    pub fn ids(&self, points: &Range<u64>) -> Slice<'_, u32> {
        let place = self.shelf.place(points).expect("points of the submission are there");
        self.ids.get().slice(place, points.end - points.start)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_stay_until_others_need_the_room() {
        let mut shelf = Shelf::new(1000);
        let fresh = |shelf: &Shelf| shelf.fresh.iter().map(|f| (f.points.clone(), f.place)).collect::<Vec<_>>();
        assert!(shelf.begin(&(64..300)));
        // The next ones overlap by what alignment asks for; then some that begin elsewhere.
        assert!(shelf.admit(&(256..500)) && shelf.admit(&(5056..5200)) && !shelf.admit(&(5120..6000)));
        assert_eq!(fresh(&shelf), [(64..300, 0), (300..500, 236), (5056..5200, 448)]);
        assert_eq!(shelf.place(&(128..400)), Some(64));
        assert_eq!(shelf.place(&(5120..5200)), Some(512));
        assert_eq!(shelf.place(&(400..501)), None);
        // Ranges already present stay, and are not fresh.
        assert!(shelf.begin(&(5056..5100)) && shelf.fresh.is_empty());
        assert!(shelf.admit(&(0..64)) && !shelf.admit(&(10_048..10_500)));
        assert!(shelf.begin(&(10_048..10_500)));
        assert_eq!(fresh(&shelf), [(10_048..10_500, 0)]);
        assert_eq!(shelf.place(&(64..300)), None);
        assert!(!shelf.begin(&(0..1001)));
    }
}
