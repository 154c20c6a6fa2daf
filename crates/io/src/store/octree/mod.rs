//! Octrees of Potree 2.0: folders of metadata.json, hierarchy.bin and octree.bin, as PotreeConverter 2 and `pellucid
//! prepare` write them.
//!
//! Points are uncompressed records, the position three int32 on a grid. Names of attributes that a cloud has a column
//! for:
//!
//! - position: `position`.
//! - color: `rgb`, `rgba`: of 65535, or of 255 if no channel is above; of `pellucid prepare` also `linear_red` …
//!   `linear_blue`.
//! - normal: `NormalX`, `NormalY`, `NormalZ`, or `normal`.
//! - intensity, classification, alpha, radius: the same names.
//! - scalars: all others of one number; `gps-time` counts from the first. Points that PotreeConverter's `classification
//!   flags` mark as withheld are left out.
//! - Gaussian: of `pellucid prepare`: `extents`, `rotation`, `base`, `harmonics`, and `exact_position` where the grid
//!   rounds.
//!
//! What `pellucid prepare` adds stands in an object `pellucid` of metadata.json and in nodes.bin, which Potree ignores.

pub(crate) mod about;
pub(crate) mod attributes;
mod decode;
pub(crate) mod hierarchy;
pub(crate) mod metadata;
pub(crate) mod nodes;
pub(crate) mod survey;

use std::path::Path;
use std::sync::Arc;

use glam::DVec3;

use super::keys::cut;
use super::{Node, Piece, Store, StoreSurvey, Summary};
use crate::{Error, InputFile, SharedFile};
use attributes::Role;
pub(crate) use decode::integers;
use decode::{Decoder, full_scale, not_withheld, splats_of};
use hierarchy::Listed;
use metadata::{Checked, METADATA};
use nodes::{NODES, NodeExtent};
use pellucid_core::cloud::crs::Crs;
use pellucid_core::cloud::filter::Filter;
use pellucid_core::cloud::gaussians::reach;
use pellucid_core::cloud::{Bounds, Cloud, GPS_TIME, UpAxis};

/// The file of the nodes' points.
pub(crate) const POINTS: &str = "octree.bin";
/// The file of the nodes.
pub(crate) const HIERARCHY: &str = "hierarchy.bin";

/// Points that are said to be dropped, at most.
const MOST_DROPPED: u64 = 1 << 40;

/// Share of a coordinate by which a node's box may be off.
const ROUNDING: f64 = 1e-14;

/// A folder with an octree. Threads read its nodes side by side.
#[derive(Debug)]
pub struct Octree {
    pub(super) summary: Summary,
    nodes: Vec<Node>,
    /// The first byte of each node in the file of points.
    starts: Vec<u64>,
    decoder: Decoder,
    file: SharedFile,
    /// `true` if this program wrote it.
    is_ours: bool,
}

impl Octree {
    /// Opens a folder, or the metadata.json in it. Reads everything but the points.
    ///
    /// # Errors
    /// A file is missing or can't be read; the octree is compressed or of Potree 1; what the files say contradicts
    /// itself or their sizes; nodes overlap; there are no points. Memory use follows the files' sizes, not their
    /// claims.
    pub fn open(path: &Path) -> Result<Self, Error> {
        let folder = if path.is_dir() { path } else { pellucid_core::atomic::folder(path) };
        if !folder.join(METADATA).exists() && folder.join("cloud.js").exists() {
            let cause = "an octree of Potree 1 is not supported; convert its source with PotreeConverter 2 or `pellucid prepare`";
            return Err(Error::malformed(&folder.join("cloud.js"), "format", cause));
        }
        let checked = metadata::read(&folder.join(METADATA)).map_err(|error| missing(error, folder))?;
        let file = SharedFile::open(&folder.join(POINTS))?;
        let listed = list(folder, &checked)?;
        check_bytes(folder, &listed, checked.layout.stride as u64, file.len())?;
        let extents = extents(folder, checked.about.is_some())?;
        let nodes = nodes_of(folder, &checked, &listed, extents.as_deref())?;
        let points: u64 = nodes.iter().map(|node| node.points).sum();
        if points == 0 {
            return Err(Error::NoPoints { path: folder.to_path_buf(), non_finite: 0 });
        }
        let (decoder, like) = decoder(&checked, points).map_err(|cause| Error::malformed(folder, METADATA, cause))?;
        let summary = Summary {
            path: folder.to_path_buf(),
            points,
            bounds: nodes.first().map_or(checked.bounds, |root| root.bounds),
            up: like.up,
            ranges: ranges(&checked),
            grid: Some(checked.grid),
            like,
        };
        let starts = listed.iter().map(|listed| listed.offset).collect();
        Ok(Self { summary, nodes, starts, decoder, file, is_ours: checked.about.is_some() })
    }

