//! Renders that can't be done: what is said, and that no file comes or goes.

use std::fs;

use crate::{builtin, device, done, folder, has_device, inside, run, write_cloud};

#[test]
fn a_budget_that_one_pixel_exceeds_is_an_error_that_names_it() {
    if !has_device() {
        return;
    }
    let folder = folder();
    let stack = builtin(&folder, "stack", &["layers=100000", "size=2"]);
    let device = device().unwrap_or("0".to_owned());
    let mut args = vec!["render", &stack, "--device", &device, "-o", "a.png", "--memory-budget", "100KiB"];
    fs::write(inside(&folder, "a.png"), "old").unwrap();
    let (code, stdout, stderr) = run(&folder, &args);
    assert_eq!((code, stdout.as_str()), (1, ""), "{stderr}");
    assert!(stderr.starts_with("error: ") && stderr.lines().count() == 1, "{stderr}");
    for part in ["pixel (0, 0) has 100000 fragments", "--memory-budget"] {
        assert!(stderr.contains(part), "{part:?} in {stderr}");
    }
    assert_eq!(fs::read_to_string(inside(&folder, "a.png")).unwrap(), "old", "what was there stays");
    // The budget that the message names does it.
    let (_, after) = stderr.split_once("--memory-budget ").unwrap();
    let wanted = after.split([',', '\n']).next().unwrap().trim_end_matches(" or more").replace(' ', "");
    *args.last_mut().unwrap() = &wanted;
    assert_eq!(run(&folder, &args), (0, String::new(), String::new()), "{wanted}");
    assert_ne!(fs::read(inside(&folder, "a.png")).unwrap(), b"old");
    assert_eq!(fs::read_dir(&folder).unwrap().count(), 2, "the scene and the picture, nothing temporary");
}

#[test]
fn an_unknown_device_is_an_error_that_lists_those_present() {
    if !has_device() {
        return;
    }
    let folder = folder();
    write_cloud(&inside(&folder, "a.ply"));
    let list: serde_json::Value = serde_json::from_str(&run(&folder, &["devices", "--json"]).1).unwrap();
    let names: Vec<_> = list.as_array().unwrap().iter().map(|d| d["name"].as_str().unwrap()).collect();
    for command in ["render", "profile", "plan"] {
        for unknown in ["nonsense", "99"] {
            let (code, stdout, stderr) = run(&folder, &[command, "a.ply", "--device", unknown]);
            assert_eq!((code, stdout.as_str()), (1, ""), "{stderr}");
            assert!(stderr.starts_with("error: ") && names.iter().all(|name| stderr.contains(name)), "{stderr}");
        }
    }
    assert_eq!(run(&folder, &["devices", "--device", "nonsense"]).0, 1);
    assert_eq!(fs::read_dir(&folder).unwrap().count(), 1);
}

