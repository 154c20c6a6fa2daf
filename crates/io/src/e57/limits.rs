//! Limits of the colors and intensities of scans, and what becomes of values without limits or outside of them.
//!
//! Many writers leave limits empty, or fill them in wrongly: the values decide whether limits hold.

use std::ops::Range;

use ::e57::{RecordDataType, RecordValue};
use glam::Vec3;

use crate::channel::{full_integer, full_scale};
use pellucid_core::color::FULL_INTEGERS;

/// Limits of a type above this are those of float32 and say nothing.
const ANY_FLOAT: f64 = 1e30;

/// The least and the largest value of a field.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Limits {
    pub min: f64,
    pub max: f64,
}

impl Limits {
    /// Limits of no values.
    const NONE: Self = Self { min: f64::INFINITY, max: f64::NEG_INFINITY };

    /// Returns the limits that a scan gives for a field, else those of its type; `None` where neither says anything.
    pub fn new(given: Option<(&RecordValue, &RecordValue)>, kind: &RecordDataType) -> Option<Self> {
        // A limit may be of another type than the values: a scaled one is one only if the values are.
        let value = |value: &RecordValue| value.to_f64(kind).ok();
        let given = given.and_then(|(min, max)| Some(Self { min: value(min)?, max: value(max)? }));
        given.filter(|limits| limits.say_something()).or_else(|| {
            let (min, max) = match *kind {
                RecordDataType::Single { min, max } => (min?.into(), max?.into()),
                RecordDataType::Double { min, max } => (min?, max?),
                RecordDataType::Integer { min, max } => (min as f64, max as f64),
                RecordDataType::ScaledInteger { min, max, scale, offset } => {
                    (min as f64 * scale + offset, max as f64 * scale + offset)
                }
            };
            Some(Self { min, max }).filter(Self::say_something)
        })
    }

    fn say_something(&self) -> bool {
        self.min < self.max && self.max - self.min < ANY_FLOAT
    }

    /// Returns those of some values.
    fn of(values: impl Iterator<Item = f32>) -> Self {
        let finite = values.filter(|value| value.is_finite()).map(f64::from);
        finite.fold(Self::NONE, |Self { min, max }, value| Self { min: min.min(value), max: max.max(value) })
    }

    fn and(self, more: Self) -> Self {
        Self { min: self.min.min(more.min), max: self.max.max(more.max) }
    }

    /// Returns `true` if values with these limits are within, but for the rounding to float32.
    fn hold(&self, seen: &Self) -> bool {
        let rounding = f64::from(f32::EPSILON) * self.min.abs().max(self.max.abs());
        self.min - rounding <= seen.min && seen.max <= self.max + rounding
    }

    /// Returns a value in [0, 1].
    fn scale(&self, value: f32) -> f32 {
        (((f64::from(value) - self.min) / (self.max - self.min)) as f32).clamp(0.0, 1.0)
    }
}

/// The points of a scan, and the limits of its colors and intensities, if it has them.
pub(super) struct ScanLimits {
    pub points: Range<usize>,
    pub color: Option<[Option<Limits>; 3]>,
    pub intensity: Option<Option<Limits>>,
}

/// Scales intensities to [0, 1] if all scans have limits that hold; otherwise they stay as they are. Limits that are
/// each scan's own extremes would make the scans unlike each other, so they hold together. A point without a number
/// has the intensity 0.
pub(super) fn scale_intensities(values: &mut [f32], scans: &[ScanLimits]) {
    let given = scans.iter().filter_map(|scan| {
        let limits = scan.intensity?;
        Some((scan.points.clone(), limits, Limits::of(values[scan.points.clone()].iter().copied())))
    });
    let given: Vec<_> = given.collect();
    if let Some(limits) = limits_that_hold(&given) {
        for ((points, ..), limits) in given.iter().zip(limits) {
            values[points.clone()].iter_mut().for_each(|value| *value = limits.scale(*value));
        }
    }
    values.iter_mut().filter(|value| value.is_nan()).for_each(|value| *value = 0.0);
}

/// The limits of each scan that has them; `None` if some don't hold.
fn limits_that_hold(given: &[(Range<usize>, Option<Limits>, Limits)]) -> Option<Vec<Limits>> {
    let limits = given.iter().map(|(_, limits, seen)| limits.filter(|limits| limits.hold(seen)));
    let limits = limits.collect::<Option<Vec<_>>>()?;
    let are_extremes = |((.., seen), limits): (&(_, _, Limits), &Limits)| seen.hold(limits);
    let all = limits.iter().copied().fold(Limits::NONE, Limits::and);
    let are_own = given.iter().zip(&limits).all(are_extremes);
    Some(if are_own { vec![all; limits.len()] } else { limits })
}

/// Scales colors to [0, 1]: by limits that hold, else as those of a file without limits. A field of more than 8 bits
/// may hold colors of fewer.
pub(super) fn scale_colors(colors: &mut [Vec3], scans: &[ScanLimits]) {
    let seen = |points: &Range<usize>, i: usize| Limits::of(colors[points.clone()].iter().map(|color| color[i]));
    let given = scans.iter().filter_map(|scan| Some((&scan.points, scan.color?)));
    let given: Vec<_> = given.map(|(points, limits)| (points, limits, [0, 1, 2].map(|i| seen(points, i)))).collect();
    let largest = given.iter().flat_map(|(.., seen)| seen).map(|seen| seen.max as f32).fold(0.0, f32::max);
    for (points, limits, seen) in given {
        let held = [0, 1, 2].map(|i| limits[i].filter(|limits| limits.hold(&seen[i])));
        let up_to = |full: f32| Limits { min: 0.0, max: full.into() };
        let is_wide =
            |limits: &Limits| limits.min == 0.0 && FULL_INTEGERS[1..].iter().any(|full| f64::from(*full) == limits.max);
        let by = match held {
            [Some(red), Some(green), Some(blue)] => [red, green, blue]
                .map(|limits| if is_wide(&limits) { up_to(full_integer(largest).into()) } else { limits }),
            _ => [up_to(full_scale(Some(largest)).unwrap_or(1.0)); 3],
        };
        for color in &mut colors[points.clone()] {
            *color = Vec3::from([0, 1, 2].map(|i| by[i].scale(color[i])));
        }
    }
}
