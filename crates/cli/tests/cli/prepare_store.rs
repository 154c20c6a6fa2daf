//! Stores that `pellucid prepare` writes: what they hold, what is said, and runs that end early.

use std::fs;
use std::os::unix::process::ExitStatusExt;
use std::path::Path;

use pellucid_engine::io::store::{Octree, Store};
use pellucid_testing::root;
use tempfile::TempDir;

use crate::{assert_refused, folder, inside, pellucid, run, write_cloud};

const FILES: [&str; 4] = ["hierarchy.bin", "metadata.json", "nodes.bin", "octree.bin"];

/// A folder with a scan of 2059 points.
fn scan() -> TempDir {
    let folder = folder();
    fs::copy(root().join("tests/data/lidar/sample_c_2k.las"), inside(&folder, "a.las")).unwrap();
    folder
}

fn bytes(store: &Path) -> Vec<Vec<u8>> {
    let names = fs::read_dir(store).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
    // SIGKILL may leave a temporary file.
    let mut names: Vec<_> = names.filter(|name| !name.starts_with(".pellucid-")).collect();
    names.sort();
    assert_eq!(names, FILES);
    FILES.map(|file| fs::read(store.join(file)).unwrap()).to_vec()
}

#[test]
fn scans_become_stores() {
    let folder = scan();
    let small = ["--host-memory", "1MiB", "--node-points", "100", "-q"];
    for output in ["store", "other.d/"] {
        let args = [&["prepare", "a.las", "-o", output], &small[..]].concat();
        assert_eq!(run(&folder, &args), (0, String::new(), String::new()));
    }
    assert!(bytes(&inside(&folder, "store"))[0] == bytes(&inside(&folder, "other.d"))[0]);
    let store = Octree::open(&inside(&folder, "store")).unwrap();
    let summary = store.summary();
    let prepared = summary.like.prepared.as_ref().unwrap();
    assert_eq!((summary.points, prepared.neighbors, prepared.estimated_radii), (2059, 24, true));
    assert!(store.nodes().len() > 20 && store.nodes().iter().all(|node| node.points <= 100));
    let both = ["prepare", "a.las", "store", "-o", "both", "--neighbors", "8", "--field", "intensity", "-v"];
    let (status, _, said) = run(&folder, &both);
    assert_eq!(status, 0, "{said}");
    for line in ["a.las: 2059 points", "store: 2059 points", "both: written, 4118 points in 1 nodes"] {
        assert!(said.contains(line), "{line}: {said}");
    }
    let summary = Octree::open(&inside(&folder, "both")).unwrap().summary().clone();
    assert_eq!((summary.points, summary.like.prepared.unwrap().neighbors), (4118, 8));
}

#[test]
fn what_can_not_be_a_store_is_said() {
    let folder = scan();
    write_cloud(&inside(&folder, "b.ply"));
    fs::create_dir(inside(&folder, "full")).unwrap();
    fs::write(inside(&folder, "full/mine"), "").unwrap();
    let cases: [(&[&str], i32, &str); 9] = [
        (&["a.las", "b.ply", "-o", "c.ply"], 2, "several become a store"),
        (&["a.las", "-o", "c.ply", "--node-points", "500"], 2, "are for stores"),
        (&["a.las", "-o", "c", "--light", "0,0,-1"], 2, "shadows are found for PLY files only"),
        (&["a.las", "-o", "c", "--host-memory", "1KiB"], 2, "at least 1 MiB"),
        (&["a.las", "-o", "c", "--node-points", "1"], 2, "expected 100 or more"),
        (&["a.las", "-o", "full"], 1, "a folder with other files"),
        (&["a.las", "-o", "c", "--field", "inetnsity"], 1, "no scalar property `inetnsity`"),
        (&["nowhere", "-o", "c"], 1, "nowhere: no such file"),
        (&["a.las", "full", "-o", "c"], 1, "full: a folder, not a point cloud"),
    ];
    for (args, status, says) in cases {
        assert_refused(&folder, &[&["prepare"], args].concat(), status, &[says]);
    }
}

#[test]
fn a_run_that_ends_early_leaves_no_store_and_goes_on() {
    let folder = scan();
    let prepare = |output: &str, fault: Option<&str>| {
        let mut command = pellucid(
            &folder,
            &["prepare", "a.las", "-o", output, "-q", "--host-memory", "1MiB", "--node-points", "100"],
        );
        if let Some(fault) = fault {
            command.env("PELLUCID_FAULT", fault);
        }
        command.output().unwrap()
    };
    assert!(prepare("whole/store", None).status.success());
    let whole = bytes(&inside(&folder, "whole/store"));
    let mut killed = 0;
    for fault in [
        "output/byte:100",
        "output/byte:40000",
        "output/byte:100000",
        "output/byte:200000",
        "output/create:7",
        "output/rename",
        "output/rename:2",
    ] {
        let status = prepare("a/store", Some(&format!("kill@{fault}"))).status;
        killed += u32::from(status.signal() == Some(9));
        assert!(!inside(&folder, "a/store/metadata.json").exists() || status.success(), "{fault}");
        let said = prepare("b/store", Some(&format!("disk-full@{fault}")));
        assert!(said.status.success() || String::from_utf8_lossy(&said.stderr).contains("free some space"), "{said:?}");
        for parent in ["a", "b"] {
            let store = format!("{parent}/store");
            assert!(prepare(&store, None).status.success(), "{fault}");
            assert!(bytes(&inside(&folder, &store)) == whole, "{fault}");
            assert_eq!(fs::read_dir(inside(&folder, parent)).unwrap().count(), 1, "{fault}: nothing is left beside");
            fs::remove_dir_all(inside(&folder, parent)).unwrap();
        }
    }
    assert!(killed >= 5, "{killed}");
}
