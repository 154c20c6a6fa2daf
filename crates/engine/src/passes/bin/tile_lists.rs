//! The lists of the tiles: counted, then stored.

use super::binning::{Binned, Binning, pattern};
use super::passes::{Measure, MeasurePush, Pairs, TileCount, TileStore};
use super::{Bins, Job};
use crate::gpu::{Dispatch, Expected, Recorder, Run, Variant};
use crate::passes::Error;
use crate::passes::project::DeviceCloud;

impl Bins {
    /// Records the counts of the tiles, their prefix sums, and the longest of their lists.
    pub(super) fn record_tile_count<'a>(
        &'a self,
        recorder: &mut Recorder<'a>,
        job: &Job<'a>,
        binning: &Binning,
        records: usize,
    ) -> Result<(), Error> {
        let cells = binning.cells();
        let (counts, cursors) = (self.counts.get().slice(0, cells), self.cursors.get().slice(0, cells));
        // Before the dispatches, so that only they wait for one another.
        recorder.fill_all("bin/clear", &[(counts, 0), (self.scan.overflow.all(), 0), (self.longest.all(), 0)])?;
        let (cloud, records) = (job.raster.cloud, self.records[records].get().all());
        let run = Run::new(Dispatch::Invocations(binning.drawn)).variant(count_variant(binning.pairs));
        let count = TileCount { view: cloud.view(), records, bounds: cloud.bounds.all(), counts };
        recorder.run(&count, binning.push(), &run)?;
        self.scan.record(recorder, counts, cursors)?;
        let (tiles, longest) = (binning.tiles(), self.longest.all());
        let run = Run::new(Dispatch::Invocations(tiles));
        let push = MeasurePush { tiles: tiles as u32, runs: binning.runs.runs };
        Ok(recorder.run(&Measure { starts: cursors, longest }, push, &run)?)
    }

    /// Records the pairs of tile and splat in the order of splats, and their stable sort by tile: the lists.
    pub(super) fn record_pairs<'a>(
        &'a self,
        recorder: &mut Recorder<'a>,
        cloud: &'a DeviceCloud,
        Binned { binning, records, entries, .. }: &Binned,
    ) -> Result<(), Error> {
        let count = u64::from(*entries);
        let buffers = self.pairs.each_ref().map(|pairs| pairs.get().slice(0, count));
        // There may be fewer pairs than foreseen; what is none comes behind them.
        recorder.fill("bin/clear", buffers[0], u32::MAX)?;
        let pairs = Pairs {
            view: cloud.view(),
            records: self.records[*records].get().all(),
            bounds: cloud.bounds.all(),
            offsets: self.cursors.get().slice(0, binning.cells()),
            pairs: buffers[0],
        };
        recorder.run(&pairs, binning.push(), &Run::new(Dispatch::Invocations(binning.drawn)))?;
        let (bits, subgroup) = (binning.tile_bits(), binning.lanes.subgroup);
        let values = self.entries.get().slice(0, count);
        Ok(self.radix.record_values(recorder, buffers, bits, subgroup, values)?)
    }

    pub(super) fn record_tile_store<'a>(
        &'a self,
        recorder: &mut Recorder<'a>,
        cloud: &'a DeviceCloud,
        Binned { binning, records, .. }: &Binned,
    ) -> Result<(), Error> {
        let store = TileStore {
            view: cloud.view(),
            records: self.records[*records].get().all(),
            bounds: cloud.bounds.all(),
            cursors: self.cursors.get().slice(0, binning.cells()),
            entries: self.entries.get().all(),
        };
        let run = Run::new(Dispatch::Groups(binning.groups()));
        recorder.run(&store, binning.push(), &run.variant(store_variant(binning.lanes.subgroup)))?;
        // Each cell ends where the next one began; the last one is empty and has kept its cursor, the total.
        let inner = binning.cells() - 1;
        let (cursors, counts) = (self.cursors.get(), self.counts.get().slice(1, inner));
        let next = Expected::Below { ends: cursors.slice(1, inner), counts };
        Ok(recorder.agree("bin/tile-store", "run of a tile", cursors.slice(0, inner), next)?)
    }
}

/// Returns the variant of `bin/tile-count`, by whether pairs of tile and splat are sorted.
pub(super) fn count_variant(pairs: bool) -> Variant {
    Variant::plain().with("PAIRS", u32::from(pairs))
}

/// Returns the variant of `bin/tile-store`.
pub(super) fn store_variant(subgroup: u32) -> Variant {
    let [columns, rows] = pattern(subgroup);
    Variant::plain().subgroup(subgroup).constant("LANE_COLUMNS", columns).constant("LANE_ROWS", rows)
}
