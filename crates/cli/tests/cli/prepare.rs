//! Prepared clouds: the picture of the cloud they were made of, to the byte, and no harm from what is wrong with them.

use std::fs;
use std::path::Path;

use glam::{DVec3, Vec3};
use pellucid_core::cloud::field::Field;
use pellucid_core::cloud::{Cloud, UpAxis};
use pellucid_core::progress::Progress;
use pellucid_io as io;
use pellucid_scene as scene;
use pellucid_scene::Scene;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use tempfile::TempDir;

use crate::{assert_refused, done, folder, has_device, inside, run};

fn load(path: &Path) -> Cloud {
    io::load(path, &Progress::hidden()).unwrap()
}

/// A text PLY with colors, alpha, a few normals, classes and a property; some points coincide.
fn write_source(folder: &TempDir, name: &str, colors: &str) {
    let mut random = Pcg64Mcg::seed_from_u64(1);
    let mut text = format!(
        "ply\nformat ascii 1.0\ncomment by hand\nelement vertex 300\nproperty double x\nproperty double y\nproperty double z\n\
         property {colors} red\nproperty {colors} green\nproperty {colors} blue\nproperty uchar alpha\nproperty float nx\n\
         property float ny\nproperty float nz\nproperty int label\nproperty float height\nend_header\n"
    );
    let largest = if colors == "ushort" { 65_535 } else { 255 };
    for i in 0..300 {
        let mut step = || f64::from(random.random_range(0..40)) * 0.1;
        let [x, y, z] = [5e5 + step(), 4.5e6 + step(), step()];
        let mut byte = |most: u32| random.random_range(0..=most);
        let [r, g, b, a, class] = [byte(largest), byte(largest), byte(largest), byte(255), byte(6)];
        let color = |c: u32| if colors == "float" { format!("{}", f64::from(c) * 0.003) } else { c.to_string() };
        let normal = if i % 3 == 0 { "0 0.6 0.8" } else { "0 0 0" };
        text += &format!("{x} {y} {z} {} {} {} {a} {normal} {class} {}\n", color(r), color(g), color(b), z - 1.0);
    }
    fs::write(inside(folder, name), text).unwrap();
}

fn prepare(folder: &TempDir, args: &[&str]) {
    assert_eq!(run(folder, &[&["prepare"], args].concat()), (0, String::new(), String::new()), "{args:?}");
}

/// All columns, except those that only a prepared file has.
fn assert_same_columns(prepared: &Cloud, source: &Cloud) {
    let plain = Cloud { prepared: None, radii: source.radii.clone(), warnings: Vec::new(), ..prepared.clone() };
    assert_eq!(plain, Cloud { non_finite: 0, ..source.clone() });
}

#[test]
fn every_column_comes_back_to_the_bit() {
    let folder = folder();
    for colors in ["uchar", "ushort", "float"] {
        write_source(&folder, "a.ply", colors);
        prepare(&folder, &["a.ply", "-o", "b.ply"]);
        let (source, back) = (load(&inside(&folder, "a.ply")), load(&inside(&folder, "b.ply")));
        assert_same_columns(&back, &source);
        let prepared = back.prepared.expect("recognized");
        assert_eq!((prepared.neighbors, prepared.estimated_radii, prepared.field), (24, true, Field::Uncertainty));
        let header = fs::read(inside(&folder, "b.ply")).unwrap();
        let header = String::from_utf8_lossy(&header);
        let color = if colors == "float" { "property float linear_red" } else { &format!("property {colors} red") };
        for line in
            ["format binary_little_endian", "comment pellucid-prepared {\"version\":1", "property double x", color]
        {
            assert!(header.contains(line), "{colors}: {line}");
        }
        // Preparing again changes nothing.
        prepare(&folder, &["b.ply", "-o", "c.ply"]);
        assert!(fs::read(inside(&folder, "b.ply")).unwrap() == fs::read(inside(&folder, "c.ply")).unwrap());
    }
    // Nothing temporary is left.
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 3);
}

