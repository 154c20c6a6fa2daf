//! Direction from which a scene is looked at when no eye is given: `--view`, `--azimuth`, `--elevation`.

use glam::DVec3;

use pellucid_core::cloud::UpAxis;

/// The vertical of a scene: along an axis of the world, either way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Vertical(DVec3);

impl Vertical {
    /// Returns the axis nearest to a direction; `None` if that lies between two.
    pub fn nearest(up: DVec3) -> Option<Self> {
        let length = up.abs().to_array();
        let longest = (0..3).max_by(|a, b| length[*a].total_cmp(&length[*b]))?;
        let alone = (0..3).all(|axis| axis == longest || length[axis] < length[longest]);
        // The sum leaves no zero with a sign.
        alone.then(|| Self(DVec3::AXES[longest] * up[longest].signum() + DVec3::ZERO))
    }

    /// Returns its unit vector, upward.
    pub fn up(self) -> DVec3 {
        self.0
    }

    /// Returns its place among the axes: 0 for x, 1 for y, 2 for z.
    pub fn index(self) -> usize {
        (0..3).find(|axis| self.0[*axis] != 0.0).unwrap_or(2)
    }

    /// Direction to the right of a viewer before the front: +X, or +Y where X is the vertical.
    pub fn right(self) -> DVec3 {
        if self.index() == 0 { DVec3::Y } else { DVec3::X }
    }

    /// Direction toward a viewer before the front: −Y where Z is up, +Z where Y is.
    pub fn front(self) -> DVec3 {
        self.right().cross(self.0)
    }
}

impl From<UpAxis> for Vertical {
    fn from(up: UpAxis) -> Self {
        // The sum leaves no zero with a sign.
        Self(up.direction() + DVec3::ZERO)
    }
}

/// Writes the axis as `--up` has it.
impl std::fmt::Display for Vertical {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let sign = if self.0[self.index()] < 0.0 { "-" } else { "" };
        write!(f, "{sign}{}", ["x", "y", "z"][self.index()])
    }
}

