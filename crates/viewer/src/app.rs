//! The window: passes its events to egui, draws egui and the last picture on the screen, and hands the worker's news to
//! the model.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

use egui::{TexturesDelta, ViewportId};
use winit::application::ApplicationHandler;
use winit::dpi::LogicalSize;
use winit::event::{ElementState, KeyEvent, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoopProxy};
use winit::keyboard::{Key, NamedKey};
use winit::window::{Fullscreen, Window, WindowId};

use super::graphics::{Graphics, Opening};
use super::loss::{self, Losses};
use super::messages::{News, Task};
use super::model::Model;
use super::status_log::StatusLog;
use super::visibility::Visibility;
use super::worker::Workload;
use super::{Options, ui};
use crate::{Error, Result};
use pellucid_gpu::ValidationLog;
use pellucid_window::{Drawing, Picture, Shown, Textures};

/// Longest time between files that are dropped one after the other and count as one drop.
const DROP: Duration = Duration::from_millis(100);

/// Delay before a window that could not be drawn to is tried again.
const RETRY: Duration = Duration::from_millis(50);

/// Delay before the next try if memory was lacking.
const RETRY_MEMORY: Duration = Duration::from_secs(1);

/// Interval at which a minimized window is checked for being restored.
const LOOK: Duration = Duration::from_millis(250);

/// Longest time for which the screen may stay unchanged while a picture is being rendered. Drawing the window takes the
/// device's only queue away from the picture and, on a CPU, the same cores.
const UNCHANGED: Duration = Duration::from_millis(50);

/// Everything that lives as long as the window. Field order matters: fields are dropped in this order, and whatever
/// belongs to a device must go before the window.
struct Running {
    /// `None` only while one device replaces another.
    graphics: Option<Graphics>,
    losses: Losses,
    model: Model,
    input: egui_winit::State,
    window: Arc<Window>,
    dropped: Vec<PathBuf>,
    dropped_at: Instant,
    /// Time at which the screen was last drawn.
    drawn_at: Instant,
    /// Texture changes egui must upload before it is drawn again.
    textures: TexturesDelta,
    /// Time at which to draw again at the latest.
    again_at: Option<Instant>,
    visibility: Visibility,
    /// True if another window covers this one.
    covered: bool,
    /// A picture request that waits until the window is visible.
    held_back: Option<Task>,
    /// The picture that is on the screen.
    shown: Option<u64>,
    status_log: StatusLog,
}

/// The application as the event loop sees it.
pub struct App {
    /// The scene to open; taken when the window is created.
    options: Option<Options>,
    opening: Opening,
    say: Box<dyn Fn(&str)>,
    running: Option<Running>,
    /// Logs of the devices that were opened.
    logs: Vec<ValidationLog>,
    /// Reason why the application ended.
    outcome: Result<()>,
}

impl App {
    pub fn new(options: Options, proxy: EventLoopProxy<()>, say: Box<dyn Fn(&str)>) -> Self {
        let opening = Opening { options: options.device.clone(), setup: options.setup, proxy };
        Self { options: Some(options), opening, say, running: None, logs: Vec::new(), outcome: Ok(()) }
    }

    /// Ends everything that runs and returns the error, if any, including validation messages.
    pub fn finish(mut self) -> Result<()> {
        self.running = None;
        self.outcome?;
        Ok(self.logs.iter().try_for_each(ValidationLog::check)?)
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
            .with_title(title(&options.named.name))
            .with_inner_size(LogicalSize::new(width, height))
            .with_min_inner_size(LogicalSize::new(64, 64));
        let window = event_loop.create_window(attributes).map_err(super::no_display)?;
        let window = Arc::new(window);
        let workload =
            Workload { sources: options.sources, generated: options.named.is_generated(), tasks: Vec::new() };
        let mut model = Model::new(options.named.name, options.named.document, options.view, options.budget_ms)?;
        if let Some((file, source)) = options.path {
            model.take_path(file, source);
        }
        let graphics = Graphics::open(&self.opening, &window, workload, Textures::default(), &mut self.logs)?;
        model.progress = graphics.worker.progress.clone();
        let visibility = Visibility::for_window(&window);
        let ctx = egui::Context::default();
        ui::style(&ctx);
        let scale = Some(window.scale_factor() as f32);
        let input = egui_winit::State::new(ctx, ViewportId::ROOT, &window, scale, window.theme(), None);
        let now = Instant::now();
        Ok(Running {
            graphics: Some(graphics),
            losses: Losses::default(),
            model,
            input,
            window,
            dropped: Vec::new(),
            dropped_at: now,
            drawn_at: now,
            textures: TexturesDelta::default(),
            again_at: Some(now),
            visibility,
            covered: false,
            held_back: None,
            shown: None,
            status_log: StatusLog::default(),
        })
    }

