//! Counts that are foreseen: the host takes what a count will be at most for granted, and records what comes after it.
//! The device compares, and leaves that out if it is more.

use super::{Dispatch, Error, Recorder, Run, Slice};
use crate::{gpu_struct, pass};

gpu_struct! {
    /// Push constants: how many words.
    pub struct ForeseePush {
        count: u32,
    }
}

pass! {
    @from crate::SHADERS;
    /// Compares words with what they may be at most; untimed.
    pub Foresee(ForeseePush) = "foresee/compare" {
        words: Read<u32>,
        most: Read<u32>,
        go: ReadWrite<u32>,
    }
}

impl<'a> Recorder<'a> {
    /// Writes words of the host to the front of a slice, untimed.
    pub fn update(&mut self, to: Slice<'a, u32>, words: &[u32]) {
        assert!(words.len() as u64 <= to.len(), "{}: more words than room", to.name());
        self.update_raw(to.raw(), bytemuck::cast_slice(words));
    }

    /// Dispatches and draws from here on run only if each of these words is at most what the same word of `most` is,
    /// and only if nothing was left out before: `go` must hold 1 at first, and holds 0 after something was. Fills and
    /// copies run in any case. The device must be able to ([`super::DeviceInfo::conditional`]).
    pub fn only_within(
        &mut self,
        words: Slice<'a, u32>,
        most: Slice<'a, u32>,
        go: Slice<'a, u32>,
    ) -> Result<(), Error> {
        let push = ForeseePush { count: words.len() as u32 };
        self.run_untimed(&Foresee { words, most, go }, push, &Run::new(Dispatch::Invocations(words.len())))?;
        self.begin_condition(go.raw());
        Ok(())
    }
}
