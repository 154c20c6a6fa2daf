//! Scenes whose clouds stay where they are stored: nodes are read when a part of the picture needs them, and are points
//! as those of a scene in memory are.
//!
//! What follows from all points of a cloud together, such as the range of a color map, is found once, in a survey: from
//! facts about all points, and from some points that stand for all ([`Sampling`]), which a scene in memory takes, too.

mod cloud;
mod levels;
mod survey;

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use glam::DVec3;
use rayon::prelude::*;

use self::cloud::StoredCloud;
pub use self::survey::OpenStore;
use super::assemble::most_frequent;
use super::cache::Cache;
use super::clip::Clips;
use super::error::Error;
use super::gaussians;
use super::legend::Legend;
use super::nothing_left::no_points;
use super::scene::Scene;
use super::settings::{CloudSettings, ShadingModel};
use super::units::{Systems, Units};
use crate::prepare::dealt_file::{self, DealtFile};
use crate::prepare::{Arranged, Supplied, order};
use crate::supply::{Block, Branch, Failure, Keep, Supply};
use pellucid_core::cloud::gaussians::Gaussians;
use pellucid_core::cloud::sampling::Sampling;
use pellucid_core::cloud::{Bounds, Cloud, UpAxis};
use pellucid_core::color::ColorSpace;
use pellucid_core::parallel;
use pellucid_core::points::{Anchor, Points, Spheres, WholeScene, WholeSplats};
use pellucid_core::progress::{Phase, Progress};
use pellucid_io as io;
use pellucid_io::store;

/// Stores of a scene, in the order of its clouds.
pub type Stores = Vec<OpenStore>;

/// Opens the scene's clouds without reading their points, as far as their formats allow.
///
/// # Errors
/// The first cloud that can't be opened.
pub fn open_stores(scene: &Scene, progress: &Progress) -> Result<Stores, io::Error> {
    let open = |cloud: &CloudSettings| {
        progress.reset();
        progress.set_message(format!("opening {}", cloud.path.display()));
        store::open(&cloud.path, cloud.hints(), progress).map(OpenStore::new)
    };
    scene.clouds.iter().map(open).collect()
}

/// Bytes of memory for each point that is taken at a time: as it is read, put into order, and taken. Half of the memory
/// keeps nodes.
fn taken_bytes(splats: Option<WholeSplats>) -> u64 {
    2 * (150 + splats.map_or(0, |splats| Gaussians::bytes_each(splats.degree)))
}

/// Returns `true` if a cloud of the scene has levels of detail where it is stored.
///
/// # Errors
/// A cloud that can't be opened.
pub fn have_levels(scene: &Scene) -> Result<bool, io::Error> {
    let levels = scene.clouds.iter().map(|cloud| store::has_levels(&cloud.path, &cloud.hints()));
    Ok(levels.collect::<Result<Vec<_>, _>>()?.contains(&true))
}

/// Returns `true` if the picture of the stores is that of all points in memory: if they have the data that the scene
/// needs.
///
/// # Errors
/// A scene that asks for what no cloud has.
pub fn are_complete(scene: &Scene, stores: &[OpenStore]) -> Result<bool, Error> {
    let complete = stores.iter().enumerate().map(|(index, store)| cloud::has_all(scene, index, store.summary()));
    let complete = !complete.collect::<Result<Vec<_>, _>>()?.contains(&false);
    Ok(complete && !is_unlit(scene, stores))
}

/// Returns the coordinate reference systems of stores.
pub fn systems(stores: &[OpenStore]) -> Systems {
    stores.iter().map(|store| store.summary().like.crs.clone()).collect()
}

/// Notes about the filters that Gaussians were trained with, and about radii that they have no use for.
fn splat_notes(scene: &Scene, stores: &[OpenStore]) -> Vec<String> {
    let notes = |(settings, store): (&CloudSettings, &OpenStore)| {
        let like = &store.summary().like;
        let notes = [gaussians::filter_note(scene, settings, like), gaussians::radius_note(scene, settings, like)];
        let path = settings.path.display().to_string();
        notes.into_iter().flatten().map(move |note| format!("{path}: {note}"))
    };
    scene.clouds.iter().zip(stores).flat_map(notes).collect()
}

