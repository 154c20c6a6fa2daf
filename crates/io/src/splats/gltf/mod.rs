//! glTF with `KHR_gaussian_splatting`, as text or binary.
//!
//! Extents are standard deviations, as the ratified extension has them. Drafts of it had their logarithms, which a file
//! shows by any below zero. Nodes may move, turn and scale splats; then the harmonics are turned as well, with the
//! closest rotation where scales differ along axes.

mod accessor;
mod buffers;
mod document;
mod nodes;
mod primitive;

pub(crate) use buffers::decoded;

use super::{Splats, all_bytes, check_count};
use crate::{Error, InputFile};
use buffers::Buffers;
use document::Document;
use nodes::Placed;
use pellucid_core::cloud::{Cloud, UpAxis};
use pellucid_core::progress::Progress;
use primitive::Primitive;

/// First bytes of the binary form.
pub(super) const MAGIC: &[u8] = b"glTF";

/// The extension of splats, which is also what the names of their attributes begin with.
const EXTENSION: &str = "KHR_gaussian_splatting";

pub(super) fn read(source: InputFile, progress: &Progress) -> Result<Cloud, Error> {
    let (file, bytes) = all_bytes(source)?;
    let (text, binary) = document::chunks(&file, &bytes)?;
    let document = Document::parse(text).map_err(|cause| file.malformed("JSON", cause))?;
    let wrong = |(place, cause): (String, String)| file.malformed(place, cause);
    document.check().map_err(|cause| file.malformed("extensionsRequired", cause))?;
    let (placed, others) = nodes::find(&document).map_err(wrong)?;
    let buffers = Buffers::read(&file, &document, binary)?;
    let primitive = |placed: &Placed| {
        Primitive::find(&document, &buffers, placed.primitive).map_err(|(place, cause)| {
            wrong((format!("mesh {}, primitive {}, {place}", placed.mesh, placed.number), cause))
        })
    };
    let primitives = placed.iter().map(primitive).collect::<Result<Vec<_>, Error>>()?;
    let Some(degree) = primitives.iter().map(|primitive| primitive.degree).max() else {
        let cause = format!("no primitive of its scene has {EXTENSION}, and other meshes are not read");
        return Err(file.malformed("meshes", cause));
    };
    let count = primitives.iter().map(|primitive| primitive.count as u64).sum();
    check_count(&file, "accessors", count, degree, Some(buffers.len()))?;
    let logarithms = primitives.iter().any(Primitive::has_negative_scale);
    let mut cloud = Splats::new(degree, 0).finish(UpAxis::Y);
    for (placed, primitive) in placed.iter().zip(&primitives) {
        let part = primitive.splats(&placed.transform, logarithms, progress).finish(UpAxis::Y);
        cloud.warnings.extend(part.warnings.iter().cloned());
        cloud.append(part);
    }
    cloud.warnings.extend(warnings(&primitives, logarithms, others));
    if !logarithms {
        cloud.warnings.extend(oversized(&cloud));
    }
    if degree > 0 && placed.iter().any(|placed| placed.transform.stretches()) {
        let warning = "a node scales splats differently along its axes: their harmonics turn with the closest rotation";
        cloud.warnings.push(warning.to_owned());
    }
    Ok(cloud)
}

/// Returns a warning if an extent is larger than the whole cloud: then scales may be logarithms of which none is below
/// zero.
fn oversized(cloud: &Cloud) -> Option<String> {
    let largest = cloud.gaussians.iter().flat_map(|splats| &splats.extents).map(|extents| extents.max_element());
    let (largest, diagonal) = (largest.fold(0.0, f32::max), cloud.bounds()?.diagonal());
    (diagonal > 0.0 && f64::from(largest) > diagonal).then(|| {
        format!(
            "a splat's standard deviation is {largest}, but all centers lie within {diagonal:.4}: if the file follows a draft \
             of {EXTENSION}, its scales are meant as logarithms, and are read wrong"
        )
    })
}

/// Returns warnings of what is odd about the file.
fn warnings(primitives: &[Primitive], logarithms: bool, others: usize) -> Vec<String> {
    let mut warnings = Vec::new();
    if logarithms {
        warnings.push(format!("a scale is below 0, so all scales are read as logarithms, as in drafts of {EXTENSION}"));
    }
    for odd in primitives.iter().flat_map(|primitive| &primitive.odd) {
        if !warnings.contains(odd) {
            warnings.push(odd.clone());
        }
    }
    if others > 0 {
        warnings.push(format!("{others} primitives that are not splats are left out"));
    }
    warnings
}
