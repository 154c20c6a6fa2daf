//! `render --deep`: what doesn't go with it, the estimate, and its files as OpenEXR's own library reads them.

use std::fs;
use std::path::PathBuf;
use std::process::Command;

use pellucid_testing::skip::{NO_OPENEXR, skip};
use pellucid_testing::{has_device, root};
use tempfile::TempDir;

use crate::gaussians::write_splats;
use crate::{assert_refused, builtin, done, folder, inside, run};

const SIZE: [&str; 2] = ["--size", "32x24"];

#[test]
fn settings_that_conflict_with_samples_are_named() {
    let folder = folder();
    let garden = builtin(&folder, "garden", &["points=2000"]);
    let splats = write_splats(&folder);
    let cases: [(&[&str], &[&str]); 15] = [
        (&[&garden, "-o", "a.png"], &["--deep", "a.png is a PNG"]),
        (&[&garden], &["--deep", "is a PNG", "-o"]),
        (
            &[&garden, "-o", "a.exr", "--method", "stochastic"],
            &["method.name = \"stochastic\"", "abuffer, linked-list"],
        ),
        (&[&garden, "-o", "a.exr", "--method", "soft-base"], &["method.name = \"soft-base\""]),
        (
            &[&garden, "-o", "a.exr", "--method", "abuffer", "--set", "image.color=encoded"],
            &["image.color", "image.color=linear"],
        ),
        (&[&splats, "-o", "a.exr"], &["image.color = \"encoded\"", "scenes of Gaussians"]),
        (
            &[
                &splats,
                "-o",
                "a.exr",
                "--method",
                "abuffer",
                "--set",
                "image.color=linear",
                "--set",
                "method.order=distance",
            ],
            &["method.order = \"distance\"", "\"center\""],
        ),
        (&[&garden, "-o", "a.exr", "--method", "abuffer", "--set", "shading.edl=true"], &["shading.edl"]),
        (&[&garden, "-o", "a_%d.exr", "--frames"], &["--deep writes one picture"]),
        (&[&garden, "-o", "a_%d.exr", "--turntable", "--frames", "3"], &["--deep writes one picture"]),
        (&[&garden, "-o", "a.exr", "--max-error", "0.1"], &["--max-error"]),
        (&[&garden, "-o", "a.exr", "--profile", "p.json"], &["--profile"]),
        (&[&garden, "-o", "a.exr", "--deep-type", "double"], &["--deep-type", "float, half"]),
        (&[&garden, "-o", "a.exr", "--deep-compression", "zip"], &["--deep-compression", "zips, none"]),
        (&[&garden, "-o", "a.tif"], &["a.tif", ".exr"]),
    ];
    for (args, parts) in cases {
        assert_refused(&folder, &[&["render", "--deep", "-q"], args].concat(), 2, parts);
    }
    let shells = ["render", &garden, "-o", "a.exr", "--method", "soft-concentric", "--deep=sorted", "-q"];
    assert_refused(&folder, &shells, 2, &["--deep=sorted", "method.name = \"soft-concentric\"", "--deep=tidy"]);
    assert_refused(&folder, &["render", &garden, "-o", "a.exr", "--deep=messy"], 2, &["--deep", "tidy, sorted"]);
    assert_refused(&folder, &["render", &garden, "-o", "a.exr", "--deep-type", "half"], 2, &["--deep"]);
}

#[test]
fn the_size_is_told_before_and_is_not_exceeded() {
    if !has_device() {
        return;
    }
    let folder = folder();
    let tori = builtin(&folder, "tori", &["points=500"]);
    let base = ["render", &tori, "--size", "32x24", "-o", "a.exr", "--method", "abuffer"];
    let mut sizes = Vec::new();
    for more in [&["--deep", "--deep-compression", "none"][..], &["--deep"], &["--deep", "--deep-type", "half"]] {
        let (status, stdout, stderr) = run(&folder, &[&base[..], more].concat());
        assert_eq!((status, stdout.as_str()), (0, ""), "{stderr}");
        let told: u64 = stderr
            .strip_prefix("a.exr: at most ")
            .and_then(|rest| rest.split(' ').next()?.parse().ok())
            .unwrap_or_else(|| panic!("{more:?}: {stderr}"));
        let each = if more.contains(&"half") { 12 } else { 20 };
        assert!(stderr.contains(&format!("(of {each} bytes each) before compression")), "{stderr}");
        let size = fs::metadata(inside(&folder, "a.exr")).unwrap().len();
        // In addition to samples the header and the tables of 24 rows.
        assert!(size <= told * each + 24 * (36 + 32 * 4) + 4096, "{size} bytes, {stderr}");
        sizes.push(size);
    }
    assert!(sizes[0] > sizes[1] && sizes[1] > sizes[2], "{sizes:?}");
    assert_eq!(done(&folder, &[&base[..], &["--deep", "-q"]].concat()), "", "quiet");
    let first = fs::read(inside(&folder, "a.exr")).unwrap();
    done(&folder, &[&base[..], &["--deep", "-q", "--memory-budget", "1MiB"]].concat());
    assert!(fs::read(inside(&folder, "a.exr")).unwrap() == first, "the same bytes in less memory");
    let text = String::from_utf8_lossy(&first);
    assert!(
        ["pellucid:scene", "pellucid:method", "pellucid:settings", "deepscanline"].iter().all(|tag| text.contains(tag))
    );
    // The attribute that OpenEXR's Python module refuses is there on request alone.
    assert!(!text.contains("deepImageState"));
    done(&folder, &[&base[..], &["--deep=tidy,state", "-q"]].concat());
    let told = fs::read(inside(&folder, "a.exr")).unwrap();
    assert_eq!(told.len(), first.len() + 2 * "deepImageState\0".len() + 4 + 1);
    assert!(String::from_utf8_lossy(&told).contains("deepImageState\0deepImageState"));
}

