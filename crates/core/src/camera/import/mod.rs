//! Cameras of other programs: nerfstudio's `transforms.json`, the `cameras.json` of 3D Gaussian Splatting, and
//! COLMAP's models as text or binary files.
//!
//! All become a [`CameraPath`] with one key for each picture, without a target. This program's camera is a pinhole
//! with square pixels whose principal point is the picture's center; other properties of a camera are dropped with a
//! warning.

mod binary;
mod colmap;
mod lines;
mod nerfstudio;
mod trained;

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use glam::{DMat3, DQuat, DVec3};
use serde::Deserialize;
use serde::de::IgnoredAny;

use super::path::{CameraPath, Error, Key, MAX_KEYS, Problem, from_text};
use crate::image::MAX_SIDE;

/// Bytes of a text that is read at once, at most.
const MAX_BYTES: u64 = 1 << 28;

/// The source of a path.
#[derive(Debug, Clone, PartialEq)]
pub enum CameraSource {
    /// Key frames of this program.
    Path(CameraPath),
    /// Cameras of another one.
    Cameras(Cameras),
}

/// Pictures' cameras, in the order of the JSON file or of COLMAP's names.
#[derive(Debug, Clone, PartialEq)]
pub struct Cameras {
    /// Views of the file, at least one.
    views: Vec<View>,
    /// Width and height in pixels of the pictures; of the first, if they differ.
    size: Option<[u32; 2]>,
    /// Warnings about dropped properties and oddities, one sentence each.
    warnings: Vec<String>,
}

/// Imported view: eye in world units, rotation from the camera's axes (x right, y up, −z forward) to the world's.
#[derive(Debug, Clone, Copy, PartialEq)]
struct View {
    eye: DVec3,
    turn: DQuat,
    angle: Angle,
}

/// Full angle in radians.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Angle {
    Vertical(f64),
    /// Horizontal field of view, for a picture of unknown size.
    Horizontal(f64),
}

impl Cameras {
    /// Returns the cameras as keys, for pictures of this size.
    pub fn path(&self, size: [u32; 2]) -> CameraPath {
        let aspect = f64::from(size[1]) / f64::from(size[0]);
        let key = |view: &View| {
            let DQuat { x, y, z, w } = view.turn;
            let fov_y = match view.angle {
                Angle::Vertical(angle) => angle,
                Angle::Horizontal(angle) => 2.0 * ((0.5 * angle).tan() * aspect).atan(),
            };
            let orientation = Some([w, x, y, z]);
            Key { orientation, fov_y: Some(fov_y.to_degrees()), ..Key::at(view.eye.to_array()) }
        };
        CameraPath { size: self.size, ..CameraPath::new(self.views.iter().map(key).collect()) }
    }
}

impl CameraSource {
    /// Reads a file or a folder: key frames, nerfstudio's JSON (recognized by its `frames`), the cameras beside a
    /// model of Gaussians (a list), or a COLMAP model (a folder, one of its files, or the folder above `sparse/0`).
    ///
    /// # Errors
    /// Unreadable or damaged files, and files or folders of any other kind.
    pub fn read(path: &Path) -> Result<Self, Error> {
        if let Some(folder) = colmap::model(path) {
            return Ok(Self::Cameras(colmap::read(&folder)?));
        }
        if !path.is_dir() {
            return Self::read_json(path);
        }
        let json =
            ["transforms.json", "cameras.json"].map(|name| path.join(name)).into_iter().find(|json| json.is_file());
        let json = json.ok_or_else(|| {
            content(
                path,
                "this folder has neither a transforms.json nor a cameras.json, nor cameras and images of COLMAP (.bin or .txt)",
            )
        })?;
        Self::read_json(&json)
    }

    /// Returns the files that [`CameraSource::read`] reads.
    pub fn files(path: &Path) -> Vec<PathBuf> {
        match colmap::model(path) {
            Some(folder) => colmap::files(&folder),
            None if path.is_dir() => vec![path.join("transforms.json")],
            None => vec![path.to_owned()],
        }
    }

    fn read_json(path: &Path) -> Result<Self, Error> {
        let text = read_text(path)?;
        let Kind { keys, frames } = match text.trim_start().as_bytes().first() {
            Some(b'[') => return Ok(Self::Cameras(trained::read(&text, path)?)),
            Some(b'{') => from_text(&text, path)?,
            _ => from_text::<IgnoredAny>(&text, path).map(|_| Kind { keys: None, frames: None })?,
        };
        match (keys, frames) {
            (None, None) => Err(content(
                path,
                "has neither keys (a camera path) nor frames (transforms.json of nerfstudio), and is no list of cameras \
                 (cameras.json of 3D Gaussian Splatting)",
            )),
            (None, Some(_)) => Ok(Self::Cameras(nerfstudio::read(&text, path)?)),
            (Some(_), _) => Ok(Self::Path(CameraPath::from_json(&text, path)?)),
        }
    }

    /// Returns the width and height in pixels, if the file gives them.
    pub fn size(&self) -> Option<[u32; 2]> {
        match self {
            Self::Path(path) => path.size,
            Self::Cameras(cameras) => cameras.size,
        }
    }

    /// Warnings, one sentence each.
    pub fn warnings(&self) -> &[String] {
        match self {
            Self::Path(_) => &[],
            Self::Cameras(cameras) => &cameras.warnings,
        }
    }

    /// Returns the path for pictures of this size.
    pub fn path(&self, size: [u32; 2]) -> CameraPath {
        match self {
            Self::Path(path) => path.clone(),
            Self::Cameras(cameras) => cameras.path(size),
        }
    }
}

