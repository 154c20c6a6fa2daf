//! The overlay on the picture: times of the passes, counts of the frame, reasons for its passes, and the keys.

use std::time::Duration;

use bytesize::ByteSize;
use egui::{Align2, Area, Color32, Context, Frame, Grid, Id, Label, RichText, Sense, Ui, Window, vec2};
use egui_plot::{Bar, BarChart, Plot};

use super::accuracy::{Accuracy, Exactness, Reference};
use super::messages::WindowPicture;
use super::model::{Model, Passes};
use super::times::{HISTORY, Medians};

const BLUE: Color32 = Color32::from_rgb(110, 170, 255);

/// Interval at which a waiting window checks the progress of the points.
const GLANCE: Duration = Duration::from_millis(250);

/// Keyboard and pointer actions.
const KEYS: &[(&str, &str)] = &[
    ("left drag", "turn about the pivot"),
    ("right drag, middle drag, Shift + left drag", "move the picture"),
    ("wheel", "move toward or away from the point under the pointer"),
    ("double click", "turn about the point under the pointer"),
    ("W A S D, Q E", "fly ahead, left, back, right; down, up"),
    ("1 … 7", "view from the front, back, left, right, top, bottom, iso"),
    ("Home", "show everything"),
    ("K", "add the camera to the path as a key"),
    ("Space", "play or stop the path"),
    ("P", "switch between perspective and orthographic"),
    ("T", "pass times: sum, each, or none"),
    ("H", "show or hide the panel"),
    ("F11", "switch full screen on or off"),
    ("F12", "save the picture and its scene"),
    ("Ctrl + Z", "undo the last change of the scene or the path"),
    ("Ctrl + Shift + Z, Ctrl + Y", "do it again"),
    ("Ctrl + O", "open a scene, clouds or a camera path"),
    ("Ctrl + S, Ctrl + Shift + S", "save the scene, save it as…"),
    ("Ctrl + K", "save the path"),
    ("Ctrl + Q", "close"),
    ("F1", "show these keys"),
];

/// Draws what is asked for.
pub fn show(ctx: &Context, model: &mut Model) {
    if let Some(medians) = model.times.medians().filter(|_| model.shows.passes != Passes::Hidden) {
        let at = Area::new(Id::new("passes")).anchor(Align2::LEFT_TOP, [8.0, 8.0]);
        at.show(ctx, |ui| frame().show(ui, |ui| times(ui, model, &medians)));
    }
    if let Some(line) = model.line_without_picture() {
        let at = Area::new(Id::new("first picture")).anchor(Align2::CENTER_CENTER, [0.0, 0.0]).interactable(false);
        at.show(ctx, |ui| ui.add(Label::new(RichText::new(line).size(16.0)).extend()));
    }
    waiting(ctx, model);
    let mut help = model.shows.help;
    Window::new("Keys").open(&mut help).anchor(Align2::CENTER_CENTER, [0.0, 0.0]).resizable(false).show(ctx, |ui| {
        Grid::new("keys").num_columns(2).striped(true).show(ui, |ui| {
            for (key, does) in KEYS {
                ui.strong(*key);
                ui.label(*does);
                ui.end_row();
            }
        });
    });
    model.shows.help = help;
}

/// The work on points that precedes the next picture, shown if it takes long enough to be read; else how much of its
/// clouds the picture holds, if not all.
fn waiting(ctx: &Context, model: &Model) {
    if model.is_waiting() {
        ctx.request_repaint_after(GLANCE);
    }
    if let Some(line) = model.progress_line().or_else(|| model.held_line()) {
        let at = Area::new(Id::new("progress")).anchor(Align2::LEFT_BOTTOM, [8.0, -8.0]).interactable(false);
        at.show(ctx, |ui| frame().show(ui, |ui| ui.add(Label::new(line).extend())));
    }
}

/// The ground of what lies over the picture.
pub fn frame() -> Frame {
    Frame::new().fill(Color32::from_black_alpha(200)).inner_margin(8.0).corner_radius(4.0)
}

/// The line with the sum, which unfolds what there is below it.
fn times(ui: &mut Ui, model: &mut Model, medians: &Medians) {
    let Medians { wall_ms, passes: rows, frames } = medians;
    let unfolded = model.shows.passes == Passes::List;
    let title = if unfolded {
        let total: f64 = rows.iter().map(|(_, ms)| ms).sum();
        format!("⏷ {wall_ms:.1} ms a frame, {total:.1} ms on the device")
    } else {
        format!("⏵ {wall_ms:.1} ms")
    };
    let of = match frames {
        1 => "of the last frame".to_owned(),
        _ => format!("medians of the last {frames} frames with the same method and draft"),
    };
    let title = Label::new(RichText::new(title).strong()).extend().selectable(false).sense(Sense::click());
    let response =
        ui.add(title).on_hover_text(format!("{of}; click or press T to show each pass, T again to hide them"));
    if unfolded {
        passes(ui, model, rows);
    }
    if response.clicked() {
        model.shows.passes = if unfolded { Passes::Total } else { Passes::List };
    }
}

