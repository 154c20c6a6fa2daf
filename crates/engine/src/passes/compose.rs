//! Composing: how stages that blend reach every splat by its index, however many there are.

use super::Error;
use crate::choices::Choices;
use crate::gpu::{Buffer, Device, GpuType, PARTS, Slice, Variant};
use crate::passes::project::{DISCS, DeviceCloud, Footprint, Shaded, Splat, Tilt, View};
use crate::scene::{ColorSpace, Falloff};
use crate::{choices, group};

/// Division of per-splat buffers so that one pass reaches every splat: 1 or 4 parts of `len` splats.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Cut {
    /// 1 or 4.
    pub parts: u32,
    /// Splats of a part.
    pub len: u32,
    /// Elements of the buffer of tilts for each splat.
    pub tilt_stride: u32,
}

impl Cut {
    /// One part, whatever its length.
    pub const WHOLE: Self = Self { parts: 1, len: 1 << 30, tilt_stride: 1 };

    /// Returns the cut for so many points on a device, or an error if four parts do not reach.
    pub fn new(device: &Device, points: u64) -> Result<Self, Error> {
        let (len, limit) = (Self::longest(device), Self::most(device));
        if points > limit {
            return Err(Error::TooManyPoints { points, limit });
        }
        Ok(Self { parts: if points <= len { 1 } else { PARTS as u32 }, len: len as u32, tilt_stride: 1 })
    }

    /// Returns the cut for the splats of a cloud with this footprint.
    pub fn of(device: &Device, cloud: &DeviceCloud, footprint: Footprint) -> Result<Self, Error> {
        let stride = footprint.tilt_stride().max(1);
        let cut = Self::new(device, cloud.len() * stride)?;
        Ok(Self { len: (u64::from(cut.len) / stride) as u32, tilt_stride: stride as u32, ..cut })
    }

    /// Returns the largest number of points of a device: a column of theirs is one buffer, bound as up to four parts.
    pub fn most(device: &Device) -> u64 {
        let whole = device.limits().buffer_bytes / size_of::<Splat>() as u64;
        (PARTS as u64 * Self::longest(device)).min(whole)
    }

    /// Most splats of a part.
    fn longest(device: &Device) -> u64 {
        // No element is wider than a splat; 64 of any element are a multiple of every offset alignment.
        ((device.limits().binding_bytes / size_of::<Splat>() as u64) & !63).min(1 << 30)
    }

    /// Adds the constants of stages that reach splats by their index. One part is one variant, whatever its length.
    pub fn apply_to(self, variant: Variant) -> Variant {
        let len = if self.parts == 1 { Self::WHOLE.len } else { self.len };
        variant.with("PARTS", self.parts).with("PART_LENGTH", len)
    }

    /// The parts of the buffer of tilts.
    fn tilts(self, buffer: &Buffer<Tilt>) -> [Slice<'_, Tilt>; PARTS] {
        Self { len: self.len * self.tilt_stride, ..self }.slices(buffer)
    }

    /// Returns the parts of a buffer; those beyond its end repeat its first element and are not read.
    pub fn slices<T: GpuType>(self, buffer: &Buffer<T>) -> [Slice<'_, T>; PARTS] {
        let len = u64::from(self.len);
        std::array::from_fn(|i| {
            let start = i as u64 * len;
            if start < buffer.len() { buffer.slice(start, len.min(buffer.len() - start)) } else { buffer.slice(0, 1) }
        })
    }
}

group! {
    /// Bindings of the cloud for every stage that composes.
    pub Composing as ComposingGroup {
        /// The camera.
        view: Uniform<View>,
        /// Colors as blended, and opacities.
        colors: Parts<[f32; 4]>,
        /// Projected splats.
        splats: Parts<Splat>,
        /// Depths of the splats.
        splat_depths: Parts<f32>,
        /// Tilts of the splats.
        tilts: Parts<Tilt>,
    }
}

impl<'a> Composing<'a> {
    /// Returns the cloud, cut.
    pub fn new(cloud: &'a DeviceCloud, cut: Cut) -> Self {
        let (colors, tilts) = (cut.slices(&cloud.colors), cut.tilts(&cloud.tilts));
        let (splats, splat_depths) = (cut.slices(&cloud.splats), cut.slices(&cloud.splat_depths));
        Self { view: cloud.view(), colors, splats, splat_depths, tilts }
    }
}

/// Fragments that may be left out at the back of a pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
pub enum Stop {
    /// Fragments that change no bit of the image.
    #[default]
    Exact,
    /// Fragments that change no 8-bit value of the composed image by more than a quarter of a step.
    EightBit {
        /// `true` if the image goes without background, so that color is divided by A.
        transparent: bool,
    },
}

