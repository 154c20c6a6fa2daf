//! Writes Gaussian splats as other programs read them (Kerbl et al. 2023).

use std::io::Write;

use ply_rs_bw::ply::ScalarType;

use super::write::{header, narrowest_position, push_position, scalar_names};
use pellucid_core::cloud::Cloud;
use pellucid_core::cloud::gaussians::{Gaussians, Y0};

/// Writes the splats of a cloud: centers, coefficients of the color, logits of the opacity, logarithms of the extents,
/// rotations. Then come classes, intensity and scalars. Colors and alphas follow from these. Splats without a third
/// extent have no `scale_2`.
pub(super) fn write(out: &mut impl Write, cloud: &Cloud, gaussians: &Gaussians) -> std::io::Result<()> {
    let position = narrowest_position(cloud);
    let flat = gaussians.extents.iter().all(|extents| extents.z == 0.0);
    let axes = if flat { 2 } else { 3 };
    let rest = (0..3 * gaussians.coefficients()).map(|at| format!("f_rest_{at}"));
    let numbered = |stem: &'static str, count: usize| (0..count).map(move |at| format!("{stem}{at}"));
    let names = numbered("f_dc_", 3).chain(rest).chain(["opacity".to_owned()]).chain(numbered("scale_", axes));
    let names: Vec<String> = names.chain(numbered("rot_", 4)).collect();
    let mut properties = ["x", "y", "z"].map(|name| (name, position.clone())).to_vec();
    properties.extend(names.iter().map(|name| (name.as_str(), ScalarType::Float)));
    if cloud.classification.is_some() {
        properties.push(("classification", ScalarType::UChar));
    }
    if cloud.intensity.is_some() {
        properties.push(("intensity", ScalarType::Float));
    }
    let scalars = scalar_names(cloud);
    properties.extend(scalars.iter().map(|name| (name.as_str(), ScalarType::Float)));
    let comment = cloud.filter.map(|filter| format!("SplatRenderMode: {}", filter.name()));
    header(out, comment.as_deref(), cloud.len(), properties)?;

    let mut record = Vec::new();
    for index in 0..cloud.len() {
        record.clear();
        push_position(&mut record, cloud.positions[index], &position);
        let alpha = cloud.alphas.as_ref().map_or(1.0, |alphas| f64::from(alphas[index]));
        push_splat(&mut record, gaussians, index, alpha, axes);
        record.extend(cloud.classification.iter().map(|codes| codes[index]));
        let others = cloud.intensity.iter().chain(cloud.scalars.iter().map(|(_, values)| values));
        others.for_each(|values| record.extend(values[index].to_le_bytes()));
        out.write_all(&record)?;
    }
    Ok(())
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
