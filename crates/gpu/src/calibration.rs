//! A fixed amount of work, whose time says how fast the device is at the moment: clocks change, and other programs may
//! share the device.

use std::time::Duration;

use super::{Buffer, Device, Dispatch, Error, Memory, Run};
use crate::{gpu_struct, pass};

gpu_struct! {
    /// Push constants: how many words, and the length of each chain.
    pub struct SpinPush {
        count: u32,
        steps: u32,
    }
}

pass! {
    @from crate::SHADERS;
    /// Computes a fixed chain of integer operations for each word, to see how fast the device computes.
    pub Spin(SpinPush) = "calibration/spin" {
        words: ReadWrite<u32>,
    }
}

/// Chains of a calibration.
const CHAINS: u32 = 1 << 18;
/// Steps of each chain on a driver for CPUs, some milliseconds, and on a GPU, a fraction of one if it is fast.
/// Preferences don't change them: the work is the same whenever a device is measured.
const STEPS: [u32; 2] = [64, 16384];
/// Runs of the work, the fastest of which counts: the others were disturbed.
const RUNS: usize = 5;
/// Largest ratio, less one, of two times of the same work at the same clock.
const STEADY: f64 = 0.05;
/// Least and most bytes of the copy: more than the caches of most devices, less than a frame of a large cloud.
const COPY_BYTES: [u64; 2] = [16 << 20, 256 << 20];
/// The copy takes this part of the device's memory within these bounds.
const HEAP_SHARE: u64 = 256;

/// Fixed work on a device.
pub struct Yardstick {
    device: Device,
    words: Buffer<u32>,
    from: Buffer<u32>,
    to: Buffer<u32>,
}

/// Times of the fixed work.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Calibration {
    /// Time of the chains, which follows the clock of the cores.
    pub spin: Duration,
    /// Time of the copy, which follows the clock of the memory.
    pub copy: Duration,
}

impl Calibration {
    /// Returns by how much the two times differ from those of another calibration: the larger of both ratios, less
    /// one. At least 0, and infinite if one of the times is 0 and the other is not.
    pub fn moved(&self, other: &Self) -> f64 {
        let ratio = |a: Duration, b: Duration| {
            let (a, b) = (a.as_secs_f64(), b.as_secs_f64());
            if a == b { 0.0 } else { a.max(b) / a.min(b) - 1.0 }
        };
        ratio(self.spin, other.spin).max(ratio(self.copy, other.copy))
    }

    /// Returns `true` if the device was as fast for both, within 5 %: times between them can be compared.
    pub fn agrees(&self, other: &Self) -> bool {
        self.moved(other) <= STEADY
    }
}

impl Yardstick {
    /// Reserves the memory, at most 512 MiB.
    ///
    /// # Errors
    /// Returns an error if the device has no room for it.
    pub fn new(device: &Device) -> Result<Self, Error> {
        let limits = device.limits();
        let [least, most] = COPY_BYTES;
        let bytes = (limits.heap_bytes / HEAP_SHARE).clamp(least, most).min(limits.allocation_bytes) / 4 * 4;
        let words = device.buffer("calibration words", u64::from(CHAINS), Memory::Device)?;
        let from = device.buffer("calibration source", bytes / 4, Memory::Device)?;
        let to = device.buffer("calibration target", bytes / 4, Memory::Device)?;
        Ok(Self { device: device.clone(), words, from, to })
    }

    /// Returns the number of bytes that are copied, each read once and written once.
    pub fn copied_bytes(&self) -> u64 {
        4 * self.from.len()
    }

    /// Returns the number of bytes of device memory that it holds.
    pub fn bytes(&self) -> u64 {
        self.words.bytes() + self.from.bytes() + self.to.bytes()
    }

    /// Returns the number of integer operations of all chains together, four for each step.
    pub fn operations(&self) -> u64 {
        4 * u64::from(CHAINS) * u64::from(self.steps())
    }

    /// Returns the number of steps of each chain.
    #[doc(hidden)]
    pub fn steps(&self) -> u32 {
        STEPS[usize::from(!self.device.info().is_cpu())]
    }

    /// Returns the ends of the chains of the last [`Self::measure`], for tests.
    ///
    /// # Errors
    /// Vulkan errors.
    #[doc(hidden)]
    pub fn ends(&self) -> Result<Vec<u32>, Error> {
        self.words.read(0, self.words.len())
    }

    /// Does the work several times in one submission, and returns the least time of each part.
    ///
    /// # Errors
    /// Vulkan errors.
    pub fn measure(&self) -> Result<Calibration, Error> {
        let mut recorder = self.device.recorder()?;
        let push = SpinPush { count: CHAINS, steps: self.steps() };
        recorder.fill("calibration/fill", self.from.all(), 0)?;
        for _ in 0..RUNS {
            let run = Run::new(Dispatch::Invocations(u64::from(CHAINS)));
            recorder.run(&Spin { words: self.words.all() }, push, &run)?;
            recorder.copy("calibration/copy", self.from.all(), self.to.all())?;
        }
        let submitted = recorder.submit("calibration")?;
        let least = |name: &str| {
            let times = submitted.passes.iter().filter(|pass| pass.name == name).map(|pass| pass.gpu);
            times.min().unwrap_or_default()
        };
        Ok(Calibration { spin: least("calibration/spin"), copy: least("calibration/copy") })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn times(spin: u64, copy: u64) -> Calibration {
        Calibration { spin: Duration::from_micros(spin), copy: Duration::from_micros(copy) }
    }

    #[test]
    fn a_calibration_that_moved_by_more_than_a_twentieth_disagrees() {
        let before = times(1000, 200);
        assert!(before.agrees(&times(1000, 200)) && before.moved(&before) == 0.0);
        // 5 % exactly, in either direction.
        assert!(before.agrees(&times(1050, 200)) && times(1050, 200).agrees(&before));
        assert!(!before.agrees(&times(1051, 200)) && !times(1051, 200).agrees(&before));
        // The memory's clock alone.
        assert!(!before.agrees(&times(1000, 211)) && (before.moved(&times(1000, 250)) - 0.25).abs() < 1e-12);
        // A device without a clock.
        assert_eq!(times(0, 0).moved(&times(0, 0)), 0.0);
        assert_eq!(times(0, 200).moved(&before), f64::INFINITY);
    }
}
