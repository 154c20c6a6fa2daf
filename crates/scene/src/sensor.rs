//! The camera of points that one sensor saw: it stands where the sensor stood, and sees what the sensor saw.

use std::f64::consts::{PI, TAU};

use glam::{DQuat, DVec3};
use rayon::prelude::*;

use super::framed::{FILL, Framed};
use super::settings::CameraSettings;
use pellucid_core::cloud::Bounds;
use pellucid_core::cloud::sensor::Sensor;

/// Largest distance of a sensor from the box of its points, in diagonals of the box.
const FAR: f64 = 1.0;
/// Largest slope of the image's sides that an automatic field of view has: 60 degrees to either side.
const WIDEST: f64 = 1.732;
/// Sectors of the horizon around a scanner.
const SECTORS: usize = 72;
/// Sectors without points that leave a scanner a side where it saw nothing.
const OPEN: usize = 6;

/// Returns the settings of a camera in the place of the sensor that saw all of the points. `None` where the settings
/// say anything of eye, target, view, lens or depths, without such a sensor, and where it stands far from the points or
/// a depth camera does not face them.
///
/// The field of view holds all points. A scanner whose points lie aside from its forward axis is turned to their
/// middle, and one with points all around keeps the default field of view.
pub(super) fn seen_from(
    settings: &CameraSettings,
    framed: &Framed<'_>,
    bounds: &Bounds,
    [width, height]: [u32; 2],
) -> Option<CameraSettings> {
    let sensor = framed.points.sensor.filter(|_| settings.leave_place_open())?;
    let distance = (sensor.position.clamp(bounds.min, bounds.max) - sensor.position).length();
    let diagonal = bounds.diagonal();
    if !distance.is_finite() || distance > FAR * diagonal || diagonal == 0.0 {
        return None;
    }
    let aspect = f64::from(width) / f64::from(height);
    let own = Look { position: sensor.position, forward: sensor.forward, up: sensor.up };
    let (look, slope) = match (own.slope(framed, aspect), sensor.turns) {
        (Some(slope), _) => (own, Some(slope)),
        (None, false) => return None,
        (None, true) => {
            let turned = middle(&sensor, framed);
            let slope = turned.slope(framed, aspect);
            (turned, slope)
        }
    };
    let fitting = slope.map(|slope| (2.0 * (slope / FILL).atan()).to_degrees());
    let ahead = (bounds.center() - look.position).dot(look.forward);
    let ahead = if ahead > 0.0 { ahead } else { 0.5 * diagonal };
    Some(CameraSettings {
        eye: Some(look.position),
        target: Some(look.position + ahead * look.forward),
        up: Some(settings.up.unwrap_or(look.up)),
        fov_y: settings.fov_y.or(fitting),
        ..*settings
    })
}

/// Place and axes of a camera.
struct Look {
    position: DVec3,
    forward: DVec3,
    up: DVec3,
}

impl Look {
    /// Returns the slope of the image's upper side with which all points are in the image; `None` if some are beside
    /// what an image can show.
    fn slope(&self, framed: &Framed<'_>, aspect: f64) -> Option<f64> {
        let right = self.forward.cross(self.up);
        let slopes = |(position, _): (DVec3, f64)| {
            let p = position - self.position;
            let [x, y, z] = [right, self.up, self.forward].map(|axis| p.dot(axis));
            // A point in the sensor is seen in no direction.
            if p == DVec3::ZERO {
                return [0.0; 2];
            }
            if z > 0.0 { [x.abs() / z, y.abs() / z] } else { [f64::INFINITY; 2] }
        };
        let larger = |a: [f64; 2], b: [f64; 2]| [a[0].max(b[0]), a[1].max(b[1])];
        let [x, y] = framed.spheres().map(slopes).reduce(|| [0.0; 2], larger);
        let slope = y.max(x / aspect);
        (x.max(y) <= WIDEST && slope > 0.0).then_some(slope)
    }
}

