//! Landscapes that are written as octrees while they are made: every point once, the same bytes whatever the memory,
//! and runs that end early.

use std::fs;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use glam::DVec3;
use pellucid_core::cloud::{Bounds, Cloud};
use pellucid_core::progress::{Observer, Progress};
use pellucid_io::Error;
use pellucid_io::store::build::{Built, Cube, Settings, Streamed, Types, stream};
use pellucid_io::store::{Grid, MemoryStore, Octree, Store, whole};
use pellucid_scene::prepare;
use pellucid_scene::procedural::terrain::Terrain;
use pellucid_scene::{self as scene, Scene};

const FILES: [&str; 5] = ["hierarchy.bin", "metadata.json", "nodes.bin", "octree.bin", "survey.bin"];

/// Memory for a cell of some 6000 points, and for all.
const TIGHT: u64 = 1 << 20;
const ROOMY: u64 = 1 << 30;

fn write(terrain: &Terrain, folder: &Path, host_memory: u64, progress: &Progress) -> Result<Built, Error> {
    terrain.write(folder, &Settings { node_points: 500, host_memory }, progress)
}

fn bytes(folder: &Path) -> Vec<Vec<u8>> {
    let mut names: Vec<_> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    names.sort();
    assert_eq!(names, FILES);
    FILES.map(|file| fs::read(folder.join(file)).unwrap()).to_vec()
}

#[test]
fn neither_memory_nor_threads_change_a_byte() {
    let folder = tempfile::tempdir().unwrap();
    let store = folder.path().join("store");
    let terrain = Terrain::new(60_000, 2).unwrap();
    let built = write(&terrain, &store, ROOMY, &Progress::hidden()).unwrap();
    assert_eq!((built.points, built.rounding, built.notes.len()), (60_000, 0.0, 0));
    let roomy = bytes(&store);
    write(&terrain, &store, TIGHT, &Progress::hidden()).unwrap();
    assert!(bytes(&store) == roomy, "in parts");
    let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    alone.install(|| write(&terrain, &store, TIGHT, &Progress::hidden()).unwrap());
    assert!(bytes(&store) == roomy, "one thread");
    assert_eq!(fs::read_dir(&folder).unwrap().count(), 1, "nothing is left beside");
    write(&Terrain::new(60_000, 3).unwrap(), &store, ROOMY, &Progress::hidden()).unwrap();
    assert!(bytes(&store) != roomy, "another seed");
    let octree = Octree::open(&store).unwrap();
    assert!(octree.nodes().len() > 100 && octree.nodes().iter().all(|node| node.points <= 500));
    assert_eq!(fs::metadata(store.join("octree.bin")).unwrap().len(), 60_000 * 23);
}

#[test]
fn a_store_renders_like_the_points_in_memory() {
    let folder = tempfile::tempdir().unwrap();
    let store = folder.path().join("terrain");
    let terrain = Terrain::new(50_000, 1).unwrap();
    write(&terrain, &store, TIGHT, &Progress::hidden()).unwrap();
    let read = whole(&Octree::open(&store).unwrap(), &Progress::hidden()).unwrap();
    let made = Cloud { normals: None, ..whole(&terrain, &Progress::hidden()).unwrap() };
    assert_eq!((read.subset(&[]), read.len()), (made.subset(&[]), 50_000));
    // Everything that a renderer knows of the points, in its order.
    let path = folder.path().join("scene.toml");
    fs::write(&path, terrain.scene_toml("terrain")).unwrap();
    let scene = Scene::read(&path, &Default::default()).unwrap();
    assert_eq!((scene.warnings.len(), &scene.clouds[0].path), (0, &store));
    let points = |cloud: Cloud| {
        let mut points =
            prepare::order::canonical(scene::assemble(&scene, vec![cloud], true, &Progress::hidden()).unwrap());
        points.file_order.clear();
        points
    };
    assert!(points(read) == points(made));
}

