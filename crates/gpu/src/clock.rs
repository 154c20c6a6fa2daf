//! The clock of timestamps: how long passes took, and when they ran by the host's clock
//! (VK_KHR_calibrated_timestamps, VK_EXT_calibrated_timestamps).

use std::time::{Duration, Instant};

use ash::{ext, khr, vk};

use super::instance::Instance as Vulkan;
use super::limits::has_extension;

/// Counter of a queue's timestamps.
#[derive(Debug, Clone, Copy)]
pub struct Clock {
    /// Bits that count; the counter begins anew at zero after all of them were set.
    mask: u64,
    /// Nanoseconds of one tick.
    period_ns: f64,
}

impl Clock {
    /// Returns a counter of `bits` bits (timestampValidBits), 1 to 64, with ticks of `period_ns` nanoseconds.
    pub fn new(bits: u32, period_ns: f64) -> Self {
        Self { mask: u64::MAX >> 64u32.saturating_sub(bits).min(63), period_ns }
    }

    /// Returns the counter of a queue of this family.
    pub fn of(instance: &ash::Instance, physical: vk::PhysicalDevice, family: u32, period_ns: f64) -> Self {
        // SAFETY: a plain query on a live instance.
        let families = unsafe { instance.get_physical_device_queue_family_properties(physical) };
        Self::new(families.get(family as usize).map_or(64, |family| family.timestamp_valid_bits), period_ns)
    }

    /// Returns the ticks from one stamp to another, negative if `to` is the earlier one. Of two ways around the counter
    /// it is the shorter one.
    fn ticks(self, from: u64, to: u64) -> f64 {
        let forward = to.wrapping_sub(from) & self.mask;
        if forward <= self.mask / 2 { forward as f64 } else { -((from.wrapping_sub(to) & self.mask) as f64) }
    }

    /// Returns the time from one stamp to another; zero if `end` is the earlier one.
    pub fn between(self, [begin, end]: [u64; 2]) -> Duration {
        Duration::from_nanos((self.ticks(begin, end) * self.period_ns) as u64)
    }
}

/// Reading of both clocks at one time.
#[derive(Debug, Clone, Copy)]
pub struct ClockReading {
    ticks: u64,
    at: Instant,
}

impl ClockReading {
    /// Returns the host's time of a stamp.
    pub fn time_of(self, clock: Clock, stamp: u64) -> Instant {
        let nanos = clock.ticks(self.ticks, stamp) * clock.period_ns;
        let distance = Duration::from_nanos(nanos.abs() as u64);
        let moved = if nanos < 0.0 { self.at.checked_sub(distance) } else { self.at.checked_add(distance) };
        moved.unwrap_or(self.at)
    }
}

/// Functions of the extension by the name under which a device has it.
#[derive(Clone)]
enum Functions {
    Khr(khr::calibrated_timestamps::Device),
    Ext(ext::calibrated_timestamps::Device),
}

/// Reads the device's clock and the host's together.
#[derive(Clone)]
pub struct Calibrator(Functions);

/// Readings, of which the quickest counts.
const READINGS: usize = 3;

impl Calibrator {
    /// Returns the extension's name; `None` where a device can't tell what its clock shows.
    pub fn extension(instance: &Vulkan, physical: vk::PhysicalDevice) -> Option<&'static std::ffi::CStr> {
        let has = |name| has_extension(&instance.raw, physical, name);
        // SAFETY: the extension is there; a plain query on a live instance.
        let domains = unsafe {
            if has(khr::calibrated_timestamps::NAME) {
                let loader = khr::calibrated_timestamps::Instance::new(&instance.entry, &instance.raw);
                loader.get_physical_device_calibrateable_time_domains(physical)
            } else if has(ext::calibrated_timestamps::NAME) {
                let loader = ext::calibrated_timestamps::Instance::new(&instance.entry, &instance.raw);
                loader.get_physical_device_calibrateable_time_domains(physical)
            } else {
                return None;
            }
        };
        let name = match has(khr::calibrated_timestamps::NAME) {
            true => khr::calibrated_timestamps::NAME,
            false => ext::calibrated_timestamps::NAME,
        };
        domains.is_ok_and(|domains| domains.contains(&vk::TimeDomainKHR::DEVICE)).then_some(name)
    }

    /// Returns the functions of a device that was made with this extension.
    pub fn new(instance: &Vulkan, device: &ash::Device, extension: &std::ffi::CStr) -> Self {
        Self(match extension == khr::calibrated_timestamps::NAME {
            true => Functions::Khr(khr::calibrated_timestamps::Device::new(&instance.raw, device)),
            false => Functions::Ext(ext::calibrated_timestamps::Device::new(&instance.raw, device)),
        })
    }

    /// Reads both clocks; `None` if the device fails to. The host's is read before and after the device's, so that
    /// their difference is known to half of the time between, whatever clocks the driver knows besides its own.
    pub fn read(&self) -> Option<ClockReading> {
        let wanted = [vk::CalibratedTimestampInfoKHR::default().time_domain(vk::TimeDomainKHR::DEVICE)];
        let mut best: Option<(Duration, ClockReading)> = None;
        for _ in 0..READINGS {
            let begin = Instant::now();
            // SAFETY: the extension is enabled, and the device knows this clock.
            let read = unsafe {
                match &self.0 {
                    Functions::Khr(functions) => functions.get_calibrated_timestamps(&wanted),
                    Functions::Ext(functions) => functions.get_calibrated_timestamps(&wanted),
                }
            };
            let took = begin.elapsed();
            let ticks = *read.ok()?.0.first()?;
            if best.is_none_or(|(least, _)| took < least) {
                best = Some((took, ClockReading { ticks, at: begin + took / 2 }));
            }
        }
        best.map(|(_, calibration)| calibration)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_counter_of_36_bits_that_begins_anew_between_two_stamps_counts_on() {
        let clock = Clock::new(36, 10.0);
        let last = (1u64 << 36) - 1;
        // 5 ticks to the last value, one to zero, 4 more.
        assert_eq!(clock.between([last - 5, 4]), Duration::from_nanos(100));
        assert_eq!(clock.between([4, 14]), Duration::from_nanos(100));
        assert_eq!(clock.between([4, 4]), Duration::ZERO);
    }

    #[test]
    fn an_end_before_its_begin_takes_no_time() {
        for bits in [36, 63, 64] {
            assert_eq!(Clock::new(bits, 1.0).between([1000, 999]), Duration::ZERO, "{bits} bits");
        }
        assert_eq!(Clock::new(64, 1.0).between([u64::MAX, 1]), Duration::from_nanos(2));
    }

    #[test]
    fn stamps_are_placed_before_and_after_the_reading() {
        let (clock, at) = (Clock::new(8, 1000.0), Instant::now() + Duration::from_secs(1));
        let calibration = ClockReading { ticks: 250, at };
        assert_eq!(calibration.time_of(clock, 240), at - Duration::from_micros(10));
        // The counter of 8 bits begins anew after 255.
        assert_eq!(calibration.time_of(clock, 4), at + Duration::from_micros(10));
        assert_eq!(calibration.time_of(clock, 250), at);
    }
}
