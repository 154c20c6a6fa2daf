//! The types in which a store keeps the columns of a cloud: the smallest from which every value comes back to the bit.

use std::sync::OnceLock;

use glam::{DVec3, Vec3};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::super::Grid;
use super::super::octree::attributes::{AttributeLayout, NumberType, Role};
use pellucid_core::cloud::Cloud;
use pellucid_core::cloud::gaussians::Gaussians;
use pellucid_core::color::{encode_srgb, linear_values};

/// The type of a column of float32 numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Narrow {
    /// Whole numbers up to 255.
    #[default]
    Byte,
    /// Whole numbers up to 65535.
    Short,
    /// Any.
    Float,
}

impl Narrow {
    /// Returns the smallest that holds some values exactly.
    pub fn of(values: &[f32]) -> Self {
        let narrow = |value: &f32| match *value {
            value if (value as u8 as f32).to_bits() == value.to_bits() => Self::Byte,
            value if (value as u16 as f32).to_bits() == value.to_bits() => Self::Short,
            _ => Self::Float,
        };
        values.par_iter().with_min_len(1 << 14).map(narrow).max().unwrap_or_default()
    }

    pub(super) fn kind(self) -> NumberType {
        match self {
            Self::Byte => NumberType::Uint8,
            Self::Short => NumberType::Uint16,
            Self::Float => NumberType::Float,
        }
    }
}

/// The type of coordinates that are stored in addition to those on the grid.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Exact {
    /// None, since the grid rounds no position.
    #[default]
    None,
    /// Float32, which all positions are.
    Float,
    /// Float64.
    Double,
}

impl Exact {
    /// Returns the smallest that keeps some positions.
    pub fn of(positions: &[DVec3], grid: &Grid) -> Self {
        let exact = |position: &DVec3| match position {
            p if grid.nearest(*p).is_some_and(|at| same(grid.position(at), *p)) => Self::None,
            p if same(p.as_vec3().as_dvec3(), *p) => Self::Float,
            _ => Self::Double,
        };
        positions.par_iter().with_min_len(1 << 14).map(exact).max().unwrap_or_default()
    }

    fn kind(self) -> Option<NumberType> {
        match self {
            Self::None => None,
            Self::Float => Some(NumberType::Float),
            Self::Double => Some(NumberType::Double),
        }
    }
}

/// True of the same bits: zeros of two signs are two places.
fn same(a: DVec3, b: DVec3) -> bool {
    a.to_array().map(f64::to_bits) == b.to_array().map(f64::to_bits)
}

/// The types of the columns that allow several.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Types {
    /// `true` if 16-bit sRGB rounds a color, so that linear float32 colors are stored in addition. Colors of Gaussians
    /// follow from their bases: true if one doesn't.
    pub linear_colors: bool,
    /// The exact positions of Gaussians, in addition to those on the grid: a picture of them is to be that of their
    /// file.
    #[serde(default)]
    pub exact: Exact,
    /// The type of the intensity.
    pub intensity: Narrow,
    /// Types of the scalars.
    pub scalars: Vec<Narrow>,
}

impl Types {
    /// Returns the smallest ones that keep a cloud exactly; positions of points that are no Gaussians are those of the
    /// grid.
    pub fn of(cloud: &Cloud, grid: &Grid) -> Self {
        let is_rounded = |color: &Vec3| color.to_array().iter().any(|linear| exact_srgb(*linear).is_none());
        let linear_colors = match (&cloud.colors, &cloud.gaussians) {
            (None, _) => false,
            (Some(colors), None) => colors.par_iter().any(is_rounded),
            (Some(colors), Some(splats)) => {
                colors.par_iter().enumerate().any(|(at, color)| *color != splats.linear_base(at))
            }
        };
        Self {
            linear_colors,
            exact: cloud.gaussians.as_ref().map(|_| Exact::of(&cloud.positions, grid)).unwrap_or_default(),
            intensity: cloud.intensity.as_deref().map(Narrow::of).unwrap_or_default(),
            scalars: cloud.scalars.iter().map(|(_, values)| Narrow::of(values)).collect(),
        }
    }

    /// Returns types that keep two parts of a cloud.
    #[must_use]
    pub fn and(mut self, other: &Self) -> Self {
        self.linear_colors |= other.linear_colors;
        self.exact = self.exact.max(other.exact);
        self.intensity = self.intensity.max(other.intensity);
        for (index, narrow) in other.scalars.iter().enumerate() {
            match self.scalars.get_mut(index) {
                Some(own) => *own = (*own).max(*narrow),
                None => self.scalars.push(*narrow),
            }
        }
        self
    }

    /// Returns the record of a cloud with these columns and so many points in its source.
    pub fn layout(&self, like: &Cloud, points: u64) -> AttributeLayout {
        let mut layout = self.columns(like);
        // Potree's viewer reads no 64-bit integers; float64 counts to 2⁵³.
        layout.add(Role::Place, if u32::try_from(points).is_ok() { NumberType::Uint32 } else { NumberType::Double });
        layout
    }

