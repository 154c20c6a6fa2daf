//! Barriers between commands, and before the host reads.
//!
//! Without stamps a barrier stands only where a command meets what another one did since the last: it reads or writes
//! what was written, or writes what was read. Between dispatches alone it lets only dispatches wait: a GPU then neither
//! waits for copies and draws nor empties their caches. With stamps one stands before every pass, so that times are
//! those of one pass.

use ash::vk;

use super::{Recorder, Stamps};
use crate::RawSlice;
use crate::barriers::{compute_barrier, full_barrier};

/// Accesses of a command to a buffer.
#[derive(Debug, Clone, Copy)]
pub(super) struct Touch {
    pub(super) slice: RawSlice,
    pub(super) writes: bool,
}

/// Stages that a command has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    /// Compute shaders alone.
    Compute,
    /// Others, too, or nothing but others.
    Other,
}

/// Commands that wait at a barrier, and for which they wait.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Scope {
    Compute,
    All,
}

/// Accesses that are remembered of dispatches which only dispatches wait for.
const MOST_SETTLED: usize = 1024;

/// Resources that commands since the last barrier touch.
#[derive(Default)]
pub(super) struct Touched {
    all: Vec<Touch>,
    /// Accesses of dispatches before it for which only dispatches have waited.
    settled: Vec<Touch>,
    /// `true` if the commands since the last barrier are not all dispatches.
    others: bool,
    /// `true` if there was more than this list says: attachments, guards.
    more: bool,
}

impl Touched {
    /// Returns the barrier that a command with these accesses takes.
    fn barrier(&self, kind: Kind, touches: &[Touch]) -> Option<Scope> {
        let meet = |earlier: &[Touch]| touches.iter().any(|touch| earlier.iter().any(|other| other.meets(touch)));
        if self.more || (kind == Kind::Other && meet(&self.settled)) {
            return Some(Scope::All);
        }
        let compute = kind == Kind::Compute && !self.others && self.settled.len() < MOST_SETTLED;
        meet(&self.all).then_some(if compute { Scope::Compute } else { Scope::All })
    }

    /// Remembers a barrier.
    fn settle(&mut self, scope: Scope) {
        match scope {
            Scope::Compute => self.settled.append(&mut self.all),
            Scope::All => *self = Self::default(),
        }
    }

    /// Remembers a command.
    fn add(&mut self, kind: Kind, touches: &[Touch]) {
        self.others |= kind == Kind::Other;
        self.all.extend(touches);
    }
}

impl Touch {
    pub(super) fn read(slice: RawSlice) -> Self {
        Self { slice, writes: false }
    }

    pub(super) fn write(slice: RawSlice) -> Self {
        Self { slice, writes: true }
    }

    /// Returns `true` if one of these accesses must wait for another.
    pub(super) fn meet_within(touches: &[Self]) -> bool {
        touches.iter().enumerate().any(|(place, touch)| touches[..place].iter().any(|other| other.meets(touch)))
    }

    fn meets(&self, other: &Self) -> bool {
        let ([a, b], either) = ([self.slice, other.slice], self.writes || other.writes);
        either && a.buffer == b.buffer && a.offset < b.offset + b.bytes && b.offset < a.offset + a.bytes
    }
}

impl Recorder<'_> {
    /// A barrier before a command with these accesses, if it takes one.
    pub(super) fn barrier_before(&mut self, kind: Kind, touches: &[Touch]) {
        let always = (self.stamps == Stamps::Passes).then_some(Scope::All);
        if let Some(scope) = always.or_else(|| self.touched.barrier(kind, touches)) {
            match scope {
                Scope::All => full_barrier(&self.context, self.commands),
                Scope::Compute => compute_barrier(&self.context, self.commands),
            }
            self.touched.settle(scope);
        }
        self.touched.add(kind, touches);
    }

    /// A barrier must stand before the next command, whatever that does.
    pub(super) fn touch_more(&mut self) {
        self.touched.more = true;
    }

    pub(super) fn host_barrier(&self) {
        let barrier = [vk::MemoryBarrier2::default()
            .src_stage_mask(vk::PipelineStageFlags2::ALL_COMMANDS)
            .src_access_mask(vk::AccessFlags2::MEMORY_WRITE)
            .dst_stage_mask(vk::PipelineStageFlags2::HOST)
            .dst_access_mask(vk::AccessFlags2::HOST_READ)];
        let dependency = vk::DependencyInfo::default().memory_barriers(&barrier);
        // SAFETY: the command buffer is recording outside of a render pass; the barrier has no resources.
        unsafe { self.context.device.cmd_pipeline_barrier2(self.commands, &dependency) };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dispatches_wait_for_dispatches_alone_and_others_for_all() {
        use ash::vk::Handle;
        let touch = |buffer: u64, writes| Touch {
            slice: RawSlice { buffer: vk::Buffer::from_raw(buffer), offset: 0, bytes: 8, room: 8 },
            writes,
        };
        let mut touched = Touched::default();
        let mut record = |kind, touches: &[Touch]| {
            let scope = touched.barrier(kind, touches);
            if let Some(scope) = scope {
                touched.settle(scope);
            }
            touched.add(kind, touches);
            scope
        };
        let [write, read] = [true, false].map(|writes| move |buffer| touch(buffer, writes));
        // A fill, and a dispatch that adds to it.
        assert_eq!(record(Kind::Other, &[write(1)]), None);
        assert_eq!(record(Kind::Compute, &[write(1)]), Some(Scope::All));
        // Dispatches that read what others have written, and one that has nothing to do with them.
        assert_eq!(record(Kind::Compute, &[read(1), write(2)]), Some(Scope::Compute));
        assert_eq!(record(Kind::Compute, &[read(1), write(3)]), None);
        assert_eq!(record(Kind::Compute, &[read(2), write(4)]), Some(Scope::Compute));
        // A copy of what was written before two barriers of dispatches, which have not let it wait.
        assert_eq!(record(Kind::Other, &[read(1), write(5)]), Some(Scope::All));
        assert_eq!(record(Kind::Other, &[read(2), write(6)]), None);
        // After a barrier for all nobody waits for what was before.
        assert_eq!(record(Kind::Compute, &[write(3)]), None);
        assert_eq!(record(Kind::Compute, &[read(6)]), Some(Scope::All));
    }

    #[test]
    fn a_barrier_stands_where_something_written_is_met() {
        use ash::vk::Handle;
        let slice =
            |buffer: u64, offset, bytes| RawSlice { buffer: vk::Buffer::from_raw(buffer), offset, bytes, room: 99 };
        let [front, back, across] = [slice(1, 0, 8), slice(1, 8, 8), slice(1, 4, 8)];
        let meet = |a: Touch, b: Touch| {
            assert_eq!(a.meets(&b), b.meets(&a));
            a.meets(&b)
        };
        assert!(meet(Touch::write(front), Touch::read(across)) && meet(Touch::write(back), Touch::write(across)));
        assert!(!meet(Touch::read(front), Touch::read(across)), "reads do no harm");
        assert!(!meet(Touch::write(front), Touch::write(back)), "neighbors");
        assert!(!meet(Touch::write(front), Touch::write(slice(2, 0, 8))), "another buffer");
        assert!(Touch::meet_within(&[front, back, across].map(Touch::write)), "the last meets both");
        assert!(!Touch::meet_within(&[front, back].map(Touch::write)), "one pass fills both");
    }
}
