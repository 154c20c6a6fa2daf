//! Values of stores, found region by region, are those of the whole cloud in memory, to the bit.

use std::path::Path;

use glam::{DVec3, Vec3};
use pellucid_core::cloud::Cloud;
use pellucid_core::cloud::field::Field;
use pellucid_core::progress::Progress;
use pellucid_io::store::build::Settings;
use pellucid_io::store::{MemoryStore, Octree, Store, open};
use pellucid_io::{self as io, Hints};
use pellucid_scene::prepare::{self, Request};
use pellucid_testing_host::{root, whole_clouds};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// Regions of a few hundred points.
const TIGHT: Settings = Settings { node_points: 500, host_memory: 200 << 10 };

fn held(cloud: Cloud) -> Box<dyn Store> {
    Box::new(MemoryStore::new(Path::new("memory"), cloud).unwrap())
}

/// All points of a store by their places.
fn whole(store: &dyn Store) -> Cloud {
    let mut whole = store.summary().like.clone();
    let mut places = Vec::new();
    for node in 0..store.nodes().len() {
        let piece = store.read(node).unwrap();
        whole.append(piece.cloud);
        places.extend(piece.places);
    }
    let mut order: Vec<u32> = (0..places.len() as u32).collect();
    order.sort_unstable_by_key(|i| places[*i as usize]);
    whole.subset(&order)
}

fn made(inputs: &[Box<dyn Store>], request: &Request, settings: &Settings) -> Cloud {
    let folder = tempfile::tempdir().unwrap();
    let target = folder.path().join("store");
    prepare::store::prepare(inputs, &target, request, settings, &Progress::hidden()).unwrap();
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "nothing is left beside it");
    whole(&Octree::open(&target).unwrap())
}

fn bits(values: &[f32]) -> Vec<u32> {
    values.iter().map(|value| value.to_bits()).collect()
}

/// Compares a prepared store with what is found for its points at once.
#[track_caller]
fn assert_whole(cloud: &Cloud, given: Option<Vec<Vec3>>, request: &Request, about: &str) {
    let plain = Cloud { radii: None, prepared: None, normals: given, ..cloud.clone() };
    let request = Request { radii: true, fields: true, ..request.clone() };
    let found = prepare::find(&plain, &request, &Progress::hidden()).unwrap();
    let prepared = cloud.prepared.as_ref().unwrap();
    assert!(prepared.estimated_radii && prepared.neighbors == request.neighbors_of(&plain));
    let differ = |a: &[f32], b: &[f32]| bits(a).iter().zip(bits(b)).filter(|(a, b)| *a != b).count();
    assert_eq!(differ(cloud.radii.as_ref().unwrap(), &found.radii.unwrap()), 0, "radii of {about}");
    assert_eq!(differ(&prepared.values, &found.fields.unwrap()), 0, "field of {about}");
    if request.normals {
        let flat = |normals: &[Vec3]| normals.iter().flat_map(Vec3::to_array).collect::<Vec<f32>>();
        let (own, found) = (flat(cloud.normals.as_ref().unwrap()), flat(&found.normals.unwrap()));
        assert_eq!(differ(&own, &found), 0, "normals of {about}");
    }
}

/// Points on a plane, in a ball and on a grid with many at one distance, copies of some, and outliers far from all.
fn cloud(count: usize) -> Cloud {
    let mut random = Pcg64Mcg::seed_from_u64(11);
    let mut number = || random.random::<f64>();
    let mut positions: Vec<DVec3> = (0..count).map(|_| DVec3::new(number(), number(), 0.01 * number())).collect();
    positions.extend((0..count / 4).map(|_| DVec3::new(number(), number(), number()) * 0.1));
    positions.extend((0..20).map(|_| DVec3::new(number(), number(), number()) * 50.0));
    positions.extend((0..count / 4).map(|_| (DVec3::new(number(), number(), 0.0) * 16.0).floor() + 3.0 * DVec3::Z));
    positions.extend_from_within(..count / 8);
    Cloud { positions, ..Cloud::default() }
}

#[test]
fn regions_change_no_bit() {
    let cloud = cloud(3000);
    let request = |neighbors, radius_cap, normals| Request {
        neighbors: Some(neighbors),
        radius_cap: Some(radius_cap),
        normals,
        ..Request::default()
    };
    for request in [request(24, 4.0, false), request(8, 0.0, true), request(3, 1.1, true)] {
        let about = format!("{request:?}");
        let tight = made(&[held(cloud.clone())], &request, &TIGHT);
        assert_whole(&tight, None, &request, &about);
        let roomy = made(&[held(cloud.clone())], &request, &Settings { host_memory: 1 << 30, ..TIGHT });
        assert!(tight == roomy, "{about}");
    }
}

