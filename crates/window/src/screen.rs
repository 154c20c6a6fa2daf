//! Presentation of a picture in the device's memory to the window.

use std::sync::Arc;

use ash::{khr, vk};

use super::panel::{Drawing, Painter, Textures};
use super::swapchain::{self, RANGE, Swapchain, failed};
use pellucid_gpu::{Buffer, Context, Device, Error, full_barrier, image_barriers, lock};

/// Bytes to show, and where: sRGB-encoded, row by row, in the order that [`Screen::blue_first`] says.
pub struct Picture<'a> {
    /// Columns and rows.
    pub size: [u32; 2],
    /// The upper left corner in the window, in physical pixels. The part outside of the window is not shown.
    pub at: [u32; 2],
    /// 4 bytes for each pixel.
    pub pixels: &'a Buffer<u32>,
}

/// The outcome of a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shown {
    /// The window shows it.
    Yes,
    /// The window has no area now, or another one than a moment ago: try again when it has been drawn to.
    NotNow,
}

/// The content of a window. Holds the device; one frame is in flight at a time.
pub struct Screen {
    /// Dropped first: the context must outlive it.
    painter: Painter,
    context: Arc<Context>,
    loader: khr::swapchain::Device,
    format: vk::SurfaceFormatKHR,
    swapchain: Option<Swapchain>,
    pool: vk::CommandPool,
    commands: vk::CommandBuffer,
    fence: vk::Fence,
    /// `true` if the swapchain no longer fits the window.
    stale: bool,
}

impl Screen {
    /// Returns the screen of a device that was opened with [`open`](crate::open), with the textures of an earlier
    /// screen, if any.
    ///
    /// # Errors
    /// [`Error::NoSurface`] if the window accepts no 8-bit pictures, and Vulkan errors.
    pub fn new(device: &Device, textures: Textures) -> Result<Self, Error> {
        let context = device.context().clone();
        let format = swapchain::format(&context)?;
        let loader = khr::swapchain::Device::new(&context.instance.raw, &context.device);
        let mut screen = Self {
            painter: Painter::new(&context, format.format, textures)?,
            loader,
            format,
            swapchain: None,
            pool: vk::CommandPool::null(),
            commands: vk::CommandBuffer::null(),
            fence: vk::Fence::null(),
            stale: true,
            context,
        };
        let device = &screen.context.device;
        let pool = vk::CommandPoolCreateInfo::default()
            .queue_family_index(screen.context.queue_family)
            .flags(vk::CommandPoolCreateFlags::RESET_COMMAND_BUFFER);
        // SAFETY: a live device; drop destroys what was made so far.
        unsafe {
            screen.pool = device.create_command_pool(&pool, None).map_err(Error::call("vkCreateCommandPool"))?;
            let info = vk::CommandBufferAllocateInfo::default().command_pool(screen.pool).command_buffer_count(1);
            let commands = device.allocate_command_buffers(&info);
            screen.commands = commands.map_err(Error::call("vkAllocateCommandBuffers"))?[0];
            let fence = device.create_fence(&vk::FenceCreateInfo::default(), None);
            screen.fence = fence.map_err(Error::call("vkCreateFence"))?;
        }
        Ok(screen)
    }

    /// Returns `true` if pixels are B, G, R, A in memory, and not R, G, B, A.
    pub fn blue_first(&self) -> bool {
        self.format.format == vk::Format::B8G8R8A8_UNORM
    }

    /// The window has changed its size.
    pub fn resized(&mut self) {
        self.stale = true;
    }

    /// Returns the textures so far, for the next screen.
    pub fn take_textures(&mut self) -> Textures {
        std::mem::take(&mut self.painter.textures)
    }

