//! Shadows from the command line: stored with a cloud by `prepare`, the same picture as cast anew, and what is said of
//! them.

use std::fs;
use std::path::Path;

use glam::{DVec3, Vec3};
use pellucid_core::cloud::Cloud;
use pellucid_core::progress::Progress;
use pellucid_io as io;
use tempfile::TempDir;

use crate::{assert_refused, assert_refused_with_device, device, done, folder, has_device, inside, run};

const LIGHT: [&str; 10] = [
    "--light",
    "0.3,-1,0.2",
    "--shadow-samples",
    "5",
    "--light-radius",
    "4",
    "--shadow-resolution",
    "64",
    "--seed",
    "3",
];
const SHADING: &str = "[shading]\nmodel = \"lambert\"\nlight = [0.6, -2.0, 0.4]\n";
const SHADOWS: &str = "[shadows]\nsamples = 5\nlight_radius = 4\nresolution = 64\n";

/// A sphere over a floor, in no order that the program would choose; without normals half of it.
fn write_source(folder: &TempDir, name: &str, normals: bool) {
    let floor = (0..1600).map(|i| {
        let at = |k: i32| f64::from(k) * 0.1 - 2.0;
        (DVec3::new(at(i * 7 % 40), 0.0, at(i / 40)), Vec3::Y)
    });
    let sphere = (0..1500).map(|i| {
        let (y, turn) = (1.0 - (f64::from(i) + 0.5) / 750.0, 2.399_963 * f64::from(i));
        let ring = (1.0 - y * y).sqrt();
        let n = DVec3::new(ring * turn.cos(), y, ring * turn.sin());
        (DVec3::Y + 0.6 * n, n.as_vec3())
    });
    let (positions, all): (Vec<_>, Vec<_>) = floor.chain(sphere).unzip();
    let normals = normals.then(|| all.into_iter().map(|n| n.normalize()).collect());
    let colors = Some((0..positions.len()).map(|i| Vec3::new(0.9, 0.5, (i % 5) as f32 / 4.0)).collect());
    io::ply::write(&inside(folder, name), &Cloud { positions, colors, normals, ..Cloud::default() }).unwrap();
}

fn write_scene(folder: &TempDir, cloud: &str, method: &str, keys: &str) {
    let text = format!(
        "[image]\nsize = [80, 60]\n{SHADING}{SHADOWS}{keys}[method]\nname = {method:?}\n[[cloud]]\npath = {cloud:?}\nradius = 0.08\n"
    );
    fs::write(inside(folder, "s.toml"), text).unwrap();
}

fn load(path: &Path) -> Cloud {
    io::load(path, &Progress::hidden()).unwrap()
}

/// Standard error and the picture of `s.toml`, and whether it cast shadows.
fn render(folder: &TempDir, cloud: &str) -> (String, Vec<u8>, bool) {
    // The metadata name the input: all of them get the same name.
    fs::rename(inside(folder, cloud), inside(folder, "c.ply")).unwrap();
    let device = device().map_or_else(Vec::new, |device| vec!["--device".to_owned(), device]);
    let args = ["render", "s.toml", "-o", "1.exr", "--seed", "3", "--profile", "p.json"];
    let args: Vec<&str> = args.into_iter().chain(device.iter().map(String::as_str)).collect();
    let (code, stdout, stderr) = run(folder, &args);
    fs::rename(inside(folder, "c.ply"), inside(folder, cloud)).unwrap();
    assert_eq!((code, stdout.as_str()), (0, ""), "{stderr}");
    let profile = fs::read_to_string(inside(folder, "p.json")).unwrap();
    (stderr, fs::read(inside(folder, "1.exr")).unwrap(), profile.contains("\"shadows/lit\""))
}

