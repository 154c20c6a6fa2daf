//! The window of `pellucid view`: live pictures of the scene that `render` renders.
//!
//! - `navigate`: the camera and its movements; `pointer`: the actions of pointer and keys.
//! - `model`: the scene being edited ([`Document`](pellucid_scene::Document)), the last picture, and when the
//!   next one is due.
//! - `history`: steps that can be undone.
//! - `route`: key frames and the motion through them; `dialog`: chooses files to open or to save to.
//! - `messages`: the requests of the window, and the replies of the worker.
//! - `worker`, a thread, owns a `stage`: the clouds in memory or in stores, and the
//!   [`Session`](pellucid_session::Session) that `render` uses, too. `draft` decides what is left out while things
//!   move: samples, pixels and points (`thinned`). `accuracy` measures the error of drafts and approximations, `times`
//!   keeps frame times, `save` writes scene and picture, `display` converts pixels to bytes.
//! - `graphics`: the worker and the screen of one device; `loss`: decides if a lost device is opened again.
//! - `visibility`: detects a minimized window; `status_log`: the lines that `-v` prints.
//! - `app` owns the window: passes events to egui, draws `ui` (`panel` with its `controls`, `overlay`, `legend`,
//!   `handles` of clip boxes) and hands the picture to the [`Screen`](pellucid_window::Screen).

pub mod accuracy;
mod app;
pub mod controls;
mod counts;
mod dialog;
pub mod display;
pub mod draft;
mod error;
mod graphics;
mod handles;
mod hints;
mod history;
mod legend;
mod loss;
pub mod messages;
pub mod model;
pub mod navigate;
mod overlay;
mod panel;
pub mod pointer;
mod route;
mod save;
pub mod stage;
pub mod statistics;
mod status_log;
mod thinned;
mod times;
mod ui;
mod visibility;
pub mod worker;

pub use error::{Error, Result};
pub use messages::Setup;
use std::path::PathBuf;

use winit::event_loop::EventLoop;

use pellucid_core::camera::import::CameraSource;
use pellucid_gpu::DeviceOptions;
use pellucid_scene::{Named, View};
use pellucid_session::Sources;

/// The scene to show, and the settings of the window.
pub struct Options {
    /// The scene.
    pub named: Named,
    /// The clouds of the scene.
    pub sources: Sources,
    /// The view asked for, if any.
    pub view: View,
    /// Settings that stay the same when other files are opened.
    pub setup: Setup,
    /// The device to open.
    pub device: DeviceOptions,
    /// Columns and rows of the window, in pixels of a display of ordinary density.
    pub size: [u32; 2],
    /// Milliseconds that a frame should take while things move.
    pub budget_ms: f64,
    /// Cameras whose keys the window begins with, and the file that they are from.
    pub path: Option<(PathBuf, CameraSource)>,
}

fn no_display(reason: impl std::fmt::Display) -> Error {
    Error::NoDisplay(plain(&reason.to_string()))
}

/// A reason without the place in the window library's source that it begins with, and without a full stop.
fn plain(reason: &str) -> String {
    let told = reason.split_once(".rs:").and_then(|(_, rest)| rest.split_once(": ")).map_or(reason, |(_, told)| told);
    told.trim().trim_end_matches('.').to_owned()
}

/// A connection to the display.
pub struct Display(EventLoop<()>);

impl Display {
    /// Connects, which is only possible on the main thread.
    ///
    /// # Errors
    /// [`Error::NoDisplay`] if there is none, or if a library that it needs is missing.
    pub fn connect() -> Result<Self> {
        // The window library panics where a library of the system is missing.
        let hook = std::panic::take_hook();
        std::panic::set_hook(Box::new(|_| {}));
        let made = std::panic::catch_unwind(EventLoop::new);
        std::panic::set_hook(hook);
        match made {
            Ok(Ok(event_loop)) => Ok(Self(event_loop)),
            Ok(Err(error)) => Err(no_display(error)),
            Err(panic) => {
                let text = panic.downcast_ref::<String>().map(String::as_str).or(panic.downcast_ref::<&str>().copied());
                Err(no_display(text.unwrap_or("the window library gave up")))
            }
        }
    }

    /// Shows a scene in a window until it is closed. `say` receives messages, line by line.
    ///
    /// # Errors
    /// No device that can present to the window, one that is lost repeatedly, a display that ends, validation
    /// messages. Later errors of the scene or of a setting are shown in the window.
    pub fn show(self, options: Options, say: Box<dyn Fn(&str)>) -> Result<()> {
        let mut app = app::App::new(options, self.0.create_proxy(), say);
        let ran = self.0.run_app(&mut app);
        app.finish()?;
        ran.map_err(|error| Error::DisplayEnded(plain(&error.to_string())))
    }
}

#[cfg(test)]
mod tests {
    use super::plain;

    #[test]
    fn reasons_are_for_people() {
        let long = "os error at /home/x/winit-0.30.13/src/platform_impl/linux/mod.rs:765: neither A nor B is set.";
        assert_eq!(plain(long), "neither A nor B is set");
        assert_eq!(plain("Library libX.so could not be loaded."), "Library libX.so could not be loaded");
    }
}
