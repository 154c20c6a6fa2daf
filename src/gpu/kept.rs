use super::{Buffer, Device, Error, GpuType, Memory};

/// A buffer that is kept from frame to frame and only grows.
pub struct Kept<T> {
    name: &'static str,
    memory: Memory,
    buffer: Option<Buffer<T>>,
}

impl<T: GpuType> Kept<T> {
    /// Nothing yet.
    pub fn new(name: &'static str, memory: Memory) -> Self {
        Self { name, memory, buffer: None }
    }

    /// Makes sure there is room for `len` elements; what was there before may be lost.
    pub fn reserve(&mut self, device: &Device, len: u64) -> Result<(), Error> {
        if self.buffer.as_ref().is_none_or(|b| b.len() < len) {
            // Freed first, so that old and new never exist together.
            self.buffer = None;
            self.buffer = Some(device.buffer(self.name, len, self.memory)?);
        }
        Ok(())
    }

    /// Frees the memory.
    pub fn release(&mut self) {
        self.buffer = None;
    }

    /// The buffer; there must have been a [`Self::reserve`].
    pub fn get(&self) -> &Buffer<T> {
        self.buffer.as_ref().expect("reserved before use")
    }
}