/// The hash as docs/prepared-clouds.md describes it.
fn documented_hash(path: &Path) -> (String, String) {
    let bytes = fs::read(path).unwrap();
    let header = String::from_utf8_lossy(&bytes);
    let comment = header.lines().find_map(|line| line.strip_prefix("comment pellucid-prepared ")).unwrap();
    let mut object: serde_json::Value = serde_json::from_str(comment).unwrap();
    let stored = object["content"].as_str().unwrap().to_owned();
    object["content"] = "".into();
    let cloud = load(path);
    let floats = |values: &[f32]| values.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
    let positions = cloud.positions.iter().flat_map(|p| p.to_array()).flat_map(f64::to_le_bytes).collect();
    let normals = cloud.normals.iter().flatten().flat_map(|n| n.to_array()).flat_map(f32::to_le_bytes).collect();
    let mut parts: Vec<Vec<u8>> = vec![object.to_string().into_bytes(), positions, normals];
    parts.push(floats(&cloud.radii.unwrap()));
    parts.push(floats(&cloud.prepared.unwrap().values));
    parts.push(cloud.classification.unwrap_or_default());
    parts.push(floats(&cloud.intensity.unwrap_or_default()));
    parts.extend(cloud.scalars.iter().map(|(_, values)| floats(values)));
    let mut hasher = blake3::Hasher::new();
    for part in parts {
        hasher.update(&(part.len() as u64).to_le_bytes()).update(&part);
    }
    (stored, hasher.finalize().to_hex().to_string())
}

#[test]
fn the_hash_is_the_documented_one() {
    let folder = folder();
    write_source(&folder, "a.ply", "uchar");
    for field in ["uncertainty", "height"] {
        prepare(&folder, &["a.ply", "-o", "b.ply", "--field", field]);
        let (stored, computed) = documented_hash(&inside(&folder, "b.ply"));
        assert_eq!(stored, computed, "{field}");
    }
}

/// The points of a frame of one cloud under a soft method.
fn points(folder: &TempDir, cloud: &str, keys: &str) -> pellucid_core::points::Points {
    let text = format!("[method]\nname = \"soft-base\"\n[[cloud]]\npath = \"{cloud}\"\n{keys}");
    let scene = Scene::from_toml(&text, &inside(folder, "s.toml")).unwrap();
    let clouds = scene::load_clouds(&scene, &Progress::hidden()).unwrap();
    assert_eq!(scene::notes(&scene, &clouds, true), [""; 0], "{keys}");
    scene::assemble(&scene, clouds, true, &Progress::hidden()).unwrap()
}

#[test]
fn points_of_prepared_clouds_are_those_of_their_sources() {
    let folder = folder();
    write_source(&folder, "a.ply", "uchar");
    let cases: [(&[&str], &str); 7] = [
        (&[], ""),
        (&["--neighbors", "7"], "neighbors = 7"),
        (&["--field", "classification", "--soft-classes", "3,5"], "field = \"classification\"\nsoft_classes = [5, 3]"),
        (&["--field", "height"], "field = \"height\""),
        (&["--field", "label", "--neighbors", "3"], "field = \"label\"\nneighbors = 3"),
        (&["--field", "distance-to-axis"], "field = \"distance-to-axis\""),
        (
            &["--field", "distance-to-axis", "--axis-point", "500001,4.5e6,0.1", "--axis-direction", "-1,0.3,0"],
            "field = \"distance-to-axis\"\naxis = { point = [500001, 4.5e6, 0.1], direction = [-1, 0.3, 0] }",
        ),
    ];
    for (args, keys) in cases {
        prepare(&folder, &[&["a.ply", "-o", "b.ply"], args].concat());
        let wanted = points(&folder, "a.ply", keys);
        assert!(wanted.fields.iter().any(|f| *f > 0.0));
        assert_eq!(points(&folder, "b.ply", keys), wanted, "{keys}");
        // The settings of the preparation are its default.
        assert_eq!(points(&folder, "b.ply", ""), wanted, "{keys}");
        // Under other scales and places, too.
        if !keys.contains("axis = ") {
            let moved = format!("{keys}\nscale = 0.3\ntranslate = [7, 1e6, -2]");
            assert_eq!(points(&folder, "b.ply", &moved), points(&folder, "a.ply", &moved), "{moved}");
        }
    }
}

