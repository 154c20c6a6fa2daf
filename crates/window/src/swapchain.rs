//! The images that a window shows in turn.

use ash::{khr, vk};

use pellucid_gpu::{Context, Error};

/// Returns the format of all swapchains of a surface: 8 bits, sRGB-encoded, shown without conversion.
pub fn format(context: &Context) -> Result<vk::SurfaceFormatKHR, Error> {
    let Some(surface) = &context.instance.surface else { return Err(no_surface()) };
    // SAFETY: a plain query on a live surface.
    let formats = unsafe { surface.loader.get_physical_device_surface_formats(context.physical, surface.raw) }
        .map_err(failed("vkGetPhysicalDeviceSurfaceFormatsKHR"))?;
    let wanted = [vk::Format::B8G8R8A8_UNORM, vk::Format::R8G8B8A8_UNORM];
    let srgb = |f: &&vk::SurfaceFormatKHR| f.color_space == vk::ColorSpaceKHR::SRGB_NONLINEAR;
    let found = formats.iter().filter(srgb).find(|f| wanted.contains(&f.format)).copied();
    found.ok_or_else(|| Error::NoSurface("the window takes no pictures of 8 bits per channel".into()))
}

pub fn no_surface() -> Error {
    Error::NoSurface("the device was opened without a window".into())
}

/// Returns a failed call by name. Without its surface nothing can be shown any more, as without the device.
pub fn failed(call: &'static str) -> impl FnOnce(vk::Result) -> Error {
    move |result| match result {
        vk::Result::ERROR_DEVICE_LOST | vk::Result::ERROR_SURFACE_LOST_KHR => {
            Error::Lost { during: format!("showing a picture in the window ({call})") }
        }
        result => Error::Vulkan { call, result },
    }
}

/// A swapchain with what belongs to it and to each of its images.
pub struct Swapchain {
    pub raw: vk::SwapchainKHR,
    pub extent: vk::Extent2D,
    pub images: Vec<vk::Image>,
    pub views: Vec<vk::ImageView>,
    /// Signaled when an image may be drawn to.
    pub acquired: vk::Semaphore,
    /// Signaled when an image may be presented.
    pub finished: Vec<vk::Semaphore>,
}

impl Swapchain {
    /// Returns a swapchain for a window of this size, or `None` while the window has no area. `old` is the one that it
    /// replaces.
    pub fn new(
        context: &Context,
        loader: &khr::swapchain::Device,
        format: vk::SurfaceFormatKHR,
        size: [u32; 2],
        old: Option<vk::SwapchainKHR>,
    ) -> Result<Option<Self>, Error> {
        let Some(surface) = &context.instance.surface else { return Err(no_surface()) };
        // SAFETY: a plain query on a live surface.
        let able = unsafe { surface.loader.get_physical_device_surface_capabilities(context.physical, surface.raw) }
            .map_err(failed("vkGetPhysicalDeviceSurfaceCapabilitiesKHR"))?;
        if !able.supported_usage_flags.contains(USAGE) {
            return Err(Error::NoSurface("the window takes no copies of pictures".into()));
        }
        let Some(extent) = extent(&able, size) else { return Ok(None) };
        let most = if able.max_image_count == 0 { u32::MAX } else { able.max_image_count };
        let alpha = [vk::CompositeAlphaFlagsKHR::OPAQUE, vk::CompositeAlphaFlagsKHR::INHERIT];
        let alpha = alpha.into_iter().find(|a| able.supported_composite_alpha.contains(*a));
        let info = vk::SwapchainCreateInfoKHR::default()
            .surface(surface.raw)
            .min_image_count((able.min_image_count + 1).min(most))
            .image_format(format.format)
            .image_color_space(format.color_space)
            .image_extent(extent)
            .image_array_layers(1)
            .image_usage(USAGE)
            .image_sharing_mode(vk::SharingMode::EXCLUSIVE)
            .pre_transform(able.current_transform)
            .composite_alpha(alpha.unwrap_or(able.supported_composite_alpha))
            .present_mode(vk::PresentModeKHR::FIFO)
            .clipped(true)
            .old_swapchain(old.unwrap_or_default());
        // SAFETY: the surface is alive and supported by this device; the old swapchain is no longer used.
        let raw = unsafe { loader.create_swapchain(&info, None) }.map_err(failed("vkCreateSwapchainKHR"))?;
        let acquired = vk::Semaphore::null();
        let mut made = Self { raw, extent, images: Vec::new(), views: Vec::new(), acquired, finished: Vec::new() };
        match made.fill(context, loader, format.format) {
            Ok(()) => Ok(Some(made)),
            Err(error) => {
                // SAFETY: just made, used by nothing.
                unsafe { made.destroy(context, loader) };
                Err(error)
            }
        }
    }

