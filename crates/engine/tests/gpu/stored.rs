//! Scenes whose clouds stay where they are stored: the same bytes as with all points in memory and on the device.

use std::path::{Path, PathBuf};

use glam::{DVec3, Quat, Vec3};
use pellucid_core::cloud::gaussians::{Gaussians, coefficients, linear};
use pellucid_core::cloud::{Cloud, UpAxis};
use pellucid_core::color::ColorSpace;
use pellucid_core::progress::Progress;
use pellucid_engine::methods::{Frame, Rendered, Renderer};
use pellucid_gpu::Device;
use pellucid_io::store::build::Settings;
use pellucid_io::store::{MemoryStore, Store};
use pellucid_scene::prepare::{self, Arranged, Request};
use pellucid_scene::stored::{Stored, open_stores};
use pellucid_scene::{self as scene, MapResolution, Method, Overrides, Scene};
use pellucid_testing::{bits, by_windows, random, with_device};
use rand::RngExt;

/// Nodes of few points, and less memory than a cloud takes.
const TIGHT: Settings = Settings { node_points: 1000, host_memory: 1 << 20 };
/// Bytes on the device: some thousands of points at a time.
const DEVICE: u64 = 5 << 19;
/// Bytes on the device with room for images of lights.
const ROOMY: u64 = 8 << 20;
/// Bytes of nodes that are kept.
const HOST: u64 = 2 << 20;

/// Points about a few bumps and in a cloud above them, some of them in one place, with everything that a cloud may
/// have.
fn cloud(seed: u64, count: usize) -> Cloud {
    let mut random = random(seed);
    let mut number = move || random.random::<f32>();
    let mut cloud = Cloud { up: UpAxis::Z, ..Cloud::default() };
    let (mut colors, mut alphas, mut normals, mut radii) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    let (mut classes, mut intensities) = (Vec::new(), Vec::new());
    for i in 0..count {
        let [x, y] = [number(), number()].map(|u| 2.0 * u - 1.0);
        let z = if i % 4 == 0 { 0.5 + 0.4 * number() } else { 0.2 * (5.0 * x).sin() * (4.0 * y).cos() };
        cloud.positions.push(DVec3::new(x.into(), y.into(), z.into()));
        colors.push(Vec3::new(number(), number(), number()));
        alphas.push(if i % 7 == 0 { 1.0 } else { number() });
        normals.push(Vec3::new(number() - 0.5, number() - 0.5, 0.2 + number()).normalize());
        radii.push(0.002 + 0.02 * number() * number());
        classes.push([1, 2, 5, 6][i % 4]);
        intensities.push(1000.0 * number());
    }
    // Some in one place, of other looks.
    for i in (0..count / 2).step_by(50) {
        cloud.positions[count - 1 - i] = cloud.positions[i];
    }
    (cloud.colors, cloud.alphas, cloud.normals) = (Some(colors), Some(alphas), Some(normals));
    (cloud.radii, cloud.classification, cloud.intensity) = (Some(radii), Some(classes), Some(intensities));
    cloud
}

/// A store of a cloud, in a folder.
fn store(folder: &Path, name: &str, cloud: Cloud) -> PathBuf {
    store_of(folder, name, cloud, &TIGHT)
}

/// A store of a cloud with other settings than [`TIGHT`].
fn store_of(folder: &Path, name: &str, cloud: Cloud, settings: &Settings) -> PathBuf {
    let target = folder.join(name);
    let input = [Box::new(MemoryStore::new(Path::new("memory"), cloud).unwrap()) as Box<dyn Store>];
    prepare::store::prepare(&input, &target, &Request::default(), settings, &Progress::hidden()).unwrap();
    target
}

/// A scene of one method.
fn scene_of(text: &str, method: &Method) -> Scene {
    let mut overrides = Overrides::default();
    overrides.set_pair(&format!("method.name={}", method.name())).unwrap();
    Scene::from_toml_with(text, Path::new("scene.toml"), &overrides).unwrap()
}

