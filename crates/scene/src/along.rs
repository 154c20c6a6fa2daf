//! Cameras of a path through a scene, and of a turn around it. Fills in the depths that a path leaves open, and the
//! values that keys and the turn take from the scene.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::error::{Error, Place};
use super::framed::{FILL, Spheres};
use super::framing::{self, Subject, ViewExtent};
use super::scene::Scene;
use super::settings::CameraSettings;
use super::view::Vertical;
use pellucid_core::camera::path::{Defaults, Pose, Turntable};
use pellucid_core::camera::{Camera, Projection, StatedCamera};
use pellucid_core::cloud::UpAxis;
use pellucid_core::points::Points;

/// A scene through which a camera moves.
pub struct Course<'a> {
    scene: &'a Scene,
    subject: Subject<'a>,
    /// Vertical of the clouds.
    up: UpAxis,
}

impl<'a> Course<'a> {
    /// Prepares cameras for a scene, its points, and the vertical of its clouds.
    ///
    /// # Errors
    /// No points, coordinates too large for a camera.
    pub fn new(scene: &'a Scene, points: &'a Points, up: UpAxis) -> Result<Self, Error> {
        let subject = framing::subject(scene, points)?;
        Ok(Self { scene, subject, up })
    }

    /// Returns values for keys that leave them open: `[camera] up`, or else the vertical, and the scene's lens.
    pub fn defaults(&self) -> Defaults {
        let settings = &self.scene.camera;
        let vertical = settings.vertical(self.up);
        let settings = framing::with_height(settings, &self.subject, self.scene.image.size, vertical);
        path_defaults(&settings, self.up)
    }

    /// Returns the camera of a pose, with the numbers of `[camera]` that give it again: to the last bit the pose of a
    /// key with a target, else the nearest camera that such numbers give. Its depths are the pose's, else those of
    /// `[camera]`, else from the scene's bounds as [`super::camera`] finds them.
    ///
    /// # Errors
    /// A nearest depth that is not below the farthest, an eye too far away.
    pub fn camera(&self, pose: &Pose) -> Result<StatedCamera, Error> {
        let settings = &self.scene.camera;
        let given = [pose.near.or(settings.near), pose.far.or(settings.far)];
        if let [Some(near), Some(far)] = given
            && near >= far
        {
            let problem = format!("near ({near}) must be less than far ({far}); the path sets only one of them");
            return Err(Error::Conflict { place: Place::Option("[camera]".into()), problem });
        }
        let bounds = &self.subject.all;
        let beyond = || Error::Extent { min: bounds.min, max: bounds.max };
        let camera = self.stated(pose).ok_or_else(beyond)?;
        let (near, far) = framing::depths(given, pose.eye, camera.forward, bounds, self.subject.radius);
        Some(camera.with_depths(near, far)).filter(|camera| framing::is_usable(camera)).ok_or_else(beyond)
    }

    /// The camera of a pose with any depths.
    fn stated(&self, pose: &Pose) -> Option<StatedCamera> {
        let Pose { eye, right, up, forward, projection, .. } = *pose;
        if let Some([target, up]) = pose.stated {
            return StatedCamera::look_at(eye, target, up, projection, 1.0, 2.0);
        }
        let level = framing::level_up(self.scene.camera.vertical(self.up), [right, up, forward]);
        let distance = (self.subject.bounds.center() - eye).length();
        StatedCamera::nearest(&pose.camera(1.0, 2.0), distance, level)
    }

    /// Returns the turn around the scene: around `[camera] target`, else the middle of the bounds, and `[camera] up`,
    /// else the vertical. It starts at [`super::camera`]; without an `eye` it starts far enough away to have all
    /// points, as spheres of their own radius, in the image during the whole turn. An `eye` from which a perspective
    /// would lose some of them moves back as far, along its line of sight, together with the depths given by
    /// `[camera]`; one within the scene's bounds looks around from there, and stays. Also returns warnings about the
    /// camera.
    ///
    /// # Errors
    /// Returns the errors of [`super::camera`].
    pub fn turntable(&self) -> Result<(Turntable, Vec<String>), Error> {
        let settings = &framing::automatic(self.scene, self.subject.framed.points, self.up);
        let (stated, warnings) = framing::camera_of(self.scene, settings, self.subject.framed.points, self.up)?;
        let start = stated.camera();
        // A view asked for replaces them.
        let own = !settings.view.is_given();
        let center = settings.target.filter(|_| own).unwrap_or_else(|| self.subject.bounds.center());
        let axis = settings.up.filter(|_| own);
        let axis = axis.unwrap_or_else(|| settings.vertical(self.up).up()).normalize();
        let start = if settings.ortho && settings.height.is_none() {
            self.widened(start, settings, center, axis)
        } else {
            start
        };
        if settings.eye.is_some() && own {
            let eye =
                if self.keeps_all(&start, center, axis) { start.eye } else { self.eye(&start, center, axis, true) };
            let mut turntable = Turntable::new(&Camera { eye, ..start }, center, axis);
            if eye == start.eye {
                // The first frame is the camera itself.
                turntable.start.stated = Some([stated.target(), stated.stated_up()]);
            }
            let back = (start.eye - eye).dot(start.forward);
            (turntable.start.near, turntable.start.far) =
                (settings.near.map(|near| near + back), settings.far.map(|far| far + back));
            return Ok((turntable, warnings));
        }
        let eye = self.eye(&start, center, axis, settings.target.is_some() && own);
        Ok((Turntable::new(&Camera { eye, ..start }, center, axis), warnings))
    }

