//! EPT folders: points as files, one for each node of an octree, with a description and a hierarchy in JSON
//! (entwine.io, 1.x).

mod hierarchy;
mod metadata;
mod rows;

use std::path::{Path, PathBuf};

use super::keys::{Key, cut, parents};
use super::{Node, Piece, Store, Summary};
use crate::las::{Columns, LasFile, Traits};
use crate::{Error, InputFile, LasColumns};
use metadata::{Metadata, Tiles};
use pellucid_core::cloud::{Bounds, Cloud, UpAxis};
use pellucid_core::parallel;
use pellucid_core::progress::Progress;

/// Tiles that are looked at side by side, if it takes any, to find what decides about whole columns.
const AT_A_TIME: usize = 16;

/// An EPT folder with tiles in LAZ files or in rows, plain or compressed by Zstandard, read node by node.
///
/// It has the columns that LAS files have: positions, colors, intensity, classes, returns, the columns that are asked
/// for, and dimensions that LAS doesn't know as scalars. What decides about whole columns is taken from the largest and
/// smallest values in the description; where they are missing, tiles are read from the root on until it is known.
#[derive(Debug)]
pub struct Ept {
    folder: PathBuf,
    metadata: Metadata,
    asked: LasColumns,
    traits: Traits,
    keys: Vec<Key>,
    /// Number of places in the nodes before each node.
    first_places: Vec<u64>,
    nodes: Vec<Node>,
    pub(super) summary: Summary,
}

impl Ept {
    /// Opens a folder that has an `ept.json`, or that file. Of the columns that are read only where they are asked for,
    /// it has these.
    ///
    /// # Errors
    /// The description or the hierarchy is missing, damaged, has loops or doubts of how many points there are; tiles
    /// are missing, too small for their points, or in a format that isn't known.
    pub fn open(path: &Path, asked: LasColumns) -> Result<Self, Error> {
        let folder = if path.is_dir() { path } else { path.parent().unwrap_or(path) };
        let metadata = Metadata::read(&folder.join("ept.json"))?;
        let mut counts = hierarchy::read(folder, metadata.points)?;
        counts.sort_unstable();
        let keys: Vec<Key> = counts.iter().map(|(key, _)| *key).collect();
        let mut nodes = Vec::with_capacity(keys.len());
        let mut first_places = Vec::with_capacity(keys.len());
        let mut places = 0;
        for ((key, points), parent) in counts.into_iter().zip(parents(&keys)) {
            nodes.push(node(folder, &metadata, key, points, parent)?);
            first_places.push(places);
            places = u64::saturating_add(places, points);
        }
        let Some(bounds) = nodes.iter().map(|node| node.bounds).reduce(Bounds::union) else {
            return Err(Error::NoPoints { path: folder.to_path_buf(), non_finite: 0 });
        };
        let asked = metadata.has(asked);
        let summary = Summary {
            path: folder.to_path_buf(),
            points: places,
            bounds,
            up: UpAxis::Z,
            ranges: metadata.ranges(asked),
            grid: None,
            like: Cloud::default(),
        };
        let folder = folder.to_path_buf();
        let mut ept = Self { folder, metadata, asked, traits: Traits::NONE, keys, first_places, nodes, summary };
        ept.traits = ept.survey()?;
        // The columns of all tiles are those of the first.
        let (columns, names) = ept.tile(0)?;
        ept.summary.like = Cloud { withheld: 0, ..ept.finish(columns, &names).subset(&[]) };
        Ok(ept)
    }

    /// Returns the facts that decide about whole columns: the description's values, else those of as many tiles as it
    /// takes.
    fn survey(&self) -> Result<Traits, Error> {
        if let Some(traits) = self.metadata.traits(self.asked) {
            return Ok(traits);
        }
        let mut traits = Traits::NONE;
        let nodes: Vec<usize> = (0..self.keys.len()).collect();
        for tiles in nodes.chunks(AT_A_TIME) {
            let some = parallel::try_map_each::<_, _, Error>(tiles, |node| Ok(self.tile(*node)?.0.traits()))?;
            traits = some.into_iter().fold(traits, Traits::and);
            if self.metadata.settles(self.asked, &traits) {
                break;
            }
        }
        Ok(traits)
    }

