//! Pictures: both formats, their metadata, every method and option, the same bytes again.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use exr::prelude::{AttributeValue, Text, read_first_flat_layer_from_file};
use pellucid_io::output::read_image;

use crate::{builtin, done, folder, has_device, inside, run};

/// Keys of the metadata, in the order of the interface.
const KEYS: [&str; 6] = ["scene", "method", "settings", "device", "version", "seed"];

/// Color type, bytes and text chunks of a PNG.
pub fn png(path: &Path) -> (png::ColorType, Vec<u8>, BTreeMap<String, String>) {
    let mut reader = png::Decoder::new(std::io::BufReader::new(fs::File::open(path).unwrap())).read_info().unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut bytes).unwrap();
    let chunks = reader.info();
    let latin = chunks.uncompressed_latin1_text.iter().map(|t| (t.keyword.clone(), t.text.clone()));
    let utf8 = chunks.utf8_text.iter().map(|t| (t.keyword.clone(), t.get_text().unwrap()));
    (info.color_type, bytes, latin.chain(utf8).collect())
}

/// Channels by name, and the text attributes, of an EXR.
pub fn exr(path: &Path) -> (BTreeMap<String, Vec<f32>>, BTreeMap<String, String>) {
    let picture = read_first_flat_layer_from_file(path).unwrap();
    let channels = picture.layer_data.channel_data.list.iter();
    let channels = channels.map(|c| (c.name.to_string(), c.sample_data.values_as_f32().collect())).collect();
    let attributes = picture.attributes.other.iter().chain(&picture.layer_data.attributes.other);
    let text = attributes.filter_map(|(name, value): (&Text, _)| match value {
        AttributeValue::Text(text) => Some((name.to_string(), text.to_string())),
        _ => None,
    });
    (channels, text.collect())
}

#[test]
fn both_formats_with_metadata_and_the_same_bytes_again() {
    if !has_device() {
        return;
    }
    let folder = folder();
    let tori = builtin(&folder, "tori", &["points=2000"]);
    let names = ["a.png", "b.png", "a.exr", "b.exr"];
    for name in names {
        let aov: &[&str] = if name.ends_with("exr") { &["--aov"] } else { &[] };
        let args = [&["render", &tori, "--size", "64x48", "--seed", "7", "-o", name], aov].concat();
        assert_eq!(done(&folder, &args), "", "{name}: nothing on standard output");
    }
    let [a_png, b_png, a_exr, b_exr] = names.map(|name| inside(&folder, name));
    assert!(fs::read(&a_png).unwrap() == fs::read(b_png).unwrap(), "the same PNG");
    assert!(fs::read(&a_exr).unwrap() == fs::read(b_exr).unwrap(), "the same EXR");

    let (color, bytes, of_png) = png(&a_png);
    assert_eq!((color, bytes.len()), (png::ColorType::Rgb, 64 * 48 * 3));
    let (channels, of_exr) = exr(&a_exr);
    let found: Vec<_> = channels.keys().map(String::as_str).collect();
    assert_eq!(found, ["A", "B", "G", "R", "Z", "depth.mean", "depth.median", "fragments.Y"]);
    let keys: Vec<_> = KEYS.iter().map(|key| format!("pellucid:{key}")).collect();
    for key in &keys {
        assert!(of_png.contains_key(key), "{key} in {of_png:?}");
        assert_eq!(of_png.get(key), of_exr.get(key), "{key}");
    }
    let values = ["scene", "method", "version", "seed"].map(|key| of_png[&format!("pellucid:{key}")].as_str());
    assert_eq!(values, [tori.as_str(), "abuffer", env!("CARGO_PKG_VERSION"), "7"]);

    // Where nothing was drawn: no list, no alpha, no depth; elsewhere all three.
    let mut covered = 0;
    for ((length, alpha), z) in channels["fragments.Y"].iter().zip(&channels["A"]).zip(&channels["Z"]) {
        assert_eq!(*length > 0.0, *alpha > 0.0);
        assert_eq!(*length > 0.0, z.is_finite());
        covered += usize::from(*length > 0.0);
    }
    assert!((500..2500).contains(&covered), "{covered} of 3072 pixels are covered");
}

