//! The output of `profile`, `plan` and `devices`, and the files of `--profile` and `--trace`.

use std::fs;

use serde_json::Value;
use tempfile::TempDir;

use crate::{builtin, done, folder, has_device, inside, run};

fn keys(value: &Value) -> Vec<&str> {
    value.as_object().unwrap_or_else(|| panic!("an object: {value}")).keys().map(String::as_str).collect()
}

fn parsed(text: &str) -> Value {
    serde_json::from_str(text).unwrap_or_else(|e| panic!("{e}: {text}"))
}

fn read(folder: &TempDir, name: &str) -> Value {
    parsed(&fs::read_to_string(inside(folder, name)).unwrap())
}

/// Asserts the shape of a profile and what must hold between its figures.
#[track_caller]
fn assert_profile(profile: &Value, frames: usize, pixels: u64) {
    let mut wanted = vec!["version", "device", "method", "steady", "scene", "memory", "host", "frames"];
    // A picture that is rendered once notes no work.
    if profile["steady"].is_boolean() {
        wanted.push("work");
        assert_eq!(keys(&profile["work"]), ["tile_splats", "pixel_fragments"]);
        assert_eq!(keys(&profile["work"]["pixel_fragments"]), ["busy", "empty", "min", "median", "max"]);
        assert_eq!(profile["work"]["pixel_fragments"]["max"], profile["scene"]["max_list"]);
    }
    assert_eq!(keys(profile), wanted);
    assert_eq!(profile["version"], 1);
    let device = &profile["device"];
    assert_eq!(keys(device), ["name", "driver", "timestamp_period_ns"]);
    assert!(device["name"].is_string() && device["driver"].is_string());
    assert!(device["timestamp_period_ns"].as_f64().unwrap() > 0.0);

    let scene = &profile["scene"];
    assert_eq!(
        keys(scene),
        ["points", "pixels", "samples", "fragments", "max_list", "list_histogram", "nodes_read", "bytes_read"]
    );
    assert_eq!(scene["pixels"], pixels);
    assert_eq!([&scene["nodes_read"], &scene["bytes_read"]], [0, 0], "the cloud is in memory");
    assert!(scene["points"].as_u64().unwrap() > 0);
    let histogram: Vec<[u64; 2]> = serde_json::from_value(scene["list_histogram"].clone()).unwrap();
    assert!(histogram.windows(2).all(|pair| pair[0][0] < pair[1][0]), "ascending: {histogram:?}");
    assert_eq!(histogram.iter().map(|[_, count]| count).sum::<u64>(), pixels);
    assert_eq!(
        histogram.iter().map(|[length, count]| length * count).sum::<u64>(),
        scene["fragments"].as_u64().unwrap()
    );
    assert_eq!(histogram.last().unwrap()[0], scene["max_list"].as_u64().unwrap());

    let memory = &profile["memory"];
    let device = ["device_budget_bytes", "device_used_bytes"];
    let wanted = [&["peak_device_bytes"], &device[..], &["peak_host_bytes", "fragment_bytes", "bands"]].concat();
    assert_eq!(keys(memory), wanted);
    assert!(
        device.iter().all(|key| memory[key].is_u64()) || device.iter().all(|key| memory[key].is_null()),
        "{memory}"
    );
    let bytes = |key: &str| memory[key].as_u64().unwrap();
    assert!(memory["peak_host_bytes"].is_null() || bytes("peak_host_bytes") > 1 << 20);
    assert!(bytes("peak_device_bytes") > bytes("fragment_bytes") && bytes("bands") >= 1);

    let host = profile["host"].as_array().unwrap();
    let names: Vec<&str> = host.iter().map(|phase| phase["name"].as_str().unwrap()).collect();
    let all = ["read", "prepare", "order", "upload", "compile", "frame", "write"];
    assert!(
        names.iter().all(|name| all.contains(name))
            && names.is_sorted_by_key(|name| all.iter().position(|n| n == name))
    );
    assert!(["read", "order", "upload", "frame"].iter().all(|name| names.contains(name)), "{names:?}");
    assert!(host.iter().all(|phase| phase["ms"].as_f64().unwrap() >= 0.0 && keys(phase) == ["name", "ms"]), "{host:?}");

    let list = profile["frames"].as_array().unwrap();
    assert_eq!(list.len(), frames);
    let is_measured = profile["steady"].is_boolean();
    for frame in list {
        assert_eq!(keys(frame), ["gpu_ms", "total_ms", "wall_ms", "waits", "passes"]);
        // A picture that is rendered once is not measured apart.
        let total = frame["total_ms"].as_f64();
        assert_eq!((total.is_some(), frame["total_ms"].is_null()), (is_measured, !is_measured), "{frame}");
        assert!(total.is_none_or(|total| total > 0.0 && total.is_finite()), "{frame}");
        assert!(frame["waits"].as_u64().unwrap() >= 1, "the host waits for the picture at least");
        let mut sum = 0.0;
        for pass in frame["passes"].as_array().unwrap() {
            assert_eq!(keys(pass), ["name", "gpu_ms", "invocations", "bytes"]);
            assert!(pass["name"].as_str().unwrap().contains('/'), "method/stage: {pass}");
            assert!(["invocations", "bytes"].iter().all(|key| pass[key].is_u64() || pass[key].is_null()), "{pass}");
            sum += pass["gpu_ms"].as_f64().unwrap();
        }
        let (gpu, wall) = (frame["gpu_ms"].as_f64().unwrap(), frame["wall_ms"].as_f64().unwrap());
        assert!(gpu > 0.0 && (gpu - sum).abs() <= 1e-9 * gpu && wall >= gpu, "{gpu} of {sum}, wall {wall}");
    }
}

