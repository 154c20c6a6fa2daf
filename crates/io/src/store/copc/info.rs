//! The record of a LAZ file that makes a COPC file of it.

use glam::DVec3;

use super::hierarchy::Page;
use crate::Error;
use crate::las::LasFile;
use pellucid_core::cloud::Bounds;

/// Bytes of the record's fields that are read.
const LEN: usize = 56;

/// The octree of a file.
pub(super) struct Info {
    /// The cube of the root.
    pub cube: Bounds,
    /// The distance of the root's points, in the file's units.
    pub spacing: f64,
    pub root_page: Page,
}

impl Info {
    pub fn read(file: &LasFile) -> Result<Self, Error> {
        let malformed = |cause: String| file.file.malformed("COPC info record", cause);
        let Some(record) = &file.header.copc else {
            return Err(malformed("it is missing: this is a LAZ file, but not a COPC file".to_owned()));
        };
        let Some((fields, [])) = record.get(..LEN).map(<[u8]>::as_chunks::<8>) else {
            return Err(malformed(format!("it has {} bytes, but at least {LEN} are needed", record.len())));
        };
        let number = |at: usize| f64::from_le_bytes(fields[at]);
        let whole = |at: usize| u64::from_le_bytes(fields[at]);
        let (center, half, spacing) = (DVec3::new(number(0), number(1), number(2)), number(3), number(4));
        let cube = Bounds { min: center - half, max: center + half };
        let widened = file.header.widened(cube);
        if !((widened.max - widened.min).is_finite() && half > 0.0) {
            return Err(malformed(format!("no cube can lie around {center} with half a side of {half}")));
        }
        if !(spacing.is_finite() && spacing > 0.0) {
            return Err(malformed(format!("its spacing is {spacing}, expected a number above 0")));
        }
        Ok(Self { cube, spacing, root_page: Page { start: whole(5), bytes: whole(6) } })
    }
}