    /// An orthographic camera that shows everything during the whole turn.
    fn widened(&self, start: Camera, settings: &CameraSettings, center: DVec3, axis: DVec3) -> Camera {
        let spheres = Spheres { framed: self.subject.framed, center, axes: [start.right, start.up, start.forward] };
        let extent = turned_extent(&spheres, DVec2::ZERO, axis);
        let height = framing::height_of(&extent, framing::is_centered(settings), self.scene.image.size, &self.subject);
        Camera { projection: Projection::Orthographic { height }, ..start }
    }

    /// Returns `true` if moving back would bring nothing new into the image: everything is in it during the whole turn,
    /// or the projection is orthographic, or the eye is among the points.
    fn keeps_all(&self, start: &Camera, center: DVec3, axis: DVec3) -> bool {
        let Projection::Perspective { .. } = start.projection else { return true };
        let tangents = framing::tangents(start.projection, self.scene.image.size) / FILL;
        let axes = [start.right, start.up, start.forward];
        let extent = turned_extent(&Spheres { framed: self.subject.framed, center, axes }, tangents, axis);
        let distance = (center - start.eye).dot(start.forward);
        let inside = self.subject.bounds.min.cmple(start.eye).all() && start.eye.cmple(self.subject.bounds.max).all();
        inside || distance >= extent.centered_distance(tangents)
    }

    /// The nearest eye that has everything in the image during the whole turn. If `centered`, it looks at the center,
    /// else past it above or below, so that the margins above and below are equal; those to the sides are equal anyway.
    fn eye(&self, start: &Camera, center: DVec3, axis: DVec3, centered: bool) -> DVec3 {
        let tangents = framing::tangents(start.projection, self.scene.image.size);
        let axes = [start.right, start.up, start.forward];
        let spheres = Spheres { framed: self.subject.framed, center, axes };
        let extent = turned_extent(&spheres, tangents, axis);
        let clear = framing::clearance(&self.subject, center, extent.nearest);
        let distance = match (start.projection, centered) {
            (Projection::Perspective { .. }, true) => extent.centered_distance(tangents).max(clear),
            (Projection::Perspective { .. }, false) => extent.distance(tangents).max(clear),
            (Projection::Orthographic { .. }, _) => clear,
        };
        let (first, last) = extent.shifts(tangents, distance);
        let shift = if centered { 0.0 } else { 0.5 * (first.y + last.y) };
        center + start.up * shift - start.forward * distance
    }
}

/// Returns values for keys that leave them open, in a scene with this `[camera]` whose clouds have this vertical.
pub fn path_defaults(camera: &CameraSettings, up: UpAxis) -> Defaults {
    let up = camera.up.unwrap_or_else(|| Vertical::from(up).up());
    Defaults { up, projection: framing::projection(camera) }
}

/// Returns the extent like [`Spheres::extent`], for everything that the points sweep in a turn around an axis through
/// the center.
///
/// A plane measures a point p by p·n. During the turn p moves on a circle of radius R at the height h along the axis a,
/// where p·n is at most h·(a·n) + R·|n − (a·n)a|.
fn turned_extent(spheres: &Spheres<'_>, tangents: DVec2, axis: DVec3) -> ViewExtent {
    let [right, up, forward] = spheres.axes;
    let reach = (DVec2::ONE + tangents * tangents).map(f64::sqrt);
    let most = |normal: DVec3| {
        let along = axis.dot(normal);
        let across = (normal - axis * along).length();
        move |height: f64, radius: f64| height * along + radius * across
    };
    let planes = [
        most(right - forward * tangents.x),
        most(up - forward * tangents.y),
        most(-right - forward * tangents.x),
        most(-up - forward * tangents.y),
    ];
    let nearest = most(-forward);
    let one = |(position, own): (DVec3, f64)| {
        let p = position - spheres.center;
        let height = p.dot(axis);
        let radius = (p - axis * height).length();
        let [x, y, minus_x, minus_y] = planes.each_ref().map(|plane| plane(height, radius));
        ViewExtent {
            upper: DVec2::new(x, y) + reach * own,
            lower: -DVec2::new(minus_x, minus_y) - reach * own,
            nearest: -nearest(height, radius) - own,
        }
    };
    spheres.framed.spheres().map(one).reduce(|| ViewExtent::NOTHING, ViewExtent::union)
}