#[test]
fn other_neighbors_or_fields_are_computed_anew_with_a_note() {
    let folder = folder();
    write_source(&folder, "a.ply", "uchar");
    prepare(&folder, &["a.ply", "-o", "b.ply"]);
    for (keys, note) in [
        ("neighbors = 5", "b.ply: prepared with 24 neighbors, not 5; radii are computed again"),
        ("radius_cap = 0", "b.ply: prepared with radius_cap 4, not 0; radii are computed again"),
        ("field = \"height\"", "b.ply: prepared for field \"uncertainty\" instead of \"height\"; computed again"),
    ] {
        let text = format!("[method]\nname = \"one-layer\"\n[[cloud]]\npath = \"b.ply\"\n{keys}");
        let of = |text: &str| Scene::from_toml(text, &inside(&folder, "s.toml")).unwrap();
        let assembled = |scene: &Scene| {
            let clouds = scene::load_clouds(scene, &Progress::hidden()).unwrap();
            let notes = scene::notes(scene, &clouds, true);
            (scene::assemble(scene, clouds, true, &Progress::hidden()).unwrap(), notes)
        };
        let (points, notes) = assembled(&of(&text));
        assert!(notes[0].ends_with(note), "{notes:?}");
        assert_eq!((points, Vec::new()), assembled(&of(&text.replace("b.ply", "a.ply"))));
    }
}

#[test]
fn pictures_of_prepared_clouds_are_those_of_their_sources() {
    if !has_device() {
        return;
    }
    let folder = folder();
    write_source(&folder, "a.ply", "ushort");
    prepare(&folder, &["a.ply", "-o", "b.ply"]);
    let picture = |cloud: &str, out: &str, method: &[&str]| {
        // The metadata name the input: the two get the same name.
        fs::rename(inside(&folder, cloud), inside(&folder, "c.ply")).unwrap();
        done(&folder, &[&["render", "c.ply", "-o", out, "--size", "64x64", "--method"], method].concat());
        fs::rename(inside(&folder, "c.ply"), inside(&folder, cloud)).unwrap();
        fs::read(inside(&folder, out)).unwrap()
    };
    let threshold = "method.threshold=0.4";
    let methods: [&[&str]; 3] =
        [&["abuffer", "--opacity", "0.5"], &["soft-base", "--set", threshold], &["one-layer", "--set", threshold]];
    for method in methods {
        for format in ["exr", "png"] {
            let [source, prepared] = ["a.ply", "b.ply"].map(|it| picture(it, &format!("1.{format}"), method));
            assert!(source == prepared, "{method:?}, {format}");
        }
    }
    // The field has a say.
    let [all, none] = ["0", "1"].map(|t| {
        // Quiet: above 1 there is no soft point, which is told.
        picture("b.ply", "1.exr", &["soft-base", "-q", "--set", &format!("method.threshold={t}")])
    });
    assert!(all != none);
}

#[test]
fn the_vertical_of_surveys_is_kept() {
    let folder = folder();
    let source = Cloud {
        positions: (0..50).map(|i| DVec3::new(f64::from(i), f64::from(i * i % 7), f64::from(i % 5))).collect(),
        colors: Some(vec![Vec3::new(0.1, 0.25, 0.9); 50]),
        scalars: vec![("radius".into(), vec![3.0; 50]), ("field".into(), vec![2.0; 50]), ("NX".into(), vec![0.0; 50])],
        up: UpAxis::Z,
        ..Cloud::default()
    };
    let request = pellucid_scene::prepare::Request::default();
    let prepared = pellucid_scene::prepare::prepared(source.clone(), &request, &Progress::hidden()).unwrap();
    let path = inside(&folder, "a.ply");
    io::ply::write_prepared(&path, &prepared).unwrap();
    let back = load(&path);
    assert_eq!((back.up, &back.colors), (UpAxis::Z, &source.colors), "linear colors of no integer are exact");
    assert_eq!((&back.prepared, &back.radii), (&prepared.prepared, &prepared.radii));
    // Names that mean something else to the reader get a mark.
    let names: Vec<_> = back.scalars.iter().map(|(name, values)| (name.as_str(), values[0])).collect();
    assert_eq!(names, [("radius_", 3.0), ("field", 2.0), ("NX_", 0.0)]);
}

