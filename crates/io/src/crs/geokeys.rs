//! GeoTIFF keys in the records of LAS files (OGC GeoTIFF 1.1, LAS 1.4, 2.4).

use std::ops::RangeInclusive;

use pellucid_core::cloud::crs::{Crs, Unit};

use super::{epsg, or_of_code};
use crate::number::{NumberType, short};

/// Identifier of the record of keys.
pub(crate) const RECORD_KEYS: u16 = 34735;
/// Identifier of the record of float64 numbers.
pub(crate) const RECORD_NUMBERS: u16 = 34736;
/// Identifier of the record of text.
pub(crate) const RECORD_TEXT: u16 = 34737;

/// Codes that are those of EPSG; others say that other keys define the value, or are private.
const CODES: RangeInclusive<u16> = 1024..=32766;

/// Value of a unit that another key defines.
const USER_DEFINED: u16 = 32767;

const MODEL_TYPE: u16 = 1024;
const CITATION: u16 = 1026;
const GEODETIC_CRS: u16 = 2048;
const GEODETIC_CITATION: u16 = 2049;
const ANGULAR_UNITS: u16 = 2054;
const ANGULAR_UNIT_SIZE: u16 = 2055;
const PROJECTED_CRS: u16 = 3072;
const PROJECTED_CITATION: u16 = 3073;
const LINEAR_UNITS: u16 = 3076;
const LINEAR_UNIT_SIZE: u16 = 3077;
const VERTICAL_CRS: u16 = 4096;
const VERTICAL_UNITS: u16 = 4099;

/// Kind of a system: value of [`MODEL_TYPE`].
const GEOGRAPHIC: u16 = 2;

/// The three records, empty where a file has none.
#[derive(Debug, Default)]
pub(crate) struct GeoRecords {
    /// Shorts: a header of four, and four for each key.
    pub keys: Vec<u8>,
    /// Float64 numbers.
    pub numbers: Vec<u8>,
    /// Texts, each up to a `|`.
    pub text: Vec<u8>,
}

impl GeoRecords {
    /// Returns the system that the keys describe.
    pub fn crs(&self) -> Option<Crs> {
        let projected = self.code(PROJECTED_CRS);
        let geodetic = self.code(GEODETIC_CRS);
        let is_geographic = match self.short(MODEL_TYPE) {
            Some(model) => model == GEOGRAPHIC,
            None => projected.is_none() && geodetic.is_some(),
        };
        let named = if is_geographic { [GEODETIC_CITATION, CITATION] } else { [PROJECTED_CITATION, CITATION] };
        let name = named.into_iter().find_map(|key| self.text(key)).unwrap_or_default();
        let epsg = if is_geographic { geodetic } else { projected.or(geodetic) };
        let unit =
            if is_geographic { Some(self.angle().unwrap_or_else(Unit::degree)) } else { self.length(LINEAR_UNITS) };
        let height = self.code(VERTICAL_CRS).and_then(epsg::height_unit);
        let crs = Crs {
            unit: or_of_code(unit, epsg),
            vertical_unit: self.length(VERTICAL_UNITS).or(height),
            name,
            epsg,
            wkt: None,
        };
        let crs = crs.checked();
        (crs.epsg.is_some() || crs.unit.is_some() || !crs.name.is_empty()).then_some(crs)
    }

    /// The entry of a key: place, count, and value or offset.
    fn entry(&self, key: u16) -> Option<[u16; 3]> {
        let entries = self.keys.chunks_exact(8);
        // The header counts the entries; those beyond are padding.
        let count = entries.clone().next().map(|header| short(header, 6))?;
        let entry = entries.skip(1).take(count.into()).find(|entry| short(entry, 0) == key)?;
        Some([short(entry, 2), short(entry, 4), short(entry, 6)])
    }

    /// The value of a key that is stored with it.
    fn short(&self, key: u16) -> Option<u16> {
        self.entry(key).filter(|[place, ..]| *place == 0).map(|[.., value]| value)
    }

    /// The EPSG code that a key has.
    fn code(&self, key: u16) -> Option<u32> {
        self.short(key).filter(|code| CODES.contains(code)).map(u32::from)
    }

    fn number(&self, key: u16) -> Option<f64> {
        let [.., at] = self.entry(key).filter(|[place, ..]| *place == RECORD_NUMBERS)?;
        self.numbers.chunks_exact(8).nth(at.into()).map(|bytes| NumberType::Double.read(bytes))
    }

    fn text(&self, key: u16) -> Option<String> {
        let [_, count, at] = self.entry(key).filter(|[place, ..]| *place == RECORD_TEXT)?;
        let bytes = self.text.get(usize::from(at)..usize::from(at) + usize::from(count))?;
        let text = String::from_utf8_lossy(bytes);
        let text = text.trim_end_matches(['|', '\0', ' ']).trim();
        (!text.is_empty()).then(|| text.to_owned())
    }

    /// The unit of length of a key: by its code, or by its size in meters where the user defines it.
    fn length(&self, key: u16) -> Option<Unit> {
        let code = self.short(key)?;
        match code {
            USER_DEFINED => Unit::length("user-defined unit", self.number(LINEAR_UNIT_SIZE)?),
            code => epsg::of_unit_code(code.into()),
        }
    }

    fn angle(&self) -> Option<Unit> {
        match self.short(ANGULAR_UNITS)? {
            USER_DEFINED => Unit::angle("user-defined angle", self.number(ANGULAR_UNIT_SIZE)?),
            code => epsg::of_angle_code(code.into()),
        }
    }
}
