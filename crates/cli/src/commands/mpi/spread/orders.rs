//! Orders of the first rank to the others.

use pellucid_core::points::Known;
use pellucid_engine::methods::Frame;
use pellucid_engine::passes::bands::Window;
use pellucid_engine::passes::project::Parts;
use serde::{Deserialize, Serialize};

use super::super::ranks::{Ranks, encoded};

/// A thing to do. Some have bytes with them, in a message of their own.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Order {
    /// Open the device for such frames of a scene of which this is known, and how many points are solid and soft. The
    /// bytes are points that stand for all.
    Open { known: Known, frame: Frame, parts: Option<(f32, Parts)> },
    /// Keep the runs of points in the bytes.
    Keep,
    /// Render, round by round, the region of the rank's number. Passes may be timed, and listed one by one.
    Render { frame: Frame, rounds: Vec<Vec<Window>>, timed: bool, listed: bool },
    /// Stop: nothing is left to do.
    Stop,
}

/// Orders all others to do the same.
pub fn send_to_others(ranks: &Ranks, order: &Order, bytes: Option<&[u8]>) {
    let written = encoded(order);
    for rank in 1..ranks.count() {
        ranks.send(rank, &written);
        bytes.into_iter().for_each(|bytes| ranks.send(rank, bytes));
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use pellucid_core::camera::{Camera, Projection};
    use pellucid_scene::{Method, Scene};

    use super::*;

    #[test]
    fn frames_travel_to_the_last_bit() {
        let scene = Scene::from_toml("[[cloud]]\npath = \"a.ply\"\n", "scene.toml".as_ref()).expect("a scene");
        let projection = Projection::Perspective { fov_y: 1.0 / 3.0 };
        let eye = DVec3::new(0.1, 1.0 / 7.0, 1e30);
        let camera = Camera::look_at(eye, DVec3::ZERO, DVec3::Y, projection, 5e-324, 1e306).expect("a camera");
        for method in Method::all() {
            let mut frame =
                Frame { method, max_error: Some(f32::MIN_POSITIVE), ..Frame::of_scene(&scene, camera, u64::MAX) };
            frame.factors.opacity = 1.0 / 3.0;
            frame.factors.radius = f32::INFINITY;
            let order = Order::Render { frame, rounds: vec![vec![[0, 1, 2, 3]]], timed: true, listed: false };
            assert_eq!(postcard::from_bytes::<Order>(&encoded(&order)).expect("an order"), order, "{}", method.name());
        }
    }
}