#[test]
fn normals_are_stored_only_if_asked_for() {
    let folder = folder();
    let sphere: Vec<_> = (0..2000u32)
        .map(|i| {
            let [a, b] = [f64::from(i) * 2.399_963, 1.0 - f64::from(2 * i + 1) / 2000.0];
            DVec3::new(a.cos() * (1.0 - b * b).sqrt(), a.sin() * (1.0 - b * b).sqrt(), b)
        })
        .collect();
    io::ply::write(&inside(&folder, "a.ply"), &Cloud { positions: sphere, ..Cloud::default() }).unwrap();
    prepare(&folder, &["a.ply", "-o", "b.ply"]);
    assert_eq!(load(&inside(&folder, "b.ply")).normals, None);
    prepare(&folder, &["a.ply", "-o", "c.ply", "--normals"]);
    let cloud = load(&inside(&folder, "c.ply"));
    let along = |(p, n): (&DVec3, &Vec3)| p.normalize().dot(n.as_dvec3()).abs();
    let least = cloud.positions.iter().zip(cloud.normals.as_ref().unwrap()).map(along).fold(1.0, f64::min);
    assert!(least > 0.99, "{least}");
    // The field is the same, and found again from the stored normals.
    let fields = |name: &str| load(&inside(&folder, name)).prepared.unwrap().values;
    assert_eq!(fields("b.ply"), fields("c.ply"));
    prepare(&folder, &["c.ply", "-o", "d.ply", "--field", "z"]);
    prepare(&folder, &["d.ply", "-o", "e.ply", "--field", "uncertainty"]);
    assert_eq!(fields("e.ply"), fields("b.ply"));
}

#[test]
fn info_tells_what_was_prepared() {
    let folder = folder();
    write_source(&folder, "a.ply", "uchar");
    prepare(&folder, &["a.ply", "-o", "b.ply", "--field", "classification", "--soft-classes", "1", "--neighbors", "9"]);
    let (_, text, _) = run(&folder, &["info", "b.ply"]);
    assert!(text.contains("prepared    radii and field, 9 neighbors\n  field       classification: "), "{text}");
    let (_, json, _) = run(&folder, &["info", "--json", "b.ply"]);
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(json["prepared"]["field"], serde_json::json!({ "kind": "classification", "classes": [1] }));
    assert_eq!(json["prepared"]["quantiles"].as_object().unwrap().len(), 4);
    assert!(json["attributes"].as_array().unwrap().contains(&"field".into()), "{json}");
}

/// The prepared file with a change in its bytes; the message that loading it gives, if any.
fn warned(folder: &TempDir, change: impl FnOnce(Vec<u8>) -> Vec<u8>) -> (Cloud, String) {
    let bytes = change(fs::read(inside(folder, "b.ply")).unwrap());
    fs::write(inside(folder, "changed.ply"), bytes).unwrap();
    let cloud = load(&inside(folder, "changed.ply"));
    let warnings = cloud.warnings.join("\n");
    (cloud, warnings)
}

fn replaced(bytes: Vec<u8>, from: &str, to: &str) -> Vec<u8> {
    let at = bytes.windows(from.len()).position(|window| window == from.as_bytes()).expect(from);
    [&bytes[..at], to.as_bytes(), &bytes[at + from.len()..]].concat()
}

