//! Determinism of clouds that stay where they are stored: every subject and the garden give the same bytes, in stores
//! of small nodes and within little memory.

use std::path::{Path, PathBuf};

use pellucid_core::cloud::field::Field;
use pellucid_core::cloud::{Cloud, Prepared, UpAxis};
use pellucid_core::points::Points;
use pellucid_core::progress::Progress;
use pellucid_engine::methods::{Error, Frame, Rendered, Renderer};
use pellucid_gpu::Device;
use pellucid_io::store::build::Settings;
use pellucid_io::store::{MemoryStore, Store};
use pellucid_lab::check::{self, Lack, MethodScene};
use pellucid_scene::prepare::{self, Arranged, DEFAULT_NEIGHBORS, Request, radius};
use pellucid_scene::stored::{Stored, open_stores};
use pellucid_scene::{self as scene, Method, Overrides, Scene, procedural};
use pellucid_testing::{is_llvmpipe, with_device};

/// Nodes of few points.
const SMALL: Settings = Settings { node_points: 1000, host_memory: 16 << 20 };
/// Bytes on the device.
const DEVICE: u64 = 8 << 20;
/// Bytes of memory.
const HOST: u64 = 64 << 20;

/// A store of a cloud with radii and a field; its path. With `normals` those that points lack are estimated.
fn store(folder: &Path, name: &str, cloud: Cloud, normals: bool) -> PathBuf {
    let target = folder.join(name);
    let input = [Box::new(MemoryStore::new(Path::new(name), cloud).expect("points")) as Box<dyn Store>];
    let request = Request { normals, ..Request::default() };
    let built = prepare::store::prepare(&input, &target, &request, &SMALL, &Progress::hidden());
    built.expect("a store");
    target
}

/// A scene with its points in memory, and in its stores.
struct Both {
    whole: Arranged,
    stored: Arranged,
    scene: Scene,
}

impl Both {
    fn new(scene: Scene, seed: u64, folder: &Path) -> Self {
        let hidden = Progress::hidden();
        let clouds = scene::load_clouds(&scene, &hidden).expect("clouds");
        let whole = scene::arrange(&scene, clouds, seed, &hidden).expect("points");
        let stores = open_stores(&scene, &hidden).expect("stores");
        let stored = Stored::new(&scene, &stores, HOST, &hidden).expect("a scene");
        let is_dealt = matches!(whole, Arranged::Dealt(_));
        let stored = if is_dealt { stored.dealt(seed, folder, &hidden).expect("dealt") } else { stored.arranged() };
        Self { whole, stored, scene }
    }

    /// Returns the difference between the images, if there is one, and the number of regions.
    fn compare(&self, device: &Device, frame: &Frame) -> Result<(Option<String>, u64), Error> {
        let expected = rendered(device, &self.whole, frame)?;
        let found = rendered(device, &self.stored, &Frame { memory_budget: Some(DEVICE), ..*frame })?;
        let difference = check::difference(&expected.image, &found.image);
        Ok((difference.map(|difference| difference.to_string()), found.facts.windows))
    }
}

/// The subjects that stores hold: files of Gaussians are read as a whole, and no store has splats.
fn subjects() -> Vec<MethodScene> {
    let are_points = |subject: &MethodScene| subject.clouds.iter().all(|cloud| cloud.gaussians.is_none());
    check::subjects().into_iter().filter(are_points).collect()
}

fn rendered(device: &Device, arranged: &Arranged, frame: &Frame) -> Result<Rendered, Error> {
    let mut renderer = Renderer::new(device)?;
    let mut cloud = renderer.upload(arranged)?;
    renderer.render(&mut cloud, frame)
}

/// A subject's points as a file might hold them.
fn cloud(points: &Points) -> Cloud {
    let prepared = Prepared {
        neighbors: DEFAULT_NEIGHBORS,
        radius_cap: radius::DEFAULT_CAP,
        estimated_radii: false,
        field: Field::Uncertainty,
        values: points.fields.clone(),
        shadows: None,
    };
    Cloud {
        positions: points.positions.clone(),
        colors: Some(points.colors.clone()),
        alphas: Some(points.opacities.clone()),
        normals: points.normals.clone(),
        radii: Some(points.radii.clone()),
        prepared: Some(prepared),
        up: UpAxis::Y,
        ..Cloud::default()
    }
}