    /// Shows a picture with a drawing over it in a window of this size (physical pixels); returns when the device is
    /// done. `about_to_present` is called just before the picture is presented, if it is.
    ///
    /// # Errors
    /// [`Error::Lost`] if the device or the surface is lost; [`Error::NoSurface`] if the picture's length doesn't match
    /// its size, or if it is on another device. After running out of memory, the next frame may succeed.
    pub fn show(
        &mut self,
        size: [u32; 2],
        picture: Option<&Picture<'_>>,
        drawing: &Drawing,
        about_to_present: &dyn Fn(),
    ) -> Result<Shown, Error> {
        self.painter.take_in(&drawing.textures.set);
        let shown = self
            .bring_textures()
            .and_then(|()| self.draw(size, picture, drawing))
            .and_then(|index| index.map_or(Ok(Shown::NotNow), |index| self.present(index, about_to_present)));
        if shown.is_err() {
            self.give_up();
        }
        self.painter.free_textures(&drawing.textures.free)?;
        shown
    }

    fn bring_textures(&mut self) -> Result<(), Error> {
        if !self.painter.is_stale() {
            return Ok(());
        }
        let _guard = lock(&self.context.submission);
        self.painter.bring_textures(&self.context, self.pool)
    }

    /// Draws to an image of the window, if it has one to give.
    fn draw(&mut self, size: [u32; 2], picture: Option<&Picture<'_>>, drawing: &Drawing) -> Result<Option<u32>, Error> {
        picture.map_or(Ok(()), |picture| self.check(picture))?;
        if self.stale {
            self.renew(size)?;
        }
        let Some(index) = self.acquire()? else { return Ok(None) };
        self.record(index, picture, drawing)?;
        self.submit(index)?;
        Ok(Some(index))
    }

    /// After a frame that was not shown: it may have an image for ever, and the semaphore of it.
    fn give_up(&mut self) {
        if let Some(old) = self.swapchain.take() {
            self.destroy(&old);
        }
        // SAFETY: all submissions have finished; if resetting fails, beginning the command buffer reports it.
        let _ =
            unsafe { self.context.device.reset_command_buffer(self.commands, vk::CommandBufferResetFlags::empty()) };
        self.stale = true;
    }

    fn destroy(&self, old: &Swapchain) {
        let _guard = lock(&self.context.submission);
        // SAFETY: the wait ends all that uses the images, presenting included; a lost device uses nothing.
        unsafe {
            let _ = self.context.device.queue_wait_idle(self.context.queue);
            old.destroy(&self.context, &self.loader);
        }
    }

    /// Creates a swapchain that fits the window, or none while it has no area.
    fn renew(&mut self, size: [u32; 2]) -> Result<(), Error> {
        let old = self.swapchain.take();
        let raw = old.as_ref().map(|old| old.raw);
        let made = Swapchain::new(&self.context, &self.loader, self.format, size, raw);
        if let Some(old) = old {
            self.destroy(&old);
        }
        self.swapchain = made?;
        self.stale = self.swapchain.is_none();
        Ok(())
    }

    /// The next image, if the window has one to give.
    fn acquire(&mut self) -> Result<Option<u32>, Error> {
        let Some(swapchain) = &self.swapchain else { return Ok(None) };
        // SAFETY: the semaphore was waited for by the last submission, which is over.
        let acquired = unsafe {
            self.loader.acquire_next_image(swapchain.raw, PATIENCE_NS, swapchain.acquired, vk::Fence::null())
        };
        match acquired {
            Ok((index, suboptimal)) => {
                self.stale = suboptimal;
                Ok(Some(index))
            }
            Err(vk::Result::ERROR_OUT_OF_DATE_KHR) => {
                self.stale = true;
                Ok(None)
            }
            // An invisible window may provide no image.
            Err(vk::Result::TIMEOUT | vk::Result::NOT_READY) => Ok(None),
            Err(result) => Err(failed("vkAcquireNextImageKHR")(result)),
        }
    }

