//! From measured parts of a frame to times on many ranks.

use std::fmt::Display;

use pellucid_engine::passes::bands::Window;

use super::super::cut::{Costs, Load};
use super::super::link::Link;
use super::super::share::{Job, Share};
use super::super::stage::{on_demand, parted};

/// Messages in which a rank hands in a window: what it is, color, depth, what it did.
const MESSAGES: f64 = 6.0;
/// Bytes of a pixel.
const PIXEL_BYTES: f64 = 20.0;

/// A measured part of an image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Part {
    pub window: Window,
    pub seconds: f64,
    /// Work expected in it.
    pub load: Load,
}

impl Display for Part {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { window: [x0, y0, x1, y1], seconds, load } = self;
        write!(
            f,
            "columns {x0} to {x1}, rows {y0} to {y1}: {:.2} ms; {:.0} points and {:.0} fragments were expected",
            1e3 * seconds,
            load.points,
            load.fragments
        )
    }
}

/// Time that samples of a frame take.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sampled {
    total: u32,
    step: u32,
    /// Seconds that a part of them takes in any case, and of each sample.
    once: f64,
    each: f64,
    /// Seconds for packing and unpacking the sums of a part.
    copy: f64,
    /// Seconds of resolving those of all.
    resolve: f64,
    /// Bytes of a part.
    bytes: usize,
}

impl Sampled {
    /// By what all samples take and what some of them do, each with the sums brought to the host.
    pub fn new(
        alone: f64,
        [total, step]: [u32; 2],
        (some, seconds): (u32, f64),
        copy: f64,
        resolve: f64,
        bytes: usize,
    ) -> Self {
        let each = ((alone - seconds) / f64::from(total.saturating_sub(some).max(1))).max(0.0);
        let once = (seconds - f64::from(some) * each).max(0.0);
        Self { total, step, once, each, copy, resolve, bytes }
    }
}

/// Thing that ranks would share.
#[derive(Debug, Clone, PartialEq)]
pub enum Parts {
    /// Whole frames.
    None,
    Windows(Vec<Part>),
    Samples(Sampled),
}

/// A measured frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Measured {
    /// Seconds of the whole.
    pub alone: f64,
    /// Seconds of a window that has nothing in it.
    once: f64,
    costs: Costs,
    /// The parts.
    pub parts: Parts,
    frames: usize,
}

/// Quantity that grows with the number of ranks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scaling {
    /// Nothing: one scene, ever more ranks.
    Strong,
    /// The work: as much for each rank as one has alone.
    Weak,
}

impl Display for Scaling {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(if *self == Self::Strong { "strong" } else { "weak" })
    }
}

/// A prediction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Prediction {
    pub ranks: usize,
    pub share: Share,
    pub scaling: Scaling,
    /// Seconds of all frames, of which the longest work of a rank and the bringing together of the parts.
    pub seconds: f64,
    pub work: f64,
    pub gather: f64,
    /// How much more is done in a second than by one rank.
    pub speedup: f64,
}

impl Prediction {
    /// The speedup by the number of ranks.
    pub fn efficiency(&self) -> f64 {
        self.speedup / self.ranks as f64
    }
}

impl Measured {
    /// Returns predictions from measured times.
    pub fn new(alone: f64, costs: Costs, parts: Parts, frames: usize) -> Self {
        let Parts::Windows(parts) = parts else { return Self { alone, once: 0.0, costs, parts, frames } };
        let all: f64 = parts.iter().map(|part| part.seconds).sum();
        let once = (all - alone).max(0.0) / parts.len().saturating_sub(1).max(1) as f64;
        let least = parts.iter().map(|part| part.seconds).fold(alone, f64::min);
        let once = once.min(0.9 * least);
        // Chance aside, the parts take together what the whole does.
        let factor = (alone - once) / parts.iter().map(|part| part.seconds - once).sum::<f64>();
        let even = |part: Part| Part { seconds: once + factor * (part.seconds - once), ..part };
        let parts = Parts::Windows(parts.into_iter().map(even).collect());
        Self { alone, once, costs, parts, frames }
    }

    /// Seconds of a window: those of the measured parts that it meets, by how much of their work it has.
    fn seconds(&self, parts: &[Part], window: Window) -> f64 {
        let of_part = |part: &Part| {
            let [x0, y0, x1, y1] = part.window;
            let common = [window[0].max(x0), window[1].max(y0), window[2].min(x1), window[3].min(y1)];
            if common[0] >= common[2] || common[1] >= common[3] {
                return 0.0;
            }
            (part.seconds - self.once) * self.costs.of(common).work / part.load.work.max(f64::MIN_POSITIVE)
        };
        self.once + parts.iter().map(of_part).sum::<f64>()
    }

