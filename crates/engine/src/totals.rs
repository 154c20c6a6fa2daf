//! The device time of frames as whole ones, at a steady clock: warmed up by time, without timestamps between passes,
//! and between two calibrations.

use std::time::{Duration, Instant};

use serde_json::{Value, json};

use crate::gpu::{Calibration, Yardstick};
use crate::methods::{Error, Frame, Rendered, Renderer};
use crate::passes::project::DeviceCloud;

/// Length of a measurement.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Effort {
    /// Frames are rendered for so long before any counts: clocks of an idle GPU take a while to rise.
    pub warm_up: Duration,
    /// Number of frames that count.
    pub frames: usize,
    /// No frame that counts begins later than this after the first; at least one counts.
    pub limit: Duration,
}

impl Effort {
    /// A reliable measurement: 0.3 s of warm-up, then 30 frames, or those that begin within 2 s.
    pub const RELIABLE: Self = Self { warm_up: Duration::from_millis(300), frames: 30, limit: Duration::from_secs(2) };
    /// A look that only shows that everything works: a warm frame and three that count.
    pub const LOOK: Self = Self { warm_up: Duration::ZERO, frames: 3, limit: Duration::from_millis(500) };
}

/// Least, middle and nearly greatest time of frames, in milliseconds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrameTimes {
    /// Number of times.
    pub count: usize,
    /// Least time.
    pub min: f64,
    /// Median.
    pub median: f64,
    /// Smallest of the times that at least 95 % of them don't exceed.
    pub p95: f64,
}

impl FrameTimes {
    /// Returns those of some frames in milliseconds; zeros if there are none.
    pub fn of(times: impl IntoIterator<Item = f64>) -> Self {
        let mut times: Vec<f64> = times.into_iter().collect();
        times.sort_by(f64::total_cmp);
        let count = times.len();
        // ⌈0.95 n⌉-th of n, in whole numbers.
        let p95 = (95 * count).div_ceil(100).checked_sub(1).map_or(0.0, |place| times[place]);
        let at = |place: usize| times.get(place).copied().unwrap_or(0.0);
        // The middle one, or the mean of both.
        let median = 0.5 * (at(count.saturating_sub(1) / 2) + at(count / 2));
        Self { count, min: at(0), median, p95 }
    }
}

/// Times of frames, and of a fixed amount of work before and after them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Totals {
    /// Device time of each frame as a whole.
    pub device: FrameTimes,
    /// Time of each frame from its first submission to the end of its read-back.
    pub wall: FrameTimes,
    /// Most submissions that the host waited for in a frame.
    pub waits: u64,
    /// Calibrations before and after the frames; `None` if there were none.
    pub calibration: Option<[Calibration; 2]>,
}

impl Totals {
    /// Returns `false` if the device's clock moved meanwhile: the times must not be used.
    pub fn is_steady(&self) -> bool {
        self.calibration.is_none_or(|[before, after]| before.agrees(&after))
    }

    /// Returns a line for people.
    pub fn line(&self) -> String {
        let FrameTimes { count, min, median, p95 } = self.device;
        let moved = if self.is_steady() { "" } else { "; the device's clock moved meanwhile: don't use these times" };
        format!("at a steady clock: min {min:.2}, median {median:.2}, 95% up to {p95:.2} ms of {count} frame(s){moved}")
    }

    /// Returns the times as JSON: `frames`, `min_ms`, `median_ms` and `p95_ms` of the device, `wall_ms` (median),
    /// `waits`, `calibration_ms` (before and after, each of computing and of copying) and `calibrated`, false if the
    /// times must not be used.
    pub fn to_json(&self) -> Value {
        let ms = |time: Duration| time.as_secs_f64() * 1e3;
        json!({
            "frames": self.device.count,
            "min_ms": self.device.min,
            "median_ms": self.device.median,
            "p95_ms": self.device.p95,
            "wall_ms": self.wall.median,
            "waits": self.waits,
            "calibration_ms": self.calibration.map(|both| both.map(|c| [ms(c.spin), ms(c.copy)])),
            "calibrated": self.is_steady(),
        })
    }
}

