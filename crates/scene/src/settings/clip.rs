//! `[[clip]]`: where points are drawn.

use std::path::PathBuf;

use glam::DVec3;

use crate::error::Error;
use crate::schema::{Key, Range, ValueKind, keys};
use crate::table::Table;

/// An entry of `[[clip]]`. A point is drawn if every entry keeps its center.
#[derive(Debug, Clone, PartialEq)]
pub struct Clip {
    /// The part of the world that is kept, in the scene's coordinates. Its border is kept always.
    pub shape: ClipShape,
    /// `true` if everything outside is kept instead.
    pub invert: bool,
}

/// A part of the world.
#[derive(Debug, Clone, PartialEq)]
pub enum ClipShape {
    /// A box along the axes.
    Box {
        /// Smallest corner.
        min: DVec3,
        /// Largest corner.
        max: DVec3,
    },
    /// The side of a plane that its normal points to.
    Plane {
        /// A point of the plane.
        point: DVec3,
        /// Not zero; any length.
        normal: DVec3,
    },
    /// The space between two planes across an axis.
    Slab {
        /// 0 for x, 1 for y, 2 for z.
        axis: usize,
        /// The lower plane.
        min: Option<f64>,
        /// The upper plane.
        max: Option<f64>,
    },
    /// The inside of the polygons of a GeoJSON file, at any z.
    Polygon(PathBuf),
}

/// The keys of an entry.
const KEYS: [&str; 5] = ["box", "plane", "slab", "polygon", "invert"];

impl Clip {
    /// Returns the keys of `[[clip]]` with their descriptions.
    pub fn keys() -> Vec<Key> {
        keys! {
            /// Keep the inside of a box along the axes.
            "box": ValueKind::Other("`{ min = [x, y, z], max = [x, y, z] }`"), without "one of the four must be given";
            /// Keep the side of a plane that its normal points to.
            "plane": ValueKind::Other("`{ point = [x, y, z], normal = [x, y, z] }`"),
                without "one of the four must be given";
            /// Keep the space from `min` to `max` along an axis; one of them may be left out.
            "slab": ValueKind::Other("`{ axis = \"x\", min = …, max = … }`, or `\"y\"`, or `\"z\"`"),
                without "one of the four must be given";
            /// GeoJSON file; keep the inside of its polygons in x and y, without their holes.
            "polygon": ValueKind::Text, without "one of the four must be given";
            /// Keep the outside instead.
            "invert": ValueKind::Flag, value Some(false.into());
        }
    }

    /// Reads an entry.
    pub(crate) fn read(table: &Table<'_>) -> Result<Self, Error> {
        table.refuse_unknown(&KEYS)?;
        let given: Vec<_> = KEYS[..4].iter().copied().filter(|key| table.get(key).is_some()).collect();
        let [shape] = given[..] else {
            let problem = "a [[clip]] needs one of `box`, `plane`, `slab` and `polygon`, found";
            return Err(table.conflict("", format!("{problem} {}", given.len())));
        };
        let shape = match shape {
            "box" => read_box(&table.table("box")?)?,
            "plane" => read_plane(&table.table("plane")?)?,
            "slab" => read_slab(&table.table("slab")?)?,
            _ => ClipShape::Polygon(table.path_of("polygon")?.unwrap_or_default()),
        };
        Ok(Self { shape, invert: table.boolean("invert")?.unwrap_or(false) })
    }
}

fn read_box(table: &Table<'_>) -> Result<ClipShape, Error> {
    table.refuse_unknown(&["min", "max"])?;
    match (table.vector("min")?, table.vector("max")?) {
        (Some(min), Some(max)) if min.cmple(max).all() => Ok(ClipShape::Box { min, max }),
        (Some(_), Some(_)) => Err(table.conflict("", "the `min` of a box must be at most its `max`, on every axis")),
        _ => Err(table.conflict("", "a box needs `min` and `max`")),
    }
}

fn read_plane(table: &Table<'_>) -> Result<ClipShape, Error> {
    table.refuse_unknown(&["point", "normal"])?;
    match (table.vector("point")?, table.direction("normal")?) {
        (Some(point), Some(normal)) => Ok(ClipShape::Plane { point, normal }),
        _ => Err(table.conflict("", "a plane needs `point` and `normal`")),
    }
}

fn read_slab(table: &Table<'_>) -> Result<ClipShape, Error> {
    table.refuse_unknown(&["axis", "min", "max"])?;
    let axis = table.choice("axis", &[("x", 0), ("y", 1), ("z", 2)])?;
    match (axis, table.number("min", Range::ANY)?, table.number("max", Range::ANY)?) {
        (Some(axis), min, max) if min.or(max).is_some() => match (min, max) {
            (Some(least), Some(most)) if least > most => {
                Err(table.conflict("", "the `min` of a slab must be at most its `max`"))
            }
            _ => Ok(ClipShape::Slab { axis, min, max }),
        },
        _ => Err(table.conflict("", "a slab needs `axis`, and `min` or `max`")),
    }
}
