//! Command buffers, and what is made anew for each recording only once: a fence, and pools of descriptor sets.

use ash::vk;

use super::Error;

/// Most pools of descriptor sets that are kept with a command buffer.
const KEPT_POOLS: usize = 8;

/// A command buffer and its pool, with a fence for its submission and pools for the sets that it binds. Recording uses
/// all of them, and a pool must not be used from two threads at once, so that each recorder has its own.
pub struct Commands {
    pub pool: vk::CommandPool,
    pub buffer: vk::CommandBuffer,
    /// Signaled by the submission; not signaled before.
    pub fence: vk::Fence,
    /// Pools of the same size, the first ones of which the recording uses.
    pub descriptor_pools: Vec<vk::DescriptorPool>,
}

impl Commands {
    /// Makes all of it for a family of queues.
    pub fn new(device: &ash::Device, queue_family: u32) -> Result<Self, Error> {
        let info = vk::CommandPoolCreateInfo::default().queue_family_index(queue_family);
        // SAFETY: a live device; what is made is destroyed by `destroy`, here where not all of it can be made.
        unsafe {
            let pool = device.create_command_pool(&info, None).map_err(Error::call("vkCreateCommandPool"))?;
            let mut commands = Self {
                pool,
                buffer: vk::CommandBuffer::null(),
                fence: vk::Fence::null(),
                descriptor_pools: Vec::new(),
            };
            let info = vk::CommandBufferAllocateInfo::default().command_pool(pool).command_buffer_count(1);
            let buffer = device.allocate_command_buffers(&info).map_err(Error::call("vkAllocateCommandBuffers"));
            let fence =
                device.create_fence(&vk::FenceCreateInfo::default(), None).map_err(Error::call("vkCreateFence"));
            commands.fence = *fence.as_ref().unwrap_or(&vk::Fence::null());
            match (buffer, fence) {
                (Ok(buffers), Ok(_)) => {
                    commands.buffer = buffers[0];
                    Ok(commands)
                }
                (Err(error), _) | (_, Err(error)) => {
                    commands.destroy(device);
                    Err(error)
                }
            }
        }
    }

    /// Destroys all of it.
    ///
    /// # Safety
    /// The command buffer must not be pending on this device.
    pub unsafe fn destroy(self, device: &ash::Device) {
        // SAFETY: the caller vouches that nothing is in use; null handles are ignored.
        unsafe {
            for pool in self.descriptor_pools {
                device.destroy_descriptor_pool(pool, None);
            }
            device.destroy_fence(self.fence, None);
            device.destroy_command_pool(self.pool, None);
        }
    }

    /// Makes all of it as if new.
    ///
    /// # Safety
    /// The command buffer must not be pending on this device.
    pub unsafe fn reset(&mut self, device: &ash::Device) -> Result<(), vk::Result> {
        let surplus = self.descriptor_pools.split_off(self.descriptor_pools.len().min(KEPT_POOLS));
        // SAFETY: the caller vouches that nothing is in use.
        unsafe {
            for pool in surplus {
                device.destroy_descriptor_pool(pool, None);
            }
            for pool in &self.descriptor_pools {
                device.reset_descriptor_pool(*pool, vk::DescriptorPoolResetFlags::empty())?;
            }
            device.reset_fences(&[self.fence])?;
            device.reset_command_pool(self.pool, vk::CommandPoolResetFlags::empty())
        }
    }
}
