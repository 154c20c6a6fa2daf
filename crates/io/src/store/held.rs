//! A cloud in memory as a store of nodes: what small files and tests have.

use std::path::Path;

use super::{Node, Piece, Store, Summary};
use crate::Error;
use pellucid_core::cloud::Cloud;
use pellucid_core::cloud::field::range;
use pellucid_core::cloud::gaussians::reach;

/// A cloud in memory.
#[derive(Debug, Clone)]
pub struct MemoryStore {
    summary: Summary,
    nodes: Vec<Node>,
    cloud: Cloud,
}

impl MemoryStore {
    /// Returns a cloud with points, as one node.
    ///
    /// # Errors
    /// No points.
    pub fn new(path: &Path, cloud: Cloud) -> Result<Self, Error> {
        let Some(bounds) = cloud.bounds() else {
            return Err(Error::NoPoints { path: path.to_path_buf(), non_finite: cloud.non_finite });
        };
        let points = cloud.len() as u64;
        let like = cloud.subset(&[]);
        let range = |(name, values): &(String, Vec<f32>)| {
            let [least, most] = range(values.iter().map(|value| f64::from(*value)));
            (least <= most).then(|| (name.clone(), [least, most]))
        };
        let ranges = cloud.scalars.iter().filter_map(range).collect();
        let summary = Summary { path: path.to_path_buf(), points, bounds, up: cloud.up, ranges, grid: None, like };
        let node =
            Node { level: 0, parent: None, bounds, points, bytes: 0, spacing: 0.0, largest_radius: largest(&cloud) };
        Ok(Self { summary, nodes: vec![node], cloud })
    }
}

impl Store for MemoryStore {
    known!();

    fn read(&self, _node: usize) -> Result<Piece, Error> {
        Ok(Piece { cloud: self.cloud.clone(), places: (0..self.summary.points).collect() })
    }
}

fn largest(cloud: &Cloud) -> Option<f32> {
    let radii = cloud.radii.as_ref().map(|radii| radii.iter().copied().fold(0.0, f32::max));
    let splats = cloud.gaussians.as_ref();
    let reaches = splats.map(|splats| splats.extents.iter().map(|extents| reach(*extents)).fold(0.0, f32::max));
    [radii, reaches].into_iter().flatten().reduce(f32::max)
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    #[test]
    fn a_cloud_is_one_node() {
        let scalars = vec![("echo".to_owned(), vec![2.0, f32::NAN, -1.0])];
        let cloud = Cloud { positions: [0.0, 1.0, 2.0].map(DVec3::splat).to_vec(), scalars, ..Cloud::default() };
        let store = MemoryStore::new(Path::new("here"), cloud.clone()).unwrap();
        assert_eq!((store.summary().points, store.nodes().len()), (3, 1));
        assert_eq!(store.summary().ranges, [("echo".to_owned(), [-1.0, 2.0])]);
        assert!(store.summary().like.is_empty());
        let piece = store.read(0).unwrap();
        assert_eq!((piece.cloud.positions, piece.places), (cloud.positions, vec![0, 1, 2]));
        assert!(matches!(MemoryStore::new(Path::new("here"), Cloud::default()), Err(Error::NoPoints { .. })));
    }
}