fn scene_of(paths: &[PathBuf], method: Method) -> Scene {
    let clouds: String = paths.iter().map(|path| format!("[[cloud]]\npath = '{}'\n", path.display())).collect();
    let text = format!("[shading]\nmodel = 'none'\n{clouds}");
    let scene = Scene::from_toml_with(&text, Path::new("scene.toml"), &Overrides::default()).expect("a scene");
    Scene { method: method.into(), ..scene }
}

#[test]
fn subjects_in_stores_have_the_bytes_of_memory() {
    with_device(|device| {
        let (mut wrong, mut same) = (Vec::new(), 0);
        for MethodScene { name, clouds, frame, .. } in subjects() {
            let folder = tempfile::tempdir().expect("a folder");
            let paths = clouds.iter().zip(0..);
            // How a point lies that has no normal is found from all points in memory.
            let normals = frame.method.is_dealt();
            let store = |(points, at)| store(folder.path(), &format!("cloud{at}"), cloud(points), normals);
            let paths: Vec<PathBuf> = paths.map(store).collect();
            let both = Both::new(scene_of(&paths, frame.method), frame.seed, folder.path());
            match both.compare(device, &frame) {
                Ok((None, _)) => same += 1,
                Ok((Some(difference), windows)) => wrong.push(format!("{name}, {windows} windows: {difference}")),
                Err(error) if Lack::in_error(&error).is_some() => println!("not applicable: {name}: {error}"),
                Err(error) => wrong.push(format!("{name}: {error}")),
            }
        }
        assert!(wrong.is_empty(), "{}", wrong.join("\n"));
        assert!(!is_llvmpipe(device) || same == subjects().len(), "llvmpipe renders all of them: {same}");
    });
}

#[test]
fn the_garden_in_stores_has_the_bytes_of_memory() {
    let folder = tempfile::tempdir().expect("a folder");
    let generated = procedural::build("garden", &[], 1).expect("a garden");
    for (name, cloud) in generated.clouds {
        // A part takes less time, and is still more than the device is let have.
        let some: Vec<u32> = (0..cloud.len() as u32).step_by(12).collect();
        store(folder.path(), name.trim_end_matches(".ply"), cloud.subset(&some), true);
    }
    let text = generated.scene_toml.replace(".ply", "");
    with_device(|device| {
        let (mut wrong, mut windows) = (Vec::new(), Vec::new());
        for method in Method::all() {
            let (name, mut overrides) = (method.name(), Overrides::default());
            for pair in [&format!("method.name={name}"), "image.size=[320,180]"] {
                overrides.set_pair(pair).expect("a setting");
            }
            let scene = folder.path().join("scene.toml");
            let scene = Scene::from_toml_with(&text, &scene, &overrides).expect("a scene");
            let both = Both::new(scene, 1, folder.path());
            let camera = scene::camera(&both.scene, both.whole.points(), UpAxis::Y).expect("a camera").0;
            let frame = Frame { fragments: true, ..Frame::of_scene(&both.scene, camera, 1) };
            match both.compare(device, &frame) {
                Ok((None, count)) => windows.push((name, count)),
                Ok((Some(difference), count)) => wrong.push(format!("{name}, {count} windows: {difference}")),
                Err(error) if Lack::in_error(&error).is_some() => println!("not applicable: {name}: {error}"),
                Err(error) => wrong.push(format!("{name}: {error}")),
            }
        }
        println!("windows: {windows:?}");
        assert!(wrong.is_empty(), "{}", wrong.join("\n"));
        assert!(!is_llvmpipe(device) || windows.len() == Method::all().len(), "llvmpipe renders all of them");
        assert!(windows.iter().all(|(name, count)| *count > 1 || name.starts_with("spbr")), "{windows:?}");
    });
}
