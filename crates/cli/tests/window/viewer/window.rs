//! The viewer as a process: what it says, line by line, and how it ends.

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::{Arc, Condvar, Mutex};
use std::time::{Duration, Instant};

use pellucid_testing::shader_cache;
use pellucid_testing::signals::heeding;

/// A loaded machine that compiles shaders on the CPU may take long; a test that waits for this has failed.
const PATIENCE: Duration = Duration::from_secs(120);

type Lines = Arc<(Mutex<Vec<String>>, Condvar)>;

pub struct Window {
    pub process: Child,
    pub lines: Lines,
    /// Lines that were looked at.
    seen: usize,
}

impl Window {
    /// Opens the viewer in `folder`.
    pub fn open(folder: &Path, display: &str, arguments: &[&str]) -> Self {
        Self::open_with(folder, &[("DISPLAY", display)], arguments)
    }

    /// Opens the viewer with further variables of the environment; `DISPLAY` is one of them.
    pub fn open_with(folder: &Path, variables: &[(&str, &str)], arguments: &[&str]) -> Self {
        let variables = variables.iter().copied();
        let mut process = command(folder).envs(variables).arg("-v").args(arguments).spawn().unwrap();
        let lines = Lines::default();
        let (read, to) = (process.stderr.take().unwrap(), lines.clone());
        std::thread::spawn(move || {
            for line in BufReader::new(read).lines().map_while(Result::ok) {
                to.0.lock().unwrap().push(line);
                to.1.notify_all();
            }
        });
        Self { process, lines, seen: 0 }
    }

    /// The next line, from what was not looked at yet, that has this in it.
    #[track_caller]
    pub fn wait_for(&mut self, part: &str) -> String {
        let heard = self.hear_within(part, PATIENCE);
        heard.unwrap_or_else(|| panic!("no {part:?} in {:#?}", self.lines.0.lock().unwrap()))
    }

    /// The next line, as [`Self::wait_for`]; `None` if there is none so soon.
    #[track_caller]
    pub fn hear_within(&mut self, part: &str, patience: Duration) -> Option<String> {
        let until = Instant::now() + patience;
        let mut lines = self.lines.0.lock().unwrap();
        loop {
            if let Some(at) = lines[self.seen..].iter().position(|line| line.contains(part)) {
                self.seen += at + 1;
                return Some(lines[self.seen - 1].clone());
            }
            let left = until.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return None;
            }
            lines = self.lines.1.wait_timeout(lines, left.min(Duration::from_millis(200))).unwrap().0;
            if let Some(status) = self.process.try_wait().unwrap() {
                assert!(lines.iter().any(|line| line.contains(part)), "ended with {status}: {lines:#?}");
            }
        }
    }

    /// Left, top, width and height of a control, as they were said last.
    pub fn control(&self, key: &str) -> [i32; 4] {
        let lines = self.lines.0.lock().unwrap();
        let said = lines.iter().rev().find_map(|line| line.split_once(&format!("control {key} at "))).expect(key).1;
        let numbers: Vec<i32> = said.split([',', ' ', 'x']).map(|number| number.parse().unwrap()).collect();
        numbers.try_into().unwrap()
    }

    /// The exit status, and everything that was said.
    pub fn end(mut self) -> (Option<i32>, String) {
        let until = Instant::now() + PATIENCE;
        while self.process.try_wait().unwrap().is_none() && Instant::now() < until {
            std::thread::sleep(Duration::from_millis(50));
        }
        let status = self.process.try_wait().unwrap().and_then(|status| status.code());
        let lines = self.lines.0.lock().unwrap().join("\n");
        (status, lines)
    }
}

impl Drop for Window {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// The binary with validation and a shader cache that only tests use.
pub fn command(folder: &Path) -> Command {
    let mut command = heeding(env!("CARGO_BIN_EXE_pellucid"));
    command.current_dir(folder).env("PELLUCID_VALIDATION", "1").env("PELLUCID_CACHE_DIR", shader_cache());
    command.env_remove("WAYLAND_DISPLAY").env_remove("WAYLAND_SOCKET").env_remove("DISPLAY");
    command.stderr(Stdio::piped()).stdout(Stdio::piped());
    command
}
