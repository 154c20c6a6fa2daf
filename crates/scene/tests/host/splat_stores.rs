//! Gaussian splats in octrees: every bit comes back, and octrees that lie are refused.

use std::fs;
use std::path::{Path, PathBuf};

use glam::{DVec3, Quat, Vec3};
use pellucid_core::cloud::gaussians::{ColorCoding, Gaussians, coefficients, linear, reach};
use pellucid_core::cloud::{Cloud, UpAxis};
use pellucid_core::progress::Progress;
use pellucid_io::store::build::{Built, Settings, build};
use pellucid_io::store::{MemoryStore, Octree, Store, announced, open};
use pellucid_io::{Error, Hints};
use pellucid_scene::prepare::{self, Request};
use pellucid_testing_host::random;
use rand::RngExt;
use tempfile::TempDir;

/// The folder of small files.
fn folder() -> PathBuf {
    pellucid_testing_host::root().join("tests/data/splats")
}

fn load(path: &Path) -> Result<Cloud, Error> {
    pellucid_io::load(path, &Progress::hidden())
}

/// A file in each format, and one that is not on any grid.
const FIXTURES: [&str; 14] = [
    "soup.ply",
    "soup-of-sog.ply",
    "soup-of-folder.ply",
    "soup.compressed.ply",
    "soup.splat",
    "soup-v1.spz",
    "soup-v4.spz",
    "soup.sog",
    "soup-folder",
    "soup-mode0.ksplat",
    "soup-mode1.ksplat",
    "soup-mode2.ksplat",
    "soup.glb",
    "draft.gltf",
];

fn settings(node_points: usize, host_memory: u64) -> Settings {
    Settings { node_points, host_memory }
}

const ROOMY: u64 = 1 << 30;

fn held(cloud: Cloud) -> Box<dyn Store> {
    Box::new(MemoryStore::new(Path::new("memory"), cloud).unwrap())
}

fn written(inputs: &[Box<dyn Store>], settings: &Settings) -> (TempDir, PathBuf, Built) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("store");
    let built = prepare::store::prepare(inputs, &path, &Request::default(), settings, &Progress::hidden()).unwrap();
    (folder, path, built)
}

/// Splats in a cube of side 2 at any float64, some of them in one place.
fn soup(count: usize, degree: u32) -> Cloud {
    let mut random = random(count as u64);
    let mut vector = |range: std::ops::Range<f32>| Vec3::from([(); 3].map(|()| random.random_range(range.clone())));
    let mut gaussians = Gaussians { degree, ..Gaussians::default() };
    let mut positions: Vec<DVec3> = Vec::new();
    for i in 0..count {
        let place = DVec3::from(vector(-1.0..1.0)) + 1e-9 * DVec3::from(vector(0.0..1.0));
        positions.push(if i % 50 == 7 { positions[i / 2] } else { place });
        gaussians.extents.push(vector(-6.0..-2.0).exp());
        let [axis, turn] = [vector(-1.0..1.0), vector(0.0..6.0)];
        gaussians.rotations.push(Quat::from_axis_angle(axis.normalize(), turn.x));
        gaussians.bases.push(vector(-0.25..1.25));
        gaussians.harmonics.extend((0..coefficients(degree)).map(|_| vector(-0.5..0.5)));
    }
    Cloud {
        colors: Some(gaussians.bases.iter().map(|base| linear(*base)).collect()),
        alphas: Some((0..count).map(|i| i as f32 / count as f32).collect()),
        positions,
        gaussians: Some(gaussians),
        up: UpAxis::NegativeY,
        ..Cloud::default()
    }
}

/// All bits of a cloud of splats.
fn bits(cloud: &Cloud) -> (Vec<u64>, Vec<u32>) {
    let splats = cloud.gaussians.as_ref().expect("splats");
    let positions = cloud.positions.iter().flat_map(|p| p.to_array().map(f64::to_bits)).collect();
    let colors = cloud.colors.iter().flatten().flat_map(|color| color.to_array());
    let columns = colors.chain(cloud.alphas.iter().flatten().copied()).map(f32::to_bits);
    (positions, columns.chain((0..splats.len()).flat_map(|i| splats.bits(i))).collect())
}

