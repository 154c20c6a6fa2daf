//! Pictures as nodes of rows of pixels.

use std::ops::Range;

use super::{Node, PIECE, Piece, Store, Summary};
use crate::photo::{Photo, PlacedPicture};
use crate::{Error, InputFile};
use pellucid_core::cloud::Bounds;
use pellucid_core::parallel;
use pellucid_core::progress::Progress;

/// A picture, in pieces of about half a million pixels. The decoded picture and its height map stay in memory, its
/// points don't.
///
/// Opening it makes each point once: for the boxes of the nodes, and for the numbers of their points.
#[derive(Debug)]
pub struct PhotoPieces {
    placed: PlacedPicture,
    /// The rows of each node, and the number of points before them.
    pieces: Vec<(Range<u32>, u64)>,
    nodes: Vec<Node>,
    pub(super) summary: Summary,
}

impl PhotoPieces {
    /// Decodes a picture.
    ///
    /// # Errors
    /// Returns the errors of [`io::load`](crate::load), but for want of memory for points.
    pub(super) fn new(source: InputFile, photo: &Photo) -> Result<Self, Error> {
        let path = source.path.clone();
        let placed = PlacedPicture::open(source, photo)?;
        let [width, height] = placed.size();
        let rows = (PIECE / u64::from(width)).max(1) as u32;
        let all: Vec<Range<u32>> = (0..height).step_by(rows as usize).map(|y| y..height.min(y + rows)).collect();
        let seen = parallel::gather(all.len(), |i| {
            let cloud = placed.points(all[i].clone(), 0, &Progress::hidden());
            cloud.bounds().map(|bounds| (bounds, cloud.len() as u64))
        });
        let (mut points, mut pieces, mut nodes) = (0, Vec::new(), Vec::new());
        for (rows, (bounds, count)) in all.into_iter().zip(seen).filter_map(|(rows, seen)| Some((rows, seen?))) {
            pieces.push((rows, points));
            nodes.push(Node {
                level: 0,
                parent: None,
                bounds,
                points: count,
                bytes: 0,
                spacing: 0.0,
                largest_radius: None,
            });
            points += count;
        }
        let Some(bounds) = nodes.iter().map(|node| node.bounds).reduce(Bounds::union) else {
            return Err(Error::NoPoints { path, non_finite: 0 });
        };
        let like = placed.points(0..0, 0, &Progress::hidden());
        let summary = Summary { path, points, bounds, up: like.up, ranges: Vec::new(), grid: None, like };
        Ok(Self { placed, pieces, nodes, summary })
    }
}

impl Store for PhotoPieces {
    known!();

    fn read(&self, node: usize) -> Result<Piece, Error> {
        let (rows, first) = &self.pieces[node];
        let points = self.nodes[node].points;
        let cloud = self.placed.points(rows.clone(), points as usize, &Progress::hidden());
        Ok(Piece { cloud, places: (*first..first + points).collect() })
    }
}