#[test]
fn profiles_have_the_documented_shape() {
    if !has_device() {
        return;
    }
    let folder = folder();
    let tori = builtin(&folder, "tori", &["points=2000"]);
    let size = ["--size", "40x30"];
    let args = [&["profile", &tori, "--frames", "2", "--json", "--profile", "file.json"], &size[..]].concat();
    let printed = parsed(&done(&folder, &args));
    assert_profile(&printed, 2, 1200);
    assert_eq!(printed, read(&folder, "file.json"), "one profile, printed and written");

    let args = ["render", &tori, "--profile", "render.json", "--trace", "trace.json", "-o", "a.png"];
    done(&folder, &[&args[..], &size].concat());
    let rendered = read(&folder, "render.json");
    assert_profile(&rendered, 1, 1200);
    assert_eq!(rendered["host"].as_array().unwrap().last().unwrap()["name"], "write");
    assert_eq!(rendered["scene"], printed["scene"]);
    assert_trace(&read(&folder, "trace.json"), &rendered);
}

/// The waits of each frame of a profile.
fn waits(profile: &Value) -> Vec<u64> {
    profile["frames"].as_array().unwrap().iter().map(|frame| frame["waits"].as_u64().unwrap()).collect()
}

#[test]
fn steady_frames_wait_once_and_others_for_each_count() {
    if !has_device() {
        return;
    }
    let folder = folder();
    let tori = builtin(&folder, "tori", &["points=2000"]);
    let moving = ["--turntable", "--frames", "4"];
    for (method, more) in [("abuffer", &["--frames", "3"][..]), ("peel", &["--frames", "3"]), ("abuffer", &moving)] {
        let fixed = ["profile", &tori, "--json", "--size", "40x30", "--method", method];
        let of = |steady: &[&str]| parsed(&done(&folder, &[&fixed[..], more, steady].concat()));
        let (steady, waiting) = (of(&["--steady"]), of(&[]));
        assert_eq!([&steady["steady"], &waiting["steady"]], [true, false]);
        assert!(waits(&steady).iter().all(|waits| *waits == 1), "{method} {more:?}: {:?}", waits(&steady));
        // All of them, and not only the first ones.
        let [least, most] = [waits(&waiting).into_iter().min(), waits(&waiting).into_iter().max()];
        assert!(least > Some(1), "{method} {more:?}: {:?}", waits(&waiting));
        assert!(more == moving || least == most, "{method}: {:?}", waits(&waiting));
        for profile in [&steady, &waiting] {
            let frames = profile["frames"].as_array().unwrap();
            assert!(frames.iter().all(|frame| frame["total_ms"].as_f64().is_some_and(|ms| ms > 0.0 && ms.is_finite())));
        }
        // The lists are counted in either case.
        assert_eq!(steady["scene"]["fragments"], waiting["scene"]["fragments"]);
        assert!(steady["scene"]["fragments"].as_u64() > Some(0));
        for (name, profile) in [("steady.json", &steady), ("waiting.json", &waiting)] {
            fs::write(inside(&folder, name), profile.to_string()).unwrap();
        }
        let (status, _, stderr) = run(&folder, &["compare", "steady.json", "waiting.json"]);
        assert!(status == 1 && stderr.contains("different things: steady true and false;"), "{stderr}");
    }
}

