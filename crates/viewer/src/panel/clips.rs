//! Boxes, slabs and planes that cut the scene, with their numbers.

use egui::{ComboBox, DragValue, Response, RichText, Ui};

use super::row::{explained, note, vector};
use super::shading;
use crate::controls::{AXES, NewClip, clip_changes, decimals, new_clip, short_number, without_clip};
use crate::hints::hint;
use crate::model::Model;
use pellucid_scene::{Clip, ClipShape};

/// Draws the section.
pub fn show(ui: &mut Ui, model: &mut Model) {
    let clips = model.scene().clips.clone();
    for (at, clip) in clips.iter().enumerate() {
        let edited = ui.push_id(("clip", at), |ui| entry(ui, model, at, clip)).inner;
        match edited {
            Some(edited) if edited == *clip => {}
            Some(edited) => model.change(&clip_changes(at, &edited)),
            // The numbers of the others are different now.
            None => return model.change(&without_clip(at, clips.len())),
        }
    }
    add(ui, model, clips.len());
    if clips.iter().any(|clip| matches!(clip.shape, ClipShape::Box { .. })) {
        ui.weak("drag a box's dots in the picture to move its faces");
    }
}

/// Buttons that add an entry, once the extent of the points is known.
fn add(ui: &mut Ui, model: &mut Model, at: usize) {
    let Some(picture) = model.picture() else { return };
    let (bounds, forward) = (picture.subject.bounds, picture.camera.forward);
    let vertical = shading::vertical(model).index();
    // The half of the points that is farther away, so that one looks into them.
    let ahead =
        forward.abs().to_array().into_iter().enumerate().max_by(|a, b| a.1.total_cmp(&b.1)).map_or(0, |(i, _)| i);
    let kinds = [
        ("box", NewClip::Box, "keep the inside of a box along the axes"),
        ("slab", NewClip::Slab(vertical), "keep the points between two heights, or along another axis"),
        ("plane", NewClip::Plane(ahead, forward[ahead] > 0.0), "keep one side of a plane"),
    ];
    ui.horizontal(|ui| {
        ui.label("add");
        for (text, kind, hint) in kinds {
            if note(model, &format!("clip.{text}+"), ui.button(text).on_hover_text(hint)).clicked() {
                model.change(&clip_changes(at, &new_clip(kind, bounds)));
            }
        }
    });
}

/// An entry with its numbers: as it is now, or `None` if it is to go.
fn entry(ui: &mut Ui, model: &mut Model, at: usize, clip: &Clip) -> Option<Clip> {
    let mut edited = clip.clone();
    let name = match &clip.shape {
        ClipShape::Box { .. } => "box".to_owned(),
        ClipShape::Plane { .. } => "plane".to_owned(),
        ClipShape::Slab { .. } => "slab".to_owned(),
        ClipShape::Polygon(file) => format!("polygon {}", file.display()),
    };
    let out = ui.horizontal(|ui| {
        let out = ui.small_button("×").on_hover_text("remove this clip");
        let out = note(model, &format!("clip.{at}-"), out);
        ui.label(RichText::new(name).strong());
        let response = ui.checkbox(&mut edited.invert, "keep the outside").on_hover_text(hint("clip.0.invert"));
        note(model, &format!("clip.{at}.invert"), response);
        out.clicked()
    });
    if out.inner {
        return None;
    }
    match &mut edited.shape {
        ClipShape::Box { min, max } => {
            for (axis, name) in AXES.iter().enumerate() {
                ui.horizontal(|ui| {
                    ui.label(*name);
                    number(ui, model, axis, &mut min[axis], f64::NEG_INFINITY..=max[axis]);
                    ui.label("to");
                    number(ui, model, axis, &mut max[axis], min[axis]..=f64::INFINITY);
                });
            }
        }
        ClipShape::Slab { axis, min, max } => slab(ui, model, axis, min, max),
        ClipShape::Plane { point, normal } => plane(ui, model, at, point, normal),
        ClipShape::Polygon(_) => {}
    }
    Some(edited)
}

/// The most decimals that are shown of a number in an extent: where there is none, all that count.
pub fn shown_decimals(extent: f64) -> usize {
    decimals(extent).map_or(12, |digits| digits.max(4))
}

