//! Converts the bytes of octree.bin to the columns of a cloud.

use glam::{DQuat, DVec3, Quat, Vec3};

use super::attributes::{Attribute, AttributeLayout, NumberType, Role};
use crate::channel::{full_integer, unit_or};
use crate::columns::unit_or_zero;
use crate::number::{at, word};
use crate::store::Grid;
use pellucid_core::cloud::gaussians::{ColorCoding, Gaussians, coefficients};
use pellucid_core::cloud::{Cloud, GPS_TIME, Prepared};
use pellucid_core::color::linear_values;

/// Largest difference of the square of a quaternion's length from 1. Those of our own stores are as close as float32
/// allows.
const UNIT: f64 = 1e-5;

/// Decoder that turns records into clouds.
#[derive(Debug)]
pub(super) struct Decoder {
    layout: AttributeLayout,
    grid: Grid,
    /// Linear values of stored channels; empty without colors.
    table: &'static [f32],
    /// The time that counts as 0.
    first_time: f64,
    prepared: Option<Prepared>,
}

impl Decoder {
    /// `full`: the channel of full intensity, if colors are [`Role::Rgb`].
    pub fn new(
        layout: AttributeLayout,
        grid: Grid,
        full: Option<u16>,
        first_time: f64,
        prepared: Option<Prepared>,
    ) -> Self {
        Self { layout, grid, table: full.map_or(&[], linear_values), first_time, prepared }
    }

    /// Returns the number of bytes of a point.
    pub fn stride(&self) -> u64 {
        self.layout.stride as u64
    }

    /// Returns the points of some records; the columns are there whatever their number. Splats that are none have
    /// extents of zero ([`splats_of`]).
    pub fn cloud(&self, records: &[u8]) -> Cloud {
        let columns = Columns { records, stride: self.layout.stride };
        let find = |role: Role| self.layout.find(&role);
        let floats = |role: Role| find(role).map(|attribute| columns.floats(attribute));
        let positions = self.positions(&columns);
        let alphas = floats(Role::Alpha);
        let gaussians = self.gaussians(&columns, &positions, alphas.as_deref());
        Cloud {
            colors: self.colors(&columns, gaussians.as_ref()),
            alphas: alphas.map(|alphas| alphas.into_iter().map(|alpha| unit_or(1.0, alpha)).collect()),
            positions,
            gaussians,
            normals: self.normals(&columns),
            radii: floats(Role::Radius).map(|radii| radii.into_iter().map(radius).collect()),
            classification: find(Role::Classification).map(|a| columns.each(a).map(|bytes| bytes[0]).collect()),
            intensity: floats(Role::Intensity),
            scalars: self.scalars(&columns),
            prepared: self.prepared(&columns),
            ..Cloud::default()
        }
    }

    /// Returns the places of points in their source; by default those in the file, of which the first is `first`.
    pub fn places(&self, records: &[u8], first: u64) -> Vec<u64> {
        let columns = Columns { records, stride: self.layout.stride };
        match self.layout.find(&Role::Place) {
            // The conversion saturates.
            Some(place) => columns.each(place).map(|bytes| place.kind.read(bytes) as u64).collect(),
            None => (first..).take(records.len() / self.layout.stride.max(1)).collect(),
        }
    }

    fn positions(&self, columns: &Columns) -> Vec<DVec3> {
        if let Some(exact) = self.layout.find(&Role::Exact) {
            let size = exact.bytes / 3;
            let position = |bytes: &[u8]| DVec3::from([0, 1, 2].map(|axis| exact.kind.read(&bytes[size * axis..])));
            return columns.each(exact).map(position).collect();
        }
        let Some(attribute) = self.layout.find(&Role::Position) else { return Vec::new() };
        columns.each(attribute).map(|bytes| self.grid.position(integers(bytes))).collect()
    }

    /// Gaussians, of which those are none that have a number that no splat has.
    fn gaussians(&self, columns: &Columns, positions: &[DVec3], alphas: Option<&[f32]>) -> Option<Gaussians> {
        let splats = self.layout.splats().ok().flatten()?;
        let degree = splats.degree();
        let mut all = Gaussians::none(positions.len()).with_degree(degree);
        if let Some(linearity) = splats.linearity {
            all.coding = ColorCoding::of(columns.each(linearity).map(|bytes| bytes[0] != 0).collect());
        }
        let count = coefficients(degree);
        let mut shapes = columns.each(splats.extents).zip(columns.each(splats.rotation));
        let mut bases = columns.each(splats.base);
        let mut harmonics = splats.harmonics.map(|(attribute, _)| columns.each(attribute));
        for (i, position) in positions.iter().enumerate() {
            let (Some((extents, turn)), Some(base)) = (shapes.next(), bases.next()) else { break };
            let [extents, base] = [extents, base].map(|bytes| Vec3::from(singles(bytes)));
            let own = &mut all.harmonics[i * count..(i + 1) * count];
            let stored = harmonics.as_mut().and_then(Iterator::next).unwrap_or_default();
            own.iter_mut().zip(stored.chunks_exact(12)).for_each(|(color, bytes)| *color = singles(bytes).into());
            let is_one = position.is_finite()
                && extents.is_finite()
                && base.is_finite()
                && own.iter().all(|color| color.is_finite())
                && alphas.is_none_or(|alphas| !alphas[i].is_nan());
            match rotation(Quat::from_array(singles(turn))).filter(|_| is_one) {
                Some(rotation) => {
                    (all.extents[i], all.rotations[i], all.bases[i]) = (extents.abs(), rotation, base);
                }
                None => own.fill(Vec3::ZERO),
            }
        }
        Some(all)
    }

