//! Vulkan pipelines of passes, built once for each pass and variant.

use std::sync::Arc;
use std::time::{Duration, Instant};

use ash::vk;

use super::{Access, Context, Declaration, Error, Format, Variant, shader};
use crate::pass::PUSH_BYTES;

/// Shader, the piece that it takes, variant, and what a draw has for outputs; `None` for compute.
pub type PipelineKey = (&'static str, Option<&'static str>, String, Option<Outputs>);

/// Combination of a fragment's color with the one that is there.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Blend {
    /// Takes its place.
    Replace,
    /// Is added.
    Add,
    /// Covers what is left: there + color·(1 − there), component by component.
    Cover,
}

/// Outputs of a draw besides storage buffers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Outputs {
    /// A color attachment.
    pub color: Option<(Format, Blend)>,
    /// `true` with a depth attachment, whose test only a nearer fragment passes: of equals the first one drawn stays.
    pub depth: bool,
    /// Samples per pixel.
    pub samples: u32,
}

impl Outputs {
    /// None.
    pub const NONE: Self = Self { color: None, depth: false, samples: 1 };
}

/// The making of a pipeline.
#[derive(Debug, Clone, Copy)]
pub struct Compilation {
    /// Time when it began.
    pub begin: Instant,
    /// Time that it took.
    pub time: Duration,
}

/// Source of a pipeline.
#[derive(Debug, Clone)]
pub struct PipelineSource {
    /// The label under which it ran first, as in `abuffer/resolve-8`.
    pub label: &'static str,
    /// The pass.
    pub pass: &'static str,
    /// Stem of its shader file.
    pub stem: &'static str,
    /// The variant.
    pub variant: Variant,
    /// Outputs of a draw; `None` for compute.
    pub outputs: Option<Outputs>,
}

impl PipelineSource {
    /// Returns a name for people: the label, and what tells the variant from others.
    pub fn title(&self) -> String {
        let overrides = self.variant.overrides.iter().map(|(name, value)| format!("{name}={value}"));
        let constants = self.variant.constants.iter().map(|(name, value)| format!("{name}={value}"));
        let choices: Vec<String> = overrides.chain(constants).collect();
        match choices.is_empty() {
            true => self.label.to_owned(),
            false => format!("{} ({})", self.label, choices.join(", ")),
        }
    }
}

pub struct Pipeline {
    /// Source that it was made from.
    pub made: PipelineSource,
    pub raw: vk::Pipeline,
    pub layout: vk::PipelineLayout,
    pub set_layout: vk::DescriptorSetLayout,
    pub descriptor_types: Vec<vk::DescriptorType>,
    pub push_stages: Option<vk::ShaderStageFlags>,
}

impl Pipeline {
    /// Returns the compute pipeline of a pass, by the label under which it runs.
    pub fn compute(
        context: &Context,
        pass: &Declaration,
        variant: &Variant,
        label: &'static str,
    ) -> Result<Arc<Self>, Error> {
        context.pipeline((pass.shader, pass.piece, variant.key(), None), || {
            let words = shader::compile(pass, variant, context.debug_shaders)?;
            let made = made(pass, label, variant, None);
            Self::build(context, pass, made, vk::ShaderStageFlags::COMPUTE, |layout| {
                let module = Module::new(context, pass.shader, &words)?;
                let mut stage = module.stage(vk::ShaderStageFlags::COMPUTE);
                let mut size = vk::PipelineShaderStageRequiredSubgroupSizeCreateInfo::default();
                if let Some(wanted) = variant.subgroup {
                    size = size.required_subgroup_size(wanted);
                    stage =
                        stage.flags(vk::PipelineShaderStageCreateFlags::REQUIRE_FULL_SUBGROUPS).push_next(&mut size);
                }
                let info = vk::ComputePipelineCreateInfo::default().stage(stage).layout(layout).flags(flags(context));
                // SAFETY: the module and layout live through the call.
                let made = unsafe { context.device.create_compute_pipelines(context.pipeline_cache, &[info], None) };
                made.map(|p| p[0]).map_err(|(_, result)| Error::call("vkCreateComputePipelines")(result))
            })
        })
    }

