//! The window: its events to egui, egui's drawing and the last picture to the screen, the worker's news to the model.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

use egui::ViewportId;
use winit::application::ApplicationHandler;
use winit::dpi::LogicalSize;
use winit::event::WindowEvent;
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoopProxy};
use winit::window::{Window, WindowId};

use super::model::Model;
use super::worker::{Setup, Worker};
use super::{Options, ui};
use crate::Result;
use crate::gpu::window::{Drawing, Picture, Screen, Shown};
use crate::gpu::{Device, ValidationLog};

/// How long files that are dropped one after the other may take to count as one drop.
const DROP: Duration = Duration::from_millis(100);

/// How long to wait before a window that could not be drawn to is tried again.
const RETRY: Duration = Duration::from_millis(50);

/// The worker has news.
#[derive(Debug)]
pub struct Wake;

/// What runs while the window is there. The fields go in this order: the worker and the screen before the window.
struct Running {
    worker: Worker,
    screen: Screen,
    model: Model,
    input: egui_winit::State,
    window: Arc<Window>,
    dropped: Vec<PathBuf>,
    dropped_at: Instant,
    /// When to draw again, whatever happens.
    again_at: Option<Instant>,
    /// Whether nobody can see the window.
    hidden: bool,
    /// The picture that is on the screen.
    shown: Option<u64>,
    said: Said,
}

/// What was told to whoever asked for more.
#[derive(Default)]
struct Said {
    at_rest: Option<u64>,
    message: Option<String>,
    controls: Vec<(String, [i32; 4])>,
}

/// The application as the event loop sees it.
pub struct App {
    /// What to open; taken when the window is made.
    options: Option<Options>,
    proxy: EventLoopProxy<Wake>,
    say: Box<dyn Fn(&str)>,
    running: Option<Running>,
    log: Option<ValidationLog>,
    /// What ended it.
    outcome: Result<()>,
}

impl App {
    pub fn new(options: Options, proxy: EventLoopProxy<Wake>, say: Box<dyn Fn(&str)>) -> Self {
        Self { options: Some(options), proxy, say, running: None, log: None, outcome: Ok(()) }
    }

    /// Ends all that runs, and says what went wrong, validation messages included.
    pub fn finish(mut self) -> Result<()> {
        self.running = None;
        self.outcome?;
        Ok(self.log.map_or(Ok(()), |log| log.check())?)
    }

    fn end(&mut self, event_loop: &ActiveEventLoop, outcome: Result<()>) {
        if self.outcome.is_ok() {
            self.outcome = outcome;
        }
        event_loop.exit();
    }

    fn start(&mut self, event_loop: &ActiveEventLoop, options: Options) -> Result<Running> {
        let [width, height] = options.size;
        let attributes = Window::default_attributes()
            .with_title(title(&options.opened.name))
            .with_inner_size(LogicalSize::new(width, height))
            .with_min_inner_size(LogicalSize::new(64, 64));
        let window = event_loop.create_window(attributes).map_err(super::no_display)?;
        let window = Arc::new(window);
        let device = Device::open_for(&options.device, window.clone())?;
        self.log = Some(device.validation_log());
        let screen = Screen::new(&device)?;
        let proxy = self.proxy.clone();
        let (name, document) = (options.opened.name.clone(), options.opened.document.clone());
        let setup = Setup { seed: options.seed, memory_budget: options.memory_budget };
        // A loop that is gone needs no news.
        let wake = move || drop(proxy.send_event(Wake));
        let worker = Worker::start(&device, options.opened, setup, wake)?;
        let mut model = Model::new(name, document, options.view, options.budget_ms)?;
        if let Some((file, source)) = options.path {
            model.take_path(file, source);
        }
        model.progress = worker.progress.clone();
        let ctx = egui::Context::default();
        ui::style(&ctx);
        let scale = Some(window.scale_factor() as f32);
        let input = egui_winit::State::new(ctx, ViewportId::ROOT, &window, scale, window.theme(), None);
        let now = Instant::now();
        Ok(Running {
            worker,
            screen,
            model,
            input,
            window,
            dropped: Vec::new(),
            dropped_at: now,
            again_at: Some(now),
            hidden: false,
            shown: None,
            said: Said::default(),
        })
    }

    /// Runs `step` on what runs; an error ends it.
    fn with_running(
        &mut self,
        event_loop: &ActiveEventLoop,
        step: impl FnOnce(&mut Running, &dyn Fn(&str)) -> Result<bool>,
    ) {
        let Some(running) = &mut self.running else { return };
        match step(running, &self.say) {
            Ok(false) => {}
            Ok(true) => event_loop.exit(),
            Err(error) => self.end(event_loop, Err(error)),
        }
    }
}

fn title(name: &str) -> String {
    format!("{name} – pellucid")
}