#[test]
fn linear_and_display_colors_stay_what_they_are() {
    let coded = |coding: ColorCoding, count: usize, degree: u32| {
        let mut cloud = soup(count, degree);
        let all = cloud.gaussians.as_mut().unwrap();
        all.coding = coding;
        cloud.colors = Some((0..count).map(|at| all.linear_base(at)).collect());
        cloud
    };
    let each = ColorCoding::Each((0..60).map(|at| at % 4 == 1).collect());
    for cloud in [coded(ColorCoding::Linear, 90, 1), coded(each.clone(), 60, 0), soup(50, 2)] {
        let (_folder, target, _) = written(&[held(cloud.clone())], &settings(8, ROOMY));
        assert_eq!(load(&target).unwrap(), cloud);
        let like = Octree::open(&target).unwrap().summary().like.gaussians.clone().unwrap();
        assert_eq!(like.may_be_linear(), cloud.gaussians.unwrap().may_be_linear(), "what is known before any is read");
    }
    // Two clouds in one store keep theirs.
    let (first, second) = (coded(ColorCoding::Linear, 30, 1), soup(40, 1));
    let (_folder, target, _) = written(&[held(first.clone()), held(second.clone())], &settings(8, ROOMY));
    let mut both = first;
    both.append(second);
    assert_eq!(load(&target).unwrap(), both);
    assert_eq!((0..70).filter(|at| both.gaussians.as_ref().unwrap().is_linear(*at)).count(), 30);
}

#[test]
fn every_format_comes_back_to_the_bit() {
    for name in FIXTURES {
        let path = folder().join(name);
        let store = open(&path, Hints::default(), &Progress::hidden()).unwrap();
        let (_folder, target, built) = written(&[store], &settings(8, ROOMY));
        let (cloud, back) = (load(&path).unwrap(), load(&target).unwrap());
        assert!(bits(&back) == bits(&cloud), "{name}");
        // Warnings of the source about points that it left out are not kept.
        assert_eq!(Cloud { warnings: back.warnings.clone(), ..cloud }, back, "{name}");
        assert_eq!((built.points, built.rounding), (back.len() as u64, 0.0), "{name}");
        let octree = Octree::open(&target).unwrap();
        assert!(octree.nodes().len() > 5, "{name}: {} nodes", octree.nodes().len());
        let degree = back.gaussians.map(|splats| splats.degree);
        assert_eq!(announced(&target, &Hints::default()).unwrap(), Some((built.points, degree)), "{name}");
    }
}

#[test]
fn memory_and_a_second_store_change_no_bit() {
    for degree in 0..=4 {
        let cloud = soup(3000, degree);
        let (_first, path, _) = written(&[held(cloud.clone())], &settings(200, ROOMY));
        assert!(bits(&load(&path).unwrap()) == bits(&cloud), "degree {degree}");
        let (_second, tight, _) = written(&[held(cloud.clone())], &settings(200, 1 << 16));
        let again = [Box::new(Octree::open(&path).unwrap()) as Box<dyn Store>];
        let (_third, again, _) = written(&again, &settings(200, ROOMY));
        for file in ["octree.bin", "hierarchy.bin", "nodes.bin", "survey.bin"] {
            let read = |path: &Path| fs::read(path.join(file)).unwrap();
            assert!(read(&path) == read(&tight), "{file} with little memory");
        }
        assert!(bits(&load(&again).unwrap()) == bits(&cloud), "degree {degree}, again");
    }
}

#[test]
fn nodes_tell_how_far_their_splats_reach() {
    let (_folder, path, _) = written(&[held(soup(2000, 1))], &settings(200, ROOMY));
    let octree = Octree::open(&path).unwrap();
    for (at, node) in octree.nodes().iter().enumerate() {
        let cloud = octree.read(at).unwrap().cloud;
        let splats = cloud.gaussians.as_ref().unwrap();
        let farthest = splats.extents.iter().map(|extents| reach(*extents)).fold(0.0, f32::max);
        assert_eq!(node.largest_radius.unwrap_or(0.0), farthest);
        assert!(cloud.bounds().is_none_or(|bounds| node.bounds.holds(&bounds)));
    }
    let survey = octree.survey().unwrap().unwrap();
    let whole = load(&path).unwrap();
    assert_eq!(survey.facts, pellucid_core::cloud::facts::Facts::of(&whole));
}

