//! Resources whose destruction waits for interrupted recordings.

use ash::vk;
use gpu_allocator::vulkan::Allocation;

/// Handles and memory that nobody but an interrupted recording may need.
pub enum Deletion {
    Buffer(vk::Buffer, Option<Allocation>),
    Image(vk::Image, vk::ImageView, Option<Allocation>),
}

/// Resources that wait for the end of interrupted recordings, and the number of those recordings.
#[derive(Default)]
pub struct Deletions {
    pub recordings: usize,
    pub waiting: Vec<Deletion>,
}
