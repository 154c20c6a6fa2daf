//! The viewer's state: the scene, the camera, the last picture, and when the next one is due. Independent of window and
//! device.

use std::collections::{BTreeMap, VecDeque};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

use glam::DVec2;
use pellucid_core::progress::Progress;

use super::counts::abbreviated;
use super::dialog::Dialog;
use super::history::History;
use super::messages::{News, Task, WindowPicture};
use super::navigate::{self, Navigator, Pose};
use super::route::Route;
use super::statistics::Statistics;
use super::times::Times;
use crate::controls::Ratios;
use crate::{Error, Result};
use pellucid_core::camera::Projection;
use pellucid_core::camera::import::CameraSource;
use pellucid_scene::{Document, Scene, Setting, View};

mod due;
mod edit;
mod files;
mod path;
mod undo;

pub use due::STILL;
pub use files::Saved;

/// Time for which nothing may move before a complete picture is due.
pub const REST: Duration = Duration::from_millis(150);

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

/// Amount of pass times that is shown over the picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Passes {
    /// A line with their sum.
    #[default]
    Total,
    /// Each pass, and what else is known about the picture.
    List,
    /// Nothing.
    Hidden,
}

impl Passes {
    /// Returns the state after pressing T so many times.
    pub fn after(self, presses: usize) -> Self {
        [Self::Total, Self::List, Self::Hidden][(self as usize + presses) % 3]
    }
}

/// Parts of the window that are visible beside the picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Shows {
    /// The panel.
    pub panel: bool,
    /// The times of the passes.
    pub passes: Passes,
    /// The keys.
    pub help: bool,
    /// The meaning of the colors, over the picture.
    pub legend: bool,
    /// The section on colors, which has their meaning, too.
    pub colors: bool,
    /// The edges of the boxes that cut the scene.
    pub clips: bool,
}

impl Shows {
    /// True if the meaning of the colors is to come with pictures.
    pub fn explains_colors(&self) -> bool {
        self.legend || self.colors && self.panel
    }
}

/// State of the shown picture, compared with the requested one.
#[derive(Debug, Clone, Copy, PartialEq)]
enum PictureState {
    /// The shown picture is complete and current.
    Current,
    /// Something changed since the last request.
    Stale,
    /// The picture with this serial was requested; the second number is its refinement count.
    Requested(u64, u32),
    /// The picture arrived but is a draft; the number is its refinement count since movement stopped.
    Draft(u32),
}

