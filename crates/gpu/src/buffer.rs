//! Typed buffers: allocated by name, filled by the host itself or through small staging buffers, and read back through
//! these.

use std::ffi::c_void;
use std::marker::PhantomData;
use std::ops::Range;
use std::ptr::NonNull;
use std::sync::Arc;
use std::sync::atomic::Ordering;

use ash::vk::{self, Handle};
use gpu_allocator::MemoryLocation;
use gpu_allocator::vulkan::Allocation;

use super::deletions::Deletion;
use super::{Context, Error, GpuType, Limits, Recorder, Stamps, guard};

/// Bytes of the staging buffer that uploads to GPUs and read-backs pass through.
const STAGING_BYTES: u64 = 16 << 20;

/// The limit below which an allocation needs no more than free memory.
const PROMISED: &str = "maxMemoryAllocationSize";

/// The memory of a buffer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Memory {
    /// Fast for the device; reached by copies.
    Device,
    /// Written by the host, read by the device.
    Upload,
    /// Written by the device, read by the host.
    Readback,
}

impl Memory {
    fn location(self) -> MemoryLocation {
        match self {
            Self::Device => MemoryLocation::GpuOnly,
            Self::Upload => MemoryLocation::CpuToGpu,
            Self::Readback => MemoryLocation::GpuToCpu,
        }
    }
}

/// A buffer of `len` elements of `T`.
pub struct Buffer<T> {
    context: Arc<Context>,
    name: String,
    raw: vk::Buffer,
    allocation: Option<Allocation>,
    len: u64,
    element: PhantomData<T>,
}

impl<T: GpuType> Buffer<T> {
    pub(super) fn new(context: &Arc<Context>, name: &str, len: u64, memory: Memory) -> Result<Self, Error> {
        let too_large = |bytes, limit, limit_name| Error::TooLarge { name: name.to_owned(), bytes, limit, limit_name };
        let Limits { allocation_bytes, buffer_bytes, .. } = context.limits;
        let limit_name = if context.info.prefers.large_allocations { "maxBufferSize" } else { PROMISED };
        let bytes = len.max(1).saturating_mul(size_of::<T>() as u64);
        if bytes > buffer_bytes {
            return Err(too_large(bytes, buffer_bytes, limit_name));
        }
        let is_promised = bytes <= allocation_bytes;
        // The limit leaves room for the guard.
        let bytes = bytes + guard::bytes();
        let conditional = vk::BufferUsageFlags::CONDITIONAL_RENDERING_EXT;
        let usage = if context.conditional.is_some() { conditional } else { vk::BufferUsageFlags::empty() }
            | vk::BufferUsageFlags::STORAGE_BUFFER
            | vk::BufferUsageFlags::UNIFORM_BUFFER
            | vk::BufferUsageFlags::INDIRECT_BUFFER
            | vk::BufferUsageFlags::TRANSFER_SRC
            | vk::BufferUsageFlags::TRANSFER_DST;
        let info = vk::BufferCreateInfo::default().size(bytes).usage(usage).sharing_mode(vk::SharingMode::EXCLUSIVE);
        // SAFETY: a live device; the handle is destroyed in drop.
        let raw =
            unsafe { context.device.create_buffer(&info, None) }.map_err(|_| context.out_of_memory(name, bytes))?;
        let mut buffer =
            Self { context: context.clone(), name: name.to_owned(), raw, allocation: None, len, element: PhantomData };
        // SAFETY: `raw` was just made from this device.
        let requirements = unsafe { context.device.get_buffer_memory_requirements(raw) };
        let allocation = match context.allocate(name, bytes, requirements, (memory.location(), true)) {
            // The device gives no more than it promises.
            Err(Error::OutOfMemory { .. }) if !is_promised => Err(too_large(bytes, allocation_bytes, PROMISED)),
            allocated => allocated,
        }?;
        // SAFETY: the memory is fresh and large enough, at the offset that the allocator aligned.
        let bound = unsafe { context.device.bind_buffer_memory(raw, allocation.memory(), allocation.offset()) };
        context.note_allocation((vk::Buffer::TYPE, raw.as_raw()), name, requirements.size);
        buffer.allocation = Some(allocation);
        bound.map_err(Error::call("vkBindBufferMemory"))?;
        Ok(buffer)
    }

    /// Returns the number of elements.
    pub fn len(&self) -> u64 {
        self.len
    }

