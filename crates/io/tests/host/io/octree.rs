//! Clouds written as Potree 2.0 octrees and read back, whatever memory there is; octrees of others.

use std::fs;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use glam::{DVec3, Vec3};
use pellucid_core::cloud::field::Field;
use pellucid_core::cloud::{Bounds, Cloud, Prepared, UpAxis};
use pellucid_core::color::decode_srgb;
use pellucid_core::progress::{Observer, Progress};
use pellucid_io::store::build::{Built, Settings, build};
use pellucid_io::store::{Grid, MemoryStore, Node, Octree, Piece, Store, Summary, open, whole};
use pellucid_io::{Error, Hints, load};
use pellucid_testing_host::{root, whole_clouds};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::octree_bad::foreign;

const FILES: [&str; 5] = ["octree.bin", "hierarchy.bin", "nodes.bin", "survey.bin", "metadata.json"];

/// Settings that make many nodes and, if asked for, many files.
fn settings(host_memory: u64) -> Settings {
    Settings { node_points: 1000, host_memory }
}

pub const ROOMY: u64 = 1 << 30;
const TIGHT: u64 = 1 << 16;

/// Waves, a cluster far off, and many points in one place, with all columns that a prepared cloud has.
pub fn cloud(count: usize, seed: u64) -> Cloud {
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let position = |i: usize| {
        let [u, v, w]: [f64; 3] = [(); 3].map(|()| random.random());
        match i % 10 {
            0 => DVec3::new(-700.0 + 1e-4 * u, 1e-4 * v, -300.0 + 1e-4 * w),
            1 => DVec3::new(40.0, 40.0, 7.0),
            _ => DVec3::new(100.0 * u, 100.0 * v, (9.0 * u).sin() + 0.1 * w),
        }
    };
    let positions: Vec<DVec3> = (0..count).map(position).collect();
    let mut column = || (0..count).map(|_| random.random::<f32>()).collect::<Vec<f32>>();
    let prepared = Prepared {
        neighbors: 12,
        radius_cap: 4.0,
        estimated_radii: false,
        field: Field::Property { name: "height above".to_owned() },
        values: column(),
        shadows: None,
    };
    Cloud {
        positions,
        colors: Some((0..count).map(|i| Vec3::splat(decode_srgb((i % 256) as f32 / 255.0))).collect()),
        normals: Some(vec![Vec3::Y; count]),
        radii: Some(column()),
        intensity: Some(column()),
        classification: Some((0..count).map(|i| (i % 7) as u8).collect()),
        scalars: vec![("height above".to_owned(), column())],
        up: UpAxis::Y,
        prepared: Some(prepared),
        ..Cloud::default()
    }
}

pub fn held(cloud: Cloud) -> Box<dyn Store> {
    Box::new(MemoryStore::new(Path::new("memory"), cloud).unwrap())
}

pub fn write(inputs: &[Box<dyn Store>], folder: &Path, host_memory: u64) -> Built {
    build(inputs, folder, &settings(host_memory), &Progress::hidden()).unwrap()
}

fn bytes(folder: &Path) -> Vec<Vec<u8>> {
    let mut names: Vec<_> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    names.sort();
    let mut expected = FILES;
    expected.sort_unstable();
    assert_eq!(names, expected);
    FILES.map(|file| fs::read(folder.join(file)).unwrap()).to_vec()
}

/// All points of a store by their places, which must be 0, 1, 2, ….
fn points(store: &dyn Store) -> Cloud {
    let mut whole = store.summary().like.clone();
    let mut places = Vec::new();
    for node in 0..store.nodes().len() {
        let piece = store.read(node).unwrap();
        assert_eq!(piece.cloud.len() as u64, store.nodes()[node].points);
        whole.append(piece.cloud);
        places.extend(piece.places);
    }
    let mut order: Vec<u32> = (0..places.len() as u32).collect();
    order.sort_unstable_by_key(|i| places[*i as usize]);
    assert!(order.iter().enumerate().all(|(place, i)| places[*i as usize] == place as u64));
    whole.subset(&order)
}

/// Asserts that points are the same, except for positions, which may be rounded by `most`.
fn assert_same(back: Cloud, cloud: &Cloud, most: f64) {
    let moved = back.positions.iter().zip(&cloud.positions).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max);
    assert!(moved <= most, "{moved}");
    assert_eq!(Cloud { positions: cloud.positions.clone(), ..back }, *cloud);
}

