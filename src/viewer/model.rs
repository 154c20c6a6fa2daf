//! What the viewer knows: the scene, the camera, the last picture, and when the next one is due. No window, no device.

use std::collections::{BTreeMap, VecDeque};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

use glam::DVec2;
use indicatif::ProgressBar;

use super::accuracy::Standing;
use super::census::Census;
use super::dialog::Dialog;
use super::draft::Effort;
use super::navigate::{self, Navigator};
use super::route::Route;
use super::stage::Pose;
use super::times::Times;
use super::worker::{News, Picture, Request, Task};
use crate::camera::Projection;
use crate::camera::import::Source;
use crate::scene::{Document, Scene, Setting, View};
use crate::{Error, Result};

mod edit;

/// How long nothing may move for a picture without omissions to be due.
const REST: Duration = Duration::from_millis(150);

/// How much longer each picture may take than the one before it, at rest: all drafts together take a third of the last one's time.
const REFINING: f64 = 4.0;

/// Milliseconds for the first picture at rest, if the budget while things move is less: what the eye hardly waits for.
const FIRST_AT_REST_MS: f64 = 250.0;

/// Pictures at rest after which nothing is left out any more.
const MOST_REFINED: u32 = 6;

/// How long nothing may move for the picture to be held against the exact one.
const STILL: Duration = Duration::from_millis(500);

/// Pixels around the pointer in which a depth is looked for.
const PICK_PX: i64 = 6;

/// The part of the window that shows the picture, in physical pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Viewport {
    /// Left upper corner.
    pub at: [u32; 2],
    /// Columns and rows.
    pub size: [u32; 2],
}

/// What is shown beside the picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shows {
    /// The panel.
    pub panel: bool,
    /// The times of the passes.
    pub passes: bool,
    /// The keys.
    pub help: bool,
}

/// Whether a picture is on its way.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Way {
    /// None is; what is shown is as it should be.
    Rest,
    /// Something changed since the last request.
    Changed,
    /// The one of this serial was asked for; how often it will have been refined.
    Asked(u64, u32),
    /// It came, but something was left out: so many were refined since things came to rest.
    Draft(u32),
}

/// The viewer's state.
pub struct Model {
    /// The inputs as they were named.
    pub name: String,
    document: Document,
    scene: Arc<Scene>,
    navigator: Option<Navigator>,
    pose: Pose,
    /// Whether the next pose that the scene gives becomes orthographic.
    flatten: bool,
    viewport: Viewport,
    picture: Option<Box<Picture>>,
    census: Arc<[Census]>,
    way: Way,
    serial: u64,
    changed_at: Instant,
    /// The picture that was held against the exact one, or is about to be.
    measured: Option<u64>,
    budget_ms: f64,
    tasks: VecDeque<Task>,
    /// What is to be told, and whether something went wrong.
    pub message: Option<(String, bool)>,
    /// The path of key frames.
    pub route: Route,
    /// A file of cameras that waits for the first picture.
    arriving: Option<(PathBuf, Source)>,
    /// The dialog for files.
    pub dialog: Dialog,
    /// Files that are being read or written.
    pub busy: bool,
    /// What keeps the next picture waiting.
    pub progress: ProgressBar,
    /// The last frames.
    pub times: Times,
    /// What is shown.
    pub shows: Shows,
    /// Where the pointer was, in points, when it last turned or moved the picture in a drag.
    pub grabbed: Option<[f32; 2]>,
    /// Where controls are in the window, in physical pixels: left, top, width, height.
    pub controls: BTreeMap<String, [i32; 4]>,
}

impl Model {
    /// The state at the beginning: the scene's own view, or the one that is given.
    ///
    /// # Errors
    /// Whatever is wrong with the scene.
    pub fn new(name: String, document: Document, view: View, budget_ms: f64) -> Result<Self> {
        let scene = Arc::new(document.scene()?);
        Ok(Self {
            name,
            document,
            scene,
            navigator: None,
            pose: if view.is_given() { Pose::View(view) } else { Pose::Scene },
            flatten: false,
            viewport: Viewport::default(),
            picture: None,
            census: Arc::default(),
            way: Way::Changed,
            serial: 0,
            changed_at: Instant::now(),
            measured: None,
            budget_ms,
            tasks: VecDeque::new(),
            message: None,
            route: Route::default(),
            arriving: None,
            dialog: Dialog::default(),
            busy: false,
            progress: ProgressBar::hidden(),
            times: Times::default(),
            shows: Shows { panel: true, passes: true, help: false },
            grabbed: None,
            controls: BTreeMap::new(),
        })
    }

    /// The scene, without the camera and the size that the window gives it.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The last picture.
    pub fn picture(&self) -> Option<&Picture> {
        self.picture.as_deref()
    }