fn passes(ui: &mut Ui, model: &Model, rows: &[(&'static str, f64)]) {
    ui.set_width(330.0);
    ui.spacing_mut().interact_size.y = 15.0;
    strip(ui, model);
    let most = rows.iter().map(|(_, ms)| *ms).fold(f64::MIN_POSITIVE, f64::max);
    // At any window height the lines below must stay visible.
    let height = (ui.ctx().content_rect().height() - 260.0).clamp(60.0, 400.0);
    egui::ScrollArea::vertical().max_height(height).show(ui, |ui| {
        Grid::new("passes").num_columns(3).spacing([8.0, 1.0]).show(ui, |ui| {
            for (name, ms) in rows {
                ui.label(RichText::new(*name).monospace().size(11.0));
                ui.label(RichText::new(format!("{ms:8.2} ms")).monospace().size(11.0));
                bar(ui, (ms / most) as f32);
                ui.end_row();
            }
        });
    });
    if let Some(picture) = model.picture() {
        facts(ui, picture);
        accuracy(ui, picture);
        plan(ui, picture);
    }
}

/// A bar as long as a share of the longest one.
fn bar(ui: &mut Ui, share: f32) {
    let (room, _) = ui.allocate_exact_size(vec2(100.0, 9.0), Sense::hover());
    let filled = room.with_max_x(room.left() + share.clamp(0.0, 1.0) * room.width());
    ui.painter().rect_filled(filled, 1.0, BLUE);
}

/// Returns a plot from 0 to `most` that the pointer does not move.
pub fn still_plot(id: &str, height: f32, most: f64) -> Plot<'static> {
    let plot = Plot::new(id.to_owned()).height(height).include_x(0.0).include_x(most).include_y(0.0).show_grid(false);
    plot.allow_drag(false).allow_zoom(false).allow_scroll(false).allow_boxed_zoom(false).show_x(false)
}

/// The strip chart of the last frames.
fn strip(ui: &mut Ui, model: &Model) {
    let walls = model.times.walls();
    let start = HISTORY.saturating_sub(walls.len());
    let bars = walls.enumerate().map(|(i, ms)| Bar::new((start + i) as f64, ms).width(1.0)).collect();
    let chart = BarChart::new("frame", bars).color(BLUE);
    let plot = still_plot("frames", 60.0, HISTORY as f64).show_axes([false, true]).y_axis_min_width(32.0);
    plot.set_margin_fraction([0.0, 0.05].into()).show(ui, |plot| plot.bar_chart(chart));
}

fn facts(ui: &mut Ui, picture: &WindowPicture) {
    let facts = &picture.facts;
    let mut lines = vec![format!("{} splats in the picture", facts.visible)];
    if facts.fragments > 0 {
        lines.push(format!("{} fragments, the longest list {}", facts.fragments, facts.max_list));
    }
    let steps = [(facts.samples, "samples per pixel"), (facts.ensembles, "ensembles"), (facts.layers, "layers")];
    lines.extend(steps.iter().filter(|(count, _)| *count > 0).map(|(count, of)| format!("{count} {of}")));
    lines.push(format!("device memory {}, {} band(s)", ByteSize(facts.peak_device_bytes), facts.bands));
    for line in lines {
        ui.label(RichText::new(line).size(11.5));
    }
}

/// The accuracy of the picture so far, and of the drafts before it.
fn accuracy(ui: &mut Ui, picture: &WindowPicture) {
    let accuracy = &picture.accuracy;
    ui.separator();
    ui.label(RichText::new(now(picture)).strong().size(11.5)).on_hover_text(
        "Errors are of linear color, root mean square over all pixels. A standard error is estimated from the spread of \
         samples or ensembles; an RMSE is measured against the named picture.",
    );
    if accuracy.refinements.iter().all(|refinement| refinement.rmse.is_none()) {
        return;
    }
    let against = match accuracy.against {
        Some(Reference::Exact(method)) => format!("RMSE to {method}"),
        _ => "RMSE to whole".to_owned(),
    };
    let small = |text: &str| RichText::new(text).monospace().size(11.0);
    Grid::new("accuracy").num_columns(3).spacing([8.0, 1.0]).show(ui, |ui| {
        ["picture", "ms", &against].into_iter().for_each(|head| drop(ui.label(small(head).weak())));
        ui.end_row();
        for refinement in &accuracy.refinements {
            ui.label(small(&refinement.name));
            ui.label(small(&format!("{:.1}", refinement.ms)));
            ui.label(small(&refinement.rmse.map_or_else(|| "–".to_owned(), |rmse| format!("{rmse:.5}"))));
            ui.end_row();
        }
    });
}

/// Returns a sentence on the current picture.
fn now(picture: &WindowPicture) -> String {
    let Accuracy { refinements, against, exactness } = &picture.accuracy;
    let last = refinements.last();
    let standard_error = last.and_then(|refinement| refinement.standard_error);
    let rmse = last.and_then(|refinement| refinement.rmse);
    let labeled = |error: f64| format!("standard error {error:.5}");
    match (exactness, against, standard_error) {
        _ if !picture.whole => {
            let suffix = standard_error.map(|error| format!(", {}", labeled(error))).unwrap_or_default();
            format!("draft: {}{suffix}", picture.draft)
        }
        (Some(Exactness::Exact), ..) => format!("exact: {} differs only by rounding", picture.method),
        (Some(Exactness::Approximation(_)), Some(Reference::Exact(exact)), _) if rmse.is_some() => {
            format!("RMSE {:.5} against {exact}, which is exact", rmse.unwrap_or_default())
        }
        (.., Some(error)) => labeled(error),
        (Some(Exactness::Approximation(exact)), ..) => {
            format!("an approximation of {}, measured at rest", exact.name())
        }
        _ => format!("whole, as {} draws it", picture.method),
    }
}

fn plan(ui: &mut Ui, picture: &WindowPicture) {
    ui.collapsing("Plan", |ui| {
        egui::ScrollArea::vertical().max_height(200.0).show(ui, |ui| {
            for step in picture.plan.iter().filter(|step| step.on) {
                ui.label(RichText::new(step.name).monospace().size(11.0));
                ui.label(RichText::new(&step.reason).weak().size(11.0));
            }
        });
    });
}
