//! Eye-dome lighting (Boucheny 2009): a pixel becomes darker the farther its surface lies behind those around it, so
//! that a cloud without normals shows its shape.
//!
//! It is found from the depths of the whole image, once all windows are delivered, in bands of rows with the rows
//! beside them: a pixel's factor depends on nothing but nine depths, so that neither windows nor bands show. The device
//! finds factors, 4 bytes from 4 bytes a pixel, and the host multiplies colors by them.
//!
//! The depth of a pixel is its Z where a method is opaque. Where it blends exactly it is the one at which half of the
//! light or less is left, which lists of fragments give when they are gone through once more.
//!
//! Reference: `pellucid_reference::edl`, and `pellucid_reference::abuffer::median`.

use super::{Error, Frame, Timeline};
use crate::gpu::shader::Shader;
use crate::gpu::{Device, Dispatch, Memory, Run, Scratch};
use crate::passes::bands::Budget;
use crate::scene::Edl;
use crate::{fields, gpu_struct, pass};
use pellucid_core::parallel;

gpu_struct! {
    /// Push constants of `shading/edl`.
    pub struct EdlPush {
        count: u32, // Pixels to shade.
        width: u32,
        rows: u32, // Rows of `depths`, and the first one of those to shade.
        first: u32,
        straight: u32, // Offsets of the neighbors: along an axis, and along each of both on a diagonal.
        diagonal: u32,
        strength: f32, // Over the sum of logarithms.
    }
}

pass! {
    /// Finds how much darker each pixel becomes by how far it lies behind eight pixels around it, from the depths of
    /// the whole image.
    pub EyeDome(EdlPush) = "shading/edl" in "shading/edl" {
        depths: Read<f32>,
        factors: ReadWrite<f32>,
    }
}

/// The passes, in the order of their first run.
pub(crate) const PASSES: [&str; 3] = ["shading/depths", "shading/edl", "shading/factors"];

/// Bytes that a pixel takes on the device and in the host memory that it sees.
const PIXEL_BYTES: u64 = 16;

/// Pixels of a band at most.
const BAND_PIXELS: u64 = 1 << 22;

/// Returns the memory of a frame without that for bands, and that for bands, which is none unless the frame asks for
/// the effect.
pub(crate) fn divided(budget: Budget, frame: &Frame) -> (Budget, u64) {
    let bands = if frame.shading.edl.edl { (BAND_PIXELS * PIXEL_BYTES).min(budget.bytes / 4) } else { 0 };
    (Budget { bytes: budget.bytes - bands, ..budget }, bands)
}

/// Offsets to the pixels around at this radius: along an axis, and along each of both on a diagonal.
fn offsets(radius: f32) -> [u32; 2] {
    let radius = f64::from(radius);
    [radius.round() as u32, (radius * std::f64::consts::FRAC_1_SQRT_2).round() as u32]
}

/// The factor on the sum of eight logarithms: −ln(factor) = 300 · strength · (1/8) Σ log₂.
fn factor(strength: f32) -> f32 {
    let factor = 300.0 * f64::from(strength) * std::f64::consts::LOG2_E / 8.0;
    (factor as f32).min(f32::MAX)
}

/// Input of shading: an image's size, and the depth of each of its pixels.
#[derive(Clone, Copy)]
pub(crate) struct ShadedDepths<'a> {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Positive, +inf where nothing is shaded.
    pub depths: &'a [f32],
}

fields! {
    /// Buffers that are kept from frame to frame.
    pub(crate) struct EyeDomeLighting {
        depths_host: Scratch<f32> = Scratch::new("depths to shade, host", Memory::Upload),
        depths: Scratch<f32> = Scratch::new("depths to shade", Memory::Device),
        factors: Scratch<f32> = Scratch::new("factors of shading", Memory::Device),
        factors_host: Scratch<f32> = Scratch::new("factors of shading, host", Memory::Readback),
    }
}

impl EyeDomeLighting {
    /// Makes the colors of an image darker by the depths of its surface, with at most `budget` bytes for a band unless
    /// a row with its neighbors takes more.
    pub fn apply(
        &mut self,
        device: &Device,
        edl: &Edl,
        budget: u64,
        surface: ShadedDepths<'_>,
        colors: &mut [[f32; 4]],
        timeline: &mut Timeline,
    ) -> Result<(), Error> {
        let [straight, diagonal] = offsets(edl.edl_radius);
        let [width, height] = surface.size.map(u64::from);
        let halo = u64::from(straight.max(diagonal)).min(height);
        let most = budget / PIXEL_BYTES / width;
        let rows = most.saturating_sub(2 * halo).max(1);
        for start in (0..height).step_by(rows as usize) {
            let end = (start + rows).min(height);
            let [above, below] = [start.saturating_sub(halo), (end + halo).min(height)];
            let push = EdlPush {
                count: ((end - start) * width) as u32,
                width: width as u32,
                rows: (below - above) as u32,
                first: (start - above) as u32,
                straight,
                diagonal,
                strength: factor(edl.edl_strength),
            };
            let depths = &surface.depths[(above * width) as usize..(below * width) as usize];
            self.find(device, depths, push, timeline)?;
            let colors = &mut colors[(start * width) as usize..(end * width) as usize];
            darken(colors, &self.factors_host.get().mapped_slice()[..colors.len()]);
        }
        Ok(())
    }

    /// Finds the factors of a band.
    fn find(&mut self, device: &Device, depths: &[f32], push: EdlPush, timeline: &mut Timeline) -> Result<(), Error> {
        let (seen, count) = (depths.len() as u64, u64::from(push.count));
        self.depths_host.reserve(device, seen)?;
        self.depths.reserve(device, seen)?;
        self.factors.reserve(device, count)?;
        self.factors_host.reserve(device, count)?;
        self.depths_host.get_mut().write(depths);
        let mut recorder = timeline.recorder(device)?;
        recorder.copy("shading/depths", self.depths_host.get().slice(0, seen), self.depths.get().slice(0, seen))?;
        let (depths, factors) = (self.depths.get().slice(0, seen), self.factors.get().slice(0, count));
        recorder.run(&EyeDome { depths, factors }, push, &Run::new(Dispatch::Invocations(count)))?;
        recorder.copy("shading/factors", factors, self.factors_host.get().slice(0, count))?;
        timeline.submit(recorder, "shading/edl")?;
        Ok(())
    }
}

/// Multiplies colors, and not what they hide.
fn darken(colors: &mut [[f32; 4]], factors: &[f32]) {
    parallel::for_each_mut(colors, |i, [r, g, b, _]| [r, g, b].into_iter().for_each(|color| *color *= factors[i]));
}

/// Returns the number of bytes that one of the passes must at least read and write, for an image of so many pixels.
pub(crate) fn least_bytes(name: &str, pixels: u64) -> Option<u64> {
    PASSES.contains(&name).then_some(pixels * 8)
}

/// Returns the pass.
pub(crate) fn shaders() -> Vec<Shader> {
    vec![Shader::plain::<EyeDome>()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn offsets_by_hand() {
        // 1.4 · √½ = 0.99, 2.5 · √½ = 1.77; halves go away from 0.
        let wanted = [(0.3, [0, 0]), (0.6, [1, 0]), (1.0, [1, 1]), (1.4, [1, 1]), (2.5, [3, 2]), (10.0, [10, 7])];
        for (radius, offsets_px) in wanted {
            assert_eq!(offsets(radius), offsets_px, "{radius}");
        }
    }
}
