//! From where a scene is looked at when no eye is given: `--view`, `--azimuth`, `--elevation`.

use glam::DVec3;

use crate::cloud::UpAxis;

/// A named direction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ViewName {
    /// The side that a viewer of the file's convention faces: −Y for surveys (from the south), +Z for models.
    Front,
    /// From behind.
    Back,
    /// From −X.
    Left,
    /// From +X.
    Right,
    /// From above; north (surveys) or the back (models) is at the image's top.
    Top,
    /// From below.
    Bottom,
    /// From the front's right and above, all three axes equally foreshortened.
    Iso,
}

/// The direction asked for; all `None`: the default.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct View {
    /// The base that the angles override.
    pub name: Option<ViewName>,
    /// Degrees around the vertical from the front, counter-clockwise seen from above (90: from +X).
    pub azimuth: Option<f64>,
    /// Degrees above the horizon, from −90 to 90.
    pub elevation: Option<f64>,
}

impl View {
    /// True if anything was requested.
    pub fn is_given(&self) -> bool {
        *self != Self::default()
    }

    /// Azimuth and elevation in degrees.
    fn angles(&self, up: UpAxis) -> (f64, f64) {
        let (azimuth, elevation) = match (self.name, up) {
            (Some(ViewName::Front), _) => (0.0, 0.0),
            (Some(ViewName::Right), _) => (90.0, 0.0),
            (Some(ViewName::Back), _) => (180.0, 0.0),
            (Some(ViewName::Left), _) => (270.0, 0.0),
            (Some(ViewName::Top), _) => (0.0, 90.0),
            (Some(ViewName::Bottom), _) => (0.0, -90.0),
            (Some(ViewName::Iso), _) => (45.0, 1.0f64.atan2(std::f64::consts::SQRT_2).to_degrees()),
            (None, UpAxis::Z) => (30.0, 35.0),
            (None, UpAxis::Y) => (20.0, 15.0),
        };
        (self.azimuth.unwrap_or(azimuth), self.elevation.unwrap_or(elevation))
    }

    /// Unit vectors along the view and toward the image's top. They are orthogonal even straight from above.
    pub fn axes(&self, up: UpAxis) -> (DVec3, DVec3) {
        let (front, vertical) = match up {
            UpAxis::Z => (-DVec3::Y, DVec3::Z),
            UpAxis::Y => (DVec3::Z, DVec3::Y),
        };
        let (azimuth, elevation) = self.angles(up);
        let (sin_a, cos_a) = sin_cos_degrees(azimuth);
        let (sin_e, cos_e) = sin_cos_degrees(elevation);
        let outward = front * cos_a + DVec3::X * sin_a;
        (-(outward * cos_e + vertical * sin_e), vertical * cos_e - outward * sin_e)
    }
}

/// Sine and cosine, exact at multiples of 90°, so that the named views look exactly along the axes.
fn sin_cos_degrees(degrees: f64) -> (f64, f64) {
    let turn = degrees.rem_euclid(360.0);
    match turn {
        0.0 => (0.0, 1.0),
        90.0 => (1.0, 0.0),
        180.0 => (0.0, -1.0),
        270.0 => (-1.0, 0.0),
        _ => turn.to_radians().sin_cos(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn named(name: ViewName) -> View {
        View { name: Some(name), ..View::default() }
    }

    #[test]
    fn named_views_look_along_the_axes() {
        let z = |name| named(name).axes(UpAxis::Z);
        assert_eq!(z(ViewName::Front), (DVec3::Y, DVec3::Z));
        assert_eq!(z(ViewName::Right), (-DVec3::X, DVec3::Z));
        assert_eq!(z(ViewName::Back), (-DVec3::Y, DVec3::Z));
        assert_eq!(z(ViewName::Left), (DVec3::X, DVec3::Z));
        // A map: north up, east to the right (forward × up = −Z × Y = X).
        assert_eq!(z(ViewName::Top), (-DVec3::Z, DVec3::Y));
        assert_eq!(named(ViewName::Front).axes(UpAxis::Y), (-DVec3::Z, DVec3::Y));
        assert_eq!(named(ViewName::Top).axes(UpAxis::Y), (-DVec3::Y, -DVec3::Z));
    }

    #[test]
    fn iso_shortens_all_axes_equally_and_angles_override() {
        let (forward, _) = named(ViewName::Iso).axes(UpAxis::Z);
        let third = 1.0 / 3f64.sqrt();
        assert!((forward - DVec3::new(-third, third, -third)).length() < 1e-15);
        let (forward, up) = View { azimuth: Some(-90.0), elevation: Some(0.0), name: None }.axes(UpAxis::Z);
        assert_eq!((forward, up), (DVec3::X, DVec3::Z));
    }
}