#[test]
fn depths_of_exact_methods_are_channels() {
    if !has_device() {
        return;
    }
    let folder = folder();
    let tori = builtin(&folder, "tori", &["points=2000"]);
    let render = |more: &[&str]| {
        done(&folder, &[&["render", &tori, "--size", "64x48", "--opacity", "0.4", "-o", "a.exr"], more].concat());
        exr(&inside(&folder, "a.exr")).0
    };
    let flat = ["--aov", "--set", "method.shape=flat"];
    let all = render(&[&["--method", "abuffer"], &flat[..]].concat());
    let (mut halves, mut apart) = (0, 0);
    for (i, alpha) in all["A"].iter().enumerate() {
        let [first, median, mean] = ["Z", "depth.median", "depth.mean"].map(|channel| all[channel][i]);
        // The first fragment lets through 0.6 of the light; from the second on it is 0.36.
        assert_eq!(median.is_finite(), *alpha >= 0.5, "pixel {i}");
        assert_eq!(mean.is_finite(), *alpha > 0.0, "pixel {i}");
        assert!(first <= median && first <= mean * 1.000_001, "pixel {i}: {first} {median} {mean}");
        halves += usize::from(median.is_finite());
        apart += usize::from(median.is_finite() && median > first && (mean - median).abs() > 0.01);
    }
    assert!(halves > 500 && apart > 100, "{halves} medians, {apart} of them apart from the first depth and the mean");
    for method in ["linked-list", "peel", "sorted"] {
        let other = render(&[&["--method", method], &flat[..]].concat());
        assert!(["depth.median", "depth.mean"].iter().all(|channel| other[*channel] == all[*channel]), "{method}");
    }
    let has = |args: &[&str]| render(args).contains_key("depth.median");
    assert!(!has(&["--method", "abuffer"]) && !has(&["--method", "abuffer", "--profile", "p.json"]));
    assert!(!has(&["--method", "stochastic", "--aov"]));
    assert!(!has(&["--method", "peel", "--set", "method.layers=2", "--aov"]));
}

#[test]
fn every_method_gives_its_picture() {
    if !has_device() {
        return;
    }
    let folder = folder();
    let tori = builtin(&folder, "tori", &["points=2000"]);
    let mut pictures = BTreeMap::new();
    for method in ["points", "circles", "squares", "abuffer", "peel", "auto"] {
        let output = format!("{method}.exr");
        // Quiet: keys of abuffer are a warning for the others.
        let mut args = vec!["render", &tori, "-q", "--size", "64x64", "--method", method, "-o", &output];
        args.extend(["--opacity", "1", "--set", "method.shape=flat", "--set", "method.falloff=flat"]);
        done(&folder, &args);
        let (channels, metadata) = exr(&inside(&folder, &output));
        let taken = if method == "auto" { "circles" } else { method };
        assert_eq!(metadata["pellucid:method"], taken);
        pictures.insert(method, channels);
    }
    let covered = |method| pictures[method]["A"].iter().filter(|a| **a > 0.0).count();
    let counts = ["points", "circles", "squares"].map(covered);
    assert!(counts[0] < counts[1] && counts[1] < counts[2], "a disc holds its point, a square its disc: {counts:?}");
    // Opaque discs: the nearest decides, so that the methods agree, and `auto` may take the cheaper one.
    for (channel, values) in &pictures["abuffer"] {
        for other in ["auto", "peel"] {
            assert!(values.iter().zip(&pictures[other][channel]).all(|(a, b)| a == b), "{channel} of {other}");
        }
    }
}

#[test]
fn standard_errors_are_channels_and_the_seed_decides() {
    if !has_device() {
        return;
    }
    let folder = folder();
    let tori = builtin(&folder, "tori", &["points=2000"]);
    let render = |more: &[&str]| {
        let args = ["render", &tori, "--size", "64x48", "--method", "stochastic", "--opacity", "0.5", "-o", "a.exr"];
        done(&folder, &[&args[..], more].concat());
        exr(&inside(&folder, "a.exr")).0
    };
    let (first, again, other) = (render(&["--aov"]), render(&["--aov"]), render(&["--aov", "--seed", "9"]));
    for channel in ["R", "A", "stderr.R", "stderr.G", "stderr.B", "fragments.Y"] {
        assert_eq!(first[channel], again[channel], "{channel}");
    }
    assert!(first["R"] != other["R"] && first["A"] == other["A"], "A is exact");
    let most = first["stderr.R"].iter().copied().fold(0.0, f32::max);
    assert!((0.01..0.5).contains(&most), "{most}");
    assert!(!render(&[]).contains_key("stderr.R") && !render(&["--profile", "p.json"]).contains_key("stderr.R"));
}

