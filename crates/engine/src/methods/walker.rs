//! The raster path of splats: compute shaders or the hardware rasterizer.

use super::Error;
use crate::gpu::Device;
use crate::passes::bands::Window;
use crate::passes::raster::Walker;
use crate::scene::Raster;

/// Returns the raster path of a window, for methods that have both.
///
/// # Errors
/// The hardware rasterizer was requested and isn't supported.
pub(super) fn walker(device: &Device, raster: Raster, window: Window) -> Result<Walker, Error> {
    let [width, height] = device.limits().framebuffer;
    let fits = window[2] - window[0] <= width && window[3] - window[1] <= height;
    match raster {
        Raster::Hardware if !device.info().fragment_atomics => refused(device, "fragmentStoresAndAtomics".to_owned()),
        Raster::Hardware if !fits => refused(device, format!("a framebuffer larger than {width} × {height}")),
        Raster::Hardware => Ok(Walker::Hardware),
        // For every size of splat compute was the faster path on the devices measured (docs/measuring.md,
        // benches/frame.rs).
        Raster::Compute | Raster::Auto => Ok(Walker::Compute),
    }
}

/// Returns the raster path of stochastic transparency.
///
/// # Errors
/// The hardware rasterizer was requested and isn't supported.
pub(super) fn sampling_walker(device: &Device, raster: Raster, window: Window) -> Result<Walker, Error> {
    let info = device.info();
    if !samples_by_rasterizer(raster, info.subgroup.is_some(), info.multisampled.is_some()) {
        return walker(device, Raster::Compute, window);
    }
    let [width, height] = [window[2] - window[0], window[3] - window[1]];
    match info.multisampled {
        Some([w, h]) if width <= w && height <= h => walker(device, Raster::Hardware, window),
        _ => refused(device, "attachments with 4 samples per pixel, and blending of floats".to_owned()),
    }
}

/// Returns `true` if samples are drawn by the rasterizer. Compute was the faster path wherever both were measured
/// (docs/measuring.md), by far on GPUs for data centers (docs/limits.md); it can't be had without subgroups.
fn samples_by_rasterizer(raster: Raster, has_subgroups: bool, can_rasterize: bool) -> bool {
    raster == Raster::Hardware || (raster == Raster::Auto && !has_subgroups && can_rasterize)
}

fn refused<T>(device: &Device, needed: String) -> Result<T, Error> {
    Err(Error::NoHardwareRaster { device: device.info().name.clone(), needed })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn auto_takes_the_rasterizer_only_where_compute_cannot_be_had() {
        for can_rasterize in [false, true] {
            assert!(!samples_by_rasterizer(Raster::Auto, true, can_rasterize));
            assert_eq!(samples_by_rasterizer(Raster::Auto, false, can_rasterize), can_rasterize);
            for has_subgroups in [false, true] {
                assert!(!samples_by_rasterizer(Raster::Compute, has_subgroups, can_rasterize));
                assert!(samples_by_rasterizer(Raster::Hardware, has_subgroups, can_rasterize));
            }
        }
    }
}
