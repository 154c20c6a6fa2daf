//! nerfstudio's `transforms.json` (docs.nerf.studio, "Data conventions"), also used by Instant NGP and the synthetic
//! scenes of NeRF.
//!
//! A frame's `transform_matrix` maps the camera to the world; the camera's axes are OpenGL's: x right, y up, −z
//! forward.

use std::path::Path;

use glam::DVec3;
use serde::Deserialize;
use serde::de::IgnoredAny;
use serde_json::Value;

use super::colmap::MODELS;
use super::{Angle, Cameras, Intrinsics, View, check_count, content, is_place, rotation, warnings};
use crate::camera::path::{Error, from_text};

#[derive(Debug, Deserialize)]
struct File {
    #[serde(flatten)]
    lens: Lens,
    applied_transform: Option<Value>,
    applied_scale: Option<f64>,
    frames: Vec<Frame>,
}

impl File {
    /// A warning about what the cameras have been moved by.
    fn applied(&self) -> Option<String> {
        let scale = self.applied_scale.filter(|scale| *scale != 1.0).map(|_| "applied_scale");
        let names: Vec<_> =
            self.applied_transform.as_ref().map(|_| "applied_transform").into_iter().chain(scale).collect();
        (!names.is_empty()).then(|| {
            format!(
                "its cameras are used as they are, after its {}; a cloud from before that needs the same transform",
                names.join(" and ")
            )
        })
    }
}

#[derive(Debug, Deserialize)]
struct Frame {
    /// Rows of a 3 × 4 or 4 × 4 matrix.
    transform_matrix: Vec<[f64; 4]>,
    #[serde(flatten)]
    lens: Lens,
}

/// The lens of all frames, or of one.
#[derive(Debug, Default, Deserialize)]
struct Lens {
    camera_model: Option<String>,
    /// Keys of Instant NGP for lenses that are no pinholes.
    is_fisheye: Option<bool>,
    latlong: Option<IgnoredAny>,
    ftheta_p0: Option<IgnoredAny>,
    /// Full angles in radians.
    camera_angle_x: Option<f64>,
    camera_angle_y: Option<f64>,
    fl_x: Option<f64>,
    fl_y: Option<f64>,
    cx: Option<f64>,
    cy: Option<f64>,
    /// Some programs write a float here.
    w: Option<f64>,
    h: Option<f64>,
    k1: Option<f64>,
    k2: Option<f64>,
    k3: Option<f64>,
    k4: Option<f64>,
    p1: Option<f64>,
    p2: Option<f64>,
}

/// The known lens parameters of a frame.
enum KnownLens {
    Pixels(Intrinsics),
    Angle(Angle),
}

pub fn read(text: &str, path: &Path) -> Result<Cameras, Error> {
    let file: File = from_text(text, path)?;
    check_count(path, file.frames.len(), "frames")?;
    let mut views = Vec::new();
    let mut intrinsics = Vec::new();
    for (number, frame) in file.frames.iter().enumerate() {
        let wrong = |problem: String| content(path, format!("frames[{number}]: {problem}"));
        let lens = Both { frame: &frame.lens, file: &file.lens };
        lens.check_model().map_err(wrong)?;
        let angle = match lens.known().map_err(wrong)? {
            KnownLens::Pixels(camera) => {
                intrinsics.push(camera);
                camera.angle()
            }
            KnownLens::Angle(angle) => angle,
        };
        let (eye, turn) = pose(&frame.transform_matrix).map_err(wrong)?;
        views.push(View { eye, turn, angle });
    }
    let mut warnings = warnings(&intrinsics);
    let is_bent = |frame: &Frame| Both { frame: &frame.lens, file: &file.lens }.is_distorted();
    if intrinsics.is_empty() && file.frames.iter().any(is_bent) {
        warnings.push("the lens distortion is ignored".to_owned());
    }
    warnings.extend(file.applied());
    let name = path.display();
    let warnings = warnings.into_iter().map(|warning| format!("{name}: {warning}")).collect();
    Ok(Cameras { views, size: intrinsics.first().map(Intrinsics::pixels), warnings })
}

/// Eye and rotation of a camera-to-world matrix.
fn pose(rows: &[[f64; 4]]) -> Result<(DVec3, glam::DQuat), String> {
    if !(3..=4).contains(&rows.len()) {
        return Err(format!("transform_matrix must have 4 rows (or 3) of 4 numbers, not {}", rows.len()));
    }
    let column = |i: usize| DVec3::new(rows[0][i], rows[1][i], rows[2][i]);
    let eye = column(3);
    if !is_place(eye) {
        return Err("transform_matrix puts the camera farther away than 1e75".to_owned());
    }
    let turn = rotation([column(0), column(1), column(2)])
        .ok_or("transform_matrix is not a rotation: its first three columns must be orthogonal and right-handed")?;
    Ok((eye, turn))
}