    /// Returns `true` if a path is a folder with an octree, or its metadata.json.
    pub fn is_one(path: &Path) -> bool {
        path.join(METADATA).is_file() || path.file_name().is_some_and(|name| name == METADATA)
    }

    /// Returns the number of points of the file that are before those of a node.
    #[doc(hidden)]
    pub fn first_point(&self, node: usize) -> u64 {
        self.starts[node] / self.decoder.stride().max(1)
    }

    /// The points of a node from their bytes.
    fn decode(&self, node: usize, records: &[u8]) -> Result<Piece, Error> {
        let about = &self.nodes[node];
        let mut cloud = self.decoder.cloud(records);
        let mut places = self.decoder.places(records, self.first_point(node));
        let kept = if self.is_ours { splats_of(&cloud) } else { not_withheld(&cloud) };
        if let Some(kept) = kept {
            let withheld = if self.is_ours { 0 } else { cloud.len() - kept.len() };
            cloud = Cloud { withheld, ..cloud.subset(&kept) };
            places = kept.iter().map(|at| places[*at as usize]).collect();
        }
        (cloud.up, cloud.filter) = (self.summary.up, self.summary.like.filter);
        cloud.crs.clone_from(&self.summary.like.crs);
        let Bounds { min, max } = about.bounds;
        let is_outside = |p: &&DVec3| !(p.cmpge(min) & p.cmple(max)).all();
        if let Some(outside) = cloud.positions.iter().find(is_outside) {
            return Err(self.damaged(node, format!("a point lies at {outside}, outside its box from {min} to {max}")));
        }
        let reaches = cloud.gaussians.iter().flat_map(|splats| &splats.extents).map(|extents| reach(*extents));
        let mut radii = cloud.radii.iter().flatten().copied().chain(reaches);
        let mut larger = |largest: f32| radii.find(|radius| *radius > largest);
        if let Some((radius, largest)) = about.largest_radius.and_then(|largest| Some((larger(largest)?, largest))) {
            return Err(
                self.damaged(node, format!("a point has the radius {radius}, but the largest should be {largest}"))
            );
        }
        Ok(Piece { cloud, places })
    }

    fn damaged(&self, node: usize, cause: String) -> Error {
        Error::malformed(&self.summary.path, POINTS, format!("node at byte {}: {cause}", self.starts[node]))
    }
}

impl Store for Octree {
    known!();

    fn read(&self, node: usize) -> Result<Piece, Error> {
        self.decode(node, &self.file.read(self.starts[node], self.nodes[node].bytes)?)
    }

    fn survey(&self) -> Result<Option<StoreSurvey>, Error> {
        survey::read(self)
    }
}

/// The error of a folder that is no octree.
fn missing(error: Error, folder: &Path) -> Error {
    match error {
        Error::Read { source, .. } if source.kind() == std::io::ErrorKind::NotFound && folder.is_dir() => {
            let cause = format!("it has no {METADATA}, which a Potree 2.0 octree needs");
            Error::malformed(folder, "folder", cause)
        }
        Error::Read { source, path } if source.kind() == std::io::ErrorKind::NotFound => Error::Missing(path),
        error => error,
    }
}

