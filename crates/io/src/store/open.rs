//! Files and folders as stores, by what they are.

use std::path::Path;

use super::{Copc, Ept, Held, LasPieces, Octree, PlyPieces, Store, Summary};
use crate::las::LasFile;
use crate::ply::{Vertices, is_prepared};
use crate::{Error, Format, Hints, NAMES_WITHOUT_EFFECT, Source, load_with, splats};
use pellucid_core::progress::Progress;

/// Opens a cloud to be read node by node: a folder with an octree of Potree 2.0 (or its `metadata.json`), an EPT folder
/// (or its `ept.json`), COPC, LAS and LAZ files, binary PLY files. All other files are loaded as a whole, which
/// `progress` follows.
///
/// Opening takes as long as each says: [`Octree`], [`Ept`], [`Copc`], [`LasPieces`], [`PlyPieces`].
///
/// # Errors
/// Returns the errors of each store's `open`, and of [`load_with`].
pub fn open(path: &Path, hints: Hints, progress: &Progress) -> Result<Box<dyn Store>, Error> {
    if is_ept(path) {
        let mut store = Ept::open(path, hints.las)?;
        store.summary.like.warnings.extend(warning(&hints));
        return refuse_photo(path, &hints).map(|()| Box::new(store) as Box<dyn Store>);
    }
    if Octree::is_one(path) {
        let mut store = Octree::open(path)?;
        store.summary.like.warnings.extend(warning(&hints));
        return refuse_photo(path, &hints).map(|()| Box::new(store) as Box<dyn Store>);
    }
    if splats::is_folder(path) {
        return whole(path, hints, progress);
    }
    let mut source = Source::open(path)?;
    let start = source.peek()?;
    match Format::detect(&source, &start) {
        Ok(Format::Las) => {
            refuse_photo(path, &hints)?;
            let file = LasFile::open(source, hints.las)?;
            if file.header.copc.is_some() {
                let mut store = Copc::new(file)?;
                store.summary.like.warnings.extend(warning(&hints));
                return Ok(Box::new(store));
            }
            let mut store = LasPieces::new(file)?;
            store.summary.like.warnings.extend(warning(&hints));
            Ok(Box::new(store))
        }
        Ok(Format::Ply) => {
            refuse_photo(path, &hints)?;
            match PlyPieces::new(source)? {
                Some(mut store) => {
                    store.summary.like.warnings.extend(warning(&hints));
                    Ok(Box::new(store))
                }
                None => whole(path, hints, progress),
            }
        }
        _ => whole(path, hints, progress),
    }
}

/// Returns the points that a cloud announces, without a look at them, and the degree of the harmonics if they are
/// Gaussians; `None` of files that say nothing of it, or that are read as a whole.
///
/// # Errors
/// Returns an error if the file can't be opened.
pub fn announced(path: &Path, hints: &Hints) -> Result<Option<(u64, Option<u32>)>, Error> {
    if is_ept(path) {
        return Ok(Some((Ept::open(path, hints.las)?.summary().points, None)));
    }
    if Octree::is_one(path) {
        let Summary { points, like, .. } = Octree::open(path)?.summary;
        return Ok(Some((points, like.gaussians.map(|splats| splats.degree))));
    }
    if splats::is_folder(path) {
        return Ok(None);
    }
    let mut source = Source::open(path)?;
    let start = source.peek()?;
    match Format::detect(&source, &start) {
        Ok(Format::Las) => Ok(Some((LasFile::open(source, hints.las)?.header.count, None))),
        Ok(Format::Ply) => match Vertices::find(source)? {
            (Vertices::Rows(rows), comments) if !is_prepared(&comments) => Ok(Some((rows.count, None))),
            _ => Ok(None),
        },
        _ => Ok(None),
    }
}

/// Returns `true` if a path is a folder that is a store, or the file that describes it.
pub fn is_folder(path: &Path) -> bool {
    is_ept(path) || Octree::is_one(path)
}

/// Returns `true` if a cloud has levels of detail: a folder that is a store, or COPC.
///
/// # Errors
/// Returns an error if the file can't be opened.
pub fn has_levels(path: &Path, hints: &Hints) -> Result<bool, Error> {
    if is_folder(path) {
        return Ok(true);
    }
    if splats::is_folder(path) {
        return Ok(false);
    }
    let mut source = Source::open(path)?;
    let start = source.peek()?;
    let is_las = matches!(Format::detect(&source, &start), Ok(Format::Las));
    Ok(is_las && LasFile::open(source, hints.las)?.header.copc.is_some())
}

fn is_ept(path: &Path) -> bool {
    path.file_name().is_some_and(|name| name == "ept.json") || path.join("ept.json").is_file()
}

fn whole(path: &Path, hints: Hints, progress: &Progress) -> Result<Box<dyn Store>, Error> {
    Ok(Box::new(Held::new(path, load_with(path, hints, progress)?)?))
}

/// Returns a warning about hints that are for other files.
fn warning(hints: &Hints) -> Option<String> {
    hints.columns.map(|_| NAMES_WITHOUT_EFFECT.to_owned())
}

fn refuse_photo(path: &Path, hints: &Hints) -> Result<(), Error> {
    if hints.photo.is_some() { Err(Error::NoPicture { path: path.to_path_buf() }) } else { Ok(()) }
}
