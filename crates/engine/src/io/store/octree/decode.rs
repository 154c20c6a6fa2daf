//! From the bytes of octree.bin to the columns of a cloud.

use glam::{DVec3, Vec3};

use super::attributes::{Attribute, Kind, Layout, Role};
use crate::cloud::{Cloud, GPS_TIME, Prepared};
use crate::color::decode_srgb;
use crate::io::columns::unit_or_zero;
use crate::io::store::Grid;

/// Largest value of colors that have 8 bits.
const BYTE: u16 = 255;

/// What turns records into clouds.
#[derive(Debug)]
pub(super) struct Decoder {
    layout: Layout,
    grid: Grid,
    /// Linear values of stored channels; empty without colors.
    table: Vec<f32>,
    /// The time that counts as 0.
    first_time: f64,
    prepared: Option<Prepared>,
}

impl Decoder {
    /// `full`: the channel of full intensity, if colors are [`Role::Rgb`].
    pub fn new(layout: Layout, grid: Grid, full: Option<u16>, first_time: f64, prepared: Option<Prepared>) -> Self {
        let linear = |full: u16| move |stored: u16| decode_srgb(f32::from(stored) / f32::from(full));
        let table = full.map(|full| (0..=full).map(linear(full)).collect()).unwrap_or_default();
        Self { layout, grid, table, first_time, prepared }
    }

    /// Bytes of a point.
    pub fn stride(&self) -> u64 {
        self.layout.stride as u64
    }

    /// The points of some records; the columns are there whatever their number.
    pub fn cloud(&self, records: &[u8]) -> Cloud {
        let columns = Columns { records, stride: self.layout.stride };
        let find = |role: Role| self.layout.find(&role);
        let floats = |role: Role| find(role).map(|attribute| columns.floats(attribute));
        Cloud {
            positions: find(Role::Position).map(|attribute| self.positions(&columns, attribute)).unwrap_or_default(),
            colors: self.colors(&columns),
            alphas: floats(Role::Alpha).map(|alphas| alphas.into_iter().map(unit).collect()),
            normals: self.normals(&columns),
            radii: floats(Role::Radius).map(|radii| radii.into_iter().map(radius).collect()),
            classification: find(Role::Classification).map(|a| columns.each(a).map(|bytes| bytes[0]).collect()),
            intensity: floats(Role::Intensity),
            scalars: self.scalars(&columns),
            prepared: self.prepared(&columns),
            ..Cloud::default()
        }
    }

    /// The places of points in their source; by default those in the file, of which the first is `first`.
    pub fn places(&self, records: &[u8], first: u64) -> Vec<u64> {
        let columns = Columns { records, stride: self.layout.stride };
        match self.layout.find(&Role::Place) {
            // The conversion saturates.
            Some(place) => columns.each(place).map(|bytes| place.kind.read(bytes) as u64).collect(),
            None => (first..).take(records.len() / self.layout.stride.max(1)).collect(),
        }
    }

    fn positions(&self, columns: &Columns, attribute: &Attribute) -> Vec<DVec3> {
        columns.each(attribute).map(|bytes| self.grid.position(integers(bytes))).collect()
    }

    fn colors(&self, columns: &Columns) -> Option<Vec<Vec3>> {
        if let Some(linear) = self.layout.three(Role::Linear) {
            let color =
                |color: Vec3| Vec3::from(color.to_array().map(|x| if x.is_nan() { 0.0 } else { x.clamp(0.0, 1.0) }));
            return Some(columns.vectors(linear).map(color).collect());
        }
        let rgb = self.layout.find(&Role::Rgb)?;
        let last = self.table.len().checked_sub(1)?;
        let size = rgb.kind.bytes()?;
        let channel = |bytes: &[u8], i: usize| {
            let stored = match rgb.kind {
                Kind::Uint8 => usize::from(bytes[i]),
                _ => usize::from(u16::from_le_bytes([bytes[size * i], bytes[size * i + 1]])),
            };
            self.table[stored.min(last)]
        };
        Some(columns.each(rgb).map(|bytes| Vec3::from([0, 1, 2].map(|i| channel(bytes, i)))).collect())
    }

