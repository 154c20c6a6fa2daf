//! Barriers between commands, and before the host reads.
//!
//! Without stamps a barrier stands only where a command meets what another one did since the last: it reads or writes
//! what was written, or writes what was read. With stamps one stands before every pass, so that times are those of one
//! pass.

use ash::vk;

use super::{Recorder, Stamps};
use crate::RawSlice;
use crate::barriers::full_barrier;

/// Accesses of a command to a buffer.
#[derive(Debug, Clone, Copy)]
pub(super) struct Touch {
    pub(super) slice: RawSlice,
    pub(super) writes: bool,
}

/// Resources that commands since the last barrier touch.
#[derive(Default)]
pub(super) struct Touched {
    all: Vec<Touch>,
    /// `true` if there was more than this list says: attachments, guards.
    more: bool,
}

impl Touch {
    pub(super) fn read(slice: RawSlice) -> Self {
        Self { slice, writes: false }
    }

    pub(super) fn write(slice: RawSlice) -> Self {
        Self { slice, writes: true }
    }

    fn meets(&self, other: &Self) -> bool {
        let ([a, b], either) = ([self.slice, other.slice], self.writes || other.writes);
        either && a.buffer == b.buffer && a.offset < b.offset + b.bytes && b.offset < a.offset + a.bytes
    }
}

impl Recorder<'_> {
    /// A barrier before a command with these accesses, if it takes one.
    pub(super) fn barrier_before(&mut self, touches: &[Touch]) {
        let meets = |touch: &Touch| self.touched.all.iter().any(|earlier| earlier.meets(touch));
        if self.stamps == Stamps::Passes || self.touched.more || touches.iter().any(meets) {
            full_barrier(&self.context, self.commands);
            self.touched = Touched::default();
        }
        self.touched.all.extend(touches);
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
    }
}
