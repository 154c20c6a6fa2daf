//! Who visits the pixels of splats.

use super::Error;
use crate::gpu::Device;
use crate::passes::bands::Window;
use crate::passes::raster::Walker;
use crate::scene::Raster;

/// Who visits the pixels of a window, where compute shaders and the rasteriser may.
///
/// # Errors
/// The rasteriser was asked for and can't.
pub(super) fn walker(device: &Device, raster: Raster, window: Window) -> Result<Walker, Error> {
    let [width, height] = device.limits().framebuffer;
    let fits = window[2] - window[0] <= width && window[3] - window[1] <= height;
    match raster {
        Raster::Hardware if !device.info().fragment_atomics => refused(device, "fragmentStoresAndAtomics".to_owned()),
        Raster::Hardware if !fits => refused(device, format!("a framebuffer larger than {width} × {height}")),
        Raster::Hardware => Ok(Walker::Hardware),
        // For every size of splat compute was the faster way on the devices measured (README, benches/frame.rs).
        Raster::Compute | Raster::Auto => Ok(Walker::Compute),
    }
}

/// Who takes the samples of stochastic transparency.
///
/// # Errors
/// The rasteriser was asked for and can't.
pub(super) fn sampling_walker(device: &Device, raster: Raster, window: Window) -> Result<Walker, Error> {
    let info = device.info();
    match raster {
        Raster::Hardware => {}
        // Compute was the faster way wherever both were measured (README), except on devices without shuffles.
        Raster::Auto if info.subgroup.is_none() && info.multisampled.is_some() => {}
        Raster::Auto | Raster::Compute => return walker(device, Raster::Compute, window),
    }
    let [width, height] = [window[2] - window[0], window[3] - window[1]];
    match info.multisampled {
        Some([w, h]) if width <= w && height <= h => walker(device, Raster::Hardware, window),
        _ => refused(device, "attachments with 4 samples per pixel, and blending of floats".to_owned()),
    }
}

fn refused<T>(device: &Device, needed: String) -> Result<T, Error> {
    Err(Error::NoHardwareRaster { device: device.info().name.clone(), needed })
}