    /// Returns `true` for a buffer without elements (it still has memory for one).
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Returns `true` if it belongs to this device.
    #[doc(hidden)]
    pub fn is_of(&self, context: &Arc<Context>) -> bool {
        Arc::ptr_eq(&self.context, context)
    }

    /// Returns the size of the content in bytes.
    pub fn bytes(&self) -> u64 {
        self.len * size_of::<T>() as u64
    }

    /// Returns the whole buffer.
    pub fn all(&self) -> Slice<'_, T> {
        self.slice(0, self.len.max(1))
    }

    /// `len` elements from `start`.
    pub fn slice(&self, start: u64, len: u64) -> Slice<'_, T> {
        assert!(start.checked_add(len).is_some_and(|end| end <= self.len.max(1)), "{}: slice out of range", self.name);
        let size = size_of::<T>() as u64;
        Slice { raw: self.raw_slice(start * size, len * size), name: &self.name, element: PhantomData }
    }

    fn raw_slice(&self, offset: u64, bytes: u64) -> RawSlice {
        RawSlice { buffer: self.raw, offset, bytes, room: self.len.max(1) * size_of::<T>() as u64 }
    }

    /// Copies `data` to the front of the buffer and waits for it.
    pub fn upload(&self, data: &[T]) -> Result<(), Error> {
        self.upload_by(data.len() as u64, |range, to| to.copy_from_slice(&data[range]))
    }

    /// Fills the first `len` elements of the buffer, some after others, and waits for it: `fill` puts those of a range
    /// there. No copy of all of them is made on the host.
    pub fn upload_by(&self, len: u64, fill: impl Fn(Range<usize>, &mut [T])) -> Result<(), Error> {
        assert!(len <= self.len.max(1), "{}: upload larger than the buffer", self.name);
        let size = size_of::<T>() as u64;
        self.context.uploaded.fetch_add(len * size, Ordering::Relaxed);
        if let Some(memory) = self.host_memory() {
            let len = usize::try_from(len).unwrap_or(usize::MAX);
            // SAFETY: the buffer has room for `len` elements of plain data, at an address that Vulkan aligns for any of
            // them. Each submission is waited for, so that no pass uses the buffer now; the next one sees what the host
            // wrote before it. Only the thread that renders with a buffer uploads to it.
            let elements = unsafe { std::slice::from_raw_parts_mut(memory.cast::<T>().as_ptr(), len) };
            fill(0..len, elements);
            return Ok(());
        }
        let most = (STAGING_BYTES / size).clamp(1, len.max(1));
        let mut staging = Buffer::<T>::new(&self.context, "staging", most, Memory::Upload)?;
        let mut first = 0;
        while first < len {
            let count = most.min(len - first);
            let elements = bytemuck::cast_slice_mut(&mut staging.mapped_mut()[..(count * size) as usize]);
            fill(first as usize..(first + count) as usize, elements);
            let mut recorder = Recorder::new(&self.context, Stamps::None)?;
            recorder.copy_raw("upload", staging.raw_slice(0, count * size), self.raw_slice(first * size, count * size));
            recorder.submit("upload")?;
            first += count;
        }
        Ok(())
    }

    /// Returns the content of a slice of a device buffer, after all submitted work.
    pub fn read(&self, start: u64, len: u64) -> Result<Vec<T>, Error> {
        let source = self.slice(start, len.max(1)).raw;
        let mut out = vec![T::zeroed(); usize::try_from(len).unwrap_or(usize::MAX)];
        let out_bytes: &mut [u8] = bytemuck::cast_slice_mut(&mut out);
        let staging_bytes = STAGING_BYTES.min(out_bytes.len() as u64).max(4);
        let staging = Buffer::<u32>::new(&self.context, "staging", staging_bytes.div_ceil(4), Memory::Readback)?;
        let mut offset = 0;
        for chunk in out_bytes.chunks_mut(staging_bytes as usize) {
            let bytes = chunk.len() as u64;
            let mut recorder = Recorder::new(&self.context, Stamps::None)?;
            let from = self.raw_slice(source.offset + offset, bytes);
            recorder.copy_raw("read-back", from, staging.raw_slice(0, bytes));
            recorder.submit("read-back")?;
            chunk.copy_from_slice(&staging.mapped()[..chunk.len()]);
            offset += bytes;
        }
        Ok(out)
    }

    /// Writes to the front of a [`Memory::Upload`] buffer.
    pub fn write(&mut self, data: &[T]) {
        let bytes: &[u8] = bytemuck::cast_slice(data);
        self.mapped_mut()[..bytes.len()].copy_from_slice(bytes);
    }

    /// Returns the content of a [`Memory::Readback`] buffer.
    pub fn mapped_slice(&self) -> &[T] {
        &bytemuck::cast_slice(self.mapped())[..self.len as usize]
    }

    /// The memory of the buffer, where the host may write to it: that of a CPU driver is the host's. On a GPU whose own
    /// memory can be mapped, a copy by the device is not slower.
    fn host_memory(&self) -> Option<NonNull<c_void>> {
        let allocation = self.allocation.as_ref().filter(|_| self.context.info.prefers.host_writes)?;
        let coherent = vk::MemoryPropertyFlags::HOST_VISIBLE | vk::MemoryPropertyFlags::HOST_COHERENT;
        allocation.memory_properties().contains(coherent).then(|| allocation.mapped_ptr()).flatten()
    }

    fn mapped(&self) -> &[u8] {
        let mapped = self.allocation.as_ref().and_then(Allocation::mapped_slice);
        let size = usize::try_from(self.len.max(1) * size_of::<T>() as u64).unwrap_or(usize::MAX);
        &mapped.expect("host-visible buffers are mapped")[..size]
    }

    fn mapped_mut(&mut self) -> &mut [u8] {
        let mapped = self.allocation.as_mut().and_then(Allocation::mapped_slice_mut);
        mapped.expect("host-visible buffers are mapped")
    }
}

