//! Images that one pass draws into and later ones read: depths, numbers and colors, with one or more samples per pixel.
//!
//! Between passes an attachment is in the layout for reading; the recorder transitions it to the layout for drawing and
//! back.

use std::sync::Arc;

use ash::vk::{self, Handle};
use gpu_allocator::MemoryLocation;
use gpu_allocator::vulkan::Allocation;

use super::deletions::Deletion;
use super::instance::Instance;
use super::{Context, Device, Error, Resource};

/// Samples per pixel of multisampled attachments: the number that every device with such attachments supports.
pub const SAMPLES: u32 = 4;

/// The format of a pixel or sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Format {
    /// A depth for the depth test: a float in [0, 1].
    Depth,
    /// A float.
    Number,
    /// Four floats.
    Color,
}

impl Format {
    pub(super) fn raw(self) -> vk::Format {
        match self {
            Self::Depth => vk::Format::D32_SFLOAT,
            Self::Number => vk::Format::R32_SFLOAT,
            Self::Color => vk::Format::R32G32B32A32_SFLOAT,
        }
    }

    /// Returns the number of bytes of a sample.
    pub fn bytes(self) -> u64 {
        match self {
            Self::Depth | Self::Number => 4,
            Self::Color => 16,
        }
    }

    fn aspect(self) -> vk::ImageAspectFlags {
        match self {
            Self::Depth => vk::ImageAspectFlags::DEPTH,
            Self::Number | Self::Color => vk::ImageAspectFlags::COLOR,
        }
    }

    fn usage(self) -> vk::ImageUsageFlags {
        let drawn = match self {
            Self::Depth => vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT,
            Self::Number | Self::Color => vk::ImageUsageFlags::COLOR_ATTACHMENT,
        };
        drawn | vk::ImageUsageFlags::SAMPLED
    }
}

/// Returns the width and height up to which a device has all that multisampled drawing needs: depths and numbers of
/// [`SAMPLES`] samples, numbers and colors of one that blend; `None` where it lacks any of them.
pub(super) fn multisampled_size(instance: &Instance, physical: vk::PhysicalDevice) -> Option<[u32; 2]> {
    let several = vk::SampleCountFlags::from_raw(SAMPLES);
    let one = vk::SampleCountFlags::TYPE_1;
    let mut size = [u32::MAX; 2];
    for (format, samples) in
        [(Format::Depth, several), (Format::Number, several), (Format::Number, one), (Format::Color, one)]
    {
        let (tiling, flags) = (vk::ImageTiling::OPTIMAL, vk::ImageCreateFlags::empty());
        // SAFETY: plain queries on a live instance; a format that the device lacks is an error code.
        let (able, limits) = unsafe {
            let raw = &instance.raw;
            let able = raw.get_physical_device_format_properties(physical, format.raw()).optimal_tiling_features;
            let ty = vk::ImageType::TYPE_2D;
            (
                able,
                raw.get_physical_device_image_format_properties(
                    physical,
                    format.raw(),
                    ty,
                    tiling,
                    format.usage(),
                    flags,
                ),
            )
        };
        let limits = limits.ok().filter(|limits| limits.sample_counts.contains(samples))?;
        let blends = able.contains(vk::FormatFeatureFlags::COLOR_ATTACHMENT_BLEND);
        if samples == one && !blends {
            return None;
        }
        size = [size[0].min(limits.max_extent.width), size[1].min(limits.max_extent.height)];
    }
    Some(size)
}

/// An image to be drawn into and read.
pub struct Attachment {
    context: Arc<Context>,
    pub(super) format: Format,
    pub(super) samples: u32,
    size: [u32; 2],
    pub(super) raw: vk::Image,
    pub(super) view: vk::ImageView,
    allocation: Option<Allocation>,
}

