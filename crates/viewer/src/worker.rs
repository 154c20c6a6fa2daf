//! The render thread, which keeps the window responsive during long frames.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, Receiver, Sender, TryRecvError};
use std::thread::JoinHandle;

use pellucid_core::progress::Progress;

use super::accuracy::{Exactness, History, Refinement};
use super::display::{self, SceneImage, ScreenEncoder};
use super::legend::Legends;
use super::loss;
use super::messages::{News, Request, Saving, Setup, Task, WindowPicture};
use super::navigate::Pose;
use super::save;
use super::stage::{SceneRenderer, TakenPicture};
use super::statistics::Statistics;
use pellucid_core::camera::import::CameraSource;
use pellucid_core::camera::path;
use pellucid_engine::methods::{self, Frame};
use pellucid_engine::{Error, Result};
use pellucid_gpu::{self as gpu, Device};
use pellucid_scene::{self as scene, Overrides, Scene};
use pellucid_session::{Silent, Sources};

/// Flags that control which tasks may be stopped.
#[derive(Default)]
struct Stops {
    /// True if the current task may be stopped.
    may: AtomicBool,
    /// True once the window is closed: only saves are still done.
    closing: AtomicBool,
    /// True if the thread should end without doing anything more.
    ending: AtomicBool,
}

impl Stops {
    fn allow(&self, task: &Task) -> bool {
        let is_save = matches!(task, Task::Save(_));
        !self.is_ending() && (is_save || !self.closing.load(Ordering::SeqCst))
    }

    fn is_ending(&self) -> bool {
        self.ending.load(Ordering::SeqCst)
    }
}

/// Wakes the event loop, also when the thread ends.
struct Bell<F: Fn()>(F);

impl<F: Fn()> Drop for Bell<F> {
    fn drop(&mut self) {
        (self.0)();
    }
}

/// The thread's sender of news. Fields drop in this order: a loop woken by the end of the thread must find the channel
/// closed.
struct Reporter<F: Fn()> {
    news: Sender<News>,
    bell: Bell<F>,
}

impl<F: Fn()> Reporter<F> {
    fn report(&self, news: News) {
        // Sending fails after the window has closed, which is fine.
        let _ = self.news.send(news);
        (self.bell.0)();
    }
}

/// The worker's state that outlives a device: handed over at start, returned at the end.
pub struct Workload {
    /// The clouds, with columns derived from them.
    pub sources: Sources,
    /// True if no file contains them.
    pub generated: bool,
    /// Requests that are still open, except pictures.
    pub tasks: Vec<Task>,
}

/// The thread and its two ends.
pub struct Worker {
    /// Progress of the work the next picture waits for; without a message while no such work runs.
    pub progress: Progress,
    tasks: Option<Sender<Task>>,
    news: Receiver<News>,
    /// Returns its workload and the tasks it has not looked at.
    thread: Option<JoinHandle<(Workload, Receiver<Task>)>>,
    device: Device,
    stops: Arc<Stops>,
}

impl Worker {
    /// Starts the thread, with tasks that it has already. Its pictures are for a screen that has blue first in memory,
    /// or red. `wake` is called after each piece of news.
    pub fn start(
        device: &Device,
        workload: Workload,
        setup: Setup,
        blue_first: bool,
        wake: impl Fn() + Send + 'static,
    ) -> Result<Self> {
        let (tasks, waiting) = mpsc::channel();
        let (reporter, news) = mpsc::channel();
        let stage = SceneRenderer::new(device, workload.sources, &setup)?;
        let progress = stage.progress.clone();
        let (encoder, history) = (ScreenEncoder::new(device, blue_first)?, History::default());
        let work = WorkerState {
            stage,
            setup,
            generated: workload.generated,
            encoder,
            history,
            unread: None,
            whole: None,
            surveyed: false,
            legends: Legends::default(),
        };
        let reporter = Reporter { news: reporter, bell: Bell(wake) };
        let stops = Arc::new(Stops::default());
        let stoppable = stops.clone();
        let thread = std::thread::spawn(move || work.run_all(waiting, &stoppable, &reporter));
        let worker = Self { progress, tasks: Some(tasks), news, thread: Some(thread), device: device.clone(), stops };
        workload.tasks.into_iter().for_each(|task| worker.ask(task));
        Ok(worker)
    }

