//! Work of a rank for a frame: units, passes, messages.

use std::time::{Duration, Instant};

use pellucid_engine::methods::{Facts, FrameProfile};
use pellucid_engine::passes::bands::Window;
use serde::{Deserialize, Serialize};

use super::ranks::{Ranks, Traffic};

/// A rank's part of a frame. Times are in milliseconds, those of beginnings since the frame began.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct RankWork {
    /// The rank.
    pub rank: usize,
    /// Host of the rank.
    pub host: String,
    /// Regions of the image, in the order in which the rank rendered them.
    pub windows: Vec<Window>,
    /// Ranges of ensembles or samples that it drew.
    pub samples: Vec<[u32; 2]>,
    /// Numbers of the frames that it rendered alone.
    pub frames: Vec<u32>,
    /// Time that it was at work, until everything was rendered.
    pub work_ms: f64,
    /// Time without work and without a message.
    pub waited_ms: f64,
    /// Bytes that it sent and received.
    pub sent: u64,
    pub received: u64,
    /// Bytes that it read of nodes.
    pub read: u64,
    /// Passes in order of their first run: name, time on the device, invocations.
    pub passes: Vec<RankPass>,
    /// Each dispatch: name, beginning, time on the device.
    pub timeline: Vec<(String, f64, f64)>,
    /// Fragments, and the longest list.
    pub fragments: u64,
    pub max_list: u32,
    /// Splats that it projected and that show.
    pub visible: u64,
}

/// A pass with all its dispatches.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct RankPass {
    pub name: String,
    pub gpu_ms: f64,
    pub invocations: Option<u64>,
}

impl RankWork {
    /// Returns a record of a rank that has done nothing yet.
    pub fn of(ranks: &Ranks) -> Self {
        Self { rank: ranks.own(), host: ranks.host().to_owned(), ..Self::default() }
    }

    /// Adds what was rendered, in a frame that began at some time. Dispatches are kept one by one if they are `listed`.
    pub fn add(&mut self, (facts, profile): (&Facts, &FrameProfile), begin: Instant, listed: bool) {
        self.fragments += facts.fragments;
        self.max_list = self.max_list.max(facts.max_list);
        self.visible += facts.visible;
        for pass in &profile.passes {
            let (name, gpu_ms) = (pass.name.to_owned(), ms(pass.gpu));
            self.add_pass(RankPass { name, gpu_ms, invocations: pass.invocations });
        }
        if listed {
            let start = ms(profile.begin.saturating_duration_since(begin));
            let runs = profile.timeline.iter();
            self.timeline.extend(runs.map(|(run, at)| (run.name.to_owned(), start + ms(*at), ms(run.gpu))));
        }
    }

    /// Adds what the rank did for an image before this one, of the same frame, which began `earlier` milliseconds
    /// before.
    pub fn follow(&mut self, before: Self, earlier: f64) {
        let after = std::mem::replace(self, before);
        self.windows.extend(after.windows);
        self.samples.extend(after.samples);
        self.frames.extend(after.frames);
        for pass in after.passes {
            self.add_pass(pass);
        }
        self.timeline.extend(after.timeline.into_iter().map(|(name, start, length)| (name, earlier + start, length)));
        self.work_ms += after.work_ms;
        self.waited_ms += after.waited_ms;
        self.sent += after.sent;
        self.received += after.received;
        self.read += after.read;
        self.fragments += after.fragments;
        self.max_list = self.max_list.max(after.max_list);
        self.visible += after.visible;
    }

    fn add_pass(&mut self, pass: RankPass) {
        match self.passes.iter_mut().find(|known| known.name == pass.name) {
            Some(known) => {
                known.gpu_ms += pass.gpu_ms;
                known.invocations = known.invocations.zip(pass.invocations).map(|(a, b)| a + b);
            }
            None => self.passes.push(pass),
        }
    }

    /// Takes the counts of messages.
    pub fn note(&mut self, traffic: Traffic) {
        (self.sent, self.received, self.waited_ms) = (traffic.sent, traffic.received, ms(traffic.waited));
    }

    /// Time on the device in all passes.
    pub fn gpu_ms(&self) -> f64 {
        self.passes.iter().map(|pass| pass.gpu_ms).sum()
    }
}

/// The counts of a whole frame, from those of its first rank and the work of all.
pub fn joined(facts: &mut Facts, all: &[RankWork]) {
    facts.fragments = all.iter().map(|work| work.fragments).sum();
    facts.max_list = all.iter().map(|work| work.max_list).max().unwrap_or(0);
    facts.visible = all.iter().map(|work| work.visible).sum();
}

/// The longest time that a rank was at work, by the mean of all.
pub fn imbalance(all: &[RankWork]) -> f64 {
    let times = || all.iter().map(|work| work.work_ms);
    let mean = times().sum::<f64>() / all.len().max(1) as f64;
    if mean > 0.0 { times().fold(0.0, f64::max) / mean } else { 1.0 }
}

/// Milliseconds.
pub fn ms(time: Duration) -> f64 {
    time.as_secs_f64() * 1e3
}
