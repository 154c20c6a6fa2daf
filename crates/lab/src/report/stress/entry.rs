//! Methods that a sweep compares, and the errors that are expected of them.

use std::f64::consts::LN_2;

use serde::{Serialize, Serializer};

use super::Deviation;
use crate::report::unique;
use pellucid_scene::{Density, Discs, Family, LongLists, Method, Soft, SoftMethod};

/// A method with settings, as a line of the figures.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Entry {
    /// The method's name, and behind it the settings that are not its defaults.
    pub name: &'static str,
    /// The method.
    pub method: Method,
}

/// Half a unit in the last place, relative: the largest error of a rounding to float32.
const HALF_ULP: f64 = f32::EPSILON as f64 / 2.0;
/// Relative error of the integral of a soft sphere's density (shaders/shared/absorb.wgsl); its effect on an opacity is
/// at most x·exp(−x) ≤ 1/e.
const INTEGRAL: f64 = 1e-5 / std::f64::consts::E;
/// Relative error of a ray's distance from a center: position on the screen, world units per pixel, cross product and
/// root, each of which Vulkan allows up to 3 units in the last place.
const DISTANCE: f64 = 24.0 * HALF_ULP;
/// Least weight 1 − d/r of a sphere in these scenes: √2/1.5 of the radius away from the center, in the corners of
/// `stack`.
const LEAST_WEIGHT: f64 = 0.057;

impl Entry {
    /// Every method that blends discs or soft spheres, and `abuffer` with lists that are sorted in place; first those
    /// that all draw the same.
    pub fn all() -> Vec<Self> {
        let named = |method: Method| Self { name: method.name(), method };
        let same = Method::transparent();
        let others = Family::Discs.methods().chain(Family::Soft.methods());
        let others = others.filter(|method| !same.iter().any(|known| known.name() == method.name()));
        let mut all: Vec<Self> = same.iter().copied().chain(others).map(named).collect();
        let in_place = Discs { long_lists: LongLists::InPlace, ..Discs::default() };
        all.insert(1, Self { name: "abuffer long_lists=in-place", method: Method::ABuffer(in_place) });
        all
    }

    /// The names of their methods.
    pub fn methods() -> Vec<&'static str> {
        unique(Self::all().iter().map(|entry| entry.method.name()))
    }

    /// Entries of the methods with these names; all of them for no name.
    pub fn of_methods<S: AsRef<str>>(names: &[S]) -> Vec<Self> {
        let asked = |entry: &Self| names.is_empty() || names.iter().any(|name| name.as_ref() == entry.method.name());
        Self::all().into_iter().filter(asked).collect()
    }

    /// True if it draws soft spheres and not discs.
    pub(super) fn is_soft(&self) -> bool {
        self.method.as_soft().is_some()
    }

    /// The method for layers of an opacity. Discs have it from the scene, soft spheres as their softness.
    pub(super) fn for_layers(&self, opacity: f64) -> Method {
        match self.method.as_soft() {
            Some(soft) => softened(soft, opacity).into(),
            None => self.method,
        }
    }

    /// The method that is exact for what this one draws, for layers of an opacity.
    pub(super) fn exact(&self, opacity: f64) -> Method {
        if self.is_soft() {
            return softened(SoftMethod::Base(Soft::default()), opacity).into();
        }
        Method::ABuffer(Discs::default())
    }

    /// The error that is expected with so many layers.
    pub(super) fn expected(&self, layers: u32) -> Expected {
        // A layer takes two products and two sums of numbers that are at most 1, and so does a run of 256 layers.
        let roundings = 4.0 * f64::from(layers + layers.div_ceil(256)) * HALF_ULP;
        let is_exact = self.method.is_exact(false);
        if self.method.is_sampled() {
            Expected::Noise(roundings)
        } else if is_exact && self.is_soft() {
            // All layers together have an optical depth of at most ln 2, and depend on the distance by at most twice
            // that, relative (Eq. 5, by d, over r). Colors are means by the weights. A sphere has two segments.
            Expected::Exact(INTEGRAL + 2.0 * LN_2 * DISTANCE + DISTANCE / LEAST_WEIGHT + 2.0 * roundings)
        } else if is_exact {
            Expected::Exact(roundings)
        } else {
            Expected::Stated
        }
    }
}

fn softened(method: SoftMethod, opacity: f64) -> SoftMethod {
    method.changed(|soft| soft.density = Density::Softness(opacity as f32))
}

