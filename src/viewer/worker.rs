//! The thread that renders, so that the window answers however long a frame takes.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::mpsc::{self, Receiver, Sender};
use std::thread::JoinHandle;

use indicatif::ProgressBar;

use super::display::Display;
use super::navigate::Subject;
use super::save::{self, Saving};
use super::stage::{Pose, Stage, Taken};
use crate::camera::Camera;
use crate::gpu::{self, Device};
use crate::methods::{Facts, FrameProfile};
use crate::plan::Step;
use crate::scene::{self, Document, Opened, Overrides, Scene};
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

/// The thread and its two ends.
pub struct Worker {
    /// What keeps the next picture waiting: a message and how much of it is done; no message while nothing does.
    pub progress: ProgressBar,
    tasks: Option<Sender<Task>>,
    news: Receiver<News>,
    thread: Option<JoinHandle<()>>,
}

impl Worker {
    /// Starts the thread. `wake` is called after each piece of news.
    pub fn start(device: &Device, opened: Opened, setup: Setup, wake: impl Fn() + Send + 'static) -> Result<Self> {
        let (tasks, waiting) = mpsc::channel();
        let (teller, news) = mpsc::channel();
        let stage = Stage::new(device, opened.clouds, setup.seed, setup.memory_budget)?;
        let progress = stage.progress.clone();
        let mut work = Work { stage, setup, generated: opened.generated, display: Display::new() };
        let thread = std::thread::spawn(move || {
            while let Ok(task) = waiting.recv() {
                for task in latest(task, &waiting) {
                    let news = work.run(task);
                    // Nobody listens any more: the window is closed.
                    if teller.send(news).is_err() {
                        return;
                    }
                    wake();
                }
            }
        });
        Ok(Self { progress, tasks: Some(tasks), news, thread: Some(thread) })
    }

    /// Asks for something.
    pub fn ask(&self, task: Task) {
        if let Some(tasks) = &self.tasks {
            // A thread that is gone has said why.
            let _ = tasks.send(task);
        }
    }

    /// The next piece of news, if there is one.
    pub fn news(&self) -> Option<News> {
        self.news.try_recv().ok()
    }
}

impl Drop for Worker {
    fn drop(&mut self) {
        self.tasks = None;
        if let Some(thread) = self.thread.take() {
            // A panic there was printed by the thread itself.
            let _ = thread.join();
        }
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
    fn run(&mut self, task: Task) -> News {
        let (serial, done) = match task {
            Task::Show(request) => (request.serial, self.show(&request)),
            Task::Open(files) => (0, self.open(&files)),
            Task::Save(saving) => (0, self.save(&saving)),
        };
        done.unwrap_or_else(|error| match error {
            Error::Gpu(gpu::Error::Lost { .. }) => News::Lost(error),
            Error::Render(crate::methods::Error::Gpu(gpu::Error::Lost { .. })) => News::Lost(error),
            error => News::Failed(serial, error.to_string()),
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
        let progress = self.stage.progress.clone();
        let opened = scene::open(files, &Overrides::default(), self.setup.seed, &progress);
        progress.set_message("");
        let opened = opened?;
        let device = self.stage.renderer().device().clone();
        self.stage = Stage::new(&device, opened.clouds, self.setup.seed, self.setup.memory_budget)?;
        self.stage.progress = progress;
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
