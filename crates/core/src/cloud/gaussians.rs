//! Gaussian splats: what each of them has in addition to its center and its opacity (Kerbl et al. 2023).

use glam::{Quat, Vec3};
use rayon::prelude::*;

use crate::color::{ColorSpace, decode_srgb, encode_srgb};
use crate::parallel;

/// The spherical harmonic of degree 0, 1 / (2√π).
pub const Y0: f64 = 0.282_094_791_773_878_14;

/// The highest degree of harmonics that any format has.
pub const MAX_DEGREE: u32 = 4;

/// Largest reach of a Gaussian, in its largest standard deviations: where opacity 1 falls below 1/255.
pub const REACH: f32 = 3.33;

/// A number for each degree, from 0 on.
pub type ByDegree = [f32; MAX_DEGREE as usize + 1];

/// Returns the largest reach of a Gaussian with these extents ([`REACH`]), in their unit; finite.
pub fn reach(extents: Vec3) -> f32 {
    (REACH * extents.max_element()).min(f32::MAX)
}

/// Returns the linear color of a display value, which may lie beyond 0 and 1.
pub fn linear(base: Vec3) -> Vec3 {
    base.clamp(Vec3::ZERO, Vec3::ONE).to_array().map(decode_srgb).into()
}

/// Meaning of the colors of Gaussians, harmonics included.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub enum ColorCoding {
    /// Display values (sRGB-encoded), as almost all files have them.
    #[default]
    Display,
    /// Linear values, as glTF's `lin_rec709_display` has them.
    Linear,
    /// Either, splat by splat; `true` of those that are linear.
    Each(Vec<bool>),
}

impl ColorCoding {
    /// Returns the meaning of the colors of splats, each of which is linear or not. Without any it is that of linear
    /// ones.
    pub fn of(linear: Vec<bool>) -> Self {
        match linear.contains(&false) {
            false => Self::Linear,
            true if linear.contains(&true) => Self::Each(linear),
            true => Self::Display,
        }
    }
}

/// Columns of Gaussian splats, each as long as the positions of the points that they belong to. A point that is none
/// has extents of zero, and no harmonics.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Gaussians {
    /// Standard deviations along the three axes in the unit of positions: finite, at least 0, not all of them 0.
    pub extents: Vec<Vec3>,
    /// Turns x, y and z into the three axes: unit quaternions.
    pub rotations: Vec<Quat>,
    /// Color without harmonics of higher degree, not clamped: ½ + Y₀·f_dc.
    pub bases: Vec<Vec3>,
    /// Meaning of these colors and their harmonics.
    pub coding: ColorCoding,
    /// The degree of the harmonics, 0 to [`MAX_DEGREE`].
    pub degree: u32,
    /// Coefficients from degree 1 on, [`Self::coefficients`] for each splat, splat after splat, red, green and blue of
    /// each.
    pub harmonics: Vec<Vec3>,
}

/// Returns the number of coefficients from degree 1 to this one.
pub fn coefficients(degree: u32) -> usize {
    ((degree + 1) * (degree + 1) - 1) as usize
}

impl Gaussians {
    /// Makes as many points that are no Gaussians.
    pub fn none(count: usize) -> Self {
        Self {
            extents: vec![Vec3::ZERO; count],
            rotations: vec![Quat::IDENTITY; count],
            bases: vec![Vec3::ZERO; count],
            coding: ColorCoding::Display,
            degree: 0,
            harmonics: Vec::new(),
        }
    }

    /// Returns the number of coefficients of each splat from degree 1 on.
    pub fn coefficients(&self) -> usize {
        coefficients(self.degree)
    }

    /// Returns the number of points.
    pub fn len(&self) -> usize {
        self.extents.len()
    }

    /// Returns `true` if there are no points.
    pub fn is_empty(&self) -> bool {
        self.extents.is_empty()
    }

    /// Returns `true` if a point is a Gaussian.
    pub fn is_one(&self, index: usize) -> bool {
        self.extents[index] != Vec3::ZERO
    }

    /// Returns the number of points that are Gaussians.
    pub fn count(&self) -> u64 {
        self.extents.par_iter().filter(|extents| **extents != Vec3::ZERO).count() as u64
    }

