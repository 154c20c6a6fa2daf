//! Exclusive prefix sums of any length by reduce-then-scan; sums over 32 bits are detected.

use crate::gpu::shader::Shader;
use crate::gpu::{Buffer, Device, Dispatch, Error, Memory, Recorder, Run, Slice, Variant};
use crate::{gpu_struct, pass};

/// Elements of one run where each invocation takes one, and of one that a workgroup shares: the factors from level to
/// level.
const SCAN_RUN: u64 = 64;
const GROUP_RUN: u64 = 2048;

/// Constants that shaders share with this module.
pub(crate) const CONSTANTS: [(&str, u32); 2] = [("SCAN_RUN", SCAN_RUN as u32), ("GROUP_RUN", GROUP_RUN as u32)];

gpu_struct! {
    /// Push constants: how many elements.
    pub struct ScanPush {
        count: u32,
    }
}

pass! {
    /// Sums runs of counters, level by level: of 64 by an invocation each, or of 2048 by a workgroup each
    /// (`scan/reduce_group`), whichever the device prefers. A carry out of 32 bits sets the overflow flag.
    pub Reduce(ScanPush) = "scan/reduce",
    /// Sums runs of 2048 counters, each by a workgroup.
    pub ReduceGroup(ScanPush) = "scan/reduce" in "scan/reduce_group" {
        values: Read<u32>,
        sums: ReadWrite<u32>,
        overflow: ReadWrite<u32>,
    }

    /// Writes the prefix sums of each run from the level above, over the same runs as `scan/reduce`. It serves pixels,
    /// tiles of large splats, digits and tiles of ordered splats, and so does `scan/reduce`.
    pub Spread(ScanPush) = "scan/spread",
    /// Writes the prefix sums of each run of 2048, each by a workgroup.
    pub SpreadGroup(ScanPush) = "scan/spread" in "scan/spread_group" {
        values: Read<u32>,
        starts: Read<u32>,
        offsets: ReadWrite<u32>,
        overflow: ReadWrite<u32>,
    }
}

/// Returns the variant of `scan/spread` at the top level, or at one below.
pub fn spread_variant(top: bool) -> Variant {
    Variant::plain().with("TOP", u32::from(top))
}

/// Buffers of a scan of up to `capacity` elements.
pub struct Scan {
    /// Sums and their prefix sums, level by level.
    levels: Vec<[Buffer<u32>; 2]>,
    capacity: u64,
    /// `true` if workgroups share runs.
    shared: bool,
    /// A flag that a sum over 32 bits sets; who reads it must make it zero before.
    pub overflow: Buffer<u32>,
}

impl Scan {
    /// Room for scans of up to `capacity` elements.
    pub fn new(device: &Device, capacity: u64) -> Result<Self, Error> {
        let overflow = device.buffer("scan overflow", 1, Memory::Device)?;
        let mut scan = Self { levels: Vec::new(), capacity: 0, shared: device.info().prefers.shared_work, overflow };
        scan.reserve(device, capacity)?;
        Ok(scan)
    }

    /// Makes room for scans of up to `capacity` elements.
    pub fn reserve(&mut self, device: &Device, capacity: u64) -> Result<(), Error> {
        if self.capacity >= capacity {
            return Ok(());
        }
        // Smaller buffers are freed before larger ones are made.
        (self.levels, self.capacity) = (Vec::new(), 0);
        let mut levels = Vec::new();
        let mut len = capacity;
        while len > run(self.shared) {
            len = len.div_ceil(run(self.shared));
            levels.push([
                device.buffer("scan sums", len, Memory::Device)?,
                device.buffer("scan offsets", len, Memory::Device)?,
            ]);
        }
        (self.levels, self.capacity) = (levels, capacity);
        Ok(())
    }

    /// Returns the elements that a scan takes in one run, without a level of sums above.
    pub(crate) fn run(device: &Device) -> u64 {
        run(device.info().prefers.shared_work)
    }

