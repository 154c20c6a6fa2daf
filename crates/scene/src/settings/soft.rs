//! Soft spheres, and the one transparent layer: methods that tell soft points from solid ones.

use super::discs::{LISTED, LongLists};
use crate::error::Error;
use crate::schema::{Key, Ladder, Range, SettingsField, Slider, ValueKind, keys, rounded, settings, value, words};
use crate::setting::Setting;
use crate::table::Table;
use crate::tree;

settings! {
    /// Settings of soft transparency (Seemann et al. 2018).
    #[derive(Copy, serde::Serialize, serde::Deserialize)]
    pub struct Soft {
        /// Threshold t: points with a field F above it are soft, the others solid.
        threshold: f32 = 0.5, in Range::UNIT;
        /// Density of soft points: `softness` or `lambda`.
        density: Density = Density::Softness(0.5);
        /// Field value of full density; from the threshold up to it points fade in.
        modulation: Option<f32> = None, in Range::UNIT, without "off", start 0.75;
        /// Number of concentric spheres per soft sphere (soft-concentric); adaptive follows its radius in pixels.
        shells: Shells = Shells::Adaptive, without "adaptive", start 8.0, tried SHELLS;
        /// Thickness of an adaptive shell (soft-concentric).
        pixels_per_shell: f32 = 4.0, in Range::POSITIVE, unit "pixels", slider Slider::Linear(1.0, 16.0);
        /// Density of a shell falls with the ray's distance from the center (soft-concentric, Eq. 15), else it is
        /// constant.
        equalize: bool = true, only &["soft-concentric"];
        /// Storage layout of a sphere on a ray (soft-base).
        layout: SoftLayout = SoftLayout::Precise;
        /// Sorting of long lists of fragments; the picture is the same.
        long_lists: LongLists = LongLists::Merge, only LISTED;
    }
    check agree;
}

fn agree(soft: &Soft, table: &Table<'_>) -> Result<(), Error> {
    let Some(most) = soft.modulation.filter(|_| table.get("modulation").is_some()) else { return Ok(()) };
    let threshold = soft.threshold;
    let problem = if most <= threshold {
        format!("`method.modulation` must lie above `method.threshold`, found {most} and {threshold}")
    } else if soft.layout == SoftLayout::Paper {
        "`method.layout = \"paper\"` has no room for what `method.modulation` needs: keep one".to_owned()
    } else {
        return Ok(());
    };
    Err(table.conflict("modulation", problem))
}

/// Density of the spheres of the soft methods.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub enum Density {
    /// `softness`: the opacity of a whole chord through the center of a sphere of median radius, in [0, 1].
    Softness(f32),
    /// `lambda`: the factor itself, at least 0.
    Lambda(f32),
}

impl SettingsField for Density {
    type Allowed = ();

    fn keys(&self, _: Key, (): ()) -> Vec<Key> {
        let (softness, lambda) = match *self {
            Self::Softness(softness) => (Some(softness), None),
            Self::Lambda(lambda) => (None, Some(lambda)),
        };
        let value = |x: Option<f32>| x.map(|x| Setting::Number(rounded(x)));
        keys! {
            /// Density of soft spheres, as in the equations, in place of softness.
            "lambda": ValueKind::Number(Range::NOT_NEGATIVE), value value(lambda), without "softness", rival "softness";
            /// Opacity of a ray through the middle of a soft sphere of median radius.
            "softness": ValueKind::Number(Range::UNIT), value value(softness), without "lambda", rival "lambda";
        }
    }

    fn update(&mut self, table: &Table<'_>, _: &str, (): ()) -> Result<(), Error> {
        let softness = table.number32("softness", Range::UNIT)?.map(Self::Softness);
        let lambda = table.number32("lambda", Range::NOT_NEGATIVE)?.map(Self::Lambda);
        if let Some(density) = softness.or(lambda) {
            *self = density;
        }
        Ok(())
    }
}

/// Concentric spheres that stand for one of `soft-concentric` at most.
pub const MAX_SHELLS: u32 = 64;

/// `shells`: concentric spheres that stand for one of `soft-concentric`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
pub enum Shells {
    /// Number of shells from the radius in pixels over `pixels_per_shell`, from 1 to [`MAX_SHELLS`].
    #[default]
    Adaptive,
    /// Fixed number, from 1 to [`MAX_SHELLS`].
    Fixed(u32),
}

value! {
    Shells => ValueKind::WordOr("adaptive", &ValueKind::Integer(1, MAX_SHELLS));
    |table, key| match table.get(key).map(|node| &node.value) {
        Some(tree::Value::String(_)) => table.choice(key, &[("adaptive", Shells::Adaptive)]),
        _ => Ok(table.integer(key, 1, MAX_SHELLS)?.map(Shells::Fixed)),
    };
    |shells| match *shells {
        Shells::Adaptive => None,
        Shells::Fixed(shells) => Some(Setting::Integer(shells)),
    };
}

const SHELLS: Ladder = Ladder { only: &["soft-concentric"], ..Ladder::new(&[1, 2, 4, 8], &[1, 4]) };

words! {
    /// `layout`: what is stored of an event of a sphere and a ray.
    pub enum SoftLayout {
        /// Depth and sphere; all else follows from the sphere.
        Precise = "precise",
        /// The paper's 16 bytes: color and distance from the center in 8 bits each, signed depth, radius, middle.
        Paper = "paper",
    }
}

settings! {
    /// Settings of `one-layer`.
    #[derive(Copy, serde::Serialize, serde::Deserialize)]
    pub struct OneLayer {
        /// Threshold t: points with a field F above it form the transparent layer, the others are solid.
        threshold: f32 = 0.5, in Range::UNIT;
        /// Opacity of the layer.
        softness: f32 = 0.5, in Range::UNIT;
    }
}
