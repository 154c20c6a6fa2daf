//! Notes on a frame: warnings about whatever differs from the request, the opacity that was found, pictures that show
//! nothing or surfaces alone, and the metadata of an image.

use bytesize::ByteSize;
use pellucid_core::cloud::light_image::{FEWEST, Holes, automatic_resolution};
use pellucid_core::image::{Cover, Image};
use pellucid_core::points::Points;
use pellucid_engine::Result;
use pellucid_engine::methods::brightness::Applied;
use pellucid_engine::methods::see_through::{self, OpacityFactor};
use pellucid_engine::methods::{Frame, Renderer, shadows, spbr};
use pellucid_engine::passes::project::DeviceCloud;
use pellucid_scene::prepare::Arranged;
use pellucid_scene::{CloudSettings, Family, MapResolution, Method, PeelLayers};
use serde_json::{Value, json};

use crate::ensemble_warnings;
use crate::messages::Messages;
use crate::prepared::Prepared;

/// Share of the covered pixels that all look alike.
const NEARLY_ALL: f64 = 0.9;

/// Share of light that an advice aims at.
const ADVISED: f64 = 0.5;

/// A sentence for each setting and each cloud that doesn't come out as asked; `why` is the reason for the frame's
/// method.
pub fn warnings(prepared: &Prepared, cloud: &DeviceCloud, frame: &Frame, why: &str) -> Vec<String> {
    let assembled = &prepared.assembled;
    // Other methods, and points that were not dealt, need no warning.
    let shares = spbr::shares(cloud, frame).unwrap_or_default();
    let mut warnings =
        ensemble_warnings::warnings(&assembled.cloud_names(), assembled.arranged().surfaces(), &shares, frame);
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

/// Says so where a frame took more memory of the device than was free there; `None` otherwise.
pub fn beyond_memory(taken: u64, free: u64) -> Option<String> {
    (taken > free).then(|| {
        format!(
            "the frame took {} of the device's memory, of which {} were free: parts of it may have been moved to the host's, which \
             is slow; a smaller --memory-budget draws the picture in smaller parts",
            ByteSize(taken),
            ByteSize(free)
        )
    })
}

/// Says so where light falls through holes in the surfaces that cast shadows onto a cloud, and which settings help;
/// `None` where they are few, or were not counted.
pub fn shadow_holes(cloud: &DeviceCloud, frame: &Frame) -> Option<String> {
    let holes = cloud.light_holes().filter(Holes::are_many)?;
    // No scene has fewer pixels unless it asks for them: then there is nothing to advise.
    let casting = shadows::casting(frame, cloud).filter(|casting| casting.resolution > FEWEST)?;
    let given = frame.shadows?;
    let share = 100.0 * holes.share();
    let (resolution, auto) = (casting.resolution, automatic_resolution(&casting.light, &cloud.bounds(), cloud.drawn()));
    // Pixels that are as many as points, unless the points are even fewer where it matters.
    let fewer = if given.resolution != MapResolution::Auto && auto < resolution {
        format!("shadows.resolution = \"auto\" ({auto})")
    } else {
        format!("a shadows.resolution below {resolution}")
    };
    Some(format!(
        "shadows: light falls between the points: {share:.0}% of the surfaces in the light's image ({resolution} × {resolution} \
         pixels) are holes; use {fewer}, or, where points are near each other, more iterations (shadows.fill, \
         shadows.occlusion)"
    ))
}

/// Says why an image of these points is empty; `None` if it isn't.
pub fn empty(image: &Image, points: &Points, method: &Method) -> Option<String> {
    if !image.is_empty() {
        return None;
    }
    let opacities = &points.opacities;
    let invisible = !opacities.is_empty() && opacities.iter().all(|opacity| *opacity <= 0.0);
    let why = match method {
        _ if invisible => "all points have opacity 0".to_owned(),
        Method::PeelLayers(PeelLayers { only: Some(only), .. }) if *only > 1 => {
            format!("nothing is seen of layer {only}, which method.only shows alone")
        }
        _ => "no point is in view".to_owned(),
    };
    Some(format!("the picture is empty: {why}"))
}

/// Key and JSON of all that was decided for a frame: the brightness that was `applied`, the opacity that was `found`,
/// and the points that were left out.
pub fn decisions(
    frame: &Frame,
    cloud: &DeviceCloud,
    clouds: &[CloudSettings],
    applied: Option<&Applied>,
    found: Option<&OpacityFactor>,
) -> Vec<(String, String)> {
    let all = [
        ("pellucid:brightness", applied.map(Applied::json)),
        ("pellucid:see-through", found.map(|found| found.json(clouds, frame.factors.radius))),
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
        "cut_px": cut.px,
        "points": cut.shown(),
        "of": cloud.total(),
    }))
}

/// Returns `opacity 0.031`, or for clouds of several opacities `opacities 0.031, 0.0062 of the clouds, in order`.
fn listed(opacities: &[f32]) -> String {
    match opacities {
        [first, rest @ ..] if rest.iter().any(|opacity| opacity != first) => {
            let all: Vec<_> = opacities.iter().map(f32::to_string).collect();
            format!("opacities {} of the clouds, in order", all.join(", "))
        }
        [first, ..] => format!("opacity {first}"),
        [] => "no opacity".to_owned(),
    }
}

