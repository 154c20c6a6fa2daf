//! `photo` of a `[[cloud]]`: where a picture stands in the world, and how it is bent.

use std::path::Path;

use glam::DVec3;

use super::error::Error;
use super::table::{Range, Table};
use crate::io::photo::{Heights, Photo};

/// Reads the table inside that of a cloud; `None` if there is none. Files are relative to `folder`.
pub(super) fn read(
    cloud: &Table<'_>,
    folder: Option<&Path>,
    warnings: &mut Vec<String>,
) -> Result<Option<Photo>, Error> {
    let Some(node) = cloud.get("photo") else { return Ok(None) };
    let table = cloud.table("photo")?;
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
            return Err(Error::Conflict { place: node.place.clone(), problem });
        }
    };
    let scale = table.number("height_scale", Range::COORDINATE)?;
    let heights = match (table.string("heights")?, scale) {
        (None, None) => None,
        (None, Some(_)) => {
            warnings.push(format!("{}: `photo.height_scale` has no effect without `photo.heights`", node.place));
            None
        }
        (Some(path), Some(scale)) => {
            let path = folder.map_or_else(|| path.into(), |folder| folder.join(path));
            Some(Heights { path, scale })
        }
        (Some(_), None) => {
            let problem = "`photo.heights` needs `photo.height_scale`, the height of white over black in world units";
            return Err(Error::Conflict { place: node.place.clone(), problem: problem.into() });
        }
    };
    Ok(Some(Photo { origin: table.vector("origin")?, edges, heights }))
}

/// Whether two vectors are parallel neither in truth nor within rounding.
fn is_plane(right: DVec3, up: DVec3) -> bool {
    let sine = right.normalize_or_zero().cross(up.normalize_or_zero()).length();
    sine > 1e-6 && right.cross(up).try_normalize().is_some()
}