    /// Requests a task. It replaces a picture in progress, unless that one shows movement.
    pub fn ask(&self, task: Task) {
        // Stop before sending: the new task could start at once and would be stopped itself.
        if matches!(task, Task::Show(_) | Task::Open(_)) {
            self.stop();
        }
        if let Some(tasks) = &self.tasks {
            // If the thread is gone, it has reported why.
            let _ = tasks.send(task);
        }
    }

    /// Stops the current task, if it may be stopped, at its next submission. If the thread moves on to the next task at
    /// this moment, that one may be stopped instead; it then reports so, or restarts if it must not be stopped.
    fn stop(&self) {
        if self.stops.may.load(Ordering::SeqCst) {
            self.device.allow_submissions(Some(0));
        }
    }

    /// Ends the thread as soon as possible and returns its workload and the unread news. `None` after a panic, which
    /// the thread has printed.
    pub fn end(mut self) -> Option<(Workload, Vec<News>)> {
        self.stops.ending.store(true, Ordering::SeqCst);
        self.device.allow_submissions(Some(0));
        self.tasks = None;
        let (mut workload, waiting) = self.thread.take()?.join().ok()?;
        workload.tasks.extend(waiting.try_iter());
        workload.tasks.retain(|task| matches!(task, Task::Open(_) | Task::Cameras(_) | Task::Save(_)));
        Some((workload, self.news.try_iter().collect()))
    }

    /// The next piece of news, if any; [`News::Gone`] once the thread has ended without more.
    pub fn news(&self) -> Option<News> {
        match self.news.try_recv() {
            Ok(news) => Some(news),
            Err(TryRecvError::Empty) => None,
            Err(TryRecvError::Disconnected) => Some(News::Gone),
        }
    }
}

impl Drop for Worker {
    fn drop(&mut self) {
        self.stops.closing.store(true, Ordering::SeqCst);
        self.stop();
        self.tasks = None;
        if let Some(thread) = self.thread.take() {
            // The thread has already printed its panic.
            let _ = thread.join();
        }
    }
}

struct WorkerState {
    stage: SceneRenderer,
    setup: Setup,
    /// True if no file contains the clouds.
    generated: bool,
    encoder: ScreenEncoder,
    /// Pictures of the view.
    history: History,
    /// Columns and rows of the last picture's image, if its colors are on the device alone.
    unread: Option<[u32; 2]>,
    /// The last whole picture.
    whole: Option<WholePicture>,
    /// True once there was a picture of clouds that stay in their files.
    surveyed: bool,
    legends: Legends,
}

/// A whole picture that can be compared with an exact one.
#[derive(Clone)]
struct WholePicture {
    serial: u64,
    scene: Arc<Scene>,
    pose: Pose,
    frame: Frame,
    exactness: Exactness,
}

/// All waiting tasks, without pictures that a later one replaces.
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

impl WorkerState {
    /// Handles tasks until the sender is gone, the device is lost or the thread should end.
    fn run_all(
        mut self,
        waiting: Receiver<Task>,
        stops: &Stops,
        reporter: &Reporter<impl Fn()>,
    ) -> (Workload, Receiver<Task>) {
        let device = self.stage.renderer().device().clone();
        let (mut left, mut lost) = (Vec::new(), false);
        reporter.report(self.statistics());
        while let Some(task) = (!lost).then(|| waiting.recv().ok()).flatten() {
            for task in latest(task, &waiting) {
                let news = if lost { None } else { self.run_allowed(&task, &device, stops) };
                let Some(news) = news else {
                    left.push(task);
                    continue;
                };
                lost = matches!(news, News::Lost(_));
                if lost || stops.is_ending() && matches!(news, News::Stopped(_)) {
                    left.push(task);
                }
                // Points of stores were looked at for the first picture.
                let others = matches!(news, News::Opened(..)) || self.is_news(&news);
                reporter.report(news);
                if others {
                    reporter.report(self.statistics());
                }
            }
        }
        (Workload { sources: self.stage.into_sources(), generated: self.generated, tasks: left }, waiting)
    }

