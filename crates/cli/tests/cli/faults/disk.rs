//! A disk that is full: simulated at any byte, by a limit on the size of files, by a small file system, by `/dev/full`.

use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::{Command, Output, Stdio};

use pellucid_testing::long_or;
use pellucid_testing::skip::{NO_FILE_LIMIT, NO_MOUNTS, skip};

use super::checker::{Allowed, complaints};
use super::{
    COMPARE, Case, PREPARE, RENDER_DEEP, RENDER_EXR, RENDER_PNG, SCENE, assert_failed, cases, command, files,
    has_device, place, put_old, text, with_fault, written,
};

fn allowed(case: Case) -> Allowed {
    if case.together { Allowed::Nothing } else { Allowed::NewOrOld }
}

/// Runs a case with a fault over old files; asserts that it fails, and what is there then.
fn assert_full(case: Case, fault: &str) {
    let folder = place();
    put_old(folder.path(), case);
    let before = files(folder.path());
    let output = with_fault(folder.path(), case.args, fault);
    let what = format!("{:?} {fault}", case.args);
    assert_failed(&output, &what, &["out/", "written: no storage space; free some space there or write elsewhere"]);
    let found = complaints(&before, &files(folder.path()), allowed(case));
    assert!(found.is_empty(), "{what}: {found:?}");
    // Nor where there was nothing before.
    let folder = place();
    let before = files(folder.path());
    assert_failed(&with_fault(folder.path(), case.args, fault), &what, &[]);
    let found = complaints(&before, &files(folder.path()), allowed(case));
    assert!(found.is_empty(), "{what}: {found:?}");
}

/// Places of the output; the fault takes one: in a header, in the middle, at the end.
fn sweep(case: Case, places: usize) {
    let bytes: usize = written(case).values().map(Vec::len).sum();
    // Measured figures have more or fewer digits, so that their end isn't known beforehand.
    let last = if case.repeats { bytes } else { bytes * 9 / 10 };
    let mut at: Vec<usize> = (0..=places).map(|i| 1 + (last - 1) * i / places).collect();
    at.extend([2, 30, last - 1]);
    at.iter().for_each(|at| assert_full(case, &format!("disk-full@output/byte:{at}")));
    for point in ["create", "rename"] {
        assert_full(case, &format!("disk-full@output/{point}"));
    }
}

#[test]
fn wherever_the_disk_gets_full_the_old_files_stay() {
    for case in cases().filter(|case| !case.needs_device) {
        sweep(case, 4);
    }
    for case in cases().filter(|case| case.needs_device) {
        assert_full(case, "disk-full@output/byte:100");
    }
}

#[test]
#[ignore = "long: all commands, 60 places each"]
fn wherever_the_disk_gets_full_in_any_command() {
    cases().for_each(|case| sweep(case, long_or(60, 1)));
}

/// Runs a case in a shell after a command of the shell's.
fn in_shell(folder: &Path, case: Case, before: &str) -> Output {
    let run = command(folder, case.args);
    let mut shell = Command::new("bash");
    shell.current_dir(folder).arg("-c").arg(format!("{before}; exec \"$0\" \"$@\"")).arg(run.get_program());
    shell.args(run.get_args()).envs(run.get_envs().filter_map(|(key, value)| Some((key, value?))));
    shell.output().unwrap()
}

/// Limits files to each of `kib` KiB; asserts that a case fails as long as they are too small, and not after that.
fn limited(case: Case, kib: &[usize]) {
    let largest = written(case).values().map(Vec::len).max().unwrap();
    for trap in ["", "trap '' XFSZ; "] {
        for limit in kib {
            let folder = place();
            put_old(folder.path(), case);
            let before = files(folder.path());
            let output = in_shell(folder.path(), case, &format!("{trap}ulimit -f {limit}"));
            let what = format!("{:?} within {limit} KiB", case.args);
            if limit * 1024 >= largest {
                assert_eq!((output.status.code(), text(&output.stderr).as_str()), (Some(0), ""), "{what}");
                continue;
            }
            // The case's own words, not those of a shell that was told of a signal.
            assert_failed(&output, &what, &["out/", "written: File too large", "ulimit -f"]);
            let found = complaints(&before, &files(folder.path()), Allowed::Nothing);
            assert!(found.is_empty(), "{what}: {found:?}");
        }
    }
}

#[test]
fn files_over_the_limit_on_their_size_are_an_error() {
    limited(SCENE, &[0, 1, 2, 4, 64]);
    limited(PREPARE, &[0, 1, 2, 64]);
    limited(COMPARE, &[0, 64]);
    if !has_device() {
        return;
    }
    // Some CPU drivers keep the device's memory in files.
    let folder = place();
    if in_shell(folder.path(), RENDER_PNG, "ulimit -f 64").status.success() {
        limited(RENDER_PNG, &[0, 1]);
        limited(RENDER_EXR, &[0, 1, 3]);
    } else {
        skip(NO_FILE_LIMIT, "the device itself needs files beyond `ulimit -f`");
    }
}

