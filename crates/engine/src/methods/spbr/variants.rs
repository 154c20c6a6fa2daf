//! Forms in which the nearest points are found, and the variants of the passes.

use super::RUN;
use super::passes::{Draw, Large, Nearest, NearestDepth, NearestId, Renew, Resolve, Sum};
use crate::choices;
use crate::gpu::shader::{Choices, Shader};
use crate::gpu::{Device, Variant};
use crate::passes::compose::Cut;
use crate::passes::project::{DeviceCloud, Projecting, Shaded};
use crate::scene::{ColorSpace, ShadingModel};

/// How the nearest points are found.
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
    /// The form for a cloud, `wide` if there are 64-bit atomics.
    pub fn choose(device: &Device, cloud: &DeviceCloud, how: &Projecting, wide: bool) -> Self {
        let shaded = how.shading.model != ShadingModel::None && cloud.has_normals();
        match Cut::new(device, cloud.len()) {
            Ok(_) if wide && !shaded => Self::Single,
            _ if wide => Self::Wide,
            _ => Self::Narrow,
        }
    }

    /// Its passes over slots.
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

/// Properties of frame and cloud on which the passes over slots depend.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Kind {
    /// True if opacities differ from point to point.
    pub weighted: bool,
    /// True if points may ask for less than a pixel.
    pub thinned: bool,
    /// True if slanted normals make points smaller.
    pub slanted: bool,
    /// True if points may be wider than a pixel.
    pub squares: bool,
    /// True if rounds have more than one ensemble.
    pub planes: bool,
    /// True if the standard error is asked for.
    pub spread: bool,
}

choices!(struct Kind { weighted, thinned, slanted, squares, planes, spread });

/// How a pass goes through slots.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Through {
    /// An invocation for some slots each.
    Slots {
        /// True if drawn points are counted.
        counted: bool,
    },
    /// So many workgroups for each square of the list of large ones.
    Large {
        /// How many.
        stripes: u32,
    },
}

impl Choices for Through {
    fn all() -> Vec<Self> {
        vec![Self::Slots { counted: false }, Self::Slots { counted: true }, Self::Large { stripes: 3 }]
    }
}

impl Kind {
    /// The variant of a stage that goes through slots; `again`: of a later pass over the cloud.
    pub(super) fn variant(self, stage: Stage, through: Through, again: bool) -> Variant {
        let variant = Variant::plain()
            .with("WEIGHTED", u32::from(self.weighted))
            .with("THINNED", u32::from(self.thinned))
            .with("SLANTED", u32::from(self.slanted))
            .with("SQUARES", u32::from(self.squares))
            .with("PLANES", u32::from(self.planes));
        let variant = match through {
            Through::Slots { counted } => variant
                .walker("spbr_slots")
                .with("RUN", RUN as u32)
                .with("COUNTED", u32::from(counted))
                .with("AGAIN", u32::from(again)),
            Through::Large { stripes } => variant.walker("spbr_large").with("STRIPES", stripes),
        };
        match stage {
            Stage::Draw | Stage::Sum => variant.with("SPREAD", u32::from(self.spread)),
            _ => variant,
        }
    }

    /// The variants of a stage.
    fn variants(stage: Stage) -> Vec<Variant> {
        let choices = <(Self, (Through, bool))>::all().into_iter();
        choices.map(|(kind, (through, again))| kind.variant(stage, through, again)).collect()
    }
}

/// The variant of `spbr/draw`: cut and color space besides.
pub(super) fn draw_variant(variant: Variant, cut: Cut, color: ColorSpace) -> Variant {
    variant.with("PARTS", cut.parts).with("PART_LENGTH", cut.len).with("ENCODED", color as u32)
}

/// The variant of `spbr/sum`: shading besides.
pub(super) fn sum_variant(mut variant: Variant, shaded: Shaded) -> Variant {
    variant.overrides.extend(shaded.variant().overrides);
    variant
}

/// The variant of `spbr/resolve`.
pub(super) fn resolve_variant(spread: bool) -> Variant {
    Variant::plain().with("SPREAD", u32::from(spread))
}

/// The passes with their variants.
pub fn shaders() -> Vec<Shader> {
    let stages = Kind::variants;
    let (cut, color) = (Cut::all()[0], ColorSpace::Linear);
    let (draws, sums) = (stages(Stage::Draw), stages(Stage::Sum));
    // Where a point shows does not depend on its color: every variant of the one, and every variant of the other.
    let colored = <(Cut, ColorSpace)>::all().into_iter().map(|(cut, color)| draw_variant(draws[0].clone(), cut, color));
    let draw = draws.iter().map(|variant| draw_variant(variant.clone(), cut, color)).chain(colored);
    let shaded = Shaded::all();
    let colored = shaded.iter().map(|shaded| sum_variant(sums[0].clone(), *shaded));
    let sum = sums.iter().map(|variant| sum_variant(variant.clone(), shaded[0])).chain(colored);
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
