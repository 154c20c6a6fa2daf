//! What the viewer knows: the scene, the camera, the last picture, and when the next one is due. No window, no device.

use std::collections::{BTreeMap, VecDeque};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

use glam::DVec2;
use pellucid_engine::progress::Progress;

use super::census::Census;
use super::dialog::Dialog;
use super::loss::Lost;
use super::navigate::{self, Navigator};
use super::route::Route;
use super::stage::Pose;
use super::times::Times;
use super::worker::{News, Picture, Task};
use crate::{Error, Result};
use pellucid_engine::camera::Projection;
use pellucid_engine::camera::import::Source;
use pellucid_engine::scene::{Document, Scene, Setting, View};

mod due;
mod edit;

/// How long nothing may move for a picture without omissions to be due.
const REST: Duration = Duration::from_millis(150);

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
    /// Why the last picture failed, until there is one again.
    failed: Option<String>,
    /// The path of key frames.
    pub route: Route,
    /// A file of cameras that waits for the first picture.
    arriving: Option<(PathBuf, Source)>,
    /// The dialog for files.
    pub dialog: Dialog,
    /// Files that are being read or written.
    pub busy: bool,
    /// What they were asked for, in that order, in which the answers come: whether it is another scene.
    pending: VecDeque<bool>,
    /// What keeps the next picture waiting.
    pub progress: Progress,
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
        let scene = Arc::new(document.scene().map_err(pellucid_engine::Error::from)?);
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
            failed: None,
            route: Route::default(),
            arriving: None,
            dialog: Dialog::default(),
            busy: false,
            pending: VecDeque::new(),
            progress: Progress::hidden(),
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

    /// What is said in place of the picture as long as there is none.
    pub fn line_without_picture(&self) -> Option<&'static str> {
        let line = if self.way == Way::Rest {
            "there is no picture: the panel (H) says why"
        } else {
            "the first picture is on its way"
        };
        self.picture.is_none().then_some(line)
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
                self.take_answer();
            }
            News::Cameras(file, source) => {
                self.take_answer();
                self.take_path(file, *source);
            }
            News::Failed(serial, message) => {
                if serial == 0 {
                    self.take_answer();
                }
                if self.is_asked(serial) {
                    self.way = Way::Rest;
                    self.failed = Some(message.clone());
                }
                self.message = Some((message, true));
            }
            News::Stopped(serial) if self.is_asked(serial) => self.way = Way::Changed,
            News::Stopped(serial) => self.measured = self.measured.filter(|measured| *measured != serial),
            News::Measured(serial, accuracy) => {
                if let Some(picture) = self.picture.as_mut().filter(|picture| picture.serial == serial) {
                    picture.accuracy = accuracy;
                }
            }
            News::Lost(error) => return Err(error.into()),
            News::Gone => return Err(Lost::Panicked.into()),
        }
        Ok(())
    }

    /// Asks anew for a picture, and tells why: whoever was asked for one is gone, and so are files that were on their way unless
    /// `busy`.
    pub fn start_anew(&mut self, why: String, busy: bool) {
        self.way = Way::Changed;
        if !busy {
            self.pending = self.tasks.iter().map(|task| matches!(task, Task::Open(_))).collect();
        }
        self.busy = busy || !self.tasks.is_empty();
        self.message = Some((why, true));
    }

    /// Another scene.
    fn replace(&mut self, name: String, document: Document) -> Result<(), Error> {
        self.take_answer();
        // Files that were asked for after these are still on their way.
        let (busy, pending, tasks) = (self.busy, std::mem::take(&mut self.pending), std::mem::take(&mut self.tasks));
        let (shows, viewport, serial, progress) = (self.shows, self.viewport, self.serial, self.progress.clone());
        // Keys are places in the world, which another scene may show as well.
        let mut route = std::mem::take(&mut self.route);
        route.invalidate();
        let new = Self::new(name, document, View::default(), self.budget_ms)?;
        *self = Self { shows, viewport, serial, route, progress, busy, pending, tasks, ..new };
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
        // What was wrong with the one before is no longer true.
        let failed = self.failed.take();
        self.message.take_if(|(message, _)| failed.as_ref() == Some(message));
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
