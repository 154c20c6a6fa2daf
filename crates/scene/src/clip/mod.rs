//! `[[clip]]` for points: which of them are kept.

mod polygon;

use glam::DVec3;

use super::error::Error;
use super::settings::{Clip, ClipShape};
use pellucid_io as io;
use polygon::Area;

/// Side on which a point lies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Side {
    Inside,
    Border,
    Outside,
}

/// Tells where points lie.
type SideTest = Box<dyn Fn(DVec3) -> Side + Send + Sync>;

/// The clips of a scene, with the polygons of their files.
#[derive(Default)]
pub(super) struct Clips {
    /// Each with `invert`.
    clips: Vec<(SideTest, bool)>,
}

impl std::fmt::Debug for Clips {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} clips", self.clips.len())
    }
}

impl Clips {
    /// Reads the files of the polygons.
    ///
    /// # Errors
    /// A file that can't be read, or has no polygon.
    pub fn load(clips: &[Clip]) -> Result<Self, Error> {
        let load = |clip: &Clip| Ok((shape(&clip.shape)?, clip.invert));
        Ok(Self { clips: clips.iter().map(load).collect::<Result<_, Error>>()? })
    }

    /// Returns `true` if all points are kept.
    pub fn is_empty(&self) -> bool {
        self.clips.is_empty()
    }

    /// Returns `true` if every clip keeps a point. Borders are kept on either side.
    pub fn keep(&self, p: DVec3) -> bool {
        self.clips.iter().all(|(side, invert)| match side(p) {
            Side::Border => true,
            Side::Inside => !invert,
            Side::Outside => *invert,
        })
    }
}

fn shape(shape: &ClipShape) -> Result<SideTest, Error> {
    Ok(match *shape {
        ClipShape::Box { min, max } => {
            Box::new(move |p: DVec3| within([0, 1, 2].map(|axis| (min[axis], p[axis], max[axis]))))
        }
        ClipShape::Plane { point, normal } => Box::new(move |p: DVec3| side_of_sign((p - point).dot(normal))),
        ClipShape::Slab { axis, min, max } => {
            let (min, max) = (min.unwrap_or(f64::NEG_INFINITY), max.unwrap_or(f64::INFINITY));
            Box::new(move |p: DVec3| within([(min, p[axis], max)]))
        }
        ClipShape::Polygon(ref path) => {
            let area = Area::new(&io::polygon::read(path)?);
            Box::new(move |p: DVec3| area.side(p.truncate()))
        }
    })
}

/// The side of numbers that are each between two others.
fn within<const N: usize>(spans: [(f64, f64, f64); N]) -> Side {
    if spans.iter().any(|(min, x, max)| x < min || x > max) {
        Side::Outside
    } else if spans.iter().any(|(min, x, max)| x == min || x == max) {
        Side::Border
    } else {
        Side::Inside
    }
}

fn side_of_sign(x: f64) -> Side {
    match x {
        x if x > 0.0 => Side::Inside,
        x if x < 0.0 => Side::Outside,
        _ => Side::Border,
    }
}