#[test]
fn memory_changes_no_byte_and_every_point_comes_back() {
    let folder = tempfile::tempdir().unwrap();
    let cloud = cloud(20_000, 1);
    let [roomy, tight] = ["roomy", "tight"].map(|name| folder.path().join(name).join("store"));
    let (a, b) = (write(&[held(cloud.clone())], &roomy, ROOMY), write(&[held(cloud.clone())], &tight, TIGHT));
    assert_eq!(a, b);
    // 800 is below 2¹⁰, so a step of the grid is 2⁻²⁰.
    assert!(a.rounding > 0.0 && a.rounding < (-20_f64).exp2() && a.points == 20_000, "{a:?}");
    assert!(bytes(&roomy) == bytes(&tight));
    assert_eq!(fs::read_dir(tight.parent().unwrap()).unwrap().count(), 1, "nothing is left beside it");
    let octree = Octree::open(&tight).unwrap();
    assert_same(points(&octree), &cloud, a.rounding);
    let summary = octree.summary();
    assert_eq!((summary.points, summary.up), (20_000, UpAxis::Y));
    assert_eq!(summary.ranges[0].0, "height above");
    let within = cloud.bounds().unwrap();
    let off = (summary.bounds.min - within.min).abs().max((summary.bounds.max - within.max).abs());
    assert!(off.max_element() <= a.rounding, "the box is that of the points");
    assert!(octree.nodes().len() > 20);
}

/// Store with its nodes in another order.
#[derive(Debug)]
struct Turned(Octree);

impl Store for Turned {
    fn summary(&self) -> &Summary {
        self.0.summary()
    }

    fn nodes(&self) -> &[Node] {
        self.0.nodes()
    }

    fn read(&self, node: usize) -> Result<Piece, Error> {
        // The number of points of a node is told before, so only the order in a node can be another one.
        let Piece { cloud, places } = self.0.read(node)?;
        let order: Vec<u32> = (0..cloud.len() as u32).rev().collect();
        Ok(Piece { cloud: cloud.subset(&order), places: places.into_iter().rev().collect() })
    }
}

#[test]
fn a_store_made_of_a_store_is_the_same() {
    let folder = tempfile::tempdir().unwrap();
    let [first, second] = ["first", "second"].map(|name| folder.path().join(name).join("store"));
    write(&[held(cloud(5000, 1))], &first, ROOMY);
    write(&[Box::new(Turned(Octree::open(&first).unwrap()))], &second, TIGHT);
    let (mut a, mut b) = (bytes(&first), bytes(&second));
    // Rounded values are not rounded again.
    let text = |bytes: Vec<u8>| serde_json::from_slice::<serde_json::Value>(&bytes).unwrap();
    let (mut c, mut d) = (text(a.pop().unwrap()), text(b.pop().unwrap()));
    assert!(c["pellucid"]["rounding"].take().as_f64() > d["pellucid"]["rounding"].take().as_f64());
    assert_eq!(c, d);
    assert!(a == b);
    // In its own place.
    write(&[Box::new(Octree::open(&second).unwrap())], &second, TIGHT);
    b = bytes(&second);
    b.pop();
    assert!(a == b);
}

#[test]
fn several_clouds_become_one() {
    let folder = tempfile::tempdir().unwrap();
    let target = folder.path().join("store");
    let (a, plain) = (cloud(3000, 1), cloud(2000, 2));
    let b = Cloud { colors: None, scalars: Vec::new(), classification: None, ..plain };
    let built = write(&[held(a.clone()), held(b.clone())], &target, TIGHT);
    // Of 5000 random radii the smallest is small.
    let says =
        ["what was prepared for one of several clouds is left out", "more than a thousandth of the smallest radius"];
    assert!(
        built.notes.len() == 2 && built.notes.iter().zip(says).all(|(note, says)| note.contains(says)),
        "{built:?}"
    );
    let back = points(&Octree::open(&target).unwrap());
    let mut expected = Cloud { prepared: None, ..a };
    expected.append(Cloud {
        colors: Some(vec![Vec3::ONE; 2000]),
        classification: Some(vec![0; 2000]),
        scalars: vec![("height above".to_owned(), vec![f32::NAN; 2000])],
        prepared: None,
        ..b
    });
    let heights = |cloud: &Cloud| cloud.scalars[0].1.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
    assert_eq!(heights(&back), heights(&expected));
    let without = |cloud: Cloud| Cloud { scalars: Vec::new(), ..cloud };
    assert_same(without(back), &without(expected), built.rounding);
}

#[test]
fn real_scans_come_back_to_the_bit() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["lidar/sample_c_2k.las", "formats/las_extrabytes.las", "formats/laz_pointwise_nochunk.laz"] {
        let path = root().join("tests/data").join(name);
        let target = folder.path().join(name);
        let input = open(&path, Hints::default(), &Progress::hidden()).unwrap();
        let stored = points(&*input);
        let built = write(&[input], &target, TIGHT);
        assert_eq!(built.rounding, 0.0, "{name}");
        assert_same(points(&Octree::open(&target).unwrap()), &stored, 0.0);
        // As a cloud it is the file: every picture of it has the same bytes.
        assert_eq!(super::load(&target).unwrap(), super::load(&path).unwrap(), "{name}");
    }
}