    /// Returns the same without the place in the source, for points whose source has no order.
    pub fn columns(&self, like: &Cloud) -> AttributeLayout {
        let mut layout = AttributeLayout::default();
        let mut add = |is_there: bool, role: Role, kind: NumberType| {
            if is_there {
                layout.add(role, kind);
            }
        };
        add(true, Role::Position, NumberType::Int32);
        add(like.colors.is_some(), Role::Rgb, NumberType::Uint16);
        add(like.intensity.is_some(), Role::Intensity, self.intensity.kind());
        add(like.classification.is_some(), Role::Classification, NumberType::Uint8);
        for (index, (name, _)) in like.scalars.iter().enumerate() {
            let narrow = self.scalars.get(index).copied().unwrap_or(Narrow::Float);
            add(true, Role::Scalar(name.clone()), narrow.kind());
        }
        (0..3).for_each(|axis| add(like.normals.is_some(), Role::Normal(axis), NumberType::Float));
        add(like.alphas.is_some(), Role::Alpha, NumberType::Float);
        add(like.radii.is_some(), Role::Radius, NumberType::Float);
        add(like.prepared.is_some(), Role::Field, NumberType::Float);
        add(like.prepared.as_ref().is_some_and(|prepared| prepared.shadows.is_some()), Role::Lit, NumberType::Float);
        let is_linear = like.colors.is_some() && self.linear_colors;
        (0..3).for_each(|axis| add(is_linear, Role::Linear(axis), NumberType::Float));
        let degree = like.gaussians.as_ref().map(|splats| splats.degree as u8);
        let shape = [Role::Extents, Role::Rotation, Role::Base];
        shape.into_iter().for_each(|role| add(degree.is_some(), role, NumberType::Float));
        add(degree > Some(0), Role::Harmonics(degree.unwrap_or(0)), NumberType::Float);
        let may_be_linear = like.gaussians.as_ref().is_some_and(Gaussians::may_be_linear);
        add(may_be_linear, Role::Linearity, NumberType::Uint8);
        if let Some(kind) = self.exact.kind() {
            add(true, Role::Exact, kind);
        }
        layout
    }
}

/// Bits of a float32 that don't choose the part of a table.
const PART_BITS: u32 = 10;

/// Returns for the first bits of a float32 the first of the linear values of 16-bit sRGB, which ascend, that isn't
/// below.
fn firsts(linear: &[f32]) -> &'static [u16] {
    static FIRSTS: OnceLock<Vec<u16>> = OnceLock::new();
    FIRSTS.get_or_init(|| {
        let mut at = 0;
        let mut first = |part: u32| {
            at += linear[at..].iter().take_while(|value| value.to_bits() < part << PART_BITS).count();
            at as u16
        };
        (0..=1.0_f32.to_bits() >> PART_BITS).map(&mut first).collect()
    })
}

/// Returns the 16-bit sRGB number whose linear value this is, to the bit.
pub(super) fn exact_srgb(linear: f32) -> Option<u16> {
    let (all, bits) = (linear_values(u16::MAX), linear.to_bits());
    let first = usize::from(*firsts(all).get((bits >> PART_BITS) as usize)?);
    let at = all[first..].iter().position(|value| value.to_bits() >= bits)?;
    (all[first + at].to_bits() == bits).then_some((first + at) as u16)
}

/// Returns the 16-bit sRGB number nearest to a linear value.
pub(super) fn nearest_srgb(linear: f32) -> u16 {
    // The conversion saturates, and makes 0 of what isn't a number.
    exact_srgb(linear).unwrap_or_else(|| (encode_srgb(linear) * f32::from(u16::MAX)).round() as u16)
}

#[cfg(test)]
mod tests {
    use super::*;
    use pellucid_core::color::decode_srgb;

    #[test]
    fn colors_of_16_bits_are_found() {
        for stored in 0..=u16::MAX {
            let linear = decode_srgb(f32::from(stored) / 65535.0);
            assert_eq!(exact_srgb(linear), Some(stored));
            assert_eq!(nearest_srgb(linear), (encode_srgb(linear) * 65535.0).round() as u16);
        }
        for rounded in [0.5, 1e-9, -0.0, -1.0, 1.000_001, f32::NAN, f32::INFINITY] {
            assert_eq!(exact_srgb(rounded), None, "{rounded}");
        }
        assert_eq!([nearest_srgb(2.0), nearest_srgb(-1.0), nearest_srgb(f32::NAN)], [65535, 0, 0]);
    }

    #[test]
    fn positions_that_the_grid_rounds_get_a_type_of_their_own() {
        let grid = Grid { scale: DVec3::splat(0.25), offset: DVec3::ZERO };
        let of = |x: f64| Exact::of(&[DVec3::ONE, DVec3::new(1.0, x, 0.0)], &grid);
        assert_eq!([of(0.5), of(0.125), of(0.1), of(-0.0)], [Exact::None, Exact::Float, Exact::Double, Exact::Float]);
    }

    #[test]
    fn numbers_get_the_smallest_type() {
        assert_eq!(Narrow::of(&[0.0, 255.0]), Narrow::Byte);
        assert_eq!(Narrow::of(&[0.0, 256.0, 65535.0]), Narrow::Short);
        for float in [0.5, -0.0, -1.0, 65536.0, f32::NAN, f32::INFINITY] {
            assert_eq!(Narrow::of(&[1.0, float]), Narrow::Float, "{float}");
        }
    }
}
