//! Binary PLY files as nodes of consecutive points.

use std::ops::Range;
use std::path::Path;

use glam::DVec3;

use super::{Node, PIECE, Piece, Store, Summary};
use crate::columns::{PointTable, TableFacts};
use crate::ply::{VertexRows, Vertices, is_prepared, stated, step, vertical};
use crate::{Error, InputFile};
use pellucid_core::cloud::{Bounds, Cloud};
use pellucid_core::progress::Progress;

/// A binary PLY file whose vertices have no lists, in pieces of half a million consecutive points each.
///
/// Opening it reads all of it once, since such a file says nothing of its points: for the boxes of the nodes, the
/// vertical, and what decides about whole columns. Nothing of that pass is kept in memory but up to 260,000 positions
/// while it runs.
#[derive(Debug)]
pub struct PlyPieces {
    rows: VertexRows,
    whole: TableFacts,
    /// The rows of each node.
    pieces: Vec<Range<u64>>,
    nodes: Vec<Node>,
    pub(super) summary: Summary,
}

impl PlyPieces {
    /// Opens a file with points.
    ///
    /// # Errors
    /// Returns the errors of [`io::load`](crate::load), and an error for a file that has to be read as a whole: text,
    /// vertices with lists, Gaussian splats, or points that `pellucid prepare` wrote.
    pub fn open(path: &Path) -> Result<Self, Error> {
        let mut source = InputFile::open(path)?;
        let start = source.peek()?;
        if !start.starts_with(b"ply") {
            return Err(source.malformed("byte 0", "this is not a PLY file"));
        }
        match Self::new(source)? {
            Some(pieces) => Ok(pieces),
            None => Err(Error::Malformed {
                path: path.to_path_buf(),
                place: "header".to_owned(),
                cause: "text, lists, splats and prepared points can only be read as a whole".to_owned(),
            }),
        }
    }

    /// Returns the pieces of a PLY file; `None` if it has to be read as a whole.
    pub(super) fn new(source: InputFile) -> Result<Option<Self>, Error> {
        let (Vertices::Rows(rows), remarks) = Vertices::find(source)? else { return Ok(None) };
        if is_prepared(&remarks.comments) {
            return Ok(None);
        }
        let mut survey = PlySurvey::new(&rows);
        let (mut pieces, mut nodes) = (Vec::new(), Vec::new());
        for start in (0..rows.count).step_by(PIECE as usize) {
            let piece = start..rows.count.min(start + PIECE);
            if let Some(node) = survey.node(&rows, piece.clone())? {
                pieces.push(piece);
                nodes.push(node);
            }
        }
        let Some(bounds) = nodes.iter().map(|node| node.bounds).reduce(Bounds::union) else {
            return Err(Error::NoPoints { path: rows.file.path().to_path_buf(), non_finite: survey.non_finite });
        };
        let mut warnings: Vec<String> = remarks.missing.into_iter().collect();
        let (up, up_reason) = match stated(&remarks.comments) {
            Ok(Some(up)) => (up, None),
            Ok(None) => vertical(&bounds, &survey.sample),
            Err(warning) => {
                warnings.push(warning);
                vertical(&bounds, &survey.sample)
            }
        };
        let like = PointTable::new(&rows.layout, 0).finish(&rows.layout, &survey.whole);
        let like = Cloud { up, up_reason, non_finite: survey.non_finite, warnings, ..like };
        let points = nodes.iter().map(|node| node.points).sum();
        let path = rows.file.path().to_path_buf();
        let summary = Summary { path, points, bounds, up, ranges: Vec::new(), grid: None, like };
        Ok(Some(Self { whole: survey.whole, pieces, nodes, summary, rows: *rows }))
    }
}

impl Store for PlyPieces {
    known!();

    fn read(&self, node: usize) -> Result<Piece, Error> {
        let rows = self.pieces[node].clone();
        let (table, left_out) = self.rows.parse(rows.clone(), &Progress::hidden())?;
        let (whole, known) = (table.whole(&self.rows.layout), &self.nodes[node]);
        let cloud = table.finish(&self.rows.layout, &self.whole);
        let Summary { up, like, .. } = &self.summary;
        let cloud = Cloud { up: *up, up_reason: like.up_reason, ..cloud };
        let fits = cloud.len() as u64 == known.points && cloud.bounds() == Some(known.bounds);
        if !fits || self.whole.and(whole) != self.whole {
            let cause = "the file changed after it was opened";
            return Err(self.rows.file.malformed(format!("vertices {}–{}", rows.start, rows.end - 1), cause));
        }
        let mut left_out = left_out.into_iter().peekable();
        let places = rows.filter(|row| left_out.next_if_eq(row).is_none()).collect();
        Ok(Piece { cloud, places })
    }
}

/// Facts that all points tell together.
struct PlySurvey {
    whole: TableFacts,
    non_finite: usize,
    /// Finite points so far.
    points: usize,
    /// Every `step`th of them, for the vertical.
    sample: Vec<DVec3>,
    step: usize,
}

impl PlySurvey {
    fn new(rows: &VertexRows) -> Self {
        Self { whole: TableFacts::NONE, non_finite: 0, points: 0, sample: Vec::new(), step: step(rows.count) }
    }

    /// Adds some rows; the node of them, or nothing if none of their points is finite.
    fn node(&mut self, rows: &VertexRows, piece: Range<u64>) -> Result<Option<Node>, Error> {
        let (table, left_out) = rows.parse(piece.clone(), &Progress::hidden())?;
        self.whole = self.whole.and(table.whole(&rows.layout));
        self.non_finite += left_out.len();
        let points = table.cloud;
        let first = self.points.next_multiple_of(self.step) - self.points;
        self.sample.extend(points.positions.iter().skip(first).step_by(self.step));
        self.points += points.len();
        let largest = |radii: &Vec<f32>| radii.iter().copied().fold(0.0, f32::max);
        Ok(points.bounds().map(|bounds| Node {
            level: 0,
            parent: None,
            bounds,
            points: points.len() as u64,
            bytes: (piece.end - piece.start) * rows.row_len,
            spacing: 0.0,
            largest_radius: points.radii.as_ref().map(largest),
        }))
    }
}
