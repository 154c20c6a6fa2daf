//! Entries of `[[clip]]` that are added, changed and taken out.

use glam::DVec3;

use pellucid_engine::cloud::Bounds;
use pellucid_engine::scene::{Change, Clip, ClipShape, Setting};

/// How far a new box stays inside the points, as a share of their extent, so that its faces can be seen and held.
const INSET: f64 = 0.01;

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
    let at = |share: f64| short(bounds.min + share * (bounds.max - bounds.min), bounds.diagonal());
    let shape = match kind {
        NewClip::Box => ClipShape::Box { min: at(INSET), max: at(1.0 - INSET) },
        NewClip::Slab(axis) => ClipShape::Slab { axis, min: Some(at(0.25)[axis]), max: Some(at(0.75)[axis]) },
        NewClip::Plane(axis, along) => {
            let normal = if along { DVec3::AXES[axis] } else { -DVec3::AXES[axis] };
            ClipShape::Plane { point: at(0.5), normal }
        }
    };
    Clip { shape, invert: false }
}

/// A place as short as a scene of this diagonal allows: to a thousandth of it or less.
pub fn short(place: DVec3, diagonal: f64) -> DVec3 {
    DVec3::from(place.to_array().map(|x| short_number(x, diagonal)))
}

/// A coordinate as short as a scene of this diagonal allows.
pub fn short_number(x: f64, diagonal: f64) -> f64 {
    let digits = (3.0 - diagonal.max(f64::MIN_POSITIVE).log10()).ceil().clamp(0.0, 12.0);
    let factor = 10f64.powf(digits);
    (x * factor).round() / factor
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
    use pellucid_engine::scene::{Document, Overrides};

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
        // 1% of 200.8, 150 and 33.7; the diagonal is 253, so that a decimal is left.
        assert_eq!((min, max), (DVec3::new(84_002.1, 447_001.5, -1.7), DVec3::new(84_198.9, 447_148.5, 31.4)));
        let Bounds { min: low, max: high } = bounds();
        assert!(min.cmpgt(low).all() && max.cmplt(high).all());
        let flat = Bounds { min: DVec3::ZERO, max: DVec3::new(1.0, 1.0, 0.0) };
        let ClipShape::Box { min, max } = new_clip(NewClip::Box, flat).shape else { panic!("a box") };
        assert!(min.cmple(max).all(), "still a box: {min} {max}");
    }
}