/// Size of an error as far as it is known before it is measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Expected {
    /// The largest error that follows from roundings.
    Exact(f64),
    /// Noise of the size that the method states, beside roundings of this size.
    Noise(f64),
    /// Nothing: an approximation.
    Stated,
}

impl Expected {
    /// True if an error is as expected; `None` where nothing is.
    pub(super) fn holds(&self, error: &Deviation) -> Option<bool> {
        match self {
            // NaN is not.
            Self::Exact(bound) => Some(error.max <= *bound),
            Self::Noise(_) => Some(error.standard_errors.is_some_and(|found| found <= most(error.pixels))),
            Self::Stated => None,
        }
    }

    /// Roundings beside noise.
    pub(super) fn roundings(&self) -> f64 {
        if let Self::Noise(roundings) = self { *roundings } else { 0.0 }
    }

    /// The kind of error, in a word.
    pub fn word(&self) -> &'static str {
        match self {
            Self::Exact(_) => "exact",
            Self::Noise(_) => "stochastic",
            Self::Stated => "approximate",
        }
    }
}

impl Serialize for Expected {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.word().serialize(serializer)
    }
}

/// The largest ratio of error and standard error that noise explains. That of N pixels deviates from 1 by 1/√(2N) or a
/// little more, since a standard error comes from 16 strata and R, G and B of a pixel are not independent; allowed is
/// eight times that.
fn most(pixels: usize) -> f64 {
    1.0 + 6.0 / (pixels as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn named(name: &str) -> Entry {
        Entry::all().into_iter().find(|entry| entry.name == name).expect("an entry")
    }

    fn error(max: f64, standard_errors: Option<f64>) -> Deviation {
        Deviation { max, rmse: max, pixels: 256, standard_errors }
    }

    #[test]
    fn every_transparent_method_is_compared_and_in_place_beside_abuffer() {
        let names: Vec<_> = Entry::all().iter().map(|entry| entry.name).collect();
        assert_eq!(names[..3], ["abuffer", "abuffer long_lists=in-place", "linked-list"]);
        for method in ["sorted", "peel", "stochastic", "hybrid", "mlab", "moments", "wavelet", "weighted", "soft-base"]
        {
            assert!(names.contains(&method), "{method}: {names:?}");
        }
        let alike = |method: &Method| matches!(method.family(), Family::Discs | Family::Soft);
        assert_eq!(names.len(), Method::all().iter().filter(|method| alike(method)).count() + 1);
        assert_eq!(Entry::methods().len(), names.len() - 1);
        assert_eq!(Entry::of_methods(&["abuffer", "soft-express"]).len(), 3);
        assert_eq!(Entry::of_methods::<&str>(&[]).len(), names.len());
    }

    #[test]
    fn an_error_beyond_what_is_expected_does_not_hold() {
        let exact = named("sorted").expected(99);
        assert_eq!(exact, Expected::Exact(400.0 * 2f64.powi(-24)));
        assert_eq!(exact.holds(&error(2e-5, None)), Some(true));
        assert_eq!(exact.holds(&error(3e-5, None)), Some(false));
        assert_eq!(exact.holds(&error(f64::NAN, None)), Some(false));
        let noise = named("stochastic").expected(99);
        // 1 + 6/16.
        assert_eq!(noise.holds(&error(0.1, Some(1.37))), Some(true));
        assert_eq!(noise.holds(&error(0.1, Some(1.38))), Some(false));
        assert_eq!(noise.holds(&error(0.0, None)), Some(false), "without standard errors nothing is shown");
        assert_eq!(named("mlab").expected(99).holds(&error(1.0, None)), None);
        let soft = named("soft-base").expected(1);
        assert_eq!(soft.holds(&error(1e-5, None)), Some(true));
        assert_eq!(soft.holds(&error(1e-4, None)), Some(false));
        assert_eq!(named("soft-express").expected(1), Expected::Stated);
    }

    #[test]
    fn layers_of_soft_spheres_have_the_opacity_as_softness() {
        let softness = |method: Method| method.as_soft().map(|soft| soft.settings().density);
        let shells = named("soft-concentric");
        assert_eq!(softness(shells.for_layers(0.25)), Some(Density::Softness(0.25)));
        assert_eq!(softness(shells.exact(0.25)), Some(Density::Softness(0.25)));
        assert_eq!(shells.exact(0.25).name(), "soft-base");
        assert_eq!(named("weighted").exact(0.25).name(), "abuffer");
    }
}