/// Returns a scanner turned to the middle of what it saw, or as it is if it saw something all around.
fn middle(sensor: &Sensor, framed: &Framed<'_>) -> Look {
    let right = sensor.forward.cross(sensor.up);
    // Sectors with points, and the lowest and the highest elevation.
    type Seen = ([bool; SECTORS], [f64; 2]);
    let nothing = || ([false; SECTORS], [f64::INFINITY, f64::NEG_INFINITY]);
    let add = |(mut sectors, [low, high]): Seen, (position, _): (DVec3, f64)| {
        let p = position - sensor.position;
        let [x, y, z] = [right, sensor.up, sensor.forward].map(|axis| p.dot(axis));
        let across = x.hypot(z);
        if across == 0.0 {
            return (sectors, [low, high]);
        }
        let turn = (x.atan2(z) + PI) / TAU;
        sectors[((turn * SECTORS as f64) as usize).min(SECTORS - 1)] = true;
        let elevation = y.atan2(across);
        (sectors, [low.min(elevation), high.max(elevation)])
    };
    let both = |a: Seen, b: Seen| {
        let sectors = std::array::from_fn(|i| a.0[i] | b.0[i]);
        (sectors, [a.1[0].min(b.1[0]), a.1[1].max(b.1[1])])
    };
    let (sectors, [low, high]) = framed.spheres().fold(nothing, add).reduce(nothing, both);
    let (start, length) = longest_gap(&sectors);
    let own = Look { position: sensor.position, forward: sensor.forward, up: sensor.up };
    if length < OPEN || length == SECTORS {
        return own;
    }
    // Opposite to the gap's middle.
    let azimuth = (start as f64 + 0.5 * length as f64) / SECTORS as f64 * TAU;
    let level = DQuat::from_axis_angle(sensor.up, -azimuth) * sensor.forward;
    let pitch = 0.5 * (low + high);
    let forward = level * pitch.cos() + sensor.up * pitch.sin();
    Look { forward, up: sensor.up * pitch.cos() - level * pitch.sin(), ..own }
}