#[test]
fn several_files_get_the_highest_degree() {
    let inputs = [soup(500, 0), soup(300, 3), soup(200, 1)];
    let (_folder, path, built) = written(&inputs.clone().map(held), &settings(200, ROOMY));
    let back = load(&path).unwrap();
    let splats = back.gaussians.unwrap();
    assert_eq!((built.points, splats.degree, built.notes), (1000, 3, Vec::new()));
    let first = inputs[0].gaussians.clone().unwrap().with_degree(3);
    assert!((0..500).all(|i| splats.bits(i).eq(first.bits(i))));
    let second = inputs[1].gaussians.as_ref().unwrap();
    assert!((0..300).all(|i| splats.bits(500 + i).eq(second.bits(i))));
}

#[test]
fn splats_and_other_points_are_no_single_store() {
    let folder = tempfile::tempdir().unwrap();
    let points = Cloud { gaussians: None, ..soup(10, 0) };
    let named = |name: &str, cloud| Box::new(MemoryStore::new(Path::new(name), cloud).unwrap()) as Box<dyn Store>;
    let inputs = [named("points.ply", points), named("splats.sog", soup(10, 0))];
    let target = folder.path().join("store");
    let error = build(&inputs, &target, &settings(100, ROOMY), &Progress::hidden()).unwrap_err();
    assert!(matches!(error, Error::Mixed { .. }) && !target.exists());
    let says = error.to_string();
    assert!(says.starts_with("splats.sog has Gaussian splats, points.ply has points"), "{says}");
}

/// A store of splats of degree 2 whose description is changed.
fn changed(change: impl Fn(&mut serde_json::Value)) -> (TempDir, PathBuf) {
    let (folder, path, _) = written(&[held(soup(300, 2))], &settings(100, ROOMY));
    let file = path.join("metadata.json");
    let mut metadata: serde_json::Value = serde_json::from_slice(&fs::read(&file).unwrap()).unwrap();
    change(&mut metadata);
    fs::write(file, metadata.to_string()).unwrap();
    (folder, path)
}

/// The place of an attribute by its name.
fn at(metadata: &serde_json::Value, name: &str) -> usize {
    let attributes = metadata["attributes"].as_array().unwrap();
    attributes.iter().position(|attribute| attribute["name"] == name).unwrap()
}

