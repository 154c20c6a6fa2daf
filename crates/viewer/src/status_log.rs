//! Status lines for verbose output.

use std::collections::BTreeMap;

use super::model::Model;
use pellucid_gpu::Device;

/// The lines already printed, so that each is printed once.
#[derive(Default)]
pub struct StatusLog {
    at_rest: Option<u64>,
    hidden: bool,
    message: Option<String>,
    controls: BTreeMap<String, [i32; 4]>,
}

impl StatusLog {
    /// Reports that the picture on the screen is complete, once per picture, and the allocations on the device at that
    /// time. `shown` is the picture's serial.
    pub fn report_at_rest(&mut self, say: &dyn Fn(&str), model: &Model, shown: Option<u64>, device: &Device) {
        let Some(picture) = model.picture() else { return };
        if shown == Some(picture.serial) && self.at_rest != shown {
            let ([width, height], ms) = (picture.size, picture.profile.wall.as_secs_f64() * 1e3);
            say(&format!("at rest: frame {}, {width} × {height}, {}, {ms:.1} ms", picture.serial, picture.method));
            let live = device.live_allocations();
            let bytes: u64 = live.iter().map(|(_, bytes)| bytes).sum();
            say(&format!("device memory: {bytes} bytes in {} allocations", live.len()));
            self.at_rest = shown;
        }
    }

    /// Tells when pictures begin to wait for the window to be seen, and when they no longer do.
    pub fn report_hidden(&mut self, say: &dyn Fn(&str), hidden: bool) {
        if hidden != self.hidden {
            say(if hidden { "hidden: pictures wait" } else { "no picture waits any more" });
            self.hidden = hidden;
        }
    }

    /// Tells the message and where the controls are, when they change.
    pub fn report(&mut self, say: &dyn Fn(&str), model: &Model) {
        let message = model.message.as_ref().map(|(text, _)| text.clone());
        if message != self.message {
            message.iter().for_each(|message| say(message));
            self.message = message;
        }
        if self.controls != model.controls {
            for (key, [left, top, width, height]) in &model.controls {
                say(&format!("control {key} at {left},{top} {width}x{height}"));
            }
            self.controls.clone_from(&model.controls);
        }
    }
}
