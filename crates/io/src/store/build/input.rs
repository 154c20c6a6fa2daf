//! All inputs of a build as one cloud, read a batch of nodes at a time.

use glam::DVec3;

use super::super::fitted::fitted;
use super::super::{Grid, Piece, Store};
use super::columns;
use crate::Error;
use pellucid_core::cloud::{Bounds, Cloud};
use pellucid_core::parallel;
use pellucid_core::progress::Progress;

/// The inputs.
#[derive(Debug)]
pub(super) struct Input<'a> {
    stores: &'a [Box<dyn Store>],
    /// Number of points in the stores before each store.
    firsts: Vec<u64>,
    /// A cloud without points that has the columns of all.
    pub like: Cloud,
    pub notes: Vec<String>,
    pub points: u64,
    pub bounds: Bounds,
}

impl<'a> Input<'a> {
    /// `None` without stores.
    pub fn new(stores: &'a [Box<dyn Store>]) -> Option<Self> {
        let (like, notes) = columns::union(stores);
        let mut points = 0_u64;
        let mut firsts = Vec::with_capacity(stores.len());
        for store in stores {
            firsts.push(points);
            points = points.saturating_add(store.summary().points);
        }
        let bounds = stores.iter().map(|store| store.summary().bounds).reduce(Bounds::union)?;
        Some(Self { stores, firsts, like, notes, points, bounds })
    }

    /// Reads everything in batches of about so many points, on all cores. What `see` makes of the pieces is handed to
    /// `take` in order. The error of `see` is a position outside the bounds.
    pub fn each<T: Send>(
        &self,
        batch_points: u64,
        progress: &Progress,
        see: impl Fn(Piece) -> Result<T, DVec3> + Sync,
        mut take: impl FnMut(T) -> Result<(), Error>,
    ) -> Result<(), Error> {
        progress.reset();
        progress.set_length(self.points);
        let nodes =
            self.stores.iter().enumerate().flat_map(|(store, of)| (0..of.nodes().len()).map(move |node| (store, node)));
        let mut batch = Vec::new();
        let mut points = 0;
        let mut nodes = nodes.filter(|(store, node)| self.stores[*store].nodes()[*node].points > 0).peekable();
        while let Some((store, node)) = nodes.next() {
            batch.push((store, node));
            points += self.stores[store].nodes()[node].points;
            if points < batch_points && nodes.peek().is_some() {
                continue;
            }
            progress.check().map_err(|_| self.cancelled())?;
            let seen: Vec<T> = parallel::try_map_each(&batch, |(store, node)| {
                let seen = self
                    .read(*store, *node)
                    .and_then(|piece| see(piece).map_err(|outside| self.error(*store, outside)));
                progress.inc(self.stores[*store].nodes()[*node].points);
                seen
            })?;
            seen.into_iter().try_for_each(&mut take)?;
            batch.clear();
            points = 0;
        }
        Ok(())
    }

    /// Returns the grid that all inputs are on.
    pub fn shared_grid(&self) -> Option<Grid> {
        let grids: Vec<Option<Grid>> = self.stores.iter().map(|store| store.summary().grid).collect();
        Grid::shared(&grids, &self.bounds)
    }

    /// A piece with the columns of all, and places among all points.
    fn read(&self, store: usize, node: usize) -> Result<Piece, Error> {
        let Piece { cloud, mut places } = self.stores[store].read(node)?;
        places.iter_mut().for_each(|place| *place = place.saturating_add(self.firsts[store]));
        Ok(Piece { cloud: fitted(cloud, &self.like), places })
    }

    fn error(&self, store: usize, position: DVec3) -> Error {
        let Bounds { min, max } = self.bounds;
        let cause = format!("it lies outside the box that was announced, from {min} to {max}");
        Error::malformed(&self.stores[store].summary().path, format!("point at {position}"), cause)
    }

    /// Returns the error of a build that somebody ended.
    pub fn cancelled(&self) -> Error {
        Error::Cancelled { path: self.stores.first().map(|store| store.summary().path.clone()).unwrap_or_default() }
    }
}
