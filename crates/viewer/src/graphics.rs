//! What goes with a device when it is lost: the worker and the screen.

use std::sync::Arc;

use winit::event_loop::EventLoopProxy;
use winit::window::Window;

use super::app::Wake;
use super::worker::{Held, News, Setup, Worker};
use pellucid_engine::Result;
use pellucid_engine::gpu::window::{Screen, Textures};
use pellucid_engine::gpu::{Device, DeviceOptions, ValidationLog};

/// How a device is opened, each time.
pub struct Opening {
    pub options: DeviceOptions,
    pub setup: Setup,
    pub proxy: EventLoopProxy<Wake>,
}

/// The fields go in this order: the worker is the first to end.
pub struct Graphics {
    pub worker: Worker,
    pub screen: Screen,
    pub device: Device,
}

impl Graphics {
    /// Opens a device for a window that no other device shows pictures in, with what an earlier one has left. `log` gets what the
    /// validation layers will say.
    ///
    /// # Errors
    /// Whatever keeps it from being opened.
    pub fn open(
        opening: &Opening,
        window: &Arc<Window>,
        held: Held,
        textures: Textures,
        log: &mut Vec<ValidationLog>,
    ) -> Result<Self> {
        let device = Device::open_for(&opening.options, window.clone())?;
        log.push(device.validation_log());
        let screen = Screen::new(&device, textures)?;
        let proxy = opening.proxy.clone();
        // A loop that is gone needs no news.
        let wake = move || drop(proxy.send_event(Wake));
        let worker = Worker::start(&device, held, opening.setup, wake)?;
        Ok(Self { worker, screen, device })
    }

    /// Lets go of the device, to the last handle. What is to go on: what the worker held, the news that nobody has seen, and egui's
    /// textures. `None` after a panic of the worker.
    pub fn end(self) -> Option<(Held, Vec<News>, Textures)> {
        let Self { worker, mut screen, device } = self;
        let ended = worker.end();
        let textures = screen.take_textures();
        drop(screen);
        drop(device);
        ended.map(|(held, news)| (held, news, textures))
    }
}
