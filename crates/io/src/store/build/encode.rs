//! Converts the columns of a cloud to records.

use glam::{DVec3, Quat, Vec3};

use super::super::octree::attributes::{Attribute, AttributeLayout, NumberType, Role};
use super::cube::Cube;
use super::types::nearest_srgb;
use pellucid_core::cloud::Cloud;
use pellucid_core::cloud::gaussians::Gaussians;

/// Records, and what was rounded for them.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Encoded {
    /// The points' records, one behind the other.
    pub records: Vec<u8>,
    /// The largest distance of a position from its place on the grid; 0 if the layout has exact positions.
    pub rounding: f64,
}

/// Returns the records of a cloud with the columns of a layout, and for each point its place in the source.
///
/// # Errors
/// A position that isn't in the cube.
pub fn encode(layout: &AttributeLayout, cube: &Cube, cloud: &Cloud, places: &[u64]) -> Result<Encoded, DVec3> {
    let mut records = vec![0; layout.stride * cloud.len()];
    let mut rounding = 0.0_f64;
    let splats = || cloud.gaussians.iter();
    for attribute in &layout.attributes {
        let mut writer = Writer { records: &mut records, stride: layout.stride, attribute };
        match &attribute.role {
            Role::Position => rounding = positions(&mut writer, cube, &cloud.positions)?,
            Role::Rgb => {
                let colors = cloud.colors.iter().flatten();
                let rgb = |color: &Vec3| color.to_array().map(nearest_srgb).map(u16::to_le_bytes);
                writer.each(colors.map(rgb), |bytes, rgb| bytes.copy_from_slice(rgb.as_flattened()));
            }
            Role::Linear(axis) => {
                writer.floats(cloud.colors.iter().flatten().map(|color| color[usize::from(*axis)]));
            }
            Role::Normal(axis) => {
                writer.floats(cloud.normals.iter().flatten().map(|normal| normal[usize::from(*axis)]));
            }
            Role::Classification => {
                writer.each(cloud.classification.iter().flatten(), |bytes, code| bytes[0] = *code);
            }
            Role::Exact => writer.exact(&cloud.positions),
            Role::Extents => writer.singles(splats().flat_map(|splats| &splats.extents).map(Vec3::to_array)),
            Role::Rotation => writer.singles(splats().flat_map(|splats| &splats.rotations).map(Quat::to_array)),
            Role::Base => writer.singles(splats().flat_map(|splats| &splats.bases).map(Vec3::to_array)),
            Role::Linearity => splats().for_each(|splats| {
                writer.each(0..splats.len(), |bytes, splat| bytes[0] = splats.is_linear(splat).into());
            }),
            Role::Harmonics(_) => splats().for_each(|splats| writer.harmonics(splats)),
            Role::Place => writer.places(places),
            Role::Alpha => writer.floats(cloud.alphas.iter().flatten().copied()),
            Role::Radius => writer.floats(cloud.radii.iter().flatten().copied()),
            Role::Intensity => writer.floats(cloud.intensity.iter().flatten().copied()),
            Role::Field => writer.floats(cloud.prepared.iter().flat_map(|prepared| &prepared.values).copied()),
            Role::Lit => {
                let shadows = cloud.prepared.iter().flat_map(|prepared| &prepared.shadows);
                writer.floats(shadows.flat_map(|shadows| &shadows.lit).copied());
            }
            Role::Scalar(name) => {
                let column = cloud.scalars.iter().filter(|(other, _)| other == name).take(1);
                writer.floats(column.flat_map(|(_, values)| values).copied());
            }
            // A layout of this program has none of them.
            Role::NormalVector | Role::Time | Role::Ignored => {}
        }
    }
    if layout.find(&Role::Exact).is_some() {
        // In addition to them those on the grid are for other programs.
        rounding = 0.0;
    }
    Ok(Encoded { records, rounding })
}

/// Puts positions on the grid; the largest distance by which one moved.
fn positions(writer: &mut Writer, cube: &Cube, positions: &[DVec3]) -> Result<f64, DVec3> {
    let (at, stride) = (writer.attribute.at, writer.stride);
    let mut rounding = 0.0_f64;
    for (record, position) in writer.records.chunks_exact_mut(stride).zip(positions) {
        let nearest = cube.grid.nearest(*position).filter(|nearest| cube.steps(*nearest).is_some());
        let nearest = nearest.ok_or(*position)?;
        rounding = rounding.max(cube.grid.position(nearest).distance_squared(*position));
        record[at..at + 12].copy_from_slice(nearest.map(i32::to_le_bytes).as_flattened());
    }
    Ok(rounding.sqrt())
}

/// Writes an attribute of all records.
struct Writer<'a> {
    records: &'a mut [u8],
    stride: usize,
    attribute: &'a Attribute,
}

impl Writer<'_> {
    fn each<T>(&mut self, values: impl Iterator<Item = T>, write: impl Fn(&mut [u8], T)) {
        let (start, end) = (self.attribute.at, self.attribute.at + self.attribute.bytes);
        let records = self.records.chunks_exact_mut(self.stride);
        records.zip(values).for_each(|(record, value)| write(&mut record[start..end], value));
    }

    /// Numbers that the type of the attribute holds.
    fn floats(&mut self, values: impl Iterator<Item = f32>) {
        match self.attribute.kind {
            NumberType::Uint8 => self.each(values, |bytes, value| bytes[0] = value as u8),
            NumberType::Uint16 => {
                self.each(values, |bytes, value| bytes.copy_from_slice(&(value as u16).to_le_bytes()));
            }
            _ => self.each(values, |bytes, value| bytes.copy_from_slice(&value.to_le_bytes())),
        }
    }

    /// Several float32 numbers of each point.
    fn singles<const N: usize>(&mut self, values: impl Iterator<Item = [f32; N]>) {
        self.each(values, |bytes, value| bytes.copy_from_slice(value.map(f32::to_le_bytes).as_flattened()));
    }

    fn harmonics(&mut self, splats: &Gaussians) {
        self.each(0..splats.len(), |bytes, splat| {
            let colors = splats.harmonics_of(splat).iter().flat_map(|color| color.to_array());
            bytes.chunks_exact_mut(4).zip(colors).for_each(|(bytes, x)| bytes.copy_from_slice(&x.to_le_bytes()));
        });
    }

    fn exact(&mut self, positions: &[DVec3]) {
        if self.attribute.kind == NumberType::Double {
            self.each(positions.iter(), |bytes, position| {
                bytes.copy_from_slice(position.to_array().map(f64::to_le_bytes).as_flattened());
            });
        } else {
            self.singles(positions.iter().map(|position| position.as_vec3().to_array()));
        }
    }

    fn places(&mut self, places: &[u64]) {
        let places = places.iter().copied();
        match self.attribute.kind {
            NumberType::Uint32 => {
                self.each(places, |bytes, place| bytes.copy_from_slice(&(place as u32).to_le_bytes()));
            }
            _ => self.each(places, |bytes, place| bytes.copy_from_slice(&(place as f64).to_le_bytes())),
        }
    }
}
