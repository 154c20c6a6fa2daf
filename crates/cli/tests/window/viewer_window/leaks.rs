//! Many sizes, panels and files: afterwards nothing is held that was not held before.

use std::path::Path;

use crate::viewer::display::Display;
use crate::viewer::garden::with_display;
use crate::viewer::window::{Window, command};
use crate::viewer::x11::Client;

/// Widths and heights of the window. Buffers keep the size of the largest.
const SIZES: [[usize; 2]; 5] = [[940, 660], [900, 640], [860, 600], [920, 620], [880, 660]];

/// Resizes between the two measurements.
const RESIZES: usize = 30;

/// The resources held by the process.
#[derive(Debug)]
struct Holdings {
    device_memory: String,
    files: usize,
    resident_bytes: usize,
}

impl Holdings {
    /// Measures the resources while the window is at rest.
    fn measure(window: &mut Window) -> Self {
        let process = Path::new("/proc").join(window.process.id().to_string());
        let device_memory = window.wait_for("device memory: ");
        let status = std::fs::read_to_string(process.join("status")).unwrap();
        let resident = status.lines().find_map(|line| line.strip_prefix("VmRSS:")).unwrap();
        let kilobytes: usize = resident.trim().trim_end_matches(" kB").parse().unwrap();
        let files = std::fs::read_dir(process.join("fd")).unwrap().count();
        Self { device_memory, files, resident_bytes: 1024 * kilobytes }
    }
}

/// Brings the window to a size and waits for its picture.
fn resize(display: &Display, window: &mut Window, id: &str, [width, height]: [usize; 2]) {
    display.do_it(&format!("windowsize {id} {width} {height}"));
    window.wait_for(&format!(" {} × {height},", width - 330));
}

/// Hides the panel, opens files and changes the size so many times, ending with the largest size.
fn go_through(display: &Display, window: &mut Window, id: &str, folder: &Path, [opens, resizes]: [usize; 2]) {
    let client = Client::connect(&display.name);
    for _ in 0..opens {
        for key in ["h", "h"] {
            display.do_it(&format!("key {key}"));
            window.wait_for("at rest");
        }
        for file in ["scene.toml", "inner.ply"] {
            client.drop_files(id.parse().unwrap(), &[&folder.join(file)]);
            window.wait_for("opened");
            window.wait_for("at rest");
        }
    }
    for step in 0..resizes {
        resize(display, window, id, SIZES[(step + 1) % SIZES.len()]);
    }
}

#[test]
fn resizing_hiding_and_opening_leave_nothing_behind() {
    with_display(|display| {
        let folder = tempfile::tempdir_in(env!("CARGO_TARGET_TMPDIR")).unwrap();
        let folder = folder.path();
        let made = command(folder).args(["scene", "tori", "--set", "points=600", "-o", "."]).output().unwrap();
        assert!(made.status.success(), "{made:?}");
        // glibc's allocator keeps what it once had, the more the larger what was freed: told so, it gives pictures back
        // at once.
        let variables = [
            ("DISPLAY", display.name.as_str()),
            ("MALLOC_MMAP_THRESHOLD_", "65536"),
            ("MALLOC_TRIM_THRESHOLD_", "65536"),
        ];
        // Without drafts, whose sizes follow from how long frames take.
        let arguments = ["view", "inner.ply", "--size", "940x660", "--budget", "1e6"];
        let mut window = Window::open_with(folder, &variables, &arguments);
        window.wait_for("at rest");
        let id = display.do_it("search --sync --onlyvisible --name pellucid");
        display.do_it(&format!("windowfocus --sync {id}"));
        // Buffers that are kept have their sizes after a round.
        go_through(display, &mut window, &id, folder, [1, SIZES.len()]);
        let before = Holdings::measure(&mut window);
        go_through(display, &mut window, &id, folder, [5, RESIZES]);
        let after = Holdings::measure(&mut window);
        assert_eq!(after.device_memory, before.device_memory);
        assert_eq!(after.files, before.files);
        // Whoever kept a picture or an image of the window at each resize would hold so much more; the allocator's
        // own unrest is far below.
        let pictures: usize = (0..RESIZES).map(|i| SIZES[i % SIZES.len()]).map(|[w, h]| 4 * (w - 330) * h).sum();
        let grown = after.resident_bytes.saturating_sub(before.resident_bytes);
        assert!(grown < pictures / 2, "{before:?} {after:?}");
        display.do_it("key ctrl+q");
        // The validation layers tell at the end what was not destroyed.
        let (status, said) = window.end();
        assert_eq!(status, Some(0), "{said}");
        assert!(!said.contains("leaked") && !said.contains("validation") && !said.contains("panicked"), "{said}");
    });
}
