//! A temporary file to which pieces are added, and which are read and overwritten in any order.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use pellucid_fault as fault;
use pellucid_io::Error;

/// The file.
#[derive(Debug)]
pub(super) struct Pile {
    /// Unnamed: it goes with the process. With it where it ends.
    file: Mutex<(File, u64)>,
    folder: PathBuf,
}

/// A piece of it, in words of 32 bits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct FileExtent {
    pub start: u64,
    pub words: u64,
}

/// Words of some extents.
pub(super) fn words_of(extents: &[FileExtent]) -> u64 {
    extents.iter().map(|extent| extent.words).sum()
}

impl Pile {
    /// Returns an empty one in a folder.
    pub fn new(folder: &Path) -> Result<Self, Error> {
        let file = tempfile::tempfile_in(folder)
            .map_err(|source| Error::Temporary { folder: folder.to_path_buf(), source })?;
        Ok(Self { file: Mutex::new((file, 0)), folder: folder.to_path_buf() })
    }

    /// Adds words.
    pub fn add(&self, words: &[u32]) -> Result<FileExtent, Error> {
        let mut locked = self.file.lock().unwrap_or_else(PoisonError::into_inner);
        let (file, end) = &mut *locked;
        let extent = FileExtent { start: *end, words: words.len() as u64 };
        self.write(file, extent.start, words)?;
        *end += extent.words;
        Ok(extent)
    }

    /// Puts as many words in place of others.
    pub fn overwrite(&self, extents: &[FileExtent], words: &[u32]) -> Result<(), Error> {
        let mut rest = words;
        for extent in extents {
            let (here, others) = rest.split_at(usize::try_from(extent.words).unwrap_or(usize::MAX));
            self.write(&mut self.file.lock().unwrap_or_else(PoisonError::into_inner).0, extent.start, here)?;
            rest = others;
        }
        Ok(())
    }

    fn write(&self, file: &mut File, start: u64, words: &[u32]) -> Result<(), Error> {
        let written =
            file.seek(SeekFrom::Start(4 * start)).and_then(|_| fault::write_all(file, bytemuck::cast_slice(words)));
        written.map_err(|source| Error::Temporary { folder: self.folder.clone(), source })
    }

    /// Reads words behind others.
    pub fn read(&self, extent: FileExtent, into: &mut Vec<u32>) -> Result<(), Error> {
        let first = into.len();
        into.resize(first + usize::try_from(extent.words).unwrap_or(usize::MAX), 0);
        let mut locked = self.file.lock().unwrap_or_else(PoisonError::into_inner);
        let file = &mut locked.0;
        let read = file
            .seek(SeekFrom::Start(4 * extent.start))
            .and_then(|_| file.read_exact(bytemuck::cast_slice_mut(&mut into[first..])));
        read.map_err(|source| Error::Read { path: self.folder.clone(), source })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_are_read_and_overwritten_in_any_order() {
        let folder = tempfile::tempdir().unwrap();
        let pile = Pile::new(folder.path()).unwrap();
        let [a, b, c] = [&[1, 2, 3][..], &[4], &[5, 6]].map(|words| pile.add(words).unwrap());
        assert_eq!([a.start, b.start, c.start], [0, 3, 4]);
        let all = |extents: &[FileExtent]| {
            let mut words = Vec::new();
            extents.iter().for_each(|extent| pile.read(*extent, &mut words).unwrap());
            words
        };
        assert_eq!(all(&[c, a]), [5, 6, 1, 2, 3]);
        pile.overwrite(&[c, a], &[7, 8, 9, 10, 11]).unwrap();
        assert_eq!(all(&[a, b, c]), [9, 10, 11, 4, 7, 8]);
        // Nothing in the folder that anybody else could see.
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}
