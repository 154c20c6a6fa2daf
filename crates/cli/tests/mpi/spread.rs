//! `--spread`: points in parts on all ranks, of which one alone has the files.

use std::fs;
use std::process::{Command, Output};

use pellucid_scene::METHODS;
use serde_json::Value;
use tempfile::TempDir;

use crate::{alone, assert_done, cloud, counts, folder, mpirun, ranks, read, with_environment};

/// A sphere's points in a store whose nodes have a few hundred of them, with radii and field.
fn store(folder: &TempDir) -> &'static str {
    let mut text = String::new();
    for i in 0..8_000 {
        // Evenly by the golden angle, some of them twice.
        let (z, angle) = (1.0 - 2.0 * (f64::from(i) + 0.5) / 8_000.0, 2.399_963_229_728_653 * f64::from(i));
        let across = (1.0 - z * z).sqrt();
        let line = format!("{} {} {z} {} 100 50\n", across * angle.cos(), across * angle.sin(), i % 256);
        (0..1 + i32::from(i % 50 == 0)).for_each(|_| text.push_str(&line));
    }
    fs::write(folder.path().join("sphere.xyz"), text).expect("a file");
    assert_done(&alone(folder, &["prepare", "sphere.xyz", "-o", "sphere/", "--node-points", "400", "-q"]), "prepare");
    "sphere/"
}

/// `render` of an input to a file.
fn render(input: &str, output: &str, more: &[&str]) -> Vec<String> {
    let fixed = ["render", input, "-o", output, "-q", "--size", "112x80"];
    fixed.iter().chain(more).map(|arg| (*arg).to_owned()).collect()
}

fn refs(args: &[String]) -> Vec<&str> {
    args.iter().map(String::as_str).collect()
}

/// Renders by one program and by so many ranks; those whose bytes differ.
fn differing(folder: &TempDir, input: &str, more: &[&str], counts: &[usize]) -> Vec<usize> {
    differing_in(folder, input, more, counts, &["--spread"])
}

/// Renders like [`differing`], with options for ranks.
fn differing_in(folder: &TempDir, input: &str, more: &[&str], counts: &[usize], of_ranks: &[&str]) -> Vec<usize> {
    assert_done(&alone(folder, &refs(&render(input, "one.exr", more))), &format!("{more:?}"));
    let one = read(folder, "one.exr");
    assert!(!one.is_empty());
    let differs = |count: &usize| {
        let name = format!("{count}.exr");
        let spread = [more, of_ranks].concat();
        let output = ranks(folder, *count, &refs(&render(input, &name, &spread))).output().expect("mpirun runs");
        assert_done(&output, &format!("{more:?} by {count}"));
        read(folder, &name) != one
    };
    counts.iter().copied().filter(differs).collect()
}

/// Methods that don't assign points to ensembles.
fn methods() -> impl Iterator<Item = &'static str> {
    METHODS.iter().copied().filter(|method| !method.starts_with("spbr"))
}

#[test]
fn every_method_has_the_same_bytes_from_spread_points() {
    let folder = folder();
    let cloud = cloud(&folder);
    let differ: Vec<_> = methods()
        .enumerate()
        .map(|(place, method)| {
            let more = ["--method", method, "--opacity", "0.4", "--aov"];
            (method, differing(&folder, cloud, &more, &counts(place)))
        })
        .filter(|(_, counts)| !counts.is_empty())
        .collect();
    assert!(differ.is_empty(), "{differ:?}");
}

#[test]
fn samples_of_a_pixels_area_have_the_same_bytes_from_spread_points() {
    let folder = folder();
    let cloud = cloud(&folder);
    for more in [
        &["--method", "points", "--samples", "4", "--set", "shading.edl=true", "--aov"][..],
        &["--method", "abuffer", "--opacity", "0.4", "--samples", "2", "--aov"],
        &["--method", "circles", "--samples", "auto", "--set", "image.sampling_error=0.03"],
    ] {
        assert_eq!(differing(&folder, cloud, more, &[3]), [0usize; 0], "{more:?}");
    }
}

