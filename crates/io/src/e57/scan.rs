//! A single scan of an E57 file: maps its values to the rows of the cloud.

use std::collections::HashSet;
use std::ops::Range;

use ::e57::{PointCloud, RecordDataType, RecordName, RecordValue};
use glam::{DQuat, DVec3};

use super::limits::{Limits, ScanLimits};
use pellucid_core::cloud::sensor::Sensor;

use crate::columns::{Column, ScalarType, is_known};

/// The columns that all scans share; the first ones are always there.
pub(super) struct ScanColumns {
    pub columns: Vec<Column>,
    normals: Option<usize>,
    colors: Option<usize>,
    intensity: Option<usize>,
    /// Names of the other fields that every scan has, in the order of their columns, which are the last ones.
    scalars: Vec<String>,
    /// Names of those that only some scans have.
    pub left_out: Vec<String>,
}

impl ScanColumns {
    /// Returns the columns of some scans.
    pub fn for_scans(scans: &[PointCloud]) -> Self {
        let mut columns = Vec::from(["x", "y", "z"].map(|name| Column::new(name, ScalarType::Double)));
        let mut add = |some: bool, new: &[&'static str]| {
            let at = columns.len();
            columns.extend(new.iter().filter(|_| some).map(|name| Column::new(*name, ScalarType::Double)));
            some.then_some(at)
        };
        let normals = add(scans.iter().any(|scan| normal(scan).is_some()), &["nx", "ny", "nz"]);
        let colors = add(scans.iter().any(PointCloud::has_color), &["red", "green", "blue"]);
        let intensity = add(scans.iter().any(PointCloud::has_intensity), &["intensity"]);
        let (scalars, left_out) = scalars(scans);
        columns.extend(scalars.iter().map(|name| Column::new(name, ScalarType::Double)));
        Self { columns, normals, colors, intensity, scalars, left_out }
    }
}

/// Names of the scalars that all scans have, and of those that some have. A column that other scans would have to fill
/// could be as long as all of them.
fn scalars(scans: &[PointCloud]) -> (Vec<String>, Vec<String>) {
    let scalar_names =
        |scan: &PointCloud| scan.prototype.iter().filter_map(|record| scalar_name(&record.name)).collect();
    let each: Vec<HashSet<String>> = scans.iter().map(scalar_names).collect();
    let mut seen = HashSet::new();
    let all = scans.iter().flat_map(|scan| &scan.prototype).filter_map(|record| scalar_name(&record.name));
    all.filter(|name| seen.insert(name.clone())).partition(|name| each.iter().all(|names| names.contains(name)))
}

/// The name of a field that is a column by itself: `None` for those that are part of others, and for those of the grid.
fn scalar_name(name: &RecordName) -> Option<String> {
    Some(match name {
        RecordName::ReturnCount => "returnCount".to_owned(),
        RecordName::ReturnIndex => "returnIndex".to_owned(),
        RecordName::TimeStamp => "timeStamp".to_owned(),
        RecordName::Unknown { name, .. } if normal_axis(name).is_some() => return None,
        // A column of the cloud under this name would be another one.
        RecordName::Unknown { name, .. } if is_known(name) && !is_class(name) => format!("{name}_"),
        RecordName::Unknown { name, .. } => name.clone(),
        _ => return None,
    })
}

/// Returns `true` if an extension's field is a classification, for any extension.
fn is_class(name: &str) -> bool {
    pellucid_core::cloud::CLASSIFICATION_NAMES.contains(&name.to_ascii_lowercase().as_str())
}

/// The axis of a field of the extension for normals.
fn normal_axis(name: &str) -> Option<usize> {
    ["normalX", "normalY", "normalZ"].iter().position(|known| *known == name)
}

/// The positions of a scan's normals.
fn normal(scan: &PointCloud) -> Option<[usize; 3]> {
    let find = |axis: usize| {
        scan.prototype.iter().position(
            |record| matches!(&record.name, RecordName::Unknown { name, .. } if normal_axis(name) == Some(axis)),
        )
    };
    Some([find(0)?, find(1)?, find(2)?])
}

