//! The binary: exit status, standard output, standard error, and the files that it writes.

mod bad;
mod brightness;
mod camera;
mod check;
mod choice;
#[cfg(unix)]
mod ci;
mod compare;
mod data;
mod dealt;
mod deep;
mod detail;
mod failures;
#[cfg(unix)]
mod faults;
mod film_page;
mod films;
mod filters;
mod formats;
mod frames;
mod gaussians;
mod info;
mod inputs;
mod install;
#[cfg(unix)]
mod interrupted;
mod iso;
mod legend;
mod like;
mod looks;
mod measure;
mod old_scenes;
mod opacity;
mod prepare;
mod prepare_store;
mod presets;
mod readme;
mod render;
mod samples;
mod scene_store;
mod sequence;
mod shadows;
mod soft;
mod splats;
mod stress;
mod tradeoff;
mod units;

use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::{Mutex, PoisonError};
use std::thread;

use assert_cmd::Command;
use glam::{DVec3, Vec3};
use pellucid_cli::{Captured, Streams};
use pellucid_core::cloud::Cloud;
use pellucid_core::image::Image;
use pellucid_io::output::{Inputs, WriteOptions, write_image};
use pellucid_scene::{ColorSpace, procedural};
use pellucid_testing::{has_device, shader_cache};
use tempfile::TempDir;

/// The binary in `folder`, with validation and the tests' own shader cache.
fn pellucid(folder: &TempDir, args: &[&str]) -> Command {
    let mut command = Command::cargo_bin("pellucid").unwrap();
    command.current_dir(folder).env("PELLUCID_VALIDATION", "1").env("PELLUCID_CACHE_DIR", shader_cache()).args(args);
    command
}

/// Runs the binary in `folder`; exit status, standard output and standard error.
fn run(folder: &TempDir, args: &[&str]) -> (i32, String, String) {
    let output = pellucid(folder, args).output().unwrap();
    let text = |bytes| String::from_utf8(bytes).unwrap();
    (output.status.code().expect("no signal ends it"), text(output.stdout), without_progress(&text(output.stderr)))
}

/// Standard error without the lines about progress, which come where the machine is slow.
fn without_progress(stderr: &str) -> String {
    stderr.split_inclusive('\n').filter(|line| !line.starts_with("progress: ")).collect()
}

/// Stack of a process's main thread.
const STACK_BYTES: usize = 8 << 20;

/// Runs a command line in `folder` inside this process; exit status, standard output and standard error. Takes
/// milliseconds where a process takes tens of them, and longer in debug builds.
///
/// The current folder is the process's, so that one thread at a time runs a command, and no test may use a relative
/// path.
fn run_inside(folder: &TempDir, args: &[&str]) -> (i32, String, String) {
    static CAPTURED: Mutex<Captured> = Mutex::new(Captured { stdout: String::new(), stderr: String::new() });
    static CURRENT_FOLDER: Mutex<()> = Mutex::new(());
    let _alone = CURRENT_FOLDER.lock().unwrap_or_else(PoisonError::into_inner);
    let here = std::env::current_dir().unwrap();
    std::env::set_current_dir(folder).unwrap();
    let line: Vec<OsString> = ["pellucid"].iter().chain(args).map(OsString::from).collect();
    let command = thread::Builder::new().stack_size(STACK_BYTES);
    let command = command.spawn(move || pellucid_cli::run_from(line, Streams::Captured(&CAPTURED))).unwrap();
    let status = command.join();
    std::env::set_current_dir(here).unwrap();
    let Captured { stdout, stderr } = std::mem::take(&mut *CAPTURED.lock().unwrap_or_else(PoisonError::into_inner));
    let status = status.unwrap_or_else(|_| panic!("{args:?} panics: {stderr}"));
    let code = (0..=u8::MAX).find(|code| ExitCode::from(*code) == status).unwrap();
    (i32::from(code), stdout, stderr)
}

/// The device that tests are to run on; the best one if the variable is not set.
fn device() -> Option<String> {
    std::env::var("PELLUCID_TEST_DEVICE").ok()
}

