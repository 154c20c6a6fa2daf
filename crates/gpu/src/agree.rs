//! Debug builds check that stored equals counted: after a pass that relies on another one's counts, a small pass
//! compares the end of each of its cursors with the start of the next one's range. Release builds record none of this.

use std::sync::Arc;

use super::{Buffer, Context, Dispatch, Error, Memory, Recorder, Run, Slice, guard};
use crate::{gpu_struct, pass};

/// The expected words after a pass.
#[derive(Debug, Clone, Copy)]
pub enum Expected<'a> {
    /// The words of this slice.
    Words(Slice<'a, u32>),
    /// Each of `ends` minus its count: used to compare cursors with the next ranges where no copy of their starts is
    /// left.
    Below {
        /// The next ends.
        ends: Slice<'a, u32>,
        /// The counts to subtract.
        counts: Slice<'a, u32>,
    },
    /// A number that every word has.
    Value(u32),
}

gpu_struct! {
    /// Push constants: how many words, the first of each binding, and which of them count.
    pub struct AgreePush {
        count: u32,
        stored_first: u32, // Where the words of each binding begin.
        ends_first: u32,
        counts_first: u32,
        mode: u32, // Below BELOW: the same as ends; BELOW: as much below ends as counts says; above: value.
        value: u32,
        stride: u32, // Words from one that counts to the next.
    }
}

pass! {
    @from crate::SHADERS;
    /// Compares where each cursor ended with where the next range begins; debug builds alone, untimed.
    pub Agree(AgreePush) = "debug/agree" {
        found: ReadWrite<u32>,
        stored: Read<u32>,
        ends: Read<u32>,
        counts: Read<u32>,
    }
}

/// Differences whose words are kept.
const TOLD: usize = 8;
/// Ways in which words are compared: with others, with what is so much below others, with a number.
const WORDS: u32 = 0;
const BELOW: u32 = 1;
const VALUE: u32 = 2;
/// The constants of debug/agree.
pub const CONSTANTS: [(&str, u32); 2] = [("TOLD", TOLD as u32), ("BELOW", BELOW)];

/// A comparison whose outcome the device writes: number of differences, and element, stored and counted of some of
/// them.
pub struct Agreement {
    pass: &'static str,
    item: &'static str,
    first: u64,
    of: u64,
    found: Buffer<u32>,
}

impl Agreement {
    fn new(context: &Arc<Context>, pass: &'static str, item: &'static str) -> Result<Self, Error> {
        let mut found = Buffer::new(context, "stored and counted", 1 + 3 * TOLD as u64, Memory::Readback)?;
        found.write(&[0; 1 + 3 * TOLD]);
        Ok(Self { pass, item, first: 0, of: 0, found })
    }

    /// After the submission: an error if a word was not what it must be.
    pub fn check(&self) -> Result<(), Error> {
        let (differing, told) = (self.found.mapped_slice()[0], &self.found.mapped_slice()[1..]);
        // A cursor that is wrong makes the one before it look wrong, where it was compared with the next.
        let last = told.chunks_exact(3).take(differing as usize).max_by_key(|words| words[0]);
        let Some(&[element, stored, counted]) = last else { return Ok(()) };
        let (pass, item, of) = (self.pass, self.item, self.of);
        Err(Error::Miscounted { pass, item, element: self.first + u64::from(element), stored, counted, differing, of })
    }
}

impl<'a> Recorder<'a> {
    /// Records a check of counts in debug builds: after the submission it is an error, which names `pass`, if a word of
    /// `stored`, one per `item`, differs from the expectation. Slices are of equal length. Costs one untimed pass, and
    /// nothing in release builds.
    pub fn agree(
        &mut self,
        pass: &'static str,
        item: &'static str,
        stored: Slice<'a, u32>,
        expected: Expected<'a>,
    ) -> Result<(), Error> {
        self.agree_every(1, pass, item, stored, expected)
    }

    /// Like [`Self::agree`], for the first of every `stride` words only.
    pub fn agree_every(
        &mut self,
        stride: u32,
        pass: &'static str,
        item: &'static str,
        stored: Slice<'a, u32>,
        expected: Expected<'a>,
    ) -> Result<(), Error> {
        if !guard::records_checks() || stored.is_empty() {
            return Ok(());
        }
        let (ends, counts, mode, value) = match expected {
            Expected::Words(words) => (words, words, WORDS, 0),
            Expected::Below { ends, counts } => (ends, counts, BELOW, 0),
            Expected::Value(value) => (stored, stored, VALUE, value),
        };
        assert!(stored.len() == ends.len() && stored.len() == counts.len(), "{pass}: slices of different length");
        let limits = &self.context().limits;
        let alignment = limits.offset_alignment;
        let piece = (limits.binding_bytes.saturating_sub(alignment) / 4 / u64::from(stride)).max(1) * u64::from(stride);
        for start in (0..stored.len()).step_by(piece as usize) {
            let count = piece.min(stored.len() - start);
            let part = |slice: Slice<'a, u32>| slice.skip(start).first(count).reaching_back(alignment);
            let ((stored, stored_first), (ends, ends_first), (counts, counts_first)) =
                (part(stored), part(ends), part(counts));
            let mut agreement = Agreement::new(self.context(), pass, item)?;
            let words = count.div_ceil(stride.into());
            agreement.first = (stored.start() + u64::from(stored_first)) / u64::from(stride);
            agreement.of = words;
            let count = words as u32;
            let push = AgreePush { count, stored_first, ends_first, counts_first, mode, value, stride };
            let run = Run::new(Dispatch::Invocations(words));
            self.run_untimed(&Agree { found: agreement.found.all(), stored, ends, counts }, push, &run)?;
            self.keep(agreement);
        }
        Ok(())
    }
}
