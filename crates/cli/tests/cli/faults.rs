//! The state after failures: a full disk, outputs that can't be written, unusable caches, SIGKILL and signals in the
//! middle of the work, too little device memory, a lost device. Driven through the binary; in debug builds
//! `PELLUCID_FAULT` (src/fault.rs) places a fault.
//!
//! `cargo test --locked --test cli faults:: -- --ignored` sweeps over many more places than the short tests do.

mod budget;
mod cache;
pub mod checker;
mod device;
mod disk;
mod killed;
mod resumed;
mod signals;
mod targets;

use std::collections::BTreeMap;
use std::fs;
use std::os::unix::process::ExitStatusExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;

use pellucid_testing::has_device;
use pellucid_testing::signals::heeding;
use tempfile::TempDir;

/// A command that writes.
#[derive(Debug, Clone, Copy)]
struct Case {
    args: &'static [&'static str],
    /// The files that it writes, in the folder `out`.
    files: &'static [&'static str],
    needs_device: bool,
    /// True if the files appear together rather than one by one.
    together: bool,
    /// True if the same command gives the same bytes.
    repeats: bool,
    /// True if files grow while frames are rendered: whoever is killed then leaves a temporary one.
    streams: bool,
}

impl Case {
    const fn new(args: &'static [&'static str], files: &'static [&'static str]) -> Self {
        Self { args, files, needs_device: true, together: true, repeats: true, streams: false }
    }
}

// Pictures that are as good as others, by the method that compiles least: it takes a third of the default one's time.
const RENDER_PNG: Case = Case::new(
    &["render", "in/scene.toml", "-q", "--size", "40x30", "--method", "points", "-o", "out/a.png"],
    &["a.png"],
);
const RENDER_EXR: Case = Case::new(
    &["render", "in/scene.toml", "-q", "--size", "40x30", "--method", "points", "-o", "out/a.exr"],
    &["a.exr"],
);
const RENDER_DEEP: Case = Case {
    streams: true,
    ..Case::new(
        &["render", "in/scene.toml", "-q", "--size", "40x30", "--method", "abuffer", "--deep", "-o", "out/a.exr"],
        &["a.exr"],
    )
};
const MEASURED: Case = Case {
    together: false,
    repeats: false,
    ..Case::new(
        &[
            "render",
            "in/scene.toml",
            "-q",
            "--size",
            "16x12",
            "--method",
            "points",
            "-o",
            "out/a.png",
            "--profile",
            "out/p.json",
            "--trace",
            "out/t.json",
        ],
        &["a.png", "p.json", "t.json"],
    )
};
const PROFILE: Case = Case {
    together: false,
    repeats: false,
    ..Case::new(
        &[
            "profile",
            "in/scene.toml",
            "-q",
            "--size",
            "16x12",
            "--method",
            "points",
            "--frames",
            "1",
            "--profile",
            "out/p.json",
            "--json",
        ],
        &["p.json"],
    )
};
const STEPS: Case = Case {
    together: false,
    ..Case::new(
        &["render", "in/steps.toml", "-q", "--frames", "--size", "16x12", "--method", "points", "-o", "out/s%d.png"],
        &["s1.png", "s2.png"],
    )
};
const SCENE: Case = Case {
    needs_device: false,
    ..Case::new(
        &["scene", "tori", "-o", "out", "--set", "points=400"],
        &["inner.ply", "middle.ply", "outer.ply", "scene.toml"],
    )
};
const PREPARE: Case =
    Case { needs_device: false, ..Case::new(&["prepare", "in/cloud.ply", "-o", "out/p.ply", "-q"], &["p.ply"]) };
const COMPARE: Case =
    Case { needs_device: false, ..Case::new(&["compare", "in/a.png", "in/b.png", "-o", "out/d.png"], &["d.png"]) };

const CASES: [Case; 9] = [SCENE, PREPARE, COMPARE, RENDER_PNG, RENDER_EXR, RENDER_DEEP, MEASURED, PROFILE, STEPS];

/// A folder with inputs in `in`, and an empty one called `out`.
fn place() -> TempDir {
    static INPUTS: OnceLock<TempDir> = OnceLock::new();
    let made = INPUTS.get_or_init(|| {
        let folder = tempfile::tempdir().unwrap();
        let run = |args: &[&str]| {
            let output = command(folder.path(), args).output().unwrap();
            assert!(output.status.success(), "{args:?}: {}", text(&output.stderr));
        };
        run(&["scene", "tori", "-o", "in", "--set", "points=300"]);
        let inside = |name: &str| folder.path().join("in").join(name);
        let cloud = fs::read_dir(inside("")).unwrap().map(|entry| entry.unwrap().path());
        let cloud = cloud.filter(|path| path.extension().is_some_and(|e| e == "ply")).min().unwrap();
        fs::copy(cloud, inside("cloud.ply")).unwrap();
        let steps = "[[cloud]]\npath = \"cloud.ply\"\nradius = 0.05\n[[cloud]]\npath = \"cloud.ply\"\nradius = 0.1\n";
        fs::write(inside("steps.toml"), steps).unwrap();
        for (name, factor) in [("a.png", 37), ("b.png", 91)] {
            // Such that a PNG of the difference has some size.
            let pixel = |i: usize| [factor, 59, 83].map(|factor| (i * i * factor % 251) as f32 / 251.0);
            let pixels: Vec<_> = (0..40 * 30).map(pixel).collect();
            pellucid_io::output::write_rgb_png(&inside(name), [40, 30], &pixels).unwrap();
        }
        folder
    });
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("in")).unwrap();
    for entry in fs::read_dir(made.path().join("in")).unwrap() {
        let entry = entry.unwrap();
        fs::copy(entry.path(), folder.path().join("in").join(entry.file_name())).unwrap();
    }
    fs::create_dir(folder.path().join("out")).unwrap();
    folder
}

