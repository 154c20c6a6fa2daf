//! `pellucid-mpi`: the bytes of `pellucid` from any number of ranks, and errors of one as errors of all.

mod spread;

use std::ffi::OsString;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::{Duration, Instant};
use std::{env, fs};

use pellucid_scene::METHODS;
use pellucid_testing::shader_cache;
use serde_json::Value;
use tempfile::TempDir;

/// Environment of the ranks, which compete for the cores of one machine: lavapipe draws without threads of its own, and
/// Open MPI looks for no network.
const ENVIRONMENT: [(&str, &str); 6] = [
    ("OMPI_ALLOW_RUN_AS_ROOT", "1"),
    ("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1"),
    ("OMPI_MCA_rmaps_base_oversubscribe", "1"),
    ("OMPI_MCA_btl", "self,vader"),
    ("LP_NUM_THREADS", "0"),
    ("PELLUCID_VALIDATION", "1"),
];

fn with_environment(command: &mut Command, folder: &TempDir) {
    command.current_dir(folder).envs(ENVIRONMENT).env("PELLUCID_CACHE_DIR", shader_cache()).stdin(Stdio::null());
    // Runs of Open MPI share a folder unless told otherwise, and one removes it while another one makes it.
    static RUNS: AtomicU32 = AtomicU32::new(0);
    let mut own = folder.path().file_name().expect("a folder has a name").to_owned();
    own.push(RUNS.fetch_add(1, Ordering::Relaxed).to_string());
    command.env("OMPI_MCA_orte_tmpdir_base", Path::new(env!("CARGO_TARGET_TMPDIR")).join(own));
}

/// `PELLUCID_MPIRUN` names another one, as that of MPICH.
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

/// Runs the program of one machine.
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

/// Numbers of ranks that render the method at a place in [`METHODS`]: three, and one of the others in turn.
fn counts(place: usize) -> [usize; 2] {
    [3, [1, 2, 4][place % 3]]
}

