//! The thread that renders, so that the window answers however long a frame takes.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{self, Receiver, Sender};
use std::thread::JoinHandle;

use indicatif::ProgressBar;

use super::display::Display;
use super::loss;
use super::navigate::Subject;
use super::save::{self, Saving};
use super::stage::{Pose, Stage, Taken};
use crate::camera::Camera;
use crate::cloud::Cloud;
use crate::gpu::Device;
use crate::methods::{Facts, FrameProfile};
use crate::plan::Step;
use crate::scene::{self, Document, Overrides, Scene};
use crate::{Error, Result};

/// A picture that is wanted.
#[derive(Clone)]
pub struct Request {
    /// The scene, with the size of the picture in it.
    pub scene: Arc<Scene>,
    /// From where.
    pub pose: Pose,
    /// The time that it should keep to, in milliseconds, if something may be left out for it.
    pub budget_ms: Option<f64>,
    /// Counts requests.
    pub serial: u64,
}

/// What the thread is asked for.
pub enum Task {
    /// A picture; only the latest one counts.
    Show(Box<Request>),
    /// Other files instead of the scene.
    Open(Vec<PathBuf>),
    /// The scene as a file, with or without a picture of it.
    Save(Box<Saving>),
}

/// A picture for the window.
pub struct Picture {
    /// That of its request.
    pub serial: u64,
    /// From where it was asked for.
    pub pose: Pose,
    /// From where it is.
    pub camera: Camera,
    /// Of what.
    pub subject: Subject,
    /// Columns and rows.
    pub size: [u32; 2],
    /// R, G, B, A bytes, sRGB-encoded, row by row.
    pub rgba: Vec<u8>,
    /// Depth of each pixel, infinite where there is none.
    pub depths: Vec<f32>,
    /// Whether nothing was left out.
    pub full: bool,
    /// The method that was taken.
    pub method: &'static str,
    /// Its times.
    pub profile: FrameProfile,
    /// What it met.
    pub facts: Facts,
    /// The passes and why.
    pub plan: Vec<Step>,
}

/// What the thread has to say.
pub enum News {
    /// A picture is there.
    Picture(Box<Picture>),
    /// Other files are there: their name and keys.
    Opened(String, Box<Document>),
    /// Files were written.
    Saved(Vec<PathBuf>),
    /// The task of this serial failed (0: it had none); another one may do.
    Failed(u64, String),
    /// Nothing can be rendered any more.
    Lost(Error),
}

/// What a thread works on, at its beginning and at its end.
pub struct Held {
    /// The clouds as they were read.
    pub clouds: Vec<Cloud>,
    /// Whether no file holds them.
    pub generated: bool,
    /// What was asked for and not done, but for pictures.
    pub tasks: Vec<Task>,
}

/// What the thread is still to do.
#[derive(Default)]
struct Orders {
    /// Nothing any more.
    stop: AtomicBool,
    /// Nothing but writing what is to be saved.
    close: AtomicBool,
    /// Scenes to save.
    saves: AtomicUsize,
}

impl Orders {
    fn allow(&self, task: &Task) -> bool {
        let is_save = matches!(task, Task::Save(_));
        !self.stop.load(Ordering::Relaxed) && (is_save || !self.close.load(Ordering::Relaxed))
    }
}

/// The thread and its two ends.
pub struct Worker {
    device: Device,
    orders: Arc<Orders>,
    tasks: Option<Sender<Task>>,
    news: Receiver<News>,
    /// Gives back what it held, and the tasks that it has not looked at.
    thread: Option<JoinHandle<(Held, Receiver<Task>)>>,
}

impl Worker {
    /// Starts the thread, with tasks that it has already. `wake` is called after each piece of news.
    pub fn start(device: &Device, held: Held, setup: Setup, wake: impl Fn() + Send + 'static) -> Result<Self> {
        let (tasks, waiting) = mpsc::channel();
        let (teller, news) = mpsc::channel();
        let stage = Stage::new(device, held.clouds, setup.seed, setup.memory_budget)?;
        let work = Work { stage, setup, generated: held.generated, display: Display::new() };
        let orders = Arc::new(Orders::default());
        let tell = move |news| {
            // Nobody listens any more if the window is closed.
            let _ = teller.send(news);
            wake();
        };
        let theirs = orders.clone();
        let thread = std::thread::spawn(move || work.run_all(waiting, &theirs, tell));
        let worker = Self { device: device.clone(), orders, tasks: Some(tasks), news, thread: Some(thread) };
        held.tasks.into_iter().for_each(|task| worker.ask(task));
        Ok(worker)
    }

    /// Asks for something.
    pub fn ask(&self, task: Task) {
        if let Some(tasks) = &self.tasks {
            self.orders.saves.fetch_add(usize::from(matches!(task, Task::Save(_))), Ordering::Relaxed);
            // A thread that is gone has said why.
            let _ = tasks.send(task);
        }
    }

    /// Ends the thread as soon as it can be; what it held, and the news that nobody has seen. `None` after a panic, which the
    /// thread itself has printed.
    pub fn end(mut self) -> Option<(Held, Vec<News>)> {
        self.orders.stop.store(true, Ordering::Relaxed);
        self.device.abandon();
        self.tasks = None;
        let (mut held, waiting) = self.thread.take()?.join().ok()?;
        held.tasks.extend(waiting.try_iter());
        held.tasks.retain(|task| !matches!(task, Task::Show(_)));
        Some((held, self.news.try_iter().collect()))
    }

