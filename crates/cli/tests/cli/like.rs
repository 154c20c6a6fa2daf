//! `render --like`: a picture is rendered again from the camera in its metadata.

use std::fs;
use std::path::Path;

use glam::{DVec3, Vec3};
use pellucid_core::cloud::Cloud;
use pellucid_io::output::metadata;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use tempfile::TempDir;

use crate::render::{exr, png};
use crate::{assert_refused, builtin, done, folder, has_device, inside, write_cloud, write_picture};
use pellucid_testing::root;

const CAMERA: &str = "pellucid:camera";

/// A cloud about a place, as PLY.
fn cloud_at(path: &Path, place: DVec3) {
    let mut random = Pcg64::seed_from_u64(2);
    let mut vector = || DVec3::from_array(std::array::from_fn(|_| random.random_range(-1.0..1.0)));
    let positions: Vec<DVec3> = (0..400).map(|_| place + vector() * DVec3::new(5.0, 3.0, 2.0)).collect();
    let colors = positions.iter().map(|position| (0.5 * (position - place).as_vec3() / 5.0) + 0.5).collect();
    let cloud = Cloud { colors: Some(colors), positions, ..Cloud::default() };
    pellucid_io::ply::write(path, &cloud).unwrap();
}

/// Asserts that two PNGs have the same pixels and the same camera.
#[track_caller]
fn assert_same(folder: &TempDir, a: &str, b: &str) {
    let [a, b] = [a, b].map(|name| inside(folder, name));
    assert_eq!(metadata(&a, CAMERA).unwrap(), metadata(&b, CAMERA).unwrap());
    if a.extension().unwrap() == "exr" {
        let [a, b] = [a, b].map(|path| exr(&path).0);
        let bits = |channels: &std::collections::BTreeMap<String, Vec<f32>>| -> Vec<(String, Vec<u32>)> {
            channels.iter().map(|(name, values)| (name.clone(), values.iter().map(|v| v.to_bits()).collect())).collect()
        };
        assert!(bits(&a) == bits(&b), "the same bits");
        return;
    }
    let [(_, a, _), (_, b, _)] = [a, b].map(|path| png(&path));
    assert!(a == b, "the same pixels");
    assert!(a.iter().any(|value| *value > 0), "something is seen");
}

#[test]
fn a_picture_is_rendered_again_from_its_own_metadata() {
    if !has_device() {
        return;
    }
    let folder = folder();
    cloud_at(&inside(&folder, "near.ply"), DVec3::ZERO);
    cloud_at(&inside(&folder, "utm.ply"), DVec3::new(512_345.6, 5_403_210.9, 312.5));
    let scene = "[camera]\neye = [7, -9, 6]\ntarget = [0.1, 0, 0]\nfov_y = 33.3\n[[cloud]]\npath = \"near.ply\"\n";
    fs::write(inside(&folder, "stated.toml"), scene).unwrap();
    fs::write(inside(&folder, "plain.toml"), "[camera]\northo = true\n[[cloud]]\npath = \"near.ply\"\n").unwrap();
    let look = ["--opacity", "0.4", "--color-by", "height", "-q"];
    let cases: [(&str, &[&str], &str); 6] = [
        ("near.ply", &[], "png"),
        ("utm.ply", &[], "exr"),
        ("utm.ply", &["--view", "top"], "png"),
        ("near.ply", &["--ortho", "--view", "iso", "--set", "camera.near=0.5"], "exr"),
        ("stated.toml", &[], "png"),
        ("near.ply", &["--method", "stochastic", "--seed", "3", "--azimuth", "77"], "exr"),
    ];
    for (input, view, end) in cases {
        let [first, again] = ["a", "b"].map(|name| format!("{name}.{end}"));
        done(&folder, &[&["render", input, "--size", "40x30", "-o", &first], &look[..], view].concat());
        // A scene file's own camera is replaced.
        let input = if input == "stated.toml" { "plain.toml" } else { input };
        let method = if view.contains(&"--method") { &view[..4] } else { &[] };
        done(&folder, &[&["render", input, "--like", &first, "-o", &again], &look[..], method].concat());
        assert_same(&folder, &first, &again);
    }
    // Another size keeps the view: the same height in the world.
    done(&folder, &["render", "utm.ply", "--like", "a.exr", "--size", "20x15", "-o", "small.exr", "-q"]);
    assert_eq!(metadata(&inside(&folder, "small.exr"), CAMERA), metadata(&inside(&folder, "a.exr"), CAMERA));
    assert_eq!(exr(&inside(&folder, "small.exr")).0["A"].len(), 300);
}