#[test]
fn stored_shadows_give_the_picture_of_those_that_are_cast() {
    if !has_device() {
        return;
    }
    for normals in [true, false] {
        let folder = folder();
        write_source(&folder, "a.ply", normals);
        done(&folder, &["prepare", "a.ply", "-o", "plain.ply"]);
        done(&folder, &[&["prepare", "a.ply", "-o", "b.ply"], &LIGHT[..]].concat());
        // Preparing again keeps them, and asking for the same ones gives the same file.
        done(&folder, &["prepare", "b.ply", "-o", "kept.ply"]);
        done(&folder, &[&["prepare", "b.ply", "-o", "again.ply"], &LIGHT[..]].concat());
        let bytes = |name: &str| fs::read(inside(&folder, name)).unwrap();
        assert!(bytes("kept.ply") == bytes("b.ply") && bytes("again.ply") == bytes("b.ply"));
        let lit = load(&inside(&folder, "b.ply")).prepared.unwrap().shadows.unwrap().lit;
        let partly = lit.iter().filter(|m| **m > 0.0 && **m < 1.0).count();
        assert!(lit.contains(&0.0) && lit.contains(&1.0) && partly > 50, "{partly}");
        for method in ["points", "circles", "splats", "auto"] {
            write_scene(&folder, "c.ply", method, "");
            let (said, cast, casts) = render(&folder, "plain.ply");
            assert!(said.is_empty() && casts, "{method}: {said}");
            let (said, stored, casts) = render(&folder, "b.ply");
            assert!(said.is_empty() && !casts, "{method}: {said}");
            assert!(cast == stored, "{method}, normals: {normals}");
        }
        // They have a say.
        let text = fs::read_to_string(inside(&folder, "s.toml")).unwrap();
        fs::write(inside(&folder, "s.toml"), text.replace(SHADOWS, "")).unwrap();
        let unlit = render(&folder, "b.ply").1;
        fs::write(inside(&folder, "s.toml"), text).unwrap();
        assert!(unlit != render(&folder, "b.ply").1);
    }
}

#[test]
fn shadows_of_other_settings_are_cast_anew_with_a_note() {
    if !has_device() {
        return;
    }
    let folder = folder();
    write_source(&folder, "a.ply", true);
    done(&folder, &["prepare", "a.ply", "-o", "plain.ply"]);
    done(&folder, &[&["prepare", "a.ply", "-o", "b.ply"], &LIGHT[..]].concat());
    let (light, samples) = ("light = [0.6, -2.0, 0.4]", "samples = 5");
    for (from, to, why) in [
        (light, "light = [0, -1, 0]", "stored for other settings (light); cast again"),
        (light, "light = { position = [0, 5, 0] }", "stored for other settings (light); cast again"),
        (samples, "samples = 6", "stored for other settings (samples); cast again"),
        ("light_radius = 4", "light_radius = 5", "stored for other settings (light_radius); cast again"),
        ("resolution = 64", "resolution = 32", "stored for other settings (resolution); cast again"),
        ("resolution = 64", "resolution = 64\nfill = 0", "stored for other settings (fill); cast again"),
        ("resolution = 64", "resolution = 64\nocclusion = 2", "stored for other settings (occlusion); cast again"),
        (samples, "min_layer_distance = 0.2", "stored for other settings (samples, min_layer_distance); cast again"),
        ("radius = 0.08", "radius = 0.08\nscale = 2.0", "stored for the cloud where it is in its file; cast again"),
        ("radius = 0.08", "translate = [1, 0, 0]", "stored for the cloud where it is in its file; cast again"),
        ("radius = 0.08", "[[cloud]]\npath = \"a.ply\"", "stored for this cloud by itself; cast again"),
    ] {
        write_scene(&folder, "c.ply", "points", "");
        let text = fs::read_to_string(inside(&folder, "s.toml")).unwrap();
        fs::write(inside(&folder, "s.toml"), text.replacen(from, to, 1)).unwrap();
        let (said, found, casts) = render(&folder, "b.ply");
        assert!(said.contains("c.ply: shadows ") && said.contains(why) && casts, "{to}: {said}");
        let (said, wanted, _) = render(&folder, "plain.ply");
        assert!(said.is_empty() && found == wanted, "{to}: {said}");
    }
}

#[test]
fn info_and_plan_tell_of_stored_shadows() {
    if !has_device() {
        return;
    }
    let folder = folder();
    write_source(&folder, "c.ply", true);
    write_scene(&folder, "c.ply", "points", "");
    let plan = |args: &[&str]| done(&folder, &[&["plan", "s.toml", "--seed", "3"], args].concat());
    let line = |plan: &str, name: &str| plan.lines().find(|line| line.starts_with(name)).unwrap().to_owned();
    let lit = line(&plan(&[]), "shadows/lit");
    assert!(lit.contains(" on ") && lit.contains("3100 points"), "{lit}");
    for (args, why) in [
        (["--method", "sorted"], "method \"sorted\" takes no shadows"),
        (["--set", "shading.model=none"], "shadows need shading"),
        (["--set", "shading.light=headlight"], "a headlight casts no shadows"),
    ] {
        let (code, text, stderr) = run(&folder, &[&["plan", "s.toml"], &args[..]].concat());
        assert!(code == 0 && stderr.contains("[shadows] has no effect") && stderr.contains(why), "{stderr}");
        assert!(line(&text, "shadows/lit").contains(" off "), "{text}");
    }
    done(&folder, &[&["prepare", "c.ply", "-o", "lit.ply"], &LIGHT[..]].concat());
    fs::rename(inside(&folder, "lit.ply"), inside(&folder, "c.ply")).unwrap();
    let lit = line(&plan(&[]), "shadows/lit");
    assert!(lit.contains(" off ") && lit.contains("the cloud already holds the light of each point"), "{lit}");
    let text = run(&folder, &["info", "c.ply"]).1;
    assert!(text.contains("\n  shadows     a light along ["), "{text}");
    assert!(text.contains(", 5 lights within 4°, seed 3, 64 × 64 pixels, surfaces "), "{text}");
    let json: serde_json::Value = serde_json::from_str(&run(&folder, &["info", "--json", "c.ply"]).1).unwrap();
    let shadows = &json["prepared"]["shadows"];
    assert_eq!((&shadows["samples"], &shadows["resolution"]), (&5.into(), &64.into()));
    assert_eq!(shadows["direction"].as_array().unwrap().len(), 3);
    assert!(json["attributes"].as_array().unwrap().contains(&"lit".into()), "{json}");
}

