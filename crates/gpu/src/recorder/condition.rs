//! Commands that the device leaves out by a word in a buffer, and words that come with the command buffer.

use ash::vk;

use super::Recorder;
use super::barriers::{Kind, Touch};
use crate::RawSlice;

/// Most bytes of one update.
const UPDATE_BYTES: usize = 65_536;

impl Recorder<'_> {
    /// Begins a condition: dispatches and draws run only if the word is not 0. The end of the recording ends it.
    pub(crate) fn begin_condition(&mut self, word: RawSlice) {
        self.end_condition();
        self.barrier_before(Kind::Other, &[Touch::read(word)]);
        let Some(conditional) = &self.context.conditional else { return };
        let begin = vk::ConditionalRenderingBeginInfoEXT::default().buffer(word.buffer).offset(word.offset);
        // SAFETY: the extension is enabled; the command buffer is recording outside of a render pass and of a
        // condition.
        unsafe { (conditional.fp().cmd_begin_conditional_rendering_ext)(self.commands, &begin) };
        self.conditional = true;
    }

    pub(super) fn end_condition(&mut self) {
        if let (true, Some(conditional)) = (self.conditional, &self.context.conditional) {
            // SAFETY: begun in `begin_condition`, and never within a render pass.
            unsafe { (conditional.fp().cmd_end_conditional_rendering_ext)(self.commands) };
        }
        self.conditional = false;
    }

    pub(crate) fn update_raw(&mut self, to: RawSlice, bytes: &[u8]) {
        self.barrier_before(Kind::Other, &[Touch::write(RawSlice { bytes: bytes.len() as u64, ..to })]);
        self.guards.note_write(to);
        for (number, part) in bytes.chunks(UPDATE_BYTES).enumerate() {
            let offset = to.offset + (number * UPDATE_BYTES) as u64;
            // SAFETY: the range lies within the buffer: checked by the caller; offset and size are multiples of four
            // bytes.
            unsafe { self.context.device.cmd_update_buffer(self.commands, to.buffer, offset, part) };
        }
    }
}