#[test]
fn steady_frames_that_must_wait_say_why() {
    if !has_device() {
        return;
    }
    let folder = folder();
    let tori = builtin(&folder, "tori", &["points=2000"]);
    let lines: String = (0..5000).map(|i| format!("{} {} {}\n", i % 100, i / 100, i % 7)).collect();
    fs::write(inside(&folder, "a.xyz"), lines).unwrap();
    done(&folder, &["prepare", "a.xyz", "-o", "a/", "--node-points", "1000"]);
    let profile = ["profile", "--json", "--size", "40x30", "--method", "abuffer", "--frames", "2", "--steady"];
    let of = |more: &[&str]| {
        let (status, json, stderr) = run(&folder, &[&profile[..], more].concat());
        assert_eq!(status, 0, "{stderr}");
        (waits(&parsed(&json)), parsed(&json)["frames"][1]["total_ms"].as_f64(), stderr)
    };
    let (counted, total, stderr) = of(&["a/", "--detail", "1"]);
    assert!(counted.iter().all(|waits| *waits > 1) && total > Some(0.0), "{counted:?} {total:?}");
    assert!(stderr.contains("--steady: the frames wait for their counts, because their points come"), "{stderr}");
    let (counted, _, stderr) = of(&[&tori]);
    assert!(counted == [1, 1] && !stderr.contains("--steady"), "{counted:?}: {stderr}");
}

/// The line of standard error that begins with a word, cut into its parts: names with milliseconds.
#[track_caller]
fn times(stderr: &str, word: &str) -> Vec<String> {
    let line = stderr.lines().find_map(|line| line.strip_prefix(word)).unwrap_or_else(|| panic!("{word} in {stderr}"));
    let part = |part: &str| {
        let (name, ms) = part.strip_suffix(" ms").unwrap().rsplit_once(' ').unwrap();
        assert!(ms.parse::<f64>().unwrap() >= 0.0, "{part}");
        name.trim().to_owned()
    };
    line.split(", ").map(part).collect()
}

#[test]
fn a_verbose_run_says_what_host_and_device_took() {
    if !has_device() {
        return;
    }
    let folder = folder();
    let tori = builtin(&folder, "tori", &["points=2000"]);
    let args = ["render", &tori, "--size", "40x30", "-o", "a.png", "--profile", "p.json"];
    let (code, _, stderr) = run(&folder, &[&["-v"], &args[..]].concat());
    assert_eq!(code, 0, "{stderr}");
    let profile = read(&folder, "p.json");
    let names = |list: &Value| -> Vec<String> {
        list.as_array().unwrap().iter().map(|one| one["name"].as_str().unwrap().to_owned()).collect()
    };
    assert_eq!(times(&stderr, "host:"), names(&profile["host"]));
    assert_eq!(times(&stderr, "passes:"), names(&profile["frames"][0]["passes"]));
    // Passes are timed for whoever reads of them, whether they go to a file or not.
    let (_, _, told) = run(&folder, &[&["-v"], &args[..6]].concat());
    assert_eq!(times(&told, "passes:"), times(&stderr, "passes:"));
    let (_, _, quiet) = run(&folder, &args);
    assert!(!quiet.contains("host:") && !quiet.contains("passes:"), "{quiet}");
}