/// The binary in `folder`, with a shader cache that only these tests use.
fn command(folder: &Path, args: &[&str]) -> Command {
    let mut command = heeding(assert_cmd::cargo::cargo_bin("pellucid"));
    let cache = Path::new(env!("CARGO_TARGET_TMPDIR")).join("faults-cache");
    command.current_dir(folder).env("PELLUCID_CACHE_DIR", cache).args(args).args(device_args(args));
    command
}

/// Returns the option for the device that tests are to run on, for commands that take one.
fn device_args(args: &[&str]) -> Vec<String> {
    let takes = ["render", "profile", "tradeoff", "stress", "check"].iter().any(|name| args.first() == Some(name));
    let device = std::env::var("PELLUCID_TEST_DEVICE").ok().filter(|_| takes);
    device.map_or_else(Vec::new, |device| vec!["--device".to_owned(), device])
}

/// Has a command meet a fault. The host writes into a CPU driver's memory by itself, so faults of submissions come
/// where a GPU has them, too: while points are uploaded.
fn meeting(mut command: Command, fault: &str) -> Command {
    if fault.contains("@submit") || fault.contains("@wait") {
        command.env("PELLUCID_PREFER", "gpu");
    }
    command.env("PELLUCID_FAULT", fault);
    command
}

/// Runs with a fault.
fn with_fault(folder: &Path, args: &[&str], fault: &str) -> Output {
    meeting(command(folder, args), fault).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

/// The cases that can be run here.
fn cases() -> impl Iterator<Item = Case> {
    CASES.into_iter().filter(|case| !case.needs_device || has_device())
}

/// All files of a folder and of those in it, by their paths.
type Files = BTreeMap<PathBuf, Vec<u8>>;

fn files(folder: &Path) -> Files {
    let mut found = Files::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(next) = folders.pop() {
        for entry in fs::read_dir(next).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else {
                found.insert(path.strip_prefix(folder).unwrap().to_owned(), fs::read(&path).unwrap());
            }
        }
    }
    found
}

/// Puts something old where a case writes.
fn put_old(folder: &Path, case: Case) {
    case.files.iter().for_each(|name| fs::write(folder.join("out").join(name), "old").unwrap());
}

/// Asserts that a command failed as it should: status 1, nothing on standard output, and one line that has all `parts`.
#[track_caller]
fn assert_failed(output: &Output, what: &str, parts: &[&str]) {
    let (stdout, stderr) = (text(&output.stdout), text(&output.stderr));
    assert_eq!(output.status.code(), Some(1), "{what}: {:?} {stderr}", output.status.signal());
    assert_eq!(stdout, "", "{what}");
    assert!(stderr.starts_with("error: ") && stderr.lines().count() == 1, "{what}: {stderr}");
    for part in parts {
        assert!(stderr.contains(part), "{what}: {part:?} in {stderr}");
    }
}

/// Runs a case without a fault; what it wrote.
#[track_caller]
fn done(folder: &Path, case: Case) -> Files {
    let output = command(folder, case.args).output().unwrap();
    assert_eq!((output.status.code(), text(&output.stderr).as_str()), (Some(0), ""), "{:?}", case.args);
    let written = files(&folder.join("out"));
    let named = |path: &Path| case.files.iter().any(|name| path == Path::new(name));
    let (ours, others): (Files, Files) = written.into_iter().partition(|(path, _)| named(path));
    assert_eq!(ours.len(), case.files.len(), "{:?}: {:?}", case.args, ours.keys());
    assert!(others.keys().all(|path| checker::is_temporary(path)), "{:?}: {:?}", case.args, others.keys());
    ours
}

/// Output of a case where there is nothing else, of one run for all tests.
fn written(case: Case) -> &'static Files {
    static WRITTEN: [OnceLock<Files>; CASES.len()] = [const { OnceLock::new() }; CASES.len()];
    let at = CASES.iter().position(|known| known.args == case.args).expect("one of the table");
    WRITTEN[at].get_or_init(|| done(place().path(), case))
}
