//! Notes on a frame: warnings about whatever differs from the request, and the metadata of its image.

use pellucid_engine::image::Image;
use pellucid_engine::methods::brightness::Applied;
use pellucid_engine::methods::see_through::Found;
use pellucid_engine::methods::{Frame, spbr};
use pellucid_engine::passes::project::DeviceCloud;
use pellucid_engine::points::Points;
use pellucid_engine::prepare::Arranged;
use pellucid_engine::scene::CloudSettings;
use serde_json::{Value, json};

use crate::ensemble_warnings;

/// A sentence for each setting and each cloud that doesn't come out as asked; `names` are those of the clouds that have
/// points, `why` the reason for the frame's method.
pub fn warnings(names: &[String], arranged: &Arranged, cloud: &DeviceCloud, frame: &Frame, why: &str) -> Vec<String> {
    // Other methods, and points that were not dealt, need no warning.
    let shares = spbr::shares(cloud, frame).unwrap_or_default();
    let mut warnings = ensemble_warnings::warnings(names, arranged.surfaces(), &shares, frame);
    let name = frame.method.name();
    if !frame.detail.is_whole() && frame.method.is_dealt() {
        warnings.push(format!("[detail] has no effect: method {name} deals all points to ensembles"));
    } else if !frame.detail.is_whole() && !frame.method.needs_radii() {
        warnings.push(format!(
            "method {name} draws points of a fixed size, which can't grow to cover the points that [detail] leaves out"
        ));
    }
    if frame.shadows.is_some() && !frame.method.takes_shadows() {
        warnings.push(format!("[shadows] has no effect: method {name} takes no shadows ({why})"));
    }
    warnings
}

/// Says why an image of these points is empty; `None` if it isn't.
pub fn empty(image: &Image, points: &Points) -> Option<String> {
    if image.rgba.iter().any(|pixel| pixel[3] > 0.0) {
        return None;
    }
    let opacities = &points.opacities;
    let invisible = !opacities.is_empty() && opacities.iter().all(|opacity| *opacity <= 0.0);
    let why = if invisible { "all points have opacity 0" } else { "no point is in view" };
    Some(format!("the picture is empty: {why}"))
}

/// Key and JSON of all that was decided for a frame: the brightness that was `applied`, the opacity that was `found`,
/// and the points that were left out.
pub fn decisions(
    frame: &Frame,
    cloud: &DeviceCloud,
    clouds: &[CloudSettings],
    applied: Option<&Applied>,
    found: Option<&Found>,
) -> Vec<(String, String)> {
    let all = [
        ("pellucid:brightness", applied.map(Applied::json)),
        ("pellucid:see-through", found.map(|found| found.json(clouds))),
        ("pellucid:detail", left_out(frame, cloud)),
    ];
    all.into_iter().filter_map(|(key, value)| Some((key.to_owned(), value?.to_string()))).collect()
}

/// Returns what was left out of the last frame; `None` if nothing was.
fn left_out(frame: &Frame, cloud: &DeviceCloud) -> Option<Value> {
    let cut = cloud.cut_in_force()?;
    Some(json!({
        "spacing_px": frame.detail.spacing_px,
        "max_points": frame.detail.max_points,
        "cut_px": cut.px(),
        "points": cut.points(),
        "of": cloud.total(),
    }))
}
