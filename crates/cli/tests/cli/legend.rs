//! `render --legend`: what is drawn where, and what is said where nothing is.

use std::fs;

use glam::DVec3;
use pellucid_core::cloud::Cloud;
use pellucid_io::output::read_image;

use crate::{builtin, device, done, folder, has_device, inside, run};

fn write_heights(path: &std::path::Path) {
    let positions = (0..400).map(|i| DVec3::new(f64::from(i % 20), f64::from(i / 20), f64::from(i % 7))).collect();
    pellucid_io::ply::write(path, &Cloud { positions, ..Cloud::default() }).unwrap();
}

/// Renders a picture of 320 × 240 pixels that a legend can explain; without options it has none.
fn heights(folder: &tempfile::TempDir, name: &str, options: &[&str]) {
    let plain = ["render", "a.ply", "--color-by", "z", "--ortho", "--size", "320x240", "-o", name];
    done(folder, &[&plain[..], options].concat());
}

#[test]
fn a_legend_covers_one_corner_and_nothing_else() {
    if !has_device() {
        return;
    }
    let folder = folder();
    write_heights(&inside(&folder, "a.ply"));
    heights(&folder, "plain.png", &[]);
    let with = |name, options: &[&str]| heights(&folder, name, &[&["--legend"], options].concat());
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
        let (status, _, stderr) = run(&folder, &[&["render", "--legend"], args, &device].concat());
        assert_eq!(status, 0, "{stderr}");
        stderr
    };
    assert!(said(&[&tori, "--size", "200x200", "-o", "tori.png"]).starts_with("--legend draws nothing"));
    assert_eq!(said(&["a.ply", "-o", "a.exr"]), "warning: --legend has no effect on an EXR; write a .png\n");
    let small = said(&["a.ply", "--size", "64x20", "-o", "small.png"]);
    assert_eq!(
        small,
        "--legend: a legend does not fit into 64 × 20 pixels, and is left out; a larger --size has room for it\n"
    );
    done(&folder, &["render", "a.ply", "--size", "64x20", "-o", "plain.png"]);
    assert_eq!(fs::read(inside(&folder, "small.png")).unwrap(), fs::read(inside(&folder, "plain.png")).unwrap());
}

#[test]
fn a_legend_beside_hides_nothing() {
    if !has_device() {
        return;
    }
    let folder = folder();
    write_heights(&inside(&folder, "a.ply"));
    heights(&folder, "plain.png", &[]);
    let with = |name, options: &[&str]| heights(&folder, name, &[&["--legend=beside"], options].concat());
    with("beside.png", &[]);
    with("clear.png", &["--transparent"]);
    with("turn_%d.png", &["--turntable", "--frames", "2"]);
    with("turn.gif", &["--turntable", "--frames", "2"]);

    let read = |name: &str| read_image(&inside(&folder, name)).unwrap();
    let (plain, beside) = (read("plain.png"), read("beside.png"));
    // 15 letters of 11 pixels, rounded up to an even number.
    let wide = 320 + 166;
    assert_eq!((beside.width as usize, beside.height as usize), (wide, 240));
    let kept = |i: usize| plain.pixels[i] == beside.pixels[i / 320 * wide + i % 320];
    assert!((0..320 * 240).all(kept));
    let column = (0..wide * 240).filter(|i| i % wide >= 320);
    assert!(column.filter(|i| beside.pixels[*i][0] > 0.5).count() > 100, "text and colors");
    for name in ["clear.png", "turn_0.png", "turn_1.png"] {
        assert_eq!(read(name).width as usize, wide, "{name}");
    }
    let gif = fs::read(inside(&folder, "turn.gif")).unwrap();
    assert_eq!(gif[6..10], [(wide % 256) as u8, (wide / 256) as u8, 240, 0]);
}