#[test]
fn peeled_layers_are_a_channel() {
    if !has_device() {
        return;
    }
    let folder = folder();
    let tori = builtin(&folder, "tori", &["points=2000"]);
    let render = |layers: &str, more: &[&str]| {
        let args = [
            "render",
            &tori,
            "--size",
            "64x48",
            "--method",
            "peel",
            "--opacity",
            "0.5",
            "-o",
            "a.exr",
            "--set",
            layers,
        ];
        done(&folder, &[&args[..], more].concat());
        exr(&inside(&folder, "a.exr")).0
    };
    let all = render("method.layers=0", &["--aov"]);
    assert_eq!(all["layers.Y"], all["fragments.Y"], "nothing is opaque");
    let two = render("method.layers=2", &["--aov"]);
    assert_eq!(two["fragments.Y"], all["fragments.Y"]);
    assert!(two["layers.Y"].iter().zip(&all["layers.Y"]).all(|(some, all)| *some == all.min(2.0)));
    // A profile counts, but writes no channel.
    let plain = render("method.layers=0", &["--profile", "p.json"]);
    assert!(!plain.contains_key("layers.Y") && !plain.contains_key("fragments.Y"), "{:?}", plain.keys());
}

#[test]
fn options_reach_the_picture() {
    if !has_device() {
        return;
    }
    let folder = folder();
    let tori = builtin(&folder, "tori", &["points=2000"]);
    let render = |output: &str, args: &[&str]| {
        done(&folder, &[&["render", &tori, "-q", "--size", "40x30", "-o", output], args].concat());
        inside(&folder, output)
    };
    let plain = render("plain.png", &[]);
    let (color, bytes, _) = png(&render("transparent.png", &["--transparent"]));
    assert_eq!((color, bytes.len()), (png::ColorType::Rgba, 40 * 30 * 4));
    assert_eq!(bytes[..4], [0; 4], "nothing in the corner");
    let alphas: Vec<_> = bytes.chunks(4).map(|pixel| pixel[3]).collect();
    assert!(alphas.iter().any(|a| (1..255).contains(a)) && alphas.iter().filter(|a| **a > 0).count() > 200);

    let size = |path| read_image(path).map(|image| (image.width, image.height)).unwrap();
    assert_eq!(size(&plain), (40, 30));
    assert_eq!(size(&render("set.png", &["--set", "image.size=[7, 9]"])), (7, 9), "--set comes after --size");
    let (_, bytes, _) = png(&render("clear.png", &["--opacity", "0", "--background", "0,1,.2158605"]));
    // 128/255 in sRGB is 0.2158605.
    assert!(bytes.chunks(3).all(|pixel| pixel == [0, 255, 128]), "only the background is left");
    let (_, bytes, _) = png(&render("white.png", &["--opacity", "0", "--background", "white"]));
    assert!(bytes.iter().all(|value| *value == 255));
    for (name, args) in [
        ("view", ["--view", "top"]),
        ("turned", ["--azimuth", "-50"]),
        ("raised", ["--elevation", "80"]),
        ("radius", ["--radius", "0.2"]),
        ("lit", ["--set", "shading.model=none"]),
        ("gaussian", ["--set", "method.falloff=flat"]),
    ] {
        let other = render(&format!("{name}.png"), &args);
        assert!(read_image(&other).unwrap() != read_image(&plain).unwrap(), "{args:?} changes the picture");
    }
}

#[test]
fn the_default_scene_is_the_garden_that_scene_writes() {
    if !has_device() {
        return;
    }
    let folder = folder();
    done(&folder, &["render", "--size", "48x32"]);
    let (_, embedded, mut expected) = png(&inside(&folder, "garden.png"));
    let garden = builtin(&folder, "garden", &[]);
    done(&folder, &["render", &garden, "--size", "48x32", "-o", "written.png"]);
    let (_, written, mut found) = png(&inside(&folder, "written.png"));
    assert!(embedded == written, "the same pixels");
    assert_eq!(expected.insert("pellucid:scene".into(), garden.clone()).as_deref(), Some("garden"));
    // Paths of the clouds are relative to the scene file and may be spelled out.
    let settings = [&mut expected, &mut found].map(|metadata| metadata.remove("pellucid:settings").unwrap());
    assert_eq!(expected, found);
    assert_eq!(settings[0], settings[1]);
    let colors: std::collections::BTreeSet<_> = embedded.chunks(3).collect();
    assert!(colors.len() > 300, "a picture and not a plane: {} colors", colors.len());
}

