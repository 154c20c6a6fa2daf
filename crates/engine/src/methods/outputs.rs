//! Outputs of a frame that its caller wants on the host.

/// Outputs of a frame that its caller wants on the host: the others stay on the device, and nothing is copied for them.
/// What the host needs itself comes in any case. Images that it sums up, lights or brightens have everything: means of
/// several samples, eye-dome lighting, median and mean depths, brightened ensembles.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Outputs {
    /// Form of the colors.
    pub colors: Colors,
    /// `true` for [`Image::depth`](crate::image::Image::depth).
    pub depth: bool,
}

/// Form in which colors come to the host.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum Colors {
    /// [`Image::rgba`](crate::image::Image::rgba): 16 bytes a pixel.
    Float,
    /// [`Image::bytes`](crate::image::Image::bytes): the pixels of an opaque PNG over the frame's background, 4 bytes
    /// each, which the device finds.
    Bytes,
    /// None, where the device has the colors of the whole image at once
    /// ([`Renderer::colors`](super::Renderer::colors)), else floats.
    Stay,
}

impl Default for Outputs {
    fn default() -> Self {
        Self { colors: Colors::Float, depth: true }
    }
}

impl Outputs {
    /// Outputs of an opaque PNG: 4 bytes a pixel.
    pub const PNG: Self = Self { colors: Colors::Bytes, depth: false };
    /// Outputs of a picture on the screen, of which depths tell what is pointed at.
    pub const SCREEN: Self = Self { colors: Colors::Stay, depth: true };

    /// Returns the bytes of a pixel that come to the host.
    pub fn pixel_bytes(&self) -> u64 {
        let colors = match self.colors {
            Colors::Float => 16,
            Colors::Bytes => 4,
            Colors::Stay => 0,
        };
        colors + if self.depth { 4 } else { 0 }
    }
}
