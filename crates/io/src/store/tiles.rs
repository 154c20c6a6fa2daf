//! Several stores as one cloud: the tiles of a survey, or scans of one place.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::fitted::fitted;
use super::{Grid, Node, Piece, Store, Summary};
use crate::Error;
use pellucid_core::cloud::crs::Crs;
use pellucid_core::cloud::gaussians::{ColorCoding, Gaussians};
use pellucid_core::cloud::{Bounds, Cloud, GPS_TIME};

/// Stores one behind the other, whose nodes are nodes of one cloud.
///
/// Points have the columns that any of the stores has. Where a store lacks one, its points are white, opaque, without
/// normal, of class 0, and have no number (NaN) as intensity and scalars. Radii and what was prepared are kept only if
/// all have them, since there is no such value for points without.
///
/// The boxes of a file's nodes are that file's own, so adjacent files are distinguished before they are read. LAS
/// files are not looked up in spatial indices (`.lax`).
#[derive(Debug)]
pub struct Tiles {
    stores: Vec<Tile>,
    nodes: Vec<Node>,
    summary: Summary,
}

#[derive(Debug)]
struct Tile {
    store: Box<dyn Store>,
    /// Nodes of the stores before.
    first_node: usize,
    /// Places of the stores before.
    first_place: u64,
}

impl Tiles {
    /// Returns one cloud of several stores; `path` is what messages call it.
    ///
    /// # Errors
    /// No stores.
    pub fn new(path: &Path, stores: Vec<Box<dyn Store>>) -> Result<Self, Error> {
        let summaries: Vec<&Summary> = stores.iter().map(|store| store.summary()).collect();
        let Some(bounds) = summaries.iter().map(|summary| summary.bounds).reduce(Bounds::union) else {
            return Err(Error::NoPoints { path: path.to_path_buf(), non_finite: 0 });
        };
        let like = like(&summaries);
        let summary = Summary {
            path: path.to_path_buf(),
            points: summaries.iter().fold(0, |points, summary| points.saturating_add(summary.points)),
            bounds,
            up: like.up,
            ranges: ranges(&summaries, &like),
            grid: Grid::shared(&summaries.iter().map(|summary| summary.grid).collect::<Vec<_>>(), &bounds),
            like,
        };
        let mut tiles = Self { stores: Vec::with_capacity(stores.len()), nodes: Vec::new(), summary };
        let mut first_place = 0;
        for store in stores {
            let first_node = tiles.nodes.len();
            let parent = |node: &Node| node.parent.map(|parent| parent + first_node as u32);
            tiles.nodes.extend(store.nodes().iter().map(|node| Node { parent: parent(node), ..node.clone() }));
            // Points that are left out have places too.
            let places = store.summary().points.saturating_add(store.summary().like.non_finite as u64);
            tiles.stores.push(Tile { store, first_node, first_place });
            first_place = first_place.saturating_add(places);
        }
        Ok(tiles)
    }
}

impl Store for Tiles {
    known!();

    fn read(&self, node: usize) -> Result<Piece, Error> {
        let at = self.stores.partition_point(|tile| tile.first_node <= node) - 1;
        let Tile { store, first_node, first_place } = &self.stores[at];
        let Piece { cloud, mut places } = store.read(node - first_node)?;
        // A store may claim any place.
        places.iter_mut().for_each(|place| *place = place.saturating_add(*first_place));
        Ok(Piece { cloud: fitted(cloud, &self.summary.like), places })
    }
}