/// Values of `STOP` in WGSL.
pub(crate) const STOP_NEVER: u32 = 0;
pub(crate) const STOP_EXACT: u32 = 1;
pub(crate) const STOP_SRGB: u32 = 2;
pub(crate) const STOP_ENCODED: u32 = 3;
/// Values of `STOP` with an early end.
pub(crate) const STOPS: [u32; 3] = [STOP_EXACT, STOP_SRGB, STOP_ENCODED];

/// Returns the value of `STOP` in WGSL, and the bound on colors that goes with it, from that of what is blended.
pub fn stop(stop: Stop, space: ColorSpace, most: f32) -> (u32, f32) {
    match stop {
        Stop::Exact => (STOP_EXACT, most),
        Stop::EightBit { transparent } => {
            // The background may come behind. Without one, C / A moves by at most T (m + 1) / A, and A is above 0.9
            // here.
            let most = most.max(1.0);
            let most = if transparent { (most + 1.0) * 1.2 } else { most };
            (if space == ColorSpace::Linear { STOP_SRGB } else { STOP_ENCODED }, most)
        }
    }
}

/// Returns the variant of a stage that composes.
pub fn variant(cut: Cut, footprint: Footprint, falloff: Falloff) -> Variant {
    cut.apply_to(shape_variant(footprint, falloff))
}

/// Returns the variant of a stage that reaches discs that face the viewer, and leaves their falloff to itself.
pub fn disc_variant(cut: Cut) -> Variant {
    cut.apply_to(Variant::plain().with("SHAPE", Footprint::Disc as u32))
}

/// Returns the variant of a stage that composes splats which it reaches by itself.
pub fn shape_variant(footprint: Footprint, falloff: Falloff) -> Variant {
    Variant::plain().with("SHAPE", footprint as u32).with("FALLOFF", falloff as u32)
}

/// Constants that shaders share with this module.
pub(crate) const CONSTANTS: [(&str, u32); 4] = [
    ("FALLOFF_GAUSSIAN", Falloff::Gaussian as u32),
    ("STOP_NEVER", STOP_NEVER),
    ("STOP_EXACT", STOP_EXACT),
    ("STOP_SRGB", STOP_SRGB),
];

choices!(
    enum Falloff {
        Flat,
        Gaussian,
    }
);

/// The cuts; a device may want either.
impl Choices for Cut {
    fn all() -> Vec<Self> {
        [1, PARTS as u32].map(|parts| Self { parts, len: 1 << 20, tilt_stride: 1 }).to_vec()
    }
}

impl Shaded {
    /// Returns the variant of a shader that reads points in parts.
    pub(crate) fn cut(self, cut: Cut) -> Variant {
        cut.apply_to(self.variant())
    }

    /// Returns the variants of such a shader.
    pub(crate) fn cut_variants() -> Vec<Variant> {
        <(Self, Cut)>::all().into_iter().map(|(shaded, cut)| shaded.cut(cut)).collect()
    }
}

/// Returns the discs, and all falloffs, as [`shape_variant`] has them.
pub(crate) fn shape_variants() -> Vec<Variant> {
    let falloffs = || Falloff::all().into_iter();
    DISCS.iter().flat_map(|disc| falloffs().map(move |falloff| shape_variant(*disc, falloff))).collect()
}

/// Returns the discs, all falloffs and cuts, as [`variant`] has them.
pub(crate) fn variants() -> Vec<Variant> {
    variants_of(&DISCS)
}

/// Returns some footprints, all falloffs and cuts, as [`variant`] has them.
pub(crate) fn variants_of(footprints: &[Footprint]) -> Vec<Variant> {
    let choices = || <(Cut, Falloff)>::all().into_iter();
    footprints.iter().flat_map(|shape| choices().map(move |(cut, falloff)| variant(cut, *shape, falloff))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stopping_knows_what_may_still_come() {
        use ColorSpace::{Encoded, Linear};
        assert_eq!(stop(Stop::Exact, Linear, 0.25), (1, 0.25));
        assert_eq!(stop(Stop::Exact, Encoded, 1.0), (1, 1.0));
        // The background may be white.
        assert_eq!(stop(Stop::EightBit { transparent: false }, Linear, 0.25), (2, 1.0));
        assert_eq!(stop(Stop::EightBit { transparent: false }, Encoded, 3.0), (3, 3.0));
        assert_eq!(stop(Stop::EightBit { transparent: true }, Linear, 0.25), (2, 2.4));
        assert_eq!(stop(Stop::EightBit { transparent: true }, Encoded, 1.5), (3, 3.0));
    }
}