/// A scene whose clouds are stores.
#[derive(Debug, Clone)]
pub struct Stored {
    nodes: Arc<Nodes>,
    /// Some points that stand for all, with what is known of all ([`Points::whole`]).
    pub sample: Arc<Points>,
    /// Meaning of the colors of the points, by those that stand for all.
    pub legend: Legend,
    /// Everything else that should be known, one sentence each.
    pub notes: Vec<String>,
    /// The space in which colors are blended because every cloud is of Gaussians, and the scene says nothing of it.
    pub blend_space: Option<ColorSpace>,
    /// `true` if some clouds are of Gaussians.
    pub has_gaussians: bool,
}

/// Nodes that were read, each as often as it was, and their bytes in the files.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Reads {
    /// Number of nodes.
    pub nodes: u64,
    /// Bytes in the files.
    pub bytes: u64,
}

/// The nodes of all clouds.
#[derive(Debug)]
struct Nodes {
    scene: Scene,
    clips: Clips,
    clouds: Vec<StoredCloud>,
    /// Anchors that ids follow from where clouds are kept apart.
    anchors: Vec<Anchor>,
    /// The box of all points.
    bounds: Bounds,
    blocks: Vec<Block>,
    /// Cloud and node of each block.
    places: Vec<[u32; 2]>,
    cache: Cache<Points>,
    /// Nodes that were read so far, each as often as it was, and their bytes.
    nodes_read: AtomicU64,
    bytes_read: AtomicU64,
    /// Places of points that stand for all, and how many each stands for.
    sampled: (Vec<DVec3>, u64),
    /// Points that are taken at a time.
    most: u64,
}

