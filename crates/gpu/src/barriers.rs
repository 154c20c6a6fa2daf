//! Barriers between passes.

use ash::vk;

use super::Context;

/// Makes everything written before visible to everything that comes after.
pub fn full_barrier(context: &Context, commands: vk::CommandBuffer) {
    let all = vk::PipelineStageFlags2::ALL_COMMANDS;
    let barrier = [vk::MemoryBarrier2::default()
        .src_stage_mask(all)
        .src_access_mask(vk::AccessFlags2::MEMORY_WRITE)
        .dst_stage_mask(all)
        .dst_access_mask(vk::AccessFlags2::MEMORY_READ | vk::AccessFlags2::MEMORY_WRITE)];
    let dependency = vk::DependencyInfo::default().memory_barriers(&barrier);
    // SAFETY: the command buffer is recording outside of a render pass; the barrier has no resources.
    unsafe { context.device.cmd_pipeline_barrier2(commands, &dependency) };
}

/// Makes what dispatches wrote before visible to dispatches that come after, and lets these wait for those.
pub fn compute_barrier(context: &Context, commands: vk::CommandBuffer) {
    let compute = vk::PipelineStageFlags2::COMPUTE_SHADER;
    let read = vk::AccessFlags2::SHADER_STORAGE_READ | vk::AccessFlags2::UNIFORM_READ;
    let barrier = [vk::MemoryBarrier2::default()
        .src_stage_mask(compute)
        .src_access_mask(vk::AccessFlags2::SHADER_STORAGE_WRITE)
        .dst_stage_mask(compute)
        .dst_access_mask(read | vk::AccessFlags2::SHADER_STORAGE_WRITE)];
    let dependency = vk::DependencyInfo::default().memory_barriers(&barrier);
    // SAFETY: the command buffer is recording outside of a render pass; the barrier has no resources.
    unsafe { context.device.cmd_pipeline_barrier2(commands, &dependency) };
}

/// Takes images from one layout to another, after all that was done to them.
pub fn image_barriers(
    context: &Context,
    commands: vk::CommandBuffer,
    images: impl Iterator<Item = (vk::Image, vk::ImageSubresourceRange)>,
    [from, to]: [vk::ImageLayout; 2],
) {
    let all = vk::PipelineStageFlags2::ALL_COMMANDS;
    let barrier = vk::ImageMemoryBarrier2::default()
        .src_stage_mask(all)
        .src_access_mask(vk::AccessFlags2::MEMORY_WRITE)
        .dst_stage_mask(all)
        .dst_access_mask(vk::AccessFlags2::MEMORY_READ | vk::AccessFlags2::MEMORY_WRITE)
        .old_layout(from)
        .new_layout(to);
    let barriers: Vec<_> = images.map(|(image, range)| barrier.image(image).subresource_range(range)).collect();
    if barriers.is_empty() {
        return;
    }
    let dependency = vk::DependencyInfo::default().image_memory_barriers(&barriers);
    // SAFETY: the command buffer is recording outside of a render pass; the images outlive the submission.
    unsafe { context.device.cmd_pipeline_barrier2(commands, &dependency) };
}