#[test]
fn phases_of_a_sequence_and_of_a_time_series_are_those_of_the_whole_command() {
    if !has_device() {
        return;
    }
    let folder = folder();
    let tori = builtin(&folder, "tori", &["points=2000"]);
    for (frames, output) in [(&["--turntable", "--frames", "2"][..], "a_%d.png"), (&["--frames"], "b_%d.png")] {
        let files = ["--profile", "p.json", "--trace", "t.json", "-o", output, "-v"];
        let args = [&["render", &tori, "--size", "40x30"], frames, &files].concat();
        let (code, _, stderr) = run(&folder, &args);
        assert_eq!(code, 0, "{stderr}");
        let (trace, profile) = (read(&folder, "t.json"), read(&folder, "p.json"));
        let events = trace["traceEvents"].as_array().unwrap();
        assert!(times(&stderr, "host:").iter().all(|name| events.iter().any(|event| event["name"] == name.as_str())));
        let read = profile["host"].as_array().unwrap().iter().find(|phase| phase["name"] == "read").unwrap();
        assert!(read["ms"].as_f64().unwrap() > 0.0, "{read}");
        let is_frame = |event: &&Value| event["name"].as_str().unwrap().starts_with("frame ");
        let frames: Vec<_> = events.iter().filter(is_frame).collect();
        assert_eq!(frames.len(), profile["frames"].as_array().unwrap().len());
        let writes = events.iter().filter(|event| event["name"] == "write").count();
        assert_eq!(writes, frames.len(), "each picture is a span of its own");
        assert!(frames.windows(2).all(|pair| end(pair[0]) <= begin(pair[1])), "one after another: {frames:?}");
    }
}

/// Asserts that a Chrome trace shows the phases and the passes of a profile of one frame.
#[track_caller]
fn assert_trace(trace: &Value, profile: &Value) {
    let events = trace["traceEvents"].as_array().unwrap();
    let mut passes = Vec::new();
    for event in events {
        assert!(event["name"].is_string() && event["pid"].is_u64() && event["tid"].is_u64(), "{event}");
        match event["ph"].as_str().unwrap() {
            "X" => assert!(event["ts"].as_f64().unwrap() >= 0.0 && event["dur"].as_f64().unwrap() >= 0.0, "{event}"),
            // Names of the rows.
            other => assert_eq!(other, "M"),
        }
        if event["ph"] == "X" && event["name"].as_str().unwrap().contains('/') {
            passes.push(event);
        }
    }
    let starts: Vec<f64> = events.iter().filter_map(|event| event["ts"].as_f64()).collect();
    assert!(starts.is_sorted() && starts.len() > passes.len(), "events in the order of their starts: {starts:?}");
    // Both are sums of nanoseconds in microseconds.
    assert!(passes.windows(2).all(|pair| end(pair[0]) <= pair[1]["ts"].as_f64().unwrap() + 1e-3), "one after another");
    for pass in profile["frames"][0]["passes"].as_array().unwrap() {
        let runs = passes.iter().filter(|event| event["name"] == pass["name"]);
        let micros: f64 = runs.map(|event| event["dur"].as_f64().unwrap()).sum();
        assert!((micros - 1e3 * pass["gpu_ms"].as_f64().unwrap()).abs() < 1e-3, "{pass}");
    }
    assert_phases(events, profile);
    let named = |name: &str| events.iter().find(|event| event["name"] == name).unwrap();
    let (frame, phase) = (named("frame 0"), named("frame"));
    assert!(frame["tid"] == phase["tid"] && frame["tid"] != passes[0]["tid"], "rows of the host and of the device");
    assert!(begin(frame) >= begin(phase) && end(frame) <= end(phase) + 1e-3, "{frame} in {phase}");
    assert!(passes.iter().all(|pass| begin(pass) >= begin(frame) - 1e-3), "passes begin in {frame}");
}

