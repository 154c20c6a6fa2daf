//! Splats of glTF files: placed by nodes, of drafts, of linear colors, and those that can't be read.

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use glam::{DMat3, DQuat, DVec3, Quat, Vec3};
use pellucid_core::cloud::gaussians::ColorCoding;
use pellucid_core::cloud::{Cloud, UpAxis};
use serde_json::{Value, json};

use super::super::{assert_refused, load, load_bytes};
use super::{bytes, folder};

/// The color of a splat in a direction, of harmonics up to degree 2.
fn color(cloud: &Cloud, at: usize, d: DVec3) -> DVec3 {
    let gaussians = cloud.gaussians.as_ref().unwrap();
    let (x, y, z) = (d.x, d.y, d.z);
    let (one, two) = (0.488_602_511_902_919_9, 1.092_548_430_592_079);
    let functions = [
        -one * y,
        one * z,
        -one * x,
        two * x * y,
        -two * y * z,
        0.315_391_565_252_520_05 * (2.0 * z * z - x * x - y * y),
        -two * x * z,
        0.5 * two * (x * x - y * y),
    ];
    let harmonics = gaussians.harmonics_of(at).iter().zip(functions);
    gaussians.bases[at].as_dvec3() + harmonics.map(|(c, y)| c.as_dvec3() * y).sum::<DVec3>()
}

/// Asserts that a cloud is the soup moved by a turn, a scale and a translation.
#[track_caller]
fn assert_moved(cloud: &Cloud, turn: DQuat, scale: f64, translation: DVec3) {
    let soup = load(&folder().join("soup.ply")).unwrap();
    assert_eq!((cloud.len(), cloud.up, cloud.non_finite), (40, UpAxis::Y, 0));
    let (own, other) = (cloud.gaussians.as_ref().unwrap(), soup.gaussians.as_ref().unwrap());
    for at in 0..40 {
        let position = turn * (soup.positions[at] * scale) + translation;
        assert!(cloud.positions[at].distance(position) < 1e-6, "{} is not {position}", cloud.positions[at]);
        // A logit of float32 in the other file.
        let off = cloud.alphas.as_ref().unwrap()[at] - soup.alphas.as_ref().unwrap()[at];
        assert!(off.abs() < 2e-7, "alpha {off}");
        let off = (own.extents[at] / (other.extents[at] * scale as f32) - 1.0).abs().max_element();
        assert!(off < 1e-6, "extents {off}");
        // The matrices of float32 quaternions.
        let matrix = |rotation: Quat| DMat3::from_quat(rotation.as_dquat().normalize());
        let off = matrix(own.rotations[at]) - DMat3::from_quat(turn) * matrix(other.rotations[at]);
        assert!(off.to_cols_array().iter().all(|off| off.abs() < 1e-6), "{off}");
        for direction in [DVec3::X, DVec3::Y, DVec3::Z, DVec3::new(0.6, -0.64, 0.48)] {
            let off = color(cloud, at, turn * direction).distance(color(&soup, at, direction));
            assert!(off < 1e-6, "colors {off}");
        }
    }
}

#[test]
fn nodes_turn_splats_and_their_colors() {
    let half = 0.5_f64.sqrt();
    let turn = DQuat::from_xyzw(half, 0.0, 0.0, half);
    let cloud = load(&folder().join("soup.gltf")).unwrap();
    assert!(cloud.warnings.is_empty(), "{:?}", cloud.warnings);
    assert_moved(&cloud, turn, 2.0, DVec3::new(1.0, 2.0, 3.0));
}

/// splat-transform turns what it writes by half a turn about z.
#[test]
fn binary_files() {
    let cloud = load(&folder().join("soup.glb")).unwrap();
    assert!(cloud.warnings.is_empty(), "{:?}", cloud.warnings);
    assert_moved(&cloud, DQuat::from_xyzw(0.0, 0.0, 1.0, 0.0), 1.0, DVec3::ZERO);
}

