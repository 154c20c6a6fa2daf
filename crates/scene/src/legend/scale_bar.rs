//! A length that an orthographic picture shows everywhere alike.

use super::UNITS;
use pellucid_core::camera::{Camera, Projection};
use pellucid_core::cloud::crs::Unit;
use pellucid_core::color::ticks::round_below;

/// A line with its length in the world.
#[derive(Debug, Clone, PartialEq)]
pub struct ScaleBar {
    /// World units: 1, 2 or 5 times a power of ten.
    pub length: f64,
    /// Pixels of the image, at most a quarter of its width.
    pub length_px: f64,
    /// The length as text, with its unit.
    pub label: String,
}

impl ScaleBar {
    /// The most of the image's width that a scale bar takes.
    pub const MOST: f32 = 0.25;

    /// Returns the longest one for an image of so many columns and rows, of lengths in a unit, if it is known; `None`
    /// where the same length has many sizes, in perspective.
    pub fn of(camera: &Camera, size: [u32; 2], unit: Option<&Unit>) -> Option<Self> {
        let Projection::Orthographic { height } = camera.projection else { return None };
        let units_per_px = height / f64::from(size[1]);
        let (length, label) = round_below(f64::from(Self::MOST) * f64::from(size[0]) * units_per_px)?;
        let label = match unit {
            Some(unit) => unit.with(&label),
            None if length == 1.0 => format!("{label} {}", UNITS.trim_end_matches('s')),
            None => format!("{label} {UNITS}"),
        };
        Some(Self { length, length_px: length / units_per_px, label })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    fn camera(projection: Projection) -> Camera {
        Camera::look_at(DVec3::Z, DVec3::ZERO, DVec3::Y, projection, 0.1, 10.0).unwrap()
    }

    #[test]
    fn a_bar_is_as_long_as_its_length_in_the_picture() {
        for (height, size, length, label) in [
            // 800 px show 80 units; a quarter of them is 20.
            (60.0, [800, 600], 20.0, "20 units"),
            (59.9, [800, 600], 10.0, "10 units"),
            (3.0, [640, 480], 1.0, "1 unit"),
            (1e-3, [100, 100], 2e-4, "0.0002 units"),
        ] {
            let camera = camera(Projection::Orthographic { height });
            let bar = ScaleBar::of(&camera, size, None).unwrap();
            assert_eq!((bar.length, bar.label.as_str()), (length, label));
            // Measured by the camera: two points a length apart.
            let ends = [DVec3::ZERO, DVec3::X * length].map(|p| camera.project(p, size).0.x);
            assert!((ends[1] - ends[0] - bar.length_px).abs() < 1e-9 * bar.length_px, "{bar:?}");
            assert!(bar.length_px <= 0.25 * f64::from(size[0]) * (1.0 + 1e-12));
        }
        assert_eq!(ScaleBar::of(&camera(Projection::Perspective { fov_y: 1.0 }), [800, 600], None), None);
        let flat = camera(Projection::Orthographic { height: 3.0 });
        for (unit, label) in [
            (Unit::length("", 0.3048), "1 ft"),
            (Unit::length("", 1200.0 / 3937.0), "1 US survey ft"),
            (Some(Unit::metre()), "1 m"),
            (Some(Unit::degree()), "1°"),
            (Unit::length("rod", 5.0292), "1 rod"),
        ] {
            assert_eq!(ScaleBar::of(&flat, [640, 480], unit.as_ref()).unwrap().label, label);
        }
    }
}