#[test]
fn stores_are_read_by_one_rank_block_by_block() {
    let folder = folder();
    let store = store(&folder);
    let unlit = ["--set", "shading.model=none"];
    let differ: Vec<_> = methods()
        // `auto` chooses another method for points that stay in their files than for points in memory.
        .filter(|method| *method != "auto")
        .map(|method| {
            (method, differing(&folder, store, &[&["--method", method, "--opacity", "0.3"], &unlit[..]].concat(), &[3]))
        })
        .filter(|(_, counts)| !counts.is_empty())
        .collect();
    assert!(differ.is_empty(), "{differ:?}");
    for (name, more) in [
        // In several rounds.
        ("little memory", &["--memory-budget", "400KB", "--method", "abuffer"][..]),
        ("eye-dome lighting", &["--set", "shading.edl=true", "--method", "circles"]),
        ("see-through", &["--see-through", "0.5", "--method", "sorted"]),
        ("heights", &["--ortho", "--method", "weighted", "--color-by", "height"]),
    ] {
        let more = [more, &unlit].concat();
        assert_eq!(differing(&folder, store, &more, &[1, 2, 4]), [0usize; 0], "{name}");
    }
}

#[test]
fn ranks_read_only_the_nodes_that_their_windows_show() {
    let folder = folder();
    store(&folder);
    // An automatic camera looks at nodes, too.
    let scene = "[[cloud]]\npath = \"sphere/\"\nopacity = 0.3\n[method]\nname = \"abuffer\"\n[shading]\nmodel = \"none\"\n[camera]\n\
                 eye = [0, -4, 0]\ntarget = [0, 0, 0]\nup = [0, 0, 1]\nfov_y = 40\nnear = 1\nfar = 10\n";
    fs::write(folder.path().join("scene.toml"), scene).expect("a file");
    assert_eq!(differing_in(&folder, "scene.toml", &[], &[2], &[]), [0usize; 0]);
    let args = render("scene.toml", "two.exr", &["--profile", "p.json"]);
    let args: Vec<String> = args.into_iter().map(|arg| if arg == "-q" { "-v".to_owned() } else { arg }).collect();
    let output = ranks(&folder, 2, &refs(&args)).output().expect("mpirun");
    assert_done(&output, "two");
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    let share = said
        .lines()
        .find_map(|line| line.split_once("were read for the picture (")?.1.split_once(" %")?.0.parse::<f64>().ok());
    let share = share.unwrap_or_else(|| panic!("{said}"));
    assert!((20.0..80.0).contains(&share), "the first rank read {share} %");
    let profile: Value = serde_json::from_slice(&read(&folder, "p.json")).expect("JSON");
    let ranks = profile["ranks"]["frames"][0]["ranks"].as_array().expect("ranks");
    let bytes: Vec<f64> = ranks.iter().map(|rank| rank["read"].as_f64().expect("bytes")).collect();
    let all = bytes[0] / (share / 100.0);
    assert!(bytes[1] > 0.2 * all && bytes[1] < 0.8 * all, "{bytes:?} of {all}");
}

#[test]
fn gaussians_and_built_in_scenes_are_spread() {
    let folder = folder();
    let splats = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data/splats/");
    let mut files: Vec<_> = fs::read_dir(splats).expect("a folder").flatten().map(|file| file.path()).collect();
    files.sort();
    let splats: Vec<_> = files.iter().filter(|file| file.extension().is_some_and(|e| e == "ply")).collect();
    for file in splats.iter().take(2) {
        let file = file.to_str().expect("a name");
        for method in ["abuffer", "sorted"] {
            assert_eq!(differing(&folder, file, &["--method", method], &[1, 3]), [0usize; 0], "{file} {method}");
        }
    }
    fs::write(folder.path().join("empty.txt"), "").expect("a file");
    let built_in = |output: &str, more: &[&str]| {
        let fixed = ["render", "-o", output, "-q", "--size", "64x64"];
        fixed.iter().chain(more).map(|arg| (*arg).to_owned()).collect::<Vec<_>>()
    };
    assert_done(&alone(&folder, &refs(&built_in("one.png", &[]))), "one");
    assert_done(&ranks(&folder, 2, &refs(&built_in("two.png", &["--spread"]))).output().expect("mpirun"), "two");
    assert_eq!(read(&folder, "one.png"), read(&folder, "two.png"));
}

/// Three ranks, of which only the first is where the files are.
fn apart(folder: &TempDir, args: &[&str]) -> Output {
    let nowhere = tempfile::tempdir().expect("a folder");
    let mut command = Command::new(mpirun());
    with_environment(&mut command, folder);
    for (number, place) in [(1, folder), (2, &nowhere)] {
        if number > 1 {
            command.arg(":");
        }
        command.args(["-n", &number.to_string(), "-wdir"]).arg(place.path());
        command.arg(env!("CARGO_BIN_EXE_pellucid-mpi")).args(args);
    }
    let output = command.output().expect("mpirun runs");
    assert!(fs::read_dir(&nowhere).expect("a folder").next().is_none(), "another rank wrote something");
    output
}

