//! `[camera]`.

use glam::DVec3;

use crate::scene::error::Error;
use crate::scene::schema::{Key, Part, Range, Vectors, settings};
use crate::scene::table::Table;
use crate::scene::view::View;

settings! {
    /// `[camera]` as given, and the view asked for on the command line; [`camera`](crate::scene::camera) fills in the rest.
    #[derive(Copy)]
    pub struct CameraSettings {
        /// Where the camera stands; ignored if a view is asked for.
        eye: Option<DVec3> = None, in Vectors::Any, unit "world units",
            without "the whole scene in view; inside a room that is scanned on all sides";
        /// The point that the camera looks at; ignored if a view is asked for.
        target: Option<DVec3> = None, in Vectors::Any, unit "world units", without "the middle of the scene";
        /// Which direction points to the top of the image; if a view is asked for, the nearest axis is its vertical.
        up: Option<DVec3> = None, in Vectors::Directions, without "the vertical of the clouds";
        /// How wide the view is from bottom to top: a perspective camera.
        fov_y: Option<f64> = None, in Range::open(0.0, 180.0), unit "degrees", without "45", rival "height";
        /// How much of the world the image shows from bottom to top: an orthographic camera.
        height: Option<f64> = None, in Range::POSITIVE, unit "world units", without "a perspective camera", rival "fov_y";
        /// An orthographic camera that shows the whole scene, unless `height` says how much.
        ortho: bool = false, rival "fov_y";
        /// The nearest depth that is drawn, by the points' own depths.
        near: Option<f64> = None, in Range::POSITIVE, unit "world units", without "before the scene";
        /// The farthest depth that is drawn, by the points' own depths.
        far: Option<f64> = None, in Range::POSITIVE, unit "world units", without "behind the scene";
        /// The direction from which the scene is framed; no key sets it.
        view: View = View::default();
    }
    check agree;
}

impl Part for View {
    type Allowed = ();

    fn keys(&self, _: Key, (): ()) -> Vec<Key> {
        Vec::new()
    }

    fn update(&mut self, _: &Table<'_>, _: &str, (): ()) -> Result<(), Error> {
        Ok(())
    }
}

fn agree(settings: &CameraSettings, table: &Table<'_>) -> Result<(), Error> {
    let conflict = |key: &str, problem: String| {
        let place = table.get(key).map_or(&table.place, |node| &node.place).clone();
        Err(Error::Conflict { place, problem })
    };
    if settings.fov_y.is_some() && settings.height.is_some() {
        return conflict(
            "height",
            "`camera.fov_y` (perspective) and `camera.height` (orthographic) are both given: keep one".into(),
        );
    }
    if settings.fov_y.is_some() && settings.ortho {
        return conflict(
            "ortho",
            "`camera.fov_y` (perspective) and `camera.ortho` (orthographic) are both given: keep one".into(),
        );
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