/// A scene in memory.
fn whole_of(scene: &Scene) -> Arranged {
    let hidden = Progress::hidden();
    scene::arrange(scene, scene::load_clouds(scene, &hidden).unwrap(), 3, &hidden).unwrap()
}

/// A scene in its stores.
fn stored_of(scene: &Scene) -> Stored {
    let hidden = Progress::hidden();
    Stored::new(scene, &open_stores(scene, &hidden).unwrap(), HOST, &hidden).unwrap()
}

/// A scene of one method in memory and in its stores.
fn both(text: &str, method: &Method) -> (Scene, Arranged, Stored) {
    let scene = scene_of(text, method);
    let (whole, stored) = (whole_of(&scene), stored_of(&scene));
    (scene, whole, stored)
}

fn rendered(device: &Device, arranged: &Arranged, frame: &Frame) -> Result<Rendered, String> {
    let mut renderer = Renderer::new(device).expect("a renderer");
    let mut cloud = renderer.upload(arranged).map_err(|error| error.to_string())?;
    renderer.render(&mut cloud, frame).map_err(|error| error.to_string())
}

/// Every method that is not dealt, with the camera that is found.
fn assert_same(text: &str, about: &str) {
    assert_same_of(text, about, Method::all().into_iter().filter(|method| !method.is_dealt()));
}

/// Compares some methods with the camera that is found.
fn assert_same_of(text: &str, about: &str, methods: impl Iterator<Item = Method>) {
    with_device(|device| {
        let mut differ = Vec::new();
        // Points are the same for all methods that want as much of them.
        let mut known: Vec<([bool; 2], Arranged, Stored)> = Vec::new();
        for method in methods {
            let scene = scene_of(text, &method);
            let wants = [method.needs_radii(), method.needs_field()];
            let at = known.iter().position(|(of, ..)| *of == wants).unwrap_or_else(|| {
                known.push((wants, whole_of(&scene), stored_of(&scene)));
                known.len() - 1
            });
            let (_, whole, stored) = &known[at];
            // Nodes are read anew.
            stored.forget();
            assert!(stored.notes.is_empty(), "{:?}", stored.notes);
            let (camera, _) = scene::camera(&scene, whole.points(), UpAxis::Z).unwrap();
            let (found, _) = scene::camera(stored.scene(), &stored.sample, stored.up()).unwrap();
            assert_eq!(found, camera, "{about}");
            let frame = Frame { fragments: true, ..Frame::of_scene(&scene, camera, 3) };
            let expected = rendered(device, whole, &frame).expect("a frame");
            let small = Frame { memory_budget: Some(DEVICE), ..frame };
            match rendered(device, &stored.arranged(), &small) {
                Ok(image) if bits(&image.image) == bits(&expected.image) && image.facts.windows > 1 => {
                    assert_eq!(image.image.fragments, expected.image.fragments, "{about}, {}", method.name());
                }
                Ok(image) => {
                    let pairs = bits(&image.image).into_iter().zip(bits(&expected.image));
                    let off = pairs.filter(|(a, b)| a != b).count();
                    differ.push(format!("{}: {off} values, {} windows", method.name(), image.facts.windows));
                }
                Err(error) => differ.push(format!("{}: {error}", method.name())),
            }
        }
        assert!(differ.is_empty(), "{about}:\n{}", differ.join("\n"));
    });
}

#[test]
fn every_method_renders_a_store_with_the_bytes_of_memory() {
    let folder = tempfile::tempdir().unwrap();
    let path = store(folder.path(), "one", cloud(1, 10_000));
    let text = format!("[image]\nsize = [96, 72]\n[[cloud]]\npath = '{}'\nopacity = 0.4\n", path.display());
    assert_same(&text, "one store");
}

