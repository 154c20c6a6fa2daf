//! SIGKILL in the middle of the work: the old output or the new one, whole, and the next run takes no notice.

use std::os::unix::process::ExitStatusExt;
use std::path::Path;
use std::time::Duration;

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use pellucid_testing::long_or;

use super::checker::{Allowed, complaints, is_temporary, is_whole};
use super::{CASES, Case, cases, command, done, files, has_device, place, put_old, with_fault, written};

/// Asserts that there is the old output or the new, and that the next run, over what was left, makes what it would make
/// anywhere. How many temporary files were left. Where all files are as they were, the next run is one like any other.
fn assert_recovers(folder: &Path, case: Case, before: &super::Files, what: &str) -> usize {
    let after = files(folder);
    let found = complaints(before, &after, Allowed::Leftovers);
    assert!(found.is_empty(), "{what}: {found:?}");
    if after == *before {
        return 0;
    }
    let left = after.keys().filter(|path| is_temporary(path)).count();
    let again = done(folder, case);
    for (path, bytes) in &again {
        assert_eq!(is_whole(path, bytes), Ok(()), "{what}: {}", path.display());
    }
    if case.repeats {
        assert!(again == *written(case), "{what}: another result than without what was left");
    }
    left
}

/// Kills a case at a point; how many temporary files were left.
fn kill(case: Case, point: &str) -> usize {
    kill_if_passed(case, point).unwrap_or_else(|| panic!("{:?}: {point} was never passed", case.args))
}

/// Calls [`kill`]; returns nothing where the command was done before it passed the point.
fn kill_if_passed(case: Case, point: &str) -> Option<usize> {
    let folder = place();
    put_old(folder.path(), case);
    let before = files(folder.path());
    let status = with_fault(folder.path(), case.args, &format!("kill@{point}")).status;
    if status.success() {
        return None;
    }
    let what = format!("{:?} killed at {point}", case.args);
    assert_eq!(status.signal(), Some(9), "{what}: {status}");
    Some(assert_recovers(folder.path(), case, &before, &what))
}

fn sweep(case: Case, bytes: &[usize]) {
    let all = case.files.len();
    assert_eq!(kill(case, "output/create"), 0);
    for at in bytes {
        assert!(kill(case, &format!("output/byte:{at}")) > 0);
    }
    let mut ends = vec![1, all];
    ends.dedup();
    for file in ends {
        // Files that come together are all there when the first gets its name.
        let waiting = if case.together { all + 1 - file } else { 1 };
        assert_eq!(kill(case, &format!("output/rename:{file}")), waiting, "{:?}", case.args);
        assert_eq!(kill(case, &format!("output/renamed:{file}")), waiting - 1, "{:?}", case.args);
    }
}

#[test]
fn whoever_is_killed_leaves_the_old_output_or_the_new() {
    for case in cases().filter(|case| !case.needs_device) {
        sweep(case, &[1, 500]);
    }
    for case in cases().filter(|case| case.needs_device) {
        kill(case, "output/byte:200");
        kill(case, "output/renamed");
    }
}

#[test]
fn whoever_is_killed_while_rendering_leaves_nothing() {
    for case in cases().filter(|case| case.needs_device).step_by(2) {
        assert_eq!(kill(case, "submit:3"), 0);
        assert_eq!(kill(case, "allocate:5"), 0);
    }
}

#[test]
#[ignore = "long: all commands, every point"]
fn whoever_is_killed_anywhere_leaves_the_old_output_or_the_new() {
    let bytes: Vec<usize> = (0..40).step_by(long_or(1, 20)).map(|i| 1 + 43 * i).collect();
    for case in cases() {
        let total: usize = written(case).values().map(Vec::len).sum();
        let within: Vec<usize> = bytes.iter().copied().filter(|at| *at < total * 9 / 10).collect();
        sweep(case, &within);
        if case.needs_device {
            let submissions =
                (1..30).step_by(long_or(1, 3)).map_while(|nth| kill_if_passed(case, &format!("submit:{nth}")));
            let left: Vec<usize> = submissions.collect();
            let most = usize::from(case.streams);
            assert!(left.len() >= long_or(4, 2) && left.iter().all(|left| *left <= most), "{:?}: {left:?}", case.args);
        }
    }
}

#[test]
fn a_cache_that_was_being_written_is_no_matter() {
    if !has_device() {
        return;
    }
    let case = CASES[3];
    let folder = place();
    let cache = folder.path().join("cache");
    let run = |fault: &str| {
        let mut run = command(folder.path(), case.args);
        run.env("PELLUCID_CACHE_DIR", &cache).env("PELLUCID_FAULT", fault).output().unwrap().status.signal()
    };
    // The last one is written while the device is closed, after the picture.
    for nth in [1, 3] {
        assert_eq!(run(&format!("kill@cache/rename:{nth}")), Some(9));
        assert!(files(&cache).keys().any(|path| is_temporary(path)), "left in the cache");
    }
    assert_eq!(run("kill@output/rename:99"), None);
    assert!(files(&folder.path().join("out")) == *written(case));
}

/// Kills each of these commands after random times.
fn kill_at_random(all: impl Iterator<Item = Case>, times: usize, seed: u64) {
    let mut random = Pcg64::seed_from_u64(seed);
    for case in all {
        for _ in 0..times {
            let folder = place();
            put_old(folder.path(), case);
            let before = files(folder.path());
            let mut child = command(folder.path(), case.args).stdout(std::process::Stdio::null()).spawn().unwrap();
            // About as long as the command takes.
            let most = if case.streams { 600 } else { 300 };
            let ms = random.random_range(1..if case.needs_device { most } else { 40 });
            std::thread::sleep(Duration::from_millis(ms));
            // It may be done already.
            let _ = child.kill();
            child.wait().unwrap();
            assert_recovers(folder.path(), case, &before, &format!("{:?} killed after {ms} ms", case.args));
        }
    }
}

#[test]
fn whoever_is_killed_at_some_time_leaves_the_old_output_or_the_new() {
    kill_at_random(cases().filter(|case| !case.needs_device), 3, 1);
    kill_at_random(cases().filter(|case| case.needs_device).take(1), 2, 2);
}

#[test]
#[ignore = "long: 40 times each"]
fn whoever_is_killed_at_any_time_leaves_the_old_output_or_the_new() {
    kill_at_random(cases(), long_or(40, 2), 3);
}