    fn fill(&mut self, context: &Context, loader: &khr::swapchain::Device, format: vk::Format) -> Result<(), Error> {
        // SAFETY: the swapchain was just created; everything created here is destroyed with it.
        unsafe {
            self.images = loader.get_swapchain_images(self.raw).map_err(failed("vkGetSwapchainImagesKHR"))?;
            let acquired = context.device.create_semaphore(&vk::SemaphoreCreateInfo::default(), None);
            self.acquired = acquired.map_err(failed("vkCreateSemaphore"))?;
            for image in &self.images {
                let info = vk::ImageViewCreateInfo::default()
                    .image(*image)
                    .view_type(vk::ImageViewType::TYPE_2D)
                    .format(format)
                    .subresource_range(RANGE);
                let view = context.device.create_image_view(&info, None).map_err(failed("vkCreateImageView"))?;
                self.views.push(view);
                let semaphore = context.device.create_semaphore(&vk::SemaphoreCreateInfo::default(), None);
                self.finished.push(semaphore.map_err(failed("vkCreateSemaphore"))?);
            }
        }
        Ok(())
    }

    /// Destroys the handles; null handles are ignored.
    ///
    /// # Safety
    /// The device has finished with the images, or is lost.
    pub unsafe fn destroy(&self, context: &Context, loader: &khr::swapchain::Device) {
        // SAFETY: by the caller.
        unsafe {
            self.views.iter().for_each(|view| context.device.destroy_image_view(*view, None));
            self.finished.iter().for_each(|semaphore| context.device.destroy_semaphore(*semaphore, None));
            loader.destroy_swapchain(self.raw, None);
            // Destroyed after the swapchain, which may have an acquired image that was not recorded.
            context.device.destroy_semaphore(self.acquired, None);
        }
    }
}

const USAGE: vk::ImageUsageFlags = vk::ImageUsageFlags::from_raw(
    vk::ImageUsageFlags::COLOR_ATTACHMENT.as_raw() | vk::ImageUsageFlags::TRANSFER_DST.as_raw(),
);

/// All of a swapchain's image.
pub const RANGE: vk::ImageSubresourceRange = vk::ImageSubresourceRange {
    aspect_mask: vk::ImageAspectFlags::COLOR,
    base_mip_level: 0,
    level_count: 1,
    base_array_layer: 0,
    layer_count: 1,
};

/// The surface's own size where it has one, else the window's within what is allowed; `None` without an area.
fn extent(able: &vk::SurfaceCapabilitiesKHR, size: [u32; 2]) -> Option<vk::Extent2D> {
    let extent = match able.current_extent {
        // The surface takes the size of the swapchain.
        vk::Extent2D { width: u32::MAX, .. } => vk::Extent2D {
            width: size[0].clamp(able.min_image_extent.width, able.max_image_extent.width),
            height: size[1].clamp(able.min_image_extent.height, able.max_image_extent.height),
        },
        own => own,
    };
    (extent.width > 0 && extent.height > 0 && size[0] > 0 && size[1] > 0).then_some(extent)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_window_without_area_has_no_extent() {
        let capabilities = |width, height| vk::SurfaceCapabilitiesKHR {
            current_extent: vk::Extent2D { width, height },
            min_image_extent: vk::Extent2D { width: 1, height: 1 },
            max_image_extent: vk::Extent2D { width: 100, height: 100 },
            ..Default::default()
        };
        assert_eq!(extent(&capabilities(30, 20), [31, 21]), Some(vk::Extent2D { width: 30, height: 20 }));
        assert_eq!(extent(&capabilities(u32::MAX, u32::MAX), [300, 20]), Some(vk::Extent2D { width: 100, height: 20 }));
        assert_eq!(extent(&capabilities(0, 0), [30, 20]), None);
        assert_eq!(extent(&capabilities(30, 20), [0, 0]), None);
    }
}
