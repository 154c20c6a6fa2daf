//! `render --legend`: what is drawn where, and what is said where nothing is.

use std::fs;

use glam::DVec3;
use pellucid_core::cloud::Cloud;
use pellucid_io::output::read_image;

use crate::{assert_refused_with_device, builtin, device, done, folder, has_device, inside, run};

fn write_heights(path: &std::path::Path) {
    let positions = (0..400).map(|i| DVec3::new(f64::from(i % 20), f64::from(i / 20), f64::from(i % 7))).collect();
    pellucid_io::ply::write(path, &Cloud { positions, ..Cloud::default() }).unwrap();
}

#[test]
fn a_legend_covers_one_corner_and_nothing_else() {
    if !has_device() {
        return;
    }
    let folder = folder();
    write_heights(&inside(&folder, "a.ply"));
    let plain = ["render", "a.ply", "--color-by", "z", "--ortho", "--size", "320x240", "-o", "plain.png"];
    done(&folder, &plain);
    let with = |name, options: &[&str]| done(&folder, &[&plain[..8], &[name, "--legend"], options].concat());
    with("explained.png", &[]);
    with("again.png", &["--transparent"]);
    with("turn_%d.png", &["--turntable", "--frames", "2"]);
    let frames = ["turn_0.png", "turn_1.png"].map(|name| fs::read(inside(&folder, name)).unwrap());
    assert_ne!(frames[0], frames[1]);

    let [plain, explained] = ["plain.png", "explained.png"].map(|name| read_image(&inside(&folder, name)).unwrap());
    let differ: Vec<usize> = (0..320 * 240).filter(|i| plain.pixels[*i] != explained.pixels[*i]).collect();
    assert!(differ.len() > 1000, "{} pixels", differ.len());
    // A third of 320 columns, behind a margin of 7.
    assert!(differ.iter().all(|i| (7..7 + 107).contains(&(i % 320)) && i / 320 < 240 - 7));
    let metadata = |name| pellucid_io::output::metadata(&inside(&folder, name), "pellucid:settings");
    assert_eq!(metadata("plain.png"), metadata("explained.png"));
}

#[test]
fn pictures_without_a_legend_say_so() {
    if !has_device() {
        return;
    }
    let folder = folder();
    write_heights(&inside(&folder, "a.ply"));
    let tori = builtin(&folder, "tori", &["points=500"]);
    let device = device();
    let device: Vec<&str> = device.iter().flat_map(|name| ["--device", name.as_str()]).collect();
    let said = |args: &[&str]| {
        let (status, _, stderr) = run(&folder, &[&["render", "--size", "200x200", "--legend"], args, &device].concat());
        assert_eq!(status, 0, "{stderr}");
        stderr
    };
    assert!(said(&[&tori, "-o", "tori.png"]).starts_with("--legend draws nothing"));
    assert_eq!(said(&["a.ply", "-o", "a.exr"]), "warning: --legend has no effect on an EXR; write a .png\n");
    let small = ["render", "a.ply", "--size", "120x90", "--legend", "-o", "small.png"];
    assert_refused_with_device(&folder, &small, 2, &["--legend", "120 × 90", "each side must have at least 160"]);
}