    /// Makes sure that the device can copy all of a picture.
    fn check(&self, picture: &Picture<'_>) -> Result<(), Error> {
        let Picture { size: [width, height], pixels, .. } = picture;
        if !pixels.is_of(&self.context) {
            return Err(Error::NoSurface("the picture is on another device".into()));
        }
        if pixels.len() != u64::from(*width) * u64::from(*height) {
            return Err(Error::NoSurface(format!("{} pixels for a picture of {width} × {height}", pixels.len())));
        }
        Ok(())
    }

    fn record(&mut self, index: u32, picture: Option<&Picture<'_>>, drawing: &Drawing) -> Result<(), Error> {
        let Some(swapchain) = &self.swapchain else { return Ok(()) };
        let (device, commands) = (&self.context.device, self.commands);
        let image = swapchain.images[index as usize];
        let barrier = |layouts| image_barriers(&self.context, commands, std::iter::once((image, RANGE)), layouts);
        let begin = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        // SAFETY: the last submission of this command buffer is over; the image was acquired, and its swapchain lives
        // until the submission is waited for.
        unsafe {
            device.begin_command_buffer(commands, &begin).map_err(Error::call("vkBeginCommandBuffer"))?;
            barrier([vk::ImageLayout::UNDEFINED, COPIED]);
            let gray = vk::ClearColorValue { float32: [GRAY, GRAY, GRAY, 1.0] };
            device.cmd_clear_color_image(commands, image, COPIED, &gray, &[RANGE]);
            barrier([COPIED, COPIED]);
            if let Some(Picture { size, at, pixels }) = picture
                && let Some(region) = region(*size, *at, swapchain.extent)
            {
                // Results of earlier submissions are copied.
                full_barrier(&self.context, commands);
                let source = pixels.all().raw();
                let region = region.buffer_offset(source.offset);
                device.cmd_copy_buffer_to_image(commands, source.buffer, image, COPIED, &[region]);
            }
            barrier([COPIED, DRAWN]);
            let colors = [vk::RenderingAttachmentInfo::default()
                .image_view(swapchain.views[index as usize])
                .image_layout(DRAWN)
                .load_op(vk::AttachmentLoadOp::LOAD)
                .store_op(vk::AttachmentStoreOp::STORE)];
            let area = vk::Rect2D { offset: vk::Offset2D::default(), extent: swapchain.extent };
            let rendering = vk::RenderingInfo::default().render_area(area).layer_count(1).color_attachments(&colors);
            device.cmd_begin_rendering(commands, &rendering);
            self.painter.record(commands, swapchain.extent, drawing)?;
            device.cmd_end_rendering(commands);
            barrier([DRAWN, vk::ImageLayout::PRESENT_SRC_KHR]);
            device.end_command_buffer(commands).map_err(Error::call("vkEndCommandBuffer"))
        }
    }

    /// Submits and waits.
    fn submit(&self, index: u32) -> Result<(), Error> {
        let Some(swapchain) = &self.swapchain else { return Ok(()) };
        let all = vk::PipelineStageFlags2::ALL_COMMANDS;
        let wait = [vk::SemaphoreSubmitInfo::default().semaphore(swapchain.acquired).stage_mask(all)];
        let finished = swapchain.finished[index as usize];
        let signal = [vk::SemaphoreSubmitInfo::default().semaphore(finished).stage_mask(all)];
        let command = [vk::CommandBufferSubmitInfo::default().command_buffer(self.commands)];
        let submit = vk::SubmitInfo2::default()
            .wait_semaphore_infos(&wait)
            .command_buffer_infos(&command)
            .signal_semaphore_infos(&signal);
        let (device, fences) = (&self.context.device, [self.fence]);
        let guard = lock(&self.context.submission);
        // SAFETY: the command buffer is complete, the fence unsignalled; a semaphore of an image is waited for by its
        // presentation before the image is acquired again.
        let submitted = unsafe {
            pellucid_gpu::fault::vulkan("show")
                .and_then(|()| device.queue_submit2(self.context.queue, &[submit], self.fence))
        };
        drop(guard);
        submitted.map_err(failed("vkQueueSubmit2"))?;
        // SAFETY: the fence is that of the submission.
        unsafe {
            device.wait_for_fences(&fences, true, u64::MAX).map_err(failed("vkWaitForFences"))?;
            device.reset_fences(&fences).map_err(failed("vkResetFences"))
        }
    }

