//! `[image]`.

use glam::Vec3;

use crate::schema::{ValueKind, Word, settings, value};
use crate::setting::Setting;
use pellucid_core::color::ColorSpace;
use pellucid_core::image::MAX_SIDE;

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

/// Words for color spaces. The first one is the default.
const SPACES: [(&str, ColorSpace); 2] = [("linear", ColorSpace::Linear), ("encoded", ColorSpace::Encoded)];

const SPACE_WORDS: [Word; 2] = [
    Word { name: "linear", about: "Linear light." },
    Word { name: "encoded", about: "The stored sRGB values as they are." },
];

value! {
    ColorSpace => ValueKind::Words(&SPACE_WORDS);
    |table, key| table.choice(key, &SPACES);
    |own| SPACES.iter().find(|(_, space)| space == own).map(|(word, _)| Setting::from(*word));
}