    /// Predictions for a number of ranks, of which some run at once, for both kinds of scaling.
    pub fn predict(&self, job: &Job, ranks: usize, at_once: usize, link: Link) -> Vec<Prediction> {
        let mut all = match &self.parts {
            Parts::None => Vec::new(),
            Parts::Windows(parts) => self.windows(parts, job, ranks, at_once, link).to_vec(),
            Parts::Samples(samples) => self.samples(samples, job, ranks, at_once, link).to_vec(),
        };
        if self.frames > 1 || all.is_empty() {
            all.extend(self.frames(ranks, at_once));
        }
        all
    }

    fn samples(&self, of: &Sampled, job: &Job, ranks: usize, at_once: usize, link: Link) -> [Prediction; 2] {
        let (more, rest) = on_demand(job, ranks);
        let more = (more > 0).then_some((more * ranks, rest));
        let ranges = parted(of.total, of.step, ranks, more).into_iter().map(|range| range.len() as f64);
        let times: Vec<f64> =
            ranges.map(|samples| if samples > 0.0 { of.once + of.each * samples } else { 0.0 }).collect();
        let work = if ranks == 1 { self.alone } else { longest(&dealt(&times, ranks), at_once) };
        // A tree of messages, whose sums are added up; of ensembles they have the same size in each round.
        let rounds = (ranks as f64).log2().ceil();
        let gather =
            rounds * (of.copy + link.seconds(2.0, of.bytes as f64)) + if ranks == 1 { 0.0 } else { of.resolve };
        let made = |scaling, work: f64, times: f64| {
            let seconds = work + gather;
            let speedup = times * self.alone / seconds;
            Prediction { ranks, share: Share::Samples, scaling, seconds, work, gather, speedup }
        };
        let all = slowed(of.once + of.each * f64::from(of.total), ranks, at_once);
        [made(Scaling::Strong, work, 1.0), made(Scaling::Weak, if ranks == 1 { self.alone } else { all }, ranks as f64)]
    }

    fn windows(&self, parts: &[Part], job: &Job, ranks: usize, at_once: usize, link: Link) -> [Prediction; 2] {
        let (more, rest) = on_demand(job, ranks);
        let windows = self.costs.windows(ranks, more, rest);
        let times: Vec<f64> = windows.iter().map(|window| self.seconds(parts, *window)).collect();
        let busy = dealt(&times, ranks);
        let pixels = self.costs.whole().pixels;
        let gather = |pixels: f64| {
            let others = ranks as f64 - 1.0;
            link.seconds(MESSAGES * others, pixels * PIXEL_BYTES * others / ranks as f64)
        };
        let of = |scaling: Scaling, work: f64, gather: f64, times: f64| {
            let seconds = work + gather;
            Prediction {
                ranks,
                share: Share::Windows,
                scaling,
                seconds,
                work,
                gather,
                speedup: times * self.alone / seconds,
            }
        };
        let shared = |work: f64| slowed(work, ranks, at_once);
        let work = longest(&busy, at_once);
        [
            of(Scaling::Strong, work, gather(pixels), 1.0),
            // Each rank has a window with the work of the whole image.
            of(Scaling::Weak, shared(self.alone), gather(pixels * ranks as f64), ranks as f64),
        ]
    }

    fn frames(&self, ranks: usize, at_once: usize) -> [Prediction; 2] {
        let of = |scaling: Scaling, frames: usize| {
            let busy = dealt(&vec![self.alone; frames], ranks);
            let seconds = longest(&busy, at_once);
            let one = frames as f64 * self.alone;
            Prediction {
                ranks,
                share: Share::Frames,
                scaling,
                seconds,
                work: seconds,
                gather: 0.0,
                speedup: one / seconds,
            }
        };
        [of(Scaling::Strong, self.frames), of(Scaling::Weak, self.frames * ranks)]
    }
}

/// How long each rank is at work if it begins with the unit of its number and takes the next one when it is done.
fn dealt(units: &[f64], ranks: usize) -> Vec<f64> {
    let mut busy = vec![0.0; ranks];
    for (number, seconds) in units.iter().enumerate() {
        let rank = if number < ranks {
            number
        } else {
            (0..ranks).min_by(|a, b| f64::total_cmp(&busy[*a], &busy[*b])).unwrap_or(0)
        };
        busy[rank] += seconds;
    }
    busy
}

/// When the last of them is done if so many run at once.
fn longest(busy: &[f64], at_once: usize) -> f64 {
    let most = busy.iter().copied().fold(0.0, f64::max);
    most.max(busy.iter().sum::<f64>() / at_once.min(busy.len().max(1)) as f64)
}

