//! Reasons why a frame cannot be rendered.

use std::sync::Arc;

use bytesize::ByteSize;

use crate::progress::Cancelled;
use crate::supply::Failure;

/// Reason why a frame cannot be rendered.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The device failed.
    #[error(transparent)]
    Gpu(#[from] crate::gpu::Error),
    /// A number of samples that a pixel can't have.
    #[error("{samples} samples per pixel; use 1, 2, 4, 8, 16, 32 or 64")]
    PixelSamples {
        /// The number.
        samples: u32,
    },
    /// The host's memory can't hold the image.
    #[error(
        "an image of {width} × {height} pixels needs {} of memory, which are not free; use a smaller --size", ByteSize(*.bytes)
    )]
    HostMemory {
        /// Columns.
        width: u32,
        /// Rows.
        height: u32,
        /// Bytes that it needs.
        bytes: u64,
    },
    /// A single pixel has more fragments than fit; reported for the pixel with most of those rendered together.
    #[error(
        "pixel ({x}, {y}) has {length} fragments, which need {} of device memory; the budget leaves {}; use --memory-budget \
         {} or more",
        ByteSize(*.needed), ByteSize(*.available), printed(*.budget)
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
        /// The budget that would do for this pixel.
        budget: u64,
    },
    /// A list is too long to be sorted in place.
    #[error(
        "a list of {length} fragments: long_lists = \"in-place\" sorts lists of up to {most}; use long_lists = \"merge\""
    )]
    ListTooLong {
        /// Fragments of the list.
        length: u32,
        /// Fragments of the longest list that is sorted in place.
        most: u32,
    },
    /// More points than events of soft spheres can name.
    #[error(
        "{points} points, but method {method} with up to {shells} shells supports at most {limit}; use fewer shells or \
         soft-express"
    )]
    TooManySpheres {
        /// Points of the scene.
        points: u64,
        /// The method.
        method: &'static str,
        /// Shells of a sphere.
        shells: u32,
        /// The largest number of distinguishable points.
        limit: u64,
    },
    /// Samples could not be taken by whom they are for.
    #[error(transparent)]
    Samples(std::io::Error),
    /// A deep image of a method that has no samples.
    #[error("method {method} has no samples per pixel; use abuffer, linked-list, sorted, peel or soft-concentric")]
    NoSamples {
        /// The method.
        method: &'static str,
    },
    /// Samples in parts, of a frame whose samples can't be drawn in parts
    /// ([`Frame::sample_steps`](crate::methods::Frame::sample_steps)).
    #[error(
        "method {method} with these settings draws no random samples that could be cut into parts; spbr, spbr-simplified and stochastic without a limit on the error do"
    )]
    NoParts {
        /// The method.
        method: &'static str,
    },
    /// Samples that are no part of a frame's.
    #[error("samples {start} to {end} of {total}: parts begin and end at multiples of {step}, or at the end")]
    SampleRange {
        /// The first sample.
        start: u32,
        /// One past the last.
        end: u32,
        /// Samples of the frame.
        total: u32,
        /// Samples between two places where they may be cut.
        step: u32,
    },
    /// Parts of a frame's samples that are not a whole.
    #[error(transparent)]
    Part(#[from] PartError),
    /// Points that come from a file while a frame is rendered can't be read.
    #[error("{0}")]
    Store(Arc<crate::io::Error>),
    /// The coarsest level of detail has more points than are allowed.
    #[error(
        "detail.max_points = {allowed}, but the coarsest level alone has {points} points in the picture; allow {points} or \
         more"
    )]
    Coarsest {
        /// Points that are allowed.
        allowed: u64,
        /// Points of that level in the picture.
        points: u64,
    },
    /// Levels of detail of points that are all on the device.
    #[error("levels of detail need points that come some at a time (`Upload::with_detail`)")]
    NoLevels,
    /// More points show in a single pixel than fit.
    #[error(
        "{points} points may show in pixel ({x}, {y}), but the device holds {limit} at a time; use a larger --memory-budget \
         or smaller radii"
    )]
    PointsOfPixel {
        /// Column.
        x: u32,
        /// Row.
        y: u32,
        /// Points of blocks that reach the pixel.
        points: u64,
        /// Points that fit.
        limit: u64,
    },
    /// A single pixel overflows the 32-bit counters.
    #[error("pixel ({x}, {y}) gets more than 2^32 fragments or tiles; use fewer or smaller splats")]
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
    /// A window of a single pixel, with the surroundings that filters reach, needs more memory than available.
    #[error(
        "the filters of all layers reach {halo} pixels around a window of the image, which takes {} of device memory at \
         least; the budget leaves {}; use --memory-budget {}, or fewer layers or iterations",
        ByteSize(*.needed), ByteSize(*.available), printed(*.needed)
    )]
    HaloOverBudget {
        /// Pixels that are rendered on each side of a window.
        halo: u32,
        /// Bytes that the smallest window takes.
        needed: u64,
        /// Bytes that are there for a window.
        available: u64,
    },
    /// A window of a single pixel has more tiles than the device can bind, with all around it that filters reach.
    #[error(
        "the filters of all layers reach {halo} pixels around a window of the image, which has {tiles} tiles of 16 × 16 \
         pixels at least; this device allows {limit}; use fewer layers or iterations"
    )]
    HaloTooLarge {
        /// Pixels that are rendered on each side of a window.
        halo: u32,
        /// Tiles of the smallest window.
        tiles: u64,
        /// Tiles that can be bound.
        limit: u64,
    },
    /// The cloud is longer than the device can address.
    #[error(
        "{points} points, but for the method in force the buffers of this device (maxStorageBufferRange, maxBufferSize, \
         maxMemoryAllocationSize) hold {limit} at most"
    )]
    TooManyPoints {
        /// Points of the scene.
        points: u64,
        /// Points that fit.
        limit: u64,
    },
    /// The sort of splats alone takes more than the budget.
    #[error(
        "sorting {points} splats needs {} of device memory; the budget leaves {}; use --memory-budget {}, or method abuffer \
         for transparent discs",
        ByteSize(*.needed), ByteSize(*.available), printed(*.budget)
    )]
    SortOverBudget {
        /// Points of the scene.
        points: u64,
        /// Bytes that the sort needs.
        needed: u64,
        /// Bytes that are there.
        available: u64,
        /// The budget that would do.
        budget: u64,
    },
    /// The points are not in the order that ensembles are dealt from.
    #[error("methods spbr and spbr-simplified need points that were dealt before they were uploaded")]
    NotDealt,
    /// The device has no shuffles.
    #[error(
        "methods that go through tiles of splats (sorted, stochastic, hybrid, mlab, moments, wavelet, weighted, average, unsorted, hqs, splats, the soft ones where there are solid points, one-layer) need subgroups of a known size from 8 to 32 with ballots and shuffles, which {device} lacks; use abuffer or circles"
    )]
    NoSubgroups {
        /// The device.
        device: String,
    },
    /// The rasterizer was asked for, but the device cannot write from fragment shaders, or not over so large an area.
    #[error("raster = \"hardware\" needs {needed}, which {device} lacks; use \"compute\" or \"auto\"")]
    NoHardwareRaster {
        /// The device.
        device: String,
        /// The missing feature.
        needed: String,
    },
    /// A light's image doesn't fit a binding or the budget.
    #[error(
        "shadows.resolution = {resolution} needs {} of device memory in two parts; the budget leaves {}, and a part may have {}: {}",
        ByteSize(*.needed), ByteSize(*.budget), ByteSize(*.binding), smaller_image(*.largest)
    )]
    ShadowImage {
        /// Columns and rows of the image.
        resolution: u32,
        /// Bytes that it needs.
        needed: u64,
        /// Bytes that the budget leaves.
        budget: u64,
        /// Bytes that a binding may have, which is half of the image.
        binding: u64,
        /// The largest resolution that would work; 0 if none would.
        largest: u32,
    },
    /// The images of all lights don't fit the budget together, where points come to the device some at a time.
    #[error(
        "shadows of points that don't all fit the device take images of {resolution} × {resolution} pixels, {count} in all, \
         which need {} together; a quarter of the budget is {}; use --memory-budget {}, or smaller shadows.samples or shadows.resolution{}",
        ByteSize(*.needed), ByteSize(*.budget), printed(needed.saturating_mul(4)),
        if *.largest > 0 { format!(" (up to {largest})") } else { String::new() }
    )]
    ShadowImages {
        /// Images, six of a light that has points all around it.
        count: u64,
        /// Columns and rows of an image.
        resolution: u32,
        /// Bytes that they need.
        needed: u64,
        /// Bytes that there are for them.
        budget: u64,
        /// The largest resolution that would work; 0 if none would.
        largest: u32,
    },
    /// A Gaussian has one place in the order of a method that was to order them pixel by pixel.
    #[error(
        "order = \"pixel\" orders Gaussians in each pixel, but sorted orders them once; use method = \"abuffer\" or order = \
         \"center\""
    )]
    OneOrder,
    /// Ellipsoids have no single depth for a method that takes one of each splat.
    #[error(
        "kernel = \"ellipsoid\" integrates along rays through ellipsoids, which method {method} can't; use method = \
         \"abuffer\" or \"linked-list\", or kernel = \"ray\""
    )]
    NoEllipsoids {
        /// The method.
        method: &'static str,
    },
    /// Eye-dome lighting of a picture that has no single surface.
    #[error("shading.edl needs the depth of a surface, but method {method} has none: {}", crate::scene::edl_methods())]
    NoSurfaceDepth {
        /// The method.
        method: &'static str,
    },
    /// A count was larger than taken for granted: the renderer tries again, and waits for it. Nobody else meets this.
    #[error("a count was larger than foreseen")]
    Unforeseen,
    /// Somebody who watches the progress wanted the work to end.
    #[error("cancelled")]
    Cancelled,
    /// The image is empty or too large.
    #[error("an image of {width} × {height} pixels: each side must have 1 to {} pixels", crate::image::MAX_SIDE)]
    ImageSize {
        /// Width in pixels.
        width: u32,
        /// Height in pixels.
        height: u32,
    },
}

