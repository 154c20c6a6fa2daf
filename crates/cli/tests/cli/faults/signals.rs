//! SIGINT and SIGTERM: the command ends by the signal, as shells expect (130 and 143), and leaves nothing unfinished.

use std::io::{BufRead, BufReader};
use std::os::unix::process::ExitStatusExt;
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use super::checker::{Allowed, complaints};
use super::{CASES, cases, command, files, has_device, meeting, place, put_old};
use pellucid_testing::signals::heeding;

/// The time a signal may take on a busy machine.
const PATIENCE: Duration = Duration::from_secs(120);

/// Starts a command that hangs at a point, and waits until it does.
fn hanging(command: Command, point: &str) -> Child {
    let mut command = meeting(command, &format!("hang@{point}"));
    let mut child = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    let stderr = BufReader::new(child.stderr.take().unwrap());
    let mut lines = stderr.lines().map(Result::unwrap);
    let hangs = lines.by_ref().any(|line| line == "fault: hanging");
    if !hangs {
        child.wait().unwrap();
    }
    assert!(hangs, "{point} was never passed");
    child
}

fn send(child: &Child, signal: &str) {
    let sent = Command::new("kill").args([format!("-{signal}"), child.id().to_string()]).status().unwrap();
    assert!(sent.success());
}

/// Ends a command by a signal. One that lives on is killed, so that its status is another.
fn end(mut child: Child, signal: &str) -> ExitStatus {
    send(&child, signal);
    let since = Instant::now();
    while since.elapsed() < PATIENCE {
        if let Some(status) = child.try_wait().unwrap() {
            return status;
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    send(&child, "KILL");
    child.wait().unwrap()
}

/// Ends a command with each signal at each point; asserts that nothing is there that wasn't before.
fn assert_clean(args: &[&str], points: &[&str], prepare: impl Fn(&Path)) {
    for point in points {
        for (signal, number) in [("INT", 2), ("TERM", 15)] {
            let folder = place();
            prepare(folder.path());
            let before = files(folder.path());
            let folders = |folder: &Path| std::fs::read_dir(folder).unwrap().count();
            let count = folders(folder.path());
            let status = end(hanging(command(folder.path(), args), point), signal);
            let what = format!("{args:?} at {point}, SIG{signal}");
            assert_eq!(status.signal(), Some(number), "{what}: {status}");
            let found = complaints(&before, &files(folder.path()), Allowed::Nothing);
            assert!(found.is_empty(), "{what}: {found:?}");
            assert_eq!(folders(folder.path()), count, "{what}: no new folder");
        }
    }
}

#[test]
fn a_signal_leaves_nothing_unfinished() {
    for case in cases() {
        let points: &[&str] =
            if case.needs_device { &["output/byte:50"] } else { &["output/byte:50", "output/rename"] };
        assert_clean(case.args, points, |folder| put_old(folder, case));
    }
    // Folders that are new go as well.
    assert_clean(&["scene", "tori", "-o", "new/er"], &["output/create", "output/rename"], |_| ());
}

#[test]
fn a_signal_while_the_device_works_leaves_nothing() {
    if !has_device() {
        return;
    }
    let stress =
        ["stress", "-q", "-o", "new", "--quick", "--method", "sorted", "--frames", "1", "--max-fragments", "4096"];
    assert_clean(&stress, &["submit:20"], |_| ());
    let tradeoff = ["tradeoff", "in/scene.toml", "-q", "--size", "16x12", "-o", "new/er", "--quick"];
    assert_clean(&tradeoff, &["submit:3"], |_| ());
    let prepare =
        ["prepare", "in/cloud.ply", "-q", "-o", "out/p.ply", "--light", "0,0,-1", "--shadow-resolution", "64"];
    assert_clean(&prepare, &["submit:3"], |_| ());
    assert_clean(CASES[3].args, &["submit:3"], |_| ());
}

#[test]
fn a_signal_that_was_ignored_stays_ignored() {
    let folder = place();
    let mut shell = heeding("bash");
    shell.current_dir(folder.path()).args(["-c", "trap '' INT; exec \"$0\" \"$@\""]);
    shell.arg(assert_cmd::cargo::cargo_bin("pellucid")).args(CASES[0].args);
    let mut child = hanging(shell, "output/rename");
    send(&child, "INT");
    std::thread::sleep(Duration::from_millis(200));
    // Systems without /proc don't tell that it was ignored.
    if cfg!(target_os = "linux") {
        assert_eq!(child.try_wait().unwrap(), None, "as in a shell's job in the background");
    }
    // A terminal that is closed.
    assert_eq!(end(child, "HUP").signal(), Some(1));
    assert_eq!(std::fs::read_dir(folder.path().join("out")).unwrap().count(), 0);
}