/// Models of a pinhole, with or without a lens that bends lines.
fn is_perspective(model: &str) -> bool {
    MODELS.iter().any(|(known, ..)| *known == model) || ["PERSPECTIVE", "FISHEYE", "FISHEYE624"].contains(&model)
}

/// A frame's own numbers over those of the file.
struct Both<'a> {
    frame: &'a Lens,
    file: &'a Lens,
}

impl Both<'_> {
    fn get(&self, value: fn(&Lens) -> Option<f64>) -> Option<f64> {
        value(self.frame).or_else(|| value(self.file))
    }

    /// Name of the camera's model in capital letters.
    fn model(&self) -> Option<String> {
        self.frame.camera_model.as_ref().or(self.file.camera_model.as_ref()).map(|model| model.to_uppercase())
    }

    /// Refuses cameras that are neither pinholes nor lenses in front of one.
    fn check_model(&self) -> Result<(), String> {
        let has = |is: fn(&Lens) -> bool| is(self.frame) || is(self.file);
        let other = match self.model() {
            Some(model) if !is_perspective(&model) => format!("camera_model {model}"),
            _ if has(|lens| lens.latlong.is_some()) => "latlong".to_owned(),
            _ if has(|lens| lens.ftheta_p0.is_some()) => "ftheta_p0".to_owned(),
            _ => return Ok(()),
        };
        Err(format!("{other}: only perspective cameras are read here, PINHOLE, OPENCV and COLMAP's other models"))
    }

    fn is_distorted(&self) -> bool {
        // A fisheye bends lines even where all its coefficients are 0.
        let fisheye = self.model().is_some_and(|model| model.contains("FISHEYE"))
            || self.frame.is_fisheye.or(self.file.is_fisheye) == Some(true);
        let values: [fn(&Lens) -> Option<f64>; 6] =
            [|lens| lens.k1, |lens| lens.k2, |lens| lens.k3, |lens| lens.k4, |lens| lens.p1, |lens| lens.p2];
        fisheye || values.into_iter().any(|value| self.get(value).is_some_and(|x| x != 0.0))
    }

    fn known(&self) -> Result<KnownLens, String> {
        let (angle_x, angle_y) = (self.get(|lens| lens.camera_angle_x), self.get(|lens| lens.camera_angle_y));
        for (name, angle) in [("camera_angle_x", angle_x), ("camera_angle_y", angle_y)] {
            if angle.is_some_and(|angle| !(angle > 0.0 && angle < std::f64::consts::PI)) {
                return Err(format!("{name} must be radians between 0 and π, both excluded"));
            }
        }
        let (focal_x, focal_y) = (self.get(|lens| lens.fl_x), self.get(|lens| lens.fl_y));
        let size = self.get(|lens| lens.w).zip(self.get(|lens| lens.h));
        let Some((width, height)) = size else {
            return match (angle_y, angle_x) {
                (Some(angle), _) => Ok(KnownLens::Angle(Angle::Vertical(angle))),
                (None, Some(angle)) => Ok(KnownLens::Angle(Angle::Horizontal(angle))),
                (None, None) if focal_x.or(focal_y).is_some() => Err("fl_x and fl_y need w and h".to_owned()),
                (None, None) => {
                    Err("the field of view is missing: give fl_x, fl_y, w and h, or camera_angle_x".to_owned())
                }
            };
        };
        let from_angle = |side: f64, angle: Option<f64>| angle.map(|angle| 0.5 * side / (0.5 * angle).tan());
        let along_x = focal_x.or_else(|| from_angle(width, angle_x));
        let along_y = focal_y.or_else(|| from_angle(height, angle_y));
        let (Some(x), Some(y)) = (along_x.or(along_y), along_y.or(along_x)) else {
            return Err("the field of view is missing: give fl_x or camera_angle_x".to_owned());
        };
        let center = self.get(|lens| lens.cx).zip(self.get(|lens| lens.cy)).map(|(x, y)| [x, y]);
        let camera = Intrinsics { focal: [x, y], center, size: [width, height], distorted: self.is_distorted() };
        camera.check()?;
        Ok(KnownLens::Pixels(camera))
    }
}