#[test]
fn comments_that_lie_and_changed_points_are_noticed() {
    let folder = folder();
    write_source(&folder, "a.ply", "uchar");
    prepare(&folder, &["a.ply", "-o", "b.ply"]);
    let changed = "line 3: the points changed after `pellucid prepare`";
    // (from, to, the warning, whether the stored radii stay)
    let cases = [
        ("\"neighbors\":24", "\"neighbors\":12", changed, false),
        ("\"up\":\"z\"", "\"up\":\"y\"", changed, false),
        ("\"kind\":\"uncertainty\"", "\"kind\":\"intensity\"", changed, false),
        ("property float field", "property float yield", changed, false),
        ("property float radius", "property float radiux", changed, false),
        ("\"radius\":\"estimated\"", "\"radius\":\"own\"", changed, true),
        (
            "\"version\":1",
            "\"version\":2",
            "line 3: it was prepared in format 2, but this program reads only format 1",
            true,
        ),
        ("\"version\":1", "\"version\":-1", "names no version", true),
        ("\"neighbors\":24", "\"neighbors\":0", "claims 0 neighbors", true),
        ("\"neighbors\":24", "\"neighbors\":1e99", "can't be read", true),
        ("\"kind\":\"uncertainty\"", "\"kind\":\"nonsense\"", "can't be read", true),
        ("{\"version\"", "\"version\"", "can't be read", true),
        ("{\"version\":1", "{\u{fffd}\"version\":1", "can't be read", true),
    ];
    for (from, to, warning, radii) in cases {
        let (cloud, warnings) = warned(&folder, |bytes| replaced(bytes, from, to));
        assert!(warnings.contains(warning), "{to}: {warnings}");
        assert!(cloud.prepared.is_none() && cloud.radii.is_some() == radii, "{to}");
        assert_eq!(cloud.len(), 300);
    }
    // The last point moved, its radius, its field (NaN, infinity, 2), its label.
    let record = 3 * 8 + 4 + 3 * 4 + 4 + 4 + 1 + 4;
    for (offset, value) in [(0, 1f32), (40, 0.5), (44, f32::NAN), (44, f32::INFINITY), (44, 2.0)] {
        let (cloud, warnings) = warned(&folder, |mut bytes| {
            let at = bytes.len() - record + offset;
            bytes[at..at + 4].copy_from_slice(&value.to_le_bytes());
            bytes
        });
        assert!(warnings.contains(changed) && cloud.prepared.is_none(), "{offset} {value}: {warnings}");
    }
    // Other colors are no other points.
    let (cloud, warnings) = warned(&folder, |mut bytes| {
        let at = bytes.len() - record + 24;
        bytes[at] ^= 1;
        bytes
    });
    assert!(cloud.prepared.is_some() && warnings.is_empty());

    // The binary says so, and goes on as with the source.
    warned(&folder, |bytes| replaced(bytes, "\"neighbors\":24", "\"neighbors\":12"));
    let (code, _, stderr) = run(&folder, &["info", "changed.ply"]);
    assert!(code == 0 && stderr.starts_with("warning: changed.ply: line 3: "), "{stderr}");
    assert_eq!(points(&folder, "changed.ply", ""), points(&folder, "a.ply", ""));
}

#[test]
fn inputs_that_can_not_be_prepared_give_one_error() {
    let folder = folder();
    write_source(&folder, "a.ply", "uchar");
    fs::write(inside(&folder, "s.toml"), "[[cloud]]\npath = \"a.ply\"\n").unwrap();
    let cases: [(&[&str], i32, &str); 12] = [
        (&["a.ply", "-o", "b.las"], 2, "the name must end in .ply"),
        (&["s.toml", "-o", "b.ply"], 2, "prepare takes a point cloud"),
        (&["no.ply", "-o", "b.ply"], 1, "no.ply: no such file"),
        (&["a.ply", "-o", "no/b.ply"], 1, "no folder"),
        (&["a.ply", "-o", "b.ply", "--neighbors", "0"], 2, "--neighbors: `cloud.0.neighbors`"),
        (&["a.ply", "-o", "b.ply", "--field", "classification"], 2, "needs soft_classes"),
        (&["a.ply", "-o", "b.ply", "--field", "classification", "--soft-classes", "3,x"], 2, "--soft-classes"),
        (&["a.ply", "-o", "b.ply", "--field", "classification", "--soft-classes", "256"], 2, "0 to 255"),
        (&["a.ply", "-o", "b.ply", "--field", "distance-to-axis", "--axis-direction", "0,0,0"], 2, "a direction"),
        (&["a.ply", "-o", "b.ply", "--field", "intensity"], 1, "a.ply: field = \"intensity\", but the file has none"),
        (
            &["a.ply", "-o", "b.ply", "--field", "heights"],
            1,
            "no scalar property `heights` for field; did you mean `height`?",
        ),
        (&["a.ply"], 2, "--output"),
    ];
    for (args, status, part) in cases {
        assert_refused(&folder, &[&["prepare"], args].concat(), status, &[part]);
    }
}