/// Time of work that all ranks do, if so many run at once.
fn slowed(work: f64, ranks: usize, at_once: usize) -> f64 {
    work * (ranks as f64 / at_once as f64).max(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    const LINK: Link = Link { latency: 1e-5, bandwidth: 2e9 };

    /// A frame of 1024 × 1024 pixels without points, whose parts take as long as they are high, and a millisecond more.
    fn measured(once: f64) -> (Measured, Job) {
        let costs = Costs::blank([1024, 1024]);
        let part = |window: Window| Part {
            window,
            seconds: once + f64::from(window[3] - window[1]) / 1024.0,
            load: costs.of(window),
        };
        let parts = costs.windows(8, 0, 0.0).into_iter().map(part).collect();
        let load = costs.whole();
        (
            Measured::new(1.0 + once, costs, Parts::Windows(parts), 36),
            Job { load, samples: None, slots: 0, frames: 36, is_gpu: false },
        )
    }

    fn strong(predictions: &[Prediction], share: Share) -> Prediction {
        *predictions.iter().find(|p| p.share == share && p.scaling == Scaling::Strong).unwrap()
    }

    #[test]
    fn one_rank_takes_what_was_measured() {
        let (measured, job) = measured(0.001);
        let all = measured.predict(&job, 1, usize::MAX, LINK);
        let one = strong(&all, Share::Windows);
        assert!((one.seconds - 1.001).abs() < 1e-9 && (one.speedup - 1.0).abs() < 1e-9 && one.gather == 0.0, "{one:?}");
        assert!((strong(&all, Share::Frames).seconds - 36.0 * 1.001).abs() < 1e-9);
    }

    #[test]
    fn ranks_share_what_can_be_shared() {
        let (measured, job) = measured(0.001);
        let of = |ranks| strong(&measured.predict(&job, ranks, usize::MAX, LINK), Share::Windows);
        assert!((of(4).work - 0.251).abs() < 0.02, "{:?}", of(4));
        assert!(of(4).speedup > 3.5 && of(4).gather > 0.0);
        // Every rank has the time of an empty window, and messages add up.
        assert!(of(4096).efficiency() < 0.25, "{:?}", of(4096));
        // 36 frames on 32 ranks: two for some.
        let frames = strong(&measured.predict(&job, 32, usize::MAX, LINK), Share::Frames);
        assert!((frames.seconds - 2.0 * 1.001).abs() < 1e-9);
    }

    #[test]
    fn samples_are_shared_and_their_sums_travel_along_a_tree() {
        // A second for each of 100 samples, and one besides; a hundredth for packing and for resolving.
        let sampled = Sampled::new(101.0, [100, 1], (50, 51.0), 0.01, 0.01, 20_000_000);
        let (windows, job) = measured(0.0);
        let measured = Measured { alone: 101.0, parts: Parts::Samples(sampled), ..windows };
        let of = |ranks| *measured.predict(&job, ranks, usize::MAX, LINK).first().unwrap();
        assert_eq!((of(1).seconds, of(1).share), (101.0, Share::Samples));
        assert!((of(4).work - 26.0).abs() < 1e-9, "{:?}", of(4));
        // Two rounds of two messages, a hundredth of a second for the bytes and for packing each.
        assert!((of(4).gather - (2.0 * (0.02 + 2e-5) + 0.01)).abs() < 1e-9, "{:?}", of(4));
        assert!((of(200).work - 2.0).abs() < 1e-9, "some ranks have nothing to do");
    }

    #[test]
    fn ranks_that_share_cores_wait_for_them() {
        let (measured, job) = measured(0.0);
        let of = |ranks, at_once| strong(&measured.predict(&job, ranks, at_once, LINK), Share::Windows).work;
        assert!((of(4, 2) - 0.5).abs() < 0.02 && (of(2, 2) - 0.5).abs() < 0.02);
        let weak = measured.predict(&job, 4, 2, LINK);
        let weak = weak.iter().find(|p| p.scaling == Scaling::Weak && p.share == Share::Windows).unwrap();
        assert!((weak.work - 2.0).abs() < 1e-9 && (weak.efficiency() - 0.5).abs() < 0.1, "{weak:?}");
    }

    #[test]
    fn units_go_to_who_is_done_first() {
        assert_eq!(dealt(&[3.0, 1.0, 1.0, 1.0], 2), [3.0, 3.0]);
        assert_eq!(dealt(&[1.0], 3), [1.0, 0.0, 0.0]);
        assert_eq!((longest(&[3.0, 1.0], usize::MAX), longest(&[3.0, 3.0, 3.0], 2)), (3.0, 4.5));
    }
}