    /// Where the picture is.
    pub fn viewport(&self) -> Viewport {
        self.viewport
    }

    /// Whether the last picture is as it should be, with nothing left out, and nothing has moved for a moment.
    pub fn is_at_rest(&self, now: Instant) -> bool {
        self.way == Way::Rest && !self.busy && self.tasks.is_empty() && now >= self.rest_at()
    }

    fn rest_at(&self) -> Instant {
        self.changed_at + REST
    }

    /// Whether the projection has no perspective.
    pub fn is_orthographic(&self) -> bool {
        self.navigator.map_or(self.flatten, |navigator| navigator.is_orthographic())
    }

    /// Something is to be shown otherwise.
    fn touch(&mut self) {
        self.way = Way::Changed;
        self.changed_at = Instant::now();
    }

    /// The window gives the picture another place.
    pub fn set_viewport(&mut self, viewport: Viewport) {
        if viewport != self.viewport {
            if viewport.size != self.viewport.size {
                self.touch();
            }
            self.viewport = viewport;
        }
    }

    /// Moves the camera, once there is one.
    pub fn navigate(&mut self, movement: impl FnOnce(&mut Navigator)) {
        let Some(navigator) = &mut self.navigator else { return };
        let before = *navigator;
        movement(navigator);
        if *navigator != before {
            let near_far = (self.scene.camera.near, self.scene.camera.far);
            self.pose = Pose::At(navigator.settings(near_far.0, near_far.1));
            self.route.stop();
            self.touch();
        }
    }

    /// Shows everything from a side, in the projection that is in force. Until that picture is there nothing moves the camera,
    /// since nobody knows yet where it is.
    pub fn look_from(&mut self, view: View) {
        self.flatten = self.is_orthographic();
        self.route.stop();
        self.navigator = None;
        self.pose = Pose::View(view);
        self.touch();
    }

    /// Whether the worker has something to do.
    pub fn is_waiting(&self) -> bool {
        self.busy || matches!(self.way, Way::Asked(..))
    }

    /// What keeps the next picture waiting, and how much of that is done.
    pub fn progress_line(&self) -> Option<String> {
        let message = Some(self.progress.message()).filter(|message| !message.is_empty() && self.is_waiting())?;
        let share = self.progress.length().and_then(|length| (100 * self.progress.position()).checked_div(length));
        Some(share.map_or_else(|| message.clone(), |share| format!("{message}, {share} %")))
    }

    /// The point of the scene that the picture shows at a position, in pixels of the picture.
    pub fn point_at(&self, pixel: DVec2) -> Option<glam::DVec3> {
        let picture = self.picture.as_deref()?;
        let depth = navigate::depth_at(&picture.depths, picture.size, pixel, PICK_PX)?;
        Some(navigate::unproject(&picture.camera, picture.size, pixel, depth))
    }

    /// Zooms to what is under a position of the picture; where nothing is, to that place as far away as the pivot.
    pub fn zoom_at(&mut self, pixel: DVec2, factor: f64) {
        let Some(picture) = &self.picture else { return };
        let Some(navigator) = &self.navigator else { return };
        let depth = picture.camera.to_view(navigator.pivot()).z;
        let aside = navigate::unproject(&picture.camera, picture.size, pixel, depth);
        let point = self.point_at(pixel).unwrap_or(aside);
        self.navigate(|navigator| navigator.zoom(point, factor));
    }

    /// Lets the camera turn about what is under a position of the picture.
    pub fn pivot_at(&mut self, pixel: DVec2) {
        match self.point_at(pixel) {
            Some(point) => {
                self.navigate(|navigator| navigator.set_pivot(point));
                self.message = Some((format!("turns about {:.3}, {:.3}, {:.3}", point.x, point.y, point.z), false));
            }
            None => self.message = Some(("there is nothing to turn about".to_owned(), false)),
        }
    }

    /// What the worker is to do next, if anything.
    pub fn next_task(&mut self, now: Instant) -> Option<Task> {
        if let Some(task) = self.tasks.pop_front() {
            return Some(task);
        }
        let effort = self.effort(now).filter(|_| !self.busy && !self.viewport.size.contains(&0));
        let Some((effort, refined)) = effort else { return self.measure(now) };
        self.serial += 1;
        self.way = Way::Asked(self.serial, refined);
        let mut scene = Scene::clone(&self.scene);
        scene.image.size = self.viewport.size;
        let (scene, pose, serial) = (Arc::new(scene), self.pose, self.serial);
        Some(Task::Show(Box::new(Request { scene, pose, effort, serial })))
    }

