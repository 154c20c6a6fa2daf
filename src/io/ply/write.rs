//! Writes a cloud as a binary little-endian PLY file.

use std::io::{BufWriter, Write};
use std::path::Path;

use glam::DVec3;
use ply_rs_bw::ply::{DefaultElement, ElementDef, Encoding, PropertyDef, PropertyType, ScalarType, Version};
use ply_rs_bw::writer::Writer;

use crate::cloud::Cloud;
use crate::color::encode_srgb;
use crate::io::Error;

/// Writes a cloud: float positions if that keeps every one exactly, else double; colors and alphas as 8 bits (colors
/// sRGB-encoded), all other columns as they are. What a PLY file can't say, the vertical and the number of dropped
/// points, is not kept; white space in the name of a scalar becomes `_`.
///
/// # Errors
/// If the file can't be written; then the old file, or none, is there.
pub fn write(path: &Path, cloud: &Cloud) -> Result<(), Error> {
    write_atomically(path, cloud).map_err(|source| Error::Write { path: path.to_path_buf(), source })
}

fn write_atomically(path: &Path, cloud: &Cloud) -> std::io::Result<()> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut temporary = tempfile::Builder::new();
    #[cfg(unix)]
    {
        // The usual rights of a new file, less the umask; a temporary file's own are private.
        use std::os::unix::fs::PermissionsExt;
        temporary.permissions(std::fs::Permissions::from_mode(0o666));
    }
    let file = temporary.tempfile_in(folder)?;
    let mut out = BufWriter::with_capacity(1 << 20, file);
    write_header(&mut out, cloud)?;
    let double = !fits_float(&cloud.positions);
    let mut record = Vec::new();
    for index in 0..cloud.len() {
        record.clear();
        push_record(&mut record, cloud, index, double);
        out.write_all(&record)?;
    }
    let file = out.into_inner().map_err(std::io::IntoInnerError::into_error)?;
    file.persist(path)?;
    Ok(())
}

fn write_header(out: &mut impl Write, cloud: &Cloud) -> std::io::Result<()> {
    let position = if fits_float(&cloud.positions) { ScalarType::Float } else { ScalarType::Double };
    let mut properties: Vec<(&str, ScalarType)> = ["x", "y", "z"].map(|name| (name, position.clone())).to_vec();
    if cloud.colors.is_some() {
        properties.extend(["red", "green", "blue"].map(|name| (name, ScalarType::UChar)));
    }
    if cloud.alphas.is_some() {
        properties.push(("alpha", ScalarType::UChar));
    }
    if cloud.normals.is_some() {
        properties.extend(["nx", "ny", "nz"].map(|name| (name, ScalarType::Float)));
    }
    if cloud.radii.is_some() {
        properties.push(("radius", ScalarType::Float));
    }
    if cloud.classification.is_some() {
        properties.push(("classification", ScalarType::UChar));
    }
    if cloud.intensity.is_some() {
        properties.push(("intensity", ScalarType::Float));
    }
    properties.extend(cloud.scalars.iter().map(|(name, _)| (name.as_str(), ScalarType::Float)));

    let writer = Writer::<DefaultElement>::new();
    writer.write_line_magic_number(out)?;
    writer.write_line_format(out, &Encoding::BinaryLittleEndian, &Version { major: 1, minor: 0 })?;
    let mut vertex = ElementDef::new("vertex".to_owned());
    vertex.count = cloud.len();
    writer.write_line_element_definition(out, &vertex)?;
    for (name, scalar) in properties {
        let name = name.split_whitespace().collect::<Vec<_>>().join("_");
        let property = PropertyDef::new(name, PropertyType::Scalar(scalar));
        writer.write_line_property_definition(out, &property)?;
    }
    writer.write_line_end_header(out)?;
    Ok(())
}

fn fits_float(positions: &[DVec3]) -> bool {
    positions.iter().all(|&p| p.as_vec3().as_dvec3() == p)
}

/// The bytes of one vertex, in the order of the header.
fn push_record(record: &mut Vec<u8>, cloud: &Cloud, index: usize, double: bool) {
    for value in cloud.positions[index].to_array() {
        if double {
            record.extend(value.to_le_bytes());
        } else {
            record.extend((value as f32).to_le_bytes());
        }
    }
    if let Some(colors) = &cloud.colors {
        record.extend(colors[index].to_array().map(|linear| byte(encode_srgb(linear))));
    }
    if let Some(alphas) = &cloud.alphas {
        record.push(byte(alphas[index]));
    }
    if let Some(normals) = &cloud.normals {
        record.extend(normals[index].to_array().into_iter().flat_map(f32::to_le_bytes));
    }
    if let Some(radii) = &cloud.radii {
        record.extend(radii[index].to_le_bytes());
    }
    if let Some(classification) = &cloud.classification {
        record.push(classification[index]);
    }
    if let Some(intensity) = &cloud.intensity {
        record.extend(intensity[index].to_le_bytes());
    }
    for (_, values) in &cloud.scalars {
        record.extend(values[index].to_le_bytes());
    }
}

/// The nearest 8-bit value of a share; the conversion saturates.
fn byte(share: f32) -> u8 {
    (share * 255.0).round() as u8
}