/// Splats in a cube, most of them small and few of them huge, some in one place.
fn splats(seed: u64, count: usize, degree: u32) -> Cloud {
    let mut random = random(seed);
    let mut vector = |range: std::ops::Range<f32>| Vec3::from([(); 3].map(|()| random.random_range(range.clone())));
    let mut cloud = Cloud { up: UpAxis::Z, ..Cloud::default() };
    let mut gaussians = Gaussians { degree, ..Gaussians::default() };
    for i in 0..count {
        cloud.positions.push(DVec3::from(vector(-1.0..1.0)));
        let larger = if i % 500 == 3 { 2.5 } else { 0.0 };
        gaussians.extents.push((vector(-6.5..-4.0) + larger).exp());
        let [axis, turn] = [vector(-1.0..1.0), vector(0.0..6.0)];
        gaussians.rotations.push(Quat::from_axis_angle(axis.normalize(), turn.x));
        gaussians.bases.push(vector(-0.25..1.25));
        gaussians.harmonics.extend((0..coefficients(degree)).map(|_| vector(-0.3..0.3)));
    }
    for i in (0..count / 2).step_by(50) {
        cloud.positions[count - 1 - i] = cloud.positions[i];
    }
    let mut random = pellucid_testing::random(seed + 1);
    cloud.alphas = Some((0..count).map(|_| random.random()).collect());
    cloud.colors = Some(gaussians.bases.iter().map(|base| linear(*base)).collect());
    cloud.gaussians = Some(gaussians);
    cloud
}

/// Methods of discs by their names.
fn named(names: &[&str]) -> impl Iterator<Item = Method> {
    let names: Vec<String> = names.iter().map(|name| (*name).to_owned()).collect();
    Method::all().into_iter().filter(move |method| names.iter().any(|name| name == method.name()))
}

const EXACT: [&str; 3] = ["abuffer", "sorted", "stochastic"];

#[test]
fn stores_of_splats_have_the_bytes_of_memory() {
    let folder = tempfile::tempdir().unwrap();
    let path = store(folder.path(), "one", splats(1, 10_000, 2));
    let text = format!("[image]\nsize = [96, 72]\n[[cloud]]\npath = '{}'\n", path.display());
    assert_same_of(&text, "splats", Method::all().into_iter().filter(|method| method.discs().is_some()));
}

#[test]
fn splats_reach_as_far_as_their_least_opacity_and_kernel_say() {
    let folder = tempfile::tempdir().unwrap();
    let path = store(folder.path(), "one", splats(2, 8_000, 1));
    for settings in ["alpha_min = 1e-5\ndilation = 3.0", "kernel = 'ray'\nalpha_min = 1e-3", "order = 'distance'"] {
        for view in ["", "fov_y = 95\neye = [0.3, 0.2, -0.9]\ntarget = [0, 0, 0.2]", "ortho = true"] {
            let text = format!(
                "[image]\nsize = [96, 72]\n[method]\nname = 'abuffer'\n{settings}\n[camera]\n{view}\n[[cloud]]\npath = '{}'\n",
                path.display()
            );
            assert_same_of(&text, &format!("{settings}, {view}"), named(&["abuffer"]));
        }
    }
}

#[test]
fn stores_of_splats_and_of_points_share_a_scene() {
    let folder = tempfile::tempdir().unwrap();
    let [one, two] = [(3, 6_000, 0), (4, 6_000, 3)]
        .map(|(seed, count, degree)| store(folder.path(), &format!("store{seed}"), splats(seed, count, degree)));
    let points = store(folder.path(), "points", cloud(5, 4_000));
    let text = format!(
        "[image]\nsize = [96, 72]\n[[clip]]\nslab = {{ axis = 'z', min = -0.6, max = 0.9 }}\n\
         [[cloud]]\npath = '{}'\nopacity = 0.8\nscale = 0.5\ntranslate = [0.2, 0, 0.1]\n\
         [[cloud]]\npath = '{}'\nsh_degree = 1\n\
         [[cloud]]\npath = '{}'\nopacity = 0.4\n",
        one.display(),
        two.display(),
        points.display()
    );
    assert_same_of(&text, "splats and points", named(&EXACT));
    // Without harmonics a splat takes so little that the budget has room for one store.
    let [one, two] = [one, two].map(|path| format!("[[cloud]]\npath = '{}'\ncolor = [1, 0.5, 0]\n", path.display()));
    let painted = format!("[image]\nsize = [96, 72]\n{one}{two}scale = 1.5\n");
    assert_same_of(&painted, "splats of one color", named(&EXACT));
}

