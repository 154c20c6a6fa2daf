//! Writes a cloud as a binary little-endian PLY file.

use std::io::Write;
use std::path::Path;

use glam::Vec3;
use ply_rs_bw::ply::{DefaultElement, ElementDef, Encoding, PropertyDef, PropertyType, ScalarType, Version};
use ply_rs_bw::writer::Writer;

use super::prepared::{self, FIELD, LIT};
use super::write_splats;
use crate::Error;
use crate::channel::full_integer;
use crate::columns::{LINEAR_COLOR, is_known};
use pellucid_core::atomic;
use pellucid_core::cloud::Cloud;
use pellucid_core::cloud::field::without_blanks;
use pellucid_core::color::{decode_srgb, encode_srgb};

/// Writes a cloud: float positions if they keep every one exactly, else double; colors and alphas as 8 bits (colors
/// sRGB-encoded), all other columns unchanged. PLY can't store the vertical and the number of dropped points, so they
/// are lost; white space in the name of a scalar becomes `_`. Gaussian splats are written as such, as other programs
/// read them, their vertical in a comment unless it is −Y.
///
/// # Errors
/// The file can't be written; an earlier file of this name, if any, is unchanged.
pub fn write(path: &Path, cloud: &Cloud) -> Result<(), Error> {
    let written = atomic::write(path, |out| write_to(out, cloud));
    written.map_err(|source| Error::Write { path: path.to_path_buf(), source })
}

/// Writes a cloud like [`write()`], to an open file.
///
/// # Errors
/// Writing to `out` fails.
pub fn write_to(out: &mut impl Write, cloud: &Cloud) -> std::io::Result<()> {
    if let Some(gaussians) = &cloud.gaussians {
        return write_splats::write(out, cloud, gaussians);
    }
    let position = narrowest_position(cloud);
    write_columns(out, cloud, &ColumnTypes { position, color: Coding::Byte, alpha: Coding::Byte })
}

/// Writes a cloud with its prepared data, so that reading it gives the same points to the bit, the vertical included.
/// Positions are double; colors and alphas have 8 or 16 bits where that is exact, else they are floats (colors linear
/// ones). A scalar gets a `_` appended if the reader would take its name for another column. Gaussian splats are
/// written as by [`write()`]; nothing is prepared of them.
///
/// # Errors
/// The file can't be written; an earlier file of this name, if any, is unchanged.
pub fn write_prepared(path: &Path, cloud: &Cloud) -> Result<(), Error> {
    if cloud.gaussians.is_some() {
        return write(path, cloud);
    }
    let channels =
        |colors: &Vec<Vec3>| Coding::narrowest(colors.iter().flat_map(Vec3::to_array), encode_srgb, decode_srgb);
    let types = ColumnTypes {
        position: ScalarType::Double,
        color: cloud.colors.as_ref().map_or(Coding::Byte, channels),
        alpha: cloud
            .alphas
            .as_ref()
            .map_or(Coding::Byte, |alphas| Coding::narrowest(alphas.iter().copied(), same, same)),
    };
    let written = atomic::write(path, |out| write_columns(out, cloud, &types));
    written.map_err(|source| Error::Write { path: path.to_path_buf(), source })
}

fn same(x: f32) -> f32 {
    x
}

/// Types of the columns that allow several.
struct ColumnTypes {
    position: ScalarType,
    color: Coding,
    alpha: Coding,
}

/// The storage of a number in [0, 1].
#[derive(Clone, Copy, PartialEq)]
enum Coding {
    Byte,
    Short,
    Float,
}

impl Coding {
    /// The smallest one from which all values come back exactly. Shorts that fewer bits would hold don't: their range
    /// is found in the values (`channel`).
    fn narrowest(values: impl Iterator<Item = f32>, encode: fn(f32) -> f32, decode: fn(f32) -> f32) -> Self {
        let mut largest = 0.0f32;
        let exact = |value: f32, largest: f32| {
            let stored = (encode(value) * largest).round().clamp(0.0, largest);
            decode(stored / largest).to_bits() == value.to_bits()
        };
        let coding =
            values.inspect(|value| largest = largest.max(encode(*value))).fold(
                Self::Byte,
                |coding, value| match coding {
                    Self::Byte if exact(value, 255.0) => Self::Byte,
                    // 16 bits represent everything that 8 bits represent exactly, since 65535 = 257·255.
                    Self::Byte | Self::Short if exact(value, 65535.0) => Self::Short,
                    _ => Self::Float,
                },
            );
        let is_told = full_integer((largest * 65535.0).round()) == u16::MAX;
        if coding == Self::Short && !is_told { Self::Float } else { coding }
    }

    fn scalar(self) -> ScalarType {
        match self {
            Self::Byte => ScalarType::UChar,
            Self::Short => ScalarType::UShort,
            Self::Float => ScalarType::Float,
        }
    }

    /// Appends a value: encoded if stored as an integer, unchanged as a float.
    fn push(self, record: &mut Vec<u8>, value: f32, encode: fn(f32) -> f32) {
        match self {
            // The nearest integer; the conversion saturates.
            Self::Byte => record.push((encode(value) * 255.0).round() as u8),
            Self::Short => record.extend(((encode(value) * 65535.0).round() as u16).to_le_bytes()),
            Self::Float => record.extend(value.to_le_bytes()),
        }
    }
}

