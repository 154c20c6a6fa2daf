//! Recipes: `--preset`.

use std::fs;

use glam::{DVec3, Vec3};
use pellucid_core::cloud::Cloud;
use pellucid_io::output::read_image;
use tempfile::TempDir;

use crate::{assert_refused, device, folder, has_device, inside, run};

/// Red ground, green high vegetation and blue buildings, side by side.
fn scan(folder: &TempDir) {
    let cloud = Cloud {
        positions: (0..3).map(|i| DVec3::new(f64::from(i), 0.0, 0.0)).collect(),
        colors: Some(vec![Vec3::X, Vec3::Y, Vec3::Z]),
        classification: Some(vec![2, 5, 6]),
        radii: Some(vec![0.25; 3]),
        ..Cloud::default()
    };
    pellucid_io::ply::write(&inside(folder, "scan.ply"), &cloud).unwrap();
    let plain = Cloud { classification: None, ..cloud };
    pellucid_io::ply::write(&inside(folder, "plain.ply"), &plain).unwrap();
}

/// Renders a file with these options; the largest red, green and blue, and what was said.
fn picture(folder: &TempDir, file: &str, options: &[&str]) -> ([f32; 3], String) {
    let device = device();
    let device: Vec<&str> = device.iter().flat_map(|device| ["--device", device]).collect();
    let args = [&["render", file, "--size", "32x32", "-o", "out.exr"], options, &device].concat();
    let (code, _, stderr) = run(folder, &args);
    assert_eq!(code, 0, "{options:?}: {stderr}");
    let image = read_image(&inside(folder, "out.exr")).unwrap();
    fs::remove_file(inside(folder, "out.exr")).unwrap();
    let brightest = |channel: usize| image.pixels.iter().map(|pixel| pixel[channel]).fold(0.0, f32::max);
    ([0, 1, 2].map(brightest), stderr)
}

#[test]
fn the_list_needs_no_input() {
    let folder = folder();
    for command in ["render", "profile", "plan"] {
        let (code, list, stderr) = run(&folder, &[command, "--preset", "list"]);
        assert_eq!((code, stderr.as_str()), (0, ""), "{command}");
        for part in
            ["canopy: ", "building: ", "indoor: ", "heritage: ", "model: ", "\n  cloud.*.class += { id = \"ground\""]
        {
            assert!(list.contains(part), "{part:?}: {list}");
        }
    }
    assert_refused(
        &folder,
        &["render", "--preset", "roof", "-o", "a.png"],
        2,
        &["--preset", "unknown preset", "canopy"],
    );
}

#[test]
fn options_win_over_a_preset() {
    if !has_device() {
        return;
    }
    let folder = folder();
    scan(&folder);
    // By the list: ground 1, high vegetation 0.03, buildings 0.3.
    for (options, wanted) in [
        (&[][..], [1.0, 0.03, 0.3]),
        (&["--class", "high-vegetation=0.5"], [1.0, 0.5, 0.3]),
        (&["--set", "cloud.0.class=[]", "--opacity", "0.5"], [0.5; 3]),
        (&["--color-by", "uniform", "--classes", "6"], [0.3; 3]),
    ] {
        let (found, said) = picture(&folder, "scan.ply", &[&["--preset", "canopy"], options].concat());
        let off = found.iter().zip(wanted).map(|(found, wanted)| (found - wanted).abs()).fold(0.0, f32::max);
        assert!(off < 1e-3, "{options:?}: {found:?}");
        // A line for each key that was set.
        let first =
            "preset canopy:\n  cloud.*.opacity = 0.05, unless an option gives surface_opacity\n  cloud.*.radius_factor";
        assert!(said.starts_with(first) && said.lines().count() == 14, "{said}");
        assert!(said.lines().skip(1).all(|line| line.starts_with("  ")), "{said}");
    }
}

#[test]
fn every_preset_takes_the_opacity_of_a_surface() {
    if !has_device() {
        return;
    }
    let folder = folder();
    scan(&folder);
    for preset in ["canopy", "building", "indoor", "heritage"] {
        let (_, said) = picture(&folder, "plain.ply", &["--preset", preset, "--surface-opacity", "0.3"]);
        // None is looked for.
        assert!(!said.contains("trials"), "{said}");
    }
}

#[test]
fn every_preset_draws_with_classes_and_without() {
    if !has_device() {
        return;
    }
    let folder = folder();
    scan(&folder);
    for preset in ["canopy", "building", "indoor", "heritage", "model", "print"] {
        for file in ["scan.ply", "plain.ply"] {
            let (_, said) = picture(&folder, file, &["--preset", preset]);
            assert!(said.starts_with(&format!("preset {preset}:\n  ")), "{said}");
            // Classes with opacities of their own need none that is found.
            let finds = match preset {
                "model" | "print" => false,
                "canopy" | "building" => file == "plain.ply",
                _ => true,
            };
            assert_eq!(said.contains("\nsee-through 0."), finds, "{preset} {file}: {said}");
        }
        let (_, said) = picture(&folder, "plain.ply", &["--preset", preset, "--opacity", "0.5"]);
        assert!(!said.contains("\nsee-through 0."), "{said}");
    }
}
