//! Sequences that are cut short, by force or by an interruption, and gone on with.

use std::fs;
use std::process::{Command, Stdio};
use std::time::Duration;

use serde_json::Value;
use tempfile::TempDir;

use crate::{device, has_device, inside};
use pellucid_testing::shader_cache;
use pellucid_testing::signals::heeding;

use super::sequence::{garden, json, pictures, said, written};

/// Starts a run, waits until some frames are there, and ends it by force or by an interruption; its exit status.
fn cut_short(folder: &TempDir, args: &[&str], frames: usize, signal: &str) -> Option<i32> {
    let mut command = heeding(assert_cmd::cargo::cargo_bin("pellucid"));
    command
        .current_dir(folder)
        .env("PELLUCID_CACHE_DIR", shader_cache())
        .args(args)
        .stdout(Stdio::null())
        .stderr(Stdio::null());
    if let Some(device) = device() {
        command.args(["--device", &device]);
    }
    let mut child = command.spawn().unwrap();
    while pictures(folder).len() < frames {
        assert!(child.try_wait().unwrap().is_none(), "it ended before it was to be cut short");
        std::thread::sleep(Duration::from_millis(2));
    }
    Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap();
    child.wait().unwrap().code()
}

#[test]
fn a_run_that_is_killed_goes_on_where_it_was() {
    if !has_device() {
        return;
    }
    // Enough frames that the last ones are not there when the first ones are.
    const FRAMES: usize = 60;
    let [cut, whole] = [garden(), garden()];
    let args = |method: &'static str, more: &[&'static str]| {
        let path = ["--path", "path.json", "--frames", "60", "-o", "f_%02d.png", "--profile", "p.json", "-v"];
        [&["render", "garden/scene.toml", "--method", method, "--size", "160x120"], &path[..], more].concat()
    };
    let args = args("abuffer", &["--opacity", "0.5"]);
    said(&whole, &args);
    let mut before = 0;
    for (frames, signal) in [(5, "-KILL"), (20, "-INT"), (30, "-KILL")] {
        let status = cut_short(&cut, &args, frames, signal);
        assert_eq!(status, Some(130).filter(|_| signal == "-INT"));
        let there = pictures(&cut);
        assert!(there.len() >= frames.max(before) && there.len() < FRAMES, "{} frames", there.len());
        before = there.len();
        // Every file of a frame's name is whole.
        let expected = pictures(&whole);
        assert!(there.iter().all(|(name, bytes)| expected[name] == *bytes));
        assert!(!inside(&cut, "p.json").exists());
    }
    let known = fs::read_to_string(inside(&cut, "p.json.partial")).unwrap();
    let last = said(&cut, &args);
    assert_eq!(written(&last), FRAMES - before, "{last}");
    assert!(last.contains(&format!("{before} of 60 frames were there already")), "{last}");
    assert!(pictures(&cut) == pictures(&whole), "byte for byte");
    // The profile has all frames, those of the runs before as they were measured then.
    let profile = json(&cut, "p.json");
    let frames = profile["frames"].as_array().unwrap();
    assert_eq!(frames.len(), FRAMES);
    let mut kept = 0;
    for (number, frame) in frames.iter().enumerate() {
        assert_eq!((frame["frame"].as_u64(), frame["passes"].as_array().is_some()), (Some(number as u64), true));
        let lines = known.lines().filter_map(|line| serde_json::from_str::<Value>(line).ok());
        kept += lines.filter(|line| line["frames"][0] == *frame).count();
    }
    assert_eq!(kept, before);
    let expected = json(&whole, "p.json");
    for key in ["version", "device", "scene"] {
        assert_eq!(profile[key], expected[key], "{key}");
    }
    // The peak of the host's memory is that of one run.
    let of_device =
        |profile: &Value| ["peak_device_bytes", "fragment_bytes", "bands"].map(|key| profile["memory"][key].clone());
    assert_eq!(of_device(&profile), of_device(&expected));
    assert!(!inside(&cut, "p.json.partial").exists());
}
