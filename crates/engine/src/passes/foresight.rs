//! Counts that the host asks for in the middle of a frame, and what it takes for granted where it knows an earlier
//! frame.
//!
//! A count decides how large buffers are, how much is dispatched, and what is done at all. The first frame of its kind
//! waits for each. The second waits, too, but goes on with a count that has a margin, so that its buffers have room.
//! From the third one on nothing is waited for: all is recorded for counts of that size, and the device compares.
//! Whatever comes behind a count that is larger it leaves out, and the frame is rendered once more, waiting. Bytes of
//! the image don't depend on any of this: an upper bound serves wherever a count does.

use super::Error;
use crate::gpu::{self, Buffer, Device, Memory, Recorder, Slice};

/// Source from which the counts of a window are known before it is rendered.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Knowledge {
    /// Not at all: the host waits for each.
    #[default]
    None,
    /// The host waits for each, and goes on with something larger.
    Ahead,
    /// The predicted counts are upper bounds; if they prove too small, the window is rendered once more.
    Bounds,
}

/// Counts that were asked for; an upper bound of them where the host did not wait.
#[derive(Debug, Clone, Default)]
pub struct Answer {
    /// The words.
    pub words: Vec<u32>,
    /// Place at which the counts themselves are found.
    pub place: AnswerPlace,
}

/// Place of the counts that answer a question, once they were submitted.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct AnswerPlace {
    first: u64,
    count: u64,
}

/// A question of a window.
struct Question {
    name: &'static str,
    /// Index at which its answer begins.
    first: u64,
    /// The upper bound of each word of the answer; nothing until it was given.
    most: Vec<u32>,
}

/// Eighths of a count that its upper bound is above it; twice as many after each miss.
const MARGIN: u32 = 1;
/// Times that a margin grows; from then on a miss is followed by a rest.
const GROWTHS: u32 = 3;
/// Windows that wait after such a miss.
const REST: u32 = 16;
/// Windows in a row that were as foreseen, after which a miss is forgotten.
const FORGIVEN: u32 = 64;
/// Words from one answer to the next are a multiple of this many, so that each can be bound by itself.
const ALIGNED: u64 = 64;

/// Facts about windows of one kind.
#[derive(Default)]
pub struct Foresight {
    knowledge: Knowledge,
    /// Questions of the last window, in order, if there was one.
    known: Option<Vec<Question>>,
    /// Questions of this window so far.
    asked: Vec<Question>,
    /// `true` if buffers have room for what is known.
    roomy: bool,
    /// `true` if windows of this kind don't fit with a margin.
    hopeless: bool,
    /// Windows that were not as foreseen, windows since then that were, and windows that are to wait.
    misses: u32,
    hits: u32,
    rest: u32,
    answers: Option<Answers>,
}

/// Buffers of answers.
struct Answers {
    found: Buffer<u32>,
    most: Buffer<u32>,
    host: Buffer<u32>,
    go: Buffer<u32>,
    go_host: Buffer<u32>,
}

impl Answers {
    fn new(device: &Device, words: u64) -> Result<Self, gpu::Error> {
        Ok(Self {
            found: device.buffer("counts", words, Memory::Device)?,
            most: device.buffer("counts, at most", words, Memory::Device)?,
            host: device.buffer("counts, host", words, Memory::Readback)?,
            go: device.buffer("counts as foreseen", 1, Memory::Device)?,
            go_host: device.buffer("counts as foreseen, host", 1, Memory::Readback)?,
        })
    }
}

impl Foresight {
    /// Forgets everything: windows of another kind follow.
    pub fn forget(&mut self) {
        *self = Self { answers: self.answers.take(), ..Self::default() };
    }

    /// Begins a window of the same kind as the last one. It waits for its counts if it `waits`, or has to.
    pub fn begin(&mut self, waits: bool) {
        self.asked.clear();
        if !waits {
            self.rest = self.rest.saturating_sub(1);
        }
        self.knowledge = if waits || self.hopeless || self.rest > 0 || self.known.is_none() {
            Knowledge::None
        } else if self.roomy {
            Knowledge::Bounds
        } else {
            Knowledge::Ahead
        };
    }

    /// Returns the source from which the counts of this window are known.
    pub fn knowledge(&self) -> Knowledge {
        self.knowledge
    }

    /// The window is finished: what it asked is known now.
    pub fn finish(&mut self) {
        if self.knowledge == Knowledge::Bounds {
            self.hits += 1;
            if self.hits >= FORGIVEN {
                (self.hits, self.misses) = (0, self.misses.saturating_sub(1));
            }
            for place in 0..self.asked.len() {
                self.bound(place);
            }
        }
        self.roomy = self.knowledge != Knowledge::None;
        self.known = Some(std::mem::take(&mut self.asked));
    }