    /// The columns of a tile, as they are stored, and the names of those that LAS doesn't know.
    fn tile(&self, node: usize) -> Result<(Columns, Vec<String>), Error> {
        let path = tile_path(&self.folder, &self.metadata, self.keys[node]);
        let points = self.nodes[node].points;
        match &self.metadata.tiles {
            Tiles::Laszip => {
                let file = LasFile::open(InputFile::open(&path)?, self.asked)?;
                if file.header.count != points {
                    let cause = format!("it has {} points, but the hierarchy says {points}", file.header.count);
                    return Err(file.file.malformed("LAS header", cause));
                }
                let parts = parallel::try_map_each(&file.chunks, |chunk| file.decode(chunk, &Progress::hidden()))?;
                let columns = Columns::join(parts).unwrap_or_else(|| Columns::new(&file.header, self.asked));
                Ok((columns, file.extra_names().map(str::to_owned).collect()))
            }
            Tiles::Rows(rows) => rows.read(InputFile::open(&path)?, points, self.asked, false),
            Tiles::Zstandard(rows) => rows.read(InputFile::open(&path)?, points, self.asked, true),
        }
    }

    fn finish(&self, columns: Columns, names: &[String]) -> Cloud {
        let cloud = columns.finish(names.iter().map(|name| &**name), self.asked, &self.traits);
        let cloud = Cloud { crs: self.metadata.crs.clone(), ..cloud };
        match &self.metadata.tiles {
            Tiles::Laszip => cloud,
            Tiles::Rows(rows) | Tiles::Zstandard(rows) => rows.without_missing(cloud),
        }
    }

    fn check(&self, node: usize, cloud: &Cloud) -> Result<(), Error> {
        let Node { points, bounds, .. } = &self.nodes[node];
        let fail = |cause: String| {
            Err(Error::malformed(&tile_path(&self.folder, &self.metadata, self.keys[node]), "tile", cause))
        };
        if (cloud.len() + cloud.withheld) as u64 != *points {
            return fail(format!(
                "it has {} points with finite coordinates, but the hierarchy says {points}",
                cloud.len()
            ));
        }
        if let Some(found) = cloud.bounds().filter(|found| !bounds.holds(found)) {
            return fail(format!(
                "its points lie from {} to {}, outside its box from {} to {}",
                found.min, found.max, bounds.min, bounds.max
            ));
        }
        let like = Cloud { warnings: self.summary.like.warnings.clone(), withheld: 0, ..cloud.subset(&[]) };
        if like != self.summary.like {
            return fail("its columns differ from those of the root's tile".to_owned());
        }
        Ok(())
    }
}

impl Store for Ept {
    known!();

    fn read(&self, node: usize) -> Result<Piece, Error> {
        let (columns, names) = self.tile(node)?;
        let places = columns.places(self.first_places[node]).collect();
        let cloud = self.finish(columns, &names);
        self.check(node, &cloud)?;
        Ok(Piece { cloud, places })
    }
}

fn tile_path(folder: &Path, metadata: &Metadata, key: Key) -> PathBuf {
    folder.join("ept-data").join(format!("{key}.{}", metadata.tiles.extension()))
}

fn node(folder: &Path, metadata: &Metadata, key: Key, points: u64, parent: Option<u32>) -> Result<Node, Error> {
    let path = tile_path(folder, metadata, key);
    let bytes = std::fs::metadata(&path).map_err(Error::opening(&path))?.len();
    let most = metadata.tiles.most_points(bytes);
    if points > most {
        let what = format!("the hierarchy says {points} points, but {bytes} bytes hold at most {most}");
        return Err(Error::Truncated { path, what });
    }
    let Some(bounds) = cut(metadata.widened(key.cube(&metadata.cube)), metadata.widened(metadata.conforming)) else {
        let cause = format!("node {key} lies outside `boundsConforming`");
        return Err(Error::malformed(&folder.join("ept.json"), "hierarchy", cause));
    };
    let spacing = metadata.spacing / (1u64 << key.level) as f64;
    Ok(Node { level: key.level, parent, bounds, points, bytes, spacing, largest_radius: None })
}