impl Stored {
    /// Returns a scene with its stores, whose nodes are kept in at most so many bytes of memory once they are read.
    /// Unless the stores know what is known of all their points, all are read once.
    ///
    /// # Errors
    /// Returns an error if a store can't be read, if a cloud lacks what the scene asks for or it would have to be
    /// found from neighbors, or if no point is left.
    pub fn new(
        scene: &Scene,
        stores: &[OpenStore],
        memory: u64,
        progress: &Progress,
    ) -> Result<Self, crate::OpenError> {
        progress.begin(Phase::Prepare);
        let (mut scene, clips) = (scene.clone(), Clips::load(&scene.clips)?);
        let gaussians = |index: usize| stores.get(index)?.summary().like.gaussians.as_ref();
        let blend_space = scene.settle_for(|index| gaussians(index).map(Gaussians::blend_space));
        let has_gaussians = (0..stores.len()).any(|index| gaussians(index).is_some());
        let mut notes = splat_notes(&scene, stores);
        let is_unlit = is_unlit(&scene, stores);
        if is_unlit {
            scene.shading.model = match scene.shading.model {
                ShadingModel::Auto | ShadingModel::None => ShadingModel::None,
                _ => return Err(Error::Unprepared { path: scene.clouds[0].path.clone(), what: "normals" }.into()),
            };
        }
        let count = stores.iter().map(|store| store.summary().points).sum();
        let (mut clouds, mut anchors) = (Vec::with_capacity(stores.len()), Vec::new());
        let mut legend = Legend::new(Units::of(&scene, systems(stores)));
        let (mut sample, mut first) = (Points::default(), 0);
        for (index, store) in stores.iter().enumerate() {
            let at = cloud::CloudPlace { scene: &scene, clips: &clips, index, first };
            let (cloud, own) = StoredCloud::new(&at, store, &mut legend, progress)?;
            first += cloud.facts.points;
            anchors.push(Anchor::new(&own.sampled().copied().collect::<Vec<_>>(), cloud.bounds()));
            let path = scene.clouds[index].path.display();
            notes.extend(cloud.up_note.iter().map(|note| format!("{path}: {note}")));
            clouds.push(cloud);
            sample.append(own);
        }
        let lacks_some = scene.shading_normals().is_some() && clouds.iter().any(|cloud| cloud.facts.lacks_normals);
        if is_unlit || lacks_some {
            let note = "points that have no normals are not shaded, and `cos_theta = false` has no effect on them; `pellucid prepare \
                        --normals` stores some";
            notes.push(note.to_owned());
        }
        let bounds = clouds.iter().filter_map(StoredCloud::bounds).reduce(Bounds::union);
        let bounds = bounds.filter(|bounds| bounds.min.is_finite() && bounds.max.is_finite());
        let bounds = bounds.ok_or_else(|| no_points(&scene, &sample, &[]))?;
        let (blocks, places) = blocks(&scene, &clouds);
        let sampling = Sampling::of(count);
        let sample = sample.taken_by(sampling);
        let sampled = (sample.positions.clone(), sampling.every());
        let splats = clouds.iter().filter_map(|cloud| cloud.splats).reduce(WholeSplats::and);
        let (cache, most) = (Cache::new(memory / 2, Points::bytes), (memory / taken_bytes(splats)).max(1));
        let nodes = Arc::new(Nodes {
            scene,
            clips,
            clouds,
            anchors,
            bounds,
            blocks,
            places,
            cache,
            nodes_read: AtomicU64::new(0),
            bytes_read: AtomicU64::new(0),
            sampled,
            most,
        });
        let clouds = &nodes.clouds;
        let whole = WholeScene {
            count,
            bounds,
            largest_radius: clouds.iter().map(|cloud| cloud.largest_radius).fold(0.0, f32::max),
            brightest: clouds.iter().map(|cloud| cloud.brightest).fold(1.0, f32::max),
            is_transparent: clouds.iter().any(|cloud| cloud.is_transparent),
            splats,
            identity: clouds.iter().map(StoredCloud::identity).collect::<Vec<_>>().join("\n"),
            spheres: Arc::clone(&nodes) as Arc<dyn Spheres>,
        };
        let sample = Arc::new(Points { whole: Some(Arc::new(whole)), ..sample });
        Ok(Self { nodes, sample, legend, notes, blend_space, has_gaussians })
    }

    /// Returns the scene, without shading where points have no normals to shade by.
    pub fn scene(&self) -> &Scene {
        &self.nodes.scene
    }

    /// Returns all points, block by block.
    pub fn arranged(&self) -> Arranged {
        Arranged::Supplied(Supplied {
            supply: Arc::clone(&self.nodes) as Arc<dyn Supply>,
            sample: Arc::clone(&self.sample),
            dealt: None,
        })
    }

    /// Returns all points, partitioned into ensembles by `seed` into a temporary file in `folder`: for methods that
    /// want that ([`Method::is_dealt`](super::Method::is_dealt)), which want no radii.
    ///
    /// # Errors
    /// Returns an error if a node can't be read, if there is no room in the folder, if memory is too small, if
    /// `progress` cancels the work, or if no point is left.
    pub fn dealt(&self, seed: u64, folder: &Path, progress: &Progress) -> Result<Arranged, crate::OpenError> {
        progress.begin(Phase::Order);
        progress.reset();
        progress.set_message("dealing points to ensembles");
        let nodes = &self.nodes;
        let own = nodes.clouds.iter().zip(&nodes.anchors).enumerate();
        let sources = own.filter_map(|(place, (cloud, anchor))| {
            let blocks = cloud.store.nodes().iter().map(|node| node.points).collect();
            let (path, read) = (cloud.store.summary().path.clone(), nodes.reader(place));
            Some(dealt_file::CloudBlocks { path, blocks, read, bounds: cloud.bounds()?, anchor: *anchor })
        });
        let settings = dealt_file::DealSettings {
            has_normals: nodes.clouds.iter().any(StoredCloud::has_normals),
            seed,
            memory: nodes.cache.most,
            folder: folder.to_path_buf(),
        };
        let file = DealtFile::deal(sources.collect(), &settings, progress)?;
        if file.is_empty() {
            return Err(no_points(&nodes.scene, &self.sample, &[]).into());
        }
        let supply = Arc::clone(nodes) as Arc<dyn Supply>;
        Ok(Arranged::Supplied(Supplied { supply, sample: Arc::clone(&self.sample), dealt: Some(Arc::new(file)) }))
    }

