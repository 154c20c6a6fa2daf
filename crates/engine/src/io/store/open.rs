//! Any input as a store.

use std::path::Path;

use super::{Grid, Held, Octree, Store};
use crate::io::{Error, Hints, Source, las, load_with};
use crate::progress::Progress;

/// Opens an octree, or reads a file of another format ([`load_with`]) into memory.
///
/// # Errors
/// Those of [`Octree::open`] and of [`load_with`].
pub fn open_input(path: &Path, hints: Hints, progress: &Progress) -> Result<Box<dyn Store>, Error> {
    if Octree::is_one(path) {
        return Ok(Box::new(Octree::open(path)?));
    }
    let cloud = load_with(path, hints, progress)?;
    Ok(Box::new(Held::new(path, cloud)?.on_grid(las_grid(path)?)))
}

/// The grid of a LAS or LAZ file; `None` of others.
fn las_grid(path: &Path) -> Result<Option<Grid>, Error> {
    let mut source = Source::open(path)?;
    if !source.peek()?.starts_with(b"LASF") {
        return Ok(None);
    }
    las::grid(&mut source).map(Some)
}