    /// Runs a task, again if it was stopped in place of the one before it; `None` if it must not start.
    fn run_allowed(&mut self, task: &Task, device: &Device, stops: &Stops) -> Option<News> {
        loop {
            device.allow_submissions(None);
            stops.may.store(task.may_stop(), Ordering::SeqCst);
            // Saves are completed even if the window closes in the meantime.
            if !stops.allow(task) {
                return None;
            }
            let news = self.run(task);
            stops.may.store(false, Ordering::SeqCst);
            if task.may_stop() || stops.is_ending() || !matches!(news, News::Stopped(_)) {
                return Some(news);
            }
        }
    }

    fn run(&mut self, task: &Task) -> News {
        let (serial, done) = match task {
            Task::Show(request) => (request.serial, self.show(request)),
            Task::Measure(serial) => (*serial, self.measure(*serial)),
            Task::Open(files) => (0, self.open(files)),
            Task::Cameras(file) => return cameras(file),
            Task::Save(saving) => (0, self.save(saving)),
        };
        done.unwrap_or_else(|error| match error {
            error if loss::during(&error).is_some() => News::Lost(error),
            Error::Gpu(gpu::Error::Stopped { .. }) => News::Stopped(serial),
            Error::Render(methods::Error::Gpu(gpu::Error::Stopped { .. }) | methods::Error::Cancelled) => {
                News::Stopped(serial)
            }
            error if matches!(task, Task::Measure(_)) => {
                News::Failed(serial, format!("can't measure the accuracy of the picture: {error}"))
            }
            error => News::Failed(serial, error.to_string()),
        })
    }

    /// True of the first picture of clouds that stay in their files.
    fn is_news(&mut self, news: &News) -> bool {
        let is_first = matches!(news, News::Picture(picture) if picture.held.is_some()) && !self.surveyed;
        self.surveyed |= is_first;
        is_first
    }

    fn statistics(&self) -> News {
        News::Clouds(Statistics::of_clouds(self.stage.clouds()).into())
    }

    fn show(&mut self, request: &Request) -> Result<News> {
        let Request { scene, pose, effort, serial, legend } = request;
        self.supply(scene, *pose)?;
        let mut taken = self.stage.take(scene, *pose, *effort)?;
        let plan = self.stage.plan(&taken);
        let (stage, legends) = (&self.stage, &mut self.legends);
        let legend = legend.then(|| legends.of_scene(scene, || stage.legend(scene))).transpose()?;
        let (whole, lacks_samples, draft) = (taken.is_whole(), taken.lacks_samples(), taken.name());
        let image = &taken.rendered.image;
        let settled = self.stage.settled(scene);
        let shown = SceneImage { size: [image.width, image.height], scene: &settled };
        let refinement = Refinement {
            name: draft.clone(),
            ms: taken.rendered.profile.wall.as_secs_f64() * 1e3,
            // A single stratum of samples has no spread.
            standard_error: image.standard_error().filter(|error| error.is_finite()),
            rmse: None,
        };
        let composed = image.has_colors().then(|| shown.composed(&image.rgba));
        let pixels = match self.stage.renderer().colors() {
            Some(colors) => self.encoder.encode(colors, shown)?,
            None => self.encoder.upload(composed.as_deref().unwrap_or_default(), scene)?,
        };
        self.unread = composed.is_none().then_some(shown.size);
        let mut depths = std::mem::take(&mut taken.rendered.image.depth);
        if shown.is_coarse() {
            depths = display::enlarge_depths(&depths, shown.size, scene.image.size);
        }
        self.history.add(scene, *pose, refinement, composed, whole);
        let TakenPicture { rendered, frame, subject, exactness, field, held, .. } = taken;
        if let (true, Some(exactness)) = (whole, exactness) {
            self.whole = Some(WholePicture { serial: *serial, scene: scene.clone(), pose: *pose, frame, exactness });
        }
        let picture = WindowPicture {
            serial: *serial,
            pose: *pose,
            camera: frame.camera,
            subject,
            size: scene.image.size,
            pixels: Some(pixels),
            depths,
            whole,
            lacks_samples,
            draft,
            accuracy: self.history.accuracy(exactness),
            method: frame.method.name(),
            profile: rendered.profile,
            facts: rendered.facts,
            plan,
            field,
            legend,
            held,
        };
        Ok(News::Picture(Box::new(picture)))
    }

