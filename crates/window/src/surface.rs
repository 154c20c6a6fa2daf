//! The surface of a window, and the device that presents to it.

use std::ffi::c_char;
use std::sync::Arc;

use ash::khr;
use raw_window_handle::{HasDisplayHandle, HasWindowHandle};

use pellucid_gpu::{Device, DeviceOptions, Error, Surface};

/// Types that provide the handles of a window and its display.
pub trait Handles: HasDisplayHandle + HasWindowHandle + Send + Sync {}

impl<T: HasDisplayHandle + HasWindowHandle + Send + Sync> Handles for T {}

/// A window that lives at least as long as whoever holds this.
pub type Handle = Arc<dyn Handles>;

fn refused(why: impl std::fmt::Display) -> Error {
    Error::NoSurface(why.to_string())
}

/// Returns the instance extensions that surfaces of this kind of window need.
fn extensions(window: &Handle) -> Result<&'static [*const c_char], Error> {
    let display = window.display_handle().map_err(refused)?;
    ash_window::enumerate_required_extensions(display.as_raw())
        .map_err(|_| refused("Vulkan knows no windows of this kind"))
}

/// Makes the surface of a window. `instance` has the [`extensions`] that it needs.
fn surface(entry: &ash::Entry, instance: &ash::Instance, window: Handle) -> Result<Surface, Error> {
    let display = window.display_handle().map_err(refused)?.as_raw();
    let handle = window.window_handle().map_err(refused)?.as_raw();
    // SAFETY: both handles are those of a live window, which is kept for as long as the surface.
    let raw = unsafe { ash_window::create_surface(entry, instance, display, handle, None) }
        .map_err(|result| refused(format_args!("the window has no surface ({result:?})")))?;
    let loader = khr::surface::Instance::new(entry, instance);
    Ok(Surface { loader, raw, window: Box::new(window) })
}

/// Opens the device that `options` names, or the best one of those that can show pictures in a window.
/// [`Screen`](crate::Screen) shows them.
///
/// # Errors
/// Returns the errors of [`Device::open`], and [`Error::NoSurface`] if no driver can present to windows of this kind.
pub fn open(options: &DeviceOptions, window: Handle) -> Result<Device, Error> {
    let wanted = extensions(&window)?;
    Device::open_for(options, wanted, |entry, instance| surface(entry, instance, window))
}
