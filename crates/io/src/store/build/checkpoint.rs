//! State that an assembler needs to go on after its process ended: a file of the nodes that are written, which grows,
//! and one of those that are open, of which there are two in turn.

use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::cube::Cell;
use super::hierarchy::Written;
use super::sink::Sink;
use super::tree::Open;
use crate::Error;
use pellucid_core::cloud::facts::Facts;

/// The file of the nodes that are written, a line each.
const NODES: &str = "written.jsonl";

/// A moment of an assembler.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub(super) struct Checkpoint {
    /// Length of octree.bin in bytes.
    pub bytes: u64,
    /// Bytes of the file of nodes.
    pub nodes: u64,
    /// The file of open nodes; `None` for none.
    pub open: Option<u8>,
    /// Bits of the ranges.
    pub ranges: Vec<[u64; 2]>,
    /// Facts about the points so far.
    pub facts: Facts,
    /// Bytes of the file of points that stand for all.
    pub sample: u64,
    /// Points so far.
    pub total: u64,
}

/// The file of the nodes that are written.
#[derive(Debug)]
pub(super) struct Kept {
    file: Sink,
    /// Number of records in it.
    count: usize,
    /// The file of open nodes that is written next.
    next: u8,
}

fn open_path(folder: &Path, number: u8) -> PathBuf {
    folder.join(format!("open.{number}"))
}

impl Kept {
    /// Returns the nodes of a checkpoint, and their file.
    pub fn resume(folder: &Path, checkpoint: &Checkpoint) -> Result<(Self, Vec<Written>), Error> {
        let path = folder.join(NODES);
        let file = Sink::keep(&path, checkpoint.nodes)?;
        let failed = |source| Error::Read { path: path.clone(), source };
        let reader = BufReader::new(std::fs::File::open(&path).map_err(failed)?);
        let read = |line: std::io::Result<String>| serde_json::from_str(&line?).map_err(std::io::Error::from);
        let written = reader.lines().map(read).collect::<Result<Vec<Written>, _>>().map_err(failed)?;
        let next = checkpoint.open.map_or(0, |open| 1 - open.min(1));
        Ok((Self { file, count: written.len(), next }, written))
    }

    /// Adds the nodes that are new; bytes of the file.
    pub fn add(&mut self, written: &[Written]) -> Result<u64, Error> {
        let mut text = Vec::new();
        for node in written.get(self.count..).unwrap_or_default() {
            // A node is plain numbers.
            text.extend(serde_json::to_vec(node).unwrap_or_default());
            text.push(b'\n');
        }
        self.file.write(&text)?;
        self.count = written.len();
        Ok(self.file.len())
    }

    /// Writes the open nodes; the number of their file.
    pub fn write_open(&mut self, folder: &Path, open: &[Open]) -> Result<Option<u8>, Error> {
        let number = self.next;
        let mut file = Sink::new(&open_path(folder, number))?;
        for Open { cell, total, is_inner, records } in open {
            let mut line = serde_json::to_vec(&(cell, total, is_inner, records.len())).unwrap_or_default();
            line.push(b'\n');
            file.write(&line)?;
            file.write(records)?;
        }
        self.next = 1 - number;
        Ok(Some(number))
    }

    /// Removes the files, which are no part of a store.
    pub fn remove(&self, folder: &Path) {
        // A file that can't be removed is in nobody's way.
        let _ = std::fs::remove_file(folder.join(NODES));
        (0..2).for_each(|number| drop(std::fs::remove_file(open_path(folder, number))));
    }
}

/// Returns the open nodes of a checkpoint.
pub(super) fn read_open(folder: &Path, checkpoint: &Checkpoint) -> Result<Vec<Open>, Error> {
    let Some(number) = checkpoint.open else { return Ok(Vec::new()) };
    let path = open_path(folder, number);
    let read = || -> std::io::Result<Vec<Open>> {
        let mut reader = BufReader::new(std::fs::File::open(&path)?);
        let mut open = Vec::new();
        let mut line = String::new();
        while reader.read_line(&mut line)? > 0 {
            let (cell, total, is_inner, bytes): (Cell, u64, bool, u64) = serde_json::from_str(&line)?;
            let mut records = Vec::new();
            if (reader.by_ref().take(bytes).read_to_end(&mut records)? as u64) < bytes {
                return Err(std::io::ErrorKind::UnexpectedEof.into());
            }
            open.push(Open { cell, total, is_inner, records });
            line.clear();
        }
        Ok(open)
    };
    read().map_err(|source| Error::Read { path: path.clone(), source })
}