/// Returns a cloud of no points with the columns of all.
pub(super) fn like(all: &[&Summary]) -> Cloud {
    let clouds = || all.iter().map(|summary| &summary.like);
    let any = |has: fn(&Cloud) -> bool| clouds().any(has);
    let first = clouds().next().cloned().unwrap_or_default();
    let mut scalars: Vec<(String, Vec<f32>)> = Vec::new();
    for (name, _) in clouds().flat_map(|cloud| &cloud.scalars) {
        if scalars.iter().all(|(known, _)| known != name) {
            scalars.push((name.clone(), Vec::new()));
        }
    }
    let prepared = first.prepared.clone().filter(|_| clouds().all(|cloud| cloud.prepared == first.prepared));
    // Radii that were estimated mean nothing without the rest of what was prepared.
    let estimated = any(|cloud| cloud.prepared.as_ref().is_some_and(|prepared| prepared.estimated_radii));
    let keeps_radii = clouds().all(|cloud| cloud.radii.is_some()) && (prepared.is_some() || !estimated);
    let degree = clouds().filter_map(|cloud| Some(cloud.gaussians.as_ref()?.degree)).max();
    let linear = any(|cloud| cloud.gaussians.as_ref().is_some_and(Gaussians::may_be_linear));
    let coding = if linear { ColorCoding::Linear } else { ColorCoding::Display };
    Cloud {
        gaussians: degree.map(|degree| Gaussians { coding, ..Gaussians::none(0).with_degree(degree) }),
        filter: first.filter.filter(|_| clouds().all(|cloud| cloud.filter == first.filter)),
        colors: any(|cloud| cloud.colors.is_some()).then(Vec::new),
        alphas: any(|cloud| cloud.alphas.is_some()).then(Vec::new),
        normals: any(|cloud| cloud.normals.is_some()).then(Vec::new),
        radii: keeps_radii.then(Vec::new),
        classification: any(|cloud| cloud.classification.is_some()).then(Vec::new),
        intensity: any(|cloud| cloud.intensity.is_some()).then(Vec::new),
        scalars,
        non_finite: clouds().map(|cloud| cloud.non_finite).sum(),
        up: first.up,
        up_reason: first.up_reason,
        crs: shared_crs(all).ok().flatten(),
        up_is_convention: first.up_is_convention,
        warnings: warnings(all, prepared.is_some(), keeps_radii),
        prepared,
        ..Cloud::default()
    }
}

/// Says that inputs state different systems.
pub(super) fn differing_crs(all: &[&Summary]) -> Option<String> {
    let [(first, crs), (path, other)] = shared_crs(all).err()?;
    let (first, path) = (first.display(), path.display());
    Some(format!("{first} is in {crs}, but {path} in {other}, so together they have no coordinate reference system"))
}

/// Returns the system of all that state one; the first two that differ, as an error.
fn shared_crs(all: &[&Summary]) -> Result<Option<Arc<Crs>>, [(PathBuf, String); 2]> {
    let mut stated = all.iter().filter_map(|summary| Some((&summary.path, summary.like.crs.as_ref()?)));
    let Some((first, crs)) = stated.next() else { return Ok(None) };
    match stated.find(|(_, other)| *other != crs) {
        None => Ok(Some(Arc::clone(crs))),
        Some((path, other)) => Err([(first.clone(), crs.title()), (path.clone(), other.title())]),
    }
}

fn warnings(all: &[&Summary], keeps_prepared: bool, keeps_radii: bool) -> Vec<String> {
    let several = all.len() > 1;
    let mut warnings: Vec<String> = Vec::new();
    for Summary { path, like, .. } in all {
        let of = |warning: &String| if several { format!("{}: {warning}", path.display()) } else { warning.clone() };
        warnings.extend(like.warnings.iter().map(of));
    }
    warnings.extend(differing_crs(all));
    if let Some(other) = all.iter().find(|summary| summary.up != all[0].up) {
        warnings.push(format!(
            "{} has {:?} as its up axis, but {} has {:?}, which is used for all files",
            other.path.display(),
            other.up,
            all[0].path.display(),
            all[0].up
        ));
    }
    if !keeps_radii && all.iter().any(|summary| summary.like.radii.is_some()) {
        warnings.push("radii are left out, since not all of the files have them".to_owned());
    }
    if !keeps_prepared && all.iter().any(|summary| summary.like.prepared.is_some()) {
        warnings.push("what was prepared is left out, since not all of the files are prepared alike".to_owned());
    }
    if all.iter().filter(|summary| summary.like.scalar(GPS_TIME).is_some()).count() > 1 {
        warnings.push(format!("{GPS_TIME} counts from the first point of each file"));
    }
    warnings
}

/// Ranges of the scalars that are known of every store that has them.
fn ranges(all: &[&Summary], like: &Cloud) -> Vec<(String, [f64; 2])> {
    let of = |name: &String| {
        let has = |summary: &&&Summary| summary.like.scalars.iter().any(|(known, _)| known == name);
        let range =
            |summary: &&Summary| summary.ranges.iter().find(|(known, _)| known == name).map(|(_, range)| *range);
        let ranges = all.iter().filter(has).map(range).collect::<Option<Vec<_>>>()?;
        let range = ranges.into_iter().reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])])?;
        Some((name.clone(), range))
    };
    like.scalars.iter().filter_map(|(name, _)| of(name)).collect()
}

#[cfg(test)]
mod tests {
    use glam::{DVec3, Vec3};

    use super::*;
    use crate::store::MemoryStore;
    use pellucid_core::cloud::UpAxis;

