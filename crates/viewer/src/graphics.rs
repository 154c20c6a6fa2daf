//! The parts that are lost together with a device: the worker and the screen.

use std::sync::Arc;

use winit::event_loop::EventLoopProxy;
use winit::window::Window;

use super::messages::{News, Setup};
use super::worker::{Worker, Workload};
use pellucid_engine::Result;
use pellucid_gpu::{Device, DeviceOptions, ValidationLog};
use pellucid_window::{Screen, Textures};

/// Settings with which a device is opened, each time.
pub struct Opening {
    pub options: DeviceOptions,
    pub setup: Setup,
    /// Wakes the loop when the worker has news.
    pub proxy: EventLoopProxy<()>,
}

/// The fields go in this order: the worker is the first to end.
pub struct Graphics {
    pub worker: Worker,
    pub screen: Screen,
    pub device: Device,
}

impl Graphics {
    /// Opens a device for a window that no other device presents to, and continues with the state an earlier device
    /// left. `log` receives the validation layers' messages.
    ///
    /// # Errors
    /// No device can be opened.
    pub fn open(
        opening: &Opening,
        window: &Arc<Window>,
        workload: Workload,
        textures: Textures,
        log: &mut Vec<ValidationLog>,
    ) -> Result<Self> {
        let device = pellucid_window::open(&opening.options, window.clone())?;
        log.push(device.validation_log());
        let screen = Screen::new(&device, textures)?;
        let proxy = opening.proxy.clone();
        // A loop that is gone needs no news.
        let wake = move || proxy.send_event(()).unwrap_or_default();
        let worker = Worker::start(&device, workload, opening.setup, screen.blue_first(), wake)?;
        Ok(Self { worker, screen, device })
    }

    /// Releases the device down to the last handle. Returns the state needed to continue: the worker's workload, unread
    /// news, and egui's textures. `None` after the worker has panicked.
    pub fn end(self) -> Option<(Workload, Vec<News>, Textures)> {
        let Self { worker, mut screen, device } = self;
        let ended = worker.end();
        let textures = screen.take_textures();
        drop(screen);
        drop(device);
        ended.map(|(workload, mut news)| {
            for news in &mut news {
                if let News::Picture(picture) = news {
                    picture.pixels = None;
                }
            }
            (workload, news, textures)
        })
    }
}
