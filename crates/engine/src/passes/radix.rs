//! Stable radix sort of records (key, value) by their keys (Satish, Harris, Garland 2009): count, scan, scatter per
//! digit.
//!
//! Records are cut into runs; a subgroup takes each run in order. Within a step, invocations rank equal digits by
//! shuffles. No barrier, no shared memory, no forward progress between workgroups.

use super::scan::Scan;
use crate::gpu::shader::{SUBGROUPS, Shader};
use crate::gpu::{Device, Dispatch, Error, Expected, Memory, Preferences, Recorder, Run, Scratch, Slice, Variant};
use crate::{fields, gpu_struct, pass};

gpu_struct! {
    /// Push constants: records, how they are cut, and the digit.
    pub struct RadixPush {
        count: u32,
        runs: u32,
        run_length: u32,
        shift: u32,
        mask: u32, // Values of a digit, less one.
    }
}

pass! {
    /// Counts the records of each run by their digit, straight into their counters or in the memory of a workgroup
    /// first (`radix/count_group`), whichever the device prefers; runs once for each digit.
    pub Count(RadixPush) = "radix/count",
    /// Counts the records of each run by their digit, in the memory of the run's workgroup first.
    pub CountGroup(RadixPush) = "radix/count" in "radix/count_group" {
        records: Read<[u32; 2]>,
        counts: ReadWrite<u32>,
    }

    /// Moves each record to its place among those of its digit: one subgroup per run, in order; runs once for each
    /// digit. Where nobody asks for keys, the last run moves values alone. If the device prefers it, the places of four
    /// runs are in the memory of a workgroup (`radix/scatter_group`).
    pub Scatter(RadixPush) = "radix/scatter" with "moved_records" {
        records: Read<[u32; 2]>,
        cursors: ReadWrite<u32>,
        moved: ReadWrite<[u32; 2]>,
    }

    /// Moves each record to its place, with several runs in a workgroup whose memory holds their places.
    pub ScatterGroup(RadixPush) = "radix/scatter" in "radix/scatter_group" with "moved_records" {
        records: Read<[u32; 2]>,
        cursors: ReadWrite<u32>,
        moved: ReadWrite<[u32; 2]>,
    }

    /// Moves the value of each record to its place among those of its digit.
    pub ScatterValues(RadixPush) = "radix/scatter" in "radix/scatter" with "moved_values" {
        records: Read<[u32; 2]>,
        cursors: ReadWrite<u32>,
        moved: ReadWrite<u32>,
    }

    /// Moves the value of each record to its place, like `ScatterGroup`.
    pub ScatterGroupValues(RadixPush) = "radix/scatter" in "radix/scatter_group" with "moved_values" {
        records: Read<[u32; 2]>,
        cursors: ReadWrite<u32>,
        moved: ReadWrite<u32>,
    }
}

/// Widest digit in bits.
const MOST_BITS: u32 = 9;
/// Narrowest.
const LEAST_BITS: u32 = 4;
/// Subgroups below this size find equal digits by shuffles, larger ones by ballots.
const MOST_SHUFFLED: u32 = 16;

/// Subgroups of a workgroup, each with a run of its own, where they share work: no device has room for less than 128
/// invocations and 16 KiB.
const TEAM: u32 = 4;

/// Constants that shaders share with this module.
pub(crate) const CONSTANTS: [(&str, u32); 2] = [("DIGIT_VALUES", 1 << MOST_BITS), ("MOST_SHUFFLED", MOST_SHUFFLED)];

/// Division of records into runs, each of which one subgroup takes in order.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Runs {
    /// Number of runs.
    pub runs: u32,
    /// Records of each but the last.
    pub length: u32,
}

impl Runs {
    /// Divides records into as many runs as keep the device busy, but none shorter than pays, and none longer than an
    /// invocation may loop.
    pub fn new(concurrent: u64, records: u64, shortest: u64, longest: u64) -> Self {
        let length = records.div_ceil(concurrent).clamp(shortest, longest);
        Self { runs: records.div_ceil(length).max(1) as u32, length: length as u32 }
    }
}

/// Division of keys into digits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Digits {
    /// Number of digits; records are sorted once by each.
    pub digits: u32,
    /// Bits of each.
    pub bits: u32,
    /// Counters, one for each run and value of a digit.
    pub counters: u64,
}

impl Digits {
    /// Divides keys of `bits` bits into as few digits as can be without more counters than records.
    pub fn new(device: &Device, records: u64, bits: u32) -> Self {
        Self::of(device.info().prefers, records, bits)
    }

    fn of(prefers: Preferences, records: u64, bits: u32) -> Self {
        let cut = runs(prefers, records);
        let digits = bits.div_ceil(widest(cut, records)).max(1);
        let bits = bits.div_ceil(digits);
        Self { digits, bits, counters: u64::from(cut.runs) << bits }
    }
}

fields! {
    /// Buffers of a sort, kept from frame to frame.
    pub struct Radix by device {
        prefers: Preferences = device.info().prefers,
        counts: Scratch<u32> = Scratch::new("digit counts", Memory::Device),
        cursors: Scratch<u32> = Scratch::new("digit cursors", Memory::Device),
        scan: Scan = Scan::new(device, 0)?,
    }
}

impl Radix {
    /// Returns the number of device bytes of a sort of so many records, the records themselves not counted.
    pub fn bytes(device: &Device, records: u64) -> u64 {
        let counters = counters(device.info().prefers, records);
        counters * 8 + Scan::bytes(counters)
    }

    /// Returns the number of device bytes of the buffers that are kept.
    pub fn kept_bytes(&self) -> u64 {
        self.counts.bytes() + self.cursors.bytes() + self.scan.kept_bytes()
    }