#[test]
fn splats_frames_and_deep_pictures_hold_their_cameras_too() {
    if !has_device() {
        return;
    }
    let folder = folder();
    let splats = root().join("tests/data/splats/soup.ply");
    let tori = builtin(&folder, "tori", &["points=500"]);
    let base = ["render", &tori, "--size", "32x24", "-q"];
    done(&folder, &[&base[..], &["--turntable", "--frames", "3", "-o", "f_%d.png"]].concat());
    let cameras: Vec<String> =
        (0..3).map(|frame| metadata(&inside(&folder, &format!("f_{frame}.png")), CAMERA).unwrap()).collect();
    assert!(cameras[0] != cameras[1] && cameras[1] != cameras[2]);
    for frame in ["f_0.png", "f_1.png", "f_2.png"] {
        done(&folder, &["render", &tori, "--like", frame, "-o", "again.png", "-q"]);
        assert_same(&folder, frame, "again.png");
    }
    done(&folder, &[&base[..], &["--method", "abuffer", "--deep", "-o", "deep.exr"]].concat());
    done(&folder, &[&base[..], &["--method", "abuffer", "-o", "flat.exr"]].concat());
    done(&folder, &["render", &tori, "--like", "deep.exr", "--method", "abuffer", "-o", "again.exr", "-q"]);
    assert_same(&folder, "flat.exr", "again.exr");
    let bytes = fs::read(inside(&folder, "deep.exr")).unwrap();
    let text = String::from_utf8_lossy(&bytes);
    assert!(text.contains("worldToCamera\0m44f\0@") && text.contains("worldToNDC\0m44f\0@"));
    let splats = splats.to_str().unwrap();
    done(&folder, &["render", splats, "--size", "32x24", "-o", "s.png", "-q"]);
    done(&folder, &["render", splats, "--like", "s.png", "-o", "t.png", "-q"]);
    assert_same(&folder, "s.png", "t.png");
}