/// Appends what the vertex of an index has of a property.
type Push<'a> = Box<dyn Fn(&mut Vec<u8>, usize) + 'a>;

/// A property of the vertices, or several of a type.
pub(super) struct Property<'a> {
    names: Vec<String>,
    scalar: ScalarType,
    push: Push<'a>,
}

impl<'a> Property<'a> {
    pub fn new(
        names: impl IntoIterator<Item = impl Into<String>>,
        scalar: ScalarType,
        push: impl Fn(&mut Vec<u8>, usize) + 'a,
    ) -> Self {
        Self { names: names.into_iter().map(Into::into).collect(), scalar, push: Box::new(push) }
    }

    fn floats(name: impl Into<String>, values: &'a [f32]) -> Self {
        Self::new([name], ScalarType::Float, |record, index| record.extend(values[index].to_le_bytes()))
    }
}

/// Writes the whole file.
fn write_columns(out: &mut impl Write, cloud: &Cloud, types: &ColumnTypes) -> std::io::Result<()> {
    let (color, alpha) = (types.color, types.alpha);
    let mut properties = vec![position(cloud, types.position.clone())];
    if let Some(colors) = &cloud.colors {
        let names = if color == Coding::Float { LINEAR_COLOR[0] } else { ["red", "green", "blue"] };
        properties.push(Property::new(names, color.scalar(), move |record, index| {
            colors[index].to_array().into_iter().for_each(|linear| color.push(record, linear, encode_srgb));
        }));
    }
    if let Some(alphas) = &cloud.alphas {
        let push = move |record: &mut Vec<u8>, index: usize| alpha.push(record, alphas[index], same);
        properties.push(Property::new(["alpha"], alpha.scalar(), push));
    }
    if let Some(normals) = &cloud.normals {
        properties.push(Property::new(["nx", "ny", "nz"], ScalarType::Float, |record, index| {
            record.extend(normals[index].to_array().map(f32::to_le_bytes).as_flattened());
        }));
    }
    properties.extend(cloud.radii.iter().map(|radii| Property::floats("radius", radii)));
    properties.extend(cloud.prepared.iter().map(|prepared| Property::floats(FIELD, &prepared.values)));
    properties.extend(others(cloud));
    let shadows = cloud.prepared.iter().flat_map(|prepared| &prepared.shadows);
    properties.extend(shadows.map(|shadows| Property::floats(LIT, &shadows.lit)));
    let comment: Vec<String> = prepared::comment(cloud)?.into_iter().collect();
    write_vertices(out, &comment, cloud.len(), &properties)
}

/// Returns classes, intensity and scalars of a cloud.
pub(super) fn others(cloud: &Cloud) -> impl Iterator<Item = Property<'_>> {
    let classes = cloud.classification.iter().map(|codes| {
        Property::new(["classification"], ScalarType::UChar, |record: &mut Vec<u8>, index| record.push(codes[index]))
    });
    let intensity = cloud.intensity.iter().map(|values| Property::floats("intensity", values));
    let scalars = cloud.scalars.iter().map(|(name, values)| Property::floats(scalar_name(cloud, name), values));
    classes.chain(intensity).chain(scalars)
}

/// Writes a file of so many vertices with these properties.
pub(super) fn write_vertices(
    out: &mut impl Write,
    comments: &[String],
    vertices: usize,
    properties: &[Property],
) -> std::io::Result<()> {
    let writer = Writer::<DefaultElement>::new();
    writer.write_line_magic_number(out)?;
    writer.write_line_format(out, &Encoding::BinaryLittleEndian, &Version { major: 1, minor: 0 })?;
    for comment in comments {
        writeln!(out, "comment {comment}")?;
    }
    let mut vertex = ElementDef::new("vertex".to_owned());
    vertex.count = vertices;
    writer.write_line_element_definition(out, &vertex)?;
    for Property { names, scalar, .. } in properties {
        for name in names {
            let property = PropertyDef::new(name.clone(), PropertyType::Scalar(scalar.clone()));
            writer.write_line_property_definition(out, &property)?;
        }
    }
    writer.write_line_end_header(out)?;
    let mut record = Vec::new();
    for index in 0..vertices {
        record.clear();
        properties.iter().for_each(|property| (property.push)(&mut record, index));
        out.write_all(&record)?;
    }
    Ok(())
}

/// Returns the smallest type that keeps all positions.
pub(super) fn narrowest_position(cloud: &Cloud) -> ScalarType {
    let single = cloud.positions.iter().all(|&p| p.as_vec3().as_dvec3() == p);
    if single { ScalarType::Float } else { ScalarType::Double }
}

/// Returns the positions of a cloud as numbers of a type.
pub(super) fn position(cloud: &Cloud, scalar: ScalarType) -> Property<'_> {
    let double = scalar == ScalarType::Double;
    Property::new(["x", "y", "z"], scalar, move |record, index| {
        let position = cloud.positions[index];
        if double {
            record.extend(position.to_array().map(f64::to_le_bytes).as_flattened());
        } else {
            record.extend(position.as_vec3().to_array().map(f32::to_le_bytes).as_flattened());
        }
    })
}

/// The property name of a scalar: in a prepared file one that the reader can't take for another column.
fn scalar_name(cloud: &Cloud, name: &str) -> String {
    let name = without_blanks(name);
    if cloud.prepared.is_some() && is_known(&name) { format!("{name}_") } else { name }
}