/// A picture of a file in memory, and one of its store, of which some comes at a time.
#[test]
fn the_picture_of_a_store_is_that_of_the_file_that_it_was_made_of() {
    let soups = pellucid_testing::root().join("tests/data/splats");
    let hidden = Progress::hidden();
    for name in ["soup.sog", "soup.ply", "soup-v4.spz", "soup.compressed.ply", "soup.glb", "soup-mode2.ksplat"] {
        let (folder, file) = (tempfile::tempdir().unwrap(), soups.join(name));
        let target = folder.path().join("store");
        let input = [pellucid_io::store::open(&file, Default::default(), &hidden).unwrap()];
        prepare::store::prepare(&input, &target, &Request::default(), &TIGHT, &hidden).unwrap();
        let scene = |path: &Path, method: &str| {
            let mut overrides = Overrides::default();
            overrides.set_pair(&format!("method.name={method}")).unwrap();
            let text = format!("[image]\nsize = [64, 48]\n[[cloud]]\npath = '{}'\n", path.display());
            Scene::from_toml_with(&text, Path::new("scene.toml"), &overrides).unwrap()
        };
        for method in EXACT {
            let mut of_file = scene(&file, method);
            let clouds = scene::load_clouds(&of_file, &hidden).unwrap();
            let up = scene::up_axis(&clouds);
            assert_eq!(of_file.settle(&clouds), Some(ColorSpace::Encoded));
            let whole = scene::arrange(&of_file, clouds, 3, &hidden).unwrap();
            let of_store = scene(&target, method);
            let stored = Stored::new(&of_store, &open_stores(&of_store, &hidden).unwrap(), HOST, &hidden).unwrap();
            assert_eq!(stored.blend_space, Some(ColorSpace::Encoded));
            let (camera, _) = scene::camera(&of_file, whole.points(), up).unwrap();
            assert_eq!(scene::camera(stored.scene(), &stored.sample, stored.up()).unwrap().0, camera, "{name}");
            let (of_file, of_store) =
                (Frame::of_scene(&of_file, camera, 3), Frame::of_scene(stored.scene(), camera, 3));
            with_device(|device| {
                let expected = rendered(device, &whole, &of_file).expect("a frame");
                let found = rendered(device, &stored.arranged(), &of_store).expect("a frame");
                assert!(bits(&found.image) == bits(&expected.image), "{name}, {method}");
            });
        }
    }
}

/// Gaussians that stay in the host's memory, and come some at a time.
#[test]
fn splats_in_memory_come_window_by_window() {
    let path = PathBuf::from("splats");
    let text = "[image]\nsize = [96, 72]\n[method]\nname = 'stochastic'\n[[cloud]]\npath = 'splats'\n";
    let scene = Scene::from_toml_with(text, &path, &Overrides::default()).unwrap();
    let whole = scene::arrange(&scene, vec![splats(7, 20_000, 1)], 3, &Progress::hidden()).unwrap();
    let (camera, _) = scene::camera(&scene, whole.points(), UpAxis::Z).unwrap();
    let frame = Frame::of_scene(&scene, camera, 3);
    let Arranged::Canonical(points) = &whole else { panic!("an order by content") };
    with_device(|device| {
        let expected = rendered(device, &whole, &frame).expect("a frame");
        let mut renderer = Renderer::new(device).expect("a renderer");
        let mut cloud = by_windows(&renderer, points);
        let small = Frame { memory_budget: Some(DEVICE), ..frame };
        let found = renderer.render(&mut cloud, &small).expect("a frame");
        assert!(bits(&found.image) == bits(&expected.image) && found.facts.windows > 1);
    });
}

