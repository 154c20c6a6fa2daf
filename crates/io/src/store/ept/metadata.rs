//! The description of an EPT folder, `ept.json`.

use std::path::Path;
use std::sync::Arc;

use glam::DVec3;
use serde::Deserialize;
use serde::de::DeserializeOwned;

use super::rows::{EptRows, MOST_FOR_ONE};
use crate::crs;
use crate::las::{MAX_POINTS_PER_BYTE, Traits};
use crate::number::Class;
use crate::{Error, InputFile, LasColumns};
use pellucid_core::cloud::crs::Crs;
use pellucid_core::cloud::{Bounds, GPS_TIME, NUMBER_OF_RETURNS, POINT_SOURCE, RETURN_NUMBER};

/// Parts of the file that are read.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Json {
    bounds: [f64; 6],
    bounds_conforming: Option<[f64; 6]>,
    data_type: String,
    hierarchy_type: String,
    points: u64,
    schema: Vec<Dimension>,
    span: u32,
    /// [`Srs`]; read by itself, since it decides nothing about the points.
    #[serde(default)]
    srs: serde_json::Value,
}

/// The coordinate reference system: as text, or by codes of an authority.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct Srs {
    authority: serde_json::Value,
    horizontal: serde_json::Value,
    vertical: serde_json::Value,
    wkt: serde_json::Value,
}

impl Srs {
    fn crs(&self) -> Option<Crs> {
        let is_epsg = self.authority.as_str().is_some_and(|name| name.eq_ignore_ascii_case("EPSG"));
        let code = |value: &serde_json::Value| match value {
            serde_json::Value::String(text) => text.parse().ok(),
            value => value.as_u64().and_then(|code| u32::try_from(code).ok()),
        };
        let of_codes = || {
            let horizontal = code(&self.horizontal).filter(|_| is_epsg)?;
            Some(crs::of_codes(horizontal, code(&self.vertical)))
        };
        let Some(found) = self.wkt.as_str().and_then(crs::parse) else { return of_codes() };
        // The text may be that of the horizontal part alone.
        let known: Crs = of_codes().unwrap_or_default();
        Some(Crs {
            epsg: found.epsg.or(known.epsg),
            vertical_unit: found.vertical_unit.clone().or(known.vertical_unit),
            ..found
        })
    }
}

/// A number of each point.
#[derive(Debug, Clone, Deserialize)]
pub(super) struct Dimension {
    pub name: String,
    #[serde(rename = "type")]
    pub class: Class,
    /// Bytes.
    pub size: usize,
    pub scale: Option<f64>,
    pub offset: Option<f64>,
    minimum: Option<f64>,
    maximum: Option<f64>,
}

/// The checked description.
#[derive(Debug)]
pub(super) struct Metadata {
    pub points: u64,
    /// The cube of the root.
    pub cube: Bounds,
    /// The box of the points.
    pub conforming: Bounds,
    /// The distance of the root's points, in the points' units.
    pub spacing: f64,
    pub tiles: Tiles,
    /// The coordinate reference system.
    pub crs: Option<Arc<Crs>>,
    schema: Vec<Dimension>,
    /// A step of the coordinates' grid along each axis.
    step: DVec3,
}

/// The files of the points.
#[derive(Debug)]
pub(super) enum Tiles {
    /// LAZ files.
    Laszip,
    /// Rows of the schema's numbers.
    Rows(EptRows),
    /// Rows of binary values, compressed with Zstandard.
    Zstandard(EptRows),
}

impl Tiles {
    pub fn extension(&self) -> &'static str {
        match self {
            Self::Laszip => "laz",
            Self::Rows(_) => "bin",
            Self::Zstandard(_) => "zst",
        }
    }

    /// Returns the number of points of a tile of so many bytes, at most.
    pub fn most_points(&self, bytes: u64) -> u64 {
        match self {
            Self::Laszip => bytes.saturating_mul(MAX_POINTS_PER_BYTE),
            Self::Rows(rows) => bytes / rows.len() as u64,
            Self::Zstandard(rows) => bytes.saturating_mul(MOST_FOR_ONE) / rows.len() as u64,
        }
    }
}

/// Reads a JSON file.
pub(super) fn read_json<T: DeserializeOwned>(path: &Path) -> Result<T, Error> {
    let mut source = InputFile::open(path)?;
    let bytes = source.all()?;
    serde_json::from_slice(&bytes).map_err(|e| match e.is_eof() {
        true => source.truncated(format!("the JSON ends too early, in line {}", e.line())),
        false => source.malformed(format!("line {}, column {}", e.line(), e.column()), e.to_string()),
    })
}

