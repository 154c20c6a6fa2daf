//! The commands of README: each runs as it stands there, on a small scan in place of the reader's.

use std::fs;

use crate::films::has_ffmpeg;
use crate::{device, folder, has_device, inside, run};

/// The lines of README's shell blocks that run the program on a scan, without it and its name.
fn commands() -> Vec<Vec<String>> {
    let text = fs::read_to_string(pellucid_testing::root().join("README.md")).unwrap();
    let blocks = text.split("```sh\n").skip(1).filter_map(|rest| rest.split_once("```"));
    let lines = blocks.flat_map(|(block, _)| block.lines());
    lines
        .filter_map(|line| line.split(" # ").next()?.trim().strip_prefix("pellucid "))
        .map(|line| line.split_ascii_whitespace().map(str::to_owned).collect())
        .collect()
}

#[test]
fn readme_is_short() {
    let text = fs::read_to_string(pellucid_testing::root().join("README.md")).unwrap();
    assert!(text.split_ascii_whitespace().count() <= 1200);
}

/// A word of a command for the small scan, whose heights are others and of which a few frames will do.
fn own(word: &str) -> &str {
    match word {
        "72" => "4",
        _ if word.starts_with("z=") => "z=630..635",
        _ => word,
    }
}

#[test]
fn the_commands_of_readme_run() {
    if !has_device() {
        return;
    }
    let commands = commands();
    assert!(commands.len() >= 7, "{commands:?}");
    let folder = folder();
    let scan = pellucid_testing::root().join("tests/data/lidar/sample_c_2k.las");
    fs::copy(scan, inside(&folder, "scan.laz")).unwrap();
    for command in &commands {
        if command.iter().any(|word| word.ends_with(".mp4")) && !has_ffmpeg() {
            continue;
        }
        let mut args: Vec<&str> = command.iter().map(|arg| own(arg)).collect();
        let device = device();
        if command[0] == "render" {
            // Large enough for a legend.
            args.extend(["--size", "240x180"]);
            args.extend(device.iter().flat_map(|device| ["--device", device.as_str()]));
        }
        let (status, _, stderr) = run(&folder, &args);
        assert_eq!(status, 0, "{command:?}: {stderr}");
    }
}
