//! Entries of `[[clip]]` that are added, changed and taken out.

use glam::DVec3;

use pellucid_core::cloud::Bounds;
use pellucid_scene::{Change, Clip, ClipShape, Setting};

/// Margin of a new box inside the points, as a share of their extent, so that its faces can be seen and held.
const INSET: f64 = 0.01;

/// The most decimals that coordinates are rounded to.
const MOST_DECIMALS: f64 = 12.0;

/// The names of the axes in a scene file.
pub const AXES: [&str; 3] = ["x", "y", "z"];

/// A kind of entry that can be added.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NewClip {
    /// A box slightly inside the points.
    Box,
    /// The middle half of the points along an axis.
    Slab(usize),
    /// The half of the points that an axis points to; with `false` the other one.
    Plane(usize, bool),
}

/// The clip of this kind for points in a box.
pub fn new_clip(kind: NewClip, bounds: Bounds) -> Clip {
    let extent = bounds.max - bounds.min;
    let at = |share: f64, round: fn(f64) -> f64| {
        let place = bounds.min + share * extent;
        DVec3::from([0, 1, 2].map(|axis| rounded(place[axis], extent[axis], round)))
    };
    let shape = match kind {
        NewClip::Box => ClipShape::Box { min: at(INSET, f64::floor), max: at(1.0 - INSET, f64::ceil) },
        NewClip::Slab(axis) => {
            let [min, max] = [0.25, 0.75].map(|share| Some(at(share, f64::round)[axis]));
            ClipShape::Slab { axis, min, max }
        }
        NewClip::Plane(axis, along) => {
            let normal = if along { DVec3::AXES[axis] } else { -DVec3::AXES[axis] };
            ClipShape::Plane { point: at(0.5, f64::round), normal }
        }
    };
    Clip { shape, invert: false }
}

/// The decimals that numbers need in an extent: a thousandth of it or less. `None` where there is no extent, or hardly
/// any.
pub fn decimals(extent: f64) -> Option<usize> {
    let digits = (extent > 0.0).then(|| (3.0 - extent.log10()).ceil().max(0.0))?;
    (digits <= MOST_DECIMALS).then_some(digits as usize)
}

/// A coordinate as short as the extent along its axis allows. Without an extent it stays as it is.
pub fn short_number(x: f64, extent: f64) -> f64 {
    rounded(x, extent, f64::round)
}

fn rounded(x: f64, extent: f64, round: fn(f64) -> f64) -> f64 {
    let Some(digits) = decimals(extent) else { return x };
    let factor = 10f64.powi(digits as i32);
    round(x * factor) / factor
}

/// The changes that make the entry `at` of `[[clip]]` this clip. It is an entry of that shape already, or the next one.
pub fn clip_changes(at: usize, clip: &Clip) -> Vec<Change> {
    let key = |name: &str| format!("clip.{at}.{name}");
    let vector = |name: &str, v: DVec3| (key(name), Some(Setting::from(v.to_array())));
    let number = |name: &str, x: Option<f64>| (key(name), x.map(Setting::Number));
    let mut changes = match clip.shape {
        ClipShape::Box { min, max } => vec![vector("box.min", min), vector("box.max", max)],
        ClipShape::Plane { point, normal } => vec![vector("plane.point", point), vector("plane.normal", normal)],
        ClipShape::Slab { axis, min, max } => {
            let name = AXES.get(axis).copied().unwrap_or("z");
            vec![(key("slab.axis"), Some(name.into())), number("slab.min", min), number("slab.max", max)]
        }
        ClipShape::Polygon(_) => vec![],
    };
    changes.push((key("invert"), clip.invert.then_some(Setting::Flag(true))));
    changes
}

