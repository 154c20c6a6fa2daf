//! Files of Gaussian splats as pictures: the colors of one splat in the middle, worked out by hand.

use std::fs;

use glam::DVec3;
use pellucid_core::color::encode_srgb_f64;
use pellucid_core::progress::Progress;
use pellucid_engine::methods::{Frame, Renderer};
use pellucid_scene::prepare;
use pellucid_scene::stored::{Stored, open_stores};
use pellucid_scene::{self as scene, ColorSpace, Overrides, Scene};
use pellucid_testing::with_device;
use serde_json::json;
use tempfile::TempDir;

/// Pixels of a side: the splat's center is that of the middle one.
const SIDE: u32 = 33;

/// The middle pixel of the picture of a file, as 8-bit display values over black, and as the scene's store has it.
#[track_caller]
fn middle(folder: &TempDir, name: &str, camera: &str, keys: &str) -> [[u8; 3]; 2] {
    let hidden = Progress::hidden();
    let file = folder.path().join(name);
    let store = folder.path().join("store");
    fs::remove_dir_all(&store).ok();
    let opened = pellucid_io::store::open(&file, pellucid_io::Hints::default(), &hidden).unwrap();
    let settings = pellucid_io::store::build::Settings { node_points: 100, host_memory: 1 << 26 };
    prepare::store::prepare(&[opened], &store, &prepare::Request::default(), &settings, &hidden).unwrap();
    let scene_of = |path: &std::path::Path| {
        let text = format!("{keys}\n[camera]\n{camera}\nfov_y = 53.13\n[[cloud]]\npath = {path:?}");
        let mut overrides = Overrides::default();
        overrides.set("test", "image.size", &format!("[{SIDE}, {SIDE}]")).unwrap();
        Scene::from_toml_with(&text, "scene.toml".as_ref(), &overrides).unwrap()
    };
    let bytes = |scene: &Scene, arranged: &prepare::Arranged, up| {
        let camera = scene::camera(scene, arranged.points(), up).unwrap().0;
        let frame = Frame::of_scene(scene, camera, 1);
        let mut found = [0; 3];
        with_device(|device| {
            let mut renderer = Renderer::new(device).unwrap();
            let mut cloud = renderer.upload(arranged).unwrap();
            let image = renderer.render(&mut cloud, &frame).unwrap().image;
            let pixel = image.rgba[(SIDE * SIDE / 2) as usize];
            let display = |value: f32| match frame.color {
                ColorSpace::Linear => encode_srgb_f64(value.into()),
                ColorSpace::Encoded => value.into(),
            };
            found = [0, 1, 2].map(|channel| (255.0 * display(pixel[channel])).round() as u8);
        });
        found
    };
    let mut of_file = scene_of(&file);
    let clouds = scene::load_clouds(&of_file, &hidden).unwrap();
    let up = scene::up_axis(&clouds);
    of_file.settle(&clouds);
    let whole = scene::arrange(&of_file, clouds, 1, &hidden).unwrap();
    let of_store = scene_of(&store);
    let stored = Stored::new(&of_store, &open_stores(&of_store, &hidden).unwrap(), 1 << 26, &hidden).unwrap();
    [bytes(&of_file, &whole, up), bytes(stored.scene(), &stored.arranged(), up)]
}

/// A splat at the origin with extents of 1, as trainers write it, with coefficients of degree 0 and 1.
fn ply(folder: &TempDir, base: f64, harmonics: [f64; 9], alpha: f64) {
    let names = ["x", "y", "z", "f_dc_0", "f_dc_1", "f_dc_2"].map(str::to_owned).into_iter();
    let names = names.chain((0..9).map(|at| format!("f_rest_{at}"))).chain(["opacity".to_owned()]);
    let names = names.chain((0..3).map(|at| format!("scale_{at}"))).chain((0..4).map(|at| format!("rot_{at}")));
    let lines: String = names.map(|name| format!("property float {name}\n")).collect();
    let coefficient = (base - 0.5) / 0.282_094_791_773_878_14;
    let harmonics = harmonics.map(|value| value.to_string()).join(" ");
    let logit = (alpha / (1.0 - alpha)).ln();
    let row = format!("0 0 0 {coefficient} {coefficient} {coefficient} {harmonics} {logit} 0 0 0 1 0 0 0");
    let text = format!("ply\nformat ascii 1.0\nelement vertex 1\n{lines}end_header\n{row}\n");
    fs::write(folder.path().join("a.ply"), text).unwrap();
}

