//! Stores that `pellucid prepare` writes: what they hold, what is said, and runs that end early.

use std::fs;
use std::os::unix::process::ExitStatusExt;
use std::path::Path;
use std::process::Output;

use pellucid_io::store::{Octree, Store};
use pellucid_testing::root;
use tempfile::TempDir;

use crate::{assert_refused, folder, inside, pellucid, run, write_cloud};

const FILES: [&str; 5] = ["hierarchy.bin", "metadata.json", "nodes.bin", "octree.bin", "survey.bin"];

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
fn inputs_and_options_that_make_no_store_are_refused() {
    let folder = scan();
    write_cloud(&inside(&folder, "b.ply"));
    fs::create_dir(inside(&folder, "full")).unwrap();
    fs::write(inside(&folder, "full/mine"), "").unwrap();
    let cases: [(&[&str], i32, &str); 9] = [
        (&["a.las", "b.ply", "-o", "c.ply"], 2, "name a folder to write several as a store"),
        (&["a.las", "-o", "c.ply", "--node-points", "500"], 2, "are for stores"),
        (&["a.las", "-o", "c", "--light", "0,0,-1"], 2, "shadows can only be stored in a PLY file"),
        (&["a.las", "-o", "c", "--host-memory", "1KiB"], 2, "at least 1 MiB"),
        (&["a.las", "-o", "c", "--node-points", "1"], 2, "expected 100 or more"),
        (&["a.las", "-o", "full"], 1, "the folder has other files"),
        (&["a.las", "-o", "c", "--field", "inetnsity"], 1, "no scalar property `inetnsity`"),
        (&["nowhere", "-o", "c"], 1, "nowhere: no such file"),
        (&["a.las", "full", "-o", "c"], 1, "full: a folder, not a point cloud"),
    ];
    for (args, status, says) in cases {
        assert_refused(&folder, &[&["prepare"], args].concat(), status, &[says]);
    }
}

/// Makes a store in many small steps, with a fault if there is one. Few neighbors are found in a fifth of the time, and
/// change no file's size.
fn prepare(folder: &TempDir, output: &str, node_points: &str, fault: Option<&str>) -> Output {
    let small = ["-q", "--host-memory", "1MiB", "--neighbors", "8", "--node-points", node_points];
    let args = [&["prepare", "a.las", "-o", output], &small[..]].concat();
    let mut command = pellucid(folder, &args);
    if let Some(fault) = fault {
        command.env("PELLUCID_FAULT", fault);
    }
    command.output().unwrap()
}

/// A scan, and its store in a run that nothing ended.
fn scan_and_store() -> (TempDir, Vec<Vec<u8>>) {
    let folder = scan();
    assert!(prepare(&folder, "whole/store", "100", None).status.success());
    let whole = bytes(&inside(&folder, "whole/store"));
    (folder, whole)
}

/// Ends runs by a fault, then runs without: the same bytes come of it. Returns `true` if the fault was met.
fn ends_early((folder, whole): &(TempDir, Vec<Vec<u8>>), fault: &str) -> bool {
    let status = prepare(folder, "a/store", "100", Some(&format!("kill@{fault}"))).status;
    let metadata = |parent: &str| inside(folder, &format!("{parent}/store/metadata.json")).exists();
    assert!(!metadata("a") || status.success() || fault.contains("renamed"), "{fault}");
    let said = prepare(folder, "b/store", "100", Some(&format!("disk-full@{fault}")));
    let text = String::from_utf8_lossy(&said.stderr);
    assert!(
        said.status.success() || text.starts_with("error: b") && text.contains("free some space"),
        "{fault}: {said:?}"
    );
    assert!(said.status.success() || !metadata("b"), "{fault}");
    for parent in ["a", "b"] {
        let store = format!("{parent}/store");
        let again = prepare(folder, &store, "100", None);
        assert!(again.status.success(), "{fault}: {again:?}");
        assert!(bytes(&inside(folder, &store)) == *whole, "{fault}");
        // SIGKILL may leave a temporary file.
        let left = fs::read_dir(inside(folder, parent)).unwrap().map(|entry| entry.unwrap().file_name());
        let left = left.filter(|name| !name.to_string_lossy().ends_with(".tmp")).count();
        assert_eq!(left, 1, "{fault}: nothing is left beside");
        fs::remove_dir_all(inside(folder, parent)).unwrap();
    }
    status.signal() == Some(9)
}

