//! Plain LAS and LAZ files as nodes of consecutive points.

use std::ops::Range;
use std::path::Path;

use super::{Node, PIECE, Piece, Store, Summary};
use crate::las::{Chunk, Columns, LasFile, Traits};
use crate::{Error, InputFile, LasColumns};
use pellucid_core::cloud::{Bounds, Cloud};
use pellucid_core::parallel;
use pellucid_core::progress::Progress;

/// A LAS or LAZ file, in pieces of about half a million consecutive points each.
///
/// Opening it decodes chunks from the start of the file until what decides about whole columns is known: the first
/// pieces where colors have 16 bits and pulses several returns, the whole file where colors have fewer, where every
/// pulse has one return, where GPS times are asked for, or where points lie outside of the header's box. Nothing of
/// that pass is kept in memory.
///
/// A node's box is that of its points if the pass came so far, else the header's. The points of an old LAZ file
/// without chunks are one node.
#[derive(Debug)]
pub struct LasPieces {
    file: LasFile,
    traits: Traits,
    pieces: Vec<Range<usize>>,
    nodes: Vec<Node>,
    pub(super) summary: Summary,
}

impl LasPieces {
    /// Opens a file with points. Of the columns that are read only where they are asked for, it has these.
    ///
    /// # Errors
    /// Returns the errors of [`io::load`](crate::load) that show before the points are read, and an error if the
    /// header makes coordinates infinite.
    pub fn open(path: &Path, asked: LasColumns) -> Result<Self, Error> {
        Self::new(LasFile::open(InputFile::open(path)?, asked)?)
    }

    pub(super) fn new(file: LasFile) -> Result<Self, Error> {
        check_finite(&file)?;
        let pieces = pieces(&file.chunks);
        let claimed = file.header.claimed_bounds();
        let is_fine = |bounds: &Bounds| claimed.is_some_and(|claimed| claimed.holds(bounds));
        let survey = LasSurvey::of(&file, file.chunks.iter(), Some(&is_fine))?;
        let boxes = &survey.boxes;
        let whole = boxes.iter().copied().reduce(Bounds::union);
        let bounds = if boxes.len() == file.chunks.len() { whole } else { claimed };
        let Some(bounds) = bounds else { return Err(no_points(&file)) };
        let node = |piece: &Range<usize>| {
            let chunks = &file.chunks[piece.clone()];
            let seen = boxes.get(piece.clone()).and_then(|boxes| boxes.iter().copied().reduce(Bounds::union));
            Node {
                level: 0,
                parent: None,
                bounds: seen.unwrap_or(bounds),
                points: chunks.iter().map(|chunk| chunk.points).sum(),
                bytes: chunks.iter().map(|chunk| chunk.bytes).sum(),
                spacing: 0.0,
                largest_radius: None,
            }
        };
        let nodes = pieces.iter().map(node).collect();
        let summary = summary(&file, &survey.traits, bounds);
        Ok(Self { traits: survey.traits, pieces, nodes, summary, file })
    }
}

impl Store for LasPieces {
    known!();

    fn read(&self, node: usize) -> Result<Piece, Error> {
        let chunks = &self.file.chunks[self.pieces[node].clone()];
        read(&self.file, chunks, &self.traits, &self.nodes[node].bounds)
    }
}

/// Runs of chunks with about [`PIECE`] points each: a chunk of a LAZ file is never cut.
fn pieces(chunks: &[Chunk]) -> Vec<Range<usize>> {
    let mut pieces = Vec::new();
    let (mut start, mut points) = (0, 0);
    for (at, chunk) in chunks.iter().enumerate() {
        points += chunk.points;
        if points >= PIECE || at + 1 == chunks.len() {
            pieces.push(start..at + 1);
            (start, points) = (at + 1, 0);
        }
    }
    pieces
}

/// Returns what is known of the whole of a file.
pub(super) fn summary(file: &LasFile, traits: &Traits, bounds: Bounds) -> Summary {
    let like = file.finish(Columns::new(&file.header, file.asked), traits);
    let like = Cloud { warnings: file.header.warnings.clone(), ..like };
    let path = file.file.path().to_path_buf();
    Summary { path, points: file.header.count, bounds, up: like.up, ranges: Vec::new(), grid: Some(file.grid()), like }
}