/// Runs a case in a file system of 64 KiB, mounted where nobody else sees it, of which only so many KiB are free.
/// Standard error, the exit status, and what is in it then. `None` where that is not allowed.
fn mounted(case: Case, free: usize, options: &str) -> Option<(i32, String, String)> {
    let folder = place();
    let run = command(folder.path(), case.args);
    let script = format!(
        "mount -t tmpfs -o size=64k none out || exit 99; echo -n old > out/{old}; \
         head -c {filled}k /dev/zero > out/filler; {options}\
         \"$0\" \"$@\"; status=$?; ls -A out; cat out/{old}; exit $status",
        old = case.files[0],
        filled = 60 - free,
    );
    let output = Command::new("unshare")
        .args(["-rm", "bash", "-c", &script])
        .arg(run.get_program())
        .args(run.get_args())
        .envs(run.get_envs().filter_map(|(key, value)| Some((key, value?))))
        .current_dir(folder.path())
        .output()
        .ok()?;
    let (stderr, stdout) = (text(&output.stderr), text(&output.stdout));
    let refused = output.status.code() == Some(99) || stderr.starts_with("unshare");
    (!refused).then(|| (output.status.code().unwrap_or(-1), stderr, stdout))
}

#[test]
fn a_file_system_without_room_is_an_error() {
    let cases = [SCENE, PREPARE, COMPARE, RENDER_EXR, RENDER_DEEP];
    for case in cases.into_iter().filter(|case| !case.needs_device || has_device()) {
        // The smaller files would find room.
        for free in if case.together && case.files.len() > 1 { vec![0, 4, 8] } else { vec![0] } {
            let Some((status, stderr, left)) = mounted(case, free, "") else {
                skip(NO_MOUNTS, "`unshare -rm` or `mount` is refused");
                return;
            };
            let what = format!("{:?} with {free} KiB free: {stderr}", case.args);
            assert_eq!(status, 1, "{what}");
            assert!(stderr.starts_with("error: out/") && stderr.contains("free some space"), "{what}");
            let mut names = [case.files[0], "filler"];
            names.sort_unstable();
            assert_eq!(left, format!("{}\n{}\nold", names[0], names[1]), "{what}");
        }
    }
}

#[test]
fn samples_that_may_find_no_room_are_refused_before_they_are_rendered() {
    if !has_device() {
        return;
    }
    // The header has room, and the rows would not.
    let Some((status, stderr, left)) = mounted(RENDER_DEEP, 8, "") else {
        skip(NO_MOUNTS, "`unshare -rm` or `mount` is refused");
        return;
    };
    assert_eq!(status, 1, "{stderr}");
    assert!(stderr.starts_with("error: out/a.exr: may take ") && stderr.contains("free some space"), "{stderr}");
    assert_eq!(left, "a.exr\nfiller\nold");
}

#[test]
fn a_file_system_that_is_only_read_is_an_error_before_any_work() {
    let Some((status, stderr, left)) = mounted(SCENE, 30, "mount -o remount,ro out; ") else {
        skip(NO_MOUNTS, "`unshare -rm` or `mount` is refused");
        return;
    };
    assert_eq!(status, 1, "{stderr}");
    assert!(
        stderr.contains("Read-only file system") && stderr.contains("choose a folder with write permission"),
        "{stderr}"
    );
    assert_eq!(left, "filler\ninner.ply\nold");
}

#[cfg(target_os = "linux")]
#[test]
fn standard_output_that_is_full_is_an_error() {
    let full = || Stdio::from(std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap());
    let commands: [(&[&str], bool); 8] = [
        (&["scene", "--list"], false),
        (&["info", "in/cloud.ply"], false),
        (&["info", "in/cloud.ply", "--json"], false),
        (&["compare", "in/a.png", "in/b.png", "--json"], false),
        (&["check", "--list"], false),
        (&["devices"], true),
        (&["plan", "in/scene.toml"], true),
        (&["check", "abuffer/faint", "--json"], true),
    ];
    for (args, _) in commands.into_iter().filter(|(_, needs_device)| !needs_device || has_device()) {
        let folder = place();
        let output = command(folder.path(), args).stdout(full()).output().unwrap();
        let help = "error: standard output: No space left on device (os error 28); free some space";
        assert_failed(&output, &format!("{args:?}"), &[help]);
    }
}

#[cfg(target_os = "linux")]
#[test]
fn devices_in_the_place_of_files_stay_what_they_are() {
    for case in [PREPARE, COMPARE] {
        let folder = place();
        let target = folder.path().join("out").join(case.files[0]);
        symlink("/dev/full", &target).unwrap();
        let output = command(folder.path(), case.args).output().unwrap();
        assert_failed(&output, &format!("{:?}", case.args), &["out/", "written: No space left on device"]);
        assert!(target.is_symlink(), "{:?}", case.args);
        std::fs::remove_file(&target).unwrap();
        symlink("/dev/null", &target).unwrap();
        let output = command(folder.path(), case.args).output().unwrap();
        assert!(output.status.success() && target.is_symlink(), "{:?}: {}", case.args, text(&output.stderr));
        assert_eq!(std::fs::read_dir(folder.path().join("out")).unwrap().count(), 1);
    }
}
