//! Files and folders as stores, by what they are.

use std::path::Path;

use super::photo::PhotoPieces;
use super::{Copc, Ept, LasPieces, MemoryStore, Octree, PlyPieces, Store, Summary};
use crate::las::LasFile;
use crate::photo::{self, Photo};
use crate::ply::{Vertices, is_prepared};
use crate::{Error, Format, Hints, InputFile, NAMES_WITHOUT_EFFECT, load_with, splats};
use pellucid_core::progress::Progress;

/// Opens a cloud to be read node by node: a folder with an octree of Potree 2.0 (or its `metadata.json`), an EPT folder
/// (or its `ept.json`), COPC, LAS and LAZ files, binary PLY files, pictures. All other files are loaded as a whole,
/// which `progress` follows.
///
/// Opening takes as long as each says: [`Octree`], [`Ept`], [`Copc`], [`LasPieces`], [`PlyPieces`].
///
/// # Errors
/// Returns the errors of each store's `open`, and of [`load_with`].
pub fn open(path: &Path, hints: Hints, progress: &Progress) -> Result<Box<dyn Store>, Error> {
    let found = StoreFormat::at(path)?;
    if matches!(found, StoreFormat::Las(_) | StoreFormat::Ply(_)) {
        refuse_photo(path, &hints)?;
    }
    match found {
        StoreFormat::Ept => hinted(path, &hints, Ept::open(path, hints.las)?, |store| &mut store.summary),
        StoreFormat::Octree => hinted(path, &hints, Octree::open(path)?, |store| &mut store.summary),
        StoreFormat::Las(source) => {
            let file = LasFile::open(source, hints.las)?;
            if file.header.copc.is_some() {
                hinted(path, &hints, Copc::new(file)?, |store| &mut store.summary)
            } else {
                hinted(path, &hints, LasPieces::new(file)?, |store| &mut store.summary)
            }
        }
        StoreFormat::Ply(source) => match PlyPieces::new(source)? {
            Some(store) => hinted(path, &hints, store, |store| &mut store.summary),
            None => whole(path, hints, progress),
        },
        StoreFormat::Picture(source) => {
            let mut store = PhotoPieces::new(source, hints.photo.unwrap_or(&Photo::default()))?;
            store.summary.like.warnings.extend(hints.columns.map(|_| NAMES_WITHOUT_EFFECT.to_owned()));
            Ok(Box::new(store))
        }
        StoreFormat::Whole => whole(path, hints, progress),
    }
}

/// Format of the cloud at a path.
enum StoreFormat {
    Ept,
    Octree,
    Las(InputFile),
    Ply(InputFile),
    Picture(InputFile),
    /// A file or folder that is read as a whole.
    Whole,
}

impl StoreFormat {
    fn at(path: &Path) -> Result<Self, Error> {
        if is_ept(path) {
            return Ok(Self::Ept);
        }
        if Octree::is_one(path) {
            return Ok(Self::Octree);
        }
        if splats::is_folder(path) {
            return Ok(Self::Whole);
        }
        let mut source = InputFile::open(path)?;
        let start = source.peek()?;
        Ok(match Format::detect(&source, &start) {
            Ok(Format::Las) => Self::Las(source),
            Ok(Format::Ply) => Self::Ply(source),
            Ok(Format::Picture) => Self::Picture(source),
            _ => Self::Whole,
        })
    }
}

/// Returns the points that a cloud announces, without a look at them, and the degree of the harmonics if they are
/// Gaussians; `None` of files that say nothing of it, or that are read as a whole.
///
/// # Errors
/// Returns an error if the file can't be opened.
pub fn announced(path: &Path, hints: &Hints) -> Result<Option<(u64, Option<u32>)>, Error> {
    Ok(match StoreFormat::at(path)? {
        StoreFormat::Ept => Some((Ept::open(path, hints.las)?.summary().points, None)),
        StoreFormat::Octree => {
            let Summary { points, like, .. } = Octree::open(path)?.summary;
            Some((points, like.gaussians.map(|splats| splats.degree)))
        }
        StoreFormat::Las(source) => Some((LasFile::open(source, hints.las)?.header.count, None)),
        StoreFormat::Ply(source) => match Vertices::find(source)? {
            (Vertices::Rows(rows), remarks) if !is_prepared(&remarks.comments) => Some((rows.count, None)),
            _ => None,
        },
        // Steep ones become more.
        StoreFormat::Picture(source) => Some((photo::pixels(source)?, None)),
        StoreFormat::Whole => None,
    })
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
    Ok(match StoreFormat::at(path)? {
        StoreFormat::Ept | StoreFormat::Octree => true,
        StoreFormat::Las(source) => LasFile::open(source, hints.las)?.header.copc.is_some(),
        StoreFormat::Ply(_) | StoreFormat::Picture(_) | StoreFormat::Whole => false,
    })
}

fn is_ept(path: &Path) -> bool {
    path.file_name().is_some_and(|name| name == "ept.json") || path.join("ept.json").is_file()
}

fn whole(path: &Path, hints: Hints, progress: &Progress) -> Result<Box<dyn Store>, Error> {
    Ok(Box::new(MemoryStore::new(path, load_with(path, hints, progress)?)?))
}

/// A store that warns of hints that are for other files.
fn hinted<S: Store + 'static>(
    path: &Path,
    hints: &Hints,
    mut store: S,
    summary: fn(&mut S) -> &mut Summary,
) -> Result<Box<dyn Store>, Error> {
    summary(&mut store).like.warnings.extend(hints.columns.map(|_| NAMES_WITHOUT_EFFECT.to_owned()));
    refuse_photo(path, hints).map(|()| Box::new(store) as Box<dyn Store>)
}

fn refuse_photo(path: &Path, hints: &Hints) -> Result<(), Error> {
    if hints.photo.is_some() { Err(Error::NoPicture(path.to_path_buf())) } else { Ok(()) }
}
