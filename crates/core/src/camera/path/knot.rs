//! A key frame as the curve takes it.

use glam::{DMat3, DQuat, DVec3};

use super::{Defaults, Key, Problem};
use crate::camera::{Camera, Projection};

/// Eye, axes and lens of a key.
#[derive(Debug, Clone, Copy)]
pub struct Knot {
    pub eye: DVec3,
    /// Axes toward the image's right and top, and along the view: as a scene's camera has them, without the rounding of
    /// `turn`.
    pub axes: [DVec3; 3],
    pub projection: Projection,
    /// Distance of the target; 0 for a key without one.
    pub reach: f64,
    /// Rotation from the camera's axes (x right, y up, −z forward) to the world's.
    pub turn: DQuat,
    pub lens: Lens,
    pub near: Option<f64>,
    pub far: Option<f64>,
    /// The unit vector of a target's `up`; `None` for an orientation.
    pub up: Option<DVec3>,
    /// Target and `up` as they were given; `None` for an orientation.
    pub stated: Option<[DVec3; 2]>,
}

/// The logarithm of what a size in the picture is proportional to, so that a zoom is even.
#[derive(Debug, Clone, Copy)]
pub struct Lens {
    pub orthographic: bool,
    /// ln cot(fov_y / 2), or ln height.
    pub log: f64,
}

impl Lens {
    fn from_projection(projection: Projection) -> Self {
        match projection {
            Projection::Perspective { fov_y } => Self { orthographic: false, log: -(0.5 * fov_y).tan().ln() },
            Projection::Orthographic { height } => Self { orthographic: true, log: height.ln() },
        }
    }

    pub fn projection(self) -> Projection {
        if self.orthographic {
            Projection::Orthographic { height: self.log.exp() }
        } else {
            Projection::Perspective { fov_y: 2.0 * (-self.log).exp().atan() }
        }
    }
}

impl Knot {
    /// Makes a knot from a validated key.
    pub fn new(number: usize, key: &Key, defaults: &Defaults) -> Result<Self, Problem> {
        let eye = DVec3::from(key.eye);
        let projection = match (key.fov_y, key.height) {
            (Some(fov_y), _) => Projection::Perspective { fov_y: fov_y.to_radians() },
            (None, Some(height)) => Projection::Orthographic { height },
            (None, None) => defaults.projection,
        };
        let (turn, axes, reach, stated) = match (key.orientation, key.target) {
            (Some([w, x, y, z]), _) => {
                let turn = DQuat::from_xyzw(x, y, z, w).normalize();
                (turn, [DVec3::X, DVec3::Y, DVec3::NEG_Z].map(|axis| turn * axis), 0.0, None)
            }
            (None, target) => {
                let target = DVec3::from(target.unwrap_or(key.eye));
                let arm = target - eye;
                let up = key.up.map_or(defaults.up, DVec3::from);
                // Step by step as `scene::camera` does, so that a key gives the camera of a scene with its vectors, bit
                // for bit.
                let camera =
                    Camera::look_at(DVec3::ZERO, arm.normalize(), up, projection, 1.0, 2.0).ok_or_else(|| {
                        Problem::of_key(
                            number,
                            "up",
                            format!("{up} is parallel to the view {arm}; give another direction"),
                        )
                    })?;
                let Camera { right, up: top, forward, .. } = camera;
                let turn = DQuat::from_mat3(&DMat3::from_cols(right, top, -forward)).normalize();
                (turn, [right, top, forward], arm.length(), Some([target, up]))
            }
        };
        let lens = Lens::from_projection(projection);
        let up = stated.map(|[_, up]| up.normalize());
        Ok(Self { eye, axes, projection, reach, turn, lens, near: key.near, far: key.far, up, stated })
    }

    pub fn forward(&self) -> DVec3 {
        self.turn * DVec3::NEG_Z
    }
}