#[test]
fn a_run_that_ends_early_leaves_no_store_and_goes_on() {
    let scan = scan_and_store();
    let faults = [
        "output/byte:100",
        "output/byte:40000",
        "output/byte:100000",
        "output/byte:200000",
        "output/create:7",
        "output/rename",
        // The last of them give the files of the store their names.
        "output/rename:2",
        "output/rename:7",
        "output/rename:8",
    ];
    let killed = faults.iter().filter(|fault| ends_early(&scan, fault)).count();
    assert!(killed >= 7, "{killed}");
}

#[test]
#[ignore = "takes a minute: every 10,000th byte, every file that is made and every name that is given"]
fn a_run_that_ends_anywhere_goes_on() {
    let scan = scan_and_store();
    // Behind the first place that a run does not come to there is none that it does.
    let killed = [("byte", 10_000), ("create", 1), ("rename", 1)].map(|(point, step)| {
        (1..).take_while(|at| ends_early(&scan, &format!("output/{point}:{}", step * at))).count()
    });
    assert!(killed.iter().sum::<usize>() > 70, "{killed:?}");
}

#[test]
fn a_store_that_is_replaced_is_the_old_one_whole_or_none() {
    let folder = scan();
    assert!(prepare(&folder, "store", "200", None).status.success());
    let store = inside(&folder, "store");
    let old = bytes(&store);
    let is_killed = |at: usize| {
        let status = prepare(&folder, "store", "100", Some(&format!("kill@output/rename:{at}"))).status;
        if status.success() {
            return false;
        }
        assert_eq!(status.signal(), Some(9));
        assert!(!store.join("metadata.json").exists() || bytes(&store) == old, "killed at the {at}th name");
        // Files of both would be read as one store.
        fs::remove_dir_all(&store).unwrap();
        assert!(prepare(&folder, "store", "200", None).status.success());
        true
    };
    let killed = (1..).take_while(|at| is_killed(*at)).count();
    assert!(killed >= 7, "{killed}");
    assert!(bytes(&store) != old);
}

#[test]
fn leftovers_of_other_arguments_or_inputs_are_not_used() {
    let folder = scan();
    let other = root().join("tests/data/formats/las_extrabytes.las");
    let kill = |output: &str| {
        let status = prepare(&folder, output, "100", Some("kill@output/byte:40000")).status;
        assert_eq!(status.signal(), Some(9));
        assert!(!inside(&folder, output).join("metadata.json").exists());
    };
    kill("a/store");
    for output in ["a/store", "whole/store"] {
        assert!(prepare(&folder, output, "200", None).status.success());
    }
    assert!(bytes(&inside(&folder, "a/store")) == bytes(&inside(&folder, "whole/store")), "other arguments");
    kill("b/store");
    fs::copy(other, inside(&folder, "a.las")).unwrap();
    for output in ["b/store", "new/store"] {
        assert!(prepare(&folder, output, "100", None).status.success());
    }
    assert!(bytes(&inside(&folder, "b/store")) == bytes(&inside(&folder, "new/store")), "another input");
    for parent in ["a", "b"] {
        assert_eq!(fs::read_dir(inside(&folder, parent)).unwrap().count(), 1, "{parent}: nothing is left beside");
    }
}

#[test]
fn a_folder_without_its_description_is_no_store() {
    let folder = scan();
    assert!(prepare(&folder, "store", "100", None).status.success());
    fs::remove_file(inside(&folder, "store/metadata.json")).unwrap();
    assert_refused(&folder, &["prepare", "store", "-o", "again"], 1, &["store: a folder, not a point cloud"]);
    // It is taken for what is left of one, and replaced.
    assert!(prepare(&folder, "store", "100", None).status.success());
    assert_eq!(bytes(&inside(&folder, "store")).len(), 5);
}