    /// Returns `true` if every point is a Gaussian.
    pub fn are_all(&self) -> bool {
        self.extents.par_iter().all(|extents| *extents != Vec3::ZERO)
    }

    /// Returns `true` if the colors of a splat are linear.
    pub fn is_linear(&self, index: usize) -> bool {
        match &self.coding {
            ColorCoding::Display => false,
            ColorCoding::Linear => true,
            ColorCoding::Each(linear) => linear[index],
        }
    }

    /// Returns `true` if the colors of some splats are linear, or may be in a list that stands for others.
    pub fn may_be_linear(&self) -> bool {
        self.coding != ColorCoding::Display
    }

    /// Returns the space in which they are meant to be blended: display values, in which most are trained, or linear
    /// light, if any colors may be linear.
    pub fn blend_space(&self) -> ColorSpace {
        if self.may_be_linear() { ColorSpace::Linear } else { ColorSpace::Encoded }
    }

    /// Returns the linear color of a splat without harmonics of higher degree, clamped to [0, 1].
    pub fn linear_base(&self, index: usize) -> Vec3 {
        let base = self.bases[index];
        if self.is_linear(index) { base.clamp(Vec3::ZERO, Vec3::ONE) } else { linear(base) }
    }

    /// Returns the coefficients of a splat from degree 1 on.
    pub fn harmonics_of(&self, index: usize) -> &[Vec3] {
        let count = self.coefficients();
        &self.harmonics[index * count..(index + 1) * count]
    }

    /// Returns the same splats with harmonics up to a degree, which may be higher than theirs.
    #[must_use]
    pub fn with_degree(self, degree: u32) -> Self {
        if degree == self.degree {
            return self;
        }
        let new = coefficients(degree);
        let copy =
            |i: usize, to: &mut [Vec3]| to.iter_mut().zip(self.harmonics_of(i)).for_each(|(to, from)| *to = *from);
        Self { degree, harmonics: parallel::runs(self.len(), new, copy), ..self }
    }

    /// Returns some of them, in another order: place i gets splat `from(i)` of `count` places.
    #[must_use]
    pub fn picked(&self, count: usize, from: impl Fn(usize) -> usize + Sync) -> Self {
        let coding = match &self.coding {
            ColorCoding::Each(linear) => ColorCoding::Each(parallel::map(count, |i| linear[from(i)])),
            same => same.clone(),
        };
        Self { coding, ..Self::gathered(count, self.degree, |i| Some((self, from(i)))) }
    }

    /// Returns splats of any lists of no higher degree: place i gets what `of(i)` names, a list and a place there;
    /// without that no Gaussian.
    pub(crate) fn gathered<'a>(
        count: usize,
        degree: u32,
        of: impl Fn(usize) -> Option<(&'a Self, usize)> + Sync,
    ) -> Self {
        let copy = |i: usize, to: &mut [Vec3]| {
            let own = of(i).map_or(&[][..], |(own, at)| own.harmonics_of(at));
            to[..own.len()].copy_from_slice(own);
        };
        let linear = parallel::map(count, |i| of(i).is_some_and(|(own, at)| own.is_linear(at)));
        Self {
            extents: parallel::map(count, |i| of(i).map_or(Vec3::ZERO, |(own, at)| own.extents[at])),
            rotations: parallel::map(count, |i| of(i).map_or(Quat::IDENTITY, |(own, at)| own.rotations[at])),
            bases: parallel::map(count, |i| of(i).map_or(Vec3::ZERO, |(own, at)| own.bases[at])),
            coding: if linear.contains(&true) { ColorCoding::Each(linear) } else { ColorCoding::Display },
            degree,
            harmonics: parallel::runs(count, coefficients(degree), copy),
        }
    }

    /// Gives each of some places what stood at another one.
    #[doc(hidden)]
    pub fn trade(&mut self, places: &[u32], from: &[u32]) {
        let taken = self.picked(from.len(), |i| from[i] as usize);
        let count = self.coefficients();
        for (i, place) in places.iter().map(|place| *place as usize).enumerate() {
            self.extents[place] = taken.extents[i];
            self.rotations[place] = taken.rotations[i];
            self.bases[place] = taken.bases[i];
            if let ColorCoding::Each(linear) = &mut self.coding {
                linear[place] = taken.is_linear(i);
            }
            self.harmonics[place * count..(place + 1) * count].copy_from_slice(taken.harmonics_of(i));
        }
    }