impl From<Failure> for Error {
    fn from(failure: Failure) -> Self {
        match failure {
            Failure::Coarsest { allowed, points } => Self::Coarsest { allowed, points },
            Failure::Cancelled => Self::Cancelled,
            Failure::Store(error) => Self::Store(error),
        }
    }
}

impl From<Cancelled> for Error {
    fn from(_: Cancelled) -> Self {
        Self::Cancelled
    }
}

/// Reason why parts of a frame's samples can't be put together.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum PartError {
    /// Something that was sent as a part is none.
    #[error("this is no part of a frame's samples: {0}")]
    Damaged(&'static str),
    /// Parts of frames with another method, size, number of samples, or other channels.
    #[error("parts of a frame's samples that belong to different frames")]
    Different,
    /// Two parts hold the same samples.
    #[error("samples {start} to {end} of a frame are in two of its parts")]
    Twice {
        /// The first of them.
        start: u32,
        /// One past the last.
        end: u32,
    },
    /// Samples that are in no part.
    #[error("of {total} samples of a frame, those from {first} on are in none of its parts")]
    Missing {
        /// The first of them.
        first: u32,
        /// All samples of the frame.
        total: u32,
    },
}

/// A budget as a message prints it: rounded up, so that the printed value suffices.
fn printed(budget: u64) -> ByteSize {
    let unit = match budget {
        ..0x400 => 1,
        0x400..0x10_0000 => 1 << 10,
        0x10_0000..0x4000_0000 => 1 << 20,
        _ => 1 << 29,
    };
    ByteSize(budget.next_multiple_of(unit))
}

fn smaller_image(largest: u32) -> String {
    match largest {
        0 => "a larger --memory-budget would help".to_owned(),
        _ => format!("up to {largest} would do"),
    }
}

impl Error {
    /// Returns `true` if only this method with its settings fails here, while another may succeed: neither a failed
    /// device nor a frame that no method could render.
    pub fn is_refusal(&self) -> bool {
        use crate::gpu::Error::{OutOfMemory, TooLarge};
        match self {
            Self::Gpu(error) => matches!(error, OutOfMemory { .. } | TooLarge { .. }),
            Self::ImageSize { .. } | Self::PixelSamples { .. } | Self::Cancelled | Self::Store(_) | Self::NoLevels => {
                false
            }
            Self::SampleRange { .. } | Self::Part(_) => false,
            _ => true,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_budget_that_is_printed_is_enough() {
        for budget in [1, 1023, 1025, 964_467, (1 << 20) - 1, (5 << 20) + 1, 73_123_456, (1 << 30) - 1, 3_333_333_333] {
            let named: ByteSize = printed(budget).to_string().parse().unwrap();
            assert!((budget..=budget + budget / 8 * 5 + 1024).contains(&named.as_u64()), "{budget}: {named}");
        }
    }
}
