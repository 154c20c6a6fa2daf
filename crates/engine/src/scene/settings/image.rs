//! `[image]`.

use glam::Vec3;

use crate::image::MAX_SIDE;
use crate::scene::schema::{settings, words};

settings! {
    /// `[image]`.
    #[derive(Copy)]
    pub struct ImageSettings {
        /// Width and height of the image.
        size: [u32; 2] = [1024, 1024], in 1..=MAX_SIDE, unit "pixels";
        /// Color behind all points, always in linear light.
        background: Vec3 = Vec3::ZERO;
        /// Color space of blending: linear light, or the encoded (stored) values.
        color: Option<ColorSpace> = None, without "`\"linear\"`; `\"encoded\"` where every cloud is of Gaussians";
    }
}

impl ImageSettings {
    /// Returns the space in which colors are blended.
    pub fn color_space(&self) -> ColorSpace {
        self.color.unwrap_or_default()
    }
}

words! {
    /// The space in which blending runs.
    pub enum ColorSpace {
        /// Linear light.
        Linear = "linear",
        /// The stored sRGB values as they are.
        Encoded = "encoded",
    }
}