    /// Brings the colors of the last picture to the host if the next one is of the same view: a better one will tell
    /// their error.
    fn supply(&mut self, scene: &Scene, pose: Pose) -> Result<()> {
        let Some(size) = self.unread.take().filter(|_| self.history.is_of(scene, pose)) else { return Ok(()) };
        if let Some(rgba) = self.stage.renderer().read_colors()? {
            let settled = self.stage.settled(scene);
            self.history.supply(SceneImage { size, scene: &settled }.composed(&rgba));
        }
        Ok(())
    }

    /// Compares the pictures of the last view with the exact one.
    fn measure(&mut self, serial: u64) -> Result<News> {
        let whole = self.whole.clone().filter(|whole| whole.serial == serial);
        let exactness = whole.as_ref().map(|whole| whole.exactness);
        if let (Some(whole), Some(Exactness::Approximation(method))) = (whole, exactness) {
            self.supply(&whole.scene, whole.pose)?;
            let rendered = self.stage.exact(&whole.scene, whole.pose, &whole.frame, method)?;
            let settled = self.stage.settled(&whole.scene);
            let image = SceneImage { size: [rendered.image.width, rendered.image.height], scene: &settled };
            let exact = image.composed(&rendered.image.rgba);
            self.stage.recycle(rendered.image);
            self.history.measure(&whole.scene, whole.pose, method.name(), &exact);
        }
        Ok(News::Measured(serial, self.history.accuracy(exactness)))
    }

    fn open(&mut self, files: &[PathBuf]) -> Result<News> {
        let progress = self.stage.progress.clone();
        let named = scene::name(files, &Overrides::default(), self.setup.seed)?;
        let scene = named.document.scene()?;
        let sources = Sources::open(&named.input, &scene, self.setup.limits(), &Silent, &progress);
        progress.set_message("");
        let device = self.stage.renderer().device().clone();
        self.stage = SceneRenderer::new(&device, sources?, &self.setup)?;
        self.stage.progress = progress;
        // A file of the same name may have other contents now.
        (self.history, self.unread, self.whole) = (History::default(), None, None);
        (self.legends, self.surveyed) = (Legends::default(), false);
        self.generated = named.is_generated();
        Ok(News::Opened(named.name, Box::new(named.document)))
    }

    fn save(&mut self, saving: &Saving) -> Result<News> {
        // The saved picture takes its place.
        self.unread = None;
        save::write(&mut self.stage, saving, self.generated).map(News::Saved)
    }
}

/// Reads cameras; reports which content was expected if the file has none.
fn cameras(file: &Path) -> News {
    match CameraSource::read(file) {
        Ok(source) => News::Cameras(file.to_owned(), Box::new(source)),
        Err(error @ path::Error::Read { .. }) => News::Failed(0, error.to_string()),
        Err(error) => News::Failed(
            0,
            format!(
                "{error}. Cameras are key frames of this program (docs/camera-paths.md), a transforms.json of nerfstudio, a \
                 cameras.json of 3D Gaussian Splatting or a model of COLMAP"
            ),
        ),
    }
}

#[cfg(test)]
mod tests;
