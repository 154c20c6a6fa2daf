//! Ways in which ranks share work: regions of an image, its random samples, or frames; and the choice of the one that
//! is expected to be fastest.

use std::fmt::Display;

use pellucid_engine::Result;
use pellucid_scene::Error;
use serde::{Deserialize, Serialize};

use super::cut::{Load, PIXEL, POINT};
use super::link::Link;
use crate::commands::mpi_args::Wanted;

/// Thing that the ranks share.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Share {
    /// Regions of each image.
    Windows,
    /// Ensembles or samples of each image.
    Samples,
    /// Whole images.
    Frames,
}

impl Display for Share {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Windows => "windows",
            Self::Samples => "ensembles",
            Self::Frames => "frames",
        })
    }
}

/// Nanoseconds of a fragment of `abuffer`: of one thread of lavapipe, and of a GPU (docs/measurements.md).
const FRAGMENT_NS: [f64; 2] = [57.0, 0.4];

/// Slots of `spbr` take as long as so many fragments.
const SLOT: f64 = 5.0;

/// Bytes of a pixel of an image, and of the sums of an ensemble or of a batch of samples.
const IMAGE_BYTES: f64 = 20.0;
const SUM_BYTES: f64 = 32.0;

/// Work that can be shared.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Job {
    /// The points and fragments of a frame.
    pub load: Load,
    /// Ensembles or samples of a frame, and how many of them a rank takes at least; `None` of methods that have none.
    pub samples: Option<[u32; 2]>,
    /// Points that `spbr` assigns to all ensembles; 0 for other methods.
    pub slots: u64,
    /// Images whose mean a frame is.
    pub images: u32,
    /// Frames.
    pub frames: usize,
    /// True if the device is a GPU.
    pub is_gpu: bool,
}

/// A way to share the work.
#[derive(Debug, Clone, PartialEq)]
pub struct Offer {
    pub share: Share,
    /// Expected seconds of all frames; `None` if the work cannot be shared in this way.
    pub seconds: Option<f64>,
    /// Reason for the estimate, or why the work cannot be shared in this way.
    pub why: String,
}

impl Job {
    /// Seconds of so many fragments in each image.
    fn seconds(&self, fragments: f64) -> f64 {
        f64::from(self.images) * fragments * FRAGMENT_NS[usize::from(self.is_gpu)] * 1e-9
    }

    /// Times that splats are visited.
    fn visits(&self) -> f64 {
        match self.samples {
            Some([samples, batch]) if self.slots == 0 => f64::from(samples.div_ceil(batch.max(1))),
            _ => 1.0,
        }
    }

    /// Seconds of a frame by one rank.
    pub fn alone(&self) -> f64 {
        let Load { points, fragments, pixels, .. } = self.load;
        let drawn = if self.slots > 0 { SLOT * self.slots as f64 } else { POINT * points + fragments * self.visits() };
        self.seconds(drawn + PIXEL * pixels)
    }

    fn windows(&self, ranks: usize, link: Link) -> Offer {
        let n = ranks as f64;
        // A rank that assigns points to ensembles tests all of them for each region.
        let indivisible = if self.slots > 0 { self.seconds(SLOT * self.slots as f64) } else { 0.0 };
        let work = indivisible + (self.alone() - indivisible) / n;
        let gather = link.seconds(n - 1.0, self.load.pixels * IMAGE_BYTES * (n - 1.0) / n);
        let seconds = self.frames as f64 * (work + gather);
        let all = if self.slots > 0 { "; each rank tests the points of all ensembles" } else { "" };
        Offer {
            share: Share::Windows,
            seconds: Some(seconds),
            why: format!("{} of work per frame on each rank{all}, {} to gather pixels", time(work), time(gather)),
        }
    }

    fn ensembles(&self, ranks: usize, link: Link) -> Offer {
        let share = Share::Samples;
        let Some([samples, least]) = self.samples else {
            return Offer { share, seconds: None, why: "the method draws no ensembles and no samples".to_owned() };
        };
        let n = ranks as f64;
        let parts = f64::from(samples.div_ceil(least.max(1)));
        // Every rank projects all points of a method of splats.
        let once = if self.slots > 0 { 0.0 } else { self.seconds(POINT * self.load.points) };
        let work = once + (self.alone() - once) * (parts / n).ceil() / parts;
        let sums = if self.slots > 0 { 1.0 } else { parts };
        let bytes = self.load.pixels * SUM_BYTES * sums * (n - 1.0) / if self.slots > 0 { 1.0 } else { n };
        let gather = f64::from(self.images) * link.seconds(n - 1.0, bytes);
        Offer {
            share,
            seconds: Some(self.frames as f64 * (work + gather)),
            why: format!("{} of work per frame on each rank, {} to gather sums", time(work), time(gather)),
        }
    }