    /// Returns the vertical of most clouds.
    pub fn up(&self) -> UpAxis {
        most_frequent(self.nodes.clouds.iter().map(StoredCloud::up))
    }

    /// Returns `true` if points have other classes than 0 and 1, which say that nothing was classified.
    pub fn is_classified(&self) -> bool {
        self.nodes.clouds.iter().any(|cloud| (2..=u8::MAX).any(|code| cloud.facts.has_class(code)))
    }

    /// Returns clouds without points that have the columns of the scene's.
    pub fn likes(&self) -> impl Iterator<Item = &Cloud> {
        self.nodes.clouds.iter().map(|cloud| &cloud.store.summary().like)
    }

    /// Returns how clouds are colored and why, a phrase for each.
    pub fn colorings(&self) -> Vec<String> {
        self.nodes.clouds.iter().map(|cloud| cloud.coloring.clone()).collect()
    }

    /// Returns the blocks of all points.
    pub fn blocks(&self) -> &[Block] {
        &self.nodes.blocks
    }

    /// Returns the points of a block, which are read and not kept.
    ///
    /// # Errors
    /// Returns an error if the points can't be read.
    pub fn block(&self, block: usize) -> Result<Points, Failure> {
        self.nodes.read(block)
    }

    /// Gives the memory of nodes back that were read.
    pub fn forget(&self) {
        self.nodes.cache.clear();
    }

    /// Returns what was read of nodes so far.
    pub fn reads(&self) -> Reads {
        let [nodes, bytes] =
            [&self.nodes.nodes_read, &self.nodes.bytes_read].map(|count| count.load(Ordering::Relaxed));
        Reads { nodes, bytes }
    }

    /// Returns bytes that were read of nodes so far, and those of all nodes.
    pub fn bytes_read(&self) -> [u64; 2] {
        let nodes = self.nodes.clouds.iter().flat_map(|cloud| cloud.store.nodes());
        [self.reads().bytes, nodes.map(|node| node.bytes).sum()]
    }
}

impl Nodes {
    /// Reads nodes of a cloud, which are not kept.
    fn reader(self: &Arc<Self>, cloud: usize) -> dealt_file::Read {
        let nodes = Arc::clone(self);
        Arc::new(move |node| match nodes.clouds[cloud].store.nodes()[node].points {
            0 => Ok(Points::default()),
            _ => nodes.clouds[cloud].points(&nodes.scene, &nodes.clips, node),
        })
    }

    /// The points of a block, with those that are not drawn set apart.
    fn part(&self, block: usize) -> Result<Arc<Points>, Failure> {
        self.cache.get(block, || self.read(block))
    }

    /// Reads the points of a block.
    fn read(&self, block: usize) -> Result<Points, Failure> {
        let [cloud, node] = self.places[block].map(|number| number as usize);
        let cloud = &self.clouds[cloud];
        let points = cloud.points(&self.scene, &self.clips, node).map_err(|error| Failure::Store(Arc::new(error)))?;
        self.nodes_read.fetch_add(1, Ordering::Relaxed);
        self.bytes_read.fetch_add(cloud.store.nodes()[node].bytes, Ordering::Relaxed);
        Ok(points)
    }
}

impl Supply for Nodes {
    fn blocks(&self) -> &[Block] {
        &self.blocks
    }

    fn most(&self) -> u64 {
        self.most
    }