    fn present(&mut self, index: u32, about_to_present: &dyn Fn()) -> Result<Shown, Error> {
        let Some(swapchain) = &self.swapchain else { return Ok(Shown::NotNow) };
        let (swapchains, indices) = ([swapchain.raw], [index]);
        let finished = [swapchain.finished[index as usize]];
        let info =
            vk::PresentInfoKHR::default().wait_semaphores(&finished).swapchains(&swapchains).image_indices(&indices);
        about_to_present();
        let guard = lock(&self.context.submission);
        // SAFETY: the image was acquired and is in the layout for presenting.
        let presented = unsafe { self.loader.queue_present(self.context.queue, &info) };
        drop(guard);
        match presented {
            Ok(suboptimal) => {
                self.stale |= suboptimal;
                Ok(Shown::Yes)
            }
            Err(vk::Result::ERROR_OUT_OF_DATE_KHR) => {
                self.stale = true;
                Ok(Shown::NotNow)
            }
            Err(result) => Err(failed("vkQueuePresentKHR")(result)),
        }
    }
}

impl Drop for Screen {
    fn drop(&mut self) {
        let _guard = lock(&self.context.submission);
        let device = &self.context.device;
        // SAFETY: the wait ends all that uses the handles, presenting included; a lost device uses nothing. Null
        // handles are ignored.
        unsafe {
            let _ = device.queue_wait_idle(self.context.queue);
            if let Some(swapchain) = self.swapchain.take() {
                swapchain.destroy(&self.context, &self.loader);
            }
            device.destroy_fence(self.fence, None);
            device.destroy_command_pool(self.pool, None);
        }
    }
}

/// Time to wait for an image, in nanoseconds.
const PATIENCE_NS: u64 = 200_000_000;
/// Around the picture, where the window has nothing else.
const GRAY: f32 = 0.1;
const COPIED: vk::ImageLayout = vk::ImageLayout::TRANSFER_DST_OPTIMAL;
const DRAWN: vk::ImageLayout = vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL;

/// The part of a picture of this size, with its corner at `at`, that fits the window; `None` if that is empty.
fn region(size: [u32; 2], at: [u32; 2], extent: vk::Extent2D) -> Option<vk::BufferImageCopy> {
    let room = [extent.width.saturating_sub(at[0]), extent.height.saturating_sub(at[1])];
    let [width, height] = [size[0].min(room[0]), size[1].min(room[1])];
    let offset = [i32::try_from(at[0]).ok()?, i32::try_from(at[1]).ok()?];
    (width > 0 && height > 0).then(|| {
        vk::BufferImageCopy::default()
            .buffer_row_length(size[0])
            .image_subresource(vk::ImageSubresourceLayers {
                aspect_mask: vk::ImageAspectFlags::COLOR,
                mip_level: 0,
                base_array_layer: 0,
                layer_count: 1,
            })
            .image_offset(vk::Offset3D { x: offset[0], y: offset[1], z: 0 })
            .image_extent(vk::Extent3D { width, height, depth: 1 })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_is_cut_at_the_windows_border() {
        let extent = vk::Extent2D { width: 10, height: 8 };
        let part = |size, at| {
            let region = region(size, at, extent)?;
            Some((region.image_extent.width, region.image_extent.height, region.buffer_row_length))
        };
        assert_eq!(part([6, 8], [0, 0]), Some((6, 8, 6)));
        assert_eq!(part([6, 9], [7, 1]), Some((3, 7, 6)));
        assert_eq!(part([6, 9], [10, 0]), None);
        assert_eq!(part([6, 0], [0, 0]), None);
    }
}