/// A wall whose file does not say which way is up, and one whose file does.
#[test]
fn a_store_has_the_vertical_of_the_points_it_was_built_of() {
    let folder = tempfile::tempdir().unwrap();
    let position = |i: u32| DVec3::new(f64::from(i % 60), 0.01 * f64::from(i % 7), f64::from(i / 60));
    for (up_is_convention, up, name) in [(true, UpAxis::Y, "silent"), (false, UpAxis::Z, "stated")] {
        let positions = (0..3000).map(position).collect();
        let wall = Cloud { positions, up: UpAxis::Z, up_is_convention, ..Cloud::default() };
        let target = folder.path().join(name);
        write(&[held(wall)], &target, ROOMY);
        assert_eq!(Octree::open(&target).unwrap().summary().like.up_is_convention, up_is_convention);
        assert_eq!(load(&target, &Progress::hidden()).unwrap().up, up);
    }
}

#[test]
fn whole_scans_come_back_to_the_bit() {
    let Some(data) = whole_clouds() else { return };
    let folder = tempfile::tempdir().unwrap();
    for name in ["lidar/autzen_trim.laz", "lidar/ign_lidarhd_77050_627755_classified.laz"] {
        let path = data.join(name);
        let input = open(&path, Hints::default(), &Progress::hidden()).unwrap();
        let cloud = points(&*input);
        let target = folder.path().join(name);
        let built = write(&[input], &target, 4 << 20);
        assert_eq!(built.rounding, 0.0, "{name}");
        assert_same(points(&Octree::open(&target).unwrap()), &cloud, 0.0);
    }
}

/// Cancels the work when so many messages came.
struct Impatient {
    patience: usize,
    told: Arc<AtomicUsize>,
}

impl Observer for Impatient {
    fn advanced(&self, _done: u64, _total: Option<u64>) {
        self.told.fetch_add(1, Ordering::Relaxed);
    }

    fn is_cancelled(&self) -> bool {
        self.told.load(Ordering::Relaxed) > self.patience
    }
}

/// Counts what is read of a store.
#[derive(Debug)]
struct Counted(MemoryStore, Arc<AtomicUsize>);

impl Store for Counted {
    fn summary(&self) -> &Summary {
        self.0.summary()
    }

    fn nodes(&self) -> &[Node] {
        self.0.nodes()
    }

    fn read(&self, node: usize) -> Result<Piece, Error> {
        self.1.fetch_add(1, Ordering::Relaxed);
        self.0.read(node)
    }
}

#[test]
fn a_stopped_build_resumes_where_it_was() {
    let folder = tempfile::tempdir().unwrap();
    let [whole, parts] = ["whole", "parts"].map(|name| folder.path().join(name).join("store"));
    write(&[held(cloud(5000, 1))], &whole, TIGHT);
    let (reads, mut stops) = (Arc::new(AtomicUsize::new(0)), 0);
    let begin = || -> Vec<Box<dyn Store>> {
        let held = MemoryStore::new(Path::new("memory"), cloud(5000, 1)).unwrap();
        vec![Box::new(Counted(held, reads.clone()))]
    };
    // Each time a little further.
    for patience in 0.. {
        let observer = Impatient { patience: 6 * patience, told: Arc::default() };
        match build(&begin(), &parts, &settings(TIGHT), &Progress::observed(observer)) {
            Ok(_) => break,
            Err(error) => assert!(matches!(error, Error::Cancelled { .. }), "{error}"),
        }
        stops += 1;
        assert!(!parts.join("metadata.json").exists());
    }
    // The third pass alone has more chunks than that; the first two read the cloud once each.
    assert!(stops > 2 && reads.load(Ordering::Relaxed) == 2, "{stops} {reads:?}");
    assert!(bytes(&parts) == bytes(&whole));
    assert_eq!(fs::read_dir(parts.parent().unwrap()).unwrap().count(), 1);
}

#[test]
fn leftovers_of_other_builds_are_not_used() {
    let folder = tempfile::tempdir().unwrap();
    let [whole, again] = ["whole", "again"].map(|name| folder.path().join(name).join("store"));
    write(&[held(cloud(5000, 1))], &whole, TIGHT);
    let stopped = || {
        let observer = Impatient { patience: 12, told: Arc::default() };
        build(&[held(cloud(5000, 1))], &again, &settings(TIGHT), &Progress::observed(observer)).unwrap_err();
        again.parent().unwrap().join(".store.pellucid-unfinished")
    };
    // Another cloud.
    let work = stopped();
    assert!(work.join("state.json").exists());
    write(&[held(cloud(4000, 2))], &again, TIGHT);
    assert_eq!(Octree::open(&again).unwrap().summary().points, 4000);
    // Files that are gone or shorter.
    for file in ["octree.bin", "chunk.3", "written.jsonl", "chunk.4"] {
        let work = stopped();
        if file.starts_with('c') {
            fs::write(work.join(file), "short").unwrap();
        } else {
            fs::remove_file(work.join(file)).unwrap();
        }
        write(&[held(cloud(5000, 1))], &again, TIGHT);
        assert!(bytes(&again) == bytes(&whole), "{file}");
    }
}

