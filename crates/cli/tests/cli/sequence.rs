//! `render --path` and `render --turntable`: frames that belong together, and what happens when a run is cut short.

use std::collections::BTreeMap;
use std::fs;

use pellucid_io::output::metadata;
use serde_json::Value;
use tempfile::TempDir;

use crate::{assert_refused, builtin, device, done, folder, has_device, inside, pellucid, run};

use super::render::exr;

/// Three keys around the garden.
const KEYS: &str = r#"{"version": 1, "keys": [
    {"eye": [12, -9, 6], "target": [0, 0, 1]},
    {"eye": [12, 9, 6], "target": [0, 0, 1], "fov_y": 50},
    {"eye": [3, 9, 2], "target": [0, 0, 1]}
]}"#;

/// A garden of few points with a path beside it.
pub fn garden() -> TempDir {
    let folder = folder();
    builtin(&folder, "garden", &["points=3000"]);
    // A key of its method that others don't have would be a warning.
    let scene = inside(&folder, "garden/scene.toml");
    let plain = fs::read_to_string(&scene).unwrap().replace("shape = \"oriented\"\n", "");
    fs::write(scene, plain).unwrap();
    fs::write(inside(&folder, "path.json"), KEYS).unwrap();
    folder
}

/// The arguments of a small render of it.
fn small<'a>(more: &[&'a str]) -> Vec<&'a str> {
    [&["render", "garden/scene.toml", "--method", "circles", "--size", "48x36"], more].concat()
}

/// The camera of each frame of a profile.
fn cameras(folder: &TempDir, profile: &str) -> Vec<Value> {
    json(folder, profile)["frames"].as_array().unwrap().iter().map(|frame| frame["camera"].clone()).collect()
}

/// The largest difference of two numbers at the same place of two JSON values, relative where they are above 1;
/// infinite where the values have other places.
fn apart(a: &Value, b: &Value) -> f64 {
    let both: Vec<(&Value, &Value)> = match (a, b) {
        (Value::Number(a), Value::Number(b)) => {
            let [a, b] = [a, b].map(|number| number.as_f64().unwrap());
            return (a - b).abs() / a.abs().max(1.0);
        }
        (Value::Array(a), Value::Array(b)) if a.len() == b.len() => a.iter().zip(b).collect(),
        (Value::Object(a), Value::Object(b)) if a.keys().eq(b.keys()) => a.values().zip(b.values()).collect(),
        _ => return f64::INFINITY,
    };
    both.into_iter().map(|(a, b)| apart(a, b)).fold(0.0, f64::max)
}

/// The pictures of a folder and their bytes.
pub fn pictures(folder: &TempDir) -> BTreeMap<String, Vec<u8>> {
    let files = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let pictures = files.filter(|path| path.extension().is_some_and(|e| e == "png" || e == "exr"));
    pictures.map(|path| (path.file_name().unwrap().to_str().unwrap().to_owned(), fs::read(path).unwrap())).collect()
}

/// Runs and returns what was said on standard error; the run succeeds.
pub fn said(folder: &TempDir, args: &[&str]) -> String {
    let device = device().map_or_else(Vec::new, |device| vec!["--device".to_owned(), device]);
    let output = pellucid(folder, args).args(device).output().unwrap();
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert_eq!((output.status.code(), output.stdout.len()), (Some(0), 0), "{stderr}");
    stderr
}

/// Returns the number of frames that a run with -v wrote.
pub fn written(said: &str) -> usize {
    said.lines().filter(|line| line.ends_with(": written")).count()
}

pub fn json(folder: &TempDir, name: &str) -> Value {
    serde_json::from_slice(&fs::read(inside(folder, name)).unwrap()).unwrap()
}

