//! `[image]`.

use glam::Vec3;

use crate::schema::{Range, Slider, ValueKind, Word, settings, value};
use crate::setting::Setting;
use crate::tree;
use pellucid_core::color::ColorSpace;
use pellucid_core::image::MAX_SIDE;

settings! {
    /// `[image]`.
    #[derive(Copy)]
    pub struct ImageSettings {
        /// Width and height of the image.
        size: [u32; 2] = [1024, 1024], in 1..=MAX_SIDE, unit "pixels";
        /// Color behind all points, in linear light; auto, the default without a scene file, is black, or white behind
        /// dark points.
        background: Background = Background::Color(Vec3::ZERO);
        /// Samples of a pixel's area: images, each moved by a fraction of a pixel, whose mean is shown; auto: as many
        /// as it takes.
        samples: Samples = Samples::Count(1), unit "samples per pixel";
        /// RMSE between the picture and one with half as many samples at which `samples = "auto"` ends; it doubles
        /// them from 4 to 64.
        sampling_error: f32 = 0.003, in Range::POSITIVE, slider Slider::Powers(0.0001, 0.1);
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

/// The most samples of a pixel.
pub const MAX_SAMPLES: u32 = 64;

/// `samples`: samples of a pixel's area.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Samples {
    /// Enough for `sampling_error`, from 4 to 64.
    Auto,
    /// A power of two, from 1 to 64.
    Count(u32),
}

impl Samples {
    /// Returns the number; that of `auto` is 1 as long as no picture has settled it.
    pub fn count(self) -> u32 {
        match self {
            Self::Auto => 1,
            Self::Count(count) => count,
        }
    }
}

value! {
    Samples => ValueKind::WordOr("auto", &ValueKind::OneOf(&[1, 2, 4, 8, 16, 32, 64]));
    |table, key| {
        let Some(node) = table.get(key) else { return Ok(None) };
        match &node.value {
            tree::Value::String(word) if word == "auto" => return Ok(Some(Samples::Auto)),
            tree::Value::Integer(count) if count.count_ones() == 1 => {
                let allowed = u32::try_from(*count).ok().filter(|count| *count <= MAX_SAMPLES);
                if let Some(count) = allowed {
                    return Ok(Some(Samples::Count(count)));
                }
            }
            _ => {}
        }
        Err(table.wrong(key, node, "1, 2, 4, 8, 16, 32, 64 or \"auto\""))
    };
    |samples| Some(match *samples {
        Samples::Auto => Setting::from("auto"),
        Samples::Count(count) => Setting::Integer(count),
    });
}

/// `background`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Background {
    /// Black, or white where the points are dark ([`are_dark`](crate::are_dark)).
    Auto,
    /// Linear R, G, B, each from 0 to 1.
    Color(Vec3),
}

impl Background {
    /// Returns the color, linear; that of `auto` is black as long as no points have settled it.
    pub fn color(self) -> Vec3 {
        match self {
            Self::Auto => Vec3::ZERO,
            Self::Color(color) => color,
        }
    }
}

value! {
    Background => ValueKind::WordOr("auto", &ValueKind::Color);
    |table, key| match table.get(key).map(|node| &node.value) {
        Some(tree::Value::String(word)) if word == "auto" => Ok(Some(Background::Auto)),
        _ => Ok(table.color(key)?.map(Background::Color)),
    };
    |background| match background {
        Background::Auto => Some(Setting::from("auto")),
        Background::Color(color) => color.setting(),
    };
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