/// Python with OpenEXR, as tools/setup.sh installs it in CI.
fn openexr() -> Option<PathBuf> {
    let python = root().join("target/openexr/bin/python");
    if python.is_file() {
        return Some(python);
    }
    skip(
        NO_OPENEXR,
        "python3 -m venv target/openexr && target/openexr/bin/pip install -r crates/cli/tests/cli/deep/requirements.txt",
    );
    None
}

/// Runs the script on a deep file and a flat one; returns true if it succeeded, and its output.
fn read(python: &PathBuf, folder: &TempDir, files: [&str; 2], counts: bool) -> (bool, String) {
    let script = root().join("crates/cli/tests/cli/deep/read.py");
    let mut command = Command::new(python);
    command.arg(script).args(files).args(counts.then_some("--counts")).current_dir(folder.path());
    let output = command.output().unwrap();
    let text = [output.stdout, output.stderr].concat();
    (output.status.success(), String::from_utf8_lossy(&text).into_owned())
}

#[test]
fn openexr_reads_what_flattens_to_the_flat_file() {
    let Some(python) = openexr().filter(|_| has_device()) else { return };
    let folder = folder();
    let garden = builtin(&folder, "garden", &["points=4000"]);
    let splats = write_splats(&folder);
    let ellipsoids = ["--set", "method.kernel=ellipsoid", "--set", "image.color=linear"];
    // Soft spheres that fill the picture, a few of them solid.
    let soft = ["--set", "method.softness=0.3"];
    let cases: [(&str, &str, &[&str], bool); 7] = [
        (&garden, "abuffer", &["--opacity", "0.3"], true),
        (&garden, "linked-list", &["--opacity", "0.3", "--set", "method.shape=oriented"], true),
        (&garden, "sorted", &["--opacity", "0.3", "--set", "method.shape=flat"], true),
        (&garden, "peel", &["--opacity", "0.3"], true),
        (&garden, "peel", &["--opacity", "0.3", "--set", "method.layers=3"], false),
        (&splats, "abuffer", &ellipsoids, false),
        (&garden, "soft-concentric", &soft, false),
    ];
    for (scene, method, more, counts) in cases {
        let base = [&["render", scene, "--method", method, "-q", "--set", "image.background=[0,0,0]"], &SIZE[..], more]
            .concat();
        done(&folder, &[&base[..], &["-o", "flat.exr", "--aov"]].concat());
        // OpenEXR opens a file as it is where its state isn't asked for.
        for (state, packing, told) in [
            ("--deep", "zips", "none"),
            ("--deep=tidy,state", "zips", "tidy"),
            ("--deep=sorted", "none", "none"),
            ("--deep=sorted,state", "none", "sorted"),
        ] {
            let is_sorted = state.contains("sorted");
            // Overlapping volumes are split before they are flattened, which the script doesn't do.
            if is_sorted && !counts {
                continue;
            }
            done(&folder, &[&base[..], &["-o", "deep.exr", state, "--deep-compression", packing]].concat());
            let (agree, words) = read(&python, &folder, ["deep.exr", "flat.exr"], is_sorted);
            assert!(agree && words.contains(&format!("state {told}\n")), "{method} {more:?} {state}: {words}");
            assert_eq!(
                words.contains("ZBack"),
                ["ellipsoid", "soft"].iter().any(|w| format!("{method}{more:?}").contains(w))
            );
        }
    }
    // Of another scene it doesn't agree, nor with another number of samples.
    let other = [
        "render",
        &garden,
        "--method",
        "abuffer",
        "-q",
        "--set",
        "image.background=[0,0,0]",
        "--opacity",
        "0.31",
        "-o",
        "other.exr",
    ];
    done(&folder, &[&other[..], &SIZE, &["--deep=tidy"]].concat());
    let flat = [
        "render",
        &garden,
        "--method",
        "abuffer",
        "-q",
        "--set",
        "image.background=[0,0,0]",
        "--opacity",
        "0.3",
        "-o",
        "flat.exr",
        "--aov",
    ];
    done(&folder, &[&flat[..], &SIZE].concat());
    let (agree, words) = read(&python, &folder, ["other.exr", "flat.exr"], false);
    assert!(!agree && words.contains("samples, not"), "{words}");
    let first = [
        "render",
        &garden,
        "--method",
        "peel",
        "-q",
        "--set",
        "image.background=[0,0,0]",
        "--opacity",
        "0.3",
        "-o",
        "other.exr",
        "--set",
        "method.layers=1",
    ];
    done(&folder, &[&first[..], &SIZE, &["--deep=sorted"]].concat());
    let (agree, words) = read(&python, &folder, ["other.exr", "flat.exr"], true);
    assert!(!agree && words.contains("fragments"), "{words}");
}