    /// Puts others behind these; all get the higher degree of the two.
    pub fn append(&mut self, more: Self) {
        let degree = self.degree.max(more.degree);
        let more = more.with_degree(degree);
        self.coding = self.coding_with(&more);
        *self = std::mem::take(self).with_degree(degree);
        self.extents.extend(more.extents);
        self.rotations.extend(more.rotations);
        self.bases.extend(more.bases);
        self.harmonics.extend(more.harmonics);
    }

    /// The meaning of the colors of these and others behind them.
    fn coding_with(&self, more: &Self) -> ColorCoding {
        match (&self.coding, &more.coding) {
            (_, coding) if self.is_empty() => coding.clone(),
            (coding, other) if more.is_empty() || coding == other && !matches!(coding, ColorCoding::Each(_)) => {
                coding.clone()
            }
            _ => {
                let own = (0..self.len()).map(|i| self.is_linear(i));
                ColorCoding::Each(own.chain((0..more.len()).map(|i| more.is_linear(i))).collect())
            }
        }
    }

    /// Returns those of two lists that follow each other, of which either may have none.
    #[must_use]
    pub fn joined(first: (Option<Self>, usize), second: (Option<Self>, usize)) -> Option<Self> {
        if first.0.is_none() && second.0.is_none() {
            return None;
        }
        let filled = |(some, count): (Option<Self>, usize)| some.unwrap_or_else(|| Self::none(count));
        let mut all = filled(first);
        all.append(filled(second));
        Some(all)
    }

    /// Returns bounds on the display value of all splats from any direction, drawn with harmonics up to each degree:
    /// element d is that of degree d. Of degrees that they don't have it is that of their own; at least 0.
    pub fn brightest(&self) -> ByDegree {
        // A bound on each harmonic is its norm, √((2l + 1) / 4π) (addition theorem).
        let norm = |degree: u32| ((2 * degree + 1) as f32 / (4.0 * std::f32::consts::PI)).sqrt();
        let norms: Vec<f32> =
            (1..=self.degree).flat_map(|degree| vec![norm(degree); 2 * degree as usize + 1]).collect();
        let of_splat = |i: usize| {
            let display = |most: f32| if self.is_linear(i) { encode_srgb(most) } else { most };
            let (mut most, mut sum, mut next) = (ByDegree::default(), self.bases[i], 0);
            for (degree, most) in most.iter_mut().enumerate() {
                let end = coefficients(degree as u32).min(norms.len());
                let added = self.harmonics_of(i)[next..end].iter().zip(&norms[next..end]);
                sum = added.fold(sum, |sum, (color, norm)| sum + *norm * color.abs());
                next = end;
                *most = display(sum.max_element().max(0.0));
            }
            most
        };
        let larger = |a: ByDegree, b: ByDegree| std::array::from_fn(|degree| a[degree].max(b[degree]));
        (0..self.len()).into_par_iter().with_min_len(1 << 10).map(of_splat).reduce(ByDegree::default, larger)
    }

    /// Returns the number of bytes of each splat in these columns.
    pub fn bytes_each(degree: u32) -> u64 {
        (size_of::<Quat>() + (2 + coefficients(degree)) * size_of::<Vec3>()) as u64
    }

    /// Returns all numbers of a splat, for comparisons of content.
    pub fn bits(&self, index: usize) -> impl Iterator<Item = u32> + '_ {
        let extents = self.extents[index].to_array().into_iter();
        let rest = self.rotations[index].to_array().into_iter().chain(self.bases[index].to_array());
        let harmonics = self.harmonics_of(index).iter().flat_map(|color| color.to_array());
        extents.chain(rest).chain(harmonics).map(f32::to_bits).chain([self.is_linear(index).into()])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn some(count: usize, degree: u32) -> Gaussians {
        let each = |i: usize| Vec3::splat(1.0 + i as f32);
        Gaussians {
            extents: (0..count).map(each).collect(),
            rotations: vec![Quat::IDENTITY; count],
            bases: (0..count).map(each).collect(),
            coding: ColorCoding::Display,
            degree,
            harmonics: (0..count * coefficients(degree)).map(each).collect(),
        }
    }