/// A grid of 20 × 20 points of this gray in a file.
fn write_gray(folder: &Path, name: &str, gray: u8) {
    let points = (0..400).map(|i| format!("{} {} 0 {gray} {gray} {gray}\n", i % 20, i / 20));
    let colors = "property uchar red\nproperty uchar green\nproperty uchar blue\n";
    let places = "property float x\nproperty float y\nproperty float z\n";
    let header = format!("ply\nformat ascii 1.0\nelement vertex 400\n{places}{colors}end_header\n");
    fs::write(folder.join(name), header + &points.collect::<String>()).unwrap();
}

#[test]
fn dark_clouds_lie_on_white_and_others_on_black() {
    if !has_device() {
        return;
    }
    let folder = folder();
    // sRGB 40 is 0.021 in linear light, 70 is 0.061.
    write_gray(folder.path(), "dark.ply", 40);
    write_gray(folder.path(), "bright.ply", 70);
    fs::write(folder.path().join("s.toml"), "[[cloud]]\npath = 'dark.ply'\n").unwrap();
    fs::write(folder.path().join("auto.toml"), "image = { background = 'auto' }\n[[cloud]]\npath = 'dark.ply'\n")
        .unwrap();
    let corner = |args: &[&str]| {
        let (status, _, stderr) = run(&folder, &[&["render", "-v", "--size", "48x32", "-o", "a.png"], args].concat());
        assert_eq!(status, 0, "{stderr}");
        let (_, bytes, mut tags) = png(&inside(&folder, "a.png"));
        let said = stderr.contains("the background is white").then_some("white");
        let said = said.or(stderr.contains("the background is black").then_some("black"));
        assert_eq!(tags.remove("pellucid:background").as_deref(), said, "{args:?}");
        (bytes[0], said)
    };
    for (args, wanted) in [
        (&["dark.ply"] as &[&str], (255, Some("white"))),
        (&["bright.ply"], (0, Some("black"))),
        (&["dark.ply", "bright.ply", "bright.ply"], (0, Some("black"))),
        (&["dark.ply", "--color-by", "uniform"], (0, Some("black"))),
        (&["bright.ply", "--set", "cloud.*.color=[0.01, 0.01, 0.01]"], (255, Some("white"))),
        (&["dark.ply", "--background", "black"], (0, None)),
        (&["s.toml"], (0, None)),
        (&["s.toml", "--background", "auto"], (255, Some("white"))),
        (&["auto.toml"], (255, Some("white"))),
        // Only the dark ones are drawn.
        (
            &[
                "dark.ply",
                "bright.ply",
                "bright.ply",
                "--set",
                "cloud.1.translate=[0, 0, 50]",
                "--set",
                "cloud.2.translate=[0, 0, 50]",
                "--slice",
                "z=..9",
            ],
            (255, Some("white")),
        ),
    ] {
        assert_eq!(corner(args), wanted, "{args:?}");
    }
}

#[test]
fn a_small_memory_budget_changes_no_byte() {
    if !has_device() {
        return;
    }
    let folder = folder();
    // 64 × 64 pixels of 300 fragments: 4.7 MiB of ordered lists.
    let stack = builtin(&folder, "stack", &["layers=300", "size=64"]);
    done(&folder, &["render", &stack, "-o", "all.exr", "--aov", "--profile", "all.json"]);
    done(
        &folder,
        &["render", &stack, "-o", "bands.exr", "--aov", "--memory-budget", "1MiB", "--profile", "bands.json"],
    );
    assert!(fs::read(inside(&folder, "all.exr")).unwrap() == fs::read(inside(&folder, "bands.exr")).unwrap());
    let memory = |name: &str| {
        let text = fs::read_to_string(inside(&folder, name)).unwrap();
        let profile: serde_json::Value = serde_json::from_str(&text).unwrap();
        assert_eq!(profile["scene"]["fragments"], 64 * 64 * 300);
        let number = |key: &str| profile["memory"][key].as_u64().unwrap();
        (number("bands"), number("fragment_bytes"))
    };
    let (all, bands) = (memory("all.json"), memory("bands.json"));
    assert_eq!(all.0, 1);
    assert!(bands.0 > 8 && bands.1 <= 1 << 20, "{bands:?} of {all:?}");
}
