//! The keys of a `[[cloud]]` that decide the colors of its points.

use crate::error::Error;
use crate::schema::{ValueKind, Word, settings, value, words};
use crate::setting::Setting;
use crate::table::Table;
use crate::tree;
use pellucid_core::color::colormap::Colormap;
use pellucid_io::LasColumns;

settings! {
    /// Coloring of the points of a `[[cloud]]` without a `color`.
    pub struct ColorSettings {
        /// Source of the colors.
        color_by: ColorBy = ColorBy::Auto;
        /// Colors of values, from the lowest to the highest.
        colormap: ColormapName = ColormapName::Viridis;
        /// Values of the first and the last color; gps-time in seconds since the first point; `drawn`: percentiles of
        /// drawn points.
        range: Option<ColorRange> = None, without "percentiles 1 and 99 of the cloud's finite values";
        /// Reverse the colormap.
        reverse: bool = false;
        /// Use a logarithmic scale; values of 0 or less are gray.
        log: bool = false;
    }
    check check;
}

/// `range` of a `[[cloud]]`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ColorRange {
    /// Percentiles 1 and 99 of the points that are drawn, after classes, clips and outliers that are dropped.
    Drawn,
    /// The values of the first and the last color.
    Between([f64; 2]),
}

impl ColorRange {
    /// Returns the values, if they are given.
    pub fn ends(self) -> Option<[f64; 2]> {
        match self {
            Self::Drawn => None,
            Self::Between(ends) => Some(ends),
        }
    }
}

value! {
    ColorRange => ValueKind::WordOr("drawn", &ValueKind::Other("`[low, high]`"));
    |table, key| match table.get(key).map(|node| &node.value) {
        Some(tree::Value::String(_)) => table.choice(key, &[("drawn", ColorRange::Drawn)]),
        _ => Ok(table.range(key)?.map(ColorRange::Between)),
    };
    |range| match range {
        ColorRange::Drawn => Some(Setting::from("drawn")),
        ColorRange::Between(ends) => ends.setting(),
    };
}

words! {
    /// `colormap` of a `[[cloud]]`.
    pub enum ColormapName {
        /// Dark blue through green to yellow, perceptually even.
        Viridis = "viridis",
        /// Blue to yellow; even with red-green color blindness too.
        Cividis = "cividis",
        /// Black through purple to pale yellow.
        Magma = "magma",
        /// Black through red to pale yellow.
        Inferno = "inferno",
        /// Blue through red to yellow.
        Plasma = "plasma",
        /// A rainbow without false edges.
        Turbo = "turbo",
        /// Water through green and brown to snow.
        Terrain = "terrain",
        /// Black to white, even in sRGB.
        Grey = "grey",
    }
}

impl ColormapName {
    /// Returns its table.
    pub fn map(self) -> Colormap {
        // Every word names a table: a test tells.
        Colormap::named(self.word()).unwrap_or_else(Colormap::grey)
    }
}

/// Declares an enum of words with what each means, like [`words`], or the name of a scalar.
macro_rules! words_or_scalar {
    (
        $(#[$meta:meta])*
        pub enum $Name:ident {
            $($(#[doc = $about:literal])+ $Variant:ident = $word:literal,)+
        }
    ) => {
        $(#[$meta])*
        #[derive(Debug, Clone, PartialEq, Eq)]
        pub enum $Name {
            $($(#[doc = $about])+ $Variant,)+
            /// A scalar of the file, by its name.
            Scalar(String),
        }

        impl Default for $Name {
            fn default() -> Self {
                Self::Auto
            }
        }

        impl $Name {
            /// The words; everything else is the name of a scalar.
            const WORDS: &'static [Word] =
                &[$(Word { name: $word, about: concat!($($about),+).trim_ascii_start() }),+];

            fn known() -> impl Iterator<Item = (&'static str, Self)> {
                [$(($word, Self::$Variant)),+].into_iter()
            }
        }
    };
}

words_or_scalar! {
    /// `color_by` of a `[[cloud]]`.
    pub enum ColorBy {
        /// The file's colors unless all are black or all white, those of Gaussian splats always; else classes if there
        /// are three besides 0 and 1; else height.
        Auto = "auto",
        /// The file's colors.
        Rgb = "rgb",
        /// The coordinate along the vertical; with auto darker where intensity is small.
        Height = "height",
        /// The file's intensity.
        Intensity = "intensity",
        /// Classes, each with a color of its own.
        Classification = "classification",
        /// Number of the return within its pulse.
        Return = "return",
        /// Source of the point, usually a flight line.
        Source = "source",
        /// Seconds since the first point.
        GpsTime = "gps-time",
        /// Direction of the normal: x, y, z as red, green, blue.
        Normal = "normal",
        /// One color for each cloud.
        Cloud = "cloud",
        /// White for all.
        Uniform = "uniform",
        /// The field F of `field`.
        Field = "field",
    }
}

impl ColorBy {
    /// Returns the words of a scene file that name no scalar.
    pub fn words() -> impl Iterator<Item = &'static str> {
        Self::WORDS.iter().map(|word| word.name)
    }

    /// Returns its word in a scene file, or the name of the scalar.
    pub fn word(&self) -> &str {
        match self {
            Self::Scalar(name) => name,
            meaning => Self::known().find(|(_, known)| known == meaning).map_or("", |(word, _)| word),
        }
    }

    /// Returns `true` if values become colors by way of the colormap; `auto` may do so.
    pub fn is_mapped(&self) -> bool {
        !matches!(self, Self::Rgb | Self::Classification | Self::Normal | Self::Cloud | Self::Uniform)
    }

    /// Returns the columns of LAS files that it needs.
    pub fn las_columns(&self) -> LasColumns {
        match self {
            Self::Return => LasColumns { returns: true, ..LasColumns::default() },
            Self::Source => LasColumns { source: true, ..LasColumns::default() },
            Self::GpsTime => LasColumns { gps_time: true, ..LasColumns::default() },
            Self::Scalar(name) => LasColumns::named(name),
            _ => LasColumns::default(),
        }
    }
}

value! {
    ColorBy => ValueKind::WordsOr(ColorBy::WORDS, "the name of a scalar of the file");
    |table, key| {
        let Some(given) = table.string(key)? else { return Ok(None) };
        let known = ColorBy::known().find(|(word, _)| *word == given);
        Ok(Some(known.map_or_else(|| ColorBy::Scalar(given.to_owned()), |(_, by)| by)))
    };
    |by| Some(Setting::Word(by.word().to_owned()));
}

/// Refuses a logarithm of what has none, and notes keys without effect.
fn check(settings: &mut ColorSettings, table: &Table<'_>) -> Result<(), Error> {
    if let (Some([low, _]), Some(node), true) =
        (settings.range.and_then(ColorRange::ends), table.get("range"), settings.log)
        && low <= 0.0
    {
        let problem = format!("must begin above 0 with log = true, found {low:?}");
        return Err(table.error("range", node, problem));
    }
    if !settings.color_by.is_mapped() {
        for key in ["colormap", "range", "reverse", "log"] {
            if let Some(node) = table.get(key) {
                let by = settings.color_by.word();
                table.warn(format!("{}: `{key}` has no effect with color_by = {by:?}", node.place));
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_word_has_its_meaning() {
        for (word, meaning) in ColorBy::known() {
            let variant = format!("{meaning:?}").to_lowercase();
            assert_eq!((meaning.word(), variant), (word, word.replace('-', "")));
        }
    }

    #[test]
    fn every_colormap_has_its_table() {
        for (word, name) in ColormapName::ALL {
            assert_eq!(Some(name.map()), Colormap::named(word));
        }
    }
}