/// Runs a command on the test device and asserts that it succeeds without a word on standard error; standard output.
#[track_caller]
fn done(folder: &TempDir, args: &[&str]) -> String {
    let device = device().map_or_else(Vec::new, |device| vec!["--device".to_owned(), device]);
    let output = pellucid(folder, args).args(device).output().unwrap();
    let text = |bytes| String::from_utf8(bytes).unwrap();
    let (stdout, stderr) = (text(output.stdout), without_progress(&text(output.stderr)));
    assert_eq!((output.status.code(), stderr.as_str()), (Some(0), ""), "{args:?}");
    stdout
}

/// Writes a built-in scene; its scene file.
fn builtin(folder: &TempDir, name: &str, parameters: &[&str]) -> String {
    let sets = parameters.iter().flat_map(|pair| ["--set", pair]);
    let args = ["scene", name, "-o", name].into_iter().chain(sets).collect::<Vec<_>>();
    assert_eq!(run(folder, &args), (0, String::new(), String::new()));
    format!("{name}/scene.toml")
}

/// A file of a folder.
fn inside(folder: &TempDir, name: &str) -> PathBuf {
    folder.path().join(name)
}

/// Asserts that a command fails as a failure should: the status, one `error: ` line that names `parts`, nothing on
/// standard output, no new file. Runs it in this process, so that it must be refused before it opens a device.
#[track_caller]
fn assert_refused(folder: &TempDir, args: &[&str], status: i32, parts: &[&str]) {
    assert_refused_by(run_inside, folder, args, status, parts);
}

/// Asserts the same of a command that opens a device before it fails, in a process of its own.
#[track_caller]
fn assert_refused_with_device(folder: &TempDir, args: &[&str], status: i32, parts: &[&str]) {
    assert_refused_by(run, folder, args, status, parts);
}

#[track_caller]
fn assert_refused_by(
    run: fn(&TempDir, &[&str]) -> (i32, String, String),
    folder: &TempDir,
    args: &[&str],
    status: i32,
    parts: &[&str],
) {
    let files = || fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name()).collect::<Vec<_>>();
    let before = files();
    let (code, stdout, stderr) = run(folder, args);
    assert_eq!(code, status, "{args:?}: {stderr}");
    assert!(stderr.starts_with("error: "), "{args:?}: {stderr}");
    for part in parts {
        assert!(stderr.contains(part), "{args:?}: {part:?} in {stderr}");
    }
    assert_eq!(stdout, "", "{args:?}");
    assert_eq!(files(), before, "{args:?}: no file comes or goes");
}

fn folder() -> TempDir {
    tempfile::tempdir().unwrap()
}

fn write_cloud(path: &Path) {
    let cloud = Cloud {
        positions: vec![DVec3::ZERO, DVec3::new(1.0, 2.0, 3.0)],
        colors: Some(vec![Vec3::ONE, Vec3::X]),
        classification: Some(vec![2, 2]),
        ..Cloud::default()
    };
    pellucid_io::ply::write(path, &cloud).unwrap();
}

fn write_picture(path: &Path, width: u32, red: f32) {
    let pixels = width as usize * 2;
    let mut image = Image {
        width,
        height: 2,
        rgba: vec![[0.0, 0.0, 0.0, 1.0]; pixels],
        depth: vec![1.0; pixels],
        ..Image::default()
    };
    image.rgba[1][0] = red;
    let options = WriteOptions {
        background: Vec3::ZERO,
        color: ColorSpace::Linear,
        transparent: false,
        metadata: Vec::new(),
        camera: None,
        inputs: Inputs::default(),
    };
    write_image(path, &image, &options).unwrap();
}

/// The commands that take a scene.
const COMMANDS: [&str; 3] = ["render", "profile", "plan"];

#[test]
fn missing_and_empty_inputs_exit_with_1() {
    let folder = folder();
    fs::write(folder.path().join("empty.ply"), "").unwrap();
    fs::write(folder.path().join("empty.toml"), "").unwrap();
    fs::write(folder.path().join("lost.toml"), "[[cloud]]\npath = \"nowhere.las\"\n").unwrap();
    fs::create_dir(folder.path().join("dir")).unwrap();
    fs::create_dir(folder.path().join("dir.toml")).unwrap();
    for command in COMMANDS {
        for input in ["no.toml", "no.ply", "empty.ply", "empty.toml", "dir", "dir.toml"] {
            assert_refused(&folder, &[command, input], 1, &[input]);
        }
        assert_refused(&folder, &[command, "lost.toml"], 1, &["nowhere.las"]);
    }
    for input in ["no.ply", "empty.ply", "dir"] {
        assert_refused(&folder, &["info", input, "--json"], 1, &[input]);
    }
}