/// Says which opacity was found for a share of light.
pub fn describe_opacity(share: f64, found: Option<OpacityFactor>, prepared: &Prepared, messages: &dyn Messages) {
    let option = messages.option("see-through", &share);
    let Some(found) = found else {
        messages.warn(&format_args!("{option}: no opacity can be found, because no pixel is covered"));
        return;
    };
    let mut opacities = said(found.factor, prepared, |opacity| opacity);
    let radius_factor = prepared.radius_factor();
    if radius_factor != 1.0 {
        opacities = format!("{opacities} and radius_factor {radius_factor}, which keeps sparse points apart");
    }
    let OpacityFactor { transmittance, trials, .. } = found;
    if found.meets(share) {
        messages.note(&format_args!(
            "see-through {share}: {opacities} (the median covered pixel lets {transmittance:.3} of the light through; {trials} \
             trials)"
        ));
    } else {
        messages.warn(&format_args!(
            "{option} is out of reach: the nearest is {opacities}, where the median covered pixel lets {transmittance:.3} of \
             the light through"
        ));
    }
}

/// Says so where nearly every covered pixel looks opaque or empty though the points don't, and which opacity to try.
pub fn judge(
    (renderer, cloud, frame): (&mut Renderer, &mut DeviceCloud, &Frame),
    prepared: &Prepared,
    image: &Image,
    messages: &dyn Messages,
) -> Result<()> {
    let opacities = &prepared.points().opacities;
    // An author of a scene file knows; whoever gave one number for all may have guessed.
    if !prepared.request.opacity_given || opacities.iter().all(|opacity| *opacity >= 1.0) {
        return Ok(());
    }
    let method = frame.method;
    if method.family() == Family::Opaque {
        let (name, auto) = (method.name(), messages.option("method", &"auto"));
        messages.warn(&format_args!("the opacity has no effect: method {name} is opaque; {auto} shows it"));
    }
    if !method.family().has_opacity() {
        return Ok(());
    }
    let Some(seems) = looks(image) else { return Ok(()) };
    let largest = see_through::largest_factor(prepared.points());
    // Each trial would read a cloud that is not in memory.
    let found = match prepared.assembled.arranged() {
        Arranged::Supplied(_) => None,
        _ => see_through::estimate(renderer, cloud, frame, ADVISED, largest)?,
    };
    let found = found.filter(|found| found.meets(ADVISED));
    let option = messages.option("see-through", &ADVISED);
    let advice = found.map(|found| match has_own_opacities(prepared) {
        true => format!("; {option} finds the factor on all opacities that lets half of the light through"),
        false => {
            let tried = opacity_to_try(found.factor, prepared);
            format!("; {tried} would let half of the light through ({option} finds it)")
        }
    });
    messages.note(&format_args!("nearly every covered pixel looks {seems}{}", advice.unwrap_or_default()));
    Ok(())
}

/// Returns how nearly every covered pixel looks, if all look alike.
fn looks(image: &Image) -> Option<&'static str> {
    let mut counts = [0u64; 4];
    image.covers().for_each(|cover| counts[cover as usize] += 1);
    let covered = counts.iter().sum::<u64>() - counts[Cover::Nothing as usize];
    let nearly_all = |cover: Cover| counts[cover as usize] as f64 >= NEARLY_ALL * covered as f64;
    match (nearly_all(Cover::Fully), nearly_all(Cover::Hardly)) {
        (true, _) => Some("opaque"),
        (false, true) => Some("empty"),
        (false, false) => None,
    }
}

/// Returns the opacities with a factor, to two digits.
fn opacity_to_try(factor: f32, prepared: &Prepared) -> String {
    said(factor, prepared, |opacity| format!("{opacity:.1e}").parse().unwrap_or(opacity))
}

/// Returns `true` if surfaces or classes have opacities, so that points of a cloud have several, which one option
/// doesn't set.
fn has_own_opacities(prepared: &Prepared) -> bool {
    let of_classes = |cloud: &CloudSettings| cloud.class.iter().any(|entry| entry.opacity.is_some());
    prepared.scene().clouds.iter().any(|cloud| cloud.surface_opacity.is_some() || of_classes(cloud))
}

/// Returns the opacities with a factor, or the factor itself where points of a cloud have several.
fn said(factor: f32, prepared: &Prepared, rounded: impl Fn(f32) -> f32) -> String {
    if has_own_opacities(prepared) {
        return format!("{} times the opacity of each point", rounded(factor));
    }
    listed(&see_through::opacities(factor, &prepared.scene().clouds).into_iter().map(rounded).collect::<Vec<_>>())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_that_took_more_memory_than_was_free_is_warned_of() {
        assert_eq!(beyond_memory(1 << 20, 1 << 20), None);
        let warning = beyond_memory(3 << 20, 1 << 20).expect("a warning");
        assert!(warning.contains("took 3.0 MiB of the device's memory, of which 1.0 MiB were free"), "{warning}");
    }

    #[test]
    fn an_empty_picture_of_a_single_layer_names_the_layer() {
        let mut image = Image { width: 1, height: 1, rgba: vec![[0.0; 4]], ..Image::default() };
        let points = Points { opacities: vec![0.5], ..Points::default() };
        let of = |only| Method::PeelLayers(PeelLayers { only, ..PeelLayers::default() });
        let says = |method, image: &Image| empty(image, &points, &method).unwrap_or_default();
        assert!(says(of(Some(3)), &image).ends_with("nothing is seen of layer 3, which method.only shows alone"));
        // Without a first layer there is no point at all.
        for method in [of(Some(1)), of(None), Method::Points] {
            assert!(says(method, &image).ends_with("no point is in view"));
        }
        image.rgba[0][3] = 0.25;
        assert_eq!(empty(&image, &points, &of(Some(3))), None);
    }
}
