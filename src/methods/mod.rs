//! The methods: what each frame records, and the renderer that runs them over windows and bands of the image.

pub mod abuffer;
pub mod bands;
pub mod peel;
pub mod renderer;
pub mod splat;

pub use renderer::{Facts, Frame, FrameProfile, PassProfile, Rendered, Renderer};

use bytesize::ByteSize;

/// Why a frame cannot be rendered.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The device failed.
    #[error(transparent)]
    Gpu(#[from] crate::gpu::Error),
    /// One pixel alone has more fragments than fit.
    #[error(
        "pixel ({x}, {y}) has {length} fragments, which need {} of device memory; the budget leaves {}: --memory-budget {} would do",
        ByteSize(*.needed), ByteSize(*.available), ByteSize(*.budget)
    )]
    PixelOverBudget {
        /// Column.
        x: u32,
        /// Row.
        y: u32,
        /// Fragments of the pixel.
        length: u32,
        /// Bytes that they need.
        needed: u64,
        /// Bytes that are there for fragments.
        available: u64,
        /// The budget that would do.
        budget: u64,
    },
    /// One pixel alone overflows the 32-bit counters.
    #[error("pixel ({x}, {y}) gets more than 2^32 fragments or tiles; fewer or smaller splats would help")]
    PixelOverflow {
        /// Column.
        x: u32,
        /// Row.
        y: u32,
    },
    /// More layers than peeling goes through.
    #[error(
        "a pixel has more than {limit} layers, each of which visits every splat; method \"abuffer\" renders any number, and layers = N stops after N"
    )]
    TooManyLayers {
        /// Layers that were peeled.
        limit: u32,
    },
    /// The cloud is longer than the device can address.
    #[error("{points} points, but this device binds at most {limit} (four times maxStorageBufferRange)")]
    TooManyPoints {
        /// Points of the scene.
        points: u64,
        /// Points that fit.
        limit: u64,
    },
    /// The rasteriser was asked for, but the device cannot write from fragment shaders, or not over so large an area.
    #[error("raster = \"hardware\" needs {needed}, which {device} lacks; use \"compute\" or \"auto\"")]
    NoHardwareRaster {
        /// The device.
        device: String,
        /// What is missing.
        needed: String,
    },
    /// The image is empty or too large.
    #[error("an image of {width} × {height} pixels: each side must have 1 to {} pixels", crate::scene::MAX_SIDE)]
    ImageSize {
        /// Width in pixels.
        width: u32,
        /// Height in pixels.
        height: u32,
    },
}