/// Levels leave nodes out; splats that are left stay as they are, and no budget changes a byte.
#[test]
fn levels_of_splats_leave_some_out() {
    let folder = tempfile::tempdir().unwrap();
    let path = store(folder.path(), "one", splats(6, 20_000, 0));
    let text =
        format!("[image]\nsize = [96, 72]\n[detail]\nmax_points = 9000\n[[cloud]]\npath = '{}'\n", path.display());
    let (scene, whole, stored) = both(&text, &named(&["stochastic"]).next().unwrap());
    let (camera, _) = scene::camera(&scene, whole.points(), UpAxis::Z).unwrap();
    let frame = Frame::of_scene(&scene, camera, 3);
    with_device(|device| {
        let all = rendered(device, &whole, &Frame { detail: Default::default(), ..frame }).expect("a frame");
        let roomy = rendered(device, &stored.arranged(), &frame).expect("a frame");
        let tight = Frame { memory_budget: Some(2 << 20), ..frame };
        let tight = rendered(device, &stored.arranged(), &tight).expect("a frame");
        assert!(bits(&roomy.image) == bits(&tight.image) && tight.facts.windows > roomy.facts.windows);
        assert!(bits(&roomy.image) != bits(&all.image));
    });
}

#[test]
fn windows_are_as_large_as_their_points_let_them_be_however_large_nodes_are() {
    let folder = tempfile::tempdir().unwrap();
    let path = store_of(folder.path(), "one", cloud(4, 60_000), &LOOSE);
    let text = format!("[image]\nsize = [320, 240]\n[[cloud]]\npath = '{}'\n", path.display());
    let (scene, whole, stored) = both(&text, &Method::Points);
    with_device(|device| {
        let (camera, _) = scene::camera(&scene, whole.points(), UpAxis::Z).unwrap();
        let frame = Frame { memory_budget: Some(5 << 20), ..Frame::of_scene(&scene, camera, 3) };
        let image = rendered(device, &stored.arranged(), &frame).expect("a frame");
        assert!(bits(&image.image) == bits(&rendered(device, &whole, &frame).expect("a frame").image));
        // Memory has room for 7000 points of a window, and the image has 300 tiles.
        assert!((9..60).contains(&image.facts.windows), "{} windows", image.facts.windows);
        let [read, all] = stored.bytes_read();
        assert!(read <= image.facts.windows * all, "{read} bytes of {all} were read");
    });
}

#[test]
fn several_stores_with_clips_classes_and_color_maps_have_the_bytes_of_memory() {
    let folder = tempfile::tempdir().unwrap();
    let [one, two] =
        [(1, 8_000), (2, 4_000)].map(|(seed, count)| store(folder.path(), &format!("store{seed}"), cloud(seed, count)));
    let text = format!(
        "[image]\nsize = [120, 90]\n[shading]\nmodel = 'lambert'\n\
         [[clip]]\nslab = {{ axis = 'z', min = -0.15, max = 0.8 }}\n\
         [[cloud]]\npath = '{}'\ncolor_by = 'height'\nopacity = 0.5\n\
         [[cloud.class]]\nid = 5\nvisible = false\n[[cloud.class]]\nid = 6\nopacity = 0.9\ncolor = [1, 0, 0]\n\
         [[cloud]]\npath = '{}'\nscale = 0.7\ntranslate = [0.3, 0.1, -0.05]\ncolor_by = 'intensity'\nopacity = 0.3\n",
        one.display(),
        two.display()
    );
    assert_same(&text, "two stores");
}

