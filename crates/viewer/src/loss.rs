//! Decides if a lost device is worth opening again.

use std::time::{Duration, Instant};

use pellucid_engine::Error;
use pellucid_gpu as gpu;

/// A device that lasts for no longer than this is not opened another time.
const PATIENCE: Duration = Duration::from_secs(10);

/// The operation during which the device was lost, if the error says that it was.
pub fn during(error: &Error) -> Option<&str> {
    match error {
        Error::Gpu(gpu::Error::Lost { during }) => Some(during),
        Error::Render(pellucid_engine::methods::Error::Gpu(gpu::Error::Lost { during })) => Some(during),
        _ => None,
    }
}

/// Record of the last loss of the device.
#[derive(Debug, Default)]
pub struct Losses {
    /// Time at which the device was there again, and the picture that was on the screen before.
    last: Option<(Instant, Option<u64>)>,
}

impl Losses {
    /// Decides if a device that is lost now is opened again; `shown` is the serial of the picture on the screen. It is
    /// not if the device lasted only a moment or showed no new picture.
    pub fn allow(&self, now: Instant, shown: Option<u64>) -> bool {
        self.last.is_none_or(|(at, before)| now >= at + PATIENCE && shown != before)
    }

    /// Records that the device was opened again.
    pub fn opened(&mut self, now: Instant, shown: Option<u64>) {
        self.last = Some((now, shown));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_device_that_does_not_last_is_not_opened_for_ever() {
        let start = Instant::now();
        let after = |seconds| start + Duration::from_secs(seconds);
        let mut losses = Losses::default();
        assert!(losses.allow(start, None), "the first time");
        losses.opened(after(1), None);
        assert!(!losses.allow(after(3), Some(1)), "within ten seconds");
        assert!(!losses.allow(after(100), None), "without a picture");
        assert!(losses.allow(after(12), Some(1)));
        losses.opened(after(13), Some(1));
        assert!(!losses.allow(after(100), Some(1)), "the picture from before");
        assert!(losses.allow(after(100), Some(2)));
    }

    #[test]
    fn a_loss_is_known_wherever_it_comes_from() {
        let lost = || gpu::Error::Lost { during: "a sort".into() };
        assert_eq!(during(&lost().into()), Some("a sort"));
        assert_eq!(during(&pellucid_engine::methods::Error::from(lost()).into()), Some("a sort"));
        assert_eq!(during(&gpu::Error::NoDevice.into()), None);
    }
}