/// Ends the work after so many points, and keeps how far it was when it began.
struct Stop {
    after: u64,
    first: Arc<AtomicU64>,
    last: AtomicU64,
}

impl Observer for Stop {
    fn advanced(&self, done: u64, _total: Option<u64>) {
        self.last.store(done, Ordering::Relaxed);
        if done > 0 {
            let _ = self.first.compare_exchange(0, done, Ordering::Relaxed, Ordering::Relaxed);
        }
    }

    fn is_cancelled(&self) -> bool {
        self.last.load(Ordering::Relaxed) >= self.after
    }
}

#[test]
fn work_that_was_ended_goes_on() {
    let folder = tempfile::tempdir().unwrap();
    let [store, other] = ["store", "other"].map(|name| folder.path().join(name));
    let terrain = Terrain::new(150_000, 4).unwrap();
    write(&terrain, &other, ROOMY, &Progress::hidden()).unwrap();
    let run = |after: u64| {
        let first = Arc::new(AtomicU64::new(0));
        let progress = Progress::observed(Stop { after, first: first.clone(), last: AtomicU64::new(0) });
        (write(&terrain, &store, TIGHT, &progress), first.load(Ordering::Relaxed))
    };
    let (ended, start) = run(100_000);
    assert!(matches!(ended, Err(Error::Cancelled { .. })) && !store.exists() && start < 10_000, "{ended:?} {start}");
    let work = folder.path().join(".store.pellucid-unfinished");
    let kept = folder.path().join("kept");
    fs::create_dir(&kept).unwrap();
    for entry in fs::read_dir(&work).unwrap() {
        let entry = entry.unwrap();
        fs::copy(entry.path(), kept.join(entry.file_name())).unwrap();
    }
    let (made, start) = run(u64::MAX);
    // Four cells of up to 6168 points are made between the moments that are written down.
    assert!(made.is_ok() && start > 50_000, "{made:?} {start}");
    assert!(bytes(&store)[3] == bytes(&other)[3]);
    fs::remove_dir_all(&store).unwrap();
    // An earlier run that lacks a file is as if there were none.
    for lost in ["octree.bin", "written.jsonl"] {
        fs::create_dir(&work).unwrap();
        fs::read_dir(&kept).unwrap().map(|entry| entry.unwrap()).for_each(|entry| {
            fs::copy(entry.path(), work.join(entry.file_name())).unwrap();
        });
        fs::remove_file(work.join(lost)).unwrap();
        let (made, start) = run(u64::MAX);
        assert!(made.is_ok() && start < 10_000, "{lost}: {made:?} {start}");
        assert!(bytes(&store)[3] == bytes(&other)[3], "{lost}");
    }
}

#[test]
fn clouds_that_are_not_as_announced_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let store = folder.path().join("store");
    let cloud = Cloud { positions: vec![DVec3::ZERO, DVec3::new(0.5, 0.25, 1.0)], ..Cloud::default() };
    let layout = Types::default().columns(&cloud);
    let held = MemoryStore::new(Path::new("held"), cloud).unwrap();
    let write = |scale: f64, side: f64| {
        let grid = Grid { scale: DVec3::splat(scale), offset: DVec3::ZERO };
        let cube = Cube::around(grid, &Bounds { min: DVec3::ZERO, max: DVec3::splat(side) }).unwrap();
        let streamed = Streamed { store: &held, cube, layout: &layout, key: "two points" };
        stream(&streamed, &store, &Settings::default(), &Progress::hidden())
    };
    for (scale, side, says) in [(0.5, 1.0, "off the grid"), (0.25, 0.5, "lies outside the octree")] {
        let error = write(scale, side).unwrap_err().to_string();
        assert!(error.contains("held") && error.contains(says), "{error}");
        assert!(!store.exists());
    }
    assert_eq!(write(0.25, 1.0).unwrap().points, 2);
}
