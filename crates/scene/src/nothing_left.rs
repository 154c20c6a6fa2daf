//! The error of a scene of which no point is left: it names what there was, beside what was asked for.

use std::borrow::Borrow;

use super::error::Error;
use super::scene::Scene;
use super::settings::{ClassSettings, ClipShape, CloudSettings};
use pellucid_core::cloud::{Bounds, Cloud};
use pellucid_core::color::classes as class_names;
use pellucid_core::points::Points;

/// Classes that are named, at most.
const MOST_CLASSES: usize = 12;

/// Returns `true` if an entry of the cloud's classes hides points.
fn hides(settings: &CloudSettings) -> bool {
    settings.class.iter().any(|entry| entry.visible == Some(false))
}

/// Returns `true` if an entry hides points of some class.
fn hides_classes(settings: &CloudSettings) -> bool {
    let is_of_classes = |entry: &ClassSettings| (0..=u8::MAX).any(|code| entry.points.holds_class(code));
    settings.class.iter().any(|entry| entry.visible == Some(false) && is_of_classes(entry))
}

/// Returns the classes of the points, in ascending order; none where no class is hidden.
pub(super) fn classes(scene: &Scene, clouds: &[impl Borrow<Cloud>]) -> Vec<u8> {
    let mut there = [false; 256];
    for (settings, cloud) in scene.clouds.iter().zip(clouds) {
        let codes = cloud.borrow().classification.iter().flatten().filter(|_| hides_classes(settings));
        codes.for_each(|code| there[usize::from(*code)] = true);
    }
    (0..=u8::MAX).filter(|code| there[usize::from(*code)]).collect()
}

/// Returns the error of a scene without a point to draw; `classes` are those of its points, if they are known.
pub(super) fn no_points(scene: &Scene, points: &Points, classes: &[u8]) -> Error {
    let clouds: Vec<_> = scene.clouds.iter().map(|cloud| cloud.path.display().to_string()).collect();
    let (count, bounds) = (points.unseen.positions.len(), Bounds::of(&points.unseen.positions));
    let (hidden, cut) = (scene.clouds.iter().any(hides), !scene.clips.is_empty());
    let reason = match bounds {
        None => "no finite point remains after `translate` and `scale`".to_owned(),
        Some(bounds) => {
            let extent = format!("the points extend over {}", extents(scene, bounds));
            let there = if classes.is_empty() { None } else { Some(format!("the points have {}", named(classes))) };
            let (what, there) = match (hidden, cut) {
                (true, true) => ("hidden classes and clips leave out", there.into_iter().chain([extent]).collect()),
                (false, true) => ("clips cut off", vec![extent]),
                _ => ("hidden classes leave out", there.into_iter().collect()),
            };
            let parts: Vec<String> =
                [format!("no point remains to draw: {what} all {count}")].into_iter().chain(there).collect();
            parts.join("; ")
        }
    };
    Error::NoPoints { clouds: clouds.join(", "), reason }
}

/// The extents of the points along the axes that are clipped.
fn extents(scene: &Scene, bounds: Bounds) -> String {
    let is_cut = |axis: usize| {
        scene.clips.iter().any(|clip| match clip.shape {
            ClipShape::Slab { axis: across, .. } => across == axis,
            ClipShape::Polygon(_) => axis < 2,
            ClipShape::Box { .. } | ClipShape::Plane { .. } => true,
        })
    };
    let one = |axis: usize| {
        let [min, max] = [bounds.min[axis], bounds.max[axis]];
        // Four digits of the extent, whatever the distance to the origin.
        let digits = if max > min { (3.0 - (max - min).log10().floor()).clamp(0.0, 9.0) as usize } else { 3 };
        format!("{} {min:.digits$} to {max:.digits$}", ["x", "y", "z"][axis])
    };
    (0..3).filter(|axis| is_cut(*axis)).map(one).collect::<Vec<_>>().join(", ")
}

fn named(classes: &[u8]) -> String {
    let one = |code: &u8| match class_names::name(*code) {
        Some(name) => format!("{code} ({name})"),
        None => code.to_string(),
    };
    let some: Vec<_> = classes.iter().take(MOST_CLASSES).map(one).collect();
    let more = if classes.len() > MOST_CLASSES { " and others" } else { "" };
    format!("{} {}{more}", if classes.len() == 1 { "class" } else { "classes" }, some.join(", "))
}
