//! Coordinate reference systems as files state them: well-known text, GeoTIFF keys, EPSG codes. What can't be read is
//! no system, and no error.

mod epsg;
mod geokeys;
mod tree;
mod wkt;

use pellucid_core::cloud::crs::{Crs, Unit};

pub(crate) use geokeys::{GeoRecords, RECORD_KEYS, RECORD_NUMBERS, RECORD_TEXT};

/// Returns the system that a text describes: well-known text of either version, or codes as in `EPSG:32633`,
/// `EPSG:32633+5703` and `urn:ogc:def:crs:EPSG::32633`.
pub(crate) fn parse(text: &str) -> Option<Crs> {
    let text = text.trim_matches(|letter: char| letter.is_whitespace() || letter == '\0');
    of_name(text).or_else(|| wkt::parse(text)).map(Crs::checked)
}

fn of_name(text: &str) -> Option<Crs> {
    const URN: &str = "urn:ogc:def:crs:";
    let is_urn = text.get(..URN.len()).is_some_and(|start| start.eq_ignore_ascii_case(URN));
    let mut parts = if is_urn { &text[URN.len()..] } else { text }.split(':');
    if !parts.next()?.eq_ignore_ascii_case("EPSG") {
        return None;
    }
    let codes = parts.next_back()?;
    let (horizontal, vertical) = codes.split_once('+').unwrap_or((codes, ""));
    Some(of_codes(horizontal.parse().ok()?, vertical.parse().ok()))
}

/// Returns the system of EPSG codes; units are known only of some.
pub(crate) fn of_codes(horizontal: u32, vertical: Option<u32>) -> Crs {
    Crs {
        epsg: Some(horizontal),
        unit: epsg::unit(horizontal),
        vertical_unit: vertical.and_then(epsg::height_unit),
        ..Crs::default()
    }
}

/// Returns the unit of a system that states none, if its code leaves no doubt.
fn or_of_code(unit: Option<Unit>, code: Option<u32>) -> Option<Unit> {
    unit.or_else(|| code.and_then(epsg::unit))
}

#[cfg(test)]
mod tests;
