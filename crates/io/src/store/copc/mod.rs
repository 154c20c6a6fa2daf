//! COPC files: LAZ files whose chunks are the nodes of an octree, with a hierarchy that says which chunk is which
//! (copc.io, 1.0).

mod hierarchy;
mod info;

use std::collections::HashMap;
use std::path::Path;

use super::keys::{Key, cut, parents};
use super::las::{LasSurvey, check_finite, no_points, read, summary};
use super::{Node, Piece, Store, Summary};
use crate::las::{Chunk, LasFile, Traits};
use crate::{Error, InputFile, LasColumns};
use hierarchy::Entry;
use info::Info;
use pellucid_core::cloud::Bounds;

/// A COPC file, read node by node.
///
/// Opening it reads the hierarchy, and decodes nodes from the root on until what decides about whole columns is known:
/// the root where colors have 16 bits and pulses several returns, all nodes where colors have fewer, where every pulse
/// has one return, or where GPS times are asked for.
#[derive(Debug)]
pub struct Copc {
    file: LasFile,
    traits: Traits,
    /// The chunk of each node.
    chunks: Vec<Chunk>,
    nodes: Vec<Node>,
    pub(super) summary: Summary,
}

impl Copc {
    /// Opens a COPC file with points. Of the columns that are read only where they are asked for, it has these.
    ///
    /// # Errors
    /// Returns the errors of [`LasPieces::open`](super::LasPieces::open), and an error for a file without the record
    /// that makes a COPC file of it; a hierarchy that is damaged, has loops, names chunks that the file doesn't have,
    /// or leaves points out.
    pub fn open(path: &Path, asked: LasColumns) -> Result<Self, Error> {
        Self::new(LasFile::open(InputFile::open(path)?, asked)?)
    }

    pub(super) fn new(file: LasFile) -> Result<Self, Error> {
        check_finite(&file)?;
        if file.header.count == 0 {
            return Err(no_points(&file));
        }
        let info = Info::read(&file)?;
        let mut entries = hierarchy::read(&file.file, info.root_page)?;
        entries.sort_unstable_by_key(|entry| entry.key);
        let chunks = chunks(&file, &entries)?;
        let keys: Vec<Key> = entries.iter().map(|entry| entry.key).collect();
        let claimed = file.header.claimed_bounds();
        let nodes = entries.iter().zip(parents(&keys)).map(|(entry, parent)| {
            let cube = file.header.widened(entry.key.cube(&info.cube));
            let Some(bounds) = claimed.map_or(Some(cube), |claimed| cut(cube, claimed)) else {
                let cause = "its cube lies outside the box in the header";
                return Err(file.file.malformed(format!("COPC node {}", entry.key), cause));
            };
            Ok(Node {
                level: entry.key.level,
                parent,
                bounds,
                points: entry.points,
                bytes: entry.bytes,
                spacing: info.spacing / (1u64 << entry.key.level) as f64,
                largest_radius: None,
            })
        });
        let nodes = nodes.collect::<Result<Vec<_>, Error>>()?;
        let survey = LasSurvey::of(&file, chunks.iter(), None)?;
        let Some(bounds) = nodes.iter().map(|node| node.bounds).reduce(Bounds::union) else {
            return Err(no_points(&file));
        };
        let summary = summary(&file, &survey.traits, bounds);
        Ok(Self { traits: survey.traits, chunks, nodes, summary, file })
    }
}

/// The chunk of each entry: every chunk belongs to one.
fn chunks(file: &LasFile, entries: &[Entry]) -> Result<Vec<Chunk>, Error> {
    let mut left: HashMap<u64, &Chunk> = file.chunks.iter().map(|chunk| (chunk.start, chunk)).collect();
    let take = |entry: &Entry| match left.remove(&entry.start) {
        Some(chunk) if chunk.bytes == entry.bytes && chunk.points == entry.points => Ok(*chunk),
        chunk => {
            let cause = format!(
                "it has {} points in {} bytes from byte {}, where {}",
                entry.points,
                entry.bytes,
                entry.start,
                chunk.map_or_else(
                    || "no chunk of points begins, or one that belongs to another node".to_owned(),
                    |chunk| format!("a chunk of {} points in {} bytes begins", chunk.points, chunk.bytes)
                )
            );
            Err(file.file.malformed(format!("COPC node {}", entry.key), cause))
        }
    };
    let taken = entries.iter().map(take).collect::<Result<Vec<_>, _>>()?;
    match left.values().map(|chunk| chunk.start).min() {
        None => Ok(taken),
        Some(start) => {
            let cause = format!("{} chunks of points belong to no node, the first at byte {start}", left.len());
            Err(file.file.malformed("COPC hierarchy", cause))
        }
    }
}

impl Store for Copc {
    known!();

    fn read(&self, node: usize) -> Result<Piece, Error> {
        read(&self.file, &self.chunks[node..=node], &self.traits, &self.nodes[node].bounds)
    }
}
