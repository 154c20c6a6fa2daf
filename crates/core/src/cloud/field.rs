//! The scalar field F of a cloud, which separates solid points from soft ones.

use std::borrow::Cow;

use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::{Bounds, CLASSIFICATION_NAMES, Cloud, INTENSITY_NAMES};

/// Values that differ by less than this share of the largest one differ only by rounding.
const LEAST_RANGE: f64 = 1e-9;

/// The definition of F.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum Field {
    /// The uncertainty of a point lying on a surface (Eq. 21), scaled to [0, 1].
    #[default]
    Uncertainty,
    /// 1 for some classes, 0 for the others.
    Classification {
        /// The soft classes.
        classes: Vec<u8>,
    },
    /// The intensity, as a property.
    Intensity,
    /// Distance from a line, scaled to [0, 1].
    DistanceToAxis {
        /// A point of the line, by default the center of the bounds.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        point: Option<[f64; 3]>,
        /// The line's direction, not zero, by default the file's vertical.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        direction: Option<[f64; 3]>,
    },
    /// A scalar property: as stored if every value lies in [0, 1], else scaled from the smallest to the largest; a
    /// constant property gives 0. +∞ counts as 1, −∞ as 0, and NaN as 0: solid.
    Property {
        /// Name of the scalar.
        name: String,
    },
}

/// A cloud lacks what its field is made of.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs, reason = "the messages say what the fields are")]
pub enum Error {
    /// No property of that name.
    #[error("no scalar property `{name}` for field{hint}")]
    NoProperty { name: String, hint: String },
    /// No classes.
    #[error("field = \"classification\" needs classes, but the file has none; {there}")]
    NoClasses { there: String },
    /// No intensity.
    #[error("field = \"intensity\", but the file has none; {there}")]
    NoIntensity { there: String },
}

impl Field {
    /// Returns its name in the setting `field`.
    pub fn name(&self) -> &str {
        match self {
            Self::Uncertainty => "uncertainty",
            Self::Classification { .. } => "classification",
            Self::Intensity => "intensity",
            Self::DistanceToAxis { .. } => "distance-to-axis",
            Self::Property { name } => name,
        }
    }

    /// Returns the same in a cloud's own coordinates p, where this one is in those of a scene, `scale`·p + `translate`.
    pub fn in_file_units(&self, scale: f64, translate: DVec3) -> Self {
        match self {
            Self::DistanceToAxis { point: Some(point), direction } => {
                let point = (DVec3::from(*point) - translate) / scale;
                Self::DistanceToAxis { point: Some(point.to_array()), direction: *direction }
            }
            other => other.clone(),
        }
    }

    /// F of each point; `None` for uncertainty, which needs neighbors.
    ///
    /// # Errors
    /// The cloud lacks the property.
    pub fn values(&self, cloud: &Cloud) -> Result<Option<Vec<f32>>, Error> {
        let values = self.unscaled(cloud, || cloud.bounds())?;
        Ok(values.map(|values| self.scaled(&values, range(values.iter().copied()))))
    }

    /// Returns the column that F is made of, for some points of a cloud with these bounds; `None` for uncertainty.
    ///
    /// # Errors
    /// The cloud lacks the property.
    #[doc(hidden)]
    pub fn unscaled(&self, cloud: &Cloud, bounds: impl FnOnce() -> Option<Bounds>) -> Result<Option<Vec<f64>>, Error> {
        match self {
            Self::Uncertainty => Ok(None),
            Self::Classification { classes } => match &cloud.classification {
                Some(codes) => Ok(Some(codes.iter().map(|code| f64::from(u8::from(classes.contains(code)))).collect())),
                None => Err(Error::NoClasses { there: there(cloud) }),
            },
            Self::Intensity => match &cloud.intensity {
                Some(values) => Ok(Some(doubles(values))),
                None => Err(Error::NoIntensity { there: there(cloud) }),
            },
            Self::DistanceToAxis { point, direction } => Ok(Some(to_axis(cloud, bounds, *point, *direction))),
            Self::Property { name } => match column(cloud, name) {
                Some(values) => Ok(Some(values)),
                None => {
                    let names = names(cloud);
                    let names = names.iter().map(|name| &**name);
                    let hint = crate::words::nearest(name, names, "the file has");
                    Err(Error::NoProperty { name: name.clone(), hint })
                }
            },
        }
    }

    /// F of what it is made of, given the [`range`] of the whole cloud.
    #[doc(hidden)]
    pub fn scaled(&self, values: &[f64], range: [f64; 2]) -> Vec<f32> {
        match self {
            Self::Uncertainty | Self::DistanceToAxis { .. } => scaled_in(values, range),
            Self::Classification { .. } => values.iter().map(|value| *value as f32).collect(),
            Self::Intensity | Self::Property { .. } => property(values, range),
        }
    }
}

/// Returns values from the smallest to the largest as 0 to 1, all 0 if they differ by no more than rounding.
pub fn scaled(values: &[f64]) -> Vec<f32> {
    scaled_in(values, range(values.iter().copied()))
}

/// Scales some values of a cloud with this range.
fn scaled_in(values: &[f64], [least, most]: [f64; 2]) -> Vec<f32> {
    let range = most - least;
    if range <= LEAST_RANGE * most.abs().max(least.abs()) {
        return vec![0.0; values.len()];
    }
    values.iter().map(|value| share((value - least) / range)).collect()
}

