//! The coordinate reference system of a cloud, as far as its file states it: name, EPSG code and units.

use std::f64::consts::PI;

use glam::DVec3;
use serde::{Deserialize, Serialize};

/// Characters of a name at most.
const MAX_NAME: usize = 100;

/// Share of its size by which a unit may be off: the two feet differ by 2·10⁻⁶.
const ROUNDING: f64 = 1e-7;

/// Cosine of an angle below which a direction has no part along another one.
const LEVEL: f64 = 1e-9;

/// Units with a symbol: name, symbol, size in meters.
const KNOWN: [(&str, &str, f64); 6] = [
    ("metre", "m", 1.0),
    ("foot", "ft", 0.3048),
    ("US survey foot", "US survey ft", 1200.0 / 3937.0),
    ("kilometre", "km", 1000.0),
    ("centimetre", "cm", 0.01),
    ("millimetre", "mm", 0.001),
];

/// Name of the angle that is most used.
const DEGREE: &str = "degree";

/// A coordinate reference system.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct Crs {
    /// The name; empty where the file has none.
    pub name: String,
    /// EPSG code, of a compound system that of its horizontal part.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub epsg: Option<u32>,
    /// The whole description as well-known text, if the file has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wkt: Option<String>,
    /// Unit of horizontal coordinates, if it is known; of a geocentric system that of all.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unit: Option<Unit>,
    /// Unit of heights, if it is stated by itself.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub vertical_unit: Option<Unit>,
}

impl Crs {
    /// Returns the unit of heights: the stated one, else that of horizontal lengths.
    pub fn height_unit(&self) -> Option<&Unit> {
        self.vertical_unit.as_ref().or_else(|| self.unit.as_ref().filter(|unit| unit.meters.is_some()))
    }

    /// Returns the unit of lengths along a direction; `None` where it is not known, and between two units. Z is the
    /// vertical.
    pub fn unit_along(&self, direction: DVec3) -> Option<&Unit> {
        let (unit, height) = (self.unit.as_ref(), self.height_unit());
        let is_level = direction.z.abs() <= LEVEL * direction.length();
        let is_upright = direction.truncate().length() <= LEVEL * direction.length();
        match (unit, height) {
            _ if is_level => unit,
            _ if is_upright => height,
            (Some(unit), Some(height)) => unit.is_same(height).then_some(unit),
            _ => None,
        }
    }

    /// Returns it with clean names and without units that are none, as what others wrote may have them.
    #[must_use]
    pub fn checked(self) -> Self {
        let checked = |unit: Unit| unit.checked();
        Self {
            name: plain(&self.name),
            unit: self.unit.and_then(checked),
            vertical_unit: self.vertical_unit.and_then(checked),
            ..self
        }
    }

    /// Returns the name and the EPSG code, as far as there are any.
    pub fn title(&self) -> String {
        match (self.name.as_str(), self.epsg) {
            ("", Some(code)) => format!("EPSG:{code}"),
            ("", None) => "unnamed".to_owned(),
            (name, Some(code)) => format!("{name} (EPSG:{code})"),
            (name, None) => name.to_owned(),
        }
    }
}

/// A unit of coordinates.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Unit {
    /// The name, as in the EPSG registry where the size is known there.
    pub name: String,
    /// Size in meters, above 0; `None` of an angle.
    pub meters: Option<f64>,
}

impl Unit {
    /// Returns the unit of a size in meters; `None` for a size that is none. The name counts only where the size is
    /// not that of a known unit.
    pub fn length(name: &str, meters: f64) -> Option<Self> {
        if !(meters.is_finite() && meters > 0.0) {
            return None;
        }
        let known = KNOWN.iter().find(|(.., size)| (meters - size).abs() <= ROUNDING * size);
        Some(match known {
            Some((name, _, size)) => Self { name: (*name).to_owned(), meters: Some(*size) },
            None => Self { name: named(name), meters: Some(meters) },
        })
    }

    /// Returns the unit of angles of a size in radians; `None` for a size that is none.
    pub fn angle(name: &str, radians: f64) -> Option<Self> {
        if !(radians.is_finite() && radians > 0.0) {
            return None;
        }
        let is_degree = (radians - PI / 180.0).abs() <= ROUNDING * PI / 180.0;
        Some(if is_degree { Self::degree() } else { Self { name: named(name), meters: None } })
    }

    /// Returns the meter.
    pub fn metre() -> Self {
        let (name, _, size) = KNOWN[0];
        Self { name: name.to_owned(), meters: Some(size) }
    }

    /// Returns the degree.
    pub fn degree() -> Self {
        Self { name: DEGREE.to_owned(), meters: None }
    }

