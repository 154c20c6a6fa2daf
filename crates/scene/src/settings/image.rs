//! `[image]`.

use glam::Vec3;

use crate::schema::{ValueKind, Word, settings, value};
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
