//! Messages about opacities: the one that a share of light asked for, and pictures that show nothing, or surfaces
//! alone.

use pellucid_engine::Result;
use pellucid_engine::image::Image;
use pellucid_engine::methods::see_through::{self, Found};
use pellucid_engine::methods::{Frame, Renderer};
use pellucid_engine::passes::project::DeviceCloud;
use pellucid_engine::prepare::Arranged;
use pellucid_engine::scene::{CloudSettings, Family};

use crate::messages::Messages;
use crate::prepared::Prepared;

/// Opacity or transmittance below which a pixel looks empty or opaque.
const HARDLY: f32 = 0.01;

/// Share of the covered pixels that all look alike.
const NEARLY_ALL: f64 = 0.9;

/// Share of light that an advice aims at.
const ADVISED: f64 = 0.5;

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
pub(crate) fn describe(share: f64, found: Option<Found>, prepared: &Prepared, messages: &dyn Messages) {
    let option = messages.option("see-through", &share);
    let Some(found) = found else {
        messages.warn(&format_args!("{option}: no opacity can be found, because no pixel is covered"));
        return;
    };
    let opacities = said(found.factor, prepared, |opacity| opacity);
    let Found { transmittance, trials, .. } = found;
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
pub(crate) fn judge(
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
    let alphas = image.rgba.iter().map(|pixel| pixel[3]);
    let covered = alphas.clone().filter(|a| *a > 0.0).count();
    let nearly_all = |count: usize| count as f64 >= NEARLY_ALL * covered as f64;
    let opaque = nearly_all(alphas.clone().filter(|a| *a > 1.0 - HARDLY).count());
    let faint = nearly_all(alphas.filter(|a| *a > 0.0 && *a < HARDLY).count());
    match (opaque, faint) {
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