/// The viewer's state.
pub struct Model {
    /// The inputs as they were named.
    pub name: String,
    document: Document,
    scene: Arc<Scene>,
    /// The scene as it was opened.
    opened: (Document, Arc<Scene>),
    history: History,
    /// Ratios of opacities that one slider changes.
    ratios: Ratios,
    navigator: Option<Navigator>,
    pose: Pose,
    /// True if the next pose the scene gives becomes orthographic.
    flatten: bool,
    viewport: Viewport,
    picture: Option<Box<WindowPicture>>,
    statistics: Arc<[Statistics]>,
    picture_state: PictureState,
    serial: u64,
    /// True if the last picture was asked for with the meaning of its colors.
    explained: bool,
    changed_at: Instant,
    /// The serial of the picture that was compared with the exact one, or is about to be.
    measured: Option<u64>,
    budget_ms: f64,
    tasks: VecDeque<Task>,
    /// The message to show; true marks an error.
    pub message: Option<(String, bool)>,
    /// The files that were saved last, until they are dismissed.
    pub saved: Option<Saved>,
    /// Reason why the last picture failed; cleared by the next picture.
    failed: Option<String>,
    /// The path of key frames.
    pub route: Route,
    /// A file of cameras that waits for the first picture.
    arriving: Option<(PathBuf, CameraSource)>,
    /// The dialog for files.
    pub dialog: Dialog,
    /// Files that are being read or written.
    pub busy: bool,
    /// Requests whose answers are due, in the order of the requests; true if the request opens another scene.
    pending: VecDeque<bool>,
    /// Progress of the work the next picture waits for.
    pub progress: Progress,
    /// The last frames.
    pub times: Times,
    /// True if clouds that stay in their files are drawn at rest with all of their points.
    everything: bool,
    /// Visible parts.
    pub shows: Shows,
    /// Position of the pointer, in points, when it last turned or moved the picture in a drag.
    pub grabbed: Option<[f32; 2]>,
    /// Position of each control in the window, in physical pixels: left, top, width, height.
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
            opened: (document.clone(), scene.clone()),
            document,
            scene,
            history: History::default(),
            ratios: Ratios::default(),
            navigator: None,
            pose: if view.is_given() { Pose::View(view) } else { Pose::Scene },
            flatten: false,
            viewport: Viewport::default(),
            picture: None,
            statistics: Arc::default(),
            picture_state: PictureState::Stale,
            serial: 0,
            explained: false,
            changed_at: Instant::now(),
            measured: None,
            budget_ms,
            tasks: VecDeque::new(),
            message: None,
            saved: None,
            failed: None,
            route: Route::default(),
            arriving: None,
            dialog: Dialog::default(),
            busy: false,
            pending: VecDeque::new(),
            progress: Progress::hidden(),
            times: Times::default(),
            everything: false,
            shows: Shows { panel: true, ..Shows::default() },
            grabbed: None,
            controls: BTreeMap::new(),
        })
    }

    /// The scene, without the camera and the size that the window gives it.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The place that pictures are taken from.
    pub fn pose(&self) -> Pose {
        self.pose
    }

    /// The camera's position and movements, once they are known.
    pub fn navigator(&self) -> Option<Navigator> {
        self.navigator
    }

    /// The last picture.
    pub fn picture(&self) -> Option<&WindowPicture> {
        self.picture.as_deref()
    }

    /// Gives the picture's memory on the device back; all else of it stays.
    pub fn release_picture(&mut self) {
        if let Some(picture) = &mut self.picture {
            picture.pixels = None;
        }
    }

    /// The part of the window that shows the picture.
    pub fn viewport(&self) -> Viewport {
        self.viewport
    }

    /// True if the last picture is complete and current, and nothing has moved for a moment.
    pub fn is_at_rest(&self, now: Instant) -> bool {
        self.picture_state == PictureState::Current && !self.busy && self.tasks.is_empty() && now >= self.rest_at()
    }

    fn rest_at(&self) -> Instant {
        self.changed_at + REST
    }

    /// True if clouds that stay in their files are drawn at rest with all of their points, however near to one another.
    pub fn draws_everything(&self) -> bool {
        self.everything
    }

    /// Has all points of clouds that stay in their files drawn at rest, or no more than are seen.
    pub fn draw_everything(&mut self, everything: bool) {
        let is_missing = self.picture.as_ref().is_some_and(|picture| !picture.whole);
        if everything && is_missing && self.picture_state == PictureState::Current {
            self.picture_state = PictureState::Draft(due::MOST_REFINED);
        }
        self.everything = everything;
    }

    /// Describes the resident part of clouds that stay in their files, unless the picture holds all.
    pub fn held_line(&self) -> Option<String> {
        let held = self.picture.as_ref()?.held.filter(|held| held.points < held.all)?;
        let [points, all] = [held.points, held.all].map(abbreviated);
        let rest = if held.is_fine { "; the others are less than a pixel from these" } else { "" };
        Some(format!("{points} of {all} points{rest}"))
    }

    /// True if the projection is orthographic.
    pub fn is_orthographic(&self) -> bool {
        self.navigator.map_or(self.flatten, |navigator| navigator.is_orthographic())
    }

    /// Shows a message.
    fn show_note(&mut self, text: impl Into<String>) {
        self.message = Some((text.into(), false));
    }

    /// Shows an error.
    fn show_error(&mut self, text: impl Into<String>) {
        self.message = Some((text.into(), true));
    }

    /// Marks the picture as stale.
    fn touch(&mut self) {
        self.picture_state = PictureState::Stale;
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

    /// Asks for a picture with the meaning of its colors, if that is to be shown and wasn't asked for: the worker has
    /// the clouds.
    pub fn explain_colors(&mut self) {
        if self.shows.explains_colors() && !self.explained && self.picture_state != PictureState::Stale {
            self.touch();
        }
    }

    /// Moves the camera, once it is known.
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

    /// Shows everything from a side, in the current projection. The camera can't be moved until that picture arrives,
    /// because its position is not known before.
    pub fn look_from(&mut self, view: View) {
        self.flatten = self.is_orthographic();
        self.route.stop();
        self.navigator = None;
        self.pose = Pose::View(view);
        self.touch();
    }

    /// True if the worker is busy.
    pub fn is_waiting(&self) -> bool {
        self.busy || matches!(self.picture_state, PictureState::Requested(..))
    }

    /// The line shown in place of the picture until the first one arrives.
    pub fn line_without_picture(&self) -> Option<&'static str> {
        let line = if self.picture_state == PictureState::Current {
            "no picture: the panel (H) gives the reason"
        } else {
            "rendering the first picture"
        };
        self.picture.is_none().then_some(line)
    }

    /// The work that the next picture waits for, and its progress.
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
                self.show_note(format!("turns about {:.3}, {:.3}, {:.3}", point.x, point.y, point.z));
            }
            None => self.show_note("no point to turn about"),
        }
    }

    /// Handles news from the worker.
    ///
    /// # Errors
    /// Errors that end the viewer.
    pub fn take_in(&mut self, news: News) -> Result<(), Error> {
        match news {
            News::Picture(picture) => self.show(picture),
            News::Opened(name, document) => return self.replace(name, *document),
            News::Clouds(statistics) => self.statistics = statistics,
            News::Saved(files) => {
                self.note_saved(&files);
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
                    self.picture_state = PictureState::Current;
                    self.failed = Some(message.clone());
                }
                self.show_error(message);
            }
            News::Stopped(serial) if self.is_asked(serial) => self.picture_state = PictureState::Stale,
            News::Stopped(serial) => self.measured = self.measured.filter(|measured| *measured != serial),
            News::Measured(serial, accuracy) => {
                if let Some(picture) = self.picture.as_mut().filter(|picture| picture.serial == serial) {
                    picture.accuracy = accuracy;
                }
            }
            News::Lost(error) => return Err(error.into()),
            News::Gone => return Err(Error::Panicked),
        }
        Ok(())
    }

    /// Requests the picture again and says why: the worker that was asked is gone, and so are files in transit unless
    /// `busy`.
    pub fn start_anew(&mut self, why: String, busy: bool) {
        self.picture_state = PictureState::Stale;
        if !busy {
            self.pending = self.tasks.iter().map(|task| matches!(task, Task::Open(_))).collect();
        }
        self.busy = busy || !self.tasks.is_empty();
        self.show_error(why);
    }

    /// Replaces the scene.
    fn replace(&mut self, name: String, document: Document) -> Result<(), Error> {
        self.take_answer();
        let old = std::mem::replace(self, Self::new(name, document, View::default(), self.budget_ms)?);
        // Files that were asked for after these are still on their way.
        (self.busy, self.pending, self.tasks) = (old.busy, old.pending, old.tasks);
        (self.shows, self.viewport, self.serial) = (old.shows, old.viewport, old.serial);
        (self.progress, self.saved, self.route) = (old.progress, old.saved, old.route);
        // Keys are positions in the world, which another scene may share.
        self.route.invalidate();
        self.show_note(format!("{}: opened", self.name));
        Ok(())
    }

    fn is_asked(&self, serial: u64) -> bool {
        matches!(self.picture_state, PictureState::Requested(asked, _) if asked == serial)
    }

    fn show(&mut self, picture: Box<WindowPicture>) {
        if let PictureState::Requested(serial, refined) = self.picture_state
            && serial == picture.serial
        {
            let is_enough = picture.whole || !self.everything && picture.held.is_some_and(|held| held.is_fine);
            self.picture_state = match is_enough {
                true => PictureState::Current,
                // Finer drafts would show the same.
                false if picture.lacks_samples => PictureState::Draft(due::MOST_REFINED),
                false => PictureState::Draft(refined),
            };
        }
        // The error of the previous picture no longer applies.
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
