//! nodes.bin: what Potree's hierarchy has no room for, the box and the largest radius of each node's points.

use serde::{Deserialize, Serialize};

use super::integers;
use crate::number::{float, long};
use crate::store::Grid;
use pellucid_core::cloud::Bounds;

/// The file's name.
pub(crate) const NODES: &str = "nodes.bin";

/// First bytes of the file, the last one of which is the version.
const MAGIC: [u8; 8] = *b"pellucd\x01";

/// Bytes of a node: the first of its points in octree.bin (u64), the largest radius, of Gaussians how
/// far they reach (f32, NaN without either), the corners of its box
/// on the grid (6 i32).
const RECORD: usize = 36;

/// A node with points.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(crate) struct NodeExtent {
    /// First byte of its points in octree.bin.
    pub offset: u64,
    /// The largest radius of its points, if they have radii; of Gaussians how far they reach.
    pub largest_radius: Option<f32>,
    /// Least and largest integers of its points.
    pub corners: [[i32; 3]; 2],
}

impl NodeExtent {
    /// Returns the box of its points.
    pub fn bounds(&self, grid: &Grid) -> Bounds {
        let [min, max] = self.corners.map(|corner| grid.position(corner));
        Bounds { min, max }
    }

    fn read(bytes: &[u8]) -> Result<Self, String> {
        let (offset, radius) = (long(bytes, 0), float(bytes, 8) as f32);
        let corners @ [least, most] = [integers(&bytes[12..]), integers(&bytes[24..])];
        if (0..3).any(|axis| least[axis] > most[axis]) {
            return Err(format!("there is no box from {least:?} to {most:?}"));
        }
        if radius < 0.0 || radius.is_infinite() {
            return Err(format!("the largest radius can't be {radius}"));
        }
        Ok(Self { offset, largest_radius: Some(radius).filter(|radius| !radius.is_nan()), corners })
    }
}

/// Returns the bytes of the file, for nodes in the order of their bytes.
pub(crate) fn write(extents: &[NodeExtent]) -> Vec<u8> {
    let mut bytes = MAGIC.to_vec();
    for extent in extents {
        bytes.extend(extent.offset.to_le_bytes());
        bytes.extend(extent.largest_radius.unwrap_or(f32::NAN).to_le_bytes());
        bytes.extend(extent.corners.iter().flatten().flat_map(|x| x.to_le_bytes()));
    }
    bytes
}

/// Returns the nodes of the file, in the order of their bytes; or what is wrong, with its place.
pub(crate) fn read(bytes: &[u8]) -> Result<Vec<NodeExtent>, (String, String)> {
    let Some(records) = bytes.strip_prefix(&MAGIC) else {
        return Err((NODES.to_owned(), "its first bytes are not those of a file of this version".to_owned()));
    };
    if records.len() % RECORD != 0 {
        return Err((
            NODES.to_owned(),
            format!("{} bytes are not a multiple of the {RECORD} bytes of a record", records.len()),
        ));
    }
    let read = |(index, bytes)| NodeExtent::read(bytes).map_err(|cause| (format!("{NODES}: record {index}"), cause));
    let extents = records.chunks_exact(RECORD).enumerate().map(read).collect::<Result<Vec<_>, _>>()?;
    if !extents.is_sorted_by(|a, b| a.offset < b.offset) {
        return Err((NODES.to_owned(), "nodes are not in the order of their bytes".to_owned()));
    }
    Ok(extents)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nodes_are_read_back_and_inconsistent_ones_are_refused() {
        let extent =
            |offset, largest_radius| NodeExtent { offset, largest_radius, corners: [[-1, 2, 3], [4, i32::MAX, 3]] };
        let extents = [extent(0, None), extent(7, Some(0.5))];
        let bytes = write(&extents);
        assert_eq!(read(&bytes).unwrap(), extents);
        assert!(read(&bytes[..bytes.len() - 1]).is_err() && read(&bytes[1..]).is_err());
        assert!(read(&write(&[extents[1], extents[0]])).is_err());
        assert!(read(&write(&[extent(0, Some(-1.0))])).is_err());
        assert!(read(&write(&[NodeExtent { corners: [[1, 0, 0], [0, 0, 0]], ..extents[0] }])).is_err());
    }
}