    /// Returns the graphics pipeline of a pass that draws triangles.
    pub fn draw(
        context: &Context,
        pass: &Declaration,
        variant: &Variant,
        outputs: Outputs,
    ) -> Result<Arc<Self>, Error> {
        context.pipeline((pass.shader, pass.piece, variant.key(), Some(outputs)), || {
            let [vertex, fragment] = shader::compile_draw(pass, variant, context.debug_shaders)?;
            let stages = vk::ShaderStageFlags::VERTEX | vk::ShaderStageFlags::FRAGMENT;
            let made = made(pass, pass.name, variant, Some(outputs));
            Self::build(context, pass, made, stages, |layout| {
                let modules =
                    [Module::new(context, shader::QUAD, &vertex)?, Module::new(context, pass.shader, &fragment)?];
                let stages =
                    [modules[0].stage(vk::ShaderStageFlags::VERTEX), modules[1].stage(vk::ShaderStageFlags::FRAGMENT)];
                let vertices = vk::PipelineVertexInputStateCreateInfo::default();
                let assembly =
                    vk::PipelineInputAssemblyStateCreateInfo::default().topology(vk::PrimitiveTopology::TRIANGLE_LIST);
                let viewport = vk::PipelineViewportStateCreateInfo::default().viewport_count(1).scissor_count(1);
                let rasterization = vk::PipelineRasterizationStateCreateInfo::default().line_width(1.0);
                let multisample = vk::PipelineMultisampleStateCreateInfo::default()
                    .rasterization_samples(vk::SampleCountFlags::from_raw(outputs.samples));
                let dynamic_states = [vk::DynamicState::VIEWPORT, vk::DynamicState::SCISSOR];
                let dynamic = vk::PipelineDynamicStateCreateInfo::default().dynamic_states(&dynamic_states);
                let colors: Vec<_> = outputs.color.iter().map(|(format, _)| format.raw()).collect();
                let blends: Vec<_> = outputs.color.iter().map(|(_, blend)| blend_state(*blend)).collect();
                let blending = vk::PipelineColorBlendStateCreateInfo::default().attachments(&blends);
                let depth = vk::PipelineDepthStencilStateCreateInfo::default()
                    .depth_test_enable(outputs.depth)
                    .depth_write_enable(outputs.depth)
                    .depth_compare_op(vk::CompareOp::LESS);
                let mut rendering = vk::PipelineRenderingCreateInfo::default().color_attachment_formats(&colors);
                if outputs.depth {
                    rendering = rendering.depth_attachment_format(Format::Depth.raw());
                }
                let info = vk::GraphicsPipelineCreateInfo::default()
                    .stages(&stages)
                    .vertex_input_state(&vertices)
                    .input_assembly_state(&assembly)
                    .viewport_state(&viewport)
                    .rasterization_state(&rasterization)
                    .multisample_state(&multisample)
                    .depth_stencil_state(&depth)
                    .color_blend_state(&blending)
                    .dynamic_state(&dynamic)
                    .layout(layout)
                    .flags(flags(context))
                    .push_next(&mut rendering);
                // SAFETY: all states, modules and the layout live through the call.
                let made = unsafe { context.device.create_graphics_pipelines(context.pipeline_cache, &[info], None) };
                made.map(|p| p[0]).map_err(|(_, result)| Error::call("vkCreateGraphicsPipelines")(result))
            })
        })
    }