#[test]
fn radii_of_classes_in_stores_are_those_of_memory() {
    let folder = tempfile::tempdir().unwrap();
    let path = store(folder.path(), "one", cloud(1, 12_000));
    // Far larger than those of the file: discs reach into windows from nodes far outside of them.
    let large = "[[cloud.class]]\nid = 6\nradius = 0.2\nopacity = 0.05\n[[cloud.class]]\nid = 'ground'\nradius = 0.001\n\
                 [[cloud.class]]\nscalar = 'intensity'\nrange = [990, 1000]\nradius = 0.15\n";
    // Smaller ones for all: the cloud's own radius, which no point has, moves no camera.
    let small = [1, 2, 5, 6].map(|id| format!("[[cloud.class]]\nid = {id}\nradius = 0.0{id}\n")).concat();
    let methods =
        || Method::all().into_iter().filter(|method| ["circles", "abuffer", "soft-base"].contains(&method.name()));
    assert_eq!(methods().count(), 3);
    for (radius, classes) in [("", large), ("radius = 0.02", large), ("radius = 3\nradius_factor = 0.5", &small)] {
        let text = format!(
            "[image]\nsize = [96, 72]\n[[cloud]]\npath = '{}'\nopacity = 0.4\n{radius}\n{classes}",
            path.display()
        );
        assert_same_of(&text, radius, methods());
    }
}

/// The methods that deal points to ensembles: less of them than there are, and each several times; with the lists of
/// both ways, and with all points on the device and some at a time.
fn assert_same_dealt(text: &str, about: &str, settings: &[(&str, f64)]) {
    let folder = tempfile::tempdir().unwrap();
    with_device(|device| {
        for (setting, opacity_factor) in settings {
            let hidden = Progress::hidden();
            let mut overrides = Overrides::default();
            setting.split(' ').for_each(|pair| overrides.set_pair(pair).unwrap());
            let scene = Scene::from_toml_with(text, Path::new("scene.toml"), &overrides).unwrap();
            let clouds = scene::load_clouds(&scene, &hidden).unwrap();
            let whole = scene::arrange(&scene, clouds, 3, &hidden).unwrap();
            let stored = Stored::new(&scene, &open_stores(&scene, &hidden).unwrap(), HOST, &hidden).unwrap();
            let filed = stored.dealt(3, folder.path(), &hidden).unwrap();
            assert_eq!(filed.surfaces(), whole.surfaces(), "{about}, {setting}");
            let (Arranged::Dealt(dealt), Arranged::Supplied(supplied)) = (&whole, &filed) else {
                panic!("{about}: dealt")
            };
            let file = supplied.dealt.as_ref().expect("a file");
            let found = file.read(0..file.len()).unwrap();
            assert!(found.positions == dealt.points.positions, "{about}: the order of the list");
            assert!(found.dealt_ids == dealt.points.dealt_ids, "{about}: ids");
            assert!(found.colors == dealt.points.colors && found.normals == dealt.points.normals, "{about}: columns");

            let (camera, _) = scene::camera(&scene, whole.points(), UpAxis::Z).unwrap();
            let mut frame = Frame { spread: true, ..Frame::of_scene(&scene, camera, 3) };
            frame.factors.opacity = *opacity_factor as f32;
            let expected = rendered(device, &whole, &frame).expect("a frame");
            for memory_budget in [None, Some(SOME)] {
                let image = rendered(device, &filed, &Frame { memory_budget, ..frame }).expect("a frame of the file");
                assert_eq!(image.facts.streamed.is_some(), memory_budget.is_some(), "{about}, {setting}");
                assert_eq!(image.facts.slots, expected.facts.slots, "{about}, {setting}");
                assert!(bits(&image.image) == bits(&expected.image), "{about}, {setting}, {memory_budget:?}");
                assert_eq!(image.image.stderr, expected.image.stderr, "{about}, {setting}");
            }
            eprintln!("{about}, {setting}: {} slots of {} points", expected.facts.slots, file.len());
        }
    });
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0, "files without names");
}

/// Nodes of stores that are made in less time.
const LOOSE: Settings = Settings { node_points: 10_000, host_memory: 32 << 20 };

/// Bytes on the device that points take more than: some of the list come at a time.
const SOME: u64 = 3 << 20;