#[test]
fn a_damaged_manifest_of_a_driver_is_no_device_and_says_what_to_check() {
    if !has_device() {
        return;
    }
    let folder = folder();
    write_cloud(&inside(&folder, "a.ply"));
    fs::write(inside(&folder, "bad.json"), "{bad").unwrap();
    fs::write(inside(&folder, "list.json"), "[1, 2").unwrap();
    for (manifest, args) in [
        ("bad.json", &["devices"][..]),
        ("list.json", &["devices", "--json"]),
        ("bad.json", &["render", "a.ply", "-o", "a.png"]),
    ] {
        let mut command = crate::pellucid(&folder, args);
        command.env("VK_DRIVER_FILES", inside(&folder, manifest)).env_remove("VK_ICD_FILENAMES");
        let output = command.output().unwrap();
        let stderr = String::from_utf8(output.stderr).unwrap();
        assert_eq!((output.status.code(), stderr.lines().count()), (Some(1), 1), "{stderr}");
        assert!(stderr.starts_with("error: no Vulkan device") && stderr.contains("VK_DRIVER_FILES"), "{stderr}");
        assert!(!stderr.contains("fewer points"), "{stderr}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_picture_too_large_for_memory_is_an_error_that_says_what_it_needs() {
    if !has_device() {
        return;
    }
    let folder = folder();
    write_cloud(&inside(&folder, "a.ply"));
    // 16384² pixels of 20 bytes, and 24 more for a PNG or 52 for an EXR; from a limit below the image alone to one
    // that holds it, but not what its file is made of. Device memory of a driver for CPUs counts too.
    for (limit_kib, file, bytes) in
        [(3_000_000, "a.png", "11.0 GiB"), (8_000_000, "a.png", "11.0 GiB"), (12_000_000, "a.exr", "18.0 GiB")]
    {
        let program = assert_cmd::cargo::cargo_bin("pellucid");
        let command =
            format!("ulimit -v {limit_kib}; exec \"$0\" render a.ply --size 16384x16384 --method points -o {file}");
        let mut shell = std::process::Command::new("sh");
        shell.args(["-c", &command]).arg(program).current_dir(&folder);
        let output = shell.env("PELLUCID_CACHE_DIR", pellucid_testing::shader_cache()).output().unwrap();
        let stderr = String::from_utf8(output.stderr).unwrap();
        assert_eq!((output.status.code(), stderr.lines().count()), (Some(1), 1), "{stderr}");
        let wanted = format!("error: {file}: a picture of 16384 × 16384 pixels needs {bytes} of memory");
        assert!(stderr.starts_with(&wanted) && stderr.contains("--size"), "{stderr}");
        assert!(!inside(&folder, file).exists());
    }
}

#[cfg(target_os = "linux")]
#[test]
fn no_command_that_makes_pictures_ends_in_an_abort_where_memory_is_short() {
    if !has_device() {
        return;
    }
    let folder = folder();
    write_cloud(&inside(&folder, "a.ply"));
    // 4096² pixels of 20 bytes; from a limit below the image to some within which a part of the work fits.
    for limit_kib in [700_000, 900_000, 1_100_000, 1_400_000] {
        for args in [
            "profile a.ply --method points --frames 1 --json",
            "render a.ply --method points --legend --ortho -o a.png",
            "render a.ply --method points --aov -o a.exr",
            "render a.ply --method points --turntable --frames 1 -o a_%d.png",
        ] {
            within(&folder, limit_kib, args);
        }
    }
    // Frames fit, but not all that is compared with them.
    for args in [
        "render a.ply --opacity 0.5 --max-error 0.1 --recalibrate -o a.png",
        "render a.ply --opacity 0.5 --budget 100 --recalibrate -o a.png",
        "render a.ply --opacity 0.5 --method sorted --turntable --frames 2 --popping a.csv -o b_%d.png",
        "tradeoff a.ply --opacity 0.5 --quick --only sorted --time 5 --turntable --frames 2 -o a",
    ] {
        let stderr = within(&folder, 2_200_000, args);
        assert!(stderr.contains("an image of 4096 × 4096 pixels needs"), "{args}: {stderr}");
    }
}

/// Runs the program for 4096² pixels within so much memory, and returns what it says: it succeeds, or tells an error.
#[cfg(target_os = "linux")]
fn within(folder: &tempfile::TempDir, limit_kib: u32, args: &str) -> String {
    let program = assert_cmd::cargo::cargo_bin("pellucid");
    let command = format!("ulimit -v {limit_kib}; exec \"$0\" {args} --size 4096x4096");
    let mut shell = std::process::Command::new("sh");
    shell.args(["-c", &command]).arg(program).current_dir(folder);
    let output = shell.env("PELLUCID_CACHE_DIR", pellucid_testing::shader_cache()).output().unwrap();
    let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!([Some(0), Some(1)].contains(&output.status.code()), "{args}, {limit_kib} KiB: {stderr}");
    assert!(output.status.success() || stderr.contains("error: "), "{args}, {limit_kib} KiB: {stderr}");
    stderr
}

#[cfg(target_os = "linux")]
#[test]
fn a_folder_that_takes_no_file_is_an_error() {
    if !has_device() {
        return;
    }
    let folder = folder();
    write_cloud(&inside(&folder, "a.ply"));
    // Nobody, not even root, makes files in /proc.
    let (code, stdout, stderr) = run(&folder, &["render", "a.ply", "--size", "8x8", "-o", "/proc/a.png"]);
    assert_eq!((code, stdout.as_str()), (1, ""), "{stderr}");
    assert!(stderr.starts_with("error: /proc/a.png: can't be written"), "{stderr}");
}

#[test]
fn warnings_can_be_silenced_and_details_asked_for() {
    if !has_device() {
        return;
    }
    let folder = folder();
    write_cloud(&inside(&folder, "a.ply"));
    let render = ["render", "a.ply", "--size", "8x8", "--aov"];
    let (code, _, stderr) = run(&folder, &render);
    assert_eq!((code, stderr.lines().count()), (0, 1), "{stderr}");
    assert!(stderr.starts_with("warning: --aov has no effect on a PNG"), "{stderr}");
    done(&folder, &[&render[..], &["-q"]].concat());
    let (_, _, stderr) = run(&folder, &[&render[..4], &["-v"]].concat());
    for part in ["a.ply: 2 points", "method circles: every point is opaque", "8 × 8 pixels", " ms", "a.png: written"] {
        assert!(stderr.contains(part), "{part:?} in {stderr}");
    }
}
