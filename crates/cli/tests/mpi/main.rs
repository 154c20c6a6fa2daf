//! `pellucid-mpi`: the bytes of `pellucid` from any number of ranks, and errors of one as errors of all.

mod spread;

use std::ffi::OsString;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};
use std::{env, fs, thread};

use pellucid_engine::scene::METHODS;
use tempfile::TempDir;

/// One thread for each rank: they compete for the cores.
const ENVIRONMENT: [(&str, &str); 5] = [
    ("OMPI_ALLOW_RUN_AS_ROOT", "1"),
    ("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1"),
    ("OMPI_MCA_rmaps_base_oversubscribe", "1"),
    ("LP_NUM_THREADS", "1"),
    ("PELLUCID_VALIDATION", "1"),
];

fn with_environment(command: &mut Command, folder: &TempDir) {
    let cache = Path::new(env!("CARGO_TARGET_TMPDIR")).join("cli-cache");
    command.current_dir(folder).envs(ENVIRONMENT).env("PELLUCID_CACHE_DIR", cache).stdin(Stdio::null());
}

/// What starts ranks. `PELLUCID_MPIRUN` names another one, as that of MPICH.
fn mpirun() -> OsString {
    env::var_os("PELLUCID_MPIRUN").unwrap_or_else(|| "mpirun".into())
}

/// The program on so many ranks.
fn ranks(folder: &TempDir, count: usize, args: &[&str]) -> Command {
    let mut command = Command::new(mpirun());
    with_environment(&mut command, folder);
    command.args(["-n", &count.to_string(), env!("CARGO_BIN_EXE_pellucid-mpi")]).args(args);
    command
}

/// The same by the program of one machine.
fn alone(folder: &TempDir, args: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_pellucid"));
    with_environment(&mut command, folder);
    command.args(args).output().expect("pellucid runs")
}

fn folder() -> TempDir {
    tempfile::tempdir().expect("a folder")
}

fn read(folder: &TempDir, name: &str) -> Vec<u8> {
    fs::read(folder.path().join(name)).unwrap_or_default()
}

/// A small cloud with radii and normals, as PLY.
fn cloud(folder: &TempDir) -> &'static str {
    let mut text = String::from(
        "ply\nformat ascii 1.0\nelement vertex 2000\nproperty float x\nproperty float y\nproperty float z\nproperty uchar red\n\
         property uchar green\nproperty uchar blue\nend_header\n",
    );
    let mut state = 7u32;
    let mut next = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(state >> 8) / f64::from(1 << 24)
    };
    for _ in 0..2000 {
        let [x, y, z] = [next(), next(), next()];
        let color = [next(), next(), next()].map(|c| (255.0 * c) as u8);
        text.push_str(&format!("{x:.5} {y:.5} {z:.5} {} {} {}\n", color[0], color[1], color[2]));
    }
    fs::write(folder.path().join("cloud.ply"), text).expect("a file");
    "cloud.ply"
}