/// Returns `true` if the path holds cameras, judged by its name and neighboring files: JSON, a folder, or a part of a
/// COLMAP model.
pub fn is_cameras(path: &Path) -> bool {
    let json = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("json"));
    json || path.is_dir() || colmap::model(path).is_some()
}

/// The keys that distinguish the two kinds of JSON.
#[derive(Deserialize)]
struct Kind {
    keys: Option<IgnoredAny>,
    frames: Option<IgnoredAny>,
}

/// A camera as the files give it.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Intrinsics {
    /// Focal lengths in pixels.
    focal: [f64; 2],
    /// Principal point in pixels.
    center: Option<[f64; 2]>,
    /// Width and height in pixels.
    size: [f64; 2],
    /// `true` if the lens bends straight lines.
    distorted: bool,
}

impl Intrinsics {
    /// Checks the numbers; a phrase about what is wrong.
    fn check(&self) -> Result<(), String> {
        if self.size.iter().any(|side| !(*side >= 1.0 && *side <= f64::from(MAX_SIDE))) {
            let [width, height] = self.size;
            return Err(format!("the picture's sides must be from 1 to {MAX_SIDE} pixels, not {width} × {height}"));
        }
        if self.focal.iter().any(|focal| !(*focal > 0.0 && focal.is_finite())) {
            return Err(format!("focal lengths must be positive, not {} and {}", self.focal[0], self.focal[1]));
        }
        Ok(())
    }

    fn angle(&self) -> Angle {
        Angle::Vertical(2.0 * (0.5 * self.size[1] / self.focal[1]).atan())
    }

    /// Whole pixels; [`Intrinsics::check`] has bounded them.
    fn pixels(&self) -> [u32; 2] {
        self.size.map(|side| side.round() as u32)
    }
}

/// Warnings about the intrinsics of all pictures, one sentence each.
fn warnings(all: &[Intrinsics]) -> Vec<String> {
    let mut warnings = Vec::new();
    let mut warn = |count: usize, what: &str| {
        if count > 0 {
            warnings.push(format!("of {count} of {} cameras {what}", all.len()));
        }
    };
    let count = |is: fn(&Intrinsics) -> bool| all.iter().filter(|camera| is(camera)).count();
    warn(count(|camera| camera.distorted), "the lens distortion is ignored");
    // A thousandth is a pixel at the edge of a picture of 2000.
    let square = |camera: &Intrinsics| (camera.focal[0] / camera.focal[1] - 1.0).abs() <= 1e-3;
    warn(all.iter().filter(|camera| !square(camera)).count(), "the focal lengths in x and y differ; that in y is used");
    let off = |camera: &Intrinsics| {
        let center = camera.center.unwrap_or(camera.size.map(|side| 0.5 * side));
        (0..2).map(|axis| (center[axis] - 0.5 * camera.size[axis]).abs()).fold(0.0, f64::max)
    };
    let most = all.iter().map(off).fold(0.0, f64::max);
    warn(
        all.iter().filter(|camera| off(camera) > 0.5).count(),
        &format!(
            "the principal point is up to {most:.1} pixels away from the center of the picture; the center is used"
        ),
    );
    let sizes = all.iter().map(Intrinsics::pixels);
    if let Some([width, height]) = sizes.clone().next()
        && sizes.clone().any(|size| size != [width, height])
    {
        warnings.push(format!("the pictures differ in size; all get the size of the first, {width} × {height}"));
    }
    warnings
}

/// A rotation by its columns, which may have a common length; `None` if they aren't orthogonal or not right-handed.
fn rotation(columns: [DVec3; 3]) -> Option<DQuat> {
    let unit = columns.map(|column| column.normalize_or_zero());
    let matrix = DMat3::from_cols_array_2d(&unit.map(|column| column.to_array()));
    // Files of six digits are off by 1e-6.
    let off = matrix.transpose() * matrix - DMat3::IDENTITY;
    let most = off.to_cols_array().iter().fold(0.0, |max: f64, x| max.max(x.abs()));
    (most < 1e-3 && matrix.determinant() > 0.0).then(|| DQuat::from_mat3(&matrix).normalize())
}

/// Coordinates that a path takes.
fn is_place(point: DVec3) -> bool {
    point.is_finite() && point.abs().max_element() <= 1e75
}

fn check_count(path: &Path, count: usize, what: &str) -> Result<(), Error> {
    match count {
        0 => Err(content(path, format!("holds no {what}"))),
        1..=MAX_KEYS => Ok(()),
        _ => Err(content(path, format!("holds {count} {what}; a path has at most {MAX_KEYS}"))),
    }
}

fn content(path: &Path, problem: impl Into<String>) -> Error {
    Error::Content { path: path.to_owned(), problem: Problem::whole(problem) }
}

fn read_text(path: &Path) -> Result<String, Error> {
    let failed = |source| Error::Read { path: path.to_owned(), source };
    let file = File::open(path).map_err(failed)?;
    let mut text = String::new();
    let read = file.take(MAX_BYTES + 1).read_to_string(&mut text).map_err(failed)?;
    if read as u64 > MAX_BYTES {
        return Err(content(path, format!("has more than {}", bytesize::ByteSize(MAX_BYTES))));
    }
    // The mark at the beginning of UTF-8 that editors of Windows write.
    Ok(text.strip_prefix('\u{feff}').map(str::to_owned).unwrap_or(text))
}
