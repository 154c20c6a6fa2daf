//! survey.bin: what follows from all points of a store, so that nobody has to read all of them: facts, and the points that stand for
//! all.

use std::path::Path;

use rayon::prelude::*;

use super::{Octree, malformed};
use crate::cloud::facts::Facts;
use crate::cloud::sampling::Sampling;
use crate::cloud::{Bounds, Cloud};
use crate::io::Error;
use crate::io::shared::SharedFile;
use crate::io::store::Survey;
use crate::progress::Progress;

/// The file's name.
pub(crate) const SURVEY: &str = "survey.bin";

/// First bytes of the file, the last one of which is the version. The length of the facts follows (u32), these as JSON, and the records
/// of the points.
const MAGIC: [u8; 8] = *b"pellucs\x01";
/// Bytes of the facts at most.
const MAX_FACTS: usize = 1 << 16;
/// Points that stand for all, at most; more than [`Sampling`] takes unless very many are in one place.
const MAX_POINTS: usize = 1 << 20;
/// Nodes that are read at once.
const BATCH: usize = 64;

/// The bytes of the file for a store, all of whose points are read. `None` if too many points stand for all.
///
/// # Errors
/// The store can't be read, or `progress` cancels it.
pub(crate) fn of_store(octree: &Octree, progress: &Progress) -> Result<Option<Vec<u8>>, Error> {
    let sampling = Sampling::of(octree.summary.points);
    progress.reset();
    progress.set_message("looking at the points");
    progress.set_length(octree.summary.points);
    let look = |node: &usize| {
        let (records, stride) = (octree.records(*node)?, octree.decoder.stride());
        let cloud = octree.decode(*node, &records)?;
        progress.inc(cloud.len() as u64);
        let each = records.chunks_exact(stride.max(1) as usize).zip(&cloud.positions);
        let taken = each.filter(|(_, position)| sampling.takes(**position));
        let taken: Vec<u8> = taken.flat_map(|(record, _)| record).copied().collect();
        Ok((Facts::of(&cloud), taken))
    };
    let (mut facts, mut records) = (Facts::default(), Vec::new());
    let nodes: Vec<usize> = (0..octree.nodes.len()).filter(|node| octree.nodes[*node].points > 0).collect();
    for batch in nodes.chunks(BATCH) {
        progress.check().map_err(|_| Error::Cancelled { path: octree.summary.path.clone() })?;
        for (more, taken) in batch.par_iter().map(look).collect::<Result<Vec<_>, Error>>()? {
            facts = facts.and(&more);
            records.extend(taken);
        }
        if records.len() > MAX_POINTS * octree.decoder.stride() as usize {
            return Ok(None);
        }
    }
    let json = serde_json::to_vec(&facts);
    let json = json.map_err(|source| Error::Write { path: octree.summary.path.join(SURVEY), source: source.into() })?;
    let length = (json.len() as u32).to_le_bytes();
    Ok(Some([&MAGIC[..], &length, &json, &records].concat()))
}

/// Reads the file of a store, if it is there.
///
/// # Errors
/// It can't be read, or can't be of this store.
pub(super) fn read(octree: &Octree) -> Result<Option<Survey>, Error> {
    let folder: &Path = &octree.summary.path;
    if !octree.is_ours || !folder.join(SURVEY).exists() {
        return Ok(None);
    }
    let refused = |cause: &str| malformed(folder, SURVEY, cause.to_owned());
    let file = SharedFile::open(&folder.join(SURVEY))?;
    let stride = octree.decoder.stride().max(1);
    if file.len() > (MAX_FACTS + MAX_POINTS * stride as usize) as u64 {
        return Err(refused("it has more bytes than any survey"));
    }
    let bytes = file.read(0, file.len())?;
    let rest = bytes.strip_prefix(&MAGIC).ok_or_else(|| refused("it starts like no file of this version"))?;
    let (length, rest) = rest.split_first_chunk().ok_or_else(|| refused("it ends within its facts"))?;
    let length = u32::from_le_bytes(*length) as usize;
    if length > rest.len() {
        return Err(refused("it ends within its facts"));
    }
    let (json, records) = rest.split_at(length);
    let facts: Facts = serde_json::from_slice(json).map_err(|error| refused(&error.to_string()))?;
    let all = octree.summary.bounds;
    let holds = |bounds: &Bounds| all.holds(bounds) && bounds.min.cmple(bounds.max).all();
    if facts.points != octree.summary.points || !facts.bounds.as_ref().is_some_and(holds) {
        return Err(refused("it is of other points than octree.bin"));
    }
    if !(records.len() as u64).is_multiple_of(stride) {
        return Err(refused("it ends within a point"));
    }
    let sample = Cloud { up: octree.summary.up, ..octree.decoder.cloud(records) };
    if sample.bounds().is_some_and(|bounds| !all.holds(&bounds)) {
        return Err(refused("it has points outside of the octree"));
    }
    Ok(Some(Survey { facts, sample }))
}
