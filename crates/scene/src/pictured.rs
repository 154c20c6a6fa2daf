//! The camera that a picture holds in its metadata.

use std::path::{Path, PathBuf};

use pellucid_io::output::{self, CAMERA_TAG};

use super::error::Error;
use super::parse;
use super::settings::CameraSettings;
use super::table::{Context, Table};
use super::tree;

/// Bytes of such a text, at most; those of this program have less than 400.
const MAX_BYTES: usize = 4096;

/// Camera and size of a picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PictureCamera {
    /// The camera that was used: eye, target, up, angle or height, and both depths are given.
    pub camera: CameraSettings,
    /// Width and height in pixels.
    pub size: [u32; 2],
}

impl PictureCamera {
    /// Reads the metadata of a PNG or EXR that this program wrote.
    ///
    /// # Errors
    /// Returns an error if the file can't be read, is no picture, holds no camera, or one that is damaged.
    pub fn read(path: &Path) -> Result<Self, Error> {
        let output::Tagged { size, value } = output::tagged(path, CAMERA_TAG)?;
        let text = value.ok_or_else(|| no_camera(path, "the picture has none"))?;
        if text.len() > MAX_BYTES {
            return Err(no_camera(path, "the text is too long to be one"));
        }
        Ok(Self { camera: camera(&text, path)?, size })
    }

    /// Returns the camera as a value for the key `camera` of [`Overrides`](super::Overrides).
    pub fn as_value(&self) -> String {
        let keys = self.camera.keys().into_iter().filter(|key| !["ortho", "frame"].contains(&key.name));
        let pairs = keys.filter_map(|key| Some(format!("{} = {}", key.name, key.value?)));
        format!("{{ {} }}", pairs.collect::<Vec<_>>().join(", "))
    }
}

/// The camera of a text.
fn camera(text: &str, path: &Path) -> Result<CameraSettings, Error> {
    let root = tree::parse(text, &PathBuf::from(format!("{}: {CAMERA_TAG}", path.display())))?;
    let context = Context::default();
    let camera: CameraSettings = parse::read(&Table::root(&root, &context)?)?;
    let CameraSettings { eye, target, up, fov_y, height, near, far, .. } = camera;
    let given = [
        ("eye", eye.is_some()),
        ("target", target.is_some()),
        ("up", up.is_some()),
        ("fov_y or height", fov_y.is_some() || height.is_some()),
        ("near", near.is_some()),
        ("far", far.is_some()),
    ];
    match given.into_iter().find(|(_, is_given)| !is_given) {
        Some((missing, _)) => Err(no_camera(path, &format!("it lacks {missing}"))),
        None => Ok(camera),
    }
}

fn no_camera(path: &Path, problem: &str) -> Error {
    Error::NoCamera { path: path.to_owned(), problem: problem.to_owned() }
}