impl Attachment {
    pub(super) fn new(
        context: &Arc<Context>,
        name: &str,
        format: Format,
        samples: u32,
        size: [u32; 2],
    ) -> Result<Self, Error> {
        let info = vk::ImageCreateInfo::default()
            .image_type(vk::ImageType::TYPE_2D)
            .format(format.raw())
            .extent(vk::Extent3D { width: size[0], height: size[1], depth: 1 })
            .mip_levels(1)
            .array_layers(1)
            .samples(vk::SampleCountFlags::from_raw(samples))
            .tiling(vk::ImageTiling::OPTIMAL)
            .usage(format.usage())
            .initial_layout(vk::ImageLayout::UNDEFINED);
        let limit = context.limits.framebuffer;
        if !(0..2).all(|axis| (1..=limit[axis]).contains(&size[axis])) {
            return Err(Error::Framebuffer { name: name.to_owned(), size, limit });
        }
        let bytes = u64::from(size[0]) * u64::from(size[1]) * u64::from(samples) * format.bytes();
        // SAFETY: a live device, and a size that it has; the handle is destroyed in drop.
        let raw =
            unsafe { context.device.create_image(&info, None) }.map_err(|_| context.out_of_memory(name, bytes))?;
        let (context, view) = (context.clone(), vk::ImageView::null());
        let mut image = Self { context, format, samples, size, raw, view, allocation: None };
        image.bind(name, bytes)?;
        Ok(image)
    }

    /// Gives a fresh image its memory and its view.
    fn bind(&mut self, name: &str, bytes: u64) -> Result<(), Error> {
        let context = &self.context;
        // SAFETY: the image was just made from this device.
        let requirements = unsafe { context.device.get_image_memory_requirements(self.raw) };
        let allocation = context.allocate(name, bytes, requirements, (MemoryLocation::GpuOnly, false))?;
        // SAFETY: the memory is fresh and large enough, at the offset that the allocator aligned.
        let bound = unsafe { context.device.bind_image_memory(self.raw, allocation.memory(), allocation.offset()) };
        context.note_allocation((vk::Image::TYPE, self.raw.as_raw()), name, requirements.size);
        self.allocation = Some(allocation);
        bound.map_err(Error::call("vkBindImageMemory"))?;
        let info = vk::ImageViewCreateInfo::default()
            .image(self.raw)
            .view_type(vk::ImageViewType::TYPE_2D)
            .format(self.format.raw())
            .subresource_range(self.range());
        // SAFETY: the image has its memory; the view is destroyed in drop.
        self.view =
            unsafe { context.device.create_image_view(&info, None) }.map_err(Error::call("vkCreateImageView"))?;
        context.name_object(self.view, name);
        Ok(())
    }

    /// Returns a resource for binding it to a pass that reads it.
    pub fn texture(&self) -> Resource {
        Resource::Texture(self.view)
    }

    pub(super) fn range(&self) -> vk::ImageSubresourceRange {
        let range = vk::ImageSubresourceRange::default().aspect_mask(self.format.aspect());
        range.level_count(1).layer_count(1)
    }
}

impl Drop for Attachment {
    fn drop(&mut self) {
        self.context.delete(Deletion::Image(self.raw, self.view, self.allocation.take()));
    }
}

/// An attachment that is kept from frame to frame while it is large enough.
pub struct ScratchAttachment {
    name: &'static str,
    format: Format,
    samples: u32,
    image: Option<Attachment>,
}

impl ScratchAttachment {
    /// Not allocated yet.
    pub fn new(name: &'static str, format: Format, samples: u32) -> Self {
        Self { name, format, samples, image: None }
    }

    /// Makes sure it has exactly this size, so that it never exceeds the budget; earlier content may be lost.
    pub fn reserve(&mut self, device: &Device, size: [u32; 2]) -> Result<(), Error> {
        if self.image.as_ref().is_none_or(|image| image.size != size) {
            // Freed first, so that old and new never exist together.
            self.image = None;
            self.image = Some(device.attachment(self.name, self.format, self.samples, size)?);
        }
        Ok(())
    }

    /// Frees the image.
    pub fn release(&mut self) {
        self.image = None;
    }

    /// Returns the image; there must have been a [`Self::reserve`].
    pub fn get(&self) -> &Attachment {
        self.image.as_ref().expect("reserved before use")
    }
}

/// A texture type of shaders: stands for WGSL's type in the declaration of a pass.
pub trait Texture {
    /// The texture's type in WGSL.
    const WGSL: &'static str;
}

/// Numbers or colors of one sample, as `texture_2d<f32>`.
pub struct Pixels;
/// Numbers of several samples, as `texture_multisampled_2d<f32>`.
pub struct NumberSamples;
/// Depths of several samples, as `texture_depth_multisampled_2d`.
pub struct DepthSamples;

impl Texture for Pixels {
    const WGSL: &'static str = "texture_2d<f32>";
}
impl Texture for NumberSamples {
    const WGSL: &'static str = "texture_multisampled_2d<f32>";
}
impl Texture for DepthSamples {
    const WGSL: &'static str = "texture_depth_multisampled_2d";
}