/// The nodes of the hierarchy.
fn list(folder: &Path, checked: &Checked) -> Result<Vec<Listed>, Error> {
    let bytes = InputFile::open(&folder.join(HIERARCHY))?.all()?;
    let read = hierarchy::read(&bytes, checked.metadata.hierarchy.first_chunk_size, checked.bounds);
    read.map_err(|(place, cause)| Error::malformed(folder, place, cause))
}

/// Compares the nodes' bytes with their points, with the file, and with each other.
fn check_bytes(folder: &Path, nodes: &[Listed], stride: u64, len: u64) -> Result<(), Error> {
    for node in nodes {
        let refused =
            |cause: String| Error::malformed(folder, format!("{HIERARCHY}: node of level {}", node.level), cause);
        if node.points.checked_mul(stride) != Some(node.bytes) {
            let (points, bytes) = (node.points, node.bytes);
            return Err(refused(format!("{bytes} bytes don't match {points} points of {stride} bytes")));
        }
        if node.bytes > 0 && node.offset.checked_add(node.bytes).is_none_or(|end| end > len) {
            let (offset, bytes) = (node.offset, node.bytes);
            return Err(Error::Truncated {
                path: folder.join(POINTS),
                what: format!("a node has {bytes} bytes from byte {offset}, but the file has {len}"),
            });
        }
    }
    let mut runs: Vec<(u64, u64)> =
        nodes.iter().filter(|node| node.bytes > 0).map(|node| (node.offset, node.offset + node.bytes)).collect();
    runs.sort_unstable();
    match runs.windows(2).find(|pair| pair[0].1 > pair[1].0) {
        None => Ok(()),
        Some(pair) => {
            let (end, start) = (pair[0].1, pair[1].0);
            let cause = format!(
                "two nodes overlap in {POINTS}: one ends before byte {end}, the next one begins at byte {start}"
            );
            Err(Error::malformed(folder, HIERARCHY, cause))
        }
    }
}

/// nodes.bin, if it is there.
fn extents(folder: &Path, is_ours: bool) -> Result<Option<Vec<NodeExtent>>, Error> {
    if !is_ours || !folder.join(NODES).exists() {
        return Ok(None);
    }
    let bytes = InputFile::open(&folder.join(NODES))?.all()?;
    nodes::read(&bytes).map(Some).map_err(|(place, cause)| Error::malformed(folder, place, cause))
}

/// The nodes with boxes around their points: those of nodes.bin, else the parts of the root's box.
fn nodes_of(
    folder: &Path,
    checked: &Checked,
    listed: &[Listed],
    extents: Option<&[NodeExtent]>,
) -> Result<Vec<Node>, Error> {
    let grown = |bounds: &Bounds| {
        let by = checked.grid.scale + ROUNDING * bounds.min.abs().max(bounds.max.abs());
        Bounds { min: bounds.min - by, max: bounds.max + by }
    };
    let mut nodes = Vec::with_capacity(listed.len());
    for node in listed {
        let part = grown(&node.bounds);
        let mut largest_radius = None;
        let mut bounds = Some(part).filter(|_| extents.is_none());
        if let (Some(extents), 1..) = (extents, node.points) {
            let refused =
                |cause: &str| Error::malformed(folder, NODES, format!("node at byte {}: {cause}", node.offset));
            let found = extents.binary_search_by_key(&node.offset, |extent| extent.offset);
            let extent = found.map_err(|_| refused("missing"))?;
            let own = extents[extent].bounds(&checked.grid);
            if own.min.cmplt(part.min).any() || own.max.cmpgt(part.max).any() {
                return Err(refused("its box is outside its part of the octree"));
            }
            largest_radius = extents[extent].largest_radius;
            // The grid rounds by half a step, and that is rounded.
            let around = if checked.layout.find(&Role::Exact).is_some() { checked.grid.scale } else { DVec3::ZERO };
            bounds = Some(Bounds { min: own.min - around, max: own.max + around });
        }
        let spacing = checked.metadata.spacing * (-f64::from(node.level)).exp2();
        let Listed { level, parent, points, bytes, .. } = *node;
        let node = Node { level, parent, bounds: part, points, bytes, spacing, largest_radius };
        nodes.push((node, bounds));
    }
    Ok(around_children(nodes))
}