#[test]
fn a_path_gives_a_frame_for_each_key_or_so_many_between_them() {
    if !has_device() {
        return;
    }
    let folder = garden();
    done(&folder, &small(&["--path", "path.json", "-o", "key_%d.exr"]));
    done(&folder, &small(&["--path", "path.json", "--frames", "5", "-o", "frame_%04d.exr", "--profile", "p.json"]));
    let names: Vec<String> = pictures(&folder).into_keys().collect();
    let frames = (0..5).map(|i| format!("frame_{i:04}.exr"));
    assert_eq!(names, frames.chain((0..3).map(|i| format!("key_{i}.exr"))).collect::<Vec<_>>());
    // Every other frame is at a key: the same picture.
    let [first, middle] = ["frame_0000.exr", "frame_0001.exr"].map(|name| exr(&inside(&folder, name)).0);
    for key in 0..3 {
        let (frame, of_frame) = exr(&inside(&folder, &format!("frame_{:04}.exr", 2 * key)));
        let (key, _) = exr(&inside(&folder, &format!("key_{key}.exr")));
        let bits = |channel: &Vec<f32>| channel.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
        assert!(frame.iter().all(|(name, channel)| bits(channel) == bits(&key[name])));
        assert!(of_frame["pellucid:frame"].ends_with(" of 5") && of_frame["pellucid:sequence"].len() == 64);
    }
    assert!(first != middle, "the camera moves");
    // A scene whose camera stands there gives the same picture.
    let keys = ["camera.eye=[12, 9, 6]", "camera.target=[0, 0, 1]", "camera.up=[0, 0, 1]", "camera.fov_y=50"];
    let sets: Vec<&str> = keys.iter().flat_map(|key| ["--set", *key]).collect();
    done(&folder, &small(&[&sets[..], &["-o", "there.exr"]].concat()));
    let [there, key] = ["there.exr", "key_1.exr"].map(|name| exr(&inside(&folder, name)).0);
    let covered = |channels: &BTreeMap<String, Vec<f32>>| channels["A"].iter().filter(|a| **a > 0.0).count();
    let differ = there["A"].iter().zip(&key["A"]).filter(|(a, b)| a != b).count();
    assert!(covered(&there) > 100 && differ == 0, "{differ} of {} pixels", covered(&there));
    // The profile has all frames with their cameras.
    let profile = json(&folder, "p.json");
    let frames = profile["frames"].as_array().unwrap();
    assert_eq!(frames.iter().map(|frame| frame["frame"].as_u64().unwrap()).collect::<Vec<_>>(), [0, 1, 2, 3, 4]);
    for (frame, eye) in [(0, [12.0, -9.0, 6.0]), (2, [12.0, 9.0, 6.0]), (4, [3.0, 9.0, 2.0])] {
        assert_eq!(frames[frame]["camera"]["eye"], serde_json::json!(eye));
    }
    assert!((frames[2]["camera"]["fov_y"].as_f64().unwrap() - 50.0).abs() < 1e-12);
    for key in ["gpu_ms", "wall_ms", "fragments", "max_list"] {
        assert!(frames.iter().all(|frame| frame[key].is_number()), "{key}");
    }
    assert!(!inside(&folder, "p.json.partial").exists());
}

