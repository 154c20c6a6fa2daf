//! Exclusive prefix sums of any length by reduce-then-scan; sums over 32 bits are detected.

use crate::gpu::shader::Shader;
use crate::gpu::{Buffer, Device, Dispatch, Error, Memory, Recorder, Run, Slice, Variant};
use crate::{gpu_struct, pass};

/// Elements of one run: the loop of one invocation, and the factor from level to level.
const RUN: u64 = 64;

gpu_struct! {
    /// Push constants: how many elements.
    pub struct ScanPush {
        /// Elements.
        count: u32,
    }
}

pass! {
    /// Sums runs of 64 counters, level by level. A carry out of 32 bits sets the overflow flag.
    pub Reduce(ScanPush) = "scan/reduce" {
        values: Read<u32>,
        sums: ReadWrite<u32>,
        overflow: ReadWrite<u32>,
    }
}

pass! {
    /// Writes the prefix sums of each run from the level above. It serves pixels, tiles of large splats, digits and
    /// tiles of ordered splats, and so does `scan/reduce`.
    pub Spread(ScanPush) = "scan/spread" {
        values: Read<u32>,
        starts: Read<u32>,
        offsets: ReadWrite<u32>,
        overflow: ReadWrite<u32>,
    }
}

/// The variants that a scan uses.
pub fn variants() -> [Variant; 2] {
    [0.0, 1.0].map(|top| Variant::plain().with("RUN", RUN as f64).with("TOP", top))
}

/// Buffers of a scan of up to `capacity` elements.
pub struct Scan {
    /// Sums and their prefix sums, level by level.
    levels: Vec<[Buffer<u32>; 2]>,
    capacity: u64,
}

impl Scan {
    /// Room for scans of up to `capacity` elements.
    pub fn new(device: &Device, capacity: u64) -> Result<Self, Error> {
        let mut levels = Vec::new();
        let mut len = capacity;
        while len > RUN {
            len = len.div_ceil(RUN);
            levels.push([
                device.buffer("scan sums", len, Memory::Device)?,
                device.buffer("scan offsets", len, Memory::Device)?,
            ]);
        }
        Ok(Self { levels, capacity })
    }

    /// Device bytes that a scan of `capacity` elements needs.
    pub fn bytes(capacity: u64) -> u64 {
        capacity.div_ceil(RUN) * 8 * 2
    }

    /// How many elements fit.
    pub fn capacity(&self) -> u64 {
        self.capacity
    }

    /// Records `offsets[i] = values[0] + … + values[i − 1]`. A sum over 32 bits sets `overflow[0]`, which must be zero before.
    pub fn record<'a>(
        &'a self,
        recorder: &mut Recorder<'a>,
        values: Slice<'a, u32>,
        offsets: Slice<'a, u32>,
        overflow: Slice<'a, u32>,
    ) -> Result<(), Error> {
        assert!(values.len() <= self.capacity, "scan of {} elements, room for {}", values.len(), self.capacity);
        let [inner, top] = variants();
        let push = |len: u64| ScanPush { count: len as u32 };
        let run =
            |len: u64, variant: &Variant| Run::new(Dispatch::Invocations(len.div_ceil(RUN))).variant(variant.clone());
        // Up: each level holds the sums of the one below.
        let mut lens = vec![values.len()];
        let mut current = values;
        for [sums, _] in &self.levels {
            let len = current.len();
            if len <= RUN {
                break;
            }
            let sums = sums.slice(0, len.div_ceil(RUN));
            let reduce = Reduce { values: current, sums, overflow };
            let over = Run::new(Dispatch::Invocations(sums.len()));
            recorder.run(&reduce, push(len), &over.variant(Variant::plain().with("RUN", RUN as f64)))?;
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
            // The top has one run, which starts at zero; `starts` is then bound but not read.
            let (starts, variant) =
                if level == depth { (values, &top) } else { (self.levels[level][1].slice(0, lens[level + 1]), &inner) };
            recorder.run(&Spread { values, starts, offsets: out, overflow }, push(len), &run(len, variant))?;
        }
        Ok(())
    }
}

/// The passes with their variants.
pub fn shaders() -> Vec<Shader> {
    vec![Shader::new::<Reduce>([Variant::plain().with("RUN", RUN as f64)]), Shader::new::<Spread>(variants())]
}
