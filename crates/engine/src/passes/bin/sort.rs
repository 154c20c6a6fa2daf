//! The drawn splats of a window in order: sorted by a key, or picked from an order that the cloud brings.

use super::binning::SHORTEST_RUN;
use super::keys::{key_bits, keys, keys_variant};
use super::passes::{Keys, KeysPush, Pick, Place, PresortedPush};
use super::{Bins, Job, Order, RECORD_BYTES};
use crate::gpu::{Device, Dispatch, Recorder, Run, Variant};
use crate::passes::Error;
use crate::passes::radix::{Radix, Runs};
use crate::passes::scan::Scan;
use crate::prepare::axes::Axis;

impl Bins {
    /// Records keys and sort; returns which of the records are the sorted ones.
    pub(super) fn record_sort<'a>(
        &'a self,
        recorder: &mut Recorder<'a>,
        job: &Job<'a>,
        subgroup: u32,
    ) -> Result<usize, Error> {
        let cloud = job.raster.cloud;
        let records = self.records.each_ref().map(|r| r.get().slice(0, cloud.len()));
        // Places in files are those among all points, wherever the others are.
        let all = cloud.total();
        let ([nearest, none], bits) =
            (keys(job.order, job.depth_range, all), key_bits(job.order, job.depth_range, all));
        for (first, count) in cloud.chunks() {
            let push = KeysPush { count: count as u32, first: first as u32, nearest, none };
            let (splat_depths, bounds) = (cloud.splat_depths.slice(first, count), cloud.bounds.slice(first, count));
            let points = cloud.point_colors.slice(first, count).cast();
            let run = Run::new(Dispatch::Invocations(count)).variant(keys_variant(job.order));
            recorder.run(&Keys { splat_depths, bounds, points, records: records[0] }, push, &run)?;
        }
        Ok(self.radix.record(recorder, records, bits, subgroup)?)
    }

    /// Records the passes that pick the drawn splats from the cloud's order along an axis; returns the index of their
    /// records.
    pub(super) fn record_pick<'a>(
        &'a self,
        recorder: &mut Recorder<'a>,
        device: &Device,
        job: &Job<'a>,
        axis: Axis,
        subgroup: u32,
    ) -> Result<usize, Error> {
        let cloud = job.raster.cloud;
        let Some(order) = cloud.along(axis.index) else { return Ok(0) };
        let Runs { runs, length } = order_runs(device, cloud.len());
        let push = PresortedPush { count: cloud.len() as u32, run_length: length, backward: u32::from(axis.backward) };
        let (counts, starts) = (self.counts.get().slice(0, runs.into()), self.cursors.get().slice(0, runs.into()));
        let (bounds, records) = (cloud.bounds.all(), self.records[0].get().all());
        let run = || Run::new(Dispatch::Groups(runs.into())).variant(presorted_variant(subgroup));
        recorder.run(&Pick { order, bounds, counts }, push, &run())?;
        recorder.fill("bin/clear", self.scan.overflow.all(), 0)?;
        self.scan.record(recorder, counts, starts)?;
        recorder.run(&Place { order, bounds, starts, records }, push, &run())?;
        Ok(0)
    }
}

/// Returns the number of device bytes of the records of so many points, and of sorting them.
pub fn sort_bytes(device: &Device, points: u64) -> u64 {
    2 * RECORD_BYTES * points + Radix::bytes(device, points)
}

/// Returns the number of device bytes of putting the drawn ones of so many points into an order.
pub(super) fn order_bytes(device: &Device, order: Order, points: u64, drawn: u64) -> u64 {
    match order {
        Order::Along(_) => {
            let runs = u64::from(order_runs(device, points).runs);
            RECORD_BYTES * drawn + 8 * runs + Scan::bytes(runs)
        }
        _ => sort_bytes(device, points),
    }
}

/// Cuts a presorted order into runs, each of which a subgroup takes twice.
pub fn order_runs(device: &Device, points: u64) -> Runs {
    Runs::new(device.info().prefers.concurrent_runs, points, SHORTEST_RUN, 1 << 17)
}

/// Returns the variant of `bin/pick` and `bin/place`.
pub(super) fn presorted_variant(subgroup: u32) -> Variant {
    Variant::plain().subgroup(subgroup)
}