#[test]
fn wrong_scene_files_exit_with_2_and_name_line_and_column() {
    let folder = folder();
    let cases = [
        ("[image\n", "s.toml:1:"),
        (
            "[[cloud]]\npath = \"a.ply\"\nopactiy = 1\n",
            "s.toml:3:1: unknown key `cloud.0.opactiy`; did you mean `opacity`?",
        ),
        ("[[cloud]]\npath = \"a.ply\"\nopacity = 2\n", "s.toml:3:11: `cloud.0.opacity` must be a number"),
        ("[method]\nname = \"abufer\"\n", "did you mean `abuffer`?"),
        ("[camera]\neye = [0, 0, 0]\ntarget = [0, 0, 0]\n", "s.toml:3:10: "),
        ("[image]\nsize = [8, 8]\n", "no cloud: add"),
    ];
    for (text, expected) in cases {
        fs::write(folder.path().join("s.toml"), text).unwrap();
        for command in COMMANDS {
            assert_refused(&folder, &[command, "s.toml"], 2, &[expected]);
        }
    }
    fs::write(folder.path().join("s.toml"), b"# \xff\n").unwrap();
    assert_refused(&folder, &["render", "s.toml"], 2, &["s.toml:1:3: not UTF-8"]);
}

#[test]
fn wrong_options_exit_with_2() {
    let folder = folder();
    write_cloud(&folder.path().join("a.ply"));
    fs::write(folder.path().join("s.toml"), "[[cloud]]\npath = \"a.ply\"\n").unwrap();
    let cases: [(&[&str], &str); 15] = [
        (&["a.ply", "-o", "a.jpg"], ".png"),
        (&["a.ply", "-o", "a"], ".exr"),
        (&["a.ply", "s.toml"], "a scene file (.toml) can't be combined with other inputs"),
        (&["a.ply", "--size", "64"], "--size 64: expected WxH"),
        (&["a.ply", "--size", "0x64"], "--size 0x64: `image.size`"),
        (&["a.ply", "--opacity", "-1"], "--opacity -1: `cloud.0.opacity`"),
        (&["a.ply", "--radius", "nan"], "--radius nan: `cloud.0.radius`"),
        (&["a.ply", "--background", "1,2,3"], "--background 1,2,3: `image.background`"),
        (&["a.ply", "--background", "whit"], "or a color such as \"white\" or \"#80c0ff\", found \"whit\""),
        (&["a.ply", "--method", "nonsense"], "--method nonsense: unknown method"),
        (&["a.ply", "--set", "method.nme=abuffer"], "did you mean `name`?"),
        (&["a.ply", "--set", "cloud.1.opacity=1"], "needs a number below 1"),
        (&["a.ply", "--view", "behind"], "invalid value"),
        (&["a.ply", "--elevation", "91"], "expected degrees from -90 to 90"),
        (&["a.ply", "--memory-budget", "much"], "--memory-budget"),
    ];
    for (args, expected) in cases {
        assert_refused(&folder, &[&["render"], args].concat(), 2, &[expected]);
    }
    assert_refused(&folder, &["profile", "a.ply", "--frames", "0"], 2, &["--frames"]);
    assert_refused(&folder, &["nonsense"], 2, &["nonsense"]);
}

/// The other refusals are looked at inside this process alone.
#[test]
fn a_process_refuses_with_the_same_words() {
    let folder = folder();
    write_cloud(&folder.path().join("a.ply"));
    fs::write(folder.path().join("empty.ply"), "").unwrap();
    fs::write(folder.path().join("s.toml"), "[[cloud]]\npath = \"a.ply\"\nopactiy = 1\n").unwrap();
    let cases: [(&[&str], i32); 8] = [
        (&["render", "empty.ply", "-o", "a.png"], 1),
        (&["render", "a.ply", "-o", "no/a.png"], 1),
        (&["plan", "s.toml"], 2),
        (&["render", "a.ply", "--size", "64"], 2),
        (&["render", "a.ply", "--view", "behind"], 2),
        (&["nonsense"], 2),
        (&["scene", "--list"], 0),
        (&["render", "--help"], 0),
    ];
    for (args, status) in cases {
        let of_process = run(&folder, args);
        assert_eq!(of_process.0, status, "{args:?}");
        assert_eq!(run_inside(&folder, args), of_process, "{args:?}");
    }
}

