//! `[image]`.

use glam::Vec3;

use crate::scene::schema::{settings, words};

/// Images have at most this many pixels on a side: what framebuffers allow, and what the pixels of splats are packed for.
pub const MAX_SIDE: u32 = 16_384;

settings! {
    /// `[image]`.
    #[derive(Copy)]
    pub struct ImageSettings {
        /// Width and height of the image.
        size: [u32; 2] = [1024, 1024], in 1..=MAX_SIDE, unit "pixels";
        /// What is behind all points, in linear light whatever `color` says.
        background: Vec3 = Vec3::ZERO;
        /// In which space colors are blended: linear light, or encoded as they are stored.
        color: ColorSpace = ColorSpace::Linear;
    }
}

words! {
    /// In which space blending runs.
    pub enum ColorSpace {
        /// Linear light.
        Linear = "linear",
        /// The stored sRGB values as they are.
        Encoded = "encoded",
    }
}