    /// Runs `step` on the running window; an error ends it.
    fn with_running(
        &mut self,
        event_loop: &ActiveEventLoop,
        step: impl FnOnce(&mut Running, &dyn Fn(&str)) -> Result<bool>,
    ) {
        let Some(running) = &mut self.running else { return };
        match step(running, &self.say) {
            Ok(false) => {}
            Ok(true) => event_loop.exit(),
            Err(error) => {
                let during = if let Error::Engine(error) = &error { loss::during(error) } else { None };
                let begun_anew = match during {
                    Some(during) => running.begin_anew(&self.opening, during, &mut self.logs),
                    None => Err(error),
                };
                match begun_anew {
                    // Printed at once, because the next movement of a control clears the message.
                    Ok(()) => running.status_log.report(&self.say, &running.model),
                    Err(error) => self.end(event_loop, Err(error)),
                }
            }
        }
    }
}

fn is_full_screen_key(event: &KeyEvent) -> bool {
    event.state == ElementState::Pressed && !event.repeat && event.logical_key == Key::Named(NamedKey::F11)
}

fn title(name: &str) -> String {
    format!("{name} – pellucid")
}

impl ApplicationHandler for App {
    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        let Some(options) = self.options.take() else { return };
        match self.start(event_loop, options) {
            Ok(running) => self.running = Some(running),
            Err(error) => self.end(event_loop, Err(error)),
        }
    }

    fn user_event(&mut self, event_loop: &ActiveEventLoop, (): ()) {
        self.with_running(event_loop, |running, _| {
            while let Some(news) = running.graphics.as_ref().and_then(|graphics| graphics.worker.news()) {
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
        // The device must go before the connection to the display. This waits for the frame in flight, which needs no
        // window to look at.
        if let Some(running) = self.running.take() {
            running.window.set_visible(false);
        }
    }
}

impl Running {
    /// Opens the lost device again and continues with everything the window workload.
    ///
    /// # Errors
    /// The reason for the loss if reopening doesn't help.
    fn begin_anew(&mut self, opening: &Opening, during: &str, logs: &mut Vec<ValidationLog>) -> Result<()> {
        let Some(graphics) = self.graphics.take() else { return Ok(()) };
        let (device, during) = (graphics.device.info().name.clone(), during.to_owned());
        self.model.release_picture();
        // The new device takes over the window, so the old one must have released it.
        let Some((workload, news, textures)) = graphics.end() else {
            let why = "the renderer panicked".to_owned();
            return Err(Error::NotReopened { device, during, why });
        };
        if !self.losses.allow(Instant::now(), self.shown) {
            return Err(Error::LostAgain { device, during });
        }
        // News that arrived before the loss is still worth reporting.
        self.model.message = None;
        news.into_iter().filter(|news| !matches!(news, News::Lost(_))).try_for_each(|news| self.model.take_in(news))?;
        let before = self.model.message.take().map(|(text, _)| format!("{text}; ")).unwrap_or_default();
        let busy = !workload.tasks.is_empty();
        let opened = Graphics::open(opening, &self.window, workload, textures, logs);
        let graphics = match opened {
            Ok(graphics) => graphics,
            Err(error) => return Err(Error::NotReopened { device, during, why: error.to_string() }),
        };
        let name = &graphics.device.info().name;
        let what = if *name == device { "opened again".to_owned() } else { format!("{name} was opened instead") };
        self.model.start_anew(format!("{before}the device was lost (during {during}) and {what}"), busy);
        self.model.progress = graphics.worker.progress.clone();
        self.graphics = Some(graphics);
        self.held_back = None;
        self.losses.opened(Instant::now(), self.shown);
        self.window.request_redraw();
        Ok(())
    }

    /// Handles an event and returns true if the window should close.
    fn react(&mut self, event: &WindowEvent) -> Result<bool> {
        match event {
            WindowEvent::RedrawRequested => return self.draw(),
            WindowEvent::Resized(_) | WindowEvent::ScaleFactorChanged { .. } => {
                if let Some(graphics) = &mut self.graphics {
                    graphics.screen.resized();
                }
            }
            WindowEvent::Occluded(covered) => {
                self.covered = *covered;
                self.window.request_redraw();
            }
            WindowEvent::KeyboardInput { event, .. } if is_full_screen_key(event) => {
                let full = self.window.fullscreen().is_none();
                self.window.set_fullscreen(full.then_some(Fullscreen::Borderless(None)));
                return Ok(false);
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

    /// Handles a mouse button that goes down or up. It gets its own frame, after one with all earlier events: a drag
    /// that begins and ends between two frames would be lost otherwise.
    fn press(&mut self, event: &WindowEvent) -> Result<bool> {
        let before = self.draw()?;
        // Draw the response now.
        let _ = self.input.on_window_event(&self.window, event);
        Ok(self.draw()? || before)
    }

    /// Does the work that is due before the loop waits, and returns until when it may wait.
    fn wait(&mut self, say: &dyn Fn(&str)) -> Option<Instant> {
        let now = Instant::now();
        if !self.dropped.is_empty() && now >= self.dropped_at + DROP {
            let files = std::mem::take(&mut self.dropped);
            self.model.open(files);
            self.window.request_redraw();
        }
        self.ask(now, say);
        if self.again_at.is_some_and(|at| now >= at) {
            self.again_at = None;
            self.window.request_redraw();
        }
        self.status_log.report(say, &self.model);
        if self.model.is_at_rest(now)
            && let Some(graphics) = &self.graphics
        {
            self.status_log.report_at_rest(say, &self.model, self.shown, &graphics.device);
        }
        let drop_at = (!self.dropped.is_empty()).then(|| self.dropped_at + DROP);
        [self.again_at, self.model.due_at(now), drop_at].into_iter().flatten().min()
    }

    fn is_minimized(&self) -> bool {
        self.visibility.is_minimized(&self.window)
    }

    /// Sends the worker the tasks that are due; pictures only while the window is visible.
    fn ask(&mut self, now: Instant, say: &dyn Fn(&str)) {
        let Some(graphics) = &self.graphics else { return };
        while let Some(task) = self.model.next_task(now) {
            match task {
                Task::Open(_) | Task::Cameras(_) | Task::Save(_) => graphics.worker.ask(task),
                task => self.held_back = Some(task),
            }
        }
        let hidden = self.held_back.is_some() && (self.covered || self.is_minimized());
        if let Some(task) = self.held_back.take_if(|_| !hidden) {
            graphics.worker.ask(task);
        }
        if hidden {
            self.again_at = self.again_at.or(Some(now + LOOK));
        }
        self.status_log.report_hidden(say, hidden);
    }

    /// Returns the time until which the screen may stay unchanged because a picture in progress would replace the
    /// current one.
    fn unchanged_until(&self) -> Option<Instant> {
        let seen = self.shown == self.model.picture().map(|picture| picture.serial);
        let until = self.drawn_at + UNCHANGED;
        (seen && self.model.is_waiting() && Instant::now() < until).then_some(until)
    }

    /// Draws the panel together with the picture. Returns true if the window should close.
    fn draw(&mut self) -> Result<bool> {
        let size: [u32; 2] = self.window.inner_size().into();
        if self.covered || size.contains(&0) {
            return Ok(false);
        }
        if self.is_minimized() {
            self.again_at = Some(Instant::now() + LOOK);
            return Ok(false);
        }
        let input = self.input.take_egui_input(&self.window);
        let (ctx, mut close) = (self.input.egui_ctx().clone(), false);
        let output = ctx.run(input, |ctx| close |= ui::show(ctx, &mut self.model));
        self.input.handle_platform_output(&self.window, output.platform_output);
        self.textures.append(output.textures_delta);
        if let Some(until) = self.unchanged_until() {
            self.again_at = Some(until);
            return Ok(close);
        }
        let pixels_per_point = output.pixels_per_point;
        let primitives = ctx.tessellate(output.shapes, pixels_per_point);
        let drawing = Drawing { primitives, textures: std::mem::take(&mut self.textures), pixels_per_point };
        let at = self.model.viewport().at;
        let shown = self.model.picture().and_then(|picture| Some((picture.size, picture.pixels.as_deref()?)));
        let picture = shown.map(|(size, pixels)| Picture { size, at, pixels });
        let Some(graphics) = &mut self.graphics else { return Ok(close) };
        let delay = output.viewport_output.get(&ViewportId::ROOT).map_or(Duration::MAX, |output| output.repaint_delay);
        // Wayland compositors then ask for the next frame when they can use it, and never for a window that is not
        // visible.
        let window = &self.window;
        let shown = graphics.screen.show(size, picture.as_ref(), &drawing, &|| window.pre_present_notify());
        let (shown, delay) = match shown {
            Ok(Shown::Yes) => (Shown::Yes, delay),
            Ok(Shown::NotNow) => (Shown::NotNow, delay.min(RETRY)),
            Err(error) if error.is_out_of_memory() => {
                self.model.message = Some((error.to_string(), true));
                (Shown::NotNow, delay.min(RETRY_MEMORY))
            }
            Err(error) => return Err(error.into()),
        };
        self.drawn_at = Instant::now();
        self.again_at = self.drawn_at.checked_add(delay);
        if shown == Shown::Yes {
            self.shown = self.model.picture().map(|picture| picture.serial);
        }
        Ok(close)
    }
}