#[test]
fn drafts_have_logarithms() {
    let draft = load(&folder().join("draft.gltf")).unwrap();
    let soup = load(&folder().join("soup.gltf")).unwrap();
    let [warning] = draft.warnings.as_slice() else { panic!("{:?}", draft.warnings) };
    assert!(warning.contains("logarithms, as in drafts"), "{warning}");
    let extents = |cloud: Cloud| cloud.gaussians.unwrap().extents;
    for (a, b) in extents(draft).into_iter().zip(extents(soup)) {
        assert!((a / b - 1.0).abs().max_element() < 1e-6, "{a} is not {b}");
    }
}

/// The soup as JSON, changed.
fn changed(change: impl FnOnce(&mut Value)) -> Vec<u8> {
    let mut json = serde_json::from_slice(&bytes("soup.gltf")).unwrap();
    change(&mut json);
    serde_json::to_vec(&json).unwrap()
}

fn extension(json: &mut Value) -> &mut Value {
    &mut json["meshes"][0]["primitives"][0]["extensions"]["KHR_gaussian_splatting"]
}

#[test]
fn linear_colors_stay_linear_and_so_do_their_harmonics() {
    let linear = changed(|json| extension(json)["colorSpace"] = "lin_rec709_display".into());
    let cloud = load_bytes("a.gltf", linear).unwrap();
    let soup = load(&folder().join("soup.gltf")).unwrap();
    assert!(cloud.warnings.is_empty(), "{:?}", cloud.warnings);
    let (own, other) = (cloud.gaussians.unwrap(), soup.gaussians.unwrap());
    assert_eq!((&own.coding, &other.coding), (&ColorCoding::Linear, &ColorCoding::Display));
    assert_eq!((&own.bases, &own.harmonics), (&other.bases, &other.harmonics));
    let clamped = own.bases.iter().map(|base| base.clamp(Vec3::ZERO, Vec3::ONE));
    assert!(cloud.colors.unwrap().into_iter().eq(clamped), "without harmonics they are the colors of points");
    let both = changed(|json| {
        let list = json["meshes"][0]["primitives"].as_array_mut().unwrap();
        list.push(list[0].clone());
        list[1]["extensions"]["KHR_gaussian_splatting"]["colorSpace"] = "lin_rec709_display".into();
    });
    let both = load_bytes("a.gltf", both).unwrap().gaussians.unwrap();
    assert!((0..80).all(|at| both.is_linear(at) == (at >= 40)), "each primitive has its own");
}

#[test]
fn scales_beyond_the_cloud_are_doubted() {
    let warnings = |largest: f64| {
        // Nodes double all sizes.
        let diagonal = load(&folder().join("soup.gltf")).unwrap().bounds().unwrap().diagonal() / 2.0;
        let text = changed(|json| {
            let scale = |at: usize| if at == 7 { (largest * diagonal) as f32 } else { 0.01 };
            let scales: Vec<u8> = (0..120).flat_map(|at| scale(at).to_le_bytes()).collect();
            let uri = format!("data:application/octet-stream;base64,{}", BASE64_STANDARD.encode(&scales));
            let buffers = json["buffers"].as_array_mut().unwrap();
            buffers.push(json!({ "uri": uri, "byteLength": scales.len() }));
            let number = buffers.len() - 1;
            let views = json["bufferViews"].as_array_mut().unwrap();
            views.push(json!({ "buffer": number, "byteLength": scales.len() }));
            let view = views.len() - 1;
            json["accessors"][2]["bufferView"] = view.into();
            json["accessors"][2]["byteOffset"] = 0.into();
        });
        load_bytes("a.gltf", text).unwrap().warnings
    };
    let large = warnings(1.1);
    assert!(large.len() == 1 && large[0].contains("its scales are meant as logarithms"), "{large:?}");
    assert!(warnings(0.9).is_empty());
}