impl Metadata {
    pub fn read(path: &Path) -> Result<Self, Error> {
        let json: Json = read_json(path)?;
        let malformed = |place: &str, cause: String| Error::malformed(path, format!("`{place}`"), cause);
        let cube =
            corners(json.bounds).ok_or_else(|| malformed("bounds", format!("{:?} is not a box", json.bounds)))?;
        let conforming = json.bounds_conforming.unwrap_or(json.bounds);
        let conforming =
            corners(conforming).ok_or_else(|| malformed("boundsConforming", format!("{conforming:?} is not a box")))?;
        if json.hierarchy_type != "json" {
            return Err(malformed("hierarchyType", format!("`{}` (known: json)", json.hierarchy_type)));
        }
        let sides = cube.max - cube.min;
        let spacing = sides.max_element() / f64::from(json.span);
        if !(spacing.is_finite() && spacing > 0.0) {
            return Err(malformed(
                "span",
                format!("{} does not divide a box with sides of {sides} into cells", json.span),
            ));
        }
        let tiles = match &*json.data_type {
            "laszip" => Tiles::Laszip,
            "binary" => Tiles::Rows(EptRows::new(&json.schema).map_err(|cause| malformed("schema", cause))?),
            "zstandard" => Tiles::Zstandard(EptRows::new(&json.schema).map_err(|cause| malformed("schema", cause))?),
            other => {
                return Err(malformed("dataType", format!("`{other}` (known: laszip, binary, zstandard)")));
            }
        };
        let scale = |name: &str| json.schema.iter().find(|d| d.name == name).and_then(|d| d.scale).unwrap_or(0.0);
        let step = DVec3::from(["X", "Y", "Z"].map(scale)).abs();
        let crs = serde_json::from_value(json.srs).ok().and_then(|srs: Srs| srs.crs()).map(Arc::new);
        let metadata = Self { points: json.points, cube, conforming, spacing, tiles, crs, schema: json.schema, step };
        let is_finite = |bounds: Bounds| (bounds.max - bounds.min).is_finite();
        if !(is_finite(metadata.widened(cube)) && is_finite(metadata.widened(conforming))) {
            return Err(malformed("schema", format!("coordinates can't have steps of {step}")));
        }
        Ok(metadata)
    }

    /// Returns a box with a step of the coordinates' grid around it, since points were put on the grid after they found
    /// their node.
    pub fn widened(&self, bounds: Bounds) -> Bounds {
        Bounds { min: bounds.min - self.step, max: bounds.max + self.step }
    }

    fn dimension(&self, name: &str) -> Option<&Dimension> {
        self.schema.iter().find(|dimension| dimension.name == name)
    }

    /// Returns the columns among those that are asked for that the points have.
    pub fn has(&self, asked: LasColumns) -> LasColumns {
        let has = |name| self.dimension(name).is_some();
        LasColumns {
            returns: asked.returns && has("ReturnNumber") && has("NumberOfReturns"),
            source: asked.source && has("PointSourceId"),
            gps_time: asked.gps_time && has("GpsTime"),
        }
    }

    /// Returns the facts that decide about whole columns, if the description has all of them.
    pub fn traits(&self, asked: LasColumns) -> Option<Traits> {
        // No dimension, no value; but a dimension without its limits says nothing.
        let largest = |name| self.dimension(name).map_or(Some(0.0), |dimension| dimension.maximum);
        let colors = [largest("Red")?, largest("Green")?, largest("Blue")?];
        let first_time = if asked.gps_time { self.dimension("GpsTime")?.minimum? } else { f64::INFINITY };
        Some(Traits {
            largest_color: colors.into_iter().fold(0.0, f64::max) as u16,
            most_returns: largest("NumberOfReturns")? as u8,
            first_time,
        })
    }

    /// Returns `true` if points with other values than these change no column.
    pub fn settles(&self, asked: LasColumns, traits: &Traits) -> bool {
        traits.settle(self.dimension("Red").is_some(), asked.gps_time, asked.returns)
    }

    /// Returns the least and largest values of scalars.
    pub fn ranges(&self, asked: LasColumns) -> Vec<(String, [f64; 2])> {
        let range = |dimension: &Dimension| {
            let limits = [dimension.minimum?, dimension.maximum?];
            if !(limits[0] <= limits[1] && (limits[1] - limits[0]).is_finite()) {
                return None;
            }
            let (name, shift) = match &*dimension.name {
                "ReturnNumber" => (RETURN_NUMBER, 0.0),
                "NumberOfReturns" => (NUMBER_OF_RETURNS, 0.0),
                "PointSourceId" if asked.source => (POINT_SOURCE, 0.0),
                "GpsTime" if asked.gps_time => (GPS_TIME, limits[0]),
                other => (other, 0.0),
            };
            Some((name.to_owned(), limits.map(|limit| limit - shift)))
        };
        self.schema.iter().filter_map(range).collect()
    }
}

fn corners([x0, y0, z0, x1, y1, z1]: [f64; 6]) -> Option<Bounds> {
    let (min, max) = (DVec3::new(x0, y0, z0), DVec3::new(x1, y1, z1));
    (min.is_finite() && max.is_finite() && min.cmple(max).all()).then_some(Bounds { min, max })
}