#[test]
fn given_normals_count() {
    let mut cloud = cloud(2000);
    let mut random = Pcg64Mcg::seed_from_u64(2);
    let normal = |i: usize| {
        if i.is_multiple_of(3) { Vec3::ZERO } else { Vec3::from([(); 3].map(|()| random.random::<f32>())).normalize() }
    };
    let normals: Vec<Vec3> = (0..cloud.len()).map(normal).collect();
    cloud.normals = Some(normals.clone());
    for normals_wanted in [false, true] {
        let request = Request { normals: normals_wanted, ..Request::default() };
        let made = made(&[held(cloud.clone())], &request, &TIGHT);
        assert_whole(&made, Some(normals.clone()), &request, "given normals");
    }
}

#[test]
fn fields_of_columns_are_scaled_by_the_whole_cloud() {
    let mut cloud = cloud(2000);
    let count = cloud.len();
    cloud.scalars = vec![("age".to_owned(), (0..count).map(|i| (i as f32).sin() * 7.0).collect())];
    cloud.intensity = Some((0..count).map(|i| (i % 250) as f32).collect());
    cloud.classification = Some((0..count).map(|i| (i % 5) as u8).collect());
    let fields = [
        Field::Property { name: "age".to_owned() },
        Field::Property { name: "z".to_owned() },
        Field::Intensity,
        Field::Classification { classes: vec![1, 3] },
        Field::DistanceToAxis { point: None, direction: Some([1.0, 2.0, 0.5]) },
    ];
    for field in fields {
        let request = Request { neighbors: Some(4), field: Some(field.clone()), ..Request::default() };
        let made = made(&[held(cloud.clone())], &request, &TIGHT);
        assert_whole(&made, None, &request, field.name());
        assert_eq!(made.scalars, cloud.scalars);
    }
    let request = Request { field: Some(Field::Property { name: "aeg".to_owned() }), ..Request::default() };
    let folder = tempfile::tempdir().unwrap();
    let target = folder.path().join("store");
    let error = prepare::store::prepare(&[held(cloud)], &target, &request, &TIGHT, &Progress::hidden()).unwrap_err();
    assert!(error.to_string().contains("no scalar property `aeg`") && error.to_string().contains("age"), "{error}");
}

#[test]
fn few_points_and_own_radii() {
    let one = Cloud { positions: vec![DVec3::ONE], ..Cloud::default() };
    for count in [1, 2, 5] {
        let positions = (0..count).map(|i| DVec3::splat(f64::from(i * i))).collect();
        let made = made(&[held(Cloud { positions, ..one.clone() })], &Request::default(), &TIGHT);
        assert_whole(&made, None, &Request::default(), &format!("{count} points"));
    }
    let radii = Some((0..1000).map(|i| i as f32 * 0.25).collect());
    let own = Cloud { radii, ..cloud(1000).subset(&(0..1000).collect::<Vec<u32>>()) };
    let made = made(&[held(own.clone())], &Request::default(), &TIGHT);
    assert!(made.radii == own.radii && !made.prepared.unwrap().estimated_radii);
}

#[test]
fn several_scans_have_neighbors_in_each_other() {
    let path = root().join("tests/data/lidar/sample_c_2k.las");
    let cloud = io::load(&path, &Progress::hidden()).unwrap();
    let [even, odd] = [0, 1].map(|first| cloud.subset(&(first..cloud.len() as u32).step_by(2).collect::<Vec<u32>>()));
    let made = made(&[held(even), held(odd)], &Request::default(), &TIGHT);
    assert_whole(&made, None, &Request::default(), "two halves");
    let prepared = prepare::store::prepare;
    // A prepared store is used as it is.
    let folder = tempfile::tempdir().unwrap();
    let [first, second] = ["first", "second"].map(|name| folder.path().join(name));
    let input = open(&path, Hints::default(), &Progress::hidden()).unwrap();
    prepared(&[input], &first, &Request::default(), &TIGHT, &Progress::hidden()).unwrap();
    let again = Octree::open(&first).unwrap();
    prepared(&[Box::new(again)], &second, &Request::default(), &TIGHT, &Progress::hidden()).unwrap();
    for file in ["octree.bin", "hierarchy.bin", "nodes.bin", "survey.bin"] {
        assert!(std::fs::read(first.join(file)).unwrap() == std::fs::read(second.join(file)).unwrap(), "{file}");
    }
}

#[test]
fn real_scans_change_no_bit() {
    let Some(data) = whole_clouds() else { return };
    for name in ["lidar/autzen_trim.laz", "models/bun_zipper.ply", "indoor/livingroom_fragment_double.ply"] {
        let input = open(&data.join(name), Hints::default(), &Progress::hidden()).unwrap();
        let request = Request { normals: true, ..Request::default() };
        let settings = Settings { node_points: 2000, host_memory: 8 << 20 };
        let given = whole(&*input).normals;
        let made = made(&[input], &request, &settings);
        assert_whole(&made, given, &request, name);
    }
}