/// Returns the number of bits of a value in the file.
pub(super) fn bits(kind: &RecordDataType) -> u64 {
    match kind {
        RecordDataType::Single { .. } => 32,
        RecordDataType::Double { .. } => 64,
        RecordDataType::Integer { min, max } | RecordDataType::ScaledInteger { min, max, .. } => {
            u64::from(i64::BITS - max.wrapping_sub(*min).leading_zeros())
        }
    }
}

/// A field of a scan: its place among the values and its type.
type Field<'a> = (usize, &'a RecordDataType);

/// Maps the values of a scan to a row.
pub(super) struct Scan<'a> {
    rotation: DQuat,
    translation: DVec3,
    cartesian: Option<[Field<'a>; 3]>,
    cartesian_state: Option<Field<'a>>,
    spherical: Option<[Field<'a>; 3]>,
    spherical_state: Option<Field<'a>>,
    normal: Option<([Field<'a>; 3], usize)>,
    color: Option<([Field<'a>; 3], usize)>,
    color_limits: Option<[Option<Limits>; 3]>,
    color_state: Option<Field<'a>>,
    intensity: Option<(Field<'a>, usize)>,
    intensity_limits: Option<Option<Limits>>,
    intensity_state: Option<Field<'a>>,
    /// Fields and their columns.
    scalars: Vec<(Field<'a>, usize)>,
    /// `true` if the points were seen from the scan's origin: the file has its pose, its grid, or directions.
    is_seen: bool,
    /// A row of a scan that has nothing.
    empty: Vec<f64>,
}

impl<'a> Scan<'a> {
    /// Fails with the missing property of a scan.
    pub fn new(scan: &'a PointCloud, table: &ScanColumns) -> Result<Self, String> {
        let at = |at: usize| (at, &scan.prototype[at].data_type);
        let find = |name: &RecordName| scan.prototype.iter().position(|record| record.name == *name).map(at);
        let three = |names: [RecordName; 3]| {
            let [x, y, z] = names.each_ref().map(&find);
            Some([x?, y?, z?])
        };
        let cartesian = three([RecordName::CartesianX, RecordName::CartesianY, RecordName::CartesianZ]);
        let spherical =
            three([RecordName::SphericalRange, RecordName::SphericalAzimuth, RecordName::SphericalElevation]);
        if cartesian.is_none() && spherical.is_none() {
            return Err("no coordinates: neither cartesianX, Y, Z nor sphericalRange, Azimuth, Elevation".to_owned());
        }
        let (rotation, translation) = pose(scan)?;
        let first = table.columns.len() - table.scalars.len();
        let scalar = |(index, record): (usize, &::e57::Record)| {
            let name = scalar_name(&record.name)?;
            Some((at(index), first + table.scalars.iter().position(|known| *known == name)?))
        };
        let color = three([RecordName::ColorRed, RecordName::ColorGreen, RecordName::ColorBlue]);
        let intensity = find(&RecordName::Intensity);
        Ok(Self {
            rotation,
            translation,
            cartesian,
            cartesian_state: find(&RecordName::CartesianInvalidState),
            spherical,
            spherical_state: find(&RecordName::SphericalInvalidState),
            normal: normal(scan).map(|fields| fields.map(at)).zip(table.normals),
            color: color.zip(table.colors),
            color_limits: color.map(|fields| color_limits(scan, fields)),
            color_state: find(&RecordName::IsColorInvalid),
            intensity: intensity.zip(table.intensity),
            intensity_limits: intensity.map(|field| intensity_limits(scan, field)),
            intensity_state: find(&RecordName::IsIntensityInvalid),
            scalars: scan.prototype.iter().enumerate().filter_map(scalar).collect(),
            is_seen: scan.transform.is_some()
                || spherical.is_some()
                || find(&RecordName::RowIndex).is_some()
                || find(&RecordName::ColumnIndex).is_some(),
            empty: empty(table),
        })
    }

    /// Converts a point's values to a row; its position is NaN if the scan lacks one.
    pub fn row(&self, values: &[RecordValue], row: &mut Vec<f64>) -> ::e57::Result<()> {
        row.clone_from(&self.empty);
        let value = |(at, kind): Field| values.get(at).map_or(Ok(f64::NAN), |value| value.to_f64(kind));
        let three = |[x, y, z]: [Field; 3]| Ok::<_, ::e57::Error>(DVec3::new(value(x)?, value(y)?, value(z)?));
        // State 1 is a direction without distance, 2 is nothing at all.
        let valid = |state: Option<Field>| Ok::<_, ::e57::Error>(state.map_or(Ok(0.0), value)? == 0.0);
        let set = |row: &mut [f64], at: usize, three: [f64; 3]| row[at..at + 3].copy_from_slice(&three);
        let position = if let (Some(fields), true) = (self.cartesian, valid(self.cartesian_state)?) {
            Some(three(fields)?)
        } else if let (Some(fields), true) = (self.spherical, valid(self.spherical_state)?) {
            Some(from_spherical(three(fields)?))
        } else {
            None
        };
        if let Some(position) = position {
            set(row, 0, (self.rotation * position + self.translation).to_array());
        }
        if let Some((fields, column)) = self.normal {
            set(row, column, (self.rotation * three(fields)?).to_array());
        }
        if let (Some((fields, column)), true) = (self.color, valid(self.color_state)?) {
            set(row, column, three(fields)?.to_array());
        }
        if let (Some((field, column)), true) = (self.intensity, valid(self.intensity_state)?) {
            row[column] = value(field)?;
        }
        for &(field, column) in &self.scalars {
            row[column] = value(field)?;
        }
        Ok(())
    }
}

impl Scan<'_> {
    /// Returns the scanner; `None` if the points may come from anywhere.
    pub fn sensor(&self) -> Option<Sensor> {
        let sensor = Sensor::laser(self.translation, self.rotation);
        (self.is_seen && self.translation.is_finite()).then_some(sensor)
    }

    /// Returns the limits that the scan claims for its points.
    pub fn limits(&self, points: Range<usize>) -> ScanLimits {
        ScanLimits { points, color: self.color_limits, intensity: self.intensity_limits }
    }
}

/// Range, azimuth and elevation in radians as x, y, z (ASTM E2807, 8.4.4.1).
fn from_spherical(DVec3 { x: range, y: azimuth, z: elevation }: DVec3) -> DVec3 {
    let across = range * elevation.cos();
    DVec3::new(across * azimuth.cos(), across * azimuth.sin(), range * elevation.sin())
}

/// The pose of a scan in the file's coordinates; a rotation need not be normalized.
fn pose(scan: &PointCloud) -> Result<(DQuat, DVec3), String> {
    let Some(pose) = &scan.transform else { return Ok((DQuat::IDENTITY, DVec3::ZERO)) };
    let (r, t) = (&pose.rotation, &pose.translation);
    let rotation = DQuat::from_xyzw(r.x, r.y, r.z, r.w);
    let length = rotation.length();
    if !length.is_normal() {
        return Err(format!("its pose is not a rotation: ({}, {}, {}, {})", r.w, r.x, r.y, r.z));
    }
    Ok((rotation / length, DVec3::new(t.x, t.y, t.z)))
}

fn color_limits(scan: &PointCloud, fields: [Field; 3]) -> [Option<Limits>; 3] {
    let given = scan.color_limits.as_ref().map(|limits| {
        let red = limits.red_min.as_ref().zip(limits.red_max.as_ref());
        let green = limits.green_min.as_ref().zip(limits.green_max.as_ref());
        [red, green, limits.blue_min.as_ref().zip(limits.blue_max.as_ref())]
    });
    let given = given.unwrap_or_default();
    [0, 1, 2].map(|i| Limits::new(given[i], fields[i].1))
}

fn intensity_limits(scan: &PointCloud, (_, kind): Field) -> Option<Limits> {
    let given = scan.intensity_limits.as_ref();
    Limits::new(given.and_then(|limits| limits.intensity_min.as_ref().zip(limits.intensity_max.as_ref())), kind)
}

/// No position, color and intensity, no normal.
fn empty(table: &ScanColumns) -> Vec<f64> {
    let value = |column: &Column| match column.name.as_str() {
        "x" | "y" | "z" | "red" | "green" | "blue" | "intensity" => f64::NAN,
        _ => 0.0,
    };
    table.columns.iter().map(value).collect()
}