#[test]
fn white_splats_stay_white() {
    let folder = tempfile::tempdir().unwrap();
    let camera = "eye = [0, 0, -5]\ntarget = [0, 0, 0]\nup = [0, -1, 0]";
    // Of degree 1 the splat is seen along z, whose harmonic is √(3/4π): a coefficient of the second of three of red.
    let along = |red: f64| [0.0, red / 0.488_602_511_902_919_9, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    for (base, red, alpha, expected) in [
        (1.0, 0.0, 0.8, [204, 204, 204]),
        (1.0, -0.39, 0.8, [124, 204, 204]),
        (0.0, 0.39, 0.8, [80, 0, 0]),
        (2.0, 0.0, 0.25, [128, 128, 128]),
    ] {
        ply(&folder, base, along(red), alpha);
        let found = middle(&folder, "a.ply", camera, "");
        for found in found {
            let off = found.iter().zip(expected).map(|(a, b)| a.abs_diff(b)).max();
            // 127.5 may be either.
            assert!(off <= Some(1), "{base} {red} {alpha}: {found:?} is not {expected:?}");
        }
    }
}

/// A splat at the origin of a glTF file of linear colors, of gray ½ with harmonics along z.
fn gltf(folder: &TempDir, along_z: DVec3, opacity: f32) {
    let z = (along_z / 0.488_602_511_902_919_9).as_vec3().to_array();
    let attributes: [(&str, &str, Vec<f32>); 8] = [
        ("POSITION", "VEC3", vec![0.0; 3]),
        ("KHR_gaussian_splatting:ROTATION", "VEC4", vec![0.0, 0.0, 0.0, 1.0]),
        ("KHR_gaussian_splatting:SCALE", "VEC3", vec![1.0; 3]),
        ("KHR_gaussian_splatting:OPACITY", "SCALAR", vec![opacity]),
        ("KHR_gaussian_splatting:SH_DEGREE_0_COEF_0", "VEC3", vec![0.0; 3]),
        ("KHR_gaussian_splatting:SH_DEGREE_1_COEF_0", "VEC3", vec![0.0; 3]),
        ("KHR_gaussian_splatting:SH_DEGREE_1_COEF_1", "VEC3", z.to_vec()),
        ("KHR_gaussian_splatting:SH_DEGREE_1_COEF_2", "VEC3", vec![0.0; 3]),
    ];
    let (mut bytes, mut views, mut accessors) = (Vec::new(), Vec::new(), Vec::new());
    let mut names = serde_json::Map::new();
    for (at, (name, shape, numbers)) in attributes.iter().enumerate() {
        views.push(json!({ "buffer": 0, "byteOffset": bytes.len(), "byteLength": 4 * numbers.len() }));
        accessors.push(json!({ "bufferView": at, "componentType": 5126, "count": 1, "type": shape }));
        names.insert((*name).to_owned(), at.into());
        bytes.extend(numbers.iter().flat_map(|number| number.to_le_bytes()));
    }
    let about = json!({ "kernel": "ellipse", "colorSpace": "lin_rec709_display" });
    let primitive = json!({ "attributes": names, "mode": 0, "extensions": { "KHR_gaussian_splatting": about } });
    let document = json!({
        "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [0] }], "nodes": [{ "mesh": 0 }],
        "meshes": [{ "primitives": [primitive] }], "accessors": accessors, "bufferViews": views,
        "buffers": [{ "uri": "a.bin", "byteLength": bytes.len() }],
    });
    fs::write(folder.path().join("a.bin"), bytes).unwrap();
    fs::write(folder.path().join("a.gltf"), document.to_string()).unwrap();
}

#[test]
fn linear_colors_are_blended_before_they_are_encoded() {
    let folder = tempfile::tempdir().unwrap();
    let camera = "eye = [0, 0, 5]\ntarget = [0, 0, 0]\nup = [0, 1, 0]";
    // The curve of sRGB at what is left of a linear value.
    let display = |linear: f64| (255.0 * (1.055 * linear.powf(1.0 / 2.4) - 0.055)).round() as u8;
    gltf(&folder, DVec3::ZERO, 0.5);
    assert_eq!(display(0.25), 137);
    assert_eq!(middle(&folder, "a.gltf", camera, ""), [[137; 3]; 2]);
    // A scene that says so blends display values: half of 188.
    assert_eq!(middle(&folder, "a.gltf", camera, "[image]\ncolor = 'encoded'"), [[94; 3]; 2]);
    // The splat is seen along −z: 0.11, 0.5 and 0.89, of which 0.99 is what a splat shows at most.
    gltf(&folder, DVec3::new(0.39, 0.0, -0.39), 1.0);
    let expected = [0.11, 0.5, 0.89].map(|linear| display(0.99 * linear));
    assert_eq!(middle(&folder, "a.gltf", camera, ""), [expected; 2]);
}
