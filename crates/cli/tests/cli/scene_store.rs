//! Landscapes that `pellucid scene terrain` writes as stores: when, what is said, and runs that end early.

use std::fs;
use std::os::unix::process::ExitStatusExt;
use std::path::Path;

use pellucid_io::store::{Octree, Store};
use pellucid_scene::Scene;

use crate::{assert_refused, folder, inside, pellucid, run};

/// Makes a store of 100000 points in cells of some 6000, so that there are many.
const SMALL: [&str; 7] = ["--set", "points=100000", "--store", "--host-memory", "1MiB", "--seed", "4"];

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<_> =
        fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

fn bytes(scene: &Path) -> Vec<Vec<u8>> {
    let files = [
        "scene.toml",
        "terrain/hierarchy.bin",
        "terrain/metadata.json",
        "terrain/nodes.bin",
        "terrain/octree.bin",
        "terrain/survey.bin",
    ];
    // SIGKILL may leave a temporary file.
    let clean = |folder: &Path| names(folder).into_iter().filter(|name| !name.ends_with(".tmp")).collect::<Vec<_>>();
    assert_eq!(clean(scene), ["scene.toml", "terrain"]);
    assert_eq!(clean(&scene.join("terrain")).len(), 5);
    files.map(|file| fs::read(scene.join(file)).unwrap()).to_vec()
}

#[test]
fn landscapes_become_stores_if_that_is_asked_for() {
    let folder = folder();
    let args = [&["scene", "terrain", "-o", "new/land", "-v"], &SMALL[..]].concat();
    let (status, _, said) = run(&folder, &args);
    assert!(status == 0 && said.contains("land/terrain: written, 100000 points"), "{said}");
    let land = inside(&folder, "new/land");
    let store = Octree::open(&land.join("terrain")).unwrap();
    let like = &store.summary().like;
    assert!(like.colors.is_some() && like.classification.is_some() && like.own_radii().is_some());
    assert_eq!((store.summary().points, like.normals.is_some()), (100_000, false));
    let scene = Scene::read(&land.join("scene.toml"), &Default::default()).unwrap();
    assert_eq!((scene.warnings.len(), &scene.clouds[0].path), (0, &land.join("terrain")));
    // Without the option there are few enough points for a file.
    let (status, _, said) = run(&folder, &["scene", "terrain", "-o", "file", "--set", "points=20000"]);
    assert_eq!((status, said.as_str()), (0, ""));
    assert_eq!(names(&inside(&folder, "file")), ["scene.toml", "terrain.ply"]);
}

#[test]
fn scenes_and_options_without_a_store_are_refused() {
    let folder = folder();
    fs::create_dir_all(inside(&folder, "full/terrain")).unwrap();
    fs::write(inside(&folder, "full/terrain/mine"), "").unwrap();
    let cases: [(&[&str], i32, &str); 6] = [
        (&["garden", "-o", "d", "--store"], 2, "belong to the scene terrain, not to garden"),
        (&["terrain", "-o", "d", "--host-memory", "1GiB"], 2, "give --store too"),
        (&["terrain", "-o", "d", "--store", "--host-memory", "1KiB"], 2, "at least 1 MiB"),
        (&["terrain", "-o", "d", "--set", "points=1e11"], 2, "it must lie from 10000 to 10000000000"),
        (&["terrain", "-o", "d", "--set", "points=20000000.5"], 2, "must be a whole number"),
        (&["terrain", "-o", "full", "--set", "points=20000", "--store"], 1, "the folder has other files"),
    ];
    for (args, status, says) in cases {
        assert_refused(&folder, &[&["scene"], args].concat(), status, &[says]);
    }
    assert_eq!(names(&inside(&folder, "full/terrain")), ["mine"]);
}

#[test]
fn a_run_that_ends_early_leaves_no_store_and_goes_on() {
    let folder = folder();
    let scene = |output: &str, fault: Option<&str>| {
        let mut command = pellucid(&folder, &[&["scene", "terrain", "-o", output, "-q"], &SMALL[..]].concat());
        if let Some(fault) = fault {
            command.env("PELLUCID_FAULT", fault);
        }
        command.output().unwrap()
    };
    assert!(scene("whole", None).status.success());
    let whole = bytes(&inside(&folder, "whole"));
    let mut killed = 0;
    for fault in ["output/byte:100", "output/byte:1500000", "output/byte:2200000", "output/create:5", "output/rename"] {
        let status = scene("a", Some(&format!("kill@{fault}"))).status;
        killed += u32::from(status.signal() == Some(9));
        assert!(!inside(&folder, "a/scene.toml").exists() || status.success(), "{fault}");
        let said = scene("b", Some(&format!("disk-full@{fault}")));
        let text = String::from_utf8_lossy(&said.stderr);
        assert!(said.status.success() || text.contains("free some space"), "{fault}: {text}");
        if fault.contains("byte") {
            // 23 bytes for each of 100000 points.
            assert!(text.contains("about 2.3 MB are needed") || text.contains("about 2.2 MiB are needed"), "{text}");
        }
        for output in ["a", "b"] {
            assert!(scene(output, None).status.success(), "{fault}");
            assert!(bytes(&inside(&folder, output)) == whole, "{fault}");
            fs::remove_dir_all(inside(&folder, output)).unwrap();
        }
    }
    assert!(killed >= 4, "{killed}");
}