    /// Returns `true` for units of one size, up to rounding.
    pub fn is_same(&self, other: &Self) -> bool {
        match (self.meters, other.meters) {
            (Some(a), Some(b)) => (a - b).abs() <= ROUNDING * a.max(b),
            (None, None) => self.name == other.name,
            _ => false,
        }
    }

    /// Returns the unit in which lengths are after they were multiplied by a factor above 0; `None` if it has no name.
    pub fn scaled(&self, factor: f64) -> Option<Self> {
        if factor == 1.0 {
            return Some(self.clone());
        }
        Self::length("", self.meters? / factor).filter(|unit| unit.symbol() != unit.name)
    }

    /// Returns the symbol, or the name of a unit without one.
    pub fn symbol(&self) -> &str {
        let known = KNOWN.iter().find(|(name, ..)| *name == self.name);
        known.map_or(if self.name == DEGREE { "°" } else { &self.name }, |(_, symbol, _)| symbol)
    }

    /// Returns a number with the symbol.
    pub fn with(&self, number: &str) -> String {
        let symbol = self.symbol();
        if self.name == DEGREE { format!("{number}{symbol}") } else { format!("{number} {symbol}") }
    }

    /// Returns the name and, of a length, its size.
    pub fn described(&self) -> String {
        match self.meters {
            Some(meters) => format!("{} ({meters} m)", self.name),
            None => self.name.clone(),
        }
    }

    fn checked(self) -> Option<Self> {
        match self.meters {
            Some(meters) => Self::length(&self.name, meters),
            None => Some(Self { name: named(&self.name), meters: None }),
        }
    }
}

/// A name for a unit.
fn named(name: &str) -> String {
    let name = plain(name);
    if name.is_empty() { "unnamed unit".to_owned() } else { name }
}

/// Returns a text as one short line without control characters.
fn plain(text: &str) -> String {
    let letters = text.chars().filter(|letter| !letter.is_control());
    letters.take(MAX_NAME).collect::<String>().trim().to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_known_by_their_size() {
        for (name, size, wanted) in [
            ("meter", 1.0, Some(("metre", "m"))),
            ("Foot_US", 0.304_800_609_601_219_24, Some(("US survey foot", "US survey ft"))),
            ("US survey foot", 0.304_800_609_6, Some(("US survey foot", "US survey ft"))),
            ("foot", 0.3048, Some(("foot", "ft"))),
            ("Clarke's foot", 0.304_797_265_4, Some(("Clarke's foot", "Clarke's foot"))),
            ("", 0.75, Some(("unnamed unit", "unnamed unit"))),
            ("a\u{1b}[31mb\n", 2.0, Some(("a[31mb", "a[31mb"))),
            ("metre", f64::NAN, None),
            ("metre", f64::INFINITY, None),
            ("metre", 0.0, None),
            ("metre", -1.0, None),
        ] {
            let unit = Unit::length(name, size);
            let found = unit.as_ref().map(|unit| (unit.name.as_str(), unit.symbol()));
            assert_eq!(found, wanted, "{name} {size}");
        }
        assert_eq!(Unit::angle("Degree", 0.017_453_292_519_943_295), Some(Unit::degree()));
        assert_eq!(Unit::angle("grad", 0.015_707_963_267_948_967).unwrap().name, "grad");
        assert_eq!((Unit::degree().with("2"), Unit::metre().with("5")), ("2°".into(), "5 m".into()));
    }

    #[test]
    fn lengths_that_were_multiplied_are_in_another_unit() {
        let foot = Unit::length("", 0.3048).unwrap();
        assert_eq!(foot.scaled(0.3048), Some(Unit::metre()));
        assert_eq!(Unit::metre().scaled(1000.0).unwrap().name, "millimetre");
        assert_eq!((foot.scaled(1.0), foot.scaled(2.0)), (Some(foot.clone()), None));
        assert_eq!(Unit::degree().scaled(2.0), None);
    }

    #[test]
    fn lengths_along_a_direction_have_one_unit_or_none() {
        let foot = Unit::length("", 0.3048);
        let crs = Crs { unit: foot.clone(), vertical_unit: Some(Unit::metre()), ..Crs::default() };
        assert_eq!(crs.unit_along(DVec3::NEG_Y), foot.as_ref());
        assert_eq!(crs.unit_along(5.0 * DVec3::Z), Some(&Unit::metre()));
        assert_eq!(crs.unit_along(DVec3::ONE), None);
        let one = Crs { vertical_unit: None, ..crs };
        assert!([DVec3::X, DVec3::Z, DVec3::ONE].iter().all(|direction| one.unit_along(*direction) == foot.as_ref()));
        let degrees = Crs { unit: Some(Unit::degree()), ..Crs::default() };
        assert_eq!((degrees.unit_along(DVec3::X), degrees.unit_along(DVec3::Z)), (Some(&Unit::degree()), None));
    }
}