/// Declares the named directions with their words, azimuths, elevations where these are not the usual one, and what the
/// words mean.
macro_rules! view_names {
    ($($Name:ident = $word:literal, $azimuth:literal, $elevation:expr, $about:literal;)+) => {
        /// A named direction. Those of a compass look from there at the usual elevation, where +X is east and, with Z
        /// up, +Y is north.
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub enum ViewName {
            $(#[doc = $about] $Name,)+
        }

        impl ViewName {
            /// All, with the word for each and its meaning.
            pub const ALL: &'static [(Self, &'static str, &'static str)] = &[$((Self::$Name, $word, $about)),+];

            /// Azimuth and elevation in degrees; `None` of the usual elevation.
            fn angles(self) -> (f64, Option<f64>) {
                match self {
                    $(Self::$Name => ($azimuth, $elevation),)+
                }
            }
        }
    };
}

view_names! {
    Front = "front", 0.0, Some(0.0), "From the front: −Y in surveys (from the south), +Z in models.";
    Back = "back", 180.0, Some(0.0), "From behind.";
    Left = "left", 270.0, Some(0.0), "From −X.";
    Right = "right", 90.0, Some(0.0), "From +X.";
    Top = "top", 0.0, Some(90.0), "From above, with north (surveys) or the back (models) at the top of the image.";
    Bottom = "bottom", 0.0, Some(-90.0), "From below.";
    Iso = "iso", 45.0, Some(1.0f64.atan2(std::f64::consts::SQRT_2).to_degrees()),
        "From the front's right and above, all three axes equally foreshortened.";
    South = "south", 0.0, None, "From the south and above.";
    SouthEast = "south-east", 45.0, None, "From the south-east and above.";
    East = "east", 90.0, None, "From the east and above.";
    NorthEast = "north-east", 135.0, None, "From the north-east and above.";
    North = "north", 180.0, None, "From the north and above.";
    NorthWest = "north-west", 225.0, None, "From the north-west and above.";
    West = "west", 270.0, None, "From the west and above.";
    SouthWest = "south-west", 315.0, None, "From the south-west and above.";
}

impl ViewName {
    /// Returns the direction of a word.
    pub fn named(word: &str) -> Option<Self> {
        Self::ALL.iter().find(|(_, known, _)| *known == word).map(|(name, ..)| *name)
    }
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
    /// Returns `true` if anything was requested.
    pub fn is_given(&self) -> bool {
        *self != Self::default()
    }

    /// Azimuth and elevation in degrees.
    fn angles(&self, vertical: Vertical) -> (f64, f64) {
        // Things that stand are looked at, landscapes looked down upon.
        let (usual, above) = if vertical.index() == 1 { (20.0, 15.0) } else { (30.0, 35.0) };
        let (azimuth, elevation) = self.name.map_or((usual, None), ViewName::angles);
        (self.azimuth.unwrap_or(azimuth), self.elevation.or(elevation).unwrap_or(above))
    }

    /// Returns its azimuth in degrees.
    pub(super) fn azimuth_of(&self, vertical: Vertical) -> f64 {
        self.angles(vertical).0
    }

    /// Returns unit vectors along the view and toward the image's top. They are orthogonal even straight from above.
    pub fn axes(&self, vertical: impl Into<Vertical>) -> (DVec3, DVec3) {
        let frame = vertical.into();
        let (front, vertical) = (frame.front(), frame.up());
        let (azimuth, elevation) = self.angles(frame);
        let (sin_a, cos_a) = sin_cos_degrees(azimuth);
        let (sin_e, cos_e) = sin_cos_degrees(elevation);
        let outward = front * cos_a + frame.right() * sin_a;
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
    fn a_compass_looks_from_where_it_says() {
        let from = |name| {
            let (forward, up) = named(name).axes(UpAxis::Z);
            assert!(forward.z < 0.0 && up.z > 0.0 && forward.dot(up).abs() < 1e-15);
            -DVec3::new(forward.x, forward.y, 0.0).normalize()
        };
        let diagonal = std::f64::consts::FRAC_1_SQRT_2;
        for (name, wanted) in [
            (ViewName::South, [0.0, -1.0]),
            (ViewName::SouthEast, [diagonal, -diagonal]),
            (ViewName::East, [1.0, 0.0]),
            (ViewName::NorthEast, [diagonal, diagonal]),
            (ViewName::North, [0.0, 1.0]),
            (ViewName::NorthWest, [-diagonal, diagonal]),
            (ViewName::West, [-1.0, 0.0]),
            (ViewName::SouthWest, [-diagonal, -diagonal]),
        ] {
            assert!((from(name) - DVec3::new(wanted[0], wanted[1], 0.0)).length() < 1e-15, "{name:?}");
        }
    }

    #[test]
    fn any_axis_may_be_the_vertical() {
        for up in [DVec3::X, DVec3::Y, DVec3::Z].into_iter().flat_map(|axis| [axis, -axis]) {
            let vertical = Vertical::nearest(3.0 * up + DVec3::splat(0.5)).unwrap();
            assert_eq!(vertical.up(), up);
            // Right-handed: what is right of the viewer, the top of the image, and toward the viewer.
            assert_eq!(vertical.right().cross(up), vertical.front());
            let (forward, image_up) = named(ViewName::Front).axes(vertical);
            assert_eq!((forward, image_up), (-vertical.front(), up));
            let (forward, _) = View::default().axes(vertical);
            assert!(forward.dot(up) < 0.0, "from above");
        }
        assert_eq!(Vertical::nearest(DVec3::new(1.0, -1.0, 0.5)), None);
        assert_eq!(Vertical::nearest(DVec3::ZERO), None);
        assert_eq!(Vertical::nearest(-DVec3::Y).unwrap().to_string(), "-y");
        // A depth camera's frame: x to the right, y down, z ahead.
        assert_eq!(Vertical::nearest(-DVec3::Y).unwrap().front(), -DVec3::Z);
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
