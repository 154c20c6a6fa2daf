//! The turn around a scene.

use glam::DVec3;
use pellucid::camera::path::Turntable;
use pellucid::camera::{Camera, Projection};
use pellucid::cloud::UpAxis;
use pellucid::scene::View;

#[test]
fn a_quarter_is_ninety_degrees_of_azimuth() {
    let center = DVec3::new(10.0, -3.0, 2.0);
    let camera = |azimuth: f64, up: UpAxis| {
        let view = View { name: None, azimuth: Some(azimuth), elevation: Some(25.0) };
        let (forward, top) = view.axes(up);
        let projection = Projection::Perspective { fov_y: 0.7 };
        let camera = Camera::look_at(DVec3::ZERO, forward, top, projection, 0.1, 10.0).unwrap();
        Camera { eye: center - forward * 7.0, ..camera }
    };
    for (up, axis) in [(UpAxis::Z, DVec3::Z), (UpAxis::Y, DVec3::Y)] {
        let frames = Turntable::new(&camera(20.0, up), center, axis).frames(36);
        assert_eq!(frames.len(), 36);
        for (i, frame) in frames.iter().enumerate() {
            let expected = camera(20.0 + 10.0 * i as f64, up);
            let pairs = [
                (frame.eye, expected.eye),
                (frame.right, expected.right),
                (frame.up, expected.up),
                (frame.forward, expected.forward),
            ];
            for (a, b) in pairs {
                assert!((a - b).length() < 1e-13 * 20.0, "{up:?}, frame {i}: {a} {b}");
            }
        }
        let quarter = camera(110.0, up);
        assert!((frames[9].eye - quarter.eye).length() < 1e-12 && (frames[8].eye - quarter.eye).length() > 0.1);
    }
}