/// Lets boxes of points grow around those of the nodes below. Nodes without points there and below keep what the one
/// above has of their part.
fn around_children(mut nodes: Vec<(Node, Option<Bounds>)>) -> Vec<Node> {
    for index in (0..nodes.len()).rev() {
        let (Node { parent, .. }, bounds) = nodes[index];
        if let (Some(parent), Some(bounds)) = (parent, bounds) {
            let above = &mut nodes[parent as usize].1;
            *above = Some(above.map_or(bounds, |above| above.union(bounds)));
        }
    }
    let mut done: Vec<Node> = Vec::with_capacity(nodes.len());
    for (node, bounds) in nodes {
        let above = node.parent.and_then(|parent| done.get(parent as usize)).map(|parent| parent.bounds);
        let of_above = above.map_or(node.bounds, |above| cut(node.bounds, above).unwrap_or(above));
        done.push(Node { bounds: bounds.unwrap_or(of_above), ..node });
    }
    done
}

/// Returns the decoder of points, and a cloud without points but with all that they have in common.
fn decoder(checked: &Checked, points: u64) -> Result<(Decoder, Cloud), String> {
    let Checked { metadata, about, layout, grid, .. } = checked;
    layout.splats()?;
    let described = |role: &Role| {
        let at = layout.attributes.iter().position(|attribute| attribute.role == *role)?;
        metadata.attributes.get(at)
    };
    let full = described(&Role::Rgb).and_then(|rgb| match about {
        Some(_) => full_scale(rgb.kind, None),
        None => full_scale(rgb.kind, rgb.largest()),
    });
    let first_time = described(&Role::Time).and_then(metadata::Described::range).map_or(0.0, |[first, _]| first);
    let has = |role: &Role| layout.find(role).is_some();
    let prepared = about.as_ref().and_then(|about| about.prepared.as_ref()).filter(|_| has(&Role::Field));
    let prepared = prepared.map(|record| record.prepared(has(&Role::Lit))).transpose()?;
    let decoder = Decoder::new(layout.clone(), *grid, full, first_time, prepared);
    let mut like = decoder.cloud(&[]);
    like.up = about.as_ref().map_or(UpAxis::Z, |about| about.up);
    like.up_is_convention = about.as_ref().is_none_or(|about| about.up_is_convention);
    // A file may claim any number, and those of several files are added.
    like.non_finite = about.as_ref().map_or(0, |about| about.non_finite.min(MOST_DROPPED) as usize);
    like.filter = about.as_ref().and_then(|about| Filter::named(about.filter.as_deref()?));
    // PotreeConverter mostly writes a definition of PROJ there, which says nothing here.
    let of_projection = || crate::crs::parse(&metadata.projection);
    let crs = match about {
        Some(about) => about.crs.clone().map(Crs::checked),
        None => of_projection(),
    };
    like.crs = crs.map(Arc::new);
    like.warnings.clone_from(&checked.warnings);
    if metadata.points != points {
        like.warnings.push(format!("{METADATA} announces {} points, but the nodes have {points}", metadata.points));
    }
    Ok((decoder, like))
}

/// Least and largest value of each scalar.
fn ranges(checked: &Checked) -> Vec<(String, [f64; 2])> {
    let each = checked.layout.attributes.iter().zip(&checked.metadata.attributes);
    let range = |(attribute, described): (&attributes::Attribute, &metadata::Described)| {
        let [least, most] = described.range()?;
        let [factor, summand] = attribute.transform;
        match &attribute.role {
            Role::Scalar(name) => {
                let ends = [least * factor + summand, most * factor + summand];
                let is_range = ends.iter().all(|end| end.is_finite());
                is_range.then(|| (name.clone(), [ends[0].min(ends[1]), ends[0].max(ends[1])]))
            }
            Role::Time => Some((GPS_TIME.to_owned(), [0.0, most - least])),
            _ => None,
        }
    };
    each.filter_map(range).collect()
}