#[test]
fn folders_of_others_are_left_alone() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("mine"), "precious").unwrap();
    let error = build(&[held(cloud(10, 1))], folder.path(), &settings(ROOMY), &Progress::hidden()).unwrap_err();
    assert!(error.to_string().ends_with("one with an octree to replace"), "{error}");
    let file = folder.path().join("mine");
    assert!(build(&[held(cloud(10, 1))], &file, &settings(ROOMY), &Progress::hidden()).is_err());
    assert_eq!(fs::read(&file).unwrap(), b"precious");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
}

/// A store that lies about its box.
#[derive(Debug)]
struct Lying(MemoryStore, Summary);

impl Store for Lying {
    fn summary(&self) -> &Summary {
        &self.1
    }

    fn nodes(&self) -> &[Node] {
        self.0.nodes()
    }

    fn read(&self, node: usize) -> Result<Piece, Error> {
        self.0.read(node)
    }
}

#[test]
fn points_outside_of_the_announced_box_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let held = MemoryStore::new(Path::new("memory"), cloud(100, 1)).unwrap();
    let summary = Summary {
        bounds: Bounds { min: DVec3::ZERO, max: DVec3::ONE },
        grid: Some(Grid { scale: DVec3::ONE, offset: DVec3::ZERO }),
        ..held.summary().clone()
    };
    let error =
        build(&[Box::new(Lying(held, summary))], &folder.path().join("a"), &settings(ROOMY), &Progress::hidden());
    let message = error.unwrap_err().to_string();
    assert!(message.starts_with("memory: point at ") && message.contains("outside the box"), "{message}");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0, "nothing is left");
}

#[test]
fn octrees_of_potree_are_read() {
    let (_folder, path) = foreign(|_| ());
    let octree = Octree::open(&path).unwrap();
    let summary = octree.summary();
    assert_eq!((summary.points, summary.up, octree.nodes().len()), (7, UpAxis::Z, 2));
    assert_eq!(summary.like.warnings, [""; 0]);
    let names: Vec<_> = summary.ranges.iter().map(|(name, range)| (&**name, *range)).collect();
    assert_eq!(names, [("return_number", [1.0, 1.0]), ("gps_time", [0.0, 6.0])]);
    let child = &octree.nodes()[1];
    assert_eq!((child.level, child.parent, child.spacing, child.bytes), (1, Some(0), 0.125, 99));
    // To half a step of the grid, and to rounding.
    assert!((child.bounds.min - DVec3::new(103.5, -0.5, -0.5)).abs().max_element() < 1e-6, "{child:?}");
    let cloud = points(&octree);
    assert_eq!(cloud.positions[4], DVec3::new(104.5, 2.0, 1.5));
    assert_eq!(cloud.intensity.unwrap(), [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
    assert_eq!(cloud.classification.unwrap(), [0, 1, 2, 3, 4, 5, 6]);
    // 8 bits in 16, as in LAS files.
    assert_eq!(cloud.colors.unwrap()[5], Vec3::new(1.0, decode_srgb(5.0 / 255.0), 0.0));
    let scalars: Vec<_> = cloud.scalars.iter().map(|(name, values)| (&**name, values[6])).collect();
    assert_eq!(scalars, [("return_number", 1.0), ("gps_time", 6.0)]);
    let file = Octree::open(&path.join("metadata.json")).unwrap();
    assert_eq!(file.summary().points, 7);
    let input = open(&path, Hints::default(), &Progress::hidden()).unwrap();
    assert_eq!(input.summary().points, 7);
}

#[test]
fn withheld_points_of_potree_are_left_out() {
    // Each point's flags are its number: 4, 5 and 6 have the bit of withheld points.
    let (_folder, path) = foreign(|metadata| metadata["attributes"][3]["name"] = "classification flags".into());
    let octree = Octree::open(&path).unwrap();
    let pieces = [0, 1].map(|node| octree.read(node).unwrap());
    let places: Vec<u64> = pieces.iter().flat_map(|piece| piece.places.clone()).collect();
    assert_eq!(places, [0, 1, 2, 3]);
    assert_eq!(pieces.iter().map(|piece| piece.cloud.withheld).sum::<usize>(), 3);
    let cloud = whole(&octree, &Progress::hidden()).unwrap();
    assert_eq!((cloud.len(), cloud.withheld, cloud.warnings), (4, 3, vec![]));
}