    fn held(path: &str, cloud: Cloud) -> Box<dyn Store> {
        Box::new(MemoryStore::new(Path::new(path), cloud).unwrap())
    }

    fn line(points: usize, x: f64) -> Cloud {
        let positions = (0..points).map(|at| DVec3::new(x, at as f64, 0.0)).collect();
        Cloud { positions, up: UpAxis::Z, ..Cloud::default() }
    }

    #[test]
    fn columns_that_a_store_lacks_are_filled() {
        let scalars = vec![("echo".to_owned(), vec![1.0, 2.0]), ("w".to_owned(), vec![3.0, 9.0])];
        let radii = Some(vec![0.5, 1.5]);
        let colors = Some(vec![Vec3::ZERO; 2]);
        let a = Cloud { scalars, radii, colors, intensity: Some(vec![7.0; 2]), ..line(2, 0.0) };
        let b = Cloud {
            classification: Some(vec![2; 3]),
            scalars: vec![("w".to_owned(), vec![-4.0; 3])],
            up: UpAxis::Y,
            non_finite: 5,
            warnings: vec!["odd".to_owned()],
            ..line(3, 10.0)
        };
        let tiles = Tiles::new(Path::new("both"), vec![held("a", a), held("b", b), held("c", line(1, 20.0))]).unwrap();
        let Summary { points, bounds, ranges, like, up, .. } = tiles.summary();
        assert_eq!((*points, bounds.max, *up), (6, DVec3::new(20.0, 2.0, 0.0), UpAxis::Z));
        assert_eq!(*ranges, [("echo".to_owned(), [1.0, 2.0]), ("w".to_owned(), [-4.0, 9.0])]);
        assert_eq!((like.radii.is_none(), like.non_finite, like.warnings.len()), (true, 5, 3), "{:?}", like.warnings);
        let pieces: Vec<Piece> = (0..3).map(|node| tiles.read(node).unwrap()).collect();
        assert_eq!(
            pieces.iter().map(|piece| piece.places.clone()).collect::<Vec<_>>(),
            [vec![0, 1], vec![2, 3, 4], vec![10]]
        );
        assert_eq!(tiles.nodes()[1].bounds, pieces[1].cloud.bounds().unwrap());
        let clouds = pieces.into_iter().map(|piece| piece.cloud);
        let all = clouds.fold(like.clone(), |mut all, cloud| {
            all.append(cloud);
            all
        });
        assert_eq!(all.colors.as_deref(), Some(&[[Vec3::ZERO; 2].as_slice(), &[Vec3::ONE; 4]].concat()[..]));
        assert_eq!(all.classification, Some(vec![0, 0, 2, 2, 2, 0]));
        assert_eq!(all.intensity.as_ref().map(|values| values[1]), Some(7.0));
        assert!(all.intensity.unwrap()[2..].iter().all(|value| value.is_nan()));
        assert_eq!(all.scalars[1].1[..5], [3.0, 9.0, -4.0, -4.0, -4.0]);
        assert!(all.scalars[0].1[2..].iter().all(|value| value.is_nan()));
    }

    #[test]
    fn parents_are_those_of_the_same_store() {
        #[derive(Debug)]
        struct Tree(Box<dyn Store>, [Node; 2]);
        impl Store for Tree {
            fn summary(&self) -> &Summary {
                self.0.summary()
            }
            fn nodes(&self) -> &[Node] {
                &self.1
            }
            fn read(&self, node: usize) -> Result<Piece, Error> {
                let Piece { cloud, places } = self.0.read(0)?;
                Ok(Piece { cloud: cloud.subset(&[node as u32]), places: places[node..=node].to_vec() })
            }
        }
        let tree = |x| -> Box<dyn Store> {
            let store = held("tree", line(2, x));
            let root = Node { points: 1, ..store.nodes()[0].clone() };
            let child = Node { level: 1, parent: Some(0), ..root.clone() };
            Box::new(Tree(store, [root, child]))
        };
        let tiles = Tiles::new(Path::new("all"), vec![tree(0.0), tree(1.0), tree(2.0)]).unwrap();
        let parents: Vec<_> = tiles.nodes().iter().map(|node| node.parent).collect();
        assert_eq!(parents, [None, Some(0), None, Some(2), None, Some(4)]);
        let piece = tiles.read(3).unwrap();
        assert_eq!((piece.cloud.positions, piece.places), (vec![DVec3::new(1.0, 1.0, 0.0)], vec![3]));
        assert!(Tiles::new(Path::new("all"), Vec::new()).is_err());
    }
}
