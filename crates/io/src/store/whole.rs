//! Stores read as a whole, for clouds that fit the memory.

use rayon::prelude::*;

use super::{Piece, Store};
use crate::{Error, splats};
use pellucid_core::cloud::Cloud;
use pellucid_core::parallel;
use pellucid_core::progress::Progress;

/// Returns all points of a store in the order of its source, with what the store knows of all of them.
///
/// # Errors
/// Returns the errors of [`Store::read`].
pub fn whole(store: &dyn Store, progress: &Progress) -> Result<Cloud, Error> {
    let summary = store.summary();
    progress.set_length(summary.points);
    let read = |node: &usize| {
        let piece = store.read(*node)?;
        progress.inc(piece.cloud.len() as u64);
        Ok(piece)
    };
    let nodes: Vec<usize> = (0..store.nodes().len()).collect();
    let pieces = parallel::try_map_each::<_, Piece, Error>(&nodes, read)?;
    let (mut cloud, mut places) = (summary.like.clone(), Vec::new());
    for piece in pieces {
        cloud.append(piece.cloud);
        places.extend(piece.places);
    }
    let left_out = summary.points.saturating_sub((places.len() + cloud.withheld) as u64);
    if left_out > 0 {
        cloud.warnings.push(splats::left_out(left_out));
    }
    if places.is_sorted() {
        return Ok(cloud);
    }
    let mut order: Vec<u32> = (0..places.len() as u32).collect();
    order.par_sort_unstable_by_key(|at| places[*at as usize]);
    Ok(cloud.subset(&order))
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;

    use glam::DVec3;

    use super::*;
    use crate::store::{Node, Summary};
    use pellucid_core::cloud::{Bounds, UpAxis};

    /// Every third point in a node of its own.
    #[derive(Debug)]
    struct Thirds(Summary, Vec<Node>);

    impl Store for Thirds {
        fn summary(&self) -> &Summary {
            &self.0
        }

        fn nodes(&self) -> &[Node] {
            &self.1
        }

        fn read(&self, node: usize) -> Result<Piece, Error> {
            let places: Vec<u64> = (node as u64..10).step_by(3).collect();
            let positions = places.iter().map(|place| DVec3::splat(*place as f64)).collect();
            Ok(Piece { cloud: Cloud { positions, up: UpAxis::Z, ..Cloud::default() }, places })
        }
    }

    #[test]
    fn points_come_in_the_order_of_their_source() {
        let bounds = Bounds { min: DVec3::ZERO, max: DVec3::splat(9.0) };
        let node =
            |points| Node { level: 0, parent: None, bounds, points, bytes: 0, spacing: 0.0, largest_radius: None };
        let like = Cloud { up: UpAxis::Z, warnings: vec!["odd".to_owned()], ..Cloud::default() };
        let summary =
            Summary { path: PathBuf::new(), points: 10, bounds, up: UpAxis::Z, ranges: Vec::new(), grid: None, like };
        let cloud = whole(&Thirds(summary, vec![node(4), node(3), node(3)]), &Progress::hidden()).unwrap();
        assert_eq!(cloud.positions, (0..10).map(|i| DVec3::splat(f64::from(i))).collect::<Vec<_>>());
        assert_eq!((cloud.up, cloud.warnings), (UpAxis::Z, vec!["odd".to_owned()]));
    }
}