    /// The next piece of news, if there is one.
    pub fn news(&self) -> Option<News> {
        self.news.try_recv().ok()
    }
}

impl Drop for Worker {
    fn drop(&mut self) {
        let Some(thread) = self.thread.take() else { return };
        self.orders.close.store(true, Ordering::Relaxed);
        if self.orders.saves.load(Ordering::Relaxed) == 0 {
            self.device.abandon();
        }
        self.tasks = None;
        // A panic there was printed by the thread itself.
        let _ = thread.join();
    }
}

/// What stays the same whatever is opened.
#[derive(Debug, Clone, Copy)]
pub struct Setup {
    /// Seed of stochastic methods and of the built-in scene.
    pub seed: u64,
    /// Device bytes for a frame's fragments.
    pub memory_budget: Option<u64>,
}

struct Work {
    stage: Stage,
    setup: Setup,
    /// Whether no file holds the clouds.
    generated: bool,
    display: Display,
}

/// All that waits, without pictures that a later one replaces.
fn latest(first: Task, waiting: &Receiver<Task>) -> Vec<Task> {
    let mut tasks = vec![first];
    for task in waiting.try_iter() {
        if let (Task::Show(_), Some(Task::Show(_))) = (&task, tasks.last()) {
            tasks.pop();
        }
        tasks.push(task);
    }
    tasks
}

impl Work {
    /// Does what is asked for until nobody can ask any more or the device is lost.
    fn run_all(mut self, waiting: Receiver<Task>, orders: &Orders, tell: impl Fn(News)) -> (Held, Receiver<Task>) {
        let mut left = Vec::new();
        let mut lost = false;
        while let Some(task) = (!lost).then(|| waiting.recv().ok()).flatten() {
            for task in latest(task, &waiting) {
                if lost || !orders.allow(&task) {
                    left.push(task);
                    continue;
                }
                let news = self.run(&task);
                lost = matches!(news, News::Lost(_));
                if lost {
                    left.push(task);
                } else if let Task::Save(_) = task {
                    orders.saves.fetch_sub(1, Ordering::Relaxed);
                }
                tell(news);
            }
        }
        (Held { clouds: self.stage.into_clouds(), generated: self.generated, tasks: left }, waiting)
    }

    fn run(&mut self, task: &Task) -> News {
        let (serial, done) = match task {
            Task::Show(request) => (request.serial, self.show(request)),
            Task::Open(files) => (0, self.open(files)),
            Task::Save(saving) => (0, self.save(saving)),
        };
        done.unwrap_or_else(|error| match loss::during(&error) {
            Some(_) => News::Lost(error),
            None => News::Failed(serial, error.to_string()),
        })
    }

    fn show(&mut self, request: &Request) -> Result<News> {
        let Request { scene, pose, budget_ms, serial } = request;
        let mut taken = self.stage.take(scene, *pose, *budget_ms)?;
        let plan = self.stage.plan(&taken);
        let rgba = self.display.bytes(&taken.rendered.image, scene.image.background, scene.image.color);
        let depths = std::mem::take(&mut taken.rendered.image.depth);
        let Taken { rendered, frame, subject, full, .. } = taken;
        let picture = Picture {
            serial: *serial,
            pose: *pose,
            camera: frame.camera,
            subject,
            size: [rendered.image.width, rendered.image.height],
            rgba,
            depths,
            full,
            method: frame.method.name(),
            profile: rendered.profile,
            facts: rendered.facts,
            plan,
        };
        Ok(News::Picture(Box::new(picture)))
    }

    fn open(&mut self, files: &[PathBuf]) -> Result<News> {
        let opened = scene::open(files, &Overrides::default(), self.setup.seed, &ProgressBar::hidden())?;
        let device = self.stage.renderer().device().clone();
        self.stage = Stage::new(&device, opened.clouds, self.setup.seed, self.setup.memory_budget)?;
        self.generated = opened.generated;
        Ok(News::Opened(opened.name, Box::new(opened.document)))
    }

    fn save(&mut self, saving: &Saving) -> Result<News> {
        save::write(&mut self.stage, saving, self.generated, self.setup.seed).map(News::Saved)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_that_a_later_one_replaces_is_not_rendered() {
        let scene = Document::from_clouds(["a.ply"], &Overrides::default()).unwrap().scene().unwrap();
        let scene = Arc::new(scene);
        let show =
            |serial| Task::Show(Box::new(Request { scene: scene.clone(), pose: Pose::Scene, budget_ms: None, serial }));
        let (sender, waiting) = mpsc::channel();
        for task in [show(2), show(3), Task::Open(Vec::new()), show(4), show(5)] {
            sender.send(task).unwrap();
        }
        let kept: Vec<u64> = latest(show(1), &waiting)
            .iter()
            .map(|task| if let Task::Show(request) = task { request.serial } else { 0 })
            .collect();
        assert_eq!(kept, [3, 0, 5]);
    }
}