/// Asserts that the phases of the host follow one another in a trace, and that they add up to those of a profile.
#[track_caller]
fn assert_phases(events: &[Value], profile: &Value) {
    let mut phases = Vec::new();
    for phase in profile["host"].as_array().unwrap() {
        let spans: Vec<_> = events.iter().filter(|event| event["name"] == phase["name"]).collect();
        assert!(!spans.is_empty() && spans.iter().all(|span| span["tid"] == 0), "{phase}");
        phases.extend(spans);
    }
    let micros = |phases: &[&Value]| phases.iter().map(|phase| end(phase) - begin(phase)).sum::<f64>();
    let (compile, others): (Vec<_>, Vec<_>) = phases.into_iter().partition(|phase| phase["name"] == "compile");
    let sum: f64 = profile["host"].as_array().unwrap().iter().map(|phase| 1e3 * phase["ms"].as_f64().unwrap()).sum();
    // Spans that made pipelines lie within other phases.
    assert!((micros(&others) - sum).abs() < 1.0, "{others:?} for {sum} µs");
    let within = |span: &Value| others.iter().any(|o| begin(o) <= begin(span) && end(span) <= end(o) + 1e-3);
    assert!(!compile.is_empty() && compile.iter().all(|span| within(span)), "{compile:?} in {others:?}");
    let mut others = others;
    others.sort_by(|a, b| begin(a).total_cmp(&begin(b)));
    assert_eq!(begin(others[0]), 0.0, "time counts from the first phase");
    assert!(others.windows(2).all(|pair| (end(pair[0]) - begin(pair[1])).abs() < 1e-3), "without a gap: {others:?}");
}

/// Start of an event of a trace in microseconds.
fn begin(event: &Value) -> f64 {
    event["ts"].as_f64().unwrap()
}

/// End of an event of a trace in microseconds.
fn end(event: &Value) -> f64 {
    begin(event) + event["dur"].as_f64().unwrap()
}

#[test]
fn the_table_names_every_pass_and_the_device() {
    if !has_device() {
        return;
    }
    let folder = folder();
    let tori = builtin(&folder, "tori", &["points=2000"]);
    let args = ["profile", &tori, "--frames", "2", "--size", "40x30", "--profile", "p.json"];
    let table = done(&folder, &args);
    let profile = read(&folder, "p.json");
    for pass in profile["frames"][0]["passes"].as_array().unwrap() {
        let name = pass["name"].as_str().unwrap();
        let row = table.lines().find(|line| line.split_whitespace().next() == Some(name));
        let columns: Vec<_> = row.unwrap_or_else(|| panic!("{name} in {table}")).split_whitespace().collect();
        let times: Vec<f64> = columns[1..4].iter().map(|text| text.parse().unwrap()).collect();
        assert!(times[0] <= times[1] && times[1] <= times[2], "min, median, max: {columns:?}");
        assert!(columns[4].ends_with('%'), "the share: {columns:?}");
    }
    for part in [profile["device"]["name"].as_str().unwrap(), "2 frame(s)", "1200 pixels", "copy rate", "peak"] {
        assert!(table.contains(part), "{part:?} in {table}");
    }
}

#[test]
fn a_profile_says_what_the_compiler_made_of_each_pass_or_that_the_driver_does_not_tell() {
    if !has_device() {
        return;
    }
    let folder = folder();
    let tori = builtin(&folder, "tori", &["points=500"]);
    let args = ["-q", "profile", &tori, "--frames", "1", "--size", "16x12", "--method", "points", "--pipelines"];
    let (table, profile) = (done(&folder, &args), parsed(&done(&folder, &[&args[..], &["--json"]].concat())));
    let plain = parsed(&done(&folder, &[&args[..args.len() - 1], &["--json"]].concat()));
    assert_eq!(plain.get("pipelines"), None, "nobody asked");
    let sentence = table.contains("doesn't tell what its compiler made of them");
    match profile["pipelines"].as_array() {
        None => assert!(profile["pipelines"].is_null() && sentence && !table.contains("registers"), "{table}"),
        Some(all) => {
            assert!(!sentence && table.contains("registers") && table.contains("code KiB"), "{table}");
            let told = |pipeline: &Value| !pipeline["executables"].as_array().unwrap().is_empty();
            assert!(all.iter().any(told), "{all:?}");
        }
    }
}

