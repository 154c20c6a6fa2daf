//! The surface that a device presents to, and which devices can.

use std::any::Any;

use ash::{khr, vk};

use super::limits::has_extension;

/// A surface; the instance that it was made of destroys it.
pub struct Surface {
    /// Functions for surfaces.
    pub loader: khr::surface::Instance,
    /// The surface.
    pub raw: vk::SurfaceKHR,
    /// Outlives the surface.
    pub window: Box<dyn Any + Send + Sync>,
}

impl Surface {
    /// Returns `true` if queues of this family can present to the surface.
    pub(crate) fn takes_from(&self, instance: &ash::Instance, physical: vk::PhysicalDevice, family: u32) -> bool {
        // SAFETY: a plain query on a live surface; the family is one of this device.
        let supported = unsafe { self.loader.get_physical_device_surface_support(physical, family, self.raw) };
        has_extension(instance, physical, khr::swapchain::NAME) && supported.unwrap_or(false)
    }

    /// Destroys the surface; everything created from it must be gone.
    pub(crate) fn destroy(self) {
        // SAFETY: swapchains hold the context, whose instance calls this at its own end.
        unsafe { self.loader.destroy_surface(self.raw, None) };
    }
}