    fn colors(&self, columns: &Columns, splats: Option<&Gaussians>) -> Option<Vec<Vec3>> {
        if let Some(linear) = self.layout.three(Role::Linear) {
            let color = |color: Vec3| Vec3::from(color.to_array().map(|x| unit_or(0.0, x)));
            return Some(columns.vectors(linear).map(color).collect());
        }
        let rgb = self.layout.find(&Role::Rgb)?;
        if let Some(splats) = splats {
            // In addition to them `rgb` is for other programs.
            return Some((0..splats.len()).map(|at| splats.linear_base(at)).collect());
        }
        let last = self.table.len().checked_sub(1)?;
        let size = rgb.kind.bytes()?;
        let channel = |bytes: &[u8], i: usize| self.table[(rgb.kind.read(&bytes[size * i..]) as usize).min(last)];
        Some(columns.each(rgb).map(|bytes| Vec3::from([0, 1, 2].map(|i| channel(bytes, i)))).collect())
    }

    fn normals(&self, columns: &Columns) -> Option<Vec<Vec3>> {
        if let Some(vector) = self.layout.find(&Role::NormalVector) {
            let normal = |bytes: &[u8]| unit_or_zero(singles(bytes).into());
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
        values.into_iter().map(|value| unit_or(0.0, value)).collect()
    }
}

/// Returns those of a cloud's points that are splats, if some are none; `None` of other clouds.
pub(super) fn splats_of(cloud: &Cloud) -> Option<Vec<u32>> {
    let splats = cloud.gaussians.as_ref().filter(|splats| !splats.are_all())?;
    Some((0..splats.len() as u32).filter(|at| splats.is_one(*at as usize)).collect())
}

/// The scalar of a LAS point's flags, as PotreeConverter calls it, and the one of them that says that it is withheld.
const FLAGS: (&str, u8) = ("classification flags", 1 << 2);

/// Returns those of the points of another program's octree that are not withheld, if some are.
pub(super) fn not_withheld(cloud: &Cloud) -> Option<Vec<u32>> {
    let (name, bits) = FLAGS;
    let (_, flags) = cloud.scalars.iter().find(|(known, _)| known.eq_ignore_ascii_case(name))?;
    let is_withheld = |flags: &f32| *flags as u8 & bits != 0;
    let kept = || (0u32..).zip(flags).filter(|(_, flags)| !is_withheld(flags)).map(|(at, _)| at).collect();
    flags.iter().any(is_withheld).then(kept)
}

/// The first float32 numbers of some bytes, of which there are enough.
fn singles<const N: usize>(bytes: &[u8]) -> [f32; N] {
    std::array::from_fn(|i| f32::from_le_bytes(at(bytes, 4 * i)))
}

/// A unit quaternion as it is stored, or the one of another length; `None` of zero and of what is not finite.
fn rotation(stored: Quat) -> Option<Quat> {
    let exact = stored.as_dquat();
    if (exact.length_squared() - 1.0).abs() < UNIT {
        return Some(stored);
    }
    let unit = DQuat::from_array(exact.to_array().map(|x| x / exact.length()));
    (exact.is_finite() && unit.is_finite()).then(|| unit.as_quat())
}

/// Returns the three integers of a position.
pub(crate) fn integers(bytes: &[u8]) -> [i32; 3] {
    std::array::from_fn(|axis| word(bytes, 4 * axis).cast_signed())
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
        if kind == NumberType::Float && attribute.transform == super::attributes::AS_STORED {
            // The bits of what isn't a number, too.
            return self.each(attribute).map(|bytes| f32::from_le_bytes(at(bytes, 0))).collect();
        }
        self.each(attribute).map(|bytes| (kind.read(bytes) * factor + summand) as f32).collect()
    }

    fn vectors(&self, attributes: [&Attribute; 3]) -> impl Iterator<Item = Vec3> {
        let [x, y, z] = attributes.map(|attribute| self.each(attribute));
        let float = |bytes: &[u8]| f32::from_le_bytes(at(bytes, 0));
        x.zip(y).zip(z).map(move |((x, y), z)| Vec3::new(float(x), float(y), float(z)))
    }
}

/// Returns the channel of full intensity in colors of others: that of the fewest bits that hold the largest, as in LAS
/// files; `None` if all are 0.
pub(super) fn full_scale(kind: NumberType, largest: Option<f64>) -> Option<u16> {
    match largest {
        Some(largest) if largest <= 0.0 => None,
        _ if kind == NumberType::Uint8 => Some(u8::MAX.into()),
        Some(largest) => Some(full_integer(largest as f32)),
        None => Some(u16::MAX),
    }
}
