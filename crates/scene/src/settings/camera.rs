//! `[camera]`.

use glam::DVec3;

use crate::error::Error;
use crate::schema::{Key, Range, SettingsField, Vectors, settings, words};
use crate::table::Table;
use crate::view::{Vertical, View};
use pellucid_core::cloud::UpAxis;

settings! {
    /// `[camera]` as given, and the view asked for on the command line; [`camera`](crate::camera) fills in the rest.
    #[derive(Copy)]
    pub struct CameraSettings {
        /// Position of the camera; ignored if a view is requested.
        eye: Option<DVec3> = None, in Vectors::Any, unit "world units",
            without "the whole scene in view; where the sensor of all points stood; inside a room that is scanned on all sides";
        /// Point that the camera looks at; ignored if a view is requested.
        target: Option<DVec3> = None, in Vectors::Any, unit "world units", without "the middle of the scene";
        /// Direction that points up in the image; a requested view uses the nearest axis.
        up: Option<DVec3> = None, in Vectors::Directions, without "the vertical of the clouds";
        /// Vertical field of view of a perspective camera.
        fov_y: Option<f64> = None, in Range::open(0.0, 180.0), unit "degrees", without "45", rival "height";
        /// Height of the image in the world, for an orthographic camera.
        height: Option<f64> = None, in Range::POSITIVE, unit "world units", without "a perspective camera", rival "fov_y";
        /// Use an orthographic camera; it shows the whole scene unless `height` is given.
        ortho: bool = false, rival "fov_y";
        /// Nearest depth that is drawn, measured at the center of each point.
        near: Option<f64> = None, in Range::POSITIVE, unit "world units", without "in front of the scene";
        /// Farthest depth that is drawn, measured at the center of each point.
        far: Option<f64> = None, in Range::POSITIVE, unit "world units", without "behind the scene";
        /// Points that an automatic camera shows.
        frame: Frame = Frame::Drawn;
        /// The direction from which the scene is framed; no key sets it.
        view: View = View::default();
    }
    check agree;
}

words! {
    /// `frame`.
    pub enum Frame {
        /// Points that are drawn, without the few that lie far from all others.
        Drawn = "drawn",
        /// All points, also those that a class hides or a clip cuts off.
        All = "all",
    }
}

impl CameraSettings {
    /// Returns the vertical: the axis nearest to `up` of the camera, else that of the clouds.
    pub fn vertical(&self, up: UpAxis) -> Vertical {
        self.up.and_then(Vertical::nearest).unwrap_or(up.into())
    }

    /// Returns `true` if nothing is said of eye, target, view, lens or depths: the points may ask for a place among
    /// them.
    pub(crate) fn leave_place_open(&self) -> bool {
        let Self { up, fov_y, frame, .. } = *self;
        *self == Self { up, fov_y, frame, ..Self::default() }
    }

    /// Returns the settings that show the whole scene from a view, upright: `up` is then only the vertical axis.
    pub fn seen_from(&self, view: View) -> Self {
        let up = self.up.and_then(Vertical::nearest).map(Vertical::up);
        Self { view, eye: None, target: None, up, height: None, ..*self }
    }
}

impl SettingsField for View {
    type Allowed = ();

    fn keys(&self, _: Key, (): ()) -> Vec<Key> {
        Vec::new()
    }

    fn update(&mut self, _: &Table<'_>, _: &str, (): ()) -> Result<(), Error> {
        Ok(())
    }
}

fn agree(settings: &CameraSettings, table: &Table<'_>) -> Result<(), Error> {
    let conflict = |key: &str, problem: String| Err(table.conflict(key, problem));
    let kept = |other: &str| {
        format!("`camera.fov_y` (perspective) and `camera.{other}` (orthographic) are both given: keep one")
    };
    if settings.fov_y.is_some() && settings.height.is_some() {
        return conflict("height", kept("height"));
    }
    if settings.fov_y.is_some() && settings.ortho {
        return conflict("ortho", kept("ortho"));
    }
    if let (Some(near), Some(far)) = (settings.near, settings.far)
        && near >= far
    {
        return conflict("near", format!("`camera.near` must lie below `camera.far`, found {near} and {far}"));
    }
    if let (Some(eye), Some(target)) = (settings.eye, settings.target) {
        let Some(forward) = (target - eye).try_normalize() else {
            return conflict("target", format!("`camera.eye` and `camera.target` are the same point, {eye}"));
        };
        if let Some(up) = settings.up
            // The bound of `Camera::look_at`.
            && forward.cross(up.normalize_or_zero()).length() < 1e-6
        {
            return conflict("up", format!("`camera.up` {up} points along the view, from {eye} to {target}"));
        }
    }
    Ok(())
}
