//! Binding of a pass's resources.

use ash::vk;

use super::Recorder;
use super::barriers::Touch;
use super::draw::READ;
use crate::guard;
use crate::pipeline::Pipeline;
use crate::{Access, Context, Declaration, Error, RawSlice, Resource};

/// Descriptor sets and storage descriptors of one pool.
const POOL_SETS: u32 = 128;

impl Recorder<'_> {
    pub(super) fn descriptors(
        &mut self,
        pass: &Declaration,
        pipeline: &Pipeline,
        name: &'static str,
        resources: &[Resource],
    ) -> Result<(vk::DescriptorSet, Vec<Touch>), Error> {
        let limit = self.context.limits.binding_bytes;
        let needed = resources.len() as u32;
        if self.sets_left == 0 || self.descriptors_left < needed {
            self.next_pool()?;
        }
        self.sets_left -= 1;
        self.descriptors_left -= needed;
        let layouts = [pipeline.set_layout];
        let pool = self.taken.as_ref().and_then(|taken| taken.descriptor_pools.get(self.pools - 1));
        let pool = *pool.unwrap_or(&vk::DescriptorPool::null());
        let info = vk::DescriptorSetAllocateInfo::default().descriptor_pool(pool).set_layouts(&layouts);
        // SAFETY: the pool has room for the set: counted above.
        let set = unsafe { self.context.device.allocate_descriptor_sets(&info) }
            .map_err(Error::call("vkAllocateDescriptorSets"))?[0];
        let (mut buffers, mut images, mut touches) = (Vec::new(), Vec::new(), Vec::new());
        for (resource, binding) in resources.iter().zip((pass.bindings)()) {
            match *resource {
                Resource::Buffer(RawSlice { bytes, .. }) if bytes > limit => {
                    let (name, limit_name) = (name.to_owned(), "maxStorageBufferRange");
                    return Err(Error::TooLarge { name, bytes, limit, limit_name });
                }
                Resource::Buffer(slice @ RawSlice { buffer, offset, bytes, .. }) => {
                    assert!(bytes > 0, "{name}: nothing is bound to {}", binding.name);
                    if binding.access == Access::ReadWrite
                        && self.guards.watch(&self.context, self.commands, (name, binding.name), slice)?
                    {
                        self.touch_more();
                    }
                    let guard = if binding.access == Access::Uniform { 0 } else { guard::bytes() };
                    // A buffer that fills the device's limit goes without, which only makes its `arrayLength` too
                    // short.
                    let range = (bytes + guard).min(self.context.limits.range_bytes.max(bytes));
                    buffers.push([vk::DescriptorBufferInfo { buffer, offset, range }]);
                    let writes = binding.access == Access::ReadWrite;
                    touches.push(Touch { slice: RawSlice { bytes: range, ..slice }, writes });
                }
                Resource::Texture(view) => {
                    images.push([vk::DescriptorImageInfo::default().image_view(view).image_layout(READ)]);
                }
            }
        }
        let (mut buffers, mut images) = (buffers.iter(), images.iter());
        let writes: Vec<_> = (0u32..)
            .zip(&pipeline.descriptor_types)
            .map(|(i, ty)| {
                let write = vk::WriteDescriptorSet::default().dst_set(set).dst_binding(i).descriptor_type(*ty);
                match *ty {
                    vk::DescriptorType::SAMPLED_IMAGE => write.image_info(images.next().map_or(&[], |i| i)),
                    _ => write.buffer_info(buffers.next().map_or(&[], |b| b)),
                }
            })
            .collect();
        // SAFETY: set, buffers and images are live; ranges lie within the buffers.
        unsafe { self.context.device.update_descriptor_sets(&writes, &[]) };
        Ok((set, touches))
    }

    /// Goes on with the next pool, which is made unless it was kept.
    fn next_pool(&mut self) -> Result<(), Error> {
        let per_set = 16;
        let Some(taken) = &mut self.taken else { return Ok(()) };
        if taken.descriptor_pools.len() == self.pools {
            taken.descriptor_pools.push(new_pool(&self.context, per_set)?);
        }
        self.pools += 1;
        (self.sets_left, self.descriptors_left) = (POOL_SETS, per_set * POOL_SETS);
        Ok(())
    }
}

/// Makes a pool of descriptor sets.
fn new_pool(context: &Context, per_set: u32) -> Result<vk::DescriptorPool, Error> {
    let sizes = [
        vk::DescriptorPoolSize { ty: vk::DescriptorType::STORAGE_BUFFER, descriptor_count: per_set * POOL_SETS },
        vk::DescriptorPoolSize { ty: vk::DescriptorType::UNIFORM_BUFFER, descriptor_count: per_set * POOL_SETS },
        vk::DescriptorPoolSize { ty: vk::DescriptorType::SAMPLED_IMAGE, descriptor_count: per_set * POOL_SETS },
    ];
    let info = vk::DescriptorPoolCreateInfo::default().max_sets(POOL_SETS).pool_sizes(&sizes);
    // SAFETY: a live device; the pool is destroyed with the command buffer that it is kept with.
    unsafe { context.device.create_descriptor_pool(&info, None) }.map_err(Error::call("vkCreateDescriptorPool"))
}