/// Returns the points of some chunks, which should lie in a box.
pub(super) fn read(file: &LasFile, chunks: &[Chunk], traits: &Traits, bounds: &Bounds) -> Result<Piece, Error> {
    let decode = |chunk: &Chunk| {
        let columns = file.decode(chunk, &Progress::hidden())?;
        check_box(file, chunk, &columns, bounds)?;
        let places: Vec<u64> = columns.places(chunk.first_point).collect();
        Ok((columns, places))
    };
    let (parts, places): (Vec<_>, Vec<_>) = parallel::try_map_each(chunks, decode)?.into_iter().unzip();
    let cloud = Columns::join(parts).map(|columns| file.finish(columns, traits)).unwrap_or_default();
    Ok(Piece { cloud, places: places.concat() })
}

fn check_box(file: &LasFile, chunk: &Chunk, columns: &Columns, bounds: &Bounds) -> Result<(), Error> {
    match columns.bounds() {
        Some(found) if !bounds.holds(&found) => {
            let (first, last) = (chunk.first_point, chunk.first_point + chunk.points - 1);
            let cause = format!(
                "they extend from {} to {}, but their box from {} to {}; repair it with `lasinfo -repair_bb` or `pdal \
                 translate`",
                found.min, found.max, bounds.min, bounds.max
            );
            Err(file.file.malformed(format!("points {first}–{last}"), cause))
        }
        _ => Ok(()),
    }
}

/// A file whose coordinates are all finite, so that no point is left out, and each has its place.
pub(super) fn check_finite(file: &LasFile) -> Result<(), Error> {
    if file.header.is_finite() {
        return Ok(());
    }
    Err(file.file.malformed("LAS header", "its scales or offsets make coordinates infinite"))
}

pub(super) fn no_points(file: &LasFile) -> Error {
    Error::NoPoints { path: file.file.path().to_path_buf(), non_finite: 0 }
}

/// Chunks that are decoded side by side at most.
const MOST_AT_A_TIME: usize = 64;

/// Facts that decide about the columns of a file, from as many of its chunks as that takes.
pub(super) struct LasSurvey {
    pub traits: Traits,
    /// The boxes of the points of the chunks that were decoded for it, in their order, if they are asked for.
    pub boxes: Vec<Bounds>,
}

impl LasSurvey {
    /// Decodes chunks in this order until nothing in the others can matter. `is_fine`, if it is there, says of the box
    /// of a chunk's points whether it is what it should be; where it isn't, all chunks are decoded.
    pub fn of<'a>(
        file: &LasFile,
        chunks: impl Iterator<Item = &'a Chunk>,
        is_fine: Option<&dyn Fn(&Bounds) -> bool>,
    ) -> Result<Self, Error> {
        let mut survey = Self { traits: Traits::NONE, boxes: Vec::new() };
        let (boxes, mut fine, mut done) = (is_fine.is_some(), true, 0usize);
        let mut chunks = chunks.peekable();
        // One, then twice as many each time: most files need few, some all. Independent of the machine, as the nodes'
        // boxes are.
        let (format, asked) = (&file.header.format, file.asked);
        let has_times = asked.gps_time && format.has_gps_time;
        while chunks.peek().is_some() && !(fine && survey.traits.settle(format.has_color, has_times, asked.returns)) {
            let batch: Vec<&Chunk> = chunks.by_ref().take(done.clamp(1, MOST_AT_A_TIME)).collect();
            done += batch.len();
            for (traits, bounds) in parallel::try_map_each(&batch, |chunk| file.traits(chunk, boxes))? {
                survey.traits = survey.traits.and(traits);
                fine &= bounds.is_none_or(|bounds| is_fine.is_none_or(|is_fine| is_fine(&bounds)));
                survey.boxes.extend(bounds);
            }
        }
        Ok(survey)
    }
}