#[test]
fn other_ranks_need_no_files() {
    let folder = folder();
    let (cloud, store) = (cloud(&folder), store(&folder));
    for (input, more) in
        [(cloud, &["--method", "sorted"][..]), (store, &["--method", "hqs", "--set", "shading.model=none"])]
    {
        assert_done(&alone(&folder, &refs(&render(input, "one.png", more))), input);
        let args = render(input, "three.png", &[more, &["--spread"]].concat());
        assert_done(&apart(&folder, &refs(&args)), input);
        assert_eq!(read(&folder, "one.png"), read(&folder, "three.png"), "{input}");
        let without = apart(&folder, &refs(&render(input, "none.png", more)));
        assert!(!without.status.success(), "the other ranks see no files");
    }
    let args = ["render", store, "--turntable", "--frames=3", "-q", "--size", "48x48", "--spread", "-o", "b_%02d.png"];
    assert_done(&apart(&folder, &args), "frames");
    let args = ["render", store, "--turntable", "--frames=3", "-q", "--size", "48x48", "-o", "a_%02d.png"];
    assert_done(&alone(&folder, &args), "frames");
    for number in 0..3 {
        let picture = |name: &str| {
            let file = fs::File::open(folder.path().join(format!("{name}_{number:02}.png"))).expect("a file");
            let mut reader = png::Decoder::new(std::io::BufReader::new(file)).read_info().expect("a picture");
            let mut pixels = vec![0; reader.output_buffer_size().expect("a size")];
            reader.next_frame(&mut pixels).expect("pixels");
            pixels
        };
        // Their metadata name other points: all of them, or those that stand for them.
        assert_eq!(picture("a"), picture("b"), "frame {number}");
    }
}

#[test]
fn a_profile_tells_what_ranks_sent() {
    let folder = folder();
    let store = store(&folder);
    let args =
        ["profile", store, "--frames", "1", "--json", "-q", "--method", "circles", "--size", "96x96", "--spread"];
    let output = ranks(&folder, 3, &[&args[..], &["--set", "shading.model=none"]].concat()).output().expect("mpirun");
    assert_done(&output, "profile");
    let report: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let dealt = &report["ranks"]["spread"];
    let points: Vec<u64> = dealt["points"].as_array().expect("numbers").iter().filter_map(Value::as_u64).collect();
    assert_eq!((points.len(), points.iter().sum::<u64>()), (3, 8_160));
    assert!(points.iter().all(|points| (2_000..4_000).contains(points)), "{points:?}");
    assert!(dealt["read"].as_u64().expect("bytes") > 8_160 * 12 && dealt["sent"].as_u64().expect("bytes") > 5_000 * 44);
    for rank in report["ranks"]["frames"][0]["ranks"].as_array().expect("ranks") {
        assert!(rank["sent"].as_u64() > Some(1000) && rank["received"].as_u64() > Some(1000), "{rank}");
        assert_eq!(rank["read"].as_u64(), Some(0));
    }
}

#[test]
fn settings_that_need_all_points_are_refused() {
    let folder = folder();
    let cloud = cloud(&folder);
    for (more, wanted) in [
        (&["--method", "spbr"][..], "ensembles"),
        (&["--set", "shadows.samples=4", "--set", "shading.light=[0,0,-1]", "--method", "circles"], "shadows"),
        (&["--share", "frames"], "--share windows"),
        (&["--share", "ensembles"], "--share windows"),
        (&["--detail", "2"], "left out"),
    ] {
        let args = render(cloud, "none.png", &[more, &["--spread"]].concat());
        let output = ranks(&folder, 2, &refs(&args)).output().expect("mpirun");
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        let errors: Vec<&str> = said.lines().filter(|line| line.starts_with("error:")).collect();
        assert!(!output.status.success() && errors.len() == 1, "{more:?}: {said}");
        assert!(errors[0].contains("--spread") && errors[0].contains(wanted), "{said}");
        assert!(!folder.path().join("none.png").exists());
    }
    let missing = ranks(&folder, 2, &["render", "nothing.las", "--spread", "-o", "none.png"]).output().expect("mpirun");
    assert!(
        !missing.status.success() && String::from_utf8_lossy(&missing.stderr).contains("nothing.las: no such file")
    );
}
