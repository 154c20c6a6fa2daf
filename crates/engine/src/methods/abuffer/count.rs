//! Counts a window's fragments, and finds where each pixel's list begins.

use super::capacity::Need;
use super::passes::{Lengths, Measure};
use super::{ABuffer, Bodies, Counting, LOCAL_LENGTH, ListsJob};
use crate::methods::prelude::*;
use crate::passes::foresight::AnswerPlace;

/// Pixels of one invocation of `abuffer/measure`.
const MEASURE_RUN: u64 = 64;

/// Counts of a window's fragments, from count and scan.
#[derive(Debug, Clone, Copy)]
pub(super) struct Counted {
    pub(super) overflow: bool,
    pub(super) total: u32,
    pub(super) lengths: Lengths,
    /// The total of bodies; a sphere counts once, however many events it has.
    pub(super) bodies: u32,
    most_bodies: u32,
    /// Place at which the counts are found.
    place: AnswerPlace,
}

impl Counted {
    /// Returns the counts in the words of an answer.
    fn new(words: &[u32], place: AnswerPlace, bodies_of: Bodies) -> Self {
        let (longest, total) = (words[1], words[3]);
        let [most_bodies, bodies] = match bodies_of {
            Bodies::Counted => [words[4], words[5]],
            Bodies::Halves => [longest / 2, total / 2],
            Bodies::Fragments => [longest, total],
        };
        let lengths = Lengths { longest, in_long_lists: words[2] };
        Self { overflow: words[0] != 0, lengths, total, bodies, most_bodies, place }
    }

    /// Returns a closure that adds the counts themselves to those of the frame.
    pub(super) fn noting(&self, job: &ListsJob<'_>, bands: Vec<Band>) -> impl FnOnce(&mut Facts, &Timeline) + 'static {
        let (place, bodies_of, need) = (self.place, job.storing.bodies(), Need::for_window(job, self));
        move |facts, timeline| {
            let found = Self::new(timeline.found(place), place, bodies_of);
            found.note(&bands, facts);
            let most = match bands[..] {
                [_] => u64::from(found.total),
                _ => bands.iter().map(|band| band.fragments).max().unwrap_or(0),
            };
            facts.fragment_bytes = facts.fragment_bytes.max(need.stored_bytes(most));
        }
    }

    pub(super) fn note(&self, bands: &[Band], facts: &mut Facts) {
        facts.bands += bands.len() as u64;
        facts.fragments += u64::from(self.bodies);
        facts.max_list = facts.max_list.max(self.most_bodies);
        facts.max_events = facts.max_events.max(self.lengths.longest);
    }
}

impl ABuffer {
    /// Counts and scans; if they are to be `told`, lengths come to the host with the submission.
    pub(super) fn count(
        &mut self,
        device: &Device,
        job: &ListsJob<'_>,
        told: bool,
        timeline: &mut Timeline,
    ) -> Result<Counted, Error> {
        let pixels = bands::pixels(job.raster.window);
        self.room.counts.reserve(device, pixels + 1)?;
        self.room.offsets.reserve(device, pixels + 1)?;
        self.scan.reserve(device, pixels + 1)?;
        let beside = job.storing.bodies() == Bodies::Counted;
        self.beside = beside;
        self.bodies.reserve(device, if beside { pixels } else { 1 })?;
        self.told_offsets.reserve(device, if told { pixels + 1 } else { 0 })?;
        self.told_bodies.reserve(device, if told && beside { pixels } else { 0 })?;
        let (counts, offsets) = (self.room.counts.get(), self.room.offsets.get());

        let mut recorder = timeline.recorder(device)?;
        let mut zeros = vec![counts.slice(0, pixels + 1), self.scan.overflow.all(), self.lengths.all().cast()];
        if job.storing.bodies() != Bodies::Fragments {
            zeros.extend([self.bodies.get().all(), self.body_lengths.all().cast()]);
        }
        recorder.fill_all("abuffer/clear", &zeros.into_iter().map(|words| (words, 0)).collect::<Vec<_>>())?;
        let counting = Counting { raster: job.raster, counts: counts.all(), bodies: self.bodies.get().all() };
        job.storing.record_count(&mut recorder, counting)?;
        let measure = Run::new(Dispatch::Invocations(pixels.div_ceil(MEASURE_RUN)));
        let push = CountPush { count: pixels as u32 };
        if beside {
            let run = measure.clone().variant(measure_variant(0));
            let of_bodies = Measure { counts: self.bodies.get().all(), lengths: self.body_lengths.all() };
            recorder.run(&of_bodies, push, &run)?;
        }
        let measure = measure.variant(measure_variant(LOCAL_LENGTH));
        recorder.run(&Measure { counts: counts.all(), lengths: self.lengths.all() }, push, &measure)?;
        self.scan.record(&mut recorder, counts.slice(0, pixels + 1), offsets.slice(0, pixels + 1))?;
        if !job.storing.needs().links {
            // From here on the counts are the cursors that hand out slots.
            recorder.copy("abuffer/cursors", offsets.slice(0, pixels + 1), counts.slice(0, pixels + 1))?;
        }
        self.told_offsets.record(&mut recorder, offsets);
        self.told_bodies.record(&mut recorder, self.bodies.get());
        let mut words = vec![self.scan.overflow.all(), self.lengths.all().cast(), offsets.slice(pixels, 1)];
        if beside {
            words.push(self.body_lengths.all().cast());
        }
        let names = ("abuffer/summary", "abuffer/count and scan");
        let answer = timeline.ask(device, recorder, names, &words)?;
        Ok(Counted::new(&answer.words, answer.place, job.storing.bodies()))
    }
}

/// Returns the variant of `abuffer/measure`: lists longer than `long` are long.
pub(super) fn measure_variant(long: u32) -> Variant {
    Variant::plain().with("RUN", MEASURE_RUN as f64).with("LONG", long)
}
