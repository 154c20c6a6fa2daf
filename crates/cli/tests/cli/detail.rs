//! `--detail` and `--max-points`: what they draw, what the picture says of it, and what they refuse.

use std::fs;

use serde_json::Value;
use tempfile::TempDir;

use crate::gaussians::write_splats;
use crate::{assert_refused, builtin, done, folder, has_device, inside, run, write_cloud};

/// A sphere's points in a store whose nodes have a thousand of them, with radii.
fn store(folder: &TempDir) {
    let mut text = String::new();
    for i in 0..20_000 {
        // Evenly by the golden angle.
        let (z, angle) = (1.0 - 2.0 * (f64::from(i) + 0.5) / 20_000.0, 2.399_963_229_728_653 * f64::from(i));
        let across = (1.0 - z * z).sqrt();
        text.push_str(&format!("{} {} {z} 200 100 50\n", across * angle.cos(), across * angle.sin()));
    }
    fs::write(inside(folder, "sphere.xyz"), text).unwrap();
    done(folder, &["prepare", "sphere.xyz", "-o", "sphere/", "--node-points", "1000"]);
}

fn about(folder: &TempDir, file: &str) -> Option<Value> {
    let text = pellucid_io::output::metadata(&inside(folder, file), "pellucid:detail")?;
    Some(serde_json::from_str(&text).unwrap())
}

#[test]
fn pictures_do_with_fewer_points_and_say_so() {
    if !has_device() {
        return;
    }
    let folder = folder();
    store(&folder);
    let render = |input: &str, output: &str, options: &[&str]| {
        let fixed =
            ["render", input, "-o", output, "--size", "64x64", "--set", "shading.model=none", "--method", "circles"];
        let args = [&fixed[..], options].concat();
        done(&folder, &args);
    };
    render("sphere/", "all.exr", &[]);
    assert!(about(&folder, "all.exr").is_none());
    render("sphere.xyz", "coarse.exr", &["--detail", "3"]);
    let coarse = about(&folder, "coarse.exr").unwrap();
    assert_eq!(
        (coarse["spacing_px"].as_f64(), coarse["cut_px"].as_f64(), coarse["of"].as_u64()),
        (Some(3.0), Some(3.0), Some(20_000))
    );
    assert!(coarse["points"].as_u64().unwrap() < 10_000, "{coarse}");
    let settings = pellucid_io::output::metadata(&inside(&folder, "coarse.exr"), "pellucid:settings").unwrap();
    assert!(settings.contains("spacing_px"), "{settings}");
    render("sphere/", "few.exr", &["--max-points", "9000"]);
    let few = about(&folder, "few.exr").unwrap();
    assert!(few["points"].as_u64().unwrap() <= 9000 && few["cut_px"].as_f64().unwrap() > 0.0, "{few}");
    // Whatever the memory of the host, levels are those of the store.
    render("sphere/", "tight.exr", &["--max-points", "9000", "--host-memory", "1MiB"]);
    let bytes = |name: &str| pellucid_io::output::read_image(&inside(&folder, name)).unwrap().pixels;
    assert_eq!(bytes("tight.exr"), bytes("few.exr"));
    // The sphere covers as much as it did.
    let covered = |name: &str| bytes(name).iter().filter(|pixel| pixel[0] > 0.0).count() as f64;
    for name in ["coarse.exr", "few.exr"] {
        let share = covered(name) / covered("all.exr");
        assert!((0.95..1.2).contains(&share), "{name}: {share}");
    }
}

#[test]
fn no_more_points_are_drawn_than_allowed_of_any_kind_of_cloud() {
    if !has_device() {
        return;
    }
    let folder = folder();
    store(&folder);
    let splats = write_splats(&folder);
    // Clouds without levels: a table, one that the program makes, Gaussians, and the pixels of a picture.
    done(&folder, &["render", "sphere.xyz", "-o", "photo.png", "--size", "80x60"]);
    let garden = builtin(&folder, "garden", &["points=3000"]);
    for (from, to) in [("tests/data/lidar/sample_c_2k.las", "a.las"), ("fuzz/corpus/copc/format-7", "a.copc.laz")] {
        fs::copy(pellucid_testing::root().join(from), inside(&folder, to)).unwrap();
    }
    for cloud in ["sphere.xyz", &garden, &splats, "photo.png", "a.las", "a.copc.laz", "sphere/"] {
        for most in [1u64, 7, 100, 2500] {
            let limit = most.to_string();
            let fixed = ["profile", cloud, "--json", "--frames", "1", "--size", "64x48", "--set", "shading.model=none"];
            let args = [&fixed[..], &["--max-points", &limit]].concat();
            let (status, json, stderr) = run(&folder, &args);
            if cloud == "sphere/" && most < 1000 {
                assert!(status != 0 && stderr.contains("the coarsest level alone has"), "{stderr}");
                continue;
            }
            let profile: Value = serde_json::from_str(&json).unwrap_or_else(|error| panic!("{error}: {stderr}"));
            let drawn = profile["scene"]["points"].as_u64().unwrap();
            assert!(drawn <= most && (drawn > 0 || most < 100), "{cloud}: {drawn} of {most}");
        }
    }
}

#[test]
fn detail_that_leaves_out_nothing_or_too_much_is_reported() {
    let folder = folder();
    write_cloud(&inside(&folder, "a.ply"));
    let refuse = |options: &[&str], parts: &[&str]| {
        assert_refused(&folder, &[&["render", "a.ply", "-o", "a.png"], options].concat(), 2, parts);
    };
    refuse(&["--detail", "-1"], &["--detail -1", "spacing_px", "at least 0"]);
    refuse(&["--detail", "fine"], &["--detail fine", "spacing_px"]);
    refuse(&["--max-points", "0"], &["--max-points 0", "max_points", "from 1"]);
    refuse(&["--max-points", "1e6"], &["--max-points 1e6"]);
    refuse(&["--set", "detail.pixels=2"], &["detail", "pixels"]);
    if has_device() {
        let (code, _, stderr) =
            run(&folder, &["render", "a.ply", "-o", "a.png", "--detail", "2", "--method", "points"]);
        assert_eq!(code, 0, "{stderr}");
        assert!(stderr.contains("points of a fixed size, which can't grow"), "{stderr}");
        let (code, _, stderr) = run(&folder, &["render", "a.ply", "-o", "a.png", "--detail", "2", "--method", "spbr"]);
        assert_eq!(code, 0, "{stderr}");
        assert!(stderr.contains("[detail] has no effect: method spbr"), "{stderr}");
    }
}
