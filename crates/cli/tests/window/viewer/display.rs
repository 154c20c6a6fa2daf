//! A display without a screen (Xvfb), the pointer and keys of a user (xdotool), and what is to be seen.

use std::io::{BufRead, BufReader};
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};

use tempfile::TempDir;

pub const SIZE: [usize; 2] = [1000, 900];

pub struct Display {
    server: Child,
    pub name: String,
    memory: TempDir,
}

impl Display {
    /// Starts one on a free number; `None` where Xvfb or xdotool is not installed.
    pub fn start() -> Option<Self> {
        Command::new("xdotool").arg("version").output().ok()?;
        let memory = tempfile::tempdir_in(env!("CARGO_TARGET_TMPDIR")).unwrap();
        let screen = format!("{}x{}x24", SIZE[0], SIZE[1]);
        let mut server = Command::new("Xvfb")
            .args(["-displayfd", "1", "-noreset", "-nolisten", "tcp", "-screen", "0", &screen, "-fbdir"])
            .arg(memory.path())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .ok()?;
        let mut number = String::new();
        BufReader::new(server.stdout.take()?).read_line(&mut number).unwrap();
        assert!(!number.trim().is_empty(), "Xvfb did not start");
        Some(Self { server, name: format!(":{}", number.trim()), memory })
    }

    /// Runs xdotool; what it prints.
    pub fn do_it(&self, arguments: &str) -> String {
        let output = Command::new("xdotool").env("DISPLAY", &self.name).args(arguments.split(' ')).output().unwrap();
        assert!(output.status.success(), "xdotool {arguments}: {output:?}");
        String::from_utf8(output.stdout).unwrap().trim().to_owned()
    }

    /// Drags with a button from one place to another, in some steps.
    pub fn drag(&self, button: u32, from: [i32; 2], to: [i32; 2]) {
        self.do_it(&format!("mousemove {} {}", from[0], from[1]));
        self.do_it(&format!("mousedown {button}"));
        for step in 1..=8 {
            let at = |i: usize| from[i] + (to[i] - from[i]) * step / 8;
            self.do_it(&format!("mousemove {} {}", at(0), at(1)));
            // As fast as a hand, so that it is a drag and no jump.
            std::thread::sleep(std::time::Duration::from_millis(15));
        }
        self.do_it(&format!("mouseup {button}"));
    }

    /// R, G, B of the screen's pixels, row by row: its memory is a window dump (X11's XWDFile.h).
    pub fn pixels(&self) -> Vec<[u8; 3]> {
        let file: PathBuf = self.memory.path().join("Xvfb_screen0");
        let dump = std::fs::read(file).unwrap();
        let word = |at: usize| u32::from_be_bytes(dump[4 * at..4 * at + 4].try_into().unwrap()) as usize;
        let (header, width, height, pitch, colors) = (word(0), word(4), word(5), word(12), word(19));
        assert_eq!([width, height], SIZE);
        let start = header + 12 * colors;
        let row = |y: usize| &dump[start + y * pitch..start + y * pitch + 4 * width];
        (0..height).flat_map(|y| row(y).chunks_exact(4).map(|bgrx| [bgrx[2], bgrx[1], bgrx[0]])).collect()
    }
}

impl Drop for Display {
    fn drop(&mut self) {
        let _ = self.server.kill();
        let _ = self.server.wait();
    }
}
