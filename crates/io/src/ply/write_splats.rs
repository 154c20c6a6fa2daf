//! Writes Gaussian splats as other programs read them (Kerbl et al. 2023).

use std::io::Write;

use ply_rs_bw::ply::ScalarType;

use super::splats::LINEARITY;
use super::vertical::VERTICAL_AXIS;
use super::write::{Property, narrowest_position, others, position, write_vertices};
use pellucid_core::cloud::gaussians::{Gaussians, Y0};
use pellucid_core::cloud::{Cloud, UpAxis};

/// Writes the splats of a cloud: centers, coefficients of the color, logits of the opacity, logarithms of the extents,
/// rotations. Then come classes, intensity and scalars. Colors and alphas follow from these. Splats without a third
/// extent have no `scale_2`. Where colors may be linear, a property says of which splats they are.
pub(super) fn write(out: &mut impl Write, cloud: &Cloud, gaussians: &Gaussians) -> std::io::Result<()> {
    let flat = gaussians.extents.iter().all(|extents| extents.z == 0.0);
    let axes = if flat { 2 } else { 3 };
    let numbered = |stem: &'static str, count: usize| (0..count).map(move |at| format!("{stem}{at}"));
    let names = numbered("f_dc_", 3).chain(numbered("f_rest_", 3 * gaussians.coefficients()));
    let names = names.chain(["opacity".to_owned()]).chain(numbered("scale_", axes)).chain(numbered("rot_", 4));
    let splats = Property::new(names, ScalarType::Float, |record, index| {
        let alpha = cloud.alphas.as_ref().map_or(1.0, |alphas| f64::from(alphas[index]));
        push_splat(record, gaussians, index, alpha, axes);
    });
    let mut properties = vec![position(cloud, narrowest_position(cloud)), splats];
    if gaussians.may_be_linear() {
        let linear = |record: &mut Vec<u8>, index| record.push(gaussians.is_linear(index).into());
        properties.push(Property::new([LINEARITY], ScalarType::UChar, linear));
    }
    properties.extend(others(cloud));
    let filter = cloud.filter.map(|filter| format!("SplatRenderMode: {}", filter.name()));
    // −Y is what readers assume.
    let up = match cloud.up {
        // The comment has no word for X.
        UpAxis::NegativeY | UpAxis::X => None,
        UpAxis::Y => Some("y"),
        UpAxis::Z => Some("z"),
    };
    let comments: Vec<String> = filter.into_iter().chain(up.map(|up| format!("{VERTICAL_AXIS}: {up}"))).collect();
    write_vertices(out, &comments, cloud.len(), &properties)
}

/// Appends the color, the opacity, the extents along some axes, and the rotation.
fn push_splat(record: &mut Vec<u8>, gaussians: &Gaussians, index: usize, alpha: f64, axes: usize) {
    let mut push = |value: f64| record.extend((value as f32).to_le_bytes());
    let harmonics = gaussians.harmonics_of(index);
    gaussians.bases[index].to_array().iter().for_each(|base| push((f64::from(*base) - 0.5) / Y0));
    for channel in 0..3 {
        harmonics.iter().for_each(|color| push(color[channel].into()));
    }
    push((alpha / (1.0 - alpha)).ln());
    gaussians.extents[index].to_array().iter().take(axes).for_each(|extent| push(f64::from(*extent).ln()));
    let rotation = gaussians.rotations[index];
    [rotation.w, rotation.x, rotation.y, rotation.z].iter().for_each(|part| push((*part).into()));
}
