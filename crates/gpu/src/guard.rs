//! Guard words: in debug builds every buffer extends beyond its content, shaders may write there, and each submission
//! checks if one did.
//!
//! Drivers may drop writes beyond a bound range: with robustBufferAccess all do, and lavapipe always does. So the bound
//! range includes the guard, and [`super::spirv`] subtracts its elements from `arrayLength`, so that shaders don't see
//! it. The words behind a range that ends within a buffer's content belong to others: they must stay unchanged, unless
//! a pass of the same submission may write there.
//!
//! No guard precedes a buffer: indices are unsigned, so a shader can't reach anything before its binding.

use std::ffi::OsString;
use std::sync::{Arc, LazyLock};

use ash::vk::{self, Handle};

use super::barriers::full_barrier;
use super::{Buffer, Context, Error, Memory, RawSlice};

/// Bytes of a guard: more than three of the largest elements.
const BYTES: u64 = 256;
/// The guard's content, which is unlike any count, float of a scene, or index.
const WORD: u32 = 0xfade_d0c5;
/// Guards whose words one buffer on the host takes.
const PAGE: u64 = 32;

/// Value of `PELLUCID_CHECKS`.
static ASKED: LazyLock<Option<OsString>> = LazyLock::new(|| std::env::var_os("PELLUCID_CHECKS"));

fn is_asked(value: &str) -> bool {
    ASKED.as_ref().is_some_and(|asked| asked == value)
}

/// Returns whether the device's work is checked: guard words, counts that passes must agree on, shared memory that is
/// never zero by chance. A debug build does so, unless `PELLUCID_CHECKS=0` asks for the work of a release build.
pub fn checks() -> bool {
    cfg!(debug_assertions) && !is_asked("0")
}

/// Returns whether a submission has commands of its own for [`checks`], which bring barriers. With
/// `PELLUCID_CHECKS=shaders` it has none, while shaders and buffers stay as they are.
pub fn records_checks() -> bool {
    checks() && !is_asked("shaders")
}

/// Bytes behind each buffer, and behind each bound range of one: none where nothing is checked.
pub fn bytes() -> u64 {
    if checks() { BYTES } else { 0 }
}

/// The words behind a range that a pass may write to.
struct Guard {
    buffer: vk::Buffer,
    start: u64,
    bytes: u64,
    /// Behind the buffer's content, and not within it.
    is_behind: bool,
    binding: &'static str,
    /// The first and the last pass that may write to the range.
    passes: [&'static str; 2],
}

/// The guards of a recording.
#[derive(Default)]
pub struct Guards {
    guards: Vec<Guard>,
    /// The words of each guard, before and after.
    pages: Vec<Buffer<u32>>,
    /// The ranges that the recording's commands may write to.
    written: Vec<RawSlice>,
}

impl Guards {
    /// A command writes to this range.
    pub fn note_write(&mut self, slice: RawSlice) {
        if records_checks() {
            self.written.push(slice);
        }
    }

    /// A pass may write to this range. Records, outside of passes, what makes the words behind it known, unless they
    /// are: true if a barrier must follow.
    pub fn watch(
        &mut self,
        context: &Arc<Context>,
        commands: vk::CommandBuffer,
        names: (&'static str, &'static str),
        slice: RawSlice,
    ) -> Result<bool, Error> {
        if !records_checks() {
            return Ok(false);
        }
        let (pass, binding) = names;
        self.written.push(slice);
        let start = slice.offset + slice.bytes;
        if let Some(known) = self.guards.iter_mut().find(|g| g.buffer == slice.buffer && g.start == start) {
            known.passes[1] = pass;
            return Ok(false);
        }
        let is_behind = start == slice.room;
        let bytes = if is_behind { BYTES } else { BYTES.min(slice.room - start) };
        let guard = Guard { buffer: slice.buffer, start, bytes, is_behind, binding, passes: [pass; 2] };
        if self.guards.len() as u64 == PAGE * self.pages.len() as u64 {
            self.pages.push(Buffer::new(context, "guard words", 2 * PAGE * BYTES / 4, Memory::Readback)?);
        }
        full_barrier(context, commands);
        if is_behind {
            // SAFETY: every buffer has as many bytes behind its content.
            unsafe { context.device.cmd_fill_buffer(commands, guard.buffer, start, bytes, WORD) };
        } else {
            self.copy(context, commands, self.guards.len(), &guard, 0);
        }
        self.guards.push(guard);
        Ok(true)
    }

    /// Records, after all passes, that the words come to the host.
    pub fn finish(&self, context: &Context, commands: vk::CommandBuffer) {
        if self.guards.is_empty() {
            return;
        }
        full_barrier(context, commands);
        for (number, guard) in self.guards.iter().enumerate() {
            self.copy(context, commands, number, guard, 1);
        }
    }

    fn copy(&self, context: &Context, commands: vk::CommandBuffer, number: usize, guard: &Guard, after: u64) {
        let (page, place) = (number as u64 / PAGE, number as u64 % PAGE);
        let page = &self.pages[page as usize];
        let to = (2 * place + after) * BYTES;
        let region = [vk::BufferCopy { src_offset: guard.start, dst_offset: to, size: guard.bytes }];
        // SAFETY: the words lie within their buffer, and each place of a page has room for two guards.
        unsafe { context.device.cmd_copy_buffer(commands, guard.buffer, page.all().raw().buffer, &region) };
    }

    /// After the submission: an error that names the first words that no pass may have written.
    pub fn check(&self, context: &Context) -> Result<(), Error> {
        for (number, guard) in self.guards.iter().enumerate() {
            let (page, place) = (number as u64 / PAGE, number as u64 % PAGE);
            let words = self.pages[page as usize].mapped_slice();
            let first = (2 * place * BYTES / 4) as usize;
            let (known, found) = words[first..].split_at((BYTES / 4) as usize);
            let changed = (0..(guard.bytes / 4) as usize).find(|&i| {
                let at = guard.start + 4 * i as u64;
                let wanted = if guard.is_behind { WORD } else { known[i] };
                found[i] != wanted && !self.is_written(guard.buffer, at)
            });
            if let Some(word) = changed {
                let [first, last] = guard.passes;
                return Err(Error::Overrun {
                    buffer: context.name_of((vk::Buffer::TYPE, guard.buffer.as_raw())),
                    binding: guard.binding,
                    passes: if first == last { first.to_owned() } else { format!("{first} to {last}") },
                    bytes: 4 * word as u64,
                    word: found[word],
                });
            }
        }
        Ok(())
    }

    fn is_written(&self, buffer: vk::Buffer, at: u64) -> bool {
        self.written.iter().any(|w| w.buffer == buffer && (w.offset..w.offset + w.bytes).contains(&at))
    }
}