#[test]
fn nodes_may_scale_differently_along_their_axes() {
    let stretched = load_bytes("a.gltf", changed(|json| json["nodes"][1]["scale"] = json!([2, 1, 0.5]))).unwrap();
    let [warning] = stretched.warnings.as_slice() else { panic!("{:?}", stretched.warnings) };
    assert!(warning.contains("harmonics turn with the closest rotation"), "{warning}");
    let soup = load(&folder().join("soup.ply")).unwrap();
    let (own, other) = (stretched.gaussians.as_ref().unwrap(), soup.gaussians.as_ref().unwrap());
    // A quarter turn about x of what is stretched.
    let half = 0.5_f64.sqrt();
    let linear =
        DMat3::from_quat(DQuat::from_xyzw(half, 0.0, 0.0, half)) * DMat3::from_diagonal(DVec3::new(2.0, 1.0, 0.5));
    let covariance = |matrix: DMat3, extents: Vec3| {
        let axes = matrix * DMat3::from_diagonal(extents.as_dvec3());
        axes * axes.transpose()
    };
    let matrix = |rotation: Quat| DMat3::from_quat(rotation.as_dquat().normalize());
    for at in 0..40 {
        let position = linear * soup.positions[at] + DVec3::new(1.0, 2.0, 3.0);
        assert!(stretched.positions[at].distance(position) < 1e-6, "{} is not {position}", stretched.positions[at]);
        let expected = covariance(linear * matrix(other.rotations[at]), other.extents[at]);
        let off = covariance(matrix(own.rotations[at]), own.extents[at]) - expected;
        // Extents of at most 0.8 and quaternions are float32.
        assert!(off.to_cols_array().iter().all(|off| off.abs() < 1e-6), "{off}");
    }
}

#[test]
fn buffers_beside_the_file() {
    let mut data = String::new();
    let text = changed(|json| {
        data = json["buffers"][0]["uri"].as_str().unwrap().split_once(',').unwrap().1.to_owned();
        json["buffers"][0]["uri"] = "a%20soup.bin".into();
    });
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.gltf"), text).unwrap();
    let missing = load(&folder.path().join("a.gltf")).unwrap_err().to_string();
    assert!(missing.ends_with("a soup.bin: no such file"), "{missing}");
    std::fs::write(folder.path().join("a soup.bin"), base64(&data)).unwrap();
    assert_eq!(load(&folder.path().join("a.gltf")).unwrap().len(), 40);
}

/// The bytes of base64.
fn base64(text: &str) -> Vec<u8> {
    let digit = |c: u8| match c {
        b'A'..=b'Z' => u32::from(c - b'A'),
        b'a'..=b'z' => u32::from(c - b'a') + 26,
        b'0'..=b'9' => u32::from(c - b'0') + 52,
        b'+' => 62,
        _ => 63,
    };
    let four = |four: &[u8]| {
        let padding = four.iter().filter(|c| **c == b'=').count();
        let word = four.iter().fold(0, |word, c| word << 6 | if *c == b'=' { 0 } else { digit(*c) });
        word.to_be_bytes()[1..4 - padding].to_vec()
    };
    text.as_bytes().chunks(4).flat_map(four).collect()
}

#[test]
fn two_primitives_of_different_degrees() {
    let twice = changed(|json| {
        let mut other = json["meshes"][0]["primitives"][0].clone();
        other["attributes"].as_object_mut().unwrap().retain(|name, _| !name.contains("DEGREE_2"));
        let list = json["meshes"][0]["primitives"].as_array_mut().unwrap();
        list.push(other);
        list.push(json!({ "attributes": { "POSITION": 0 } }));
    });
    let cloud = load_bytes("a.gltf", twice).unwrap();
    let gaussians = cloud.gaussians.as_ref().unwrap();
    assert_eq!((cloud.len(), gaussians.len(), gaussians.degree), (80, 80, 2));
    assert_eq!(gaussians.harmonics_of(40)[..3], gaussians.harmonics_of(0)[..3]);
    assert_eq!(gaussians.harmonics_of(40)[3..], [Vec3::ZERO; 5]);
    assert!(cloud.warnings[0].contains("1 primitives that are not splats"), "{:?}", cloud.warnings);
}

