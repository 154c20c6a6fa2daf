//! A temporary file to which pieces are added, and which are read and overwritten in any order.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use super::super::temporary::TemporaryFile;
use pellucid_io::Error;

/// The file.
#[derive(Debug)]
pub(super) struct Pile {
    file: TemporaryFile,
    /// Words that it has.
    end: Mutex<u64>,
    folder: PathBuf,
}

/// A piece of it, in words of 32 bits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct FileExtent {
    pub start: u64,
    pub words: u64,
}

impl Pile {
    /// Returns an empty one in a folder.
    pub fn new(folder: &Path) -> Result<Self, Error> {
        let folder = folder.to_path_buf();
        match TemporaryFile::new(&folder) {
            Ok(file) => Ok(Self { file, end: Mutex::new(0), folder }),
            Err(source) => Err(Error::Temporary { folder, source }),
        }
    }

    /// Adds words.
    pub fn add(&self, words: &[u32]) -> Result<FileExtent, Error> {
        let mut end = self.end.lock().unwrap_or_else(PoisonError::into_inner);
        let extent = FileExtent { start: *end, words: words.len() as u64 };
        self.write(extent.start, words)?;
        *end += extent.words;
        Ok(extent)
    }

    /// Puts as many words in place of others.
    pub fn overwrite(&self, extents: &[FileExtent], words: &[u32]) -> Result<(), Error> {
        let mut rest = words;
        for extent in extents {
            let (here, others) = rest.split_at(usize::try_from(extent.words).unwrap_or(usize::MAX));
            self.write(extent.start, here)?;
            rest = others;
        }
        Ok(())
    }

    fn write(&self, start: u64, words: &[u32]) -> Result<(), Error> {
        let written = self.file.write(start, words);
        written.map_err(|source| Error::Temporary { folder: self.folder.clone(), source })
    }

    /// Reads words behind others.
    pub fn read(&self, extent: FileExtent, into: &mut Vec<u32>) -> Result<(), Error> {
        let first = into.len();
        into.resize(first + usize::try_from(extent.words).unwrap_or(usize::MAX), 0);
        let read = self.file.read(extent.start, &mut into[first..]);
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
