//! Requests of the window, and the worker's replies.

use std::path::PathBuf;
use std::sync::Arc;

use crate::accuracy::Accuracy;
use crate::census::{Census, FieldFacts};
use crate::draft::Effort;
use crate::navigate::Subject;
use crate::save::Saving;
use crate::stage::{Held, Pose};
use pellucid_engine::Error;
use pellucid_engine::camera::Camera;
use pellucid_engine::camera::import::Source;
use pellucid_engine::gpu::Buffer;
use pellucid_engine::methods::{Facts, FrameProfile};
use pellucid_engine::plan::Step;
use pellucid_engine::scene::legend::Legend;
use pellucid_engine::scene::{Document, Scene};

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

/// A picture for the window.
pub struct Picture {
    /// The serial of its request.
    pub serial: u64,
    /// The requested pose.
    pub pose: Pose,
    /// The camera.
    pub camera: Camera,
    /// The extent of the scene.
    pub subject: Subject,
    /// Columns and rows.
    pub size: [u32; 2],
    /// Bytes of the picture in the layout of the screen; `None` once the device is lost.
    pub pixels: Option<Arc<Buffer<u32>>>,
    /// Depth of each pixel, infinite where the pixel is empty.
    pub depths: Vec<f32>,
    /// True if nothing was left out.
    pub whole: bool,
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
    pub held: Option<Held>,
}

/// News from the thread.
pub enum News {
    /// A picture is finished.
    Picture(Box<Picture>),
    /// Name and scene document of other files that were opened.
    Opened(String, Box<Document>),
    /// Statistics of the clouds, in the scene's order.
    Clouds(Arc<[Census]>),
    /// Cameras were read from this file.
    Cameras(PathBuf, Box<Source>),
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

impl News {
    /// Gives up what is on the device.
    pub fn release(&mut self) {
        if let Self::Picture(picture) = self {
            picture.pixels = None;
        }
    }
}

impl Task {
    /// True if the task may be stopped for a later picture: it only serves the eye and may take long.
    pub(super) fn may_stop(&self) -> bool {
        match self {
            Self::Show(request) => !matches!(request.effort, Effort::Moving(_)),
            Self::Measure(_) => true,
            Self::Open(_) | Self::Cameras(_) | Self::Save(_) => false,
        }
    }
}