#[test]
fn a_turntable_goes_around() {
    if !has_device() {
        return;
    }
    let folder = garden();
    let turn = |azimuth: &str, pattern: &str| {
        let view = ["--azimuth", azimuth, "--elevation", "20", "--background", "0,0,0", "-q", "-o", pattern];
        let profile = ["--profile", "turn.json"];
        done(&folder, &small(&[&["--turntable", "--frames", "4"], &view[..], &profile].concat()));
        cameras(&folder, "turn.json")
    };
    // An eye of the scene from which corners would be lost goes back, which is no warning but a note.
    let told = said(&folder, &small(&["--turntable", "--frames", "1", "-o", "own_%d.png", "-v"]));
    assert!(told.contains("since from [12.5, -20.0, 13.5] it would lose points"), "{told}");
    fs::remove_file(inside(&folder, "own_0.png")).unwrap();
    let (from_10, from_100) = (turn("10", "a_%d.png"), turn("100", "b_%d.png"));
    let read = |name: String| pellucid_io::output::read_image(&inside(&folder, &name)).unwrap();
    for i in 0..4 {
        // A quarter is 90° of azimuth: the same cameras apart from rounding. Their pictures are not compared, since a
        // rounding may move a disc's edge over a pixel.
        let next = (i + 1) % 4;
        let (same, other) = (apart(&from_10[next], &from_100[i]), apart(&from_10[i], &from_100[i]));
        assert!(same < 1e-12 && other > 0.1, "frame {i}: {same} apart, the next frame {other}");
        let (a, b) = (read(format!("a_{i}.png")), read(format!("a_{next}.png")));
        let differ = a.pixels.iter().zip(&b.pixels).filter(|(a, b)| a != b).count();
        assert!(differ > 100, "frame {i}: the next differs by {differ} pixels only");
    }
    // All of the scene is in every frame: nothing touches the border.
    for i in 0..4 {
        let image = read(format!("a_{i}.png"));
        let (width, height) = (image.width as usize, image.height as usize);
        let lit = |x: usize, y: usize| image.pixels[y * width + x] != [0.0; 3];
        let border =
            (0..width).any(|x| lit(x, 0) || lit(x, height - 1)) || (0..height).any(|y| lit(0, y) || lit(width - 1, y));
        let count = image.pixels.iter().filter(|pixel| **pixel != [0.0; 3]).count();
        assert!(!border && count > 100, "frame {i}: {count} pixels");
    }
}

