//! `--path`, `--turntable`: the cameras of many frames.

use std::path::PathBuf;

use clap::Args;
use pellucid_core::camera::StatedCamera;
use pellucid_core::camera::import::CameraSource;
use pellucid_core::camera::path::{self, Curve, Pose};
use pellucid_core::cloud::UpAxis;
use pellucid_core::points::Points;
use pellucid_engine::Result;
use pellucid_io::output::Inputs;
use pellucid_scene::{Course, Scene};
use pellucid_session::{Opened, Prepared, Request};

use super::bar::Bar;
use super::console::Console;
use super::headings::FRAMES;
use super::input::InputArgs;
use super::limit::usage;

/// A camera that moves.
#[derive(Debug, Args)]
pub struct PathArgs {
    /// Move the camera along the key frames of a file.
    ///
    /// A JSON file of keys with eye, target and more (docs/camera-paths.md), a transforms.json of nerfstudio, a
    /// cameras.json of 3D Gaussian Splatting, or the folder of a COLMAP model (text or binary). With --frames N the
    /// camera is interpolated between the keys; otherwise every key is one frame.
    #[arg(long, value_name = "PATH", conflicts_with_all = ["turntable", "like"], help_heading = FRAMES)]
    path: Option<PathBuf>,
    /// Turn the camera once around the scene, in --frames N steps.
    ///
    /// The vertical axis goes through the camera's target, or through the middle of the scene if it has no target.
    #[arg(long, help_heading = FRAMES)]
    turntable: bool,
}

/// Source of the cameras.
pub enum Along {
    /// Key frames of a file, at so many equally spaced times, or at the keys.
    Keys { path: PathBuf, source: CameraSource, frames: Option<usize> },
    /// Number of steps of a turn around the scene.
    Turn { frames: usize },
}

impl PathArgs {
    /// The options as they would be typed, if one of them was.
    pub fn option(&self) -> Option<&'static str> {
        match (&self.path, self.turntable) {
            (Some(_), _) => Some("--path"),
            (None, true) => Some("--turntable"),
            (None, false) => None,
        }
    }

    /// The files that are read for frames of these inputs.
    pub fn reads(&self, input: &InputArgs) -> Inputs {
        input.reads().with(self.path.iter().flat_map(|path| CameraSource::files(path)))
    }

    /// The requested motion of the camera, if any; reads its file. Warnings go to standard error.
    pub fn course(&self, frames: Option<u32>, input: &InputArgs, console: Console) -> Result<Option<Along>> {
        let frames = frames.map(|count| count as usize);
        if let Some(path) = &self.path {
            if input.view.view().is_given() {
                console.warn("--view, --azimuth and --elevation have no effect with --path");
            }
            let source = CameraSource::read(path)?;
            source.warnings().iter().for_each(|warning| console.warn(warning));
            return Ok(Some(Along::Keys { path: path.clone(), source, frames }));
        }
        match (self.turntable, frames) {
            (false, _) => Ok(None),
            (true, Some(frames)) => Ok(Some(Along::Turn { frames })),
            (true, None) => Err(usage("--turntable needs the number of its frames, as in --frames 36")),
        }
    }
}

impl Along {
    /// True if the first frame follows the last.
    pub fn is_closed(&self) -> bool {
        match self {
            Self::Keys { source, .. } => matches!(source, CameraSource::Path(path) if path.closed),
            Self::Turn { .. } => true,
        }
    }

    /// The size of the images that the path was made for, if its file has one.
    pub fn size(&self) -> Option<[u32; 2]> {
        match self {
            Self::Keys { source, .. } => source.size(),
            Self::Turn { .. } => None,
        }
    }

    /// Reads the clouds of a request, and finds the camera of each frame; there is at least one, and the first is that
    /// of the request.
    pub fn prepare(&self, request: Request, progress: &Bar) -> Result<(Prepared, Vec<StatedCamera>)> {
        let mut cameras = Vec::new();
        let find = |scene: &Scene, points: &Points, up: UpAxis| {
            let (found, warnings) = self.cameras(scene, points, up)?;
            cameras = found;
            Ok((cameras[0], warnings))
        };
        let prepared = Opened::new(request, progress, progress)?.prepare_by(find, progress, progress)?;
        let settings = &prepared.scene().camera;
        let given = settings.eye.filter(|_| matches!(self, Self::Turn { .. }) && !settings.view.is_given());
        if let (Some(eye), Some(first)) = (given.map(|eye| eye.to_array()), cameras.first().map(|c| c.eye.to_array()))
            && eye != first
        {
            let why = format_args!("the turn begins at {first:?}, since from {eye:?} it would lose points");
            progress.console.detail(why);
        }
        Ok((prepared, cameras))
    }

    /// The camera of each frame, and what is to be said about them; `up` is the vertical of the clouds.
    fn cameras(&self, scene: &Scene, points: &Points, up: UpAxis) -> Result<(Vec<StatedCamera>, Vec<String>)> {
        let course = Course::new(scene, points, up)?;
        let (poses, warnings) = self.poses(&course, scene.image.size)?;
        let cameras = poses.iter().map(|pose| course.camera(pose)).collect::<Result<_, _>>()?;
        Ok((cameras, warnings))
    }

    fn poses(&self, course: &Course<'_>, size: [u32; 2]) -> Result<(Vec<Pose>, Vec<String>)> {
        match self {
            Self::Turn { frames } => {
                let (turntable, warnings) = course.turntable()?;
                Ok((turntable.frames(*frames), warnings))
            }
            Self::Keys { path, source, frames } => {
                let curve = Curve::new(&source.path(size), &course.defaults());
                let curve = curve.map_err(|problem| path::Error::Content { path: path.clone(), problem })?;
                let poses = frames.map_or_else(|| curve.key_poses(), |count| curve.frames(count));
                Ok((poses, Vec::new()))
            }
        }
    }
}