    /// Returns the number of device bytes that a scan of `capacity` elements needs at most.
    pub fn bytes(capacity: u64) -> u64 {
        capacity.div_ceil(SCAN_RUN) * 8 * 2
    }

    /// Returns the number of device bytes of the buffers that are kept.
    pub fn kept_bytes(&self) -> u64 {
        Self::bytes(self.capacity)
    }

    /// Records `offsets[i] = values[0] + … + values[i − 1]`. A sum over 32 bits sets `overflow[0]`.
    pub fn record<'a>(
        &'a self,
        recorder: &mut Recorder<'a>,
        values: Slice<'a, u32>,
        offsets: Slice<'a, u32>,
    ) -> Result<(), Error> {
        assert!(values.len() <= self.capacity, "scan of {} elements, room for {}", values.len(), self.capacity);
        let run = run(self.shared);
        // Up: each level holds the sums of the one below.
        let mut lens = vec![values.len()];
        let mut current = values;
        for [sums, _] in &self.levels {
            if current.len() <= run {
                break;
            }
            let sums = sums.slice(0, current.len().div_ceil(run));
            self.reduce(recorder, current, sums)?;
            lens.push(sums.len());
            current = sums;
        }
        // Down: each level starts its runs where the one above says.
        let depth = lens.len() - 1;
        for level in (0..=depth).rev() {
            let len = lens[level];
            let (values, out) = match level.checked_sub(1) {
                None => (values, offsets),
                Some(i) => (self.levels[i][0].slice(0, len), self.levels[i][1].slice(0, len)),
            };
            let starts = (level < depth).then(|| self.levels[level][1].slice(0, lens[level + 1]));
            self.spread(recorder, values, starts, out)?;
        }
        Ok(())
    }

    fn reduce<'a>(
        &'a self,
        recorder: &mut Recorder<'a>,
        values: Slice<'a, u32>,
        sums: Slice<'a, u32>,
    ) -> Result<(), Error> {
        let (push, overflow) = (ScanPush { count: values.len() as u32 }, self.overflow.all());
        if self.shared {
            let over = Run::new(Dispatch::Groups(sums.len()));
            return recorder.run(&ReduceGroup { values, sums, overflow }, push, &over);
        }
        recorder.run(&Reduce { values, sums, overflow }, push, &Run::new(Dispatch::Invocations(sums.len())))
    }

    /// The top has one run, which starts at zero: it has no `starts`.
    fn spread<'a>(
        &'a self,
        recorder: &mut Recorder<'a>,
        values: Slice<'a, u32>,
        starts: Option<Slice<'a, u32>>,
        offsets: Slice<'a, u32>,
    ) -> Result<(), Error> {
        let (push, overflow) = (ScanPush { count: values.len() as u32 }, self.overflow.all());
        let runs = values.len().div_ceil(run(self.shared));
        let variant = spread_variant(starts.is_none());
        // The shader does not read the binding then.
        let starts = starts.unwrap_or(values);
        if self.shared {
            let over = Run::new(Dispatch::Groups(runs)).variant(variant);
            return recorder.run(&SpreadGroup { values, starts, offsets, overflow }, push, &over);
        }
        let over = Run::new(Dispatch::Invocations(runs)).variant(variant);
        recorder.run(&Spread { values, starts, offsets, overflow }, push, &over)
    }
}

/// Elements of a run.
fn run(shared: bool) -> u64 {
    if shared { GROUP_RUN } else { SCAN_RUN }
}

/// Returns the passes with their variants.
pub fn shaders() -> Vec<Shader> {
    let spread = || [false, true].map(spread_variant);
    vec![
        Shader::plain::<Reduce>(),
        Shader::plain::<ReduceGroup>(),
        Shader::new::<Spread>(spread()),
        Shader::new::<SpreadGroup>(spread()),
    ]
}
