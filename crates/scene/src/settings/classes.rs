//! `[[cloud.class]]`: what is different about some points of a cloud.

use glam::Vec3;

use crate::error::Error;
use crate::schema::{Key, Range, SettingsField, ValueKind, keys};
use crate::table::Table;
use crate::tree::{Node, Value};
use pellucid_core::cloud::CLASSIFICATION_NAMES;
use pellucid_core::color::classes;
use pellucid_core::words::nearest;
use pellucid_io::LasColumns;

/// The points that an entry is about.
#[derive(Debug, Clone, PartialEq)]
pub enum Selection {
    /// Points of a class.
    Class(u8),
    /// Points whose scalar lies in a range, its ends included.
    Scalar {
        /// The scalar's name.
        name: String,
        /// Lower and upper end.
        range: [f64; 2],
    },
}

impl Selection {
    /// Returns `true` if points of this class are among its points because of their class.
    pub fn holds_class(&self, code: u8) -> bool {
        match self {
            Self::Class(own) => *own == code,
            Self::Scalar { name, range: [low, high] } => {
                CLASSIFICATION_NAMES.contains(&name.to_lowercase().as_str())
                    && (*low..=*high).contains(&f64::from(code))
            }
        }
    }
}

/// An entry of `[[cloud.class]]`. For each point and key the last entry counts that is about the point and gives the
/// key.
#[derive(Debug, Clone, PartialEq)]
pub struct ClassSettings {
    /// Points that the entry is about.
    pub points: Selection,
    /// Opacity in place of the cloud's; the file's alpha multiplies it.
    pub opacity: Option<f32>,
    /// Color in place of the cloud's, linear RGB.
    pub color: Option<Vec3>,
    /// Radius in place of the cloud's and the file's, in world units; `radius_factor` multiplies it.
    pub radius: Option<f32>,
    /// False for points that are not drawn.
    pub visible: Option<bool>,
}

impl ClassSettings {
    /// Returns the columns of LAS files that it needs.
    pub fn las_columns(&self) -> LasColumns {
        match &self.points {
            Selection::Class(_) => LasColumns::default(),
            Selection::Scalar { name, .. } => LasColumns::named(name),
        }
    }
}

/// The class of a number or a name.
fn code(table: &Table<'_>, node: &Node) -> Result<u8, Error> {
    let found = match &node.value {
        Value::Integer(i) => u8::try_from(*i).ok(),
        Value::String(word) => match word.parse().ok().or_else(|| classes::code(word)) {
            None => {
                let hint = nearest(word, classes::names(), "the names are");
                return Err(table.error("id", node, format!("names no class: {word:?}{hint}")));
            }
            found => found,
        },
        _ => None,
    };
    found.ok_or_else(|| table.wrong("id", node, "an integer from 0 to 255 or the name of a class"))
}

fn read(table: &Table<'_>) -> Result<ClassSettings, Error> {
    table.refuse_unknown(&["id", "scalar", "range", "opacity", "color", "radius", "visible"])?;
    let points = match (table.get("id"), table.string("scalar")?, table.range("range")?) {
        (Some(node), None, None) => Selection::Class(code(table, node)?),
        (None, Some(name), Some(range)) => Selection::Scalar { name: name.to_owned(), range },
        _ => return Err(table.conflict("", "a [[cloud.class]] needs either `id`, or `scalar` and `range`")),
    };
    let opacity = table.number32("opacity", Range::UNIT)?;
    let radius = table.number32("radius", Range::NOT_NEGATIVE)?;
    let (color, visible) = (table.color("color")?, table.boolean("visible")?);
    if opacity.is_none() && color.is_none() && radius.is_none() && visible.is_none() {
        return Err(table.conflict("", "a [[cloud.class]] needs `opacity`, `color`, `radius` or `visible`"));
    }
    Ok(ClassSettings { points, opacity, color, radius, visible })
}

impl SettingsField for Vec<ClassSettings> {
    type Allowed = ();

    fn keys(&self, _: Key, (): ()) -> Vec<Key> {
        keys! {
            /// Class of the points that this entry of `[[cloud.class]]` changes. For each key the last matching entry
            /// counts.
            "class.id": ValueKind::Other(
                "integer from 0 to 255, or a name as `\"ground\"`, `\"high-vegetation\"`, `\"building\"`, `\"water\"`",
            ), without "by `scalar`";
            /// Name of the scalar that selects the points, with `range`.
            "class.scalar": ValueKind::Text, without "by `id`";
            /// Range of the scalar, including both ends.
            "class.range": ValueKind::Other("`[low, high]`"), without "by `id`";
            /// Opacity of these points, in place of the cloud's.
            "class.opacity": ValueKind::Number(Range::UNIT), without "the cloud's";
            /// Color of these points, in place of the cloud's.
            "class.color": ValueKind::Color, without "the cloud's";
            /// Radius of these points in place of the cloud's or the estimated one, not multiplied by `scale`; not of
            /// Gaussians.
            "class.radius": ValueKind::Number(Range::NOT_NEGATIVE), unit "world units", without "the cloud's";
            /// False hides these points; they still count for radii and percentiles.
            "class.visible": ValueKind::Flag, without "`true`";
        }
    }

    fn update(&mut self, table: &Table<'_>, key: &str, (): ()) -> Result<(), Error> {
        if table.get(key).is_some() {
            *self = table.tables(key)?.iter().map(read).collect::<Result<_, _>>()?;
        }
        Ok(())
    }
}