#[test]
fn exr_matrices_take_a_point_to_its_pixel() {
    if !has_device() {
        return;
    }
    let folder = folder();
    let point = DVec3::new(1.25, -0.5, 0.75);
    let cloud = Cloud { positions: vec![point], colors: Some(vec![Vec3::ONE]), ..Cloud::default() };
    pellucid_io::ply::write(&inside(&folder, "one.ply"), &cloud).unwrap();
    let eye = DVec3::new(4.0, -7.0, 3.0);
    for lens in ["fov_y = 40", "height = 6"] {
        let camera = "eye = [4, -7, 3]\ntarget = [0, 0, 1]\nup = [0, 0, 1]\nnear = 1\nfar = 20";
        let scene = format!("[camera]\n{camera}\n{lens}\n[[cloud]]\npath = \"one.ply\"\nradius = 1e-6\n");
        fs::write(inside(&folder, "one.toml"), scene).unwrap();
        done(&folder, &["render", "one.toml", "--method", "points", "--size", "80x60", "-o", "one.exr", "-q"]);
        let picture = inside(&folder, "one.exr");
        let lit: Vec<usize> =
            exr(&picture).0["A"].iter().enumerate().filter(|(_, a)| **a > 0.0).map(|(i, _)| i).collect();
        let [to_camera, to_ndc] = matrices(&picture);
        // Rows: p′ = p · M.
        let times = |m: [f32; 16]| -> [f64; 4] {
            let p = [point.x, point.y, point.z, 1.0];
            std::array::from_fn(|column| (0..4).map(|row| p[row] * f64::from(m[4 * row + column])).sum())
        };
        // Camera space by its definition: left-handed, x to the right, y up, z along the view.
        let forward = (DVec3::Z - eye).normalize();
        let right = forward.cross(DVec3::Z).normalize();
        let expected = [right, right.cross(forward), forward].map(|axis| axis.dot(point - eye));
        let found = times(to_camera);
        assert!((0..3).all(|i| (found[i] - expected[i]).abs() < 1e-5) && found[3] == 1.0, "{found:?}, {expected:?}");
        let [x, y, z, w] = times(to_ndc);
        // NDC: (0, 0) is the upper left corner of the picture, (1, 1) the lower right one.
        let (column, row) = (80.0 * x / w, 60.0 * y / w);
        assert_eq!(lit, [80 * row as usize + column as usize], "{lens}: {column}, {row}");
        let half = if lens.starts_with('f') { expected[2] * 20f64.to_radians().tan() } else { 3.0 };
        let wanted = [0.5 + 0.5 * expected[0] / (half * 80.0 / 60.0), 0.5 - 0.5 * expected[1] / half];
        assert!(
            (x / w - wanted[0]).abs() < 1e-6 && (y / w - wanted[1]).abs() < 1e-6,
            "{lens}: {x} {y} {w}, {wanted:?}"
        );
        let depth = match lens.starts_with('f') {
            true => (1.0 - 1.0 / expected[2]) / (1.0 - 1.0 / 20.0),
            false => (expected[2] - 1.0) / 19.0,
        };
        assert!((z / w - depth).abs() < 1e-6, "{lens}: {z} {w}, {depth}");
    }
}

/// `worldToCamera` and `worldToNDC` of an EXR.
fn matrices(path: &Path) -> [[f32; 16]; 2] {
    use ::exr::prelude::MetaData;
    let meta = MetaData::read_from_file(path, false).unwrap();
    let attributes = &meta.headers[0].own_attributes;
    [attributes.world_to_camera.unwrap(), attributes.world_to_normalized_device.unwrap()]
}

#[test]
fn pictures_that_say_no_camera_are_refused() {
    let folder = folder();
    write_cloud(&inside(&folder, "m.ply"));
    write_picture(&inside(&folder, "photo.png"), 3, 0.5);
    write_picture(&inside(&folder, "photo.exr"), 3, 0.5);
    fs::write(inside(&folder, "text.png"), "no picture").unwrap();
    fs::write(inside(&folder, "p.json"), r#"{"version": 1, "keys": []}"#).unwrap();
    let like = |picture| ["render", "m.ply", "--like", picture, "-o", "out.png"];
    for picture in ["photo.png", "photo.exr"] {
        assert_refused(&folder, &like(picture), 2, &[picture, CAMERA, "give a PNG or EXR that `render` wrote"]);
    }
    assert_refused(&folder, &like("m.ply"), 2, &["m.ply", ".png"]);
    assert_refused(&folder, &like("text.png"), 1, &["text.png"]);
    assert_refused(&folder, &like("nowhere.png"), 1, &["nowhere.png"]);
    for (option, value) in [
        ("--view", "top"),
        ("--azimuth", "3"),
        ("--elevation", "3"),
        ("--up", "y"),
        ("--ortho", ""),
        ("--path", "p.json"),
    ] {
        let more: Vec<&str> = [option, value].into_iter().filter(|word| !word.is_empty()).collect();
        assert_refused(&folder, &[&like("photo.png")[..], &more].concat(), 2, &["--like", option]);
    }
    let over = ["render", "m.ply", "--like", "photo.png", "-o", "./photo.png"];
    assert_refused(&folder, &over, 2, &["-o ./photo.png", "the input photo.png"]);
}