    /// The window was not as foreseen, and is to be rendered again, waiting.
    pub fn miss(&mut self) {
        if self.knowledge == Knowledge::Ahead {
            // With a margin it doesn't fit.
            self.hopeless = true;
        } else if self.misses < GROWTHS {
            self.misses += 1;
        } else {
            self.rest = REST;
        }
        (self.hits, self.roomy) = (0, false);
        self.begin(true);
    }

    /// Records a question: where its words lie. What may be taken for granted; `None` if the recording must be
    /// submitted, and then [`Self::answer`] be called.
    pub fn ask<'a>(
        &'a mut self,
        device: &Device,
        recorder: &mut Recorder<'a>,
        name: &'static str,
        words: &[Slice<'a, u32>],
    ) -> Result<Option<Answer>, Error> {
        let count: u64 = words.iter().map(Slice::len).sum();
        let first = self.asked.last().map_or(0, |q| (q.first + q.most.len() as u64).next_multiple_of(ALIGNED));
        let foreseen = self.knowledge == Knowledge::Bounds;
        let room = self.answers.as_ref().map_or(0, |answers| answers.host.len());
        let place = self.asked.len();
        let known = self
            .known
            .as_ref()
            .and_then(|known| known.get(place))
            .filter(|known| known.name == name && known.most.len() as u64 == count);
        if foreseen && (known.is_none() || room < first + count) {
            return Err(Error::Unforeseen);
        }
        let most = known.map_or_else(|| vec![0; count as usize], |known| known.most.clone());
        self.asked.push(Question { name, first, most: most.clone() });
        if room < first + count {
            // Answers of earlier questions are asked for once more at the end.
            let earlier = self.answers.take().map(|answers| answers.host.mapped_slice().to_vec());
            let mut answers = Answers::new(device, (first + count).next_power_of_two().max(8 * ALIGNED))?;
            answers.host.write(&earlier.unwrap_or_default());
            self.answers = Some(answers);
        }
        let Some(Answers { found, most: bounds, host, go, .. }) = &self.answers else { return Ok(None) };
        let mut next = first;
        let to = if foreseen { found } else { host };
        let placed = words.iter().map(|slice| {
            let place = to.slice(next, slice.len());
            next += slice.len();
            (*slice, place)
        });
        recorder.copy_all(name, &placed.collect::<Vec<_>>())?;
        if !foreseen {
            return Ok(None);
        }
        if place == 0 {
            recorder.update(go.all(), &[1]);
        }
        let bounds = bounds.slice(first, count);
        recorder.update(bounds, &most);
        recorder.only_within(found.slice(first, count), bounds, go.all())?;
        Ok(Some(Answer { words: most, place: AnswerPlace { first, count } }))
    }

    /// Returns the answer to the last question, which was waited for.
    pub fn answer(&mut self) -> Answer {
        let Some(place) = self.asked.len().checked_sub(1) else { return Answer::default() };
        self.bound(place);
        let Question { first, most, .. } = &self.asked[place];
        let found = AnswerPlace { first: *first, count: most.len() as u64 };
        let words = match self.knowledge {
            Knowledge::None => self.found(found).to_vec(),
            _ => most.clone(),
        };
        Answer { words, place: found }
    }

    /// Bounds the answer to a question, from what was found: by what bounded the last one, if that is neither less nor
    /// far more.
    fn bound(&mut self, place: usize) {
        let Some(Answers { host, .. }) = &self.answers else { return };
        let Question { first, most, .. } = &mut self.asked[place];
        let margin = MARGIN << self.misses;
        for (most, found) in most.iter_mut().zip(&host.mapped_slice()[*first as usize..]) {
            if *most < *found || *most / 3 > *found {
                let larger = found.checked_add(found.div_ceil(8).saturating_mul(margin));
                self.hopeless |= larger.is_none();
                *most = larger.unwrap_or(u32::MAX);
            }
        }
    }

    /// Records what tells [`Self::is_met`], after the last question.
    pub fn record_end<'a>(&'a self, recorder: &mut Recorder<'a>) {
        let Some(last) = self.asked.last().filter(|_| self.knowledge == Knowledge::Bounds) else { return };
        let Some(Answers { found, host, go, go_host, .. }) = &self.answers else { return };
        let words = last.first + last.most.len() as u64;
        recorder.copy_untimed(found.slice(0, words), host.slice(0, words));
        recorder.copy_untimed(go.all(), go_host.all());
    }

    /// After the submission: true if all was as foreseen.
    pub fn is_met(&self) -> bool {
        let waited = self.knowledge != Knowledge::Bounds || self.asked.is_empty();
        waited || self.answers.as_ref().is_some_and(|answers| answers.go_host.mapped_slice()[0] == 1)
    }

    /// Returns what was found, once the submission with the question has been waited for.
    pub fn found(&self, AnswerPlace { first, count }: AnswerPlace) -> &[u32] {
        let range = first as usize..(first + count) as usize;
        self.answers.as_ref().map_or(&[], |answers| &answers.host.mapped_slice()[range])
    }
}
