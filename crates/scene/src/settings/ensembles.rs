//! Points that are dealt to ensembles.

use crate::schema::{Ladder, Range, Slider, ValueKind, rounded, settings, value};
use crate::setting::Setting;
use crate::tree;

/// Most ensembles.
pub const MAX_ENSEMBLES: u32 = 65_536;

settings! {
    /// Settings of `spbr`.
    #[derive(Copy, serde::Serialize, serde::Deserialize)]
    pub struct Spbr {
        /// Number L of random parts of the points whose images are averaged.
        ensembles: u32 = 100, in 1..=MAX_ENSEMBLES, slider Slider::Count(1, 1000), refines true, tried ENSEMBLES;
        /// Slanted surfaces appear more opaque (Tanaka et al. 2016, Eq. 2); false compensates for it.
        cos_theta: bool = true;
        /// Brighten the picture to that of opaque surfaces, as `spbr-simplified` does.
        brighten: bool = false;
    }
}

settings! {
    /// Settings of `spbr-simplified`.
    #[derive(Copy, serde::Serialize, serde::Deserialize)]
    pub struct SpbrSimplified {
        /// Number L of random parts of the points whose images are averaged.
        ensembles: u32 = 100, in 1..=MAX_ENSEMBLES, slider Slider::Count(1, 1000), refines true;
        /// Factor p on the colors; auto makes the picture as bright as a single ensemble.
        brightness: Brightness = Brightness::Auto, without "auto", start 1.0, slider Slider::Powers(0.1, 100.0);
    }
}

const ENSEMBLES: Ladder = Ladder {
    fine: &[1, 2, 4, 8, 16, 32, 64, 128, 256, 512, 1024],
    ..Ladder::new(&[1, 3, 10, 30, 100, 300, 1000], &[1, 10, 100])
};

/// The factor p on the colors of an image (Uchida et al. 2020, Section 3.4).
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub enum Brightness {
    /// Whatever makes the image about as bright as that of a single ensemble.
    Auto,
    /// Fixed factor, above 0.
    Factor(f32),
}

value! {
    Brightness => ValueKind::WordOr("auto", &ValueKind::Number(Range::POSITIVE));
    |table, key| match table.get(key).map(|node| &node.value) {
        Some(tree::Value::String(_)) => table.choice(key, &[("auto", Brightness::Auto)]),
        _ => Ok(table.number32(key, Range::POSITIVE)?.map(Brightness::Factor)),
    };
    |brightness| match *brightness {
        Brightness::Auto => None,
        Brightness::Factor(factor) => Some(Setting::Number(rounded(factor))),
    };
}
