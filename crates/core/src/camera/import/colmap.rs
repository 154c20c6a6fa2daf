//! COLMAP's sparse models (colmap.github.io/format.html): `cameras` and `images`, `.bin` or `.txt`.
//!
//! An image has a unit quaternion w, x, y, z and a vector t that lead from the world to the camera: x_camera = R·x + t,
//! whose axes are OpenCV's: x right, y down, z forward. So its eye is −Rᵀt, and the rows of R are right, down and
//! forward.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use glam::{DQuat, DVec3};

use super::{Cameras, Intrinsics, View, binary, check_count, content, is_place, lines, rotation, warnings};
use crate::camera::path::Error;

/// Lens models by COLMAP's number: name, number of parameters, and number of focal lengths, which come first. The two
/// coordinates of the principal point follow, then the distortion parameters.
pub const MODELS: [(&str, usize, usize); 12] = [
    ("SIMPLE_PINHOLE", 3, 1),
    ("PINHOLE", 4, 2),
    ("SIMPLE_RADIAL", 4, 1),
    ("RADIAL", 5, 1),
    ("OPENCV", 8, 2),
    ("OPENCV_FISHEYE", 8, 2),
    ("FULL_OPENCV", 12, 2),
    ("FOV", 5, 2),
    ("SIMPLE_RADIAL_FISHEYE", 4, 1),
    ("RADIAL_FISHEYE", 5, 1),
    ("THIN_PRISM_FISHEYE", 12, 2),
    ("RAD_TAN_THIN_PRISM_FISHEYE", 16, 2),
];

/// A picture and the number of its camera.
#[derive(Debug, Clone, PartialEq)]
pub struct Image {
    /// Bytes, since names need not be UTF-8.
    pub name: Vec<u8>,
    /// w, x, y, z.
    pub rotation: [f64; 4],
    pub translation: [f64; 3],
    pub camera: u32,
}

/// Returns the folder of the model that a path means, if it means any.
pub fn model(path: &Path) -> Option<PathBuf> {
    let stem = path.file_stem().and_then(|stem| stem.to_str());
    if path.is_file() && matches!(stem, Some("cameras" | "images")) && ["bin", "txt"].iter().any(|e| has(path, e)) {
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        return Some(folder.to_owned());
    }
    let folders = [path.to_owned(), path.join("sparse/0"), path.join("sparse")];
    folders.into_iter().find(|folder| ["bin", "txt"].iter().any(|e| is_model(folder, e)))
}

fn has(path: &Path, extension: &str) -> bool {
    path.extension().is_some_and(|e| e == extension)
}

fn is_model(folder: &Path, extension: &str) -> bool {
    ["cameras", "images"].iter().all(|name| folder.join(name).with_extension(extension).is_file())
}

/// Returns the files of a model in both forms, of which those of one are read.
pub fn files(folder: &Path) -> Vec<PathBuf> {
    let names = ["cameras", "images", "points3D"].into_iter();
    names.flat_map(|name| ["bin", "txt"].map(|extension| folder.join(name).with_extension(extension))).collect()
}

pub fn read(folder: &Path) -> Result<Cameras, Error> {
    let binary = is_model(folder, "bin");
    let file = |name: &str| folder.join(name).with_extension(if binary { "bin" } else { "txt" });
    let [cameras, images] = ["cameras", "images"].map(file);
    if binary {
        return cameras_of(&binary::cameras(&cameras)?, binary::images(&images)?, &images);
    }
    cameras_of(&lines::cameras(&cameras)?, lines::images(&images)?, &images)
}

fn cameras_of(cameras: &BTreeMap<u32, Intrinsics>, mut images: Vec<Image>, path: &Path) -> Result<Cameras, Error> {
    check_count(path, images.len(), "images")?;
    images.sort_by(|a, b| a.name.cmp(&b.name));
    let mut views = Vec::new();
    let mut intrinsics = Vec::new();
    for image in &images {
        let name = String::from_utf8_lossy(&image.name);
        let wrong = |problem: String| content(path, format!("image {name}: {problem}"));
        let id = image.camera;
        let camera = cameras.get(&id).ok_or_else(|| wrong(format!("its camera {id} is not among the cameras")))?;
        let (eye, turn) = pose(image).ok_or_else(|| wrong("its pose is not a finite rotation and place".to_owned()))?;
        views.push(View { eye, turn, angle: camera.angle() });
        intrinsics.push(*camera);
    }
    let name = path.display();
    let warnings = warnings(&intrinsics).into_iter().map(|warning| format!("{name}: {warning}")).collect();
    Ok(Cameras { views, size: intrinsics.first().map(Intrinsics::pixels), warnings })
}

fn pose(image: &Image) -> Option<(DVec3, DQuat)> {
    let [w, x, y, z] = image.rotation;
    let to_camera = DQuat::from_xyzw(x, y, z, w);
    if !to_camera.length_squared().is_normal() {
        return None;
    }
    let to_world = to_camera.normalize().conjugate();
    let eye = -(to_world * DVec3::from(image.translation));
    let turn = rotation([to_world * DVec3::X, to_world * DVec3::NEG_Y, to_world * DVec3::NEG_Z])?;
    is_place(eye).then_some((eye, turn))
}

/// Returns a camera of a model by its place in [`MODELS`]; a phrase about what is wrong.
pub fn intrinsics(model: usize, size: [f64; 2], parameters: &[f64]) -> Result<Intrinsics, String> {
    let (name, count, focals) = MODELS.get(model).ok_or_else(|| format!("unknown camera model {model}"))?;
    if parameters.len() != *count {
        return Err(format!("{name} has {count} parameters, not {}", parameters.len()));
    }
    let focal = [parameters[0], parameters[focals - 1]];
    let center = [parameters[*focals], parameters[focals + 1]];
    let bends = &parameters[focals + 2..];
    let distorted = name.contains("FISHEYE") || *name == "FOV" || bends.iter().any(|x| *x != 0.0);
    let camera = Intrinsics { focal, center: Some(center), size, distorted };
    camera.check()?;
    if !center.iter().all(|x| x.is_finite()) {
        return Err("the principal point must be finite".to_owned());
    }
    Ok(camera)
}
