//! `--samples`: the number that `auto` settles, what files and messages say of it, and what doesn't go with it.

use std::fs;

use pellucid_io::output::metadata;
use serde_json::Value;
use tempfile::TempDir;

use crate::render::exr;
use crate::{assert_refused, builtin, device, done, folder, has_device, inside, run};

const SAMPLES: &str = "pellucid:samples";

/// Runs a command on the test device and asserts that it succeeds; standard output and standard error.
#[track_caller]
fn spoken(folder: &TempDir, args: &[&str]) -> (String, String) {
    let device = device().unwrap_or_default();
    let more: &[&str] = if device.is_empty() { &[] } else { &["--device", &device] };
    let (status, stdout, stderr) = run(folder, &[args, more].concat());
    assert_eq!(status, 0, "{args:?}: {stderr}");
    (stdout, stderr)
}

/// Arguments of a small picture of the garden.
fn picture<'a>(more: &[&'a str]) -> Vec<&'a str> {
    [&["render", "garden/scene.toml", "--size", "48x36", "--method", "abuffer"], more].concat()
}

/// Returns the samples that a picture's metadata state.
fn told(folder: &TempDir, name: &str) -> Option<Value> {
    metadata(&inside(folder, name), SAMPLES).map(|text| serde_json::from_str(&text).unwrap())
}

/// RMSE of two pictures, as `pellucid compare` measures it.
fn rmse(folder: &TempDir, a: &str, b: &str) -> f64 {
    let json: Value = serde_json::from_str(&done(folder, &["compare", a, b, "--json"])).unwrap();
    json["rmse"].as_f64().unwrap()
}

#[track_caller]
fn assert_same_bits(folder: &TempDir, a: &str, b: &str) {
    let [a, b] = [a, b].map(|name| exr(&inside(folder, name)).0);
    assert!(a.keys().eq(b.keys()) && !a.is_empty());
    for (name, values) in &a {
        let same = values.iter().zip(&b[name]).all(|(a, b)| a.to_bits() == b.to_bits());
        assert!(same && values.len() == b[name].len(), "{name}");
    }
}

#[test]
fn auto_takes_the_first_picture_that_differs_little_from_the_one_before() {
    if !has_device() {
        return;
    }
    let folder = folder();
    builtin(&folder, "garden", &["points=3000"]);
    for count in ["1", "2", "4", "8"] {
        done(&folder, &picture(&["--samples", count, "-q", "-o", &format!("{count}.exr")]));
    }
    let [few, more] = [rmse(&folder, "4.exr", "2.exr"), rmse(&folder, "8.exr", "4.exr")];
    assert!(few > more && more > 0.0, "each doubling changes the picture less: {few}, {more}");
    for (limit, samples, error) in [(1.01 * few, 4, few), (1.01 * more, 8, more)] {
        let key = format!("image.sampling_error={limit}");
        let args = picture(&["--samples", "auto", "--set", &key, "-o", "auto.exr"]);
        let (_, said) = spoken(&folder, &args);
        assert!(said.contains(&format!("{samples} samples per pixel: {} differ", samples / 2)), "{said}");
        let found = told(&folder, "auto.exr").unwrap();
        assert_eq!(found["samples"], samples);
        let told = found["sampling_error"].as_f64().unwrap();
        assert!((told - error).abs() < 1e-9, "{told} and {error}");
        assert_same_bits(&folder, "auto.exr", &format!("{samples}.exr"));
    }
    assert_eq!(told(&folder, "1.exr"), None);
    assert_eq!(told(&folder, "4.exr"), Some(serde_json::json!({ "samples": 4 })));
}

#[test]
fn sixty_four_samples_that_are_too_few_are_a_warning() {
    if !has_device() {
        return;
    }
    let folder = folder();
    builtin(&folder, "garden", &["points=1000"]);
    let scene = ["render", "garden/scene.toml", "--size", "16x12", "--method", "points"];
    let more = ["--samples", "auto", "--set", "image.sampling_error=1e-7", "-o", "a.png"];
    let (_, said) = spoken(&folder, &[&scene[..], &more].concat());
    let warning = "warning: 64 samples per pixel, the most there are, differ from 32 by an RMSE of";
    assert!(said.contains(warning), "{said}");
    let found = told(&folder, "a.png").unwrap();
    assert!(found["samples"] == 64 && found["sampling_error"].as_f64().unwrap() > 1e-7, "{found}");
    assert!(said.contains("above image.sampling_error = 0.0000001"), "{said}");
}

#[test]
fn frames_of_a_film_have_the_samples_of_the_first_one() {
    if !has_device() {
        return;
    }
    let folder = folder();
    builtin(&folder, "garden", &["points=1000"]);
    let film =
        ["render", "garden/scene.toml", "--size", "48x36", "--turntable", "--frames", "3", "--method", "circles"];
    let auto = ["--samples", "auto", "--set", "image.sampling_error=0.05", "-o", "a_%d.exr"];
    let (_, said) = spoken(&folder, &[&film[..], &auto].concat());
    assert_eq!(said.matches("samples per pixel").count(), 1, "{said}");
    let first = told(&folder, "a_0.exr").unwrap();
    let samples = first["samples"].to_string();
    assert!(first["sampling_error"].as_f64().unwrap() <= 0.05);
    for number in 0..3 {
        let name = format!("a_{number}.exr");
        assert_eq!(told(&folder, &name).as_ref(), Some(&first), "{name}");
    }
    done(&folder, &[&film[..], &["--samples", &samples, "-q", "-o", "b_%d.exr"]].concat());
    for number in 0..3 {
        assert_same_bits(&folder, &format!("a_{number}.exr"), &format!("b_{number}.exr"));
    }
}