fn assert_done(output: &Output, what: &str) {
    assert!(output.status.success(), "{what}: {}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn every_method_has_the_same_bytes_from_any_number_of_ranks() {
    let folder = folder();
    let cloud = cloud(&folder);
    let mut differ = Vec::new();
    for method in METHODS {
        let asked = |name: &str| {
            ["render", cloud, "--method", method, "--opacity", "0.4", "--size", "96x80", "--aov", "-q", "-o", name]
                .map(str::to_owned)
        };
        let one = asked("one.exr");
        assert_done(&alone(&folder, &one.each_ref().map(String::as_str)), method);
        for count in 1..=4 {
            let name = format!("{count}.exr");
            let args = asked(&name);
            let output = ranks(&folder, count, &args.each_ref().map(String::as_str)).output().expect("mpirun runs");
            assert_done(&output, method);
            if read(&folder, &name) != read(&folder, "one.exr") {
                differ.push(format!("{method} by {count}"));
            }
        }
    }
    assert!(differ.is_empty(), "{differ:?}");
}

#[test]
fn pictures_with_all_that_a_band_does_not_know() {
    let folder = folder();
    let cloud = cloud(&folder);
    for (name, more) in [
        ("edl", &["--method", "points", "--set", "shading.edl=true"][..]),
        ("legend", &["--color-by", "height", "--legend", "--ortho"][..]),
        ("see-through", &["--see-through", "0.5"][..]),
        ("shadows", &["--set", "shadows.samples=4", "--opacity", "1", "--set", "shading.model=\"lambert\""][..]),
    ] {
        let file = |kind: &str| format!("{name}-{kind}.png");
        let args = |output: &str| {
            let given = ["render", cloud, "--size", "120x90", "-q", "-o", output];
            given.into_iter().chain(more.iter().copied()).map(str::to_owned).collect::<Vec<_>>()
        };
        let (one, three) = (file("one"), file("three"));
        assert_done(&alone(&folder, &args(&one).iter().map(String::as_str).collect::<Vec<_>>()), name);
        let given = args(&three);
        let output = ranks(&folder, 3, &given.iter().map(String::as_str).collect::<Vec<_>>()).output().expect("mpirun");
        assert_done(&output, name);
        assert_eq!(read(&folder, &one), read(&folder, &three), "{name}");
    }
}

#[test]
fn frames_of_a_turntable_are_those_of_one_and_are_not_rendered_twice() {
    let folder = folder();
    let cloud = cloud(&folder);
    let args = |name: &'static str| ["render", cloud, "--turntable", "--frames=7", "--size", "64x48", "-q", "-o", name];
    assert_done(&alone(&folder, &args("a_%02d.png")), "alone");
    let first = ranks(&folder, 3, &args("b_%02d.png")).output().expect("mpirun");
    assert_done(&first, "ranks");
    for number in 0..7 {
        let [a, b] = ["a", "b"].map(|name| read(&folder, &format!("{name}_{number:02}.png")));
        assert!(!a.is_empty() && a == b, "frame {number}");
    }
    let there = fs::metadata(folder.path().join("b_03.png")).and_then(|file| file.modified()).expect("a file");
    fs::remove_file(folder.path().join("b_05.png")).expect("a file");
    assert_done(&ranks(&folder, 2, &args("b_%02d.png")).output().expect("mpirun"), "again");
    assert_eq!(read(&folder, "b_05.png"), read(&folder, "a_05.png"));
    assert_eq!(fs::metadata(folder.path().join("b_03.png")).and_then(|file| file.modified()).expect("a file"), there);
}

#[test]
fn an_error_of_ranks_is_said_once() {
    let folder = folder();
    for (args, wanted) in [
        (&["render", "nothing.las", "-o", "x.png"][..], "nothing.las: no such file"),
        (&["render", "--max-error", "0.01", "-o", "x.png"][..], "--max-error"),
        (&["render", "-o", "x.unknown"][..], "x.unknown"),
    ] {
        let output = ranks(&folder, 3, args).output().expect("mpirun");
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(!output.status.success());
        let errors: Vec<&str> = said.lines().filter(|line| line.starts_with("error:")).collect();
        assert_eq!(errors.len(), 1, "{said}");
        assert!(errors[0].contains(wanted) && errors[0].contains("of 3 ("), "{said}");
        assert!(fs::read_dir(folder.path()).expect("a folder").next().is_none(), "something was written");
    }
}

#[test]
#[cfg(target_os = "linux")]
fn a_rank_that_is_killed_ends_all_and_leaves_no_file() {
    let folder = folder();
    for (number, after) in [0u64, 300, 700, 1500, 3000].into_iter().enumerate() {
        let args = ["render", "--size", "1920x1080", "--method", "abuffer", "-q", "-o", "killed.png"];
        let mut running = ranks(&folder, 3, &args).stderr(Stdio::piped()).spawn().expect("mpirun");
        thread::sleep(Duration::from_millis(after));
        let victims = children(running.id());
        let Some(victim) = victims.get(number % 3) else {
            // Not there yet, or done already.
            running.kill().ok();
            running.wait().ok();
            continue;
        };
        let _ = Command::new("kill").args(["-9", &victim.to_string()]).status();
        let begin = Instant::now();
        let status = running.wait().expect("mpirun ends");
        assert!(begin.elapsed() < Duration::from_secs(10), "{:?}", begin.elapsed());
        assert!(!status.success());
        let left: Vec<_> =
            fs::read_dir(folder.path()).expect("a folder").flatten().map(|file| file.file_name()).collect();
        assert!(left.iter().all(|name| name != "killed.png"), "{left:?}");
    }
}

/// The processes that another one started.
#[cfg(target_os = "linux")]
fn children(of: u32) -> Vec<u32> {
    let path = format!("/proc/{of}/task/{of}/children");
    let text = fs::read_to_string(path).unwrap_or_default();
    text.split_whitespace().filter_map(|id| id.parse().ok()).collect()
}
