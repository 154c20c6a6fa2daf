//! A temporary file to which pieces are added, and which are read and overwritten in any order.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use crate::gpu::fault;
use crate::io::Error;

/// The file.
#[derive(Debug)]
pub(super) struct Pile {
    /// Unnamed: it goes with the process. With it where it ends.
    file: Mutex<(File, u64)>,
    folder: PathBuf,
}

/// A piece of it, in words of 32 bits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Extent {
    pub start: u64,
    pub words: u64,
}

/// Words of some extents.
pub(super) fn words_of(extents: &[Extent]) -> u64 {
    extents.iter().map(|extent| extent.words).sum()
}

impl Pile {
    /// An empty one in a folder.
    pub fn new(folder: &Path) -> Result<Self, Error> {
        let file = tempfile::tempfile_in(folder)
            .map_err(|source| Error::Temporary { folder: folder.to_path_buf(), source })?;
        Ok(Self { file: Mutex::new((file, 0)), folder: folder.to_path_buf() })
    }

    /// Adds words.
    pub fn add(&self, words: &[u32]) -> Result<Extent, Error> {
        let mut locked = self.file.lock().unwrap_or_else(PoisonError::into_inner);
        let (file, end) = &mut *locked;
        let extent = Extent { start: *end, words: words.len() as u64 };
        self.write(file, extent.start, words)?;
        *end += extent.words;
        Ok(extent)
    }

    /// Puts words in place of others, and what is too much behind all. Returns where they are now.
    pub fn replace(&self, extents: &[Extent], words: &[u32]) -> Result<Vec<Extent>, Error> {
        let (mut rest, mut used) = (words, Vec::with_capacity(extents.len()));
        for extent in extents {
            let (here, others) = rest.split_at(rest.len().min(usize::try_from(extent.words).unwrap_or(usize::MAX)));
            if !here.is_empty() {
                self.write(&mut self.file.lock().unwrap_or_else(PoisonError::into_inner).0, extent.start, here)?;
                used.push(Extent { words: here.len() as u64, ..*extent });
            }
            rest = others;
        }
        if !rest.is_empty() {
            used.push(self.add(rest)?);
        }
        Ok(used)
    }

    fn write(&self, file: &mut File, start: u64, words: &[u32]) -> Result<(), Error> {
        let written =
            file.seek(SeekFrom::Start(4 * start)).and_then(|_| fault::write_all(file, bytemuck::cast_slice(words)));
        written.map_err(|source| Error::Temporary { folder: self.folder.clone(), source })
    }

    /// Reads words behind others.
    pub fn read(&self, extent: Extent, into: &mut Vec<u32>) -> Result<(), Error> {
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
    fn pieces_are_replaced_by_fewer_and_by_more() {
        let folder = tempfile::tempdir().unwrap();
        let pile = Pile::new(folder.path()).unwrap();
        let [a, b, c] = [&[1, 2, 3][..], &[4], &[5, 6]].map(|words| pile.add(words).unwrap());
        assert_eq!([a.start, b.start, c.start], [0, 3, 4]);
        let all = |extents: &[Extent]| {
            let mut words = Vec::new();
            extents.iter().for_each(|extent| pile.read(*extent, &mut words).unwrap());
            words
        };
        assert_eq!(all(&[c, a]), [5, 6, 1, 2, 3]);
        let fewer = pile.replace(&[a, c], &[7, 8, 9, 10]).unwrap();
        assert_eq!((all(&fewer), words_of(&fewer)), (vec![7, 8, 9, 10], 4));
        let more = pile.replace(&fewer, &[1, 1, 2, 3, 5, 8]).unwrap();
        assert_eq!((all(&more), all(&[b])), (vec![1, 1, 2, 3, 5, 8], vec![4]));
        assert_eq!(more.len(), 3);
        // Nothing in the folder that anybody else could see.
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}
