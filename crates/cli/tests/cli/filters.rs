//! Options that choose colors and leave points out: `--color-by`, `--class`, `--classes`, `--without`, `--slice`.

use std::fs;

use glam::{DVec3, Vec3};
use pellucid_core::cloud::Cloud;
use pellucid_io::output::read_image;
use tempfile::TempDir;

use crate::{assert_refused, done, folder, has_device, inside};

/// Red ground at z = 0, green high vegetation at 1, blue buildings at 2.
fn scan(folder: &TempDir) {
    let classes = [2u8, 5, 6];
    let cloud = Cloud {
        positions: (0..3).map(|i| DVec3::new(f64::from(i), 0.0, f64::from(i))).collect(),
        colors: Some(vec![Vec3::X, Vec3::Y, Vec3::Z]),
        classification: Some(classes.to_vec()),
        radii: Some(vec![0.25; 3]),
        ..Cloud::default()
    };
    pellucid_io::ply::write(&inside(folder, "scan.ply"), &cloud).unwrap();
}

/// The largest red, green and blue of the picture with these options.
fn picture(folder: &TempDir, options: &[&str]) -> [f32; 3] {
    let args = [&["render", "scan.ply", "--size", "32x32", "-o", "out.exr"], options].concat();
    done(folder, &args);
    let image = read_image(&inside(folder, "out.exr")).unwrap();
    fs::remove_file(inside(folder, "out.exr")).unwrap();
    let brightest = |channel: usize| image.pixels.iter().map(|pixel| pixel[channel]).fold(0.0, f32::max);
    [0, 1, 2].map(brightest)
}

#[test]
fn points_are_left_out_by_class_and_by_place() {
    if !has_device() {
        return;
    }
    let folder = folder();
    scan(&folder);
    for (options, wanted) in [
        (&[][..], [1.0; 3]),
        (&["--classes", "2,building"], [1.0, 0.0, 1.0]),
        (&["--without", "high-vegetation"], [1.0, 0.0, 1.0]),
        (&["--without", "5", "--slice", "z=1..", "--method", "points"], [0.0, 0.0, 1.0]),
        (&["--slice", "z=..1"], [1.0, 1.0, 0.0]),
        (&["--slice", "z=0.5..1.5", "--method", "hqs"], [0.0, 1.0, 0.0]),
        (&["--slice", "x=1..", "--slice", "x=..1"], [0.0, 1.0, 0.0]),
        (&["--class", "high-vegetation=0.25", "--class", "6=.5"], [1.0, 0.25, 0.5]),
        (&["--opacity", "0.5", "--class", "ground=1", "--set", "cloud.0.class=[]"], [0.5; 3]),
        (&["--color-by", "uniform", "--slice", "z=2.."], [1.0; 3]),
    ] {
        assert_eq!(picture(&folder, options), wanted, "{options:?}");
    }
}

#[test]
fn the_plan_says_which_colors_and_why() {
    if !has_device() {
        return;
    }
    let folder = folder();
    scan(&folder);
    for (options, wanted) in [
        (&[][..], "scan.ply is colored by rgb: the file has colors"),
        (&["--color-by", "height", "--colormap", "turbo"], "scan.ply is colored by height in turbo: it was asked for"),
        (&["--set", "cloud.0.color=[1,0,0]"], "scan.ply is colored by the scene's `color`"),
    ] {
        let plan = done(&folder, &[&["plan", "scan.ply", "--size", "32x32"], options].concat());
        assert!(plan.contains(wanted), "{plan}");
    }
}

#[test]
fn options_without_a_meaning_are_refused() {
    let folder = folder();
    scan(&folder);
    for (options, status, parts) in [
        (["--class", "grund=1"], 2, ["--class grund=1: unknown class \"grund\"", "ground"]),
        (["--class", "ground"], 2, ["--class ground", "NAME=OPACITY"]),
        (["--class", "2=2"], 2, ["--class 2=2", "from 0.0 to 1.0"]),
        (["--classes", "2,300"], 2, ["--classes 2,300", "unknown class \"300\""]),
        (["--slice", "z=4"], 2, ["--slice z=4", "AXIS=FROM..TO"]),
        (["--slice", "z=4..2"], 2, ["--slice z=4..2", "`min` of a slab"]),
        (
            ["--slice", "z=9.."],
            1,
            ["scan.ply: no point remains to draw: clips cut off all 3; the points extend over z 0.000 to 2.000", "\n"],
        ),
        (
            ["--without", "2,5,6"],
            1,
            [
                "scan.ply: no point remains to draw: hidden classes leave out all",
                "classes 2 (ground), 5 (high-vegetation), 6 (building)",
            ],
        ),
        (["--color-by", "hight"], 1, ["scan.ply: no scalar `hight`", "did you mean `height`"]),
        (["--color-by", "intensity"], 1, ["color_by = \"intensity\"", "the file has no intensity"]),
        (["--colormap", "viridi"], 2, ["--colormap viridi", "\"viridis\""]),
    ] {
        assert_refused(&folder, &[&["render", "scan.ply", "-o", "out.png"], &options[..]].concat(), status, &parts);
    }
}