#[test]
fn stores_of_splats_that_lie_are_refused() {
    type Change<'a> = &'a dyn Fn(&mut serde_json::Value);
    let role = |metadata: &mut serde_json::Value, name: &str, role: serde_json::Value| {
        let at = at(metadata, name);
        metadata["pellucid"]["roles"][at] = role;
    };
    let cases: [(Change<'_>, &str); 5] = [
        // Of another degree, of one that no format has, and of more numbers than there are.
        (&|m| role(m, "harmonics", serde_json::json!({"harmonics": 1})), "24 of type Float can't be Harmonics(1)"),
        (&|m| role(m, "harmonics", serde_json::json!({"harmonics": 200})), "24 of type Float can't be Harmonics(200)"),
        (
            &|m| role(m, "extents", serde_json::json!("ignored")),
            "need extents, rotation and base, but there is no extents",
        ),
        (&|m| role(m, "exact_position", serde_json::json!("rotation")), "3 of type Double can't be Rotation"),
        (
            &|m| {
                let at = at(m, "harmonics");
                (m["attributes"][at]["numElements"], m["attributes"][at]["size"]) = (45.into(), 180.into());
                m["pellucid"]["roles"][at] = serde_json::json!({"harmonics": 3});
            },
            "points of",
        ),
    ];
    for (change, says) in cases {
        let (_folder, path) = changed(change);
        let error = Octree::open(&path).expect_err(says).to_string();
        assert!(error.starts_with(&path.display().to_string()) && error.contains(says), "{says}: {error}");
    }
    // A version that is not known makes them points.
    let (_folder, path) = changed(|m| m["pellucid"]["version"] = 9.into());
    let cloud = load(&path).unwrap();
    assert!(cloud.gaussians.is_none() && cloud.warnings[0].contains("prepared in format 9"), "{:?}", cloud.warnings);
}

#[test]
fn files_that_are_cut_short_are_refused() {
    let (_folder, path) = changed(|_| ());
    let file = path.join("octree.bin");
    let whole = fs::read(&file).unwrap();
    fs::write(&file, &whole[..whole.len() - 1]).unwrap();
    let error = Octree::open(&path).unwrap_err().to_string();
    assert!(error.contains("octree.bin") && error.contains(&format!("the file has {}", whole.len() - 1)), "{error}");
    fs::write(&file, &whole).unwrap();
    // More points in the hierarchy than bytes in the file.
    let file = path.join("hierarchy.bin");
    let mut hierarchy = fs::read(&file).unwrap();
    hierarchy[2..6].copy_from_slice(&u32::MAX.to_le_bytes());
    fs::write(&file, hierarchy).unwrap();
    let error = Octree::open(&path).unwrap_err().to_string();
    assert!(error.contains("bytes don't match 4294967295 points of"), "{error}");
}

/// Changes the numbers of an attribute of the first points.
fn overwrite(path: &Path, name: &str, points: usize, bytes: &[u8]) {
    let metadata: serde_json::Value = serde_json::from_slice(&fs::read(path.join("metadata.json")).unwrap()).unwrap();
    let sizes = metadata["attributes"].as_array().unwrap().iter().map(|one| one["size"].as_u64().unwrap() as usize);
    let sizes: Vec<usize> = sizes.collect();
    let (stride, first): (usize, usize) = (sizes.iter().sum(), sizes[..at(&metadata, name)].iter().sum());
    let file = path.join("octree.bin");
    let mut records = fs::read(&file).unwrap();
    for record in records.chunks_exact_mut(stride).take(points) {
        record[first..first + bytes.len()].copy_from_slice(bytes);
    }
    fs::write(file, records).unwrap();
}

#[test]
fn numbers_that_no_splat_has_are_left_out_and_counted() {
    let floats = |values: &[f32]| values.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
    let nan = f32::NAN;
    let cases = [
        ("extents", floats(&[0.0; 3])),
        ("extents", floats(&[1e-3, f32::INFINITY, 0.0])),
        ("rotation", floats(&[0.0; 4])),
        ("rotation", floats(&[nan, 0.0, 0.0, 1.0])),
        ("base", floats(&[nan])),
        ("harmonics", floats(&[0.0, f32::NEG_INFINITY])),
        ("alpha", floats(&[nan])),
        ("exact_position", f64::INFINITY.to_le_bytes().to_vec()),
    ];
    for (name, bytes) in cases {
        let (_folder, path) = changed(|_| ());
        overwrite(&path, name, 20, &bytes);
        let cloud = load(&path).unwrap();
        assert_eq!((cloud.len(), cloud.gaussians.as_ref().map(Gaussians::len)), (280, Some(280)), "{name}");
        let says = format!("{:?}", cloud.warnings);
        assert!(says.contains("20 splats are left out"), "{name}: {says}");
    }
    let (_folder, path) = changed(|_| ());
    overwrite(&path, "extents", 300, &floats(&[0.0; 3]));
    let error = load(&path).unwrap_err().to_string();
    assert!(error.contains("300 splats are left out"), "{error}");
    // A quaternion of another length is turned into one of 1; an extent below 0 is one above.
    let (_folder, path) = changed(|_| ());
    overwrite(&path, "rotation", 300, &floats(&[0.0, 3e20, 0.0, 4e20]));
    overwrite(&path, "extents", 300, &floats(&[-1e-5, 1e-5, 0.0]));
    let splats = load(&path).unwrap().gaussians.unwrap();
    assert!(splats.rotations[5].abs_diff_eq(Quat::from_xyzw(0.0, 0.6, 0.0, 0.8), 1e-6), "{}", splats.rotations[5]);
    assert_eq!(splats.extents[5], Vec3::new(1e-5, 1e-5, 0.0));
    // Farther than the node says, and outside its box.
    for (name, bytes, says) in [
        ("extents", floats(&[9.0]), "but the largest should be"),
        ("exact_position", 7.0_f64.to_le_bytes().to_vec(), "outside its box"),
    ] {
        let (_folder, path) = changed(|_| ());
        overwrite(&path, name, 1, &bytes);
        let error = load(&path).unwrap_err().to_string();
        assert!(error.contains(says), "{says}: {error}");
    }
}
