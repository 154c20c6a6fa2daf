//! Forms in which the nearest points are found, and the variants of the passes.

use super::passes::{Draw, Large, Nearest, NearestDepth, NearestId, Renew, Resolve, Sum};
use super::{run, small_square};
use crate::methods::prelude::*;
use crate::passes::project::Shaded;
use crate::scene::{ColorSpace, ShadingModel};

/// Way to find the nearest points.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Form {
    /// `spbr/draw`: nearest point and sum of colors in one go, by 64-bit atomics; colors of all points within reach.
    Single,
    /// `spbr/nearest` by 64-bit atomics, then `spbr/sum`.
    Wide,
    /// `spbr/nearest-depth`, `spbr/nearest-id`, then `spbr/sum`.
    Narrow,
}

impl Form {
    /// Returns the form for a cloud, `wide` if there are 64-bit atomics.
    pub fn choose(device: &Device, cloud: &DeviceCloud, how: &Projecting, wide: bool) -> Self {
        let shaded = how.shading.model != ShadingModel::None && cloud.has_normals();
        match Cut::new(device, cloud.len()) {
            Ok(_) if wide && !shaded => Self::Single,
            _ if wide => Self::Wide,
            _ => Self::Narrow,
        }
    }

    /// Returns its passes over slots.
    pub fn stages(self) -> &'static [Stage] {
        match self {
            Self::Single => &[Stage::Draw],
            Self::Wide => &[Stage::Nearest, Stage::Sum],
            Self::Narrow => &[Stage::NearestDepth, Stage::NearestId, Stage::Sum],
        }
    }
}

/// A pass over slots.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stage {
    /// [`Draw`]
    Draw,
    /// [`Nearest`]
    Nearest,
    /// [`NearestDepth`]
    NearestDepth,
    /// [`NearestId`]
    NearestId,
    /// [`Sum`]
    Sum,
}

impl Stage {
    /// Returns `true` if it is the first to meet a frame's points, and so counts those that are drawn.
    fn counts(self) -> bool {
        matches!(self, Self::Draw | Self::Nearest | Self::NearestDepth)
    }

    /// Returns `true` if the standard error shows in it.
    fn spreads(self) -> bool {
        matches!(self, Self::Draw | Self::Sum)
    }
}

/// Properties of frame and cloud on which the passes over slots depend.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SpbrKind {
    /// `true` if opacities differ from point to point.
    pub weighted: bool,
    /// `true` if points may ask for less than a pixel.
    pub thinned: bool,
    /// `true` if slanted normals make points smaller.
    pub slanted: bool,
    /// `true` if points may be wider than a pixel.
    pub squares: bool,
    /// `true` if rounds have more than one ensemble.
    pub planes: bool,
    /// `true` if the standard error is asked for.
    pub spread: bool,
}

choices!(struct SpbrKind { weighted, thinned, slanted, squares, planes, spread });

/// Way in which a pass goes through slots.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Through {
    /// An invocation for some slots each.
    Slots {
        /// `true` if they are of a later pass over the cloud.
        again: bool,
        /// `true` if the invocations of a workgroup share the pixels of its squares.
        spread: bool,
    },
    /// So many workgroups for each square of the list of large ones.
    Large {
        /// Number of stripes.
        stripes: u32,
    },
}

impl Choices for Through {
    fn all() -> Vec<Self> {
        let slots = <(bool, bool)>::all().into_iter().map(|(again, spread)| Self::Slots { again, spread });
        slots.chain([Self::Large { stripes: 3 }]).collect()
    }
}

impl SpbrKind {
    /// Returns `true` if there are such clouds and frames: points that ask for less in different ways may ask for less
    /// than a pixel.
    fn is_possible(self) -> bool {
        self.thinned || !(self.weighted || self.slanted)
    }

    /// Returns the variant of a stage that goes through slots.
    pub(super) fn variant(self, stage: Stage, through: Through) -> Variant {
        let variant = Variant::plain()
            .with("WEIGHTED", u32::from(self.weighted))
            .with("THINNED", u32::from(self.thinned))
            .with("SLANTED", u32::from(self.slanted))
            .with("SQUARES", u32::from(self.squares))
            .with("PLANES", u32::from(self.planes));
        let variant = match through {
            Through::Slots { again, spread } => variant
                .walker(if spread && self.squares { "spbr_spread" } else { "spbr_slots" })
                .with("RUN", run(spread) as u32)
                .with("SMALL_SQUARE", small_square(spread))
                .with("COUNTED", u32::from(stage.counts()))
                .with("AGAIN", u32::from(again)),
            Through::Large { stripes } => variant.walker("spbr_large").with("STRIPES", stripes),
        };
        if stage.spreads() { variant.with("SPREAD", u32::from(self.spread)) } else { variant }
    }

    /// The variants of a stage.
    fn variants(stage: Stage) -> Vec<Variant> {
        let possible = <(Self, Through)>::all().into_iter().filter(|(kind, _)| kind.is_possible());
        possible.map(|(kind, through)| kind.variant(stage, through)).collect()
    }
}

/// Returns the variant of `spbr/draw`: cut and color space besides.
pub(super) fn draw_variant(variant: Variant, cut: Cut, color: ColorSpace) -> Variant {
    cut.apply_to(variant).with("ENCODED", color as u32)
}

/// Returns the variant of `spbr/sum`: shading besides.
pub(super) fn sum_variant(mut variant: Variant, shaded: Shaded) -> Variant {
    variant.overrides.extend(shaded.variant().overrides);
    variant
}

/// Returns the variant of `spbr/resolve`.
pub(super) fn resolve_variant(spread: bool) -> Variant {
    Variant::plain().with("SPREAD", u32::from(spread))
}

/// Returns the passes with their variants.
pub fn shaders() -> Vec<Shader> {
    let stages = SpbrKind::variants;
    let colored = |draw: Variant| {
        <(Cut, ColorSpace)>::all().into_iter().map(move |(cut, color)| draw_variant(draw.clone(), cut, color))
    };
    let shaded = |sum: Variant| Shaded::all().into_iter().map(move |shaded| sum_variant(sum.clone(), shaded));
    let draw = stages(Stage::Draw).into_iter().flat_map(colored);
    let sum = stages(Stage::Sum).into_iter().flat_map(shaded);
    vec![
        Shader::new::<Draw>(draw),
        Shader::new::<Nearest>(stages(Stage::Nearest)),
        Shader::new::<NearestDepth>(stages(Stage::NearestDepth)),
        Shader::new::<NearestId>(stages(Stage::NearestId)),
        Shader::new::<Sum>(sum),
        Shader::plain::<Renew>(),
        Shader::plain::<Large>(),
        Shader::new::<Resolve>([false, true].map(resolve_variant)),
    ]
}
