use super::{Buffer, Device, Error, GpuType, Memory};

/// A buffer that is kept from frame to frame while it is large enough.
pub struct Scratch<T> {
    name: &'static str,
    memory: Memory,
    buffer: Option<Buffer<T>>,
}

impl<T: GpuType> Scratch<T> {
    /// Not allocated yet.
    pub fn new(name: &'static str, memory: Memory) -> Self {
        Self { name, memory, buffer: None }
    }

    /// Makes sure it has room for `len` elements; earlier content may be lost.
    pub fn reserve(&mut self, device: &Device, len: u64) -> Result<(), Error> {
        self.reserve_within(device, len, u64::MAX)
    }

    /// Makes sure it has room for `len` elements, but not for more than `limit`; earlier content may be lost.
    pub fn reserve_within(&mut self, device: &Device, len: u64, limit: u64) -> Result<(), Error> {
        if self.buffer.as_ref().is_none_or(|b| b.len() < len || b.len() > limit) {
            // Freed first, so that old and new never exist together.
            self.buffer = None;
            self.buffer = Some(device.buffer(self.name, len, self.memory)?);
        }
        Ok(())
    }

    /// Frees the buffer.
    pub fn release(&mut self) {
        self.buffer = None;
    }

    /// Returns the number of bytes of the buffer, 0 before the first reservation.
    pub fn bytes(&self) -> u64 {
        self.buffer.as_ref().map_or(0, Buffer::bytes)
    }

    /// Returns the buffer; there must have been a [`Self::reserve`].
    pub fn get(&self) -> &Buffer<T> {
        self.buffer.as_ref().expect("reserved before use")
    }

    /// Returns the buffer, to be written to by the host; there must have been a [`Self::reserve`].
    pub fn get_mut(&mut self) -> &mut Buffer<T> {
        self.buffer.as_mut().expect("reserved before use")
    }
}