#[test]
fn stores_are_dealt_to_ensembles_as_in_memory() {
    let folder = tempfile::tempdir().unwrap();
    let path = store_of(folder.path(), "one", cloud(1, 70_000), &LOOSE);
    let text = format!("[image]\nsize = [160, 120]\n[[cloud]]\npath = '{}'\nopacity = 0.4\n", path.display());
    // k below and above 1, and all points once.
    let settings = [
        ("method.name=spbr method.ensembles=5", 0.1),
        ("method.name=spbr method.ensembles=20", 1.0),
        ("method.name=spbr-simplified method.ensembles=7 method.brightness=1", 1.0),
    ];
    assert_same_dealt(&text, "one store", &settings);
}

#[test]
fn several_stores_are_dealt_each_by_its_opacity() {
    let folder = tempfile::tempdir().unwrap();
    let [one, two, three] = [(1, 100_000), (2, 12_000), (3, 30_000)]
        .map(|(seed, count)| store_of(folder.path(), &format!("store{seed}"), cloud(seed, count), &LOOSE));
    // None of the second one's points is drawn.
    let text = format!(
        "[image]\nsize = [120, 90]\n[shading]\nmodel = 'lambert'\n\
         [[clip]]\nslab = {{ axis = 'z', min = -0.15, max = 0.8 }}\n\
         [[cloud]]\npath = '{}'\ncolor_by = 'height'\nopacity = 0.5\n\
         [[cloud.class]]\nid = 5\nvisible = false\n[[cloud.class]]\nid = 6\nopacity = 0.9\ncolor = [1, 0, 0]\n\
         [[cloud]]\npath = '{}'\ntranslate = [0, 0, 50]\n\
         [[cloud]]\npath = '{}'\nscale = 0.7\ntranslate = [0.3, 0.1, -0.05]\ncolor_by = 'intensity'\nopacity = 0.02\n",
        one.display(),
        two.display(),
        three.display()
    );
    assert_same_dealt(&text, "three stores", &[("method.name=spbr method.ensembles=30", 1.0)]);
}

#[test]
fn many_points_in_one_place_are_told_apart_or_refused() {
    let folder = tempfile::tempdir().unwrap();
    let mut cloud = cloud(5, 90_000);
    cloud.positions[..3000].fill(DVec3::new(0.25, 0.5, 0.125));
    let path = store_of(folder.path(), "heap", cloud.clone(), &LOOSE);
    let text = format!("[image]\nsize = [80, 60]\n[[cloud]]\npath = '{}'\nopacity = 0.4\n", path.display());
    assert_same_dealt(&text, "a heap", &[("method.name=spbr method.ensembles=10", 1.0)]);
    cloud.positions[..20_000].fill(DVec3::new(0.25, 0.5, 0.125));
    let path = store_of(folder.path(), "heaps", cloud, &LOOSE);
    let text = format!("[method]\nname = 'spbr'\n[[cloud]]\npath = '{}'\n", path.display());
    let scene = Scene::from_toml_with(&text, Path::new("scene.toml"), &Overrides::default()).unwrap();
    let hidden = Progress::hidden();
    let stored = Stored::new(&scene, &open_stores(&scene, &hidden).unwrap(), HOST, &hidden).unwrap();
    let error = stored.dealt(3, folder.path(), &hidden).unwrap_err().to_string();
    assert!(error.contains("in one place") && error.contains("--host-memory"), "{error}");
    let missing = stored.dealt(3, &folder.path().join("missing"), &hidden).unwrap_err().to_string();
    assert!(missing.contains("missing"), "{missing}");
}

