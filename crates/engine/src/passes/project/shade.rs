//! The variants of shaders that shade points (shaders/shared/shade.wgsl).

use super::Projecting;
use crate::choices;
use crate::gpu::Variant;
use crate::scene::{ColorSpace, Formula};

impl Projecting {
    /// Returns how points of a cloud with or without normals are shaded.
    pub(crate) fn shaded(&self, normals: bool) -> Shaded {
        Shaded { model: self.shading.model.formula(), color: self.color, lit: self.lit, normals }
    }
}

/// Properties on which shaders that shade points depend.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Shaded {
    model: Formula,
    color: ColorSpace,
    lit: bool,
    pub(super) normals: bool,
}

choices!(
    enum Formula {
        None,
        Lambert,
        Phong,
    }
);

choices!(
    enum ColorSpace {
        Linear,
        Encoded,
    }
);

choices!(struct Shaded { model, color, lit, normals });

impl Shaded {
    /// Returns the variant of shaders/shared/shade.wgsl.
    pub(crate) fn variant(self) -> Variant {
        // Without a normal there is still a share of light.
        let model = if self.normals || self.lit { self.model } else { Formula::None };
        let variant = Variant::plain().with("SHADING", model as u32).with("LIT", u32::from(self.lit));
        variant.with("ENCODED", self.color as u32)
    }
}