    /// How much work the next picture is worth, if one is due, and how often it was refined then.
    fn effort(&self, now: Instant) -> Option<(Effort, u32)> {
        let moving = now < self.rest_at();
        match self.way {
            // However late this is asked: a long frame may have kept the window waiting.
            Way::Changed => Some((Effort::Moving(self.budget_ms), 0)),
            Way::Draft(refined) if moving || refined > MOST_REFINED => None,
            Way::Draft(MOST_REFINED) => Some((Effort::Whole, MOST_REFINED)),
            Way::Draft(refined) => {
                let first = (REFINING * self.budget_ms).max(FIRST_AT_REST_MS);
                Some((Effort::Refining(first * REFINING.powi(refined as i32)), refined + 1))
            }
            Way::Rest | Way::Asked(..) => None,
        }
    }

    /// A measurement of the picture at rest, if it is an approximation that was not measured yet.
    fn measure(&mut self, now: Instant) -> Option<Task> {
        let serial = self.unmeasured().filter(|_| !self.busy && now >= self.changed_at + STILL)?;
        self.measured = Some(serial);
        Some(Task::Measure(serial))
    }

    fn unmeasured(&self) -> Option<u64> {
        let picture = self.picture.as_deref().filter(|_| self.way == Way::Rest)?;
        let approximates = matches!(picture.accuracy.standing, Some(Standing::Approximation(_)));
        (approximates && self.measured != Some(picture.serial)).then_some(picture.serial)
    }

    /// When to look again, if nothing happens before.
    pub fn due_at(&self, now: Instant) -> Option<Instant> {
        let still_at = self.unmeasured().map(|_| self.changed_at + STILL);
        [Some(self.rest_at()), still_at].into_iter().flatten().find(|at| *at > now)
    }

    /// Takes in what the worker says.
    ///
    /// # Errors
    /// What ends the viewer.
    pub fn take_in(&mut self, news: News) -> Result<(), Error> {
        match news {
            News::Picture(picture) => self.show(picture),
            News::Opened(name, document) => return self.replace(name, *document),
            News::Clouds(census) => self.census = census,
            News::Saved(files) => {
                self.message = Some((self.saved(&files), false));
                self.busy = false;
            }
            News::Cameras(file, source) => {
                self.busy = false;
                self.take_path(file, *source);
            }
            News::Failed(serial, message) => {
                self.message = Some((message, true));
                self.busy &= serial != 0;
                if self.is_asked(serial) {
                    self.way = Way::Rest;
                }
            }
            News::Stopped(serial) if self.is_asked(serial) => self.way = Way::Changed,
            News::Stopped(serial) => self.measured = self.measured.filter(|measured| *measured != serial),
            News::Measured(serial, accuracy) => {
                if let Some(picture) = self.picture.as_mut().filter(|picture| picture.serial == serial) {
                    picture.accuracy = accuracy;
                }
            }
            News::Lost(error) => return Err(error),
        }
        Ok(())
    }

    /// Asks anew for a picture, and tells why: whoever was asked for one is gone, and so are files that were on their way unless
    /// `busy`.
    pub fn start_anew(&mut self, why: String, busy: bool) {
        self.way = Way::Changed;
        self.busy = busy || !self.tasks.is_empty();
        self.message = Some((why, true));
    }

    /// Another scene.
    fn replace(&mut self, name: String, document: Document) -> Result<(), Error> {
        let (shows, viewport, serial, progress) = (self.shows, self.viewport, self.serial, self.progress.clone());
        // Keys are places in the world, which another scene may show as well.
        let mut route = std::mem::take(&mut self.route);
        route.invalidate();
        let new = Self::new(name, document, View::default(), self.budget_ms)?;
        *self = Self { shows, viewport, serial, route, progress, ..new };
        self.message = Some((format!("{}: opened", self.name), false));
        Ok(())
    }

    fn is_asked(&self, serial: u64) -> bool {
        matches!(self.way, Way::Asked(asked, _) if asked == serial)
    }

    fn show(&mut self, picture: Box<Picture>) {
        if let Way::Asked(serial, refined) = self.way
            && serial == picture.serial
        {
            self.way = if picture.whole { Way::Rest } else { Way::Draft(refined) };
        }
        self.times.add(&picture);
        // From a pose that the scene gave the camera may move on.
        if self.pose == picture.pose && !matches!(self.pose, Pose::At(_)) {
            let fov_y = match picture.camera.projection {
                Projection::Perspective { .. } => self.scene.camera.fov_y,
                Projection::Orthographic { .. } => None,
            };
            self.navigator = Some(Navigator::new(&picture.camera, fov_y, picture.subject));
            if std::mem::take(&mut self.flatten) {
                self.navigate(Navigator::toggle_projection);
            }
        }
        self.picture = Some(picture);
        self.receive_path();
    }
}

mod files;
mod path;

#[cfg(test)]
mod tests;
