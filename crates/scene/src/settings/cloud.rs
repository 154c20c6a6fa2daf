//! `[[cloud]]`.

use std::path::PathBuf;

use glam::{DVec3, Vec3};

use crate::error::Error;
use crate::photo;
use crate::schema::{Key, Range, SettingsField, Slider, ValueKind, Vectors, keys, settings, value, words};
use crate::setting::Setting;
use crate::settings::{ClassSettings, ColorSettings, Strays};
use crate::table::Table;
use pellucid_core::cloud::field::Field;
use pellucid_core::cloud::gaussians::MAX_DEGREE;
use pellucid_io::photo::Photo;
use pellucid_io::{ColumnNames, Hints, LasColumns};

settings! {
    /// `[[cloud]]`.
    pub struct CloudSettings {
        /// File of the points, relative to the folder of the scene file, or the name of a built-in cloud.
        path: PathBuf = PathBuf::new();
        /// Primitives that a file of Gaussian splats is drawn with.
        primitive: Primitive = Primitive::Gaussians;
        /// Highest degree of the spherical harmonics of Gaussians.
        sh_degree: Option<u32> = None, in 0..=MAX_DEGREE, without "the file's", start 0.0;
        /// One color for all points, in place of the file's colors.
        color: Option<Vec3> = None, without "by `color_by`";
        /// Source of the colors if `color` is not given.
        coloring: ColorSettings = ColorSettings::default();
        /// Opacity, color, radius and visibility of single classes, or of a range of a scalar.
        class: Vec<ClassSettings> = Vec::new();
        /// Opacity of each splat, or for spbr of the surface; multiplied by the file's alpha.
        opacity: f32 = 1.0, in Range::UNIT, slider Slider::Opacity, rival "surface_opacity";
        /// Opacity of the surface that the points lie on, in place of `opacity`: the more discs overlap, the fainter
        /// each one is.
        surface_opacity: Option<f32> = None, in Range::UNIT, without "by `opacity`", start 0.3, slider Slider::Opacity, rival "opacity";
        /// Radius of all points, not multiplied by `scale`.
        radius: Option<f32> = None, in Range::NOT_NEGATIVE, unit "world units",
            without "the file's, else estimated from neighbors", start 0.003, slider Slider::Lengths(1e-5, 0.1);
        /// Factor on all radii, and on the extents of Gaussians.
        radius_factor: f32 = 1.0, in Range::NOT_NEGATIVE, slider Slider::Linear(0.0, 4.0);
        /// Number K of neighbors from which radii and uncertainty are estimated.
        neighbors: Option<usize> = None, in 1..=65_535, without "those of a prepared file, else 24", start 24.0,
            slider Slider::Count(1, 256);
        /// Points that stand apart.
        strays: Strays = Strays::default();
        /// Vector added to positions, after `scale`.
        translate: DVec3 = DVec3::ZERO, in Vectors::Any, unit "world units";
        /// Factor on positions and on the radii of the file.
        scale: f64 = 1.0, in Range::POSITIVE;
        /// Position of a picture in the world, before `scale` and `translate`.
        photo: Option<Photo> = None;
        /// Columns of a text file, as in `"x,y,z,-,r,g,b"`.
        columns: Option<ColumnNames> = None, without "by its header or its values";
        /// Field F that separates soft points from solid ones.
        field: Option<Field> = None;
    }
}

words! {
    /// Kind of points in a file with Gaussian splats.
    pub enum Primitive {
        /// Gaussians; files without Gaussians as points.
        Gaussians = "gaussians",
        /// Points at the centers of the Gaussians.
        Points = "points",
    }
}

impl CloudSettings {
    /// Returns the position of a point of the file in the scene.
    pub(crate) fn placed(&self, position: DVec3) -> DVec3 {
        self.scale * position + self.translate
    }

    /// Returns the hints that the settings give about the file.
    pub fn hints(&self) -> Hints<'_> {
        let las = if self.color.is_some() { LasColumns::default() } else { self.coloring.color_by.las_columns() };
        let las = self.class.iter().fold(las, |las, entry| las.and(entry.las_columns()));
        Hints { photo: self.photo.as_ref(), columns: self.columns.as_ref(), las }
    }
}

value! {
    ColumnNames => ValueKind::Text;
    |table, key| {
        let (Some(text), Some(node)) = (table.string(key)?, table.get(key)) else { return Ok(None) };
        let named = ColumnNames::parse(text).map(Some);
        named.map_err(|problem| table.error(key, node, format!("names columns: {problem}")))
    };
    |_| None;
}

/// The keys of a cloud that only methods with solid and soft points read.
pub(crate) const FIELD_KEYS: [&str; 3] = ["field", "soft_classes", "axis"];

impl SettingsField for Option<Field> {
    type Allowed = ();

    fn keys(&self, key: Key, (): ()) -> Vec<Key> {
        let value = self.as_ref().map(|field| Setting::Word(field.name().to_owned()));
        let kind = ValueKind::Other(
            "`\"uncertainty\"`, `\"classification\"`, `\"intensity\"`, `\"distance-to-axis\"`, or the name of a scalar of the file",
        );
        let mut keys = vec![Key { kind, value, without: "that of a prepared file, else uncertainty", ..key }];
        keys.extend(keys! {
            /// Classes whose points are soft (classification).
            "soft_classes": ValueKind::Integers(255), without "none; classification needs some";
            /// A point of the axis (distance-to-axis).
            "axis.point": ValueKind::Vector, unit "world units", without "the middle of the cloud";
            /// The direction of the axis (distance-to-axis).
            "axis.direction": ValueKind::Direction, without "the vertical";
        });
        keys
    }

    fn update(&mut self, table: &Table<'_>, key: &str, (): ()) -> Result<(), Error> {
        if let Some(field) = field(table, key)? {
            *self = Some(field);
        }
        Ok(())
    }
}

fn field(table: &Table<'_>, key: &str) -> Result<Option<Field>, Error> {
    let classes = table.integers("soft_classes", 255)?;
    let axis = table.table("axis")?;
    axis.refuse_unknown(&["point", "direction"])?;
    let point = axis.vector("point")?.map(|p| p.to_array());
    let direction = axis.direction("direction")?.map(|d| d.to_array());
    let name = table.string(key)?;
    for (key, kind) in [("soft_classes", "classification"), ("axis", "distance-to-axis")] {
        if let (Some(node), true) = (table.get(key), name != Some(kind)) {
            table.warn(format!("{}: `{key}` has no effect without field = {kind:?}", node.place));
        }
    }
    Ok(Some(match name {
        None => return Ok(None),
        Some("uncertainty") => Field::Uncertainty,
        Some("classification") => {
            let Some(mut classes) = classes else {
                let problem = "field = \"classification\" needs soft_classes, as in soft_classes = [3, 4, 5]";
                return Err(table.conflict(key, problem));
            };
            classes.sort_unstable();
            classes.dedup();
            // The range was checked.
            Field::Classification { classes: classes.into_iter().map(|class| class as u8).collect() }
        }
        Some("intensity") => Field::Intensity,
        Some("distance-to-axis") => Field::DistanceToAxis { point, direction },
        Some(name) => Field::Property { name: name.to_owned() },
    }))
}

impl SettingsField for Option<Photo> {
    type Allowed = ();

    fn keys(&self, _: Key, (): ()) -> Vec<Key> {
        photo::keys()
    }

    fn update(&mut self, table: &Table<'_>, key: &str, (): ()) -> Result<(), Error> {
        if let Some(photo) = photo::read(table, key)? {
            *self = Some(photo);
        }
        Ok(())
    }
}
