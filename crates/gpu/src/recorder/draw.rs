//! Passes that draw into attachments.

use ash::vk;

use super::Recorder;
use super::barriers::Kind;
use crate::barriers::image_barriers;
use crate::pipeline::{Outputs, Pipeline};
use crate::{Attachment, Blend, Declaration, Error, Pass, RawSlice, Resource, Slice, Variant};

/// Number of vertices of a draw.
#[derive(Debug, Clone, Copy)]
pub enum Vertices<'a> {
    /// So many.
    Count(u32),
    /// Vertices, instances, first vertex and first instance from a buffer (its first four elements).
    Indirect(Slice<'a, u32>),
}

/// Attachments that are drawn into, all of one size and number of samples.
#[derive(Clone, Copy, Default)]
pub struct Targets<'a> {
    /// The color attachment, and what fragments do to it.
    pub color: Option<(&'a Attachment, Blend)>,
    /// The depth attachment: the nearest fragment stays, the first of equals.
    pub depth: Option<&'a Attachment>,
    /// The value of every component of the color attachment at first, with depths at 1; `None`: what an earlier draw
    /// left.
    pub clear: Option<f32>,
}

impl<'a> Targets<'a> {
    fn images(&self) -> impl Iterator<Item = &'a Attachment> {
        self.color.map(|(image, _)| image).into_iter().chain(self.depth)
    }

    fn outputs(&self) -> Outputs {
        Outputs {
            color: self.color.map(|(image, blend)| (image.format, blend)),
            depth: self.depth.is_some(),
            samples: self.images().next().map_or(1, |image| image.samples),
        }
    }

    fn info(&self, image: &Attachment, clear: vk::ClearValue) -> vk::RenderingAttachmentInfo<'static> {
        let load = if self.clear.is_some() { vk::AttachmentLoadOp::CLEAR } else { vk::AttachmentLoadOp::LOAD };
        vk::RenderingAttachmentInfo::default()
            .image_view(image.view)
            .image_layout(DRAWN)
            .load_op(load)
            .store_op(vk::AttachmentStoreOp::STORE)
            .clear_value(clear)
    }
}

/// A draw of plain triangles from pulled vertices, into storage buffers and attachments.
#[derive(Clone, Copy)]
pub struct Draw<'a> {
    /// Vertices.
    pub vertices: Vertices<'a>,
    /// Width and height of the area in pixels.
    pub area: [u32; 2],
    /// Attachments, if any, of that size at least.
    pub targets: Targets<'a>,
}

/// The layout in which attachments are drawn into.
const DRAWN: vk::ImageLayout = vk::ImageLayout::ATTACHMENT_OPTIMAL;
/// The layout in which they are read, and in which they lie between passes.
pub(super) const READ: vk::ImageLayout = vk::ImageLayout::READ_ONLY_OPTIMAL;

impl<'a> Recorder<'a> {
    /// Runs a pass that draws, with its push constants as in [`Self::run`].
    pub fn draw<P: Pass + 'a>(
        &mut self,
        pass: &P,
        push: P::Push,
        variant: &Variant,
        draw: Draw<'a>,
    ) -> Result<(), Error> {
        self.draw_declared(&P::DECLARATION, &pass.resources(), bytemuck::bytes_of(&push), variant, draw)
    }

    fn draw_declared(
        &mut self,
        pass: &Declaration,
        resources: &[Resource],
        push: &[u8],
        variant: &Variant,
        draw: Draw<'a>,
    ) -> Result<(), Error> {
        let (size, limit) = (draw.area, self.context.limits.framebuffer);
        if size[0] > limit[0] || size[1] > limit[1] {
            return Err(Error::Framebuffer { name: pass.name.to_owned(), size, limit });
        }
        let variant = self.variant(pass, variant)?;
        let pipeline = Pipeline::draw(&self.context, pass, &variant, draw.targets.outputs())?;
        let (set, touches) = self.descriptors(pass, &pipeline, pass.name, resources)?;
        // Attachments are not looked at one by one.
        self.touch_more();
        self.begin_pass(pass.name, true, Kind::Other, &touches)?;
        let extent = vk::Extent2D { width: draw.area[0], height: draw.area[1] };
        let area = vk::Rect2D { offset: vk::Offset2D::default(), extent };
        let viewport = vk::Viewport {
            width: draw.area[0] as f32,
            height: draw.area[1] as f32,
            max_depth: 1.0,
            ..Default::default()
        };
        let value = draw.targets.clear.unwrap_or_default();
        let clear = vk::ClearValue { color: vk::ClearColorValue { float32: [value; 4] } };
        let far = vk::ClearValue { depth_stencil: vk::ClearDepthStencilValue { depth: 1.0, stencil: 0 } };
        let colors: Vec<_> = draw.targets.color.iter().map(|(image, _)| draw.targets.info(image, clear)).collect();
        let depth = draw.targets.depth.map(|image| draw.targets.info(image, far));
        let mut rendering = vk::RenderingInfo::default().render_area(area).layer_count(1).color_attachments(&colors);
        if let Some(depth) = &depth {
            rendering = rendering.depth_attachment(depth);
        }
        let before = if draw.targets.clear.is_some() { vk::ImageLayout::UNDEFINED } else { READ };
        self.image_barrier(draw.targets, [before, DRAWN]);
        let (device, commands) = (&self.context.device, self.commands);
        // SAFETY: as in `run`; the area is within the framebuffer limits. Indirect arguments lie
        // within their buffer, every buffer is made for that use, and the caller's passes never raise a count: the
        // vertex shader reads no splat beyond those that a direct draw would read.
        unsafe {
            device.cmd_begin_rendering(commands, &rendering);
            device.cmd_bind_pipeline(commands, vk::PipelineBindPoint::GRAPHICS, pipeline.raw);
            device.cmd_bind_descriptor_sets(commands, vk::PipelineBindPoint::GRAPHICS, pipeline.layout, 0, &[set], &[]);
            device.cmd_set_viewport(commands, 0, &[viewport]);
            device.cmd_set_scissor(commands, 0, &[area]);
            if let Some(stages) = pipeline.push_stages {
                device.cmd_push_constants(commands, pipeline.layout, stages, 0, push);
            }
            match draw.vertices {
                Vertices::Count(count) => device.cmd_draw(commands, count, 1, 0, 0),
                Vertices::Indirect(arguments) => {
                    let RawSlice { buffer, offset, bytes, .. } = arguments.raw();
                    assert!(bytes >= 16, "{}: a draw takes four words", pass.name);
                    device.cmd_draw_indirect(commands, buffer, offset, 1, 16);
                }
            }
            device.cmd_end_rendering(commands);
        }
        self.image_barrier(draw.targets, [DRAWN, READ]);
        self.touch_more();
        self.end_pass();
        self.pipelines.push(pipeline);
        Ok(())
    }

    /// Takes attachments from one layout to another, if there are any.
    fn image_barrier(&self, targets: Targets<'_>, layouts: [vk::ImageLayout; 2]) {
        image_barriers(&self.context, self.commands, targets.images().map(|i| (i.raw, i.range())), layouts);
    }
}