    fn build(
        context: &Context,
        pass: &Declaration,
        made: PipelineSource,
        stages: vk::ShaderStageFlags,
        make: impl FnOnce(vk::PipelineLayout) -> Result<vk::Pipeline, Error>,
    ) -> Result<Self, Error> {
        let descriptor_types: Vec<_> = (pass.bindings)()
            .iter()
            .map(|b| match b.access {
                Access::Uniform => vk::DescriptorType::UNIFORM_BUFFER,
                Access::Read | Access::ReadWrite => vk::DescriptorType::STORAGE_BUFFER,
                Access::Texture => vk::DescriptorType::SAMPLED_IMAGE,
            })
            .collect();
        let bindings: Vec<_> = (0u32..)
            .zip(&descriptor_types)
            .map(|(i, ty)| {
                vk::DescriptorSetLayoutBinding::default()
                    .binding(i)
                    .descriptor_type(*ty)
                    .descriptor_count(1)
                    .stage_flags(stages)
            })
            .collect();
        let device = &context.device;
        let set_info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&bindings);
        // SAFETY: a live device; destroyed with the pipeline.
        let set_layout = unsafe { device.create_descriptor_set_layout(&set_info, None) }
            .map_err(Error::call("vkCreateDescriptorSetLayout"))?;
        let set_layouts = [set_layout];
        let ranges = [vk::PushConstantRange::default().stage_flags(stages).size(PUSH_BYTES as u32)];
        let mut layout_info = vk::PipelineLayoutCreateInfo::default().set_layouts(&set_layouts);
        let push_stages = (pass.push_shape)().map(|_| stages);
        if push_stages.is_some() {
            layout_info = layout_info.push_constant_ranges(&ranges);
        }
        // SAFETY: as above.
        let layout =
            unsafe { device.create_pipeline_layout(&layout_info, None) }.map_err(Error::call("vkCreatePipelineLayout"));
        let built = layout.and_then(|layout| match make(layout) {
            Ok(raw) => Ok(Self { made, raw, layout, set_layout, descriptor_types, push_stages }),
            Err(e) => {
                // SAFETY: just made, used by nothing.
                unsafe { device.destroy_pipeline_layout(layout, None) };
                Err(e)
            }
        });
        if built.is_err() {
            // SAFETY: just made, used by nothing.
            unsafe { device.destroy_descriptor_set_layout(set_layout, None) };
        }
        built
    }

    /// Destroys the handles.
    ///
    /// # Safety
    /// The device must be idle and nothing recorded with the pipeline be submitted later.
    pub unsafe fn destroy(&self, device: &ash::Device) {
        // SAFETY: by the caller.
        unsafe {
            device.destroy_pipeline(self.raw, None);
            device.destroy_pipeline_layout(self.layout, None);
            device.destroy_descriptor_set_layout(self.set_layout, None);
        }
    }
}

fn made(pass: &Declaration, label: &'static str, variant: &Variant, outputs: Option<Outputs>) -> PipelineSource {
    PipelineSource { label, pass: pass.name, stem: pass.shader, variant: variant.clone(), outputs }
}

fn flags(context: &Context) -> vk::PipelineCreateFlags {
    match context.executables {
        Some(_) => vk::PipelineCreateFlags::CAPTURE_STATISTICS_KHR,
        None => vk::PipelineCreateFlags::empty(),
    }
}

fn blend_state(blend: Blend) -> vk::PipelineColorBlendAttachmentState {
    let source = match blend {
        Blend::Replace | Blend::Add => vk::BlendFactor::ONE,
        Blend::Cover => vk::BlendFactor::ONE_MINUS_DST_COLOR,
    };
    // For alpha the factor of color means that of alpha.
    vk::PipelineColorBlendAttachmentState::default()
        .blend_enable(blend != Blend::Replace)
        .src_color_blend_factor(source)
        .dst_color_blend_factor(vk::BlendFactor::ONE)
        .src_alpha_blend_factor(source)
        .dst_alpha_blend_factor(vk::BlendFactor::ONE)
        .color_write_mask(vk::ColorComponentFlags::RGBA)
}

/// A shader module, destroyed as soon as its pipeline is built.
struct Module<'a> {
    context: &'a Context,
    raw: vk::ShaderModule,
}

impl<'a> Module<'a> {
    fn new(context: &'a Context, name: &str, words: &[u32]) -> Result<Self, Error> {
        let info = vk::ShaderModuleCreateInfo::default().code(words);
        // SAFETY: the words come from naga's validated module or our checksummed cache.
        let raw =
            unsafe { context.device.create_shader_module(&info, None) }.map_err(Error::call("vkCreateShaderModule"))?;
        context.name_object(raw, name);
        Ok(Self { context, raw })
    }

    fn stage(&self, stage: vk::ShaderStageFlags) -> vk::PipelineShaderStageCreateInfo<'static> {
        vk::PipelineShaderStageCreateInfo::default().stage(stage).module(self.raw).name(c"main")
    }
}

impl Drop for Module<'_> {
    fn drop(&mut self) {
        // SAFETY: pipelines do not need their modules once they exist.
        unsafe { self.context.device.destroy_shader_module(self.raw, None) };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Pass;

    #[test]
    fn titles_tell_variants_apart() {
        let title = |variant: &Variant| made(&crate::Agree::DECLARATION, "abuffer/store", variant, None).title();
        assert_eq!(title(&Variant::plain()), "abuffer/store");
        let variant = Variant::plain().with("STEP", 2).constant("CAPACITY", 8);
        assert_eq!(title(&variant), "abuffer/store (STEP=2, CAPACITY=8u)");
    }
}