/// The changes that take out the entry `at` of so many.
pub fn without_clip(at: usize, count: usize) -> Vec<Change> {
    let key = if count == 1 { "clip".to_owned() } else { format!("clip.{at}") };
    vec![(key, None)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec2;
    use pellucid_scene::{Document, Overrides};

    fn bounds() -> Bounds {
        Bounds { min: DVec3::new(84_000.123_456, 447_000.0, -2.0), max: DVec3::new(84_200.9, 447_150.0, 31.7) }
    }

    #[test]
    fn clips_come_change_and_go() {
        let mut document = Document::from_clouds(["a.laz"], &Overrides::default()).unwrap();
        let before = document.to_toml("".as_ref()).unwrap();
        let kinds = [NewClip::Box, NewClip::Slab(2), NewClip::Plane(0, false), NewClip::Slab(0)];
        let mut clips: Vec<Clip> = kinds.map(|kind| new_clip(kind, bounds())).to_vec();
        for (at, clip) in clips.iter().enumerate() {
            document.change(&clip_changes(at, clip)).unwrap();
        }
        assert_eq!(document.scene().unwrap().clips, clips);
        clips[1] = Clip { shape: ClipShape::Slab { axis: 1, min: None, max: Some(5.0) }, invert: true };
        clips[2].shape = ClipShape::Plane { point: DVec3::ONE, normal: DVec3::new(1.0, 2.0, 0.0) };
        for at in [1, 2] {
            document.change(&clip_changes(at, &clips[at])).unwrap();
        }
        assert_eq!(document.scene().unwrap().clips, clips);
        for at in [1, 2, 0, 0] {
            document.change(&without_clip(at, clips.len())).unwrap();
            clips.remove(at);
            assert_eq!(document.scene().unwrap().clips, clips);
        }
        assert_eq!(document.to_toml("".as_ref()).unwrap(), before);
    }

    #[test]
    fn a_new_box_is_slightly_inside_and_its_numbers_are_short() {
        let ClipShape::Box { min, max } = new_clip(NewClip::Box, bounds()).shape else { panic!("a box") };
        // 1% of 200.8, 150 and 33.7, outward: a decimal is left of the first two, and two of the last.
        assert_eq!((min, max), (DVec3::new(84_002.1, 447_001.5, -1.67), DVec3::new(84_198.9, 447_148.5, 31.37)));
        let Bounds { min: low, max: high } = bounds();
        assert!(min.cmpgt(low).all() && max.cmplt(high).all());
        let flat = Bounds { min: DVec3::ZERO, max: DVec3::new(1.0, 1.0, 0.0) };
        let ClipShape::Box { min, max } = new_clip(NewClip::Box, flat).shape else { panic!("a box") };
        assert!(min.cmple(max).all(), "still a box: {min} {max}");
    }

    /// Checks that the margin of each axis follows its own extent: the others may be much longer.
    #[test]
    fn flat_points_stay_inside_what_is_made_for_them() {
        let z = 0.123_456;
        let flat = Bounds { min: DVec3::new(-3.0, 5.0, z), max: DVec3::new(997.0, 805.0, z) };
        let ClipShape::Box { min, max } = new_clip(NewClip::Box, flat).shape else { panic!("a box") };
        assert_eq!((min, max), (DVec3::new(7.0, 13.0, z), DVec3::new(987.0, 797.0, z)));
        let slab = ClipShape::Slab { axis: 2, min: Some(z), max: Some(z) };
        assert_eq!(new_clip(NewClip::Slab(2), flat).shape, slab);
        let plane = ClipShape::Plane { point: DVec3::new(497.0, 405.0, z), normal: DVec3::Z };
        assert_eq!(new_clip(NewClip::Plane(2, true), flat).shape, plane);

        let terrain = Bounds { min: DVec3::new(0.0, 0.0, 10.2), max: DVec3::new(1000.0, 800.0, 10.4) };
        let ClipShape::Box { min, max } = new_clip(NewClip::Box, terrain).shape else { panic!("a box") };
        assert_eq!((min.truncate(), max.truncate()), (DVec2::new(10.0, 8.0), DVec2::new(990.0, 792.0)));
        // 10.202 and 10.398, or the next step outward.
        assert!((10.2018..=10.202).contains(&min.z) && (10.398..=10.3982).contains(&max.z), "{min} {max}");
        let slab = ClipShape::Slab { axis: 2, min: Some(10.25), max: Some(10.35) };
        assert_eq!(new_clip(NewClip::Slab(2), terrain).shape, slab);
    }

    #[test]
    fn numbers_are_as_short_as_their_extent_allows() {
        for (x, extent, wanted) in
            [(10.234_567, 0.2, 10.2346), (10.234_567, 1000.0, 10.0), (0.123_456, 0.0, 0.123_456), (-7.6, 1e9, -8.0)]
        {
            assert_eq!(short_number(x, extent), wanted);
        }
        assert_eq!([0.0, 1e-12, 0.2, 1.0, 150.0, 1e6].map(decimals), [None, None, Some(4), Some(3), Some(1), Some(0)]);
    }
}
