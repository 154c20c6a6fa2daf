//! The surface of a window, and which devices can present to it.

use std::ffi::c_char;
use std::sync::Arc;

use ash::{khr, vk};
use raw_window_handle::{HasDisplayHandle, HasWindowHandle};

use crate::Error;

/// Types that provide the handles of a window and its display.
pub trait Handles: HasDisplayHandle + HasWindowHandle + Send + Sync {}

impl<T: HasDisplayHandle + HasWindowHandle + Send + Sync> Handles for T {}

/// A window that lives at least as long as whoever holds this.
pub type Handle = Arc<dyn Handles>;

fn refused(why: impl std::fmt::Display) -> Error {
    Error::NoSurface(why.to_string())
}

/// Returns the instance extensions that surfaces of this kind of window need.
pub(crate) fn extensions(window: &Handle) -> Result<&'static [*const c_char], Error> {
    let display = window.display_handle().map_err(refused)?;
    ash_window::enumerate_required_extensions(display.as_raw())
        .map_err(|_| refused("Vulkan knows no windows of this kind"))
}

/// A surface; the instance that it was made of destroys it.
pub struct Surface {
    pub(super) loader: khr::surface::Instance,
    pub(super) raw: vk::SurfaceKHR,
    /// Outlives the surface.
    _window: Handle,
}

impl Surface {
    /// Returns the surface of a window. `instance` has the [`extensions`] that it needs.
    pub(crate) fn new(entry: &ash::Entry, instance: &ash::Instance, window: Handle) -> Result<Self, Error> {
        let display = window.display_handle().map_err(refused)?.as_raw();
        let handle = window.window_handle().map_err(refused)?.as_raw();
        // SAFETY: both handles are those of a live window, which is kept for as long as the surface.
        let raw = unsafe { ash_window::create_surface(entry, instance, display, handle, None) }
            .map_err(|result| refused(format_args!("the window has no surface ({result:?})")))?;
        Ok(Self { loader: khr::surface::Instance::new(entry, instance), raw, _window: window })
    }

    /// Returns `true` if queues of this family can present to the surface.
    pub(crate) fn takes_from(&self, instance: &ash::Instance, physical: vk::PhysicalDevice, family: u32) -> bool {
        // SAFETY: plain queries on a live instance; the family is one of this device.
        let (extensions, supported) = unsafe {
            (
                instance.enumerate_device_extension_properties(physical).unwrap_or_default(),
                self.loader.get_physical_device_surface_support(physical, family, self.raw),
            )
        };
        let swaps = extensions.iter().any(|e| e.extension_name_as_c_str() == Ok(khr::swapchain::NAME));
        swaps && supported.unwrap_or(false)
    }

    /// Destroys the surface; everything created from it must be gone.
    pub(crate) fn destroy(self) {
        // SAFETY: swapchains hold the context, whose instance calls this at its own end.
        unsafe { self.loader.destroy_surface(self.raw, None) };
    }
}