#[test]
fn shadows_that_were_changed_are_noticed() {
    if !has_device() {
        return;
    }
    let folder = folder();
    write_source(&folder, "a.ply", true);
    done(&folder, &[&["prepare", "a.ply", "-o", "b.ply"], &LIGHT[..]].concat());
    let bytes = fs::read(inside(&folder, "b.ply")).unwrap();
    let changed = |from: &str, to: &str| {
        let at = bytes.windows(from.len()).position(|window| window == from.as_bytes()).expect(from);
        let changed = [&bytes[..at], to.as_bytes(), &bytes[at + from.len()..]].concat();
        fs::write(inside(&folder, "changed.ply"), changed).unwrap();
        load(&inside(&folder, "changed.ply"))
    };
    // The message about them.
    let cloud = changed("\"samples\":5", "\"samples\":6");
    assert!(cloud.prepared.is_some_and(|prepared| prepared.shadows.is_none()));
    assert!(cloud.warnings[0].contains("line 3: the comment about `lit` was changed"), "{:?}", cloud.warnings);
    // A reader that knows nothing of them finds a prepared cloud with one more property.
    let whole = String::from_utf8_lossy(&bytes);
    let object = whole.split("\"shadows\":").nth(1).unwrap();
    let object = &object[..=object.find('}').unwrap()];
    let cloud = changed(&format!(",\"shadows\":{object}"), "");
    assert!(cloud.warnings.is_empty() && cloud.prepared.unwrap().shadows.is_none());
    assert_eq!(cloud.scalars.len(), 1);
    // They themselves, in the last record.
    let mut other = bytes.clone();
    let last = other.len() - 4;
    other[last..].copy_from_slice(&0.125f32.to_le_bytes());
    fs::write(inside(&folder, "changed.ply"), other).unwrap();
    let cloud = load(&inside(&folder, "changed.ply"));
    assert!(cloud.prepared.is_none() && cloud.warnings[0].contains("the points changed"), "{:?}", cloud.warnings);
    assert_eq!(cloud.scalars.len(), 0);
}

#[test]
fn a_light_that_can_not_be_is_one_error() {
    let folder = folder();
    write_source(&folder, "a.ply", true);
    let cases: [(&[&str], i32, &str); 11] = [
        (&["--light", "0,0,0"], 2, "a direction"),
        (&["--light", "1,2"], 2, "--light"),
        (&["--light-position", "1,2,x"], 2, "--light-position"),
        (&["--light", "0,-1,0", "--shadow-samples", "0"], 2, "--shadow-samples"),
        (&["--light", "0,-1,0", "--light-radius", "90"], 2, "below 90 degrees"),
        (&["--light", "0,-1,0", "--shadow-resolution", "99999"], 2, "from 1 to 16384"),
        (&["--light", "0,-1,0", "--shadow-resolution", "many"], 2, "auto"),
        (&["--light", "0,-1,0", "--shadow-fill", "257"], 2, "from 0 to 256"),
        (&["--shadow-occlusion", "2"], 2, "--light"),
        (&["--light", "0,-1,0", "--light-position", "1,2,3"], 2, "cannot be used with"),
        (&["--shadow-samples", "5"], 2, "--light"),
    ];
    for (args, status, part) in cases {
        assert_refused(&folder, &[&["prepare", "a.ply", "-o", "b.ply"], args].concat(), status, &[part]);
    }
    if has_device() {
        let small = ["--light", "0,-1,0", "--shadow-resolution", "2000", "--memory-budget", "8MiB"];
        let args = [&["prepare", "a.ply", "-o", "b.ply"], &small[..]].concat();
        // 1024² pixels of 8 bytes.
        let parts = ["shadows.resolution = 2000 needs", "up to 1024 would do"];
        assert_refused_with_device(&folder, &args, 1, &parts);
    }
}