#[test]
fn targets_that_can_not_be_written_exit_with_1_before_any_work() {
    let folder = folder();
    fs::create_dir(folder.path().join("d.png")).unwrap();
    // The input is missing too: the target is looked at first.
    assert_refused(&folder, &["render", "no.ply", "-o", "no/a.png"], 1, &["no/a.png", "no folder"]);
    assert_refused(&folder, &["render", "no.ply", "-o", "d.png"], 1, &["d.png"]);
    assert_refused(&folder, &["render", "no.ply", "--profile", "no/p.json"], 1, &["no/p.json"]);
}

#[test]
fn info_prints_text_or_one_json_document() {
    let folder = folder();
    write_cloud(&folder.path().join("a.ply"));
    let (code, text, stderr) = run(&folder, &["info", "a.ply"]);
    assert_eq!((code, stderr.as_str()), (0, ""));
    assert!(text.starts_with("a.ply\n  points      2\n"), "{text}");

    let (_, json, _) = run(&folder, &["info", "--json", "a.ply"]);
    let value: serde_json::Value = serde_json::from_str(&json).unwrap();
    let keys: Vec<_> = value.as_object().unwrap().keys().map(String::as_str).collect();
    let described = ["points", "non_finite", "withheld", "bounds", "crs", "attributes", "classes"];
    assert_eq!(keys, [&described[..], &["ranges", "spacing", "layers", "histograms", "command"]].concat());
    assert_eq!((&value["points"], &value["non_finite"]), (&2.into(), &0.into()));
    assert_eq!(value["bounds"]["max"], serde_json::json!([1.0, 2.0, 3.0]));
    assert_eq!(value["classes"], serde_json::json!({ "2": 2 }));

    let (_, json, _) = run(&folder, &["info", "--json", "a.ply", "a.ply"]);
    let value: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!((value[1]["file"].as_str(), value.as_array().unwrap().len()), (Some("a.ply"), 2));
}

#[test]
fn scenes_are_listed_one_a_line_and_written_whole() {
    let folder = folder();
    let (code, list, _) = run(&folder, &["scene", "--list"]);
    assert_eq!(code, 0);
    let names: Vec<_> = list.lines().map(|line| line.split_whitespace().next().unwrap()).collect();
    let mut known: Vec<_> = procedural::BUILTINS.iter().map(|builtin| builtin.name).collect();
    // Made of a file, so that it is not built in.
    known.push("iso");
    assert_eq!(names, known);

    let args = ["scene", "garden", "-o", "new/garden", "--set", "points=5000", "--seed", "3"];
    assert_eq!(run(&folder, &args), (0, String::new(), String::new()));
    let written = folder.path().join("new/garden");
    let scene = pellucid_scene::Scene::read(&written.join("scene.toml"), &Default::default()).unwrap();
    assert_eq!(scene.warnings, [""; 0]);
    assert!(scene.clouds.iter().all(|cloud| cloud.path.starts_with(&written) && cloud.path.is_file()));
    // The clouds, scene.toml, nothing temporary.
    assert_eq!(fs::read_dir(&written).unwrap().count(), scene.clouds.len() + 1);
}

#[test]
fn wrong_scenes_and_parameters_exit_with_2() {
    let folder = folder();
    assert_refused(&folder, &["scene", "gardn", "-o", "d"], 2, &["gardn"]);
    assert_refused(&folder, &["scene", "garden", "-o", "d", "--set", "points=many"], 2, &["expected KEY=NUMBER"]);
    assert_refused(&folder, &["scene", "garden", "-o", "d", "--set", "pints=3"], 2, &["pints"]);
    assert_refused(&folder, &["scene", "garden"], 2, &["--output"]);
}

#[cfg(unix)]
#[test]
fn a_reader_that_stops_early_is_no_failure() {
    use std::process::{Command, Stdio};
    let mut child = Command::new(assert_cmd::cargo::cargo_bin("pellucid"))
        .args(["scene", "--list"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success(), "{output:?}");
    assert!(output.stderr.is_empty(), "{output:?}");
}
