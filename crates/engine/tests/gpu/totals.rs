//! Frames measured as whole ones, between two runs of a fixed amount of work.

use std::time::Duration;

use pellucid_engine::methods::Renderer;
use pellucid_engine::totals::{self, Effort, Totals};
use pellucid_gpu::Yardstick;
use pellucid_scene::{Discs, Method};
use pellucid_testing::{frame, perspective, scene, soup, with_device};

/// The end of a chain, on the host.
fn end(first: u32, steps: u32) -> u32 {
    (0..steps).fold(first, |word, step| (word ^ (word >> 15)).wrapping_mul(0x2c1b_3c6d).wrapping_add(step))
}

#[test]
fn chains_of_a_calibration_end_where_those_of_the_host_do() {
    with_device(|device| {
        let yardstick = Yardstick::new(device).expect("fits");
        let found = yardstick.measure().expect("measured");
        assert!(!found.spin.is_zero() && !found.copy.is_zero(), "{found:?}");
        let ends = yardstick.ends().expect("readable");
        let steps = yardstick.steps();
        // Four operations a step.
        assert_eq!(yardstick.operations(), 4 * u64::from(steps) * ends.len() as u64);
        for place in [0, 1, 63, 64, 4097, ends.len() - 1] {
            assert_eq!(ends[place], end(place as u32, steps), "chain {place}");
        }
    });
}

#[test]
fn as_many_frames_count_as_are_asked_for_and_at_least_one() {
    with_device(|device| {
        let yardstick = Yardstick::new(device).expect("fits");
        let mut renderer = Renderer::new(device).expect("a renderer");
        let points = scene(&soup(3, 200, 0.02..0.1, 0.1..0.9, false));
        let mut cloud = renderer.upload(&points).expect("fits");
        let frame = frame(perspective(), [32, 24], Method::ABuffer(Discs::default()));
        let mut measure = |frames, limit| -> Totals {
            let effort = Effort { warm_up: Duration::ZERO, frames, limit };
            totals::measure(&mut renderer, &mut cloud, &frame, Some(&yardstick), effort).expect("measured")
        };
        let found = measure(4, Duration::from_secs(600));
        assert_eq!((found.device.count, found.wall.count), (4, 4));
        assert!(found.device.min > 0.0 && found.device.min <= found.device.median, "{found:?}");
        assert!(found.waits >= 1, "the picture came to the host");
        assert_eq!(measure(4, Duration::ZERO).device.count, 1);
    });
}