#[test]
fn auto_says_if_the_scene_has_no_opaque_method() {
    if !has_device() {
        return;
    }
    let folder = folder();
    write_source(&folder, "a.ply", true);
    write_scene(&folder, "c.ply", "auto", "");
    let text = fs::read_to_string(inside(&folder, "s.toml")).unwrap() + "opacity = 0.5\n";
    fs::write(inside(&folder, "s.toml"), text).unwrap();
    let (said, _, casts) = render(&folder, "a.ply");
    assert!(said.contains("[shadows] has no effect: method") && !casts, "{said}");
}

/// A disc of scattered points over a floor of others. Coordinates are multiples of irrational numbers (Roberts 2018):
/// scattered, without gaps.
fn write_disc(folder: &TempDir, name: &str, disc: u32, floor: u32) {
    let place = |i: u32| [0.754_877_666, 0.569_840_291].map(|step: f64| (f64::from(i) * step).fract());
    let on_floor = (0..floor).map(|i| DVec3::new(place(i)[0], place(i)[1], 0.0));
    let above = (0..).map(|i| DVec3::new(place(i)[1], place(i)[0], 0.4));
    let above = above.filter(|p| (p.x - 0.5).hypot(p.y - 0.5) < 0.3).take(disc as usize);
    let positions: Vec<DVec3> = on_floor.chain(above).collect();
    let colors = Some(vec![Vec3::ONE; positions.len()]);
    io::ply::write(&inside(folder, name), &Cloud { positions, colors, ..Cloud::default() }).unwrap();
}

#[test]
fn holes_in_shadows_are_warned_of_where_light_falls_through_them() {
    if !has_device() {
        return;
    }
    let folder = folder();
    write_disc(&folder, "a.ply", 2000, 20_000);
    let device = device().map_or_else(Vec::new, |device| vec!["--device".to_owned(), device]);
    let device: Vec<&str> = device.iter().map(String::as_str).collect();
    let said = |args: &[&str]| {
        let (code, _, stderr) = run(&folder, &[args, &device].concat());
        assert_eq!(code, 0, "{stderr}");
        stderr
    };
    let shown = |set: &[&str]| {
        let light =
            ["--set", "shading.model=lambert", "--set", "shading.light=[0, 0, -1]", "--set", "shadows.samples=1"];
        let keys: Vec<&str> = set.iter().flat_map(|key| ["--set", *key]).collect();
        let render = ["render", "a.ply", "-o", "1.png", "--method", "points", "--size", "80x60"];
        said(&[&render[..], &light, &keys].concat())
    };
    // Half of 22 000 points on as many pixels are 105 columns.
    let why = "light falls between the points";
    let text = shown(&["shadows.resolution=1024"]);
    assert!(text.contains(why) && text.contains("shadows.resolution = \"auto\" (105)"), "{text}");
    assert!(text.contains("(1024 × 1024 pixels)"), "{text}");
    // Automatic, and coarse.
    assert!(!shown(&[]).contains(why));
    assert!(!shown(&["shadows.resolution=64", "shadows.fill=0"]).contains(why));
    // Points above nothing may have any holes.
    write_disc(&folder, "a.ply", 0, 20_000);
    assert!(!shown(&["shadows.resolution=1024"]).contains(why));
    // So does `prepare`, which knows the same options.
    write_disc(&folder, "a.ply", 2000, 20_000);
    let light = ["prepare", "a.ply", "-o", "b.ply", "--light", "0,0,-1"];
    let fine = ["--shadow-resolution", "1024", "--shadow-fill", "2", "--shadow-occlusion", "3"];
    assert!(said(&[&light[..], &fine].concat()).contains(why));
    assert!(run(&folder, &["info", "b.ply"]).1.contains("1024 × 1024 pixels, surfaces 0.0"));
    assert!(run(&folder, &["info", "b.ply"]).1.contains("apart, fill 2, occlusion 3"));
    assert!(!said(&light).contains(why));
    let json: serde_json::Value = serde_json::from_str(&run(&folder, &["info", "--json", "b.ply"]).1).unwrap();
    let shadows = &json["prepared"]["shadows"];
    // One iteration of occlusion is left out, as in files of before it was a setting.
    assert_eq!((&shadows["resolution"], &shadows["fill"]), (&105.into(), &1.into()));
    assert!(shadows["occlusion"].is_null());
}