    fn normals(&self, columns: &Columns) -> Option<Vec<Vec3>> {
        if let Some(vector) = self.layout.find(&Role::NormalVector) {
            let coordinate = |bytes: &[u8], axis: usize| Kind::Float.read(&bytes[4 * axis..]) as f32;
            let normal = |bytes: &[u8]| unit_or_zero(Vec3::from([0, 1, 2].map(|axis| coordinate(bytes, axis))));
            return Some(columns.each(vector).map(normal).collect());
        }
        let three = self.layout.three(Role::Normal)?;
        Some(columns.vectors(three).map(unit_or_zero).collect())
    }

    fn scalars(&self, columns: &Columns) -> Vec<(String, Vec<f32>)> {
        let scalar = |attribute: &Attribute| match &attribute.role {
            Role::Scalar(name) => Some((name.clone(), columns.floats(attribute))),
            Role::Time => {
                let since = |bytes: &[u8]| (attribute.kind.read(bytes) - self.first_time) as f32;
                Some((GPS_TIME.to_owned(), columns.each(attribute).map(since).collect()))
            }
            _ => None,
        };
        self.layout.attributes.iter().filter_map(scalar).collect()
    }

    fn prepared(&self, columns: &Columns) -> Option<Prepared> {
        let mut prepared = self.prepared.clone()?;
        prepared.values = self.unit_floats(columns, &Role::Field);
        if let Some(shadows) = &mut prepared.shadows {
            shadows.lit = self.unit_floats(columns, &Role::Lit);
        }
        Some(prepared)
    }

    /// Numbers in [0, 1], whatever is stored; 0 for what is none.
    fn unit_floats(&self, columns: &Columns, role: &Role) -> Vec<f32> {
        let values = self.layout.find(role).map(|attribute| columns.floats(attribute)).unwrap_or_default();
        values.into_iter().map(|value| if value.is_nan() { 0.0 } else { value.clamp(0.0, 1.0) }).collect()
    }
}

/// The three integers of a position.
pub(crate) fn integers(bytes: &[u8]) -> [i32; 3] {
    std::array::from_fn(|axis| i32::from_le_bytes(std::array::from_fn(|i| bytes[4 * axis + i])))
}

/// An alpha as readers of other formats give it.
fn unit(value: f32) -> f32 {
    if value.is_nan() { 1.0 } else { value.clamp(0.0, 1.0) }
}

/// A radius as readers of other formats give it.
fn radius(value: f32) -> f32 {
    if value.is_finite() { value.max(0.0) } else { 0.0 }
}

/// Records as columns.
struct Columns<'a> {
    records: &'a [u8],
    stride: usize,
}

impl<'a> Columns<'a> {
    /// The bytes of an attribute, point by point.
    fn each(&self, attribute: &Attribute) -> impl Iterator<Item = &'a [u8]> + use<'a> {
        let bytes = attribute.at..attribute.at + attribute.bytes;
        self.records.chunks_exact(self.stride).map(move |record| &record[bytes.clone()])
    }

    fn floats(&self, attribute: &Attribute) -> Vec<f32> {
        let (kind, [factor, summand]) = (attribute.kind, attribute.transform);
        if kind == Kind::Float && attribute.transform == super::attributes::AS_STORED {
            // The bits of what isn't a number, too.
            return self.each(attribute).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect();
        }
        self.each(attribute).map(|bytes| (kind.read(bytes) * factor + summand) as f32).collect()
    }

    fn vectors(&self, attributes: [&Attribute; 3]) -> impl Iterator<Item = Vec3> {
        let [x, y, z] = attributes.map(|attribute| self.each(attribute));
        let float = |bytes: &[u8]| f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]);
        x.zip(y).zip(z).map(move |((x, y), z)| Vec3::new(float(x), float(y), float(z)))
    }
}

/// The channel of full intensity in colors of others: 255 if no channel is above, as in LAS files; `None` if all are 0.
pub(super) fn full_scale(kind: Kind, largest: Option<f64>) -> Option<u16> {
    match largest {
        Some(largest) if largest <= 0.0 => None,
        Some(largest) if largest <= f64::from(BYTE) => Some(BYTE),
        _ if kind == Kind::Uint8 => Some(BYTE),
        _ => Some(u16::MAX),
    }
}