/// A value as F: clamped to the range; NaN is 0.
fn share(value: f64) -> f32 {
    if value.is_nan() { 0.0 } else { value.clamp(0.0, 1.0) as f32 }
}

/// Returns the smallest and the largest finite value; in reverse order if no value is finite.
#[doc(hidden)]
pub fn range(values: impl IntoIterator<Item = f64>) -> [f64; 2] {
    let finite = values.into_iter().filter(|value| value.is_finite());
    finite.fold([f64::INFINITY, f64::NEG_INFINITY], |[least, most], value| [least.min(value), most.max(value)])
}

fn property(values: &[f64], [least, most]: [f64; 2]) -> Vec<f32> {
    if least >= 0.0 && most <= 1.0 {
        values.iter().map(|value| share(*value)).collect()
    } else if least < most {
        scaled_in(values, [least, most])
    } else {
        // Constant, or nothing is finite.
        values.iter().map(|value| if *value == f64::INFINITY { 1.0 } else { 0.0 }).collect()
    }
}

fn to_axis(
    cloud: &Cloud,
    bounds: impl FnOnce() -> Option<Bounds>,
    point: Option<[f64; 3]>,
    direction: Option<[f64; 3]>,
) -> Vec<f64> {
    let center = || bounds().map_or(DVec3::ZERO, |bounds| bounds.center());
    let point = point.map_or_else(center, DVec3::from);
    let vertical = cloud.up.direction();
    let direction = direction.map_or(vertical, DVec3::from).normalize_or(vertical);
    cloud.positions.iter().map(|p| (p - point).cross(direction).length()).collect()
}

fn doubles(values: &[f32]) -> Vec<f64> {
    values.iter().map(|value| (*value).into()).collect()
}

/// Returns the values of a property by its name in the file; white space in it may be written as `_`, as PLY files have
/// it.
#[doc(hidden)]
pub fn column(cloud: &Cloud, name: &str) -> Option<Vec<f64>> {
    let find = |same: &dyn Fn(&str) -> bool| cloud.scalars.iter().find(|(name, _)| same(name));
    let found = find(&|other| other == name).or_else(|| find(&|other| without_blanks(other) == without_blanks(name)));
    if let Some((_, values)) = found {
        return Some(doubles(values));
    }
    let lower = name.to_lowercase();
    let coordinate = |axis: usize| Some(cloud.positions.iter().map(|p| p[axis]).collect());
    match lower.as_str() {
        "x" => coordinate(0),
        "y" => coordinate(1),
        "z" => coordinate(2),
        "radius" => cloud.own_radii().map(doubles),
        lower if CLASSIFICATION_NAMES.contains(&lower) => {
            cloud.classification.as_ref().map(|codes| codes.iter().map(|code| (*code).into()).collect())
        }
        lower if INTENSITY_NAMES.contains(&lower) => cloud.intensity.as_deref().map(doubles),
        _ => None,
    }
}

/// Returns a name as a PLY file has it.
pub fn without_blanks(name: &str) -> String {
    name.split_whitespace().collect::<Vec<_>>().join("_")
}

/// Returns the names that `field` accepts for a cloud.
pub fn names(cloud: &Cloud) -> Vec<Cow<'_, str>> {
    let usual = [
        ("classification", cloud.classification.is_some()),
        ("intensity", cloud.intensity.is_some()),
        ("radius", cloud.own_radii().is_some()),
    ];
    let usual = usual.into_iter().filter(|(_, there)| *there).map(|(name, _)| Cow::from(name));
    let scalars = cloud.scalars.iter().map(|(name, _)| Cow::from(name));
    usual.chain(scalars).chain(["x", "y", "z"].map(Cow::from)).collect()
}

/// Returns the properties of a cloud, as a phrase.
#[doc(hidden)]
pub fn there(cloud: &Cloud) -> String {
    format!("it has {}", names(cloud).join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn property(values: &[f64]) -> Vec<f32> {
        super::property(values, range(values.iter().copied()))
    }

    #[test]
    fn properties_within_0_and_1_stay_as_they_are() {
        assert_eq!(property(&[0.25, 0.5]), [0.25, 0.5]);
        assert_eq!(property(&[0.7; 3]), [0.7; 3]);
        assert_eq!(property(&[-0.0, 1.0]), [0.0, 1.0]);
    }

    #[test]
    fn others_are_scaled_and_constant_ones_are_0() {
        assert_eq!(property(&[-1.0, 0.0, 3.0]), [0.0, 0.25, 1.0]);
        assert_eq!(property(&[7.0; 3]), [0.0; 3]);
        assert_eq!(property(&[]), [0.0; 0]);
    }

    #[test]
    fn values_that_are_not_finite_scale_to_an_end() {
        let (nan, inf) = (f64::NAN, f64::INFINITY);
        assert_eq!(property(&[1.0, 3.0, nan, inf, -inf]), [0.0, 1.0, 0.0, 1.0, 0.0]);
        assert_eq!(property(&[0.5, nan, inf, -inf]), [0.5, 0.0, 1.0, 0.0]);
        assert_eq!(property(&[5.0, nan, inf, -inf]), [0.0, 0.0, 1.0, 0.0]);
        assert_eq!(property(&[nan, inf]), [0.0, 1.0]);
    }
}
