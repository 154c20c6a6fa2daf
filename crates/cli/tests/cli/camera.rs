//! Options of the camera: the vertical, the compass, orthographic pictures, the camera that is found; and what is noted
//! of it.

use std::fmt::Write as _;
use std::fs;

use pellucid_io::output::read_image;
use tempfile::TempDir;

use crate::{assert_refused, done, folder, has_device, inside, run};

/// Points on a grid of `sides` steps, each a line of text.
fn write_grid(folder: &TempDir, name: &str, sides: [u32; 3]) {
    let mut text = String::new();
    for i in 0..sides.iter().product() {
        let (x, y, z) = (i % sides[0], i / sides[0] % sides[1], i / sides[0] / sides[1]);
        writeln!(text, "{x} {y} {z}").unwrap();
    }
    fs::write(inside(folder, name), text).unwrap();
}

const SMALL: [&str; 6] = ["--size", "40x30", "--set", "method.name=points", "-o", "a.png"];

#[test]
fn the_camera_that_was_found_gives_its_picture_from_a_scene_file() {
    if !has_device() {
        return;
    }
    let folder = folder();
    write_grid(&folder, "a.xyz", [12, 10, 4]);
    for options in [&["--view", "south-west"][..], &["--azimuth", "SW", "--up", "-y"], &["--ortho", "--up", "x"]] {
        let (status, _, stderr) = run(&folder, &[&["-v", "render", "a.xyz"], &SMALL[..], options].concat());
        assert_eq!(status, 0, "{stderr}");
        let pixels = || read_image(&inside(&folder, "a.png")).unwrap().pixels;
        let picture = pixels();
        let lines: Vec<&str> = stderr
            .lines()
            .skip_while(|line| *line != "[camera]")
            .take_while(|line| !line.contains("points, "))
            .collect();
        let camera: Vec<&str> = lines.into_iter().filter(|line| *line == "[camera]" || line.contains(" = ")).collect();
        assert_eq!(camera.len(), 7, "{stderr}");
        let scene = format!("{}\n[[cloud]]\npath = 'a.xyz'\n", camera.join("\n"));
        fs::write(inside(&folder, "s.toml"), scene).unwrap();
        done(&folder, &[&["render", "s.toml"], &SMALL[..]].concat());
        assert!(pixels() == picture, "{options:?}");
    }
}

#[test]
fn a_compass_point_is_its_azimuth() {
    if !has_device() {
        return;
    }
    let folder = folder();
    write_grid(&folder, "a.xyz", [12, 10, 4]);
    let picture = |options: &[&str]| {
        done(&folder, &[&["render", "a.xyz"], &SMALL[..], options].concat());
        fs::read(inside(&folder, "a.png")).unwrap()
    };
    for (point, degrees) in [("SW", "-45"), ("north", "180"), ("ne", "135")] {
        assert!(picture(&["--azimuth", point]) == picture(&["--azimuth", degrees]), "{point}");
    }
    assert!(picture(&["--view", "south-west"]) == picture(&["--azimuth", "-45"]), "at the usual elevation");
    assert!(picture(&["--up", "y"]) != picture(&["--up", "-y"]));
    for wrong in [["--azimuth", "SSW"], ["--up", "w"], ["--up", "--y"]] {
        assert_refused(&folder, &[&["render", "a.xyz"], &wrong[..]].concat(), 2, &["expected"]);
    }
}

#[test]
fn wrong_guesses_are_noted() {
    if !has_device() {
        return;
    }
    let folder = folder();
    write_grid(&folder, "a.xyz", [20, 9, 20]);
    let noted = |options: &[&str]| run(&folder, &[&["render", "a.xyz"], &SMALL[..], options].concat()).2;
    let note = noted(&[]);
    assert!(note.contains("z is assumed to be up") && note.contains("--up y or --up -y"), "{note}");
    assert_eq!(noted(&["--up", "y"]), "");
    let alike = ["--up", "y", "--color-by", "uniform", "--background", "1,1,1"];
    assert!(noted(&alike).contains("color of the background"));
}

#[test]
fn the_vertical_of_a_ply_file_that_lies_is_z() {
    if !has_device() {
        return;
    }
    let folder = folder();
    write_grid(&folder, "a.xyz", [40, 40, 2]);
    let positions = fs::read_to_string(inside(&folder, "a.xyz")).unwrap();
    let header = "ply\nformat ascii 1.0\nelement vertex 3200\nproperty float x\nproperty float y\nproperty float z\nend_header\n";
    fs::write(inside(&folder, "a.ply"), format!("{header}{positions}")).unwrap();
    let picture = |file: &str, options: &[&str]| {
        let (status, _, stderr) = run(&folder, &[&["render", file], &SMALL[..], options].concat());
        assert_eq!(status, 0, "{stderr}");
        (stderr, read_image(&inside(&folder, "a.png")).unwrap().pixels)
    };
    let (note, lying) = picture("a.ply", &[]);
    assert!(
        note.starts_with("a.ply: the file does not say which axis is up")
            && note.contains("flattest along z (--up y changes that)"),
        "{note}"
    );
    assert!(lying == picture("a.xyz", &[]).1);
    for up in ["y", "z"] {
        let (note, asked) = picture("a.ply", &["--up", up]);
        assert!((asked == lying) == (up == "z") && !note.contains("which axis is up"), "{up}: {note}");
    }
}

#[test]
fn flat_clouds_of_any_format_lie() {
    if !has_device() {
        return;
    }
    let folder = folder();
    write_grid(&folder, "a.xyz", [40, 3, 40]);
    write_grid(&folder, "b.csv", [3, 40, 40]);
    let positions = fs::read_to_string(inside(&folder, "a.xyz")).unwrap();
    let header = "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 4800\nHEIGHT 1\nDATA ascii\n";
    fs::write(inside(&folder, "c.pcd"), format!("{header}{positions}")).unwrap();
    let picture = |file: &str, options: &[&str]| {
        let args = [&["render", file], &SMALL[..], options].concat();
        let (status, _, stderr) = run(&folder, &args);
        assert_eq!(status, 0, "{stderr}");
        (stderr, read_image(&inside(&folder, "a.png")).unwrap().pixels)
    };
    for (file, axis) in [("a.xyz", "y"), ("b.csv", "x"), ("c.pcd", "y")] {
        let (note, lying) = picture(file, &[]);
        let wanted = format!("{axis} is assumed, since its points are flattest along {axis} (--up z changes that)");
        assert!(note.contains(&wanted), "{note}");
        let (note, asked) = picture(file, &["--up", axis]);
        assert!(asked == lying && !note.contains("is assumed"), "{note}");
        assert!(picture(file, &["--up", "z"]).1 != lying);
    }
}

#[test]
fn outliers_are_counted_where_they_are_asked_for() {
    let folder = folder();
    write_grid(&folder, "a.xyz", [20, 20, 1]);
    let mut text = fs::read_to_string(inside(&folder, "a.xyz")).unwrap();
    text += "10 10 500\n";
    fs::write(inside(&folder, "a.xyz"), text).unwrap();
    let info = |options: &[&str]| run(&folder, &[&["info", "a.xyz"], options].concat()).1;
    assert!(info(&["--outliers"]).contains("\n  outliers    1\n"));
    assert!(!info(&[]).contains("outliers"));
    let json: serde_json::Value = serde_json::from_str(&info(&["--outliers", "--json"])).unwrap();
    assert_eq!((&json["outliers"], &json["points"]), (&1.into(), &401.into()));
}