    fn estimate(&self, shows: &(dyn Fn(DVec3) -> bool + Sync)) -> Option<u64> {
        let (places, each) = &self.sampled;
        let kept = places.par_iter().with_min_len(1 << 12).filter(|place| shows(**place)).count();
        Some(kept as u64 * each)
    }

    fn take(&self, blocks: &[u32], keep: Keep<'_>, progress: &Progress) -> Result<Points, Failure> {
        let read = |block: &u32| -> Result<_, Failure> {
            progress.check()?;
            let points = self.part(*block as usize)?;
            let corners = self.blocks[*block as usize].bounds.corners();
            // Whoever is taken without reaching anywhere is taken whatever the reach.
            let reach = points.gaussians.is_some().then_some(0.0);
            if keep.convex && corners.into_iter().all(|corner| (keep.keeps)(corner, *block, reach)) {
                return Ok(points);
            }
            let keeps = |at: &u32| {
                let at = *at as usize;
                (keep.keeps)(points.positions[at], *block, points.reach(at))
            };
            let kept: Vec<u32> = (0..points.len() as u32).filter(keeps).collect();
            Ok(Arc::new(Points { unseen: Arc::default(), ..points.subset(&kept, 1.0) }))
        };
        let parts = parallel::try_map_each(blocks, read)?;
        let picked = order::merged(&parts, &self.bounds);
        let mut points = Points::gather(&parts, &picked);
        if let Some(grows) = keep.grows {
            let factor = |i: usize| grows(points.positions[i], blocks[picked[i][0] as usize]);
            let factors = parallel::map(picked.len(), factor);
            crate::supply::grow(&mut points, &factors);
        }
        Ok(points)
    }
}

impl Spheres for Nodes {
    fn groups(&self) -> Vec<(Bounds, f64)> {
        self.blocks.iter().map(|block| (block.bounds, block.radius.into())).collect()
    }

    fn of_group(&self, group: usize, drawn: bool) -> Vec<(DVec3, f64)> {
        let Ok(points) = self.part(group) else { return Vec::new() };
        let most = if drawn { points.len() } else { usize::MAX };
        points.spheres().take(most).collect()
    }
}

/// Returns `true` if a cloud has no normals where the scene shades by them.
fn is_unlit(scene: &Scene, stores: &[OpenStore]) -> bool {
    let lacks = |(settings, store): (&CloudSettings, &OpenStore)| {
        let like = &store.summary().like;
        // Lights don't shade Gaussians.
        like.normals.is_none() && !gaussians::are_drawn(scene, settings, like)
    };
    scene.shading_normals().is_some() && scene.clouds.iter().zip(stores).any(lacks)
}

/// The blocks of clouds, with cloud and node of each.
fn blocks(scene: &Scene, clouds: &[StoredCloud]) -> (Vec<Block>, Vec<[u32; 2]>) {
    let (mut blocks, mut nodes) = (Vec::new(), Vec::new());
    for (index, cloud) in clouds.iter().enumerate() {
        let is_other = |(other, of): &(usize, &StoredCloud)| *other != index && of.splats.is_none();
        let others = clouds.iter().enumerate().filter(is_other).filter(|_| cloud.splats.is_none());
        let others: Vec<(Bounds, f32)> =
            others.filter_map(|(_, other)| Some((other.bounds()?, other.largest_radius))).collect();
        let before = blocks.len() as u32;
        for (node, mut block) in cloud.blocks(scene) {
            let of_scene = |branch: Branch| Branch { parent: branch.parent.map(|parent| before + parent), ..branch };
            block.branch = block.branch.map(of_scene);
            // Discs of another cloud may be in the same places.
            let meets =
                |bounds: &Bounds| bounds.min.cmple(block.bounds.max).all() && block.bounds.min.cmple(bounds.max).all();
            let there = others.iter().filter(|(bounds, _)| meets(bounds)).map(|(_, radius)| *radius);
            block.radius = there.fold(block.radius, f32::max);
            blocks.push(block);
            nodes.push([index as u32, node as u32]);
        }
    }
    (blocks, nodes)
}