/// The contract: with `--see-through`, T is that of the mean image.
#[test]
fn the_median_pixel_of_the_mean_lets_half_of_the_light_through() {
    if !has_device() {
        return;
    }
    let folder = folder();
    builtin(&folder, "garden", &["points=20000"]);
    for samples in ["4", "auto"] {
        let args = ["--see-through", "0.5", "--samples", samples, "--set", "image.sampling_error=0.02", "-o", "t.exr"];
        let (_, said) = spoken(&folder, &picture(&args));
        assert_eq!(said.matches("see-through 0.5: opacit").count(), 1, "{said}");
        let (channels, ..) = exr(&inside(&folder, "t.exr"));
        let mut covered: Vec<f32> = channels["A"].iter().copied().filter(|a| *a > 0.0).collect();
        covered.sort_by(f32::total_cmp);
        let middle = covered[covered.len() / 2];
        assert!((middle - 0.5).abs() < 0.008, "{samples}: {middle}");
        let found: Value =
            serde_json::from_str(&metadata(&inside(&folder, "t.exr"), "pellucid:see-through").unwrap()).unwrap();
        assert!((found["transmittance"].as_f64().unwrap() - 0.5).abs() <= 0.004, "{found}");
    }
}

#[test]
fn counts_of_a_mean_are_means() {
    if !has_device() {
        return;
    }
    let folder = folder();
    builtin(&folder, "garden", &["points=3000"]);
    done(&folder, &picture(&["--samples", "4", "--aov", "-q", "-o", "a.exr"]));
    let (channels, ..) = exr(&inside(&folder, "a.exr"));
    let quarters: Vec<f32> = channels["fragments.Y"].iter().map(|count| 4.0 * count).collect();
    assert!(quarters.iter().all(|four| four.fract() == 0.0), "sums of 4 whole numbers");
    assert!(quarters.iter().any(|four| four % 4.0 != 0.0), "and no whole means");
}

#[test]
fn plans_and_profiles_say_how_many_images_there_are() {
    if !has_device() {
        return;
    }
    let folder = folder();
    builtin(&folder, "garden", &["points=1000"]);
    let scene = ["garden/scene.toml", "--size", "48x36", "--method", "sorted", "--samples", "4", "-q"];
    let plan = done(&folder, &[&["plan"], &scene[..]].concat());
    assert!(plan.contains("the mean of 4 images"), "{plan}");
    let table = done(&folder, &[&["profile", "--frames", "1"], &scene[..]].concat());
    assert!(table.contains("1728 pixels with 4 samples each (passes and fragments are those of 4 images)"), "{table}");
    let of = |samples: &str| -> Value {
        let args = [&["profile", "--frames", "1", "--json", "--samples", samples], &scene[..5], &["-q"]].concat();
        serde_json::from_str(&done(&folder, &args)).unwrap()
    };
    let runs = |profile: &Value| {
        let passes = profile["frames"][0]["passes"].as_array().unwrap().clone();
        let blend = passes.into_iter().find(|pass| pass["name"] == "sorted/blend").unwrap();
        blend["invocations"].as_f64().unwrap()
    };
    let [one, two] = ["1", "2"].map(of);
    assert_eq!((&one["scene"]["samples"], &two["scene"]["samples"]), (&1.into(), &2.into()));
    assert_eq!(runs(&two), 2.0 * runs(&one), "a pixel is blended once in each image");
}

#[test]
fn numbers_that_no_pixel_has_are_refused_with_those_it_may_have() {
    let folder = folder();
    fs::write(inside(&folder, "s.toml"), "[[cloud]]\npath = \"a.ply\"\n").unwrap();
    for number in ["3", "0", "-4", "128", "4.0", "many"] {
        let args = ["render", "s.toml", &format!("--samples={number}")];
        assert_refused(&folder, &args, 2, &["`image.samples` must be", "1, 2, 4, 8, 16, 32, 64 or \"auto\""]);
    }
    assert_refused(&folder, &["render", "s.toml", "--set", "image.sampling_error=0"], 2, &["image.sampling_error"]);
}

#[test]
fn deep_pictures_have_no_samples_of_an_area() {
    let folder = folder();
    let garden = builtin(&folder, "garden", &["points=1000"]);
    for samples in ["2", "auto"] {
        let args = ["render", &garden, "--deep", "-o", "a.exr", "--method", "abuffer", "-q", "--samples", samples];
        assert_refused(&folder, &args, 2, &["--deep", "image.samples", "--samples 1"]);
    }
}