#[test]
fn points_without_normals_are_told_of_where_they_would_count() {
    let folder = tempfile::tempdir().unwrap();
    let mut cloud = cloud(7, 3000);
    cloud.normals.as_mut().unwrap()[5] = Vec3::ZERO;
    let some = store(folder.path(), "some", cloud.clone());
    let none = store(folder.path(), "none", Cloud { normals: None, ..cloud });
    let hidden = Progress::hidden();
    let opened = |path: &Path, settings: &str| {
        let text = format!("{settings}\n[[cloud]]\npath = '{}'\n", path.display());
        let scene = Scene::from_toml_with(&text, Path::new("scene.toml"), &Overrides::default()).unwrap();
        let stores = open_stores(&scene, &hidden).unwrap();
        Stored::new(&scene, &stores, HOST, &hidden).map(|stored| stored.notes.clone())
    };
    let unlit = "[shading]\nmodel = 'none'\n[method]\nname";
    for path in [&some, &none] {
        for (settings, is_told) in [
            ("[shading]\nmodel = 'auto'", true),
            (&format!("{unlit} = 'circles'"), false),
            // Its opacity depends on how points lie.
            (&format!("{unlit} = 'spbr'\ncos_theta = false"), true),
        ] {
            let notes = opened(path, settings).unwrap();
            assert_eq!(notes.iter().any(|note| note.contains("prepare --normals")), is_told, "{settings}: {notes:?}");
        }
    }
    assert_eq!(opened(&some, "[shading]\nmodel = 'phong'").unwrap().len(), 1);
    assert!(opened(&none, "[shading]\nmodel = 'phong'").unwrap_err().to_string().contains("normals"));
}

#[test]
fn shadows_are_cast_by_all_points_of_stores() {
    let folder = tempfile::tempdir().unwrap();
    let path = store(folder.path(), "lit", cloud(1, 20_000));
    // Hard and soft ones of the sun, and those of a lamp among the points, which takes six images.
    let lights = [
        ("light = [0.3, 0.2, -0.9]", "samples = 1\nresolution = 96"),
        ("light = [0.3, 0.2, -0.9]", "samples = 3\nlight_radius = 4.0"),
        ("light = { position = [0.1, 0.2, 0.6] }", "samples = 2\nlight_radius = 0.05\nfill = 3"),
    ];
    for (light, shadows) in lights {
        let text = format!(
            "[image]\nsize = [120, 90]\n[shading]\nmodel = 'lambert'\nambient = 0.1\ndiffuse = 0.9\n{light}\n\
             [shadows]\n{shadows}\n[[cloud]]\npath = '{}'\n",
            path.display()
        );
        let methods = Method::all().into_iter().filter(Method::takes_shadows);
        let methods = methods.filter(|method| ["circles", "image-space", "peel-layers"].contains(&method.name()));
        assert_same_of(&text, &format!("{light}, {shadows}"), methods);
    }
    // Frames of other lights, and of none, one after the other; and images that don't fit.
    let (light, shadows) = lights[0];
    let text = format!(
        "[image]\nsize = [120, 90]\n[shading]\nmodel = 'lambert'\n{light}\n[shadows]\n{shadows}\n\
         [[cloud]]\npath = '{}'\n",
        path.display()
    );
    let circles = Method::all().into_iter().find(|method| method.name() == "circles").unwrap();
    let (scene, whole, stored) = both(&text, &circles);
    let (camera, _) = scene::camera(&scene, whole.points(), UpAxis::Z).unwrap();
    let lit = Frame::of_scene(&scene, camera, 3);
    let mut other = lit;
    other.shadows.as_mut().unwrap().light_radius = 9.0;
    let dark = Frame { shadows: None, ..lit };
    with_device(|device| {
        let mut renderer = Renderer::new(device).expect("a renderer");
        let mut cloud = renderer.upload(&stored.arranged()).expect("small buffers");
        let images = [lit, other, dark, lit].map(|frame| {
            let expected = rendered(device, &whole, &frame).expect("a frame");
            let small = Frame { memory_budget: Some(ROOMY), ..frame };
            let found = renderer.render(&mut cloud, &small).expect("a frame");
            assert!(bits(&found.image) == bits(&expected.image), "{:?}", frame.shadows);
            bits(&found.image)
        });
        assert!(images[0] != images[1] && images[1] != images[2] && images[0] != images[2]);
        let mut large = Frame { memory_budget: Some(ROOMY), ..lit };
        large.shadows.as_mut().unwrap().resolution = MapResolution::Pixels(1024);
        let error = renderer.render(&mut cloud, &large).unwrap_err().to_string();
        assert!(error.contains("1024 × 1024 pixels, 1 in all") && error.contains("--memory-budget"), "{error}");
    });
}
