//! `photo` of a `[[cloud]]`: a picture's placement in the world, and its displacement.

use glam::DVec3;

use super::error::Error;
use super::schema::{Key, Range, ValueKind, keys};
use super::table::Table;
use pellucid_io::photo::{Heights, Photo};

/// Returns the keys of the table.
pub(super) fn keys() -> Vec<Key> {
    keys! {
        /// Position of the lower left corner of a picture.
        "photo.origin": ValueKind::Vector, unit "world units", without "its middle is at (0, 0, 0)";
        /// Vector from the left to the right edge of a picture; needs `photo.up`.
        "photo.right": ValueKind::Direction, unit "world units", without "width 1 along x";
        /// Vector from the lower to the upper edge of a picture; needs `photo.right`.
        "photo.up": ValueKind::Direction, unit "world units", without "along y, with square pixels";
        /// Grayscale picture of heights, relative to the folder of the scene file; needs `photo.height_scale`.
        "photo.heights": ValueKind::Text, without "the picture is flat";
        /// Height of white above black; if negative, white is deepest.
        "photo.height_scale": ValueKind::Number(Range::COORDINATE), unit "world units", without "the picture is flat";
    }
}

/// Reads the table inside that of a cloud; `None` if it is absent.
pub(super) fn read(cloud: &Table<'_>, key: &str) -> Result<Option<Photo>, Error> {
    let Some(node) = cloud.get(key) else { return Ok(None) };
    let table = cloud.table(key)?;
    table.refuse_unknown(&["origin", "right", "up", "heights", "height_scale"])?;
    let edges = match (table.direction("right")?, table.direction("up")?) {
        (None, None) => None,
        (Some(right), Some(up)) if is_plane(right, up) => Some([right, up]),
        (Some(right), Some(up)) => {
            return Err(table.error("up", node, format!("must span a plane with `right`, found {up} and {right}")));
        }
        (right, _) => {
            let (given, missing) = if right.is_some() { ("right", "up") } else { ("up", "right") };
            let problem = format!(
                "`photo.{given}` needs `photo.{missing}`: they are the picture's edges as vectors in the world; \
                 without both its width is 1 along x"
            );
            return Err(table.conflict("", problem));
        }
    };
    let scale = table.number("height_scale", Range::COORDINATE)?;
    let heights = match (table.path_of("heights")?, scale) {
        (None, None) => None,
        (None, Some(_)) => {
            table.warn(format!("{}: `photo.height_scale` has no effect without `photo.heights`", node.place));
            None
        }
        (Some(path), Some(scale)) => Some(Heights { path, scale }),
        (Some(_), None) => {
            let problem = "`photo.heights` needs `photo.height_scale`, the height of white over black in world units";
            return Err(table.conflict("", problem));
        }
    };
    Ok(Some(Photo { origin: table.vector("origin")?, edges, heights }))
}

/// Returns `true` if two vectors are clearly not parallel, beyond rounding.
fn is_plane(right: DVec3, up: DVec3) -> bool {
    let sine = right.normalize_or_zero().cross(up.normalize_or_zero()).length();
    sine > 1e-6 && right.cross(up).try_normalize().is_some()
}