impl ApplicationHandler<Wake> for App {
    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        let Some(options) = self.options.take() else { return };
        match self.start(event_loop, options) {
            Ok(running) => self.running = Some(running),
            Err(error) => self.end(event_loop, Err(error)),
        }
    }

    fn user_event(&mut self, event_loop: &ActiveEventLoop, _: Wake) {
        self.with_running(event_loop, |running, _| {
            while let Some(news) = running.worker.news() {
                running.model.take_in(news)?;
            }
            running.window.set_title(&title(&running.model.name));
            running.window.request_redraw();
            Ok(false)
        });
    }

    fn window_event(&mut self, event_loop: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        if let WindowEvent::CloseRequested = event {
            return self.end(event_loop, Ok(()));
        }
        self.with_running(event_loop, |running, _| running.react(&event));
    }

    fn about_to_wait(&mut self, event_loop: &ActiveEventLoop) {
        self.with_running(event_loop, |running, say| {
            let wait = running.wait(say);
            event_loop.set_control_flow(wait.map_or(ControlFlow::Wait, ControlFlow::WaitUntil));
            Ok(false)
        });
    }

    fn exiting(&mut self, _: &ActiveEventLoop) {
        // Before the connection to the display goes.
        self.running = None;
    }
}

impl Running {
    /// Takes in an event; whether the window is to be closed.
    fn react(&mut self, event: &WindowEvent) -> Result<bool> {
        match event {
            WindowEvent::RedrawRequested => return self.draw(),
            WindowEvent::Resized(_) | WindowEvent::ScaleFactorChanged { .. } => self.screen.resized(),
            WindowEvent::Occluded(hidden) => {
                self.hidden = *hidden;
                self.window.request_redraw();
            }
            WindowEvent::DroppedFile(path) => {
                self.dropped.push(path.clone());
                self.dropped_at = Instant::now();
            }
            _ => {}
        }
        if let WindowEvent::MouseInput { .. } = event {
            return self.press(event);
        }
        if self.input.on_window_event(&self.window, event).repaint {
            self.window.request_redraw();
        }
        Ok(false)
    }

    /// A button goes down or up: a frame of its own, after one with all that came before, since a drag that began and ended
    /// between two frames would be none.
    fn press(&mut self, event: &WindowEvent) -> Result<bool> {
        let before = self.draw()?;
        // What it asks for is drawn now.
        let _ = self.input.on_window_event(&self.window, event);
        Ok(self.draw()? || before)
    }

    /// What is due before the loop waits, and until when it may.
    fn wait(&mut self, say: &dyn Fn(&str)) -> Option<Instant> {
        let now = Instant::now();
        if !self.dropped.is_empty() && now >= self.dropped_at + DROP {
            let files = std::mem::take(&mut self.dropped);
            self.model.open(files);
            self.window.request_redraw();
        }
        while let Some(task) = self.model.next_task(now) {
            self.worker.ask(task);
        }
        if self.again_at.is_some_and(|at| now >= at) {
            self.again_at = None;
            self.window.request_redraw();
        }
        self.tell(say);
        self.tell_at_rest(say, now);
        let drop_at = (!self.dropped.is_empty()).then(|| self.dropped_at + DROP);
        [self.again_at, self.model.due_at(now), drop_at].into_iter().flatten().min()
    }

    /// Draws the panel and shows it with the picture; whether the window is to be closed.
    fn draw(&mut self) -> Result<bool> {
        let size: [u32; 2] = self.window.inner_size().into();
        if self.hidden || size.contains(&0) {
            return Ok(false);
        }
        let input = self.input.take_egui_input(&self.window);
        let (ctx, mut close) = (self.input.egui_ctx().clone(), false);
        let output = ctx.run(input, |ctx| close |= ui::show(ctx, &mut self.model));
        self.input.handle_platform_output(&self.window, output.platform_output);
        let pixels_per_point = output.pixels_per_point;
        let primitives = ctx.tessellate(output.shapes, pixels_per_point);
        let drawing = Drawing { primitives, textures: output.textures_delta, pixels_per_point };
        let at = self.model.viewport().at;
        let picture = self.model.picture().map(|picture| Picture { size: picture.size, at, rgba: &picture.rgba });
        let shown = self.screen.show(size, picture.as_ref(), &drawing)?;
        let delay = output.viewport_output.get(&ViewportId::ROOT).map_or(Duration::MAX, |output| output.repaint_delay);
        let delay = if shown == Shown::NotNow { delay.min(RETRY) } else { delay };
        self.again_at = Instant::now().checked_add(delay);
        if shown == Shown::Yes {
            self.shown = self.model.picture().map(|picture| picture.serial);
        }
        Ok(close)
    }

    /// Says that the picture on the screen is as it should be, once for each.
    fn tell_at_rest(&mut self, say: &dyn Fn(&str), now: Instant) {
        let Some(picture) = self.model.picture().filter(|_| self.model.is_at_rest(now)) else { return };
        if self.shown == Some(picture.serial) && self.said.at_rest != self.shown {
            let ([width, height], ms) = (picture.size, picture.profile.wall.as_secs_f64() * 1e3);
            say(&format!("at rest: frame {}, {width} × {height}, {}, {ms:.1} ms", picture.serial, picture.method));
            self.said.at_rest = Some(picture.serial);
        }
    }

    fn tell(&mut self, say: &dyn Fn(&str)) {
        let message = self.model.message.as_ref().map(|(text, _)| text.clone());
        if message != self.said.message {
            message.iter().for_each(|message| say(message));
            self.said.message = message;
        }
        let controls: Vec<_> = self.model.controls.iter().map(|(key, place)| (key.clone(), *place)).collect();
        if controls != self.said.controls {
            for (key, [left, top, width, height]) in &controls {
                say(&format!("control {key} at {left},{top} {width}x{height}"));
            }
            self.said.controls = controls;
        }
    }
}