/// A coordinate along an axis.
fn number(ui: &mut Ui, model: &Model, axis: usize, x: &mut f64, range: std::ops::RangeInclusive<f64>) -> Response {
    let extent = model.picture().map_or(0.0, |picture| (picture.subject.bounds.max - picture.subject.bounds.min)[axis]);
    let speed = 0.002 * if extent > 0.0 { extent } else { model.extent().diagonal };
    let before = *x;
    let drag = DragValue::new(x).speed(speed).range(range).max_decimals(shown_decimals(extent));
    let response = ui.add_sized([72.0, 18.0], drag.update_while_editing(false));
    *x = kept(before, *x, response.dragged(), extent);
    response
}

/// Rounds a coordinate if it was dragged; a typed number stays as it is.
fn kept(before: f64, now: f64, dragged: bool, extent: f64) -> f64 {
    if dragged && now != before { short_number(now, extent) } else { now }
}

/// The axis of a slab and its ends, either of which may be missing.
fn slab(ui: &mut Ui, model: &Model, axis: &mut usize, min: &mut Option<f64>, max: &mut Option<f64>) {
    let Some(bounds) = model.picture().map(|picture| picture.subject.bounds) else { return };
    let before = *axis;
    ui.horizontal(|ui| {
        ComboBox::from_id_salt("axis").selected_text(AXES[before]).width(40.0).show_ui(ui, |ui| {
            for (other, name) in AXES.iter().enumerate() {
                ui.selectable_value(axis, other, *name);
            }
        });
        let has_both = min.is_some() && max.is_some();
        let [low, high] = [bounds.min[before], bounds.max[before]];
        let below = f64::NEG_INFINITY..=max.unwrap_or(f64::INFINITY);
        end(ui, model, "from", min, (before, low), below, has_both);
        let above = min.unwrap_or(f64::NEG_INFINITY)..=f64::INFINITY;
        end(ui, model, "to", max, (before, high), above, has_both);
    });
    if *axis != before
        && let ClipShape::Slab { min: low, max: high, .. } = new_clip(NewClip::Slab(*axis), bounds).shape
    {
        // The old numbers mean nothing along another axis.
        (*min, *max) = (low, high);
    }
}

/// An end of a slab across an axis, and where it begins. The last one stays, since a slab needs one.
fn end(
    ui: &mut Ui,
    model: &Model,
    text: &str,
    end: &mut Option<f64>,
    (axis, start): (usize, f64),
    range: std::ops::RangeInclusive<f64>,
    may_go: bool,
) {
    let mut on = end.is_some();
    if ui.add_enabled(!on || may_go, egui::Checkbox::new(&mut on, text)).changed() {
        *end = on.then_some(start);
    }
    if let Some(x) = end {
        number(ui, model, axis, x, range);
    }
}

/// A point of a plane and the direction in which points are kept.
fn plane(ui: &mut Ui, model: &mut Model, at: usize, point: &mut glam::DVec3, normal: &mut glam::DVec3) {
    ui.weak("through");
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        let key = format!("clip.{at}.plane.point");
        for axis in 0..AXES.len() {
            let response = number(ui, model, axis, &mut point[axis], f64::NEG_INFINITY..=f64::INFINITY);
            let response = if axis == 0 { note(model, &key, response) } else { response };
            explained(response, hint(&key));
        }
    });
    ui.weak("keep the side toward");
    let turned = vector(ui, model, &format!("clip.{at}.plane.normal"), normal.to_array(), 0.005);
    // A vector without a direction is ignored, as happens while all three numbers are being typed.
    if let Some(numbers) = turned.map(glam::DVec3::from).filter(|v| v.try_normalize().is_some()) {
        *normal = numbers;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_dragged_numbers_are_rounded() {
        let (before, now) = (4.0, 10.234_567);
        assert_eq!(kept(before, now, false, 0.2), now, "typed");
        assert_eq!(kept(before, now, true, 0.2), 10.2346);
        assert_eq!(kept(before, now, true, 0.0), now, "flat");
        assert_eq!(kept(now, now, true, 1000.0), now, "held and not moved");
        assert_eq!([1000.0, 0.02, 0.0].map(shown_decimals), [4, 5, 12]);
    }
}