#[test]
fn every_method_has_the_same_bytes_from_any_number_of_ranks() {
    let folder = folder();
    let cloud = cloud(&folder);
    let mut differ = Vec::new();
    for (place, method) in METHODS.iter().enumerate() {
        let asked = |name: &str| {
            ["render", cloud, "--method", method, "--opacity", "0.4", "--size", "96x80", "--aov", "-q", "-o", name]
                .map(str::to_owned)
        };
        let one = asked("one.exr");
        assert_done(&alone(&folder, &one.each_ref().map(String::as_str)), method);
        for count in counts(place) {
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
fn windows_and_samples_of_random_methods_have_the_same_bytes() {
    let folder = folder();
    let cloud = cloud(&folder);
    for (method, share) in [("stochastic", "ensembles"), ("spbr", "windows"), ("spbr-simplified", "ensembles")] {
        let args = ["render", cloud, "--method", method, "--opacity", "0.4", "--size", "96x80", "--aov", "-q"];
        assert_done(&alone(&folder, &[&args[..], &["-o", "one.exr"]].concat()), method);
        for count in [2, 4] {
            let more = ["--share", share, "-o", "shared.exr"];
            let output = ranks(&folder, count, &[&args[..], &more].concat()).output().expect("mpirun runs");
            assert_done(&output, method);
            assert_eq!(read(&folder, "shared.exr"), read(&folder, "one.exr"), "{share} of {method} by {count}");
        }
    }
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
            let given = ["render", cloud, "--size", "400x300", "-q", "-o", output];
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
fn samples_of_a_pixels_area_have_the_bytes_of_one_process() {
    let folder = folder();
    let cloud = cloud(&folder);
    let cases: [(&str, &[&str], &str); 7] = [
        ("abuffer", &["--samples", "4"], "windows"),
        ("points", &["--samples", "4", "--set", "shading.edl=true"], "windows"),
        ("abuffer", &["--samples", "2", "--set", "image.color=encoded", "--background", "white"], "windows"),
        ("stochastic", &["--samples", "4"], "ensembles"),
        ("spbr", &["--samples", "2"], "ensembles"),
        ("spbr", &["--samples", "2"], "windows"),
        ("circles", &["--samples", "auto", "--set", "image.sampling_error=0.03"], "windows"),
    ];
    for (method, more, share) in cases {
        let args = ["render", cloud, "--method", method, "--opacity", "0.4", "--size", "96x80", "--aov", "-q"];
        let args = [&args[..], more].concat();
        assert_done(&alone(&folder, &[&args[..], &["-o", "one.exr"]].concat()), method);
        for count in [1, 3] {
            let more = ["--share", share, "-o", "shared.exr"];
            let more = if count == 1 { &more[2..] } else { &more };
            let output = ranks(&folder, count, &[&args[..], more].concat()).output().expect("mpirun runs");
            assert_done(&output, method);
            assert!(!read(&folder, "one.exr").is_empty());
            let same = read(&folder, "shared.exr") == read(&folder, "one.exr");
            assert!(same, "{share} of {method} by {count}: {args:?}");
        }
    }
}

#[test]
fn frames_with_samples_are_those_of_one_process_however_they_are_shared() {
    let folder = folder();
    let cloud = cloud(&folder);
    let args = ["render", cloud, "--turntable", "--frames=3", "--size", "64x48", "-q", "--method", "points"];
    let more = ["--set", "shading.edl=true", "--samples", "auto", "--set", "image.sampling_error=0.05"];
    let args = [&args[..], &more].concat();
    assert_done(&alone(&folder, &[&args[..], &["-o", "a_%02d.exr"]].concat()), "alone");
    for share in ["windows", "frames"] {
        let name = format!("{share}_%02d.exr");
        let more = ["--share", share, "-o", &name];
        assert_done(&ranks(&folder, 2, &[&args[..], &more].concat()).output().expect("mpirun"), "ranks");
        for number in 0..3 {
            let [a, b] = ["a", share].map(|name| read(&folder, &format!("{name}_{number:02}.exr")));
            assert!(!a.is_empty() && a == b, "{share}: frame {number}");
        }
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
fn frames_by_all_ranks_are_those_of_one() {
    let folder = folder();
    let cloud = cloud(&folder);
    let args = ["render", cloud, "--turntable", "--frames=3", "--size", "64x48", "-q"];
    assert_done(&alone(&folder, &[&args[..], &["-o", "a_%02d.exr"]].concat()), "alone");
    let more = ["--share", "windows", "-o", "b_%02d.exr"];
    assert_done(&ranks(&folder, 3, &[&args[..], &more].concat()).output().expect("mpirun"), "ranks");
    for number in 0..3 {
        let [a, b] = ["a", "b"].map(|name| read(&folder, &format!("{name}_{number:02}.exr")));
        assert!(!a.is_empty() && a == b, "frame {number}");
    }
}

#[test]
fn ways_that_share_nothing_are_refused() {
    let folder = folder();
    for (args, wanted) in [
        (&["render", "--method", "abuffer", "--share", "ensembles", "-o", "x.png"][..], "draws no ensembles"),
        (&["render", "--share", "frames", "-o", "x.png"], "there is one frame"),
        (&["profile", "--capture", "1"], "no --pipelines and no --capture"),
        (&["render", "--share", "tiles", "-o", "x.png"], "possible values"),
    ] {
        let output = ranks(&folder, 2, args).output().expect("mpirun");
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(!output.status.success() && said.contains(wanted), "{said}");
        assert!(fs::read_dir(folder.path()).expect("a folder").next().is_none(), "something was written");
    }
}

/// A JSON document that the first rank prints.
fn json(output: &Output) -> Value {
    assert_done(output, "JSON");
    serde_json::from_slice(&output.stdout).expect("JSON")
}

#[test]
fn a_profile_has_what_each_rank_did() {
    let folder = folder();
    let cloud = cloud(&folder);
    let args = [
        "profile",
        cloud,
        "--method",
        "abuffer",
        "--size",
        "128x96",
        "--frames=2",
        "--json",
        "--trace",
        "t.json",
        "-q",
    ];
    let profile = json(&ranks(&folder, 3, &args).output().expect("mpirun"));
    assert_eq!(profile["ranks"]["share"], "windows");
    let frames = profile["ranks"]["frames"].as_array().expect("frames");
    assert_eq!((frames.len(), &profile["frames"][0]["passes"][0]["name"]), (2, &"project/clear".into()));
    for frame in frames {
        let ranks = frame["ranks"].as_array().expect("ranks");
        assert_eq!(ranks.iter().map(|rank| rank["rank"].as_u64().unwrap()).collect::<Vec<_>>(), [0, 1, 2]);
        let bytes = |key: &str| ranks.iter().map(|rank| rank[key].as_u64().unwrap()).collect::<Vec<_>>();
        // Color and depth of a pixel are 20 bytes, and 4 are the length of its list.
        let pixels: u64 = ranks[1..].iter().flat_map(|rank| rank["windows"].as_array().unwrap()).map(area).sum();
        let (sent, received) = (bytes("sent"), bytes("received"));
        assert!(sent[1] + sent[2] >= 24 * pixels && received[0] >= 24 * pixels, "{frame}");
        assert!(sent[1] + sent[2] < 24 * pixels + 2000, "no more than pixels: {frame}");
        assert!(frame["imbalance"].as_f64().unwrap() >= 1.0 && frame["gather_ms"].as_f64().unwrap() >= 0.0);
        assert!(ranks.iter().all(|rank| rank["passes"].as_array().is_some_and(|passes| !passes.is_empty())), "{frame}");
        assert_eq!(pixels + ranks[0]["windows"].as_array().unwrap().iter().map(area).sum::<u64>(), 128 * 96);
    }
    let trace: Value = serde_json::from_slice(&read(&folder, "t.json")).expect("a trace");
    let rows = trace["traceEvents"].as_array().unwrap().iter().filter(|event| event["ph"] == "M");
    assert_eq!(rows.count(), 3, "a row for each rank");
}

/// Pixels of a region.
fn area(window: &Value) -> u64 {
    let [x0, y0, x1, y1] = [0, 1, 2, 3].map(|at| window[at].as_u64().unwrap());
    (x1 - x0) * (y1 - y0)
}

#[test]
fn a_plan_says_what_is_shared_and_why() {
    let folder = folder();
    let cloud = cloud(&folder);
    let plan = json(
        &ranks(&folder, 2, &["plan", cloud, "--size", "320x240", "--ranks", "4", "--json", "-q"]).output().unwrap(),
    );
    assert_eq!((&plan["share"], plan["windows"].as_array().map(Vec::len)), (&"windows".into(), Some(4)));
    let shares: f64 = plan["windows"].as_array().unwrap().iter().map(|window| window["share"].as_f64().unwrap()).sum();
    assert!((shares - 1.0).abs() < 1e-9 && plan["latency_s"].as_f64().unwrap() > 0.0);
    let dealt = ["plan", cloud, "--method", "spbr", "--ranks", "4", "-q"];
    let text = ranks(&folder, 1, &dealt).output().expect("mpirun");
    let text = String::from_utf8_lossy(&text.stdout).into_owned();
    assert!(text.contains("ensembles  on") && text.contains("tests the points of all ensembles"), "{text}");
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
        let errors = errors(&output);
        assert_eq!(errors.len(), 1, "{said}");
        assert!(errors[0].contains(wanted) && errors[0].contains("of 3 ("), "{said}");
        assert!(fs::read_dir(folder.path()).expect("a folder").next().is_none(), "something was written");
    }
}

#[test]
fn one_rank_without_a_device_is_named() {
    let folder = folder();
    let mut command = Command::new(mpirun());
    with_environment(&mut command, &folder);
    let program = env!("CARGO_BIN_EXE_pellucid-mpi");
    let of = |extra: &'static [&'static str]| {
        [&["-n", "1"][..], extra, &[program, "render", "--size", "64x64", "-o", "x.png"]].concat()
    };
    command.args(of(&[])).arg(":").args(of(&[
        "env",
        "VK_DRIVER_FILES=/nowhere.json",
        "VK_ICD_FILENAMES=/nowhere.json",
    ]));
    let output = command.output().expect("mpirun");
    let errors = errors(&output);
    assert_eq!(errors.len(), 1, "{errors:?}");
    assert!(errors[0].starts_with("error: rank 1 of 2 (") && errors[0].contains("device"), "{errors:?}");
    assert!(read(&folder, "x.png").is_empty());
}

#[test]
fn ranks_that_see_other_files_are_noticed() {
    let folder = folder();
    let cloud = cloud(&folder);
    let other = folder.path().join("other");
    fs::create_dir(&other).expect("a folder");
    // One color of one point.
    let text = fs::read_to_string(folder.path().join(cloud)).expect("the cloud");
    let (start, last) = text.trim_end().rsplit_once(' ').expect("a number");
    fs::write(other.join(cloud), format!("{start} {}\n", last.parse::<u8>().unwrap() ^ 1)).expect("a file");
    let mut command = Command::new(mpirun());
    with_environment(&mut command, &folder);
    let program = env!("CARGO_BIN_EXE_pellucid-mpi");
    let args = [program, "render", cloud, "--size", "64x64", "-o", "x.png"];
    command.args(["-n", "1"]).args(args).args([":", "-n", "1", "-wdir"]).arg(&other).args(args);
    let output = command.output().expect("mpirun");
    let errors = errors(&output);
    assert!(errors.len() == 1 && errors[0].contains("rank 1 found another scene"), "{errors:?}");
    assert!(read(&folder, "x.png").is_empty());
}

#[test]
fn errors_of_rendering_are_reported_once() {
    let folder = folder();
    let args = ["render", "--size", "640x480", "--method", "abuffer", "--memory-budget", "1KiB", "-o", "x.png"];
    let output = ranks(&folder, 3, &args).output().expect("mpirun");
    let errors = errors(&output);
    assert_eq!(errors.len(), 1, "{errors:?}");
    assert!(errors[0].contains(" of 3 (") && errors[0].contains("--memory-budget"), "{errors:?}");
}

/// The lines of standard error that are errors.
fn errors(output: &Output) -> Vec<String> {
    assert!(!output.status.success());
    let said = String::from_utf8_lossy(&output.stderr);
    said.lines().filter(|line| line.starts_with("error:")).map(str::to_owned).collect()
}

/// Messages of a rank with `-v`, in this order.
const MOMENTS: [&str; 5] = ["joined", "reading", "uploading", "rendering", "bringing parts together"];

#[test]
#[cfg(unix)]
fn a_rank_that_is_killed_at_any_moment_ends_all_and_leaves_no_file() {
    let (folder, input) = (folder(), folder());
    let cloud = input.path().join(cloud(&input));
    let cloud = cloud.to_str().expect("a name");
    for moment in MOMENTS {
        for victim in 0..3 {
            let args = ["render", cloud, "--size", "1920x1080", "--method", "abuffer", "-v", "-o", "killed.png"];
            let mut running = ranks(&folder, 3, &args).stderr(Stdio::piped()).spawn().expect("mpirun");
            let mut lines =
                BufReader::new(running.stderr.take().expect("standard error")).lines().map_while(Result::ok);
            let wanted = format!("rank {victim} of 3 ");
            let mut before = Vec::new();
            let is_wanted = |line: &String| line.starts_with(&wanted) && line.ends_with(moment);
            let line = lines.by_ref().inspect(|line| before.push(line.clone())).find(is_wanted);
            let line = line.unwrap_or_else(|| panic!("{moment} {victim}: {before:?}"));
            let process = line.split_once("process ").and_then(|(_, rest)| rest.split_once(':')).expect("a process").0;
            let killed = Command::new("kill").args(["-9", process]).status().expect("kill runs");
            let begin = Instant::now();
            let said: Vec<String> = lines.collect();
            let status = running.wait().expect("mpirun ends");
            assert!(begin.elapsed() < Duration::from_secs(10), "{moment} {victim}: {:?}", begin.elapsed());
            assert!(killed.success() && !status.success(), "{moment} {victim}");
            if mpirun() == "mpirun" {
                let named =
                    said.iter().any(|line| line.contains(&format!("rank {victim} ")) && line.contains("signal 9"));
                assert!(named, "{moment} {victim}: {said:?}");
            }
            let left: Vec<_> =
                fs::read_dir(folder.path()).expect("a folder").flatten().map(|file| file.file_name()).collect();
            assert!(left.is_empty(), "{moment} {victim}: {left:?}");
        }
    }
}