    fn frames(&self, ranks: usize) -> Offer {
        let share = Share::Frames;
        if self.frames < 2 {
            return Offer { share, seconds: None, why: "there is one frame".to_owned() };
        }
        let each = self.frames.div_ceil(ranks);
        let seconds = each as f64 * self.alone();
        Offer { share, seconds: Some(seconds), why: format!("at most {each} of {} frames on a rank", self.frames) }
    }

    /// The ways to share the work, in the order of [`Wanted`].
    pub fn offers(&self, ranks: usize, link: Link) -> [Offer; 3] {
        [self.windows(ranks, link), self.ensembles(ranks, link), self.frames(ranks)]
    }

    /// The way that is wanted, or the one that is expected to be fastest.
    ///
    /// # Errors
    /// The work cannot be shared as wanted.
    pub fn choose(&self, wanted: Wanted, ranks: usize, link: Link) -> Result<Share> {
        let offers = self.offers(ranks, link);
        let share = match wanted {
            Wanted::Auto => {
                let fastest = offers.iter().filter_map(|offer| Some((offer.seconds?, offer.share)));
                return Ok(fastest.min_by(|a, b| a.0.total_cmp(&b.0)).map_or(Share::Windows, |(_, share)| share));
            }
            Wanted::Windows => Share::Windows,
            Wanted::Ensembles => Share::Samples,
            Wanted::Frames => Share::Frames,
        };
        match offers.iter().find(|offer| offer.share == share && offer.seconds.is_none()) {
            Some(offer) => Err(Error::Usage(format!("--share {share}: {}", offer.why)).into()),
            None => Ok(share),
        }
    }
}

/// Seconds for people.
pub fn time(seconds: f64) -> String {
    if seconds < 1.0 { format!("{:.3} ms", 1e3 * seconds) } else { format!("{seconds:.2} s") }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LINK: Link = Link { latency: 1e-5, bandwidth: 2e9 };

    fn job() -> Job {
        let load = Load { points: 5e5, fragments: 9e6, pixels: 2e6, work: 0.0 };
        Job { load, samples: None, slots: 0, images: 1, frames: 1, is_gpu: false }
    }

    fn chosen(job: Job, ranks: usize) -> Share {
        job.choose(Wanted::Auto, ranks, LINK).unwrap()
    }

    #[test]
    fn the_fastest_way_to_share_is_chosen() {
        assert_eq!(chosen(job(), 4), Share::Windows);
        let dealt = Job { samples: Some([100, 1]), slots: 40_000_000, ..job() };
        assert_eq!(chosen(dealt, 4), Share::Samples, "no rank has to test all points");
        assert_eq!(chosen(Job { frames: 36, ..job() }, 4), Share::Frames, "frames need no gathering");
        assert_eq!(chosen(Job { frames: 2, ..job() }, 16), Share::Windows, "and leave ranks without work");
        let stochastic = Job { samples: Some([64, 16]), ..job() };
        assert_eq!(chosen(stochastic, 16), Share::Windows, "there are four batches");
    }

    #[test]
    fn every_image_of_a_mean_takes_its_time() {
        let four = Job { images: 4, ..job() };
        assert!((four.alone() - 4.0 * job().alone()).abs() < 1e-12);
        let [alone, mean] = [job(), four].map(|job| Job { samples: Some([64, 16]), ..job }.ensembles(4, LINK));
        let [alone, mean] = [alone, mean].map(|offer| offer.seconds.unwrap());
        assert!((mean - 4.0 * alone).abs() < 1e-12, "sums of each image are gathered");
    }

    #[test]
    fn ways_that_share_nothing_are_refused() {
        let refused = |wanted, job: Job| job.choose(wanted, 2, LINK).unwrap_err().to_string();
        assert!(refused(Wanted::Ensembles, job()).contains("--share ensembles: the method draws no ensembles"));
        assert!(refused(Wanted::Frames, job()).contains("--share frames: there is one frame"));
        assert_eq!(job().choose(Wanted::Windows, 2, LINK).unwrap(), Share::Windows);
    }

    #[test]
    fn more_ranks_take_less_time_until_messages_do() {
        let seconds = |ranks| job().windows(ranks, LINK).seconds.unwrap();
        assert!(seconds(1) > 1.8 * seconds(2) && seconds(2) > 1.7 * seconds(4));
        assert!(seconds(1 << 16) > seconds(64), "latencies add up");
        assert!((seconds(1) - job().alone()).abs() < 1e-12);
    }
}
