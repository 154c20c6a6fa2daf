//! The coordinate reference system in the records of a LAS file: GeoTIFF keys, or well-known text (LAS 1.4, 2.4).

use super::header::until_zero;
use crate::crs::{self, GeoRecords, RECORD_KEYS, RECORD_NUMBERS, RECORD_TEXT};
use pellucid_core::cloud::crs::Crs;

/// User of the records.
const USER: &[u8] = b"LASF_Projection";

/// Identifier of the record of well-known text.
const WKT: u16 = 2112;

/// Bit of the header's global encoding: the text counts, and not the keys.
const WKT_BIT: u16 = 1 << 4;

/// Returns `true` for a record that describes a system.
pub(super) fn is_record(user: &[u8], id: u16) -> bool {
    user == USER && [RECORD_KEYS, RECORD_NUMBERS, RECORD_TEXT, WKT].contains(&id)
}

/// Returns the system of a file with these records: user, identifier and bytes. If keys and text both describe one,
/// the header says which counts.
pub(super) fn crs<'a>(records: impl Iterator<Item = (&'a [u8], u16, &'a [u8])>, encoding: u16) -> Option<Crs> {
    let (mut geo, mut text) = (GeoRecords::default(), None);
    for (_, id, data) in records.filter(|(user, id, _)| is_record(user, *id)) {
        match id {
            RECORD_KEYS => geo.keys = data.to_vec(),
            RECORD_NUMBERS => geo.numbers = data.to_vec(),
            RECORD_TEXT => geo.text = data.to_vec(),
            _ => text = crs::parse(&String::from_utf8_lossy(until_zero(data))),
        }
    }
    if encoding & WKT_BIT != 0 { text.or_else(|| geo.crs()) } else { geo.crs().or(text) }
}