    /// Makes room for a sort of so many records.
    pub fn reserve(&mut self, device: &Device, records: u64) -> Result<(), Error> {
        let counters = counters(self.prefers, records);
        self.counts.reserve(device, counters)?;
        self.cursors.reserve(device, counters)?;
        self.scan.reserve(device, counters)
    }

    /// Records a sort by the lowest `bits` of the keys, of all records of the first buffer; both are overwritten.
    /// Returns the index of the one that holds the result. Subgroups have `subgroup` invocations.
    pub fn record<'a>(
        &'a self,
        recorder: &mut Recorder<'a>,
        buffers: [Slice<'a, [u32; 2]>; 2],
        bits: u32,
        subgroup: u32,
    ) -> Result<usize, Error> {
        self.record_digits(recorder, buffers, bits, subgroup, None)
    }

    /// Records the same sort where only the values are asked for, as many as there are records.
    pub fn record_values<'a>(
        &'a self,
        recorder: &mut Recorder<'a>,
        buffers: [Slice<'a, [u32; 2]>; 2],
        bits: u32,
        subgroup: u32,
        values: Slice<'a, u32>,
    ) -> Result<(), Error> {
        assert_eq!(values.len(), buffers[0].len(), "a value for each record");
        self.record_digits(recorder, buffers, bits, subgroup, Some(values)).map(drop)
    }

    fn record_digits<'a>(
        &'a self,
        recorder: &mut Recorder<'a>,
        buffers: [Slice<'a, [u32; 2]>; 2],
        bits: u32,
        subgroup: u32,
        values: Option<Slice<'a, u32>>,
    ) -> Result<usize, Error> {
        let [mut records, mut moved] = buffers;
        let Runs { runs, length } = runs(self.prefers, records.len());
        let Digits { digits, bits: digit_bits, counters } = Digits::of(self.prefers, records.len(), bits);
        for digit in 0..digits {
            let mask = (1 << digit_bits) - 1;
            let push =
                RadixPush { count: records.len() as u32, runs, run_length: length, shift: digit * digit_bits, mask };
            let (counts, cursors) = (self.counts.get().slice(0, counters), self.cursors.get().slice(0, counters));
            let over = Run::new(Dispatch::Groups(u64::from(runs)));
            if self.prefers.shared_work {
                // A workgroup writes every counter of its run.
                recorder.run(&CountGroup { records, counts }, push, &over)?;
            } else {
                recorder.fill("radix/clear", counts, 0)?;
                recorder.run(&Count { records, counts }, push, &over)?;
            }
            self.scan.record(recorder, counts, cursors)?;
            let shared = self.prefers.shared_work;
            let (team, variant) = match shared {
                false => (1, scatter_variant(subgroup)),
                true => (TEAM, scatter_group_variant(subgroup)),
            };
            let run = Run::new(Dispatch::Groups(u64::from(runs.div_ceil(team)))).variant(variant);
            match (values.filter(|_| digit + 1 == digits), shared) {
                (Some(moved), false) => recorder.run(&ScatterValues { records, cursors, moved }, push, &run)?,
                (Some(moved), true) => recorder.run(&ScatterGroupValues { records, cursors, moved }, push, &run)?,
                (None, false) => recorder.run(&Scatter { records, cursors, moved }, push, &run)?,
                (None, true) => recorder.run(&ScatterGroup { records, cursors, moved }, push, &run)?,
            }
            agree(recorder, counts, cursors, push.count)?;
            (records, moved) = (moved, records);
        }
        Ok(digits as usize % 2)
    }
}

/// Checks in debug builds that the cursors that `radix/scatter` left are those of the counts, of `records` records.
pub fn agree<'a>(
    recorder: &mut Recorder<'a>,
    counts: Slice<'a, u32>,
    cursors: Slice<'a, u32>,
    records: u32,
) -> Result<(), Error> {
    let inner = cursors.len() - 1;
    // The last one ends at the end; each of the others where the next one began.
    recorder.agree("radix/scatter", "digit of a run", cursors.skip(inner), Expected::Value(records))?;
    let next = Expected::Below { ends: cursors.skip(1), counts: counts.skip(1) };
    recorder.agree("radix/scatter", "digit of a run", cursors.first(inner), next)
}

fn runs(prefers: Preferences, records: u64) -> Runs {
    Runs::new(prefers.concurrent_runs, records, 1024, 1 << 17)
}

/// The widest digit whose counters do not outweigh the records.
fn widest(cut: Runs, records: u64) -> u32 {
    (records / u64::from(cut.runs)).max(1).ilog2().clamp(LEAST_BITS, MOST_BITS)
}

fn counters(prefers: Preferences, records: u64) -> u64 {
    let cut = runs(prefers, records);
    u64::from(cut.runs) << widest(cut, records)
}

/// Returns the variant of `radix/scatter`.
pub fn scatter_variant(subgroup: u32) -> Variant {
    Variant::plain().subgroup(subgroup).network(subgroup)
}

/// Returns the variant of `radix/scatter_group` for devices with subgroups of this size.
fn scatter_group_variant(subgroup: u32) -> Variant {
    scatter_variant(subgroup).constant("TEAM", TEAM)
}

/// Returns the passes with their variants.
pub fn shaders() -> Vec<Shader> {
    vec![
        Shader::plain::<Count>(),
        Shader::plain::<CountGroup>(),
        Shader::new::<Scatter>(SUBGROUPS.map(scatter_variant)),
        Shader::new::<ScatterValues>(SUBGROUPS.map(scatter_variant)),
        Shader::new::<ScatterGroup>(SUBGROUPS.map(scatter_group_variant)),
        Shader::new::<ScatterGroupValues>(SUBGROUPS.map(scatter_group_variant)),
    ]
}