#[test]
fn refused_files_give_errors_that_say_why() {
    type Change = fn(&mut Value);
    let cases: [(Change, &[&str]); 20] = [
        (|json| json["nodes"][1]["scale"] = json!([1, 1, -2]), &["node 1", "it mirrors or flattens splats"]),
        (|json| json["nodes"][1]["children"] = json!([0]), &["node 0", "belongs to two nodes, or to itself"]),
        (|json| json["nodes"][1]["mesh"] = 7.into(), &["node 1", "there is no mesh 7"]),
        (|json| json["scene"] = 3.into(), &["scene", "there is no scene 3"]),
        (|json| json["scenes"][0]["nodes"] = json!([9]), &["node 9", "no such node"]),
        (|json| json["meshes"][0]["primitives"][0]["mode"] = 4.into(), &["mesh 0, primitive 0", "mode 4, expected 0"]),
        (
            |json| json["meshes"][0]["primitives"][0]["extensions"] = json!({}),
            &["meshes", "no primitive of its scene has KHR_gaussian"],
        ),
        (
            |json| json["accessors"][0]["count"] = 41.into(),
            &["attribute POSITION", "accessor 0 has 41 elements of 12 bytes"],
        ),
        (|json| json["accessors"][0]["count"] = u64::MAX.into(), &["attribute POSITION", "elements of 12 bytes"]),
        (|json| json["accessors"][1]["count"] = 39.into(), &["attributes", "39 elements, but POSITION has 40"]),
        (|json| json["accessors"][2]["type"] = "VEC4".into(), &["SCALE", "accessor 2 is of type VEC4, expected VEC3"]),
        (|json| json["accessors"][2]["componentType"] = 1.into(), &["SCALE", "componentType 1"]),
        (|json| json["accessors"][2]["sparse"] = json!({}), &["SCALE", "sparse, which is not supported"]),
        (|json| json["bufferViews"][0]["byteLength"] = u64::MAX.into(), &["POSITION", "reaches beyond its buffer"]),
        (|json| json["buffers"][0]["byteLength"] = 99_999.into(), &["truncated", "buffer 0 has 6080 bytes", "99999"]),
        (|json| json["buffers"][0]["uri"] = "https://a/b".into(), &["buffer 0", "is not the name of a file"]),
        (|json| json["buffers"][0]["uri"] = "data:;base64,!".into(), &["buffer 0", "base64"]),
        (
            |json| json["extensionsRequired"] = json!(["EXT_meshopt_compression"]),
            &["needs EXT_meshopt_compression", "write the file without compression"],
        ),
        (
            |json| json["extensionsRequired"] = json!(["KHR_materials_unlit"]),
            &["requires KHR_materials_unlit, which is not supported", "to extensionsUsed alone"],
        ),
        (
            |json| extension(json)["extensions"] = json!({ "KHR_gaussian_splatting_compression_spz_2": {} }),
            &["compressed by KHR_gaussian_splatting_compression_spz_2"],
        ),
    ];
    for (change, says) in cases {
        assert_refused("a.gltf", changed(change), says);
    }
    assert_refused("a.gltf", "{", &["JSON", "EOF"]);
    assert_refused("a.gltf", "nothing", &["byte 0", "expected `{`"]);
    assert_refused("a.glb", "nothing", &["byte 0", "expected `glTF`"]);
    let mut glb = bytes("soup.glb");
    glb[4] = 1;
    assert_refused("a.glb", &glb, &["byte 4", "glTF version 1, expected 2"]);
}
