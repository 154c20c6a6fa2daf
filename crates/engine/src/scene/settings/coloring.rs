//! The keys of a `[[cloud]]` that decide the colors of its points.

use crate::color::colormap::Colormap;
use crate::io::LasColumns;
use crate::scene::Setting;
use crate::scene::error::Error;
use crate::scene::schema::{Kind, Value, settings, words};
use crate::scene::table::Table;

settings! {
    /// How the points of a `[[cloud]]` without a `color` are colored.
    pub struct ColorSettings {
        /// What colors show: auto takes the file's colors unless all are black or all white, else classes if there are at least
        /// three besides 0 and 1, else height, darker where intensity is small.
        color_by: ColorBy = ColorBy::Auto;
        /// The colors of values, from the lowest to the highest.
        colormap: ColormapName = ColormapName::Viridis;
        /// The values that get the first and the last color; of gps-time in seconds since the first point.
        range: Option<[f64; 2]> = None, without "percentiles 1 and 99 of the cloud's finite values";
        /// Turns the colormap round.
        reverse: bool = false;
        /// Logarithmic: colors show ln of values; those that are 0 or less are grey.
        log: bool = false;
    }
    check check;
}

words! {
    /// `colormap` of a `[[cloud]]`.
    pub enum ColormapName {
        /// From dark blue by green to yellow, even to the eye.
        Viridis = "viridis",
        /// From blue to yellow; also even to eyes that see no red or no green.
        Cividis = "cividis",
        /// From black by purple to pale yellow.
        Magma = "magma",
        /// From black by red to pale yellow.
        Inferno = "inferno",
        /// From blue by red to yellow.
        Plasma = "plasma",
        /// A rainbow without false edges.
        Turbo = "turbo",
        /// From water by green and brown to snow.
        Terrain = "terrain",
        /// From black to white, even in sRGB.
        Grey = "grey",
    }
}

impl ColormapName {
    /// Its table.
    pub fn map(self) -> Colormap {
        let Some(map) = Colormap::named(self.word()) else { unreachable!("every word names a table: a test tells") };
        map
    }
}

/// `color_by` of a `[[cloud]]`.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum ColorBy {
    /// The best that the file has.
    #[default]
    Auto,
    /// The file's colors.
    Rgb,
    /// The coordinate along the vertical.
    Height,
    /// Intensity.
    Intensity,
    /// The colors of classes.
    Classification,
    /// The number of a return within its pulse.
    Return,
    /// The source of a point, mostly a flight line.
    Source,
    /// Time in seconds since the first point.
    GpsTime,
    /// The normal's direction: x, y, z as red, green, blue.
    Normal,
    /// One color for each cloud.
    Cloud,
    /// One color for all: white.
    Uniform,
    /// The field F.
    Field,
    /// A scalar of the file, by its name.
    Scalar(String),
}

impl ColorBy {
    /// The words; everything else is the name of a scalar.
    const WORDS: [(&'static str, Self); 12] = [
        ("auto", Self::Auto),
        ("rgb", Self::Rgb),
        ("height", Self::Height),
        ("intensity", Self::Intensity),
        ("classification", Self::Classification),
        ("return", Self::Return),
        ("source", Self::Source),
        ("gps-time", Self::GpsTime),
        ("normal", Self::Normal),
        ("cloud", Self::Cloud),
        ("uniform", Self::Uniform),
        ("field", Self::Field),
    ];

    /// The words that a scene file writes for what is no scalar's name.
    pub fn words() -> impl Iterator<Item = &'static str> {
        Self::WORDS.iter().map(|(word, _)| *word)
    }

    /// Its word in a scene file, or the name of the scalar.
    pub fn word(&self) -> &str {
        match self {
            Self::Scalar(name) => name,
            known => Self::WORDS.iter().find(|(_, by)| by == known).map_or("", |(word, _)| word),
        }
    }

    /// True if values become colors by way of the colormap; `auto` may do so.
    pub fn is_mapped(&self) -> bool {
        !matches!(self, Self::Rgb | Self::Classification | Self::Normal | Self::Cloud | Self::Uniform)
    }

    /// The columns of LAS files that it needs.
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

impl Value for ColorBy {
    type Allowed = ();

    fn kind((): ()) -> Kind {
        Kind::Other(
            "`\"auto\"`, `\"rgb\"`, `\"height\"`, `\"intensity\"`, `\"classification\"`, `\"return\"`, `\"source\"`, \
             `\"gps-time\"`, `\"normal\"`, `\"cloud\"`, `\"uniform\"`, `\"field\"`, or the name of a scalar of the file",
        )
    }

    fn read(table: &Table<'_>, key: &str, (): ()) -> Result<Option<Self>, Error> {
        let Some(word) = table.string(key)? else { return Ok(None) };
        let known = Self::WORDS.into_iter().find(|(known, _)| *known == word);
        Ok(Some(known.map_or_else(|| Self::Scalar(word.to_owned()), |(_, by)| by)))
    }

    fn setting(&self) -> Option<Setting> {
        Some(Setting::Word(self.word().to_owned()))
    }
}

/// The lower and the upper end of a range.
impl Value for [f64; 2] {
    type Allowed = ();

    fn kind((): ()) -> Kind {
        Kind::Other("`[low, high]`")
    }

    fn read(table: &Table<'_>, key: &str, (): ()) -> Result<Option<Self>, Error> {
        table.range(key)
    }

    fn setting(&self) -> Option<Setting> {
        Some(Setting::from(*self))
    }
}

/// Refuses a logarithm of what has none, and notes keys without effect.
fn check(settings: &mut ColorSettings, table: &Table<'_>) -> Result<(), Error> {
    if let (Some([low, _]), Some(node), true) = (settings.range, table.get("range"), settings.log)
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
    fn every_colormap_has_its_table() {
        for (word, name) in ColormapName::ALL {
            assert_eq!(Some(name.map()), Colormap::named(word));
        }
    }
}
