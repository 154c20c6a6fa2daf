//! Tests that can't run here say so in one form, and fail where everything is required.

use std::io::Write as _;
use std::panic::Location;

/// No Vulkan device with validation layers.
pub const NO_DEVICE: &str = "no device";
/// The real clouds that the repository doesn't hold.
pub const NO_DATA: &str = "no real clouds";
/// No Xvfb or no xdotool.
pub const NO_DISPLAY: &str = "no display";
/// The device shows nothing in windows; SwiftShader doesn't.
pub const NO_PRESENTING: &str = "no device for windows";
/// No window manager that minimizes: ctwm.
pub const NO_WINDOW_MANAGER: &str = "no window manager";
/// No Wayland compositor: weston.
pub const NO_COMPOSITOR: &str = "no compositor";
/// No browser.
pub const NO_BROWSER: &str = "no browser";
/// No program of another name.
pub const NO_PROGRAM: &str = "no program";
/// No Python with OpenEXR, which comes from PyPI.
pub const NO_OPENEXR: &str = "no OpenEXR";
/// A user may not mount file systems in a namespace of their own.
pub const NO_MOUNTS: &str = "no mounts";
/// The device itself needs larger files than a limit on their size allows.
pub const NO_FILE_LIMIT: &str = "no limit on files";
/// The device has no 64-bit atomics, or counts no invocations.
pub const NO_ATOMICS: &str = "no 64-bit atomics or no statistics";
/// No driver whose manifest can be taken away.
pub const NO_MANIFEST: &str = "no driver to take away";

/// Reasons that don't count where only a device is required (`PELLUCID_REQUIRE_GPU`): `tools/setup.sh --tests` can't
/// provide what is missing, or leaves it out.
const OPTIONAL: [&str; 7] = [NO_DATA, NO_PRESENTING, NO_COMPOSITOR, NO_OPENEXR, NO_MOUNTS, NO_FILE_LIMIT, NO_MANIFEST];

/// Says that a test, or a part of it, is skipped: `skipped: <test>: <reason>: <detail>` on standard error, even if the
/// test's output is captured. The reason is one of this module's constants.
///
/// # Panics
/// Panics with `PELLUCID_REQUIRE_ALL` at 1, unless the reason is in the list `PELLUCID_ALLOWED_SKIPS`, which has
/// semicolons between reasons. With `PELLUCID_REQUIRE_GPU` at 1 as well, but without a list the reasons for which
/// nobody can install a remedy are allowed.
#[track_caller]
pub fn skip(reason: &str, detail: &str) {
    let caller = Location::caller();
    let thread = std::thread::current();
    // With one thread tests run on the main one.
    let test = match thread.name() {
        Some(name) if name != "main" => name.to_owned(),
        _ => format!("{}:{}", caller.file(), caller.line()),
    };
    let separator = if detail.is_empty() { "" } else { ": " };
    let line = format!("skipped: {test}: {reason}{separator}{detail}");
    // Unlike what macros print this isn't captured.
    let _ = writeln!(std::io::stderr(), "{line}");
    let is_set = |name: &str| std::env::var(name).is_ok_and(|value| value == "1");
    let listed = std::env::var("PELLUCID_ALLOWED_SKIPS").ok();
    let required = Required { all: is_set("PELLUCID_REQUIRE_ALL"), device: is_set("PELLUCID_REQUIRE_GPU"), listed };
    assert!(required.allows(reason), "{line}: not an allowed reason");
}

/// The tests that must not be skipped.
struct Required {
    all: bool,
    device: bool,
    /// Allowed reasons, with semicolons between them.
    listed: Option<String>,
}

impl Required {
    fn allows(&self, reason: &str) -> bool {
        match &self.listed {
            _ if !self.all && !self.device => true,
            Some(list) => list.split(';').any(|allowed| allowed.trim() == reason),
            None => !self.all && OPTIONAL.contains(&reason),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_listed_reasons_are_allowed() {
        let allows = |all, device, listed: Option<&str>, reason| {
            Required { all, device, listed: listed.map(str::to_owned) }.allows(reason)
        };
        for reason in [NO_DEVICE, NO_DATA] {
            assert!(allows(false, false, None, reason) && allows(false, false, Some(""), reason));
            assert!(!allows(true, true, None, reason) && !allows(true, false, Some(""), reason));
        }
        let list = Some("no real clouds; no compositor");
        for (reason, allowed) in [(NO_DATA, true), (NO_COMPOSITOR, true), (NO_DEVICE, false), ("no", false)] {
            assert_eq!(allows(true, false, list, reason), allowed, "{reason}");
            assert_eq!(allows(false, true, list, reason), allowed, "{reason}");
        }
        assert!(!allows(false, true, None, NO_DEVICE) && allows(false, true, None, NO_MOUNTS));
    }
}