/// A library that is called RenderDoc and writes down what is asked of it.
#[cfg(target_os = "linux")]
const RENDERDOC: &str = r#"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
static void note(const char *call) {
    FILE *file = fopen(getenv("CALLS"), "a");
    fprintf(file, "%s\n", call);
    fclose(file);
}
static unsigned count(void) { return 1; }
static unsigned get(unsigned index, char *path, unsigned *length, unsigned long long *time) {
    const char *known = "/captures/only.rdc";
    if (length) *length = strlen(known) + 1;
    if (path) strcpy(path, known);
    return index == 0;
}
static void start(void *device, void *window) { note("start"); }
static unsigned end(void *device, void *window) { note("end"); return 1; }
static void *functions[27];
int RENDERDOC_GetAPI(int version, void **out) {
    functions[13] = count;
    functions[14] = get;
    functions[19] = start;
    functions[21] = end;
    *out = functions;
    return version == 10000;
}
"#;

#[test]
#[cfg(target_os = "linux")]
fn renderdoc_captures_the_frame_that_is_asked_for_once_it_is_loaded() {
    use pellucid_testing::skip::{NO_PROGRAM, skip};
    if !has_device() {
        return;
    }
    let folder = folder();
    fs::write(inside(&folder, "renderdoc.c"), RENDERDOC).unwrap();
    let library = inside(&folder, "librenderdoc.so");
    let built = std::process::Command::new("cc")
        .args(["-shared", "-fPIC", "-Wl,-soname,librenderdoc.so", "-o"])
        .args([&library, &inside(&folder, "renderdoc.c")])
        .status();
    if !built.is_ok_and(|status| status.success()) {
        return skip(NO_PROGRAM, "cc");
    }
    let tori = builtin(&folder, "tori", &["points=500"]);
    let args = ["profile", &tori, "--size", "16x12", "--method", "points", "--frames", "2", "--capture"];
    let of = |number: &str, loaded: bool| {
        let mut command = crate::pellucid(&folder, &[&args[..], &[number]].concat());
        if loaded {
            command.env("LD_PRELOAD", &library).env("CALLS", inside(&folder, "calls"));
        }
        let output = command.output().unwrap();
        (output.status.code(), String::from_utf8(output.stderr).unwrap())
    };
    let (status, stderr) = of("2", true);
    assert!(status == Some(0) && stderr.contains("frame 2 is captured: /captures/only.rdc"), "{stderr}");
    assert_eq!(fs::read_to_string(inside(&folder, "calls")).unwrap(), "start\nend\n", "one frame");
    let (status, stderr) = of("2", false);
    assert!(status == Some(1) && stderr.contains("can't capture a frame: RenderDoc isn't loaded"), "{stderr}");
    let (status, stderr) = of("3", true);
    assert!(status == Some(2) && stderr.contains("--capture 3: there are only 2 frames"), "{stderr}");
}

/// Asserts that a plan says of exactly the passes of a profile that they are on; the names of those.
#[track_caller]
fn assert_planned(folder: &TempDir, args: &[&str]) -> Vec<String> {
    let plan = parsed(&done(folder, &[&["plan", "--json"], args].concat()));
    let mut on = Vec::new();
    for step in plan.as_array().unwrap() {
        assert_eq!(keys(step), ["name", "on", "reason"]);
        assert!(!step["reason"].as_str().unwrap().is_empty(), "{step}");
        if step["on"].as_bool().unwrap() {
            on.push(step["name"].as_str().unwrap().to_owned());
        }
    }
    let profile = parsed(&done(folder, &[&["profile", "--json", "--frames", "1"], args].concat()));
    let passes = profile["frames"][0]["passes"].as_array().unwrap();
    let mut ran: Vec<_> = passes.iter().map(|pass| pass["name"].as_str().unwrap().to_owned()).collect();
    let named = on.clone();
    on.sort_unstable();
    ran.sort_unstable();
    assert_eq!(on, ran, "{args:?}: what the plan has on, and what ran");
    named
}

