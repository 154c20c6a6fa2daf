//! Values for each pixel that come to the host with the frame, so that nobody waits for a copy of their own.

use super::Error;
use crate::gpu::{Buffer, Device, GpuType, Memory, Recorder, Scratch};

/// Most bytes that come with a frame: those of 32 bits for each pixel of full HD. More come by a copy of their own.
const MOST_BYTES: u64 = 8 << 20;

/// The host's copy of the front of a buffer.
pub(super) struct Told<T> {
    host: Scratch<T>,
    len: u64,
}

impl<T: GpuType> Told<T> {
    pub fn new(name: &'static str) -> Self {
        Self { host: Scratch::new(name, Memory::Readback), len: 0 }
    }

    /// Makes room for so many elements: none, if they are not wanted. The same, if they are too many.
    pub fn reserve(&mut self, device: &Device, len: u64) -> Result<(), Error> {
        self.len = if len * size_of::<T>() as u64 <= MOST_BYTES { len } else { 0 };
        if self.len > 0 {
            self.host.reserve(device, len)?;
        } else {
            self.host.release();
        }
        Ok(())
    }

    /// Records the copy, if there is room for it.
    pub fn record<'a>(&'a self, recorder: &mut Recorder<'a>, buffer: &'a Buffer<T>) {
        if self.len > 0 {
            recorder.copy_untimed(buffer.slice(0, self.len), self.host.get().slice(0, self.len));
        }
    }

    /// Returns the first `len` elements: those of the copy, which must have been submitted, or else those of the buffer
    /// now.
    pub fn read(&self, buffer: &Buffer<T>, len: u64) -> Result<Vec<T>, Error> {
        if self.len == len {
            return Ok(self.host.get().mapped_slice()[..len as usize].to_vec());
        }
        Ok(buffer.read(0, len)?)
    }
}
