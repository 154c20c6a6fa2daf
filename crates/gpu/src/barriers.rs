//! Barriers between passes.

use ash::vk;

use super::Context;

/// Makes everything written before visible to everything that comes after.
pub(crate) fn full_barrier(context: &Context, commands: vk::CommandBuffer) {
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