#[test]
fn effects_that_a_scene_does_not_ask_for_have_no_pass() {
    if !has_device() {
        return;
    }
    let folder = folder();
    let tori = builtin(&folder, "tori", &["points=2000"]);
    for method in ["abuffer", "circles", "soft-express", "spbr"] {
        let args = |more: &[&'static str]| {
            let all =
                [&["-q", &tori, "--size", "40x30", "--method", method, "--set", "shading.model=none"], more].concat();
            assert_planned(&folder, &all)
        };
        let plain = args(&[]);
        let effects = ["shading/", "shadows/"];
        assert!(!plain.iter().any(|pass| effects.iter().any(|effect| pass.starts_with(effect))), "{method}: {plain:?}");
        // Clips take points out before they come to the device: this one none, and no pass.
        assert_eq!(args(&["--slice", "x=-1000..1000"]), plain, "{method}");
        assert_eq!(args(&["--set", "cloud.*.outliers=keep", "--set", "cloud.*.radius_cap=0"]), plain, "{method}");
        // The others have no depth of a surface to shade by.
        if ["abuffer", "circles"].contains(&method) {
            let lit = args(&["--set", "shading.edl=true"]);
            assert!(lit.iter().any(|pass| pass == "shading/edl"), "{method}: {lit:?}");
        }
    }
}

#[test]
fn plan_and_profile_name_the_same_passes() {
    if !has_device() {
        return;
    }
    let folder = folder();
    let tori = builtin(&folder, "tori", &["points=2000"]);
    // The other roads that a frame may take are in crates/cli/src/commands/plan/tests.rs, on one device.
    let chosen = assert_planned(&folder, &[&tori, "--size", "40x30"]);
    assert!(chosen.iter().any(|pass| pass == "abuffer/resolve-8"), "{chosen:?}");
    let cut = assert_planned(&folder, &["-q", &tori, "--memory-budget", "400KiB", "--method", "weighted"]);
    assert!(cut.iter().any(|pass| pass == "weighted/accumulate"), "{cut:?}");
    assert_planned(&folder, &["-q", &tori, "--size", "40x30", "--method", "soft-base", "--opacity", "0.5"]);
}

#[test]
fn sorted_splats_are_profiled_for_the_output_they_are_for() {
    if !has_device() {
        return;
    }
    let folder = folder();
    let stack = builtin(&folder, "stack", &["layers=300", "size=8"]);
    let sorted = ["--method", "sorted", "--size", "40x30"];
    for format in ["png", "exr"] {
        let args = ["profile", &stack, "--json", "--frames", "2", "--for", format];
        let profile = parsed(&done(&folder, &[&args[..], &sorted].concat()));
        // The lists are counted once, in addition to the frames that are measured.
        assert_profile(&profile, 2, 1200);
        assert_eq!(profile["scene"]["max_list"], 300);
        let passes = profile["frames"][0]["passes"].as_array().unwrap();
        assert!(passes.iter().all(|pass| !pass["name"].as_str().unwrap().starts_with("abuffer/")), "{passes:?}");
        let scatter = passes.iter().find(|pass| pass["name"] == "radix/scatter").unwrap();
        assert!(scatter["bytes"].as_u64().unwrap() > 0);
    }
    let (code, _, stderr) = run(&folder, &["profile", &stack, "--for", "jpeg"]);
    assert!(code == 2 && stderr.contains("png"), "{stderr}");
    // With the channel of list lengths, the frame itself counts them.
    done(&folder, &[&["render", &stack, "--aov", "--profile", "p.json", "-o", "a.exr"], &sorted[..]].concat());
    let profile = read(&folder, "p.json");
    assert_profile(&profile, 1, 1200);
    let passes = profile["frames"][0]["passes"].as_array().unwrap();
    assert!(passes.iter().any(|pass| pass["name"] == "abuffer/count"), "{passes:?}");
}

