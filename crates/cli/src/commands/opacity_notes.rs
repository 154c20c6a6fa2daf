//! Messages about opacities: the one that `--see-through` found, and pictures that show nothing, or surfaces alone.

use pellucid_engine::Result;
use pellucid_engine::image::Image;
use pellucid_engine::methods::see_through::{self, Found};
use pellucid_engine::prepare::Arranged;
use pellucid_engine::scene::{CloudSettings, Family};
use pellucid_lab::frame_notes;

use super::console::Console;
use super::loaded::Resolved;
use super::session::Session;

/// A pixel that lets less light through, or covers less, looks opaque, or empty.
const HARDLY: f32 = 0.01;

/// The share of the covered pixels that all look alike.
const NEARLY_ALL: f64 = 0.9;

/// The share of light that an advice aims at.
const ADVISED: f64 = 0.5;

/// `opacity 0.031`, or for clouds of several opacities `opacities 0.031, 0.0062 of the clouds in their order`.
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

/// Says which opacity was found for `share`.
pub fn describe(share: f64, found: Option<Found>, resolved: &Resolved, console: Console) {
    let Some(found) = found else {
        console.warn(format_args!("--see-through {share}: no opacity can be found, because no pixel is covered"));
        return;
    };
    let opacities = said(found.factor, resolved, |opacity| opacity);
    let Found { transmittance, trials, .. } = found;
    if found.meets(share) {
        console.note(format_args!(
            "see-through {share}: {opacities} (the median covered pixel lets {transmittance:.3} of the light through; {trials} trials)"
        ));
    } else {
        console.warn(format_args!(
            "--see-through {share} is out of reach: the nearest is {opacities}, where the median covered pixel lets \
             {transmittance:.3} of the light through"
        ));
    }
}

/// Says so where a picture is empty, or where nearly every covered pixel looks opaque or empty though the points don't, and
/// which opacity to try.
pub fn judge(session: &mut Session, resolved: &Resolved, image: &Image, console: Console) -> Result<()> {
    if let Some(empty) = frame_notes::empty(image, resolved.points()) {
        console.warn(empty);
        return Ok(());
    }
    let opacities = &resolved.points().opacities;
    // An author of a scene file knows; whoever gave one number for all may have guessed.
    if !resolved.opacity_given {
        return Ok(());
    }
    if opacities.iter().all(|opacity| *opacity >= 1.0) {
        return Ok(());
    }
    let method = session.frame.method;
    if method.family() == Family::Opaque {
        let name = method.name();
        console.warn(format_args!("the opacity has no effect: method {name} is opaque; --method auto shows it"));
    }
    if !method.family().has_opacity() {
        return Ok(());
    }
    let alphas = image.rgba.iter().map(|pixel| pixel[3]);
    let covered = alphas.clone().filter(|a| *a > 0.0).count();
    let nearly_all = |count: usize| count as f64 >= NEARLY_ALL * covered as f64;
    let opaque = nearly_all(alphas.clone().filter(|a| *a > 1.0 - HARDLY).count());
    let faint = nearly_all(alphas.filter(|a| *a > 0.0 && *a < HARDLY).count());
    if !opaque && !faint {
        return Ok(());
    }
    let seems = if opaque { "opaque" } else { "empty" };
    let Session { renderer, cloud, frame, .. } = session;
    let largest = see_through::largest_factor(resolved.points());
    // Each trial would read a cloud that is not in memory.
    let found = match resolved.arranged {
        Arranged::Supplied(_) => None,
        _ => see_through::estimate(renderer, cloud, frame, ADVISED, largest)?,
    };
    let found = found.filter(|found| found.meets(ADVISED));
    let advice = found.map(|found| match has_own_opacities(resolved) {
        true => {
            format!("; --see-through {ADVISED} finds the factor on all opacities that lets half of the light through")
        }
        false => {
            let tried = opacity_to_try(found.factor, resolved);
            format!("; {tried} would let half of the light through (--see-through {ADVISED} finds it)")
        }
    });
    console.note(format_args!("nearly every covered pixel looks {seems}{}", advice.unwrap_or_default()));
    Ok(())
}

/// The opacities with a factor, to two digits.
fn opacity_to_try(factor: f32, resolved: &Resolved) -> String {
    said(factor, resolved, |opacity| format!("{opacity:.1e}").parse().unwrap_or(opacity))
}

/// True if surfaces or classes have opacities, so that points of a cloud have different ones, which `--opacity` doesn't set.
fn has_own_opacities(resolved: &Resolved) -> bool {
    let of_classes = |cloud: &CloudSettings| cloud.class.iter().any(|entry| entry.opacity.is_some());
    resolved.scene.clouds.iter().any(|cloud| cloud.surface_opacity.is_some() || of_classes(cloud))
}

/// The opacities with a factor, or the factor itself where points of a cloud have different ones.
fn said(factor: f32, resolved: &Resolved, rounded: impl Fn(f32) -> f32) -> String {
    if has_own_opacities(resolved) {
        return format!("{} times the opacity of each point", rounded(factor));
    }
    listed(&see_through::opacities(factor, &resolved.scene.clouds).into_iter().map(rounded).collect::<Vec<_>>())
}
