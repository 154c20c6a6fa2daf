//! The points of a store in a part of space.

use glam::{DVec3, Vec3};

use super::super::morton;
use crate::cache::Cache;
use pellucid_core::cloud::{Bounds, Cloud};
use pellucid_core::parallel;
use pellucid_io::Error;
use pellucid_io::store::{Node, Octree, Store};

/// A store whose points are looked at region by region.
#[derive(Debug)]
pub(super) struct RegionStore {
    pub octree: Octree,
    pub bounds: Bounds,
    /// A distance within which all points are that share a Morton cell of the whole cloud.
    pub cell: f64,
    /// Nodes that were read last: neighbors of points that are looked at one by one are in the same few.
    held: Cache<Columns>,
}

/// Columns of a node's points.
#[derive(Debug)]
struct Columns {
    positions: Vec<DVec3>,
    normals: Option<Vec<Vec3>>,
}

impl Columns {
    fn bytes(&self) -> u64 {
        (size_of_val(&*self.positions) + self.normals.as_ref().map_or(0, |normals| size_of_val(&**normals))) as u64
    }
}

/// Some points of a store.
#[derive(Debug, Default)]
pub(super) struct Local {
    pub positions: Vec<DVec3>,
    /// Normals, if the cloud has them.
    pub normals: Option<Vec<Vec3>>,
    /// Number of points before each point in the store's file.
    pub places: Vec<u64>,
}

/// A part of space.
#[derive(Debug)]
pub(super) enum SpaceRegion {
    /// Box with its faces.
    Box(Bounds),
    /// Balls by center and radius.
    Balls(Vec<(DVec3, f64)>),
}

impl SpaceRegion {
    fn holds(&self, p: DVec3) -> bool {
        match self {
            Self::Box(bounds) => (p.cmpge(bounds.min) & p.cmple(bounds.max)).all(),
            Self::Balls(balls) => balls.iter().any(|(center, radius)| center.distance(p) <= *radius),
        }
    }

    fn touches(&self, part: &Bounds) -> bool {
        match self {
            Self::Box(bounds) => (part.max.cmpge(bounds.min) & part.min.cmple(bounds.max)).all(),
            Self::Balls(balls) => balls.iter().any(|ball| reaches(*ball, part)),
        }
    }

    /// Returns the same for a part of space: fewer balls, of which there may be thousands.
    fn within(&self, part: &Bounds) -> Self {
        match self {
            Self::Box(bounds) => Self::Box(*bounds),
            Self::Balls(balls) => Self::Balls(balls.iter().copied().filter(|ball| reaches(*ball, part)).collect()),
        }
    }
}

fn reaches((center, radius): (DVec3, f64), part: &Bounds) -> bool {
    center.clamp(part.min, part.max).distance(center) <= radius
}

impl RegionStore {
    /// Looks at a store, of which nodes are held in so many bytes of memory.
    pub fn new(octree: Octree, memory: u64) -> Self {
        let bounds = octree.summary().bounds;
        // The diagonal of a cube, and what is rounded.
        let cell = 1.75 * morton::cell_side(&bounds);
        Self { octree, bounds, cell, held: Cache::new(memory, Columns::bytes) }
    }

    /// Returns the points of a part of space, in the order of the file's nodes.
    pub fn gather(&self, shape: &SpaceRegion) -> Result<Local, Error> {
        let nodes = self.octree.nodes().iter().enumerate();
        let touched: Vec<usize> =
            nodes.filter(|(_, node)| node.points > 0 && shape.touches(&node.bounds)).map(|(at, _)| at).collect();
        let parts = parallel::try_map_each(&touched, |node| self.part(*node, shape))?;
        let has_normals = self.octree.summary().like.normals.is_some();
        let mut all = Local { normals: has_normals.then(Vec::new), ..Local::default() };
        for part in parts {
            all.positions.extend(part.positions);
            all.places.extend(part.places);
            if let (Some(all), Some(normals)) = (&mut all.normals, part.normals) {
                all.extend(normals);
            }
        }
        Ok(all)
    }

    fn part(&self, node: usize, shape: &SpaceRegion) -> Result<Local, Error> {
        let read = || -> Result<_, Error> {
            let Cloud { positions, normals, .. } = self.octree.read(node)?.cloud;
            Ok(Columns { positions, normals })
        };
        let columns = self.held.get(node, read)?;
        let Columns { positions, normals } = &*columns;
        // Their own box: points of a file may lie beside that of their node.
        let Some(bounds) = Bounds::of(positions) else { return Ok(Local::default()) };
        let shape = shape.within(&bounds);
        let inside: Vec<usize> = (0..positions.len()).filter(|i| shape.holds(positions[*i])).collect();
        let first = self.octree.first_point(node);
        Ok(Local {
            positions: inside.iter().map(|i| positions[*i]).collect(),
            normals: normals.as_ref().map(|normals| inside.iter().map(|i| normals[*i]).collect()),
            places: inside.iter().map(|i| first + *i as u64).collect(),
        })
    }

    /// Returns a distance from a position within which there are so many points, or all, by the boxes of nodes alone.
    pub fn reach(&self, from: DVec3, points: u64) -> f64 {
        let farthest = |node: &Node| (node.bounds.max - from).abs().max((node.bounds.min - from).abs()).length();
        let nodes = self.octree.nodes().iter().filter(|node| node.points > 0);
        let mut nodes: Vec<(f64, u64)> = nodes.map(|node| (farthest(node), node.points)).collect();
        nodes.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        let mut there = 0_u64;
        let within = nodes.iter().find(|(_, own)| {
            there += own;
            there >= points
        });
        within.or(nodes.last()).map_or(0.0, |(distance, _)| *distance)
    }
}