/// Renders a frame again and again, without anything else on the host between two of them, and returns its times.
/// Counts are foreseen from the third frame on. Without a yardstick nobody looks at the clock.
///
/// # Errors
/// The errors of [`Renderer::render`].
pub fn measure(
    renderer: &mut Renderer,
    cloud: &mut DeviceCloud,
    frame: &Frame,
    yardstick: Option<&Yardstick>,
    effort: Effort,
) -> Result<Totals, Error> {
    let mut one = || -> Result<Rendered, Error> {
        let mut rendered = renderer.render_whole(cloud, frame)?;
        renderer.recycle(std::mem::take(&mut rendered.image));
        Ok(rendered)
    };
    let begin = Instant::now();
    // Two more after the first, which waits for its counts, unless they take long.
    for number in 0.. {
        let passed = begin.elapsed();
        if number > 0 && passed >= effort.warm_up && (number > 2 || passed >= effort.limit) {
            break;
        }
        one()?;
    }
    let before = yardstick.map(Yardstick::measure).transpose()?;
    let begin = Instant::now();
    let mut rendered = Vec::new();
    while rendered.len() < effort.frames && (rendered.is_empty() || begin.elapsed() < effort.limit) {
        rendered.push(one()?.profile);
    }
    let after = yardstick.map(Yardstick::measure).transpose()?;
    let ms = |time: Duration| time.as_secs_f64() * 1e3;
    Ok(Totals {
        device: FrameTimes::of(rendered.iter().map(|profile| ms(profile.total.unwrap_or_default()))),
        wall: FrameTimes::of(rendered.iter().map(|profile| ms(profile.wall))),
        waits: rendered.iter().map(|profile| profile.waits).max().unwrap_or(0),
        calibration: before.zip(after).map(<[Calibration; 2]>::from),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn numbers(n: usize) -> impl Iterator<Item = f64> {
        // In no order: 7 and n have no common divisor.
        (0..n).map(move |i| (7 * i % n) as f64 + 1.0)
    }

    #[test]
    fn spreads_by_hand() {
        let spread = |count, min, median, p95| FrameTimes { count, min, median, p95 };
        assert_eq!(FrameTimes::of([]), spread(0, 0.0, 0.0, 0.0));
        assert_eq!(FrameTimes::of([3.0]), spread(1, 3.0, 3.0, 3.0));
        // 95 % of 20 are 19, and of 30 are 28.5.
        assert_eq!(FrameTimes::of(numbers(20)), spread(20, 1.0, 10.5, 19.0));
        assert_eq!(FrameTimes::of(numbers(30)), spread(30, 1.0, 15.5, 29.0));
        assert_eq!(FrameTimes::of(numbers(100)), spread(100, 1.0, 50.5, 95.0));
    }

    #[test]
    fn the_three_numbers_of_a_spread_never_decrease() {
        for count in (1..60).filter(|count| count % 7 != 0) {
            let FrameTimes { min, median, p95, .. } = FrameTimes::of(numbers(count));
            assert!(min <= median && median <= p95 && p95 <= count as f64, "{count}: {min} {median} {p95}");
        }
    }

    #[test]
    fn times_between_calibrations_that_differ_are_marked() {
        let calibration = |spin| Calibration { spin: Duration::from_micros(spin), copy: Duration::from_micros(500) };
        let times = FrameTimes::of([2.0, 1.0, 4.0]);
        let between = |after| Totals {
            device: times,
            wall: times,
            waits: 1,
            calibration: Some([calibration(1000), calibration(after)]),
        };
        assert!(between(1040).is_steady() && !between(1060).is_steady() && !between(940).is_steady());
        assert!(Totals { calibration: None, ..between(2000) }.is_steady(), "nobody looked");
        let line = "at a steady clock: min 1.00, median 2.00, 95% up to 4.00 ms of 3 frame(s)";
        assert_eq!(between(1000).line(), line);
        assert_eq!(between(2000).line(), format!("{line}; the device's clock moved meanwhile: don't use these times"));
        assert_eq!(
            between(2000).to_json(),
            json!({
                "frames": 3, "min_ms": 1.0, "median_ms": 2.0, "p95_ms": 4.0, "wall_ms": 2.0, "waits": 1,
                "calibration_ms": [[1.0, 0.5], [2.0, 0.5]], "calibrated": false,
            })
        );
    }
}
