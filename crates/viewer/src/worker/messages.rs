//! What the window asks for, and what it is told.

use std::path::PathBuf;
use std::sync::Arc;

use crate::accuracy::Accuracy;
use crate::census::{Census, FieldFacts};
use crate::draft::Effort;
use crate::navigate::Subject;
use crate::save::Saving;
use crate::stage::Pose;
use pellucid_engine::Error;
use pellucid_engine::camera::Camera;
use pellucid_engine::camera::import::Source;
use pellucid_engine::methods::{Facts, FrameProfile};
use pellucid_engine::plan::Step;
use pellucid_engine::scene::{Document, Scene};

/// A picture that is wanted.
#[derive(Clone)]
pub struct Request {
    /// The scene, with the size of the picture in it.
    pub scene: Arc<Scene>,
    /// From where.
    pub pose: Pose,
    /// How much may be left out.
    pub effort: Effort,
    /// Counts requests.
    pub serial: u64,
}

/// What the thread is asked for.
pub enum Task {
    /// A picture; only the latest one counts.
    Show(Box<Request>),
    /// How far the pictures of the view with this serial are off the exact one, if its method is an approximation.
    Measure(u64),
    /// Other files instead of the scene.
    Open(Vec<PathBuf>),
    /// A file of cameras.
    Cameras(PathBuf),
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
    pub whole: bool,
    /// What it has of the whole picture.
    pub draft: String,
    /// How accurate the pictures of this view are.
    pub accuracy: Accuracy,
    /// The method that was taken.
    pub method: &'static str,
    /// Its times.
    pub profile: FrameProfile,
    /// What it met.
    pub facts: Facts,
    /// The passes and why.
    pub plan: Vec<Step>,
    /// How F of the points is spread, if the method asks for it.
    pub field: Option<FieldFacts>,
}

/// What the thread has to say.
pub enum News {
    /// A picture is there.
    Picture(Box<Picture>),
    /// Other files are there: their name and keys.
    Opened(String, Box<Document>),
    /// What is known of the clouds, in the scene's order.
    Clouds(Arc<[Census]>),
    /// Cameras are there, from this file.
    Cameras(PathBuf, Box<Source>),
    /// How far the pictures of the view with this serial are off the exact one.
    Measured(u64, Accuracy),
    /// The task of this serial was stopped, since a later one was there.
    Stopped(u64),
    /// Files were written.
    Saved(Vec<PathBuf>),
    /// The task of this serial failed (0: it had none); another one may do.
    Failed(u64, String),
    /// The thread has ended by a panic, which it has printed.
    Gone,
    /// Nothing can be rendered any more.
    Lost(Error),
}

impl Task {
    /// Whether it may be stopped for a later picture: everything that is for the eye alone and may take long.
    pub(super) fn may_stop(&self) -> bool {
        match self {
            Self::Show(request) => !matches!(request.effort, Effort::Moving(_)),
            Self::Measure(_) => true,
            Self::Open(_) | Self::Cameras(_) | Self::Save(_) => false,
        }
    }
}
