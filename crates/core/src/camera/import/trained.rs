//! The `cameras.json` that the training of 3D Gaussian Splatting writes beside a model: a list of cameras.
//!
//! `position` is the eye, and `rotation` has the rows of the matrix from the camera to the world; the camera's axes
//! are OpenCV's: x right, y down, z forward.

use std::path::Path;

use glam::{DQuat, DVec3};
use serde::Deserialize;
use serde::de::IgnoredAny;

use super::{Cameras, Intrinsics, View, check_count, content, is_place, rotation, warnings};
use crate::camera::path::{Error, from_text};

#[derive(Debug, Deserialize)]
struct Camera {
    img_name: Option<String>,
    width: Option<f64>,
    height: Option<f64>,
    position: Option<[f64; 3]>,
    rotation: Option<[[f64; 3]; 3]>,
    fx: Option<f64>,
    fy: Option<f64>,
    /// Principal point, which only some programs write.
    cx: Option<f64>,
    cy: Option<f64>,
    /// The pose in the lists of `ns-export cameras`.
    transform: Option<IgnoredAny>,
}

pub fn read(text: &str, path: &Path) -> Result<Cameras, Error> {
    let cameras: Vec<Camera> = from_text(text, path)?;
    check_count(path, cameras.len(), "cameras")?;
    let mut views = Vec::new();
    let mut intrinsics = Vec::new();
    for (number, camera) in cameras.iter().enumerate() {
        let name = camera.img_name.as_ref().map_or(String::new(), |name| format!(" ({name})"));
        let wrong = |problem: String| content(path, format!("camera [{number}]{name}: {problem}"));
        let lens = camera.lens().map_err(wrong)?;
        let (eye, turn) = camera.pose().map_err(wrong)?;
        views.push(View { eye, turn, angle: lens.angle() });
        intrinsics.push(lens);
    }
    let name = path.display();
    let warnings = warnings(&intrinsics).into_iter().map(|warning| format!("{name}: {warning}")).collect();
    Ok(Cameras { views, size: intrinsics.first().map(Intrinsics::pixels), warnings })
}

impl Camera {
    fn lens(&self) -> Result<Intrinsics, String> {
        if self.transform.is_some() {
            return Err("this list of `ns-export cameras` has no field of view; give the transforms.json of the data"
                .to_owned());
        }
        let size = [need(self.width, "width")?, need(self.height, "height")?];
        let focal = [need(self.fx, "fx")?, need(self.fy, "fy")?];
        let center = self.cx.zip(self.cy).map(|(x, y)| [x, y]);
        let lens = Intrinsics { focal, center, size, distorted: false };
        lens.check()?;
        Ok(lens)
    }

    fn pose(&self) -> Result<(DVec3, DQuat), String> {
        let eye = DVec3::from(need(self.position, "position")?);
        if !is_place(eye) {
            return Err("position is farther away than 1e75".to_owned());
        }
        let rows = need(self.rotation, "rotation")?;
        let column = |at: usize| DVec3::new(rows[0][at], rows[1][at], rows[2][at]);
        let turn = rotation([column(0), -column(1), -column(2)])
            .ok_or("rotation is none: its columns must be orthogonal and right-handed")?;
        Ok((eye, turn))
    }
}

fn need<T>(value: Option<T>, name: &str) -> Result<T, String> {
    value.ok_or_else(|| {
        format!(
            "{name} is missing; a cameras.json of 3D Gaussian Splatting has width, height, position, rotation, fx and fy for \
             each camera"
        )
    })
}
