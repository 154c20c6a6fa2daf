//! Scenes whose clouds stay where they are stored: the same bytes as with all points in memory and on the device.

use std::path::{Path, PathBuf};

use glam::{DVec3, Vec3};
use pellucid_engine::cloud::{Cloud, UpAxis};
use pellucid_engine::gpu::Device;
use pellucid_engine::io::store::build::Settings;
use pellucid_engine::io::store::{Held, Store};
use pellucid_engine::methods::{Frame, Rendered, Renderer};
use pellucid_engine::prepare::{self, Arranged, Request};
use pellucid_engine::progress::Progress;
use pellucid_engine::scene::stored::{Stored, open_stores};
use pellucid_engine::scene::{self, Method, Overrides, Scene};
use pellucid_testing::{bits, random, with_device};
use rand::RngExt;

/// Nodes of few points, and less memory than a cloud takes.
const TIGHT: Settings = Settings { node_points: 1000, host_memory: 1 << 20 };
/// Bytes on the device: some thousands of points at a time.
const DEVICE: u64 = 8 << 20;
/// Bytes of nodes that are kept.
const HOST: u64 = 2 << 20;

/// Points about a few bumps and in a cloud above them, some of them in one place, with everything that a cloud may have.
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
    let target = folder.join(name);
    let input = [Box::new(Held::new(Path::new("memory"), cloud).unwrap()) as Box<dyn Store>];
    prepare::store::prepare(&input, &target, &Request::default(), &TIGHT, &Progress::hidden()).unwrap();
    target
}

/// A scene of one method in memory and in its stores.
fn both(text: &str, method: &Method) -> (Scene, Arranged, Stored) {
    let mut overrides = Overrides::default();
    overrides.set_pair(&format!("method.name={}", method.name())).unwrap();
    let scene = Scene::from_toml_with(text, Path::new("scene.toml"), &overrides).unwrap();
    let hidden = Progress::hidden();
    let clouds = scene::load_clouds(&scene, &hidden).unwrap();
    let whole = scene::arrange(&scene, clouds, 3, &hidden).unwrap();
    let stored = Stored::new(&scene, open_stores(&scene, &hidden).unwrap(), HOST, &hidden).unwrap();
    (scene, whole, stored)
}

fn rendered(device: &Device, arranged: &Arranged, frame: &Frame) -> Result<Rendered, String> {
    let mut renderer = Renderer::new(device).expect("a renderer");
    let mut cloud = renderer.upload_arranged(arranged).map_err(|error| error.to_string())?;
    renderer.render(&mut cloud, frame).map_err(|error| error.to_string())
}

/// Every method that is not dealt, with the camera that is found.
fn assert_same(text: &str, about: &str) {
    with_device(|device| {
        let mut differ = Vec::new();
        for method in Method::all().into_iter().filter(|method| !method.is_dealt()) {
            let (scene, whole, stored) = both(text, &method);
            assert!(stored.notes().is_empty(), "{:?}", stored.notes());
            let (camera, _) = scene::camera(&scene, whole.points(), UpAxis::Z).unwrap();
            let (found, _) = scene::camera(stored.scene(), stored.sample(), stored.up()).unwrap();
            assert_eq!(found, camera, "{about}");
            let frame = Frame { fragments: true, ..Frame::of_scene(&scene, camera, 3) };
            let expected = rendered(device, &whole, &frame).expect("a frame");
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
    let path = store(folder.path(), "one", cloud(1, 40_000));
    let text = format!("[image]\nsize = [160, 120]\n[[cloud]]\npath = '{}'\nopacity = 0.4\n", path.display());
    assert_same(&text, "one store");
}

#[test]
fn several_stores_with_clips_classes_and_color_maps_have_the_bytes_of_memory() {
    let folder = tempfile::tempdir().unwrap();
    let [one, two] = [(1, 30_000), (2, 12_000)]
        .map(|(seed, count)| store(folder.path(), &format!("store{seed}"), cloud(seed, count)));
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