/// The longest run of empty sectors around the circle, the first one of several: where it begins, and its length.
fn longest_gap(sectors: &[bool; SECTORS]) -> (usize, usize) {
    let run = |start: usize| (0..SECTORS).take_while(|i| !sectors[(start + i) % SECTORS]).count();
    (0..SECTORS)
        .map(|start| (start, run(start)))
        .fold((0, 0), |best, found| if found.1 > best.1 { found } else { best })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Scene, camera, camera_notes};
    use pellucid_core::camera::{Camera, Projection};
    use pellucid_core::cloud::UpAxis;
    use pellucid_core::points::Points;

    fn seen_by(sensor: Option<Sensor>, positions: Vec<DVec3>) -> Points {
        Points { sensor, ..pellucid_testing_host::white(positions, 0.01) }
    }

    fn found(keys: &str, points: &Points) -> Camera {
        let text = format!("{keys}\n[image]\nsize = [400, 300]\n[[cloud]]\npath = 'a.pcd'");
        let scene = Scene::from_toml(&text, "s.toml".as_ref()).unwrap();
        camera(&scene, points, UpAxis::Z).unwrap().0
    }

    fn is_close(a: DVec3, b: DVec3) -> bool {
        a.distance(b) < 1e-9
    }

    /// Points that a camera in the origin sees along +Z with slopes of up to 0.6 and 0.45.
    fn image() -> Vec<DVec3> {
        let place = |i: i32, j: i32| DVec3::new(f64::from(i) * 0.03, f64::from(j) * 0.03, 1.0);
        let far = |i: i32, j: i32| 1.0 + f64::from((i + 2 * j).rem_euclid(7));
        (-20..=20).flat_map(|i| (-15..=15).map(move |j| place(i, j) * far(i, j))).collect()
    }

    #[test]
    fn a_depth_image_is_seen_from_its_camera() {
        let pose = (DVec3::new(5.0, -3.0, 2.0), DQuat::from_rotation_y(0.7) * DQuat::from_rotation_x(-0.4));
        for (place, turn) in [(DVec3::ZERO, DQuat::IDENTITY), pose] {
            let positions: Vec<DVec3> = image().into_iter().map(|p| place + turn * p).collect();
            let points = seen_by(Some(Sensor::depth_camera(place, turn)), positions.clone());
            let camera = found("", &points);
            assert!(is_close(camera.eye, place) && is_close(camera.forward, turn * DVec3::Z));
            assert!(is_close(camera.up, turn * DVec3::NEG_Y) && is_close(camera.right, turn * DVec3::X));
            // Everything is in the image, which is about as large.
            let Projection::Perspective { fov_y } = camera.projection else { panic!("an orthographic camera") };
            assert!(((0.5 * fov_y).tan() - 0.45 / 0.95).abs() < 1e-9, "{fov_y}");
            let pixels = positions.iter().map(|p| camera.project(*p, [400, 300]).0);
            assert!(pixels.into_iter().all(|p| p.x > 0.0 && p.x < 400.0 && p.y > 0.0 && p.y < 300.0));
            let mut shuffled = positions;
            shuffled.reverse();
            assert_eq!(found("", &seen_by(points.sensor, shuffled)), camera);
        }
    }

    #[test]
    fn a_scan_is_seen_from_its_scanner() {
        let wall = |from: f64, to: f64| -> Vec<DVec3> {
            let at = |i: i32| (from + (to - from) * f64::from(i) / 60.0).to_radians();
            (0..=60)
                .flat_map(|i| (-10..=10).map(move |j| DVec3::new(at(i).cos(), at(i).sin(), 0.03 * f64::from(j)) * 8.0))
                .collect()
        };
        let sensor = Some(Sensor::laser(DVec3::ZERO, DQuat::IDENTITY));
        let ahead = found("", &seen_by(sensor, wall(-30.0, 40.0)));
        assert!(is_close(ahead.eye, DVec3::ZERO) && is_close(ahead.forward, DVec3::X) && is_close(ahead.up, DVec3::Z));
        // Points to the left of it: it turns there.
        let left = found("", &seen_by(sensor, wall(60.0, 120.0)));
        assert!(is_close(left.eye, DVec3::ZERO) && left.forward.distance(DVec3::Y) < 0.05, "{}", left.forward);
        let back = found("", &seen_by(sensor, wall(150.0, 210.0)));
        assert!(back.forward.distance(DVec3::NEG_X) < 0.05, "{}", back.forward);
        // Points all around are seen with the default field of view.
        let around = found("", &seen_by(sensor, wall(-180.0, 180.0)));
        assert!(is_close(around.eye, DVec3::ZERO) && is_close(around.forward, DVec3::X));
        assert_eq!(around.projection, Projection::Perspective { fov_y: 45f64.to_radians() });
    }

    #[test]
    fn other_clouds_and_stated_cameras_stay() {
        let sensor = Some(Sensor::depth_camera(DVec3::ZERO, DQuat::IDENTITY));
        let points = seen_by(sensor, image());
        let eye = |keys: &str, points: &Points| found(keys, points).eye;
        assert_eq!(eye("[camera]\neye = [9, 9, 9]", &points), DVec3::splat(9.0));
        for keys in ["[camera]\ntarget = [0, 0, 3]", "[camera]\northo = true", "[camera]\nnear = 0.5"] {
            assert!(!is_close(eye(keys, &points), DVec3::ZERO), "{keys}");
        }
        assert!(!is_close(eye("", &seen_by(None, image())), DVec3::ZERO));
        // Behind the camera, or far from it.
        assert!(!is_close(eye("", &seen_by(sensor, image().into_iter().map(|p| -p).collect())), DVec3::ZERO));
        let one = seen_by(Some(Sensor::laser(DVec3::ONE, DQuat::IDENTITY)), vec![DVec3::ONE; 3]);
        assert!(!is_close(eye("", &one), DVec3::ONE), "all in the sensor");
        let far = image().into_iter().map(|p| p + 1e3 * DVec3::Z).collect();
        assert!(!is_close(eye("", &seen_by(sensor, far)), DVec3::ZERO));
        let fov = found("[camera]\nfov_y = 30", &points);
        assert!(is_close(fov.eye, DVec3::ZERO));
        assert_eq!(fov.projection, Projection::Perspective { fov_y: 30f64.to_radians() });
    }

    #[test]
    fn clouds_of_one_sensor_are_seen_from_it_and_others_are_not() {
        let sensor = Some(Sensor::depth_camera(DVec3::ZERO, DQuat::IDENTITY));
        let other = Some(Sensor::depth_camera(DVec3::X, DQuat::IDENTITY));
        let both = |other: Option<Sensor>| {
            let mut points = seen_by(sensor, image());
            points.append(seen_by(other, image()));
            points
        };
        assert_eq!(both(sensor).sensor, sensor);
        assert!(both(other).sensor.is_none() && both(None).sensor.is_none());
        let mut nothing = Points::default();
        nothing.append(seen_by(sensor, image()));
        assert_eq!(nothing.sensor, sensor);
        let scene = Scene::from_toml("[[cloud]]\npath = 'a.pcd'", "s.toml".as_ref()).unwrap();
        let notes = camera_notes(&scene, &both(sensor), UpAxis::Z);
        assert!(
            notes[0].contains("all points were seen from (0, 0, 0)") && notes[0].contains("--view iso"),
            "{notes:?}"
        );
        assert!(!camera_notes(&scene, &both(other), UpAxis::Z).iter().any(|note| note.contains("seen from")));
    }
}
