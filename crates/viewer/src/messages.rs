//! Requests of the window, and the worker's replies.

use std::path::PathBuf;
use std::sync::Arc;

use crate::accuracy::Accuracy;
use crate::draft::Effort;
use crate::navigate::{CameraSubject, Pose};
use crate::statistics::{FieldFacts, Statistics};
use pellucid_core::camera::Camera;
use pellucid_core::camera::import::CameraSource;
use pellucid_core::camera::path::CameraPath;
use pellucid_engine::Error;
use pellucid_engine::methods::{Facts, FrameProfile};
use pellucid_engine::plan::Step;
use pellucid_gpu::Buffer;
use pellucid_scene::legend::Legend;
use pellucid_scene::{Document, Scene};
use pellucid_session::{Limits, Residence};

/// Settings that stay the same when other files are opened.
#[derive(Debug, Clone, Copy)]
pub struct Setup {
    /// Seed of stochastic methods and of the built-in scene.
    pub seed: u64,
    /// Device bytes for a frame's fragments.
    pub memory_budget: Option<u64>,
    /// Bytes of memory for points: clouds that take more stay in their files.
    pub host_memory: u64,
}

impl Setup {
    /// Limits on reading clouds. The window leaves points out while it moves, and draws all at rest.
    pub fn limits(&self) -> Limits {
        Limits { memory: self.host_memory, residence: Residence::Memory }
    }
}

/// A picture that is wanted.
#[derive(Clone)]
pub struct Request {
    /// The scene, with the size of the picture in it.
    pub scene: Arc<Scene>,
    /// The camera's pose.
    pub pose: Pose,
    /// The effort it may take.
    pub effort: Effort,
    /// Increases with each request.
    pub serial: u64,
    /// True if the meaning of its colors is wanted, too.
    pub legend: bool,
}

/// The files to write.
pub struct Saving {
    /// The scene, with camera and size.
    pub document: Document,
    /// The stem of the files' names.
    pub stem: String,
    /// True if a picture is wanted, too.
    pub picture: bool,
    /// Key frames to write, if any.
    pub path: Option<CameraPath>,
    /// The file of the scene, if it has a name already.
    pub to: Option<PathBuf>,
}

/// A request to the thread.
pub enum Task {
    /// Render a picture; only the latest request counts.
    Show(Box<Request>),
    /// Measure how far the pictures of the view with this serial are off the exact one, if its method is an
    /// approximation.
    Measure(u64),
    /// Open other files in place of the scene.
    Open(Vec<PathBuf>),
    /// Read a file of cameras.
    Cameras(PathBuf),
    /// Save the scene as a file, with or without a picture of it.
    Save(Box<Saving>),
}

/// How much of a cloud that stays in its file a picture holds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CloudShare {
    /// Points in the picture.
    pub points: u64,
    /// All points.
    pub all: u64,
    /// True if those left out are less than a pixel from one that is there.
    pub is_fine: bool,
}

/// A picture for the window.
pub struct WindowPicture {
    /// The serial of its request.
    pub serial: u64,
    /// The requested pose.
    pub pose: Pose,
    /// The camera.
    pub camera: Camera,
    /// The extent of the scene.
    pub subject: CameraSubject,
    /// Columns and rows.
    pub size: [u32; 2],
    /// Bytes of the picture in the layout of the screen; `None` once the device is lost.
    pub pixels: Option<Arc<Buffer<u32>>>,
    /// Depth of each pixel, infinite where the pixel is empty.
    pub depths: Vec<f32>,
    /// True if nothing was left out.
    pub whole: bool,
    /// True if only samples of each pixel's area were left out.
    pub lacks_samples: bool,
    /// Description of the draft.
    pub draft: String,
    /// Accuracy of the pictures of this view.
    pub accuracy: Accuracy,
    /// The method that was used.
    pub method: &'static str,
    /// Times of the frame.
    pub profile: FrameProfile,
    /// Counts of the frame.
    pub facts: Facts,
    /// Passes of the frame and their reasons.
    pub plan: Vec<Step>,
    /// The distribution of F over the points, if the method uses it.
    pub field: Option<FieldFacts>,
    /// The meaning of its colors, if that was asked for.
    pub legend: Option<Arc<Legend>>,
    /// Resident part of clouds that stay in their files.
    pub held: Option<CloudShare>,
}

/// News from the thread.
pub enum News {
    /// A picture is finished.
    Picture(Box<WindowPicture>),
    /// Name and scene document of other files that were opened.
    Opened(String, Box<Document>),
    /// Statistics of the clouds, in the scene's order.
    Clouds(Arc<[Statistics]>),
    /// Cameras were read from this file.
    Cameras(PathBuf, Box<CameraSource>),
    /// The error of the pictures of the view with this serial against the exact one.
    Measured(u64, Accuracy),
    /// The task of this serial was stopped in favor of a later one.
    Stopped(u64),
    /// Files were written.
    Saved(Vec<PathBuf>),
    /// The task of this serial failed (0: it had none); another one may work.
    Failed(u64, String),
    /// The thread ended with a panic, which it has printed.
    Gone,
    /// Rendering is no longer possible.
    Lost(Error),
}

impl Task {
    /// True if the task may be stopped for a later picture: it only serves the eye and may take long.
    pub fn may_stop(&self) -> bool {
        match self {
            Self::Show(request) => !matches!(request.effort, Effort::Moving(_)),
            Self::Measure(_) => true,
            Self::Open(_) | Self::Cameras(_) | Self::Save(_) => false,
        }
    }
}
