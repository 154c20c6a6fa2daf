//! survey.bin: what follows from all points of a store, so that nobody has to read all of them: facts, and the points
//! that stand for all.

use std::path::Path;

use super::Octree;
use super::attributes::{AttributeLayout, Role};
use super::decode::{Decoder, full_scale, splats_of};
use crate::Error;
use crate::shared::SharedFile;
use crate::store::{Grid, StoreSurvey};
use pellucid_core::cloud::facts::Facts;
use pellucid_core::cloud::sampling::Sampling;
use pellucid_core::cloud::{Bounds, Cloud};

/// The file's name.
pub(crate) const SURVEY: &str = "survey.bin";

/// First bytes of the file, the last one of which is the version. The length of the facts follows (u32), these as JSON,
/// and the records of the points.
const MAGIC: [u8; 8] = *b"pellucs\x01";
/// Bytes of the facts at most.
const MAX_FACTS: usize = 1 << 16;
/// Points that stand for all, at most; more than [`Sampling`] takes unless very many are in one place.
const MAX_POINTS: usize = 1 << 20;
/// Looks at the points of a store while they are written.
#[derive(Debug)]
pub(crate) struct Surveyor {
    decoder: Decoder,
    sampling: Sampling,
}

impl Surveyor {
    /// Starts the survey of a store of this program with so many points in all.
    pub fn new(mut layout: AttributeLayout, grid: Grid, points: u64) -> Self {
        let full = layout.find(&Role::Rgb).and_then(|rgb| full_scale(rgb.kind, None));
        // Facts know nothing of the others.
        let is_plain = |role: &Role| !matches!(role, Role::Scalar(_) | Role::Place | Role::Field | Role::Lit);
        layout.attributes.retain(|attribute| is_plain(&attribute.role));
        Self { decoder: Decoder::new(layout, grid, full, 0.0, None), sampling: Sampling::of(points) }
    }

    /// Returns facts about the points of some records, and the records of those that stand for all.
    pub fn look(&self, records: &[u8]) -> (Facts, Vec<u8>) {
        let cloud = self.decoder.cloud(records);
        let each = records.chunks_exact(self.decoder.stride().max(1) as usize).zip(&cloud.positions);
        let taken = each.filter(|(_, position)| self.sampling.takes(**position));
        (Facts::of(&cloud), taken.flat_map(|(record, _)| record).copied().collect())
    }

    /// Returns the number of bytes of the points that stand for all, at most: with more of them a store has no survey.
    pub fn most_bytes(&self) -> u64 {
        MAX_POINTS as u64 * self.decoder.stride()
    }
}

/// Returns the bytes of the file before the records of the points that stand for all.
///
/// # Errors
/// The facts are no JSON.
pub(crate) fn head(facts: &Facts) -> Result<Vec<u8>, serde_json::Error> {
    let json = serde_json::to_vec(facts)?;
    Ok([&MAGIC[..], &(json.len() as u32).to_le_bytes(), &json].concat())
}

/// Reads the file of a store, if it is there.
///
/// # Errors
/// Returns an error if the survey can't be read, or can't be of this store.
pub(super) fn read(octree: &Octree) -> Result<Option<StoreSurvey>, Error> {
    let folder: &Path = &octree.summary.path;
    if !octree.is_ours || !folder.join(SURVEY).exists() {
        return Ok(None);
    }
    let refused = |cause: &str| Error::malformed(folder, SURVEY, cause);
    let file = SharedFile::open(&folder.join(SURVEY))?;
    let stride = octree.decoder.stride().max(1);
    if file.len() > (MAX_FACTS + MAX_POINTS * stride as usize) as u64 {
        return Err(refused("it has more bytes than any survey"));
    }
    let bytes = file.read(0, file.len())?;
    let rest =
        bytes.strip_prefix(&MAGIC).ok_or_else(|| refused("its first bytes are not those of a file of this version"))?;
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
        return Err(refused("it was made from other points than those of octree.bin"));
    }
    if !(records.len() as u64).is_multiple_of(stride) {
        return Err(refused("it ends within a point"));
    }
    let decoded = octree.decoder.cloud(records);
    let decoded = splats_of(&decoded).map(|splats| decoded.subset(&splats)).unwrap_or(decoded);
    let crs = octree.summary.like.crs.clone();
    let sample = Cloud { up: octree.summary.up, filter: octree.summary.like.filter, crs, ..decoded };
    if sample.bounds().is_some_and(|bounds| !all.holds(&bounds)) {
        return Err(refused("it has points outside the octree"));
    }
    Ok(Some(StoreSurvey { facts, sample }))
}