    #[test]
    fn degrees_keep_the_coefficients_that_they_have() {
        assert_eq!([0, 1, 2, 3, 4].map(coefficients), [0, 3, 8, 15, 24]);
        let two = some(2, 2);
        let one = two.clone().with_degree(1);
        assert_eq!(one.harmonics_of(1), &two.harmonics_of(1)[..3]);
        let three = one.with_degree(3);
        assert_eq!(three.harmonics_of(1)[..3], two.harmonics_of(1)[..3]);
        assert!(three.harmonics_of(1)[3..].iter().all(|c| *c == Vec3::ZERO));
    }

    #[test]
    fn brightness_grows_with_the_degree_that_is_drawn() {
        let mut all = some(1, 2);
        all.harmonics.fill(Vec3::ZERO);
        (all.harmonics[0], all.harmonics[7]) = (Vec3::new(-1.0, 0.0, 0.0), Vec3::new(1.0, 0.0, 0.0));
        let norm = |degree: f32| ((2.0 * degree + 1.0) / (4.0 * std::f32::consts::PI)).sqrt();
        let [zero, one, two] = [1.0, 1.0 + norm(1.0), 1.0 + norm(1.0) + norm(2.0)];
        assert_eq!(all.brightest(), [zero, one, two, two, two]);
        all.bases[0] = Vec3::splat(-9.0);
        assert_eq!(all.brightest(), ByDegree::default());
        assert_eq!(Gaussians::default().brightest(), ByDegree::default());
    }

    #[test]
    fn linear_and_display_colors_stay_what_they_are() {
        let all_linear = |count| Gaussians { coding: ColorCoding::Linear, ..some(count, 0) };
        let linear = |all: &Gaussians| (0..all.len()).map(|i| all.is_linear(i)).collect::<Vec<_>>();
        let mut all = some(1, 0);
        all.append(all_linear(2));
        assert_eq!((linear(&all), linear(&all.picked(2, |i| 2 - i))), (vec![false, true, true], vec![true; 2]));
        all.trade(&[0, 1], &[1, 0]);
        assert_eq!(linear(&all), [true, false, true]);
        let mut none = Gaussians::none(0);
        none.append(all_linear(2));
        none.append(all_linear(1));
        none.append(some(0, 0));
        assert_eq!((none.coding.clone(), none.picked(0, |i| i).coding), (ColorCoding::Linear, ColorCoding::Linear));
        let gathered = Gaussians::gathered(2, 0, |i| (i == 1).then_some((&none, 0)));
        assert_eq!(linear(&gathered), [false, true]);
        assert_eq!(Gaussians::gathered(1, 0, |_| None).coding, ColorCoding::Display);
        // ½ is 0.735 as display value, and as one it is 0.214.
        let half = |coding| Gaussians { bases: vec![Vec3::splat(0.5)], coding, ..some(1, 0) };
        let [linear, display] = [half(ColorCoding::Linear), half(ColorCoding::Display)];
        assert!((linear.brightest()[0] - 0.735_357).abs() < 1e-6 && display.brightest()[0] == 0.5);
        assert!(linear.linear_base(0) == Vec3::splat(0.5) && (display.linear_base(0).x - 0.214_041).abs() < 1e-6);
        assert!(!linear.bits(0).eq(display.bits(0)));
    }

    #[test]
    fn lists_of_different_degrees_are_joined() {
        let all = Gaussians::joined((Some(some(2, 1)), 2), (None, 1)).unwrap();
        assert_eq!((all.len(), all.harmonics.len(), all.is_one(1), all.is_one(2)), (3, 9, true, false));
        let all = Gaussians::joined((Some(some(1, 0)), 1), (Some(some(1, 1)), 1)).unwrap();
        assert_eq!(all.harmonics, [vec![Vec3::ZERO; 3], some(1, 1).harmonics].concat());
        assert!(Gaussians::joined((None, 3), (None, 4)).is_none());
        let turned = some(3, 1).picked(2, |i| 2 - i);
        assert_eq!((turned.extents[0], turned.harmonics_of(1)), (Vec3::splat(3.0), some(3, 1).harmonics_of(1)));
    }
}
