//! Clouds in nodes that are read one by one: octrees, tiles, and plain files in pieces. What a scan is too large for, a
//! node is not.

/// Methods of a store with the fields `summary` and `nodes`.
macro_rules! known {
    () => {
        fn summary(&self) -> &$crate::store::Summary {
            &self.summary
        }

        fn nodes(&self) -> &[$crate::store::Node] {
            &self.nodes
        }
    };
}

pub mod build;
mod copc;
mod ept;
mod fitted;
mod grid;
mod held;
mod keys;
mod las;
mod octree;
mod open;
mod photo;
mod ply;
mod tiles;
mod whole;

use std::fmt::Debug;
use std::path::PathBuf;

use super::Error;
pub use copc::Copc;
pub use ept::Ept;
pub use grid::Grid;
pub use held::MemoryStore;
pub use las::LasPieces;
pub use octree::Octree;
pub use open::{announced, has_levels, is_folder, open};
use pellucid_core::cloud::facts::Facts;
use pellucid_core::cloud::{Bounds, Cloud, UpAxis};
pub use ply::PlyPieces;
pub use tiles::Tiles;
pub use whole::whole;

/// Files of an octree.
pub const OCTREE_FILES: [&str; 5] =
    [octree::metadata::METADATA, octree::HIERARCHY, octree::POINTS, octree::nodes::NODES, octree::survey::SURVEY];

/// Files and folders of a folder that is a store.
pub(crate) const FILES: [&str; 8] = {
    let [metadata, hierarchy, points, nodes, survey] = OCTREE_FILES;
    [metadata, hierarchy, points, nodes, survey, "ept.json", "ept-data", "ept-hierarchy"]
};

/// Points of a node of a file in pieces, if the file has so many.
const PIECE: u64 = 500_000;

/// A cloud whose nodes are read one by one, by any number of threads at once.
pub trait Store: Debug + Send + Sync {
    /// Returns what is known of the whole cloud.
    fn summary(&self) -> &Summary;

    /// The nodes, parents before their children. Each point of the cloud is in one of them.
    fn nodes(&self) -> &[Node];

    /// Reads the points of a node: as many as it says, all within its bounds. Splats that are none and withheld points
    /// are left out.
    ///
    /// # Errors
    /// The node can't be read, is damaged, or isn't as [`Self::nodes`] describes it.
    fn read(&self, node: usize) -> Result<Piece, Error>;

    /// Returns what follows from all points, if the store has it.
    ///
    /// # Errors
    /// Returns an error if the survey can't be read, or is that of another store.
    fn survey(&self) -> Result<Option<StoreSurvey>, Error> {
        Ok(None)
    }
}

/// Facts that follow from all points of a cloud.
#[derive(Debug, Clone, PartialEq)]
pub struct StoreSurvey {
    /// Facts about all points.
    pub facts: Facts,
    /// The points that stand for all ([`Sampling`](pellucid_core::cloud::sampling::Sampling)), in any order.
    pub sample: Cloud,
}

/// Facts about a cloud in nodes, known before any of them is read.
#[derive(Debug, Clone, PartialEq)]
pub struct Summary {
    /// The file or folder.
    pub path: PathBuf,
    /// The number of points.
    pub points: u64,
    /// A box around all points, in the file's units.
    pub bounds: Bounds,
    /// The vertical of the cloud.
    pub up: UpAxis,
    /// Least and largest value of a scalar column, by its name, where the store knows them.
    pub ranges: Vec<(String, [f64; 2])>,
    /// The grid that all positions lie on, where the store has one.
    pub grid: Option<Grid>,
    /// A cloud without points but with everything else that the nodes have in common: the (empty) columns that each of
    /// them has, how it was prepared, and warnings.
    pub like: Cloud,
}

/// A part of a cloud.
#[derive(Debug, Clone, PartialEq)]
pub struct Node {
    /// 0 for a root and in stores without levels. A node's points are about half as far apart as those of its parent.
    pub level: u32,
    /// The node above, whose bounds hold this one's; `None` of a root.
    pub parent: Option<u32>,
    /// A box around its own points and those of the nodes below, in the file's units.
    pub bounds: Bounds,
    /// Number of its own points.
    pub points: u64,
    /// Bytes that are read for them.
    pub bytes: u64,
    /// The typical distance of its points and those of the levels above, in the file's units; 0 if the store has no
    /// levels.
    pub spacing: f64,
    /// The largest radius of its own points, of Gaussians how far they reach, in the file's units, where the store
    /// knows it.
    pub largest_radius: Option<f32>,
}

/// The points of a node.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Piece {
    /// Points that were read, with columns as in [`Summary::like`].
    pub cloud: Cloud,
    /// Place of each point among all points of the cloud's source, which tells points apart that are alike.
    pub places: Vec<u64>,
}