#[test]
fn the_plan_as_text_has_a_line_for_each_pass() {
    if !has_device() {
        return;
    }
    let folder = folder();
    let tori = builtin(&folder, "tori", &["points=2000"]);
    let text = done(&folder, &["plan", &tori, "--size", "40x30"]);
    let plan = parsed(&done(&folder, &["plan", &tori, "--size", "40x30", "--json"]));
    let steps = plan.as_array().unwrap();
    assert_eq!(text.lines().count(), steps.len());
    for (line, step) in text.lines().zip(steps) {
        let words: Vec<_> = line.split_whitespace().collect();
        let on = if step["on"].as_bool().unwrap() { "on" } else { "off" };
        assert_eq!(words[..2], [step["name"].as_str().unwrap(), on]);
        let reason: Vec<_> = step["reason"].as_str().unwrap().split_whitespace().collect();
        assert_eq!(words[2..], reason);
    }
}

#[test]
fn what_is_read_of_a_store_is_in_the_profile() {
    if !has_device() {
        return;
    }
    let folder = folder();
    let lines: String = (0..20_000).map(|i| format!("{} {} {}\n", i % 100, i / 100, i % 7)).collect();
    fs::write(inside(&folder, "a.xyz"), lines).unwrap();
    done(&folder, &["prepare", "a.xyz", "-o", "a/", "--node-points", "1000"]);
    let reads = |more: &[&str]| {
        let args = [
            &[
                "profile",
                "a/",
                "--json",
                "--frames",
                "2",
                "--size",
                "32x24",
                "--method",
                "circles",
                "--set",
                "shading.model=none",
            ],
            more,
        ]
        .concat();
        let scene = parsed(&done(&folder, &args))["scene"].clone();
        ["nodes_read", "bytes_read"].map(|key| scene[key].as_u64().unwrap())
    };
    let [nodes, bytes] = reads(&["--host-memory", "1MiB"]);
    // 20,000 points in nodes of 1000 at most, 15 bytes of color and place for each before they are packed.
    assert!(nodes >= 20 && bytes >= 20_000, "{nodes} nodes, {bytes} bytes");
    let [some, fewer] = reads(&["--host-memory", "1MiB", "--max-points", "5000"]);
    assert!(some > 0 && some < nodes && fewer < bytes, "{some} of {nodes} nodes, {fewer} of {bytes} bytes");
    assert_eq!(reads(&[]), [0, 0], "all of it fits into memory");
}

#[test]
fn devices_are_listed_and_one_is_taken() {
    if !has_device() {
        return;
    }
    let folder = folder();
    let (code, json, stderr) = run(&folder, &["devices", "--json"]);
    assert_eq!((code, stderr.as_str()), (0, ""));
    let list = parsed(&json);
    let list = list.as_array().unwrap();
    for (index, device) in list.iter().enumerate() {
        assert_eq!(keys(device), ["index", "name", "driver", "lacks", "memory", "taken"]);
        let memory = &device["memory"];
        assert_eq!(keys(memory), ["heap_bytes", "budget_bytes", "used_bytes"]);
        assert!(memory["heap_bytes"].as_u64() > Some(0), "{device}");
        // Both or neither: the extension has them together.
        assert_eq!(memory["budget_bytes"].is_u64(), memory["used_bytes"].is_u64());
        assert_eq!(device["index"], index);
        assert!(device["name"].is_string() && device["driver"].is_string() && device["taken"].is_boolean());
        assert!(device["lacks"].as_array().unwrap().iter().all(Value::is_string));
    }
    let taken: Vec<_> = list.iter().filter(|device| device["taken"] == true).collect();
    assert!(taken.len() == 1 && taken[0]["lacks"].as_array().unwrap().is_empty(), "{json}");
    let (_, text, _) = run(&folder, &["devices"]);
    for device in list {
        let lacks: Vec<&str> = device["lacks"].as_array().unwrap().iter().map(|word| word.as_str().unwrap()).collect();
        let told = if lacks.is_empty() { "nothing".to_owned() } else { lacks.join(", ") };
        assert!(text.lines().any(|line| line.ends_with(&format!("; lacks {told}"))), "{told}: {text}");
    }
    assert!(list.iter().all(|device| text.contains(device["name"].as_str().unwrap())), "{text}");
    let starred: Vec<_> = text.lines().filter(|line| line.starts_with("* ") && !line.contains("selected")).collect();
    assert!(starred.len() == 1 && starred[0].contains(taken[0]["name"].as_str().unwrap()), "{text}");
}