#[test]
fn frames_that_are_there_are_not_rendered_again_and_others_are_not_mixed_in() {
    if !has_device() {
        return;
    }
    let folder = garden();
    let args = |more: &[&'static str]| small(&[&["--path", "path.json", "--frames", "6", "-v"], more].concat());
    let first = said(&folder, &args(&["-o", "f_%d.png"]));
    let whole = pictures(&folder);
    assert_eq!((written(&first), whole.len()), (6, 6), "{first}");
    // One is gone, one was cut short.
    fs::remove_file(inside(&folder, "f_2.png")).unwrap();
    let again = said(&folder, &args(&["-o", "f_%d.png"]));
    assert!(written(&again) == 1 && again.contains("f_2.png: written"), "{again}");
    assert!(again.contains("5 of 6 frames were there already, 1 were rendered"), "{again}");
    assert!(pictures(&folder) == whole, "byte for byte");
    assert_eq!(written(&said(&folder, &args(&["-o", "f_%d.png"]))), 0);
    let refused = |more: &[&'static str]| {
        let args = args(more);
        let (status, _, stderr) = run(&folder, &args);
        assert!(status == 1 && stderr.contains("f_0.png: this file is not a frame of this sequence"), "{stderr}");
        assert!(stderr.contains("--overwrite") && pictures(&folder) == whole, "{stderr}");
    };
    refused(&["-o", "f_%d.png", "--set", "method.size=1.5"]);
    refused(&["-o", "f_%d.png", "--background", "0.1,0,0"]);
    refused(&["-o", "f_%d.png", "--transparent"]);
    refused(&["-o", "f_%d.png", "--seed", "3"]);
    refused(&["-o", "f_%d.png", "--set", "cloud.0.color=[1, 0, 0]"]);
    // Another size, another path, fewer frames, of which those after the last would be mixed in.
    let other = |args: &[&str], count: &str| {
        let (status, _, stderr) = run(&folder, args);
        assert!(status == 1 && stderr.contains(count) && pictures(&folder) == whole, "{stderr}");
    };
    let path = ["--path", "path.json", "-o", "f_%d.png"];
    other(
        &[&["render", "garden/scene.toml", "--method", "circles", "--size", "50x36", "--frames", "6"], &path[..]]
            .concat(),
        "(6 such files)",
    );
    other(&small(&["--path", "path.json", "-o", "f_%d.png", "--frames", "4"]), "(6 such files)");
    fs::write(inside(&folder, "path.json"), KEYS.replace("[3, 9, 2]", "[3, 9, 3]")).unwrap();
    // The first frame is where it was, and so is its picture; the others are not.
    let (status, _, stderr) = run(&folder, &args(&["-o", "f_%d.png"]));
    assert!(status == 1 && stderr.contains("f_1.png: ") && stderr.contains("(5 such files)"), "{stderr}");
    assert!(pictures(&folder) == whole);
    // Asked to, it replaces them all, and what follows the last.
    fs::write(inside(&folder, "f_7.png"), "not next to the others").unwrap();
    fs::write(inside(&folder, "f_6.png"), "something").unwrap();
    let said = said(&folder, &args(&["-o", "f_%d.png", "--overwrite"]));
    assert_eq!(written(&said), 5, "{said}");
    assert!(!inside(&folder, "f_6.png").exists() && !inside(&folder, "f_7.png").exists());
}

#[test]
fn a_damaged_frame_is_no_frame() {
    if !has_device() {
        return;
    }
    let folder = garden();
    let args = small(&["--turntable", "--frames", "2", "-o", "f_%d.png"]);
    done(&folder, &args);
    let whole = fs::read(inside(&folder, "f_1.png")).unwrap();
    let name = "pellucid:sequence";
    assert_eq!(metadata(&inside(&folder, "f_1.png"), name).map(|text| text.len()), Some(64));
    assert_eq!(metadata(&inside(&folder, "f_1.png"), "pellucid:none"), None);
    for length in [0, 7, 100, whole.len() - 1] {
        fs::write(inside(&folder, "f_1.png"), &whole[..length]).unwrap();
        assert_eq!(metadata(&inside(&folder, "f_1.png"), name), None);
        let (status, _, stderr) = run(&folder, &args);
        assert!(status == 1 && stderr.contains("f_1.png: this file is not a frame"), "{stderr}");
    }
    done(&folder, &[&args[..], &["--overwrite", "-q"]].concat());
    assert!(fs::read(inside(&folder, "f_1.png")).unwrap() == whole);
}

#[test]
fn a_profile_that_was_not_asked_for_in_time_says_so() {
    if !has_device() {
        return;
    }
    let folder = garden();
    let args = |more: &[&'static str]| small(&[&["--turntable", "--frames", "3", "-o", "f_%d.png"], more].concat());
    done(&folder, &args(&[]));
    fs::remove_file(inside(&folder, "f_1.png")).unwrap();
    let text = said(&folder, &args(&["--profile", "p.json", "--trace", "t.json"]));
    assert!(text.contains("the profile lacks 2 of 3 frames, the first is frame 0"), "{text}");
    let numbers = |name: &str| {
        let frames = json(&folder, name)["frames"].as_array().unwrap().clone();
        frames.iter().map(|frame| frame["frame"].as_u64().unwrap()).collect::<Vec<_>>()
    };
    assert_eq!(numbers("p.json"), [1]);
    assert!(json(&folder, "t.json")["traceEvents"].as_array().unwrap().len() > 2);
    // With all frames there the profile stays as it is.
    let before = fs::read(inside(&folder, "p.json")).unwrap();
    said(&folder, &args(&["--profile", "p.json"]));
    assert_eq!(fs::read(inside(&folder, "p.json")).unwrap(), before);
    // Another sequence has nothing of it.
    done(&folder, &small(&["--turntable", "--frames", "2", "-o", "g_%d.png", "--profile", "p.json"]));
    assert_eq!(numbers("p.json"), [0, 1]);
}

#[test]
fn profile_measures_each_frame_of_a_path() {
    if !has_device() {
        return;
    }
    let folder = garden();
    for method in ["circles", "sorted"] {
        let base =
            ["profile", "garden/scene.toml", "--method", method, "--size", "48x36", "--opacity", "0.5", "--json"];
        let keys: Value =
            serde_json::from_str(&done(&folder, &[&base[..], &["--path", "path.json"]].concat())).unwrap();
        assert_eq!(keys["frames"].as_array().unwrap().len(), 3);
        let turn = [&base[..], &["--turntable", "--frames", "4"]].concat();
        let turn: Value = serde_json::from_str(&done(&folder, &turn)).unwrap();
        let frames = turn["frames"].as_array().unwrap();
        let eyes: Vec<_> = frames.iter().map(|frame| frame["camera"]["eye"].to_string()).collect();
        let fov = frames[0]["camera"]["fov_y"].as_f64().unwrap();
        assert!(eyes.len() == 4 && eyes[0] != eyes[1] && (fov - 37.0).abs() < 1e-12, "{eyes:?}, {fov}");
        if method == "sorted" {
            assert!(frames.iter().all(|frame| frame["fragments"].as_u64().unwrap() > 100), "lists are counted");
            let names = frames.iter().flat_map(|frame| frame["passes"].as_array().unwrap());
            assert!(!names.map(|pass| pass["name"].as_str().unwrap()).any(|name| name == "abuffer/count"), "beside");
        }
    }
}

#[test]
fn cameras_of_other_programs() {
    if !has_device() {
        return;
    }
    let folder = garden();
    // Looking down from (0, 0, 20) with +y at the top.
    let frame = "{\"transform_matrix\": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 20], [0, 0, 0, 1]]}";
    let head = "\"fl_x\": 30, \"fl_y\": 30, \"cx\": 20, \"cy\": 16, \"w\": 40, \"h\": 30";
    fs::write(inside(&folder, "transforms.json"), format!("{{{head}, \"frames\": [{frame}]}}")).unwrap();
    fs::create_dir(inside(&folder, "model")).unwrap();
    fs::write(inside(&folder, "model/cameras.txt"), "1 PINHOLE 40 30 30 30 20 15\n").unwrap();
    // x right, y down, z forward: a turn by 180° around x.
    fs::write(inside(&folder, "model/images.txt"), "1 0 1 0 0 0 0 20 1 a.jpg\n\n").unwrap();
    let base = ["render", "garden/scene.toml", "--method", "circles"];
    let path = |path, out, profile| [&base[..], &["--path", path, "-o", out, "--profile", profile]].concat();
    let text = said(&folder, &path("transforms.json", "n%d.exr", "n.json"));
    assert!(text.contains("warning: transforms.json: ") && text.contains("principal point"), "{text}");
    done(&folder, &path("model", "c%d.exr", "c.json"));
    let [n, c] = ["n0.exr", "c0.exr"].map(|name| exr(&inside(&folder, name)).0);
    assert_eq!(n["A"].len(), 40 * 30, "as large as the pictures");
    let shown = |channels: &BTreeMap<String, Vec<f32>>| channels["A"].iter().filter(|a| **a > 0.0).count();
    assert_eq!(c["A"].len(), n["A"].len());
    assert!(shown(&n) > 0 && shown(&c) > 0);
    let [n, c] = ["n.json", "c.json"].map(|name| cameras(&folder, name).remove(0));
    assert!(apart(&n, &c) < 1e-12, "{n} {c}");
    let down = serde_json::json!({"eye": [0, 0, 20], "forward": [0, 0, -1], "up": [0, 1, 0]});
    assert!(["eye", "forward", "up"].iter().all(|key| apart(&n[key], &down[key]) < 1e-12), "{n}");
    let sized = [&base[..], &["--path", "model", "-o", "s%d.exr", "--size", "20x10"]].concat();
    done(&folder, &sized);
    assert_eq!(exr(&inside(&folder, "s0.exr")).0["A"].len(), 200);
}

#[test]
fn frames_that_show_nothing_are_told() {
    if !has_device() {
        return;
    }
    let folder = garden();
    let away = r#"{"version": 1, "keys": [{"eye": [12, 0, 6], "target": [0, 0, 1]}, {"eye": [12, 0, 6], "target": [24, 0, 11]}]}"#;
    fs::write(inside(&folder, "path.json"), away).unwrap();
    let text = said(&folder, &small(&["--path", "path.json", "-o", "f_%d.png"]));
    assert!(text.contains("1 of 2 frames show nothing of the scene, the first is frame 1"), "{text}");
}

#[test]
fn wrong_command_lines_and_paths_are_refused() {
    let folder = garden();
    let refused = |args: &[&str], status: i32, parts: &[&str]| {
        assert_refused(&folder, &[&["render", "garden/scene.toml"], args].concat(), status, parts);
    };
    refused(&["--turntable"], 2, &["--turntable needs the number", "--frames 36"]);
    refused(&["--turntable", "--frames"], 2, &["--frames needs the number of frames beside --turntable"]);
    refused(&["--path", "path.json", "--frames"], 2, &["beside --path"]);
    refused(&["--frames", "36"], 2, &["--frames 36 needs --path or --turntable"]);
    refused(&["--overwrite"], 2, &["--overwrite needs"]);
    refused(&["--turntable", "--frames", "2", "--max-error", "0.1"], 2, &["--max-error", "--turntable"]);
    for (name, says) in [("f.png", "every picture"), ("%d_%d.png", "more than one"), ("%4d.png", "spaces")] {
        refused(&["--turntable", "--frames", "2", "-o", name], 2, &[says, "frame_%04d.png"]);
    }
    refused(&["--turntable", "--frames", "2", "-o", "%d.gif"], 2, &[".png"]);
    refused(&["--turntable", "--frames", "2", "-o", "none/%d.png"], 1, &["no folder none"]);
    refused(&["--path", "none.json"], 1, &["none.json"]);
    fs::write(inside(&folder, "bad.json"), "{\"version\": 1,\n\"keys\": [{\"eyes\": 1}]}").unwrap();
    refused(&["--path", "bad.json"], 2, &["bad.json:2:", "unknown field `eyes`"]);
    let up = "{\"version\": 1, \"keys\": [{\"eye\": [0, 0, 9], \"target\": [0, 0, 0]}]}";
    fs::write(inside(&folder, "up.json"), up).unwrap();
    refused(&["--path", "up.json"], 2, &["up.json: keys[0].up: ", "parallel to the view"]);
    for args in
        [["--turntable", "--path", "path.json"], ["--turntable", "--frames", "0"], ["--turntable", "--frames", "x"]]
    {
        let (status, _, stderr) = run(&folder, &[&["render", "garden/scene.toml"], &args[..]].concat());
        assert_ne!(status, 0, "{args:?}: {stderr}");
    }
    let (status, _, stderr) = run(&folder, &["render", "--turntable", "--frames", "1.5"]);
    assert!(status == 2 && stderr.contains("1.5"), "{stderr}");
}

#[test]
fn a_time_series_needs_its_inputs_before_frames() {
    if !has_device() {
        return;
    }
    let folder = garden();
    let rest = ["--method", "points", "--size", "16x12", "-o", "s_%d.png"];
    let (status, _, stderr) = run(&folder, &[&["render", "--frames", "garden/scene.toml"], &rest[..]].concat());
    assert!(status == 2 && stderr.contains("behind the inputs"), "{stderr}");
    assert!(pictures(&folder).is_empty());
    done(&folder, &[&["render", "garden/scene.toml", "--frames"], &rest[..]].concat());
    let steps = pictures(&folder);
    assert!(steps.len() > 1 && steps.contains_key("s_1.png") && !steps.contains_key("s_0.png"));
}