impl<T> Drop for Buffer<T> {
    fn drop(&mut self) {
        self.context.delete(Deletion::Buffer(self.raw, self.allocation.take()));
    }
}

/// A range of a buffer without its type.
#[derive(Debug, Clone, Copy)]
pub struct RawSlice {
    #[doc(hidden)]
    pub buffer: vk::Buffer,
    #[doc(hidden)]
    pub offset: u64,
    pub(super) bytes: u64,
    /// Bytes of the buffer's content.
    pub(super) room: u64,
}

/// A range of a typed buffer, to be bound or copied.
#[derive(Debug)]
pub struct Slice<'a, T> {
    raw: RawSlice,
    name: &'a str,
    element: PhantomData<T>,
}

impl<T> Clone for Slice<'_, T> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<T> Copy for Slice<'_, T> {}

impl<'a, T: GpuType> From<&'a Buffer<T>> for Slice<'a, T> {
    fn from(buffer: &'a Buffer<T>) -> Self {
        buffer.all()
    }
}

impl<'a, T> Slice<'a, T> {
    /// Returns the number of elements.
    pub fn len(&self) -> u64 {
        self.raw.bytes / size_of::<T>() as u64
    }

    /// Returns `true` if there are no elements.
    pub fn is_empty(&self) -> bool {
        self.raw.bytes == 0
    }

    /// Returns the number of elements of the buffer before the first.
    pub fn start(&self) -> u64 {
        self.raw.offset / size_of::<T>() as u64
    }

    /// Returns the same bytes as elements of another type; their number must come out whole.
    pub fn cast<U: GpuType>(self) -> Slice<'a, U> {
        assert_eq!(self.raw.bytes % size_of::<U>() as u64, 0, "{}: not a whole number of elements", self.name);
        Slice { raw: self.raw, name: self.name, element: PhantomData }
    }

    /// Returns the first `len` elements.
    pub fn first(self, len: u64) -> Self {
        assert!(len <= self.len(), "{}: slice out of range", self.name);
        Self { raw: RawSlice { bytes: len * size_of::<T>() as u64, ..self.raw }, ..self }
    }

    /// Returns all but the first `count` elements.
    pub fn skip(self, count: u64) -> Self {
        assert!(count <= self.len(), "{}: slice out of range", self.name);
        let bytes = count * size_of::<T>() as u64;
        Self { raw: RawSlice { offset: self.raw.offset + bytes, bytes: self.raw.bytes - bytes, ..self.raw }, ..self }
    }

    /// Returns the slice from the aligned place before it on, and the number of elements that it has before its own
    /// first one.
    pub(super) fn reaching_back(self, alignment: u64) -> (Self, u32) {
        let before = self.raw.offset % alignment;
        let raw = RawSlice { offset: self.raw.offset - before, bytes: self.raw.bytes + before, ..self.raw };
        (Self { raw, ..self }, (before / size_of::<T>() as u64) as u32)
    }

    /// Returns the buffer's name.
    pub fn name(&self) -> &str {
        self.name
    }

    /// Returns the range without its type.
    pub fn raw(&self) -> RawSlice {
        self.raw
    }
}
