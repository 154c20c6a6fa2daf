//! The classes of the clouds: which are drawn, in which color, and how faint.

use egui::{Align, Button, Label, Layout, RichText, ScrollArea, Ui, vec2};

use super::clouds;
use super::row::{explained, note, opacity_slider, resets, three_digits};
use crate::controls::{ClassKey, ClassLook, class_changes, class_look, class_resets, opacity};
use crate::counts::{abbreviated, grouped};
use crate::model::Model;
use crate::statistics::Statistics;
use pellucid_core::color::{classes, decode_srgb_f64};
use pellucid_scene::{Change, CloudSettings, ColorBy, rounded};

/// Height of a list, in points; longer ones scroll on their own.
const ROOM: f32 = 300.0;

/// Width of the names, in points, beside sliders and without them.
const NAMES: [f32; 2] = [104.0, 170.0];

/// Width of the sliders, in points.
const SLIDER: f32 = 40.0;

/// Draws the section.
pub fn show(ui: &mut Ui, model: &mut Model) {
    let (settings, statistics) = (model.scene().clouds.clone(), model.statistics());
    let classified = settings
        .iter()
        .zip(statistics.iter())
        .enumerate()
        .filter(|(_, (_, statistics))| !statistics.classes.is_empty());
    for (i, (settings, statistics)) in classified {
        let several = model.scene().clouds.len() > 1;
        let line = colored_otherwise(settings, statistics);
        if several || line.is_some() {
            ui.horizontal(|ui| {
                if several {
                    ui.label(clouds::name(settings, i));
                }
                ui.weak(line.unwrap_or_default()).on_hover_text("a color set here overrides color_by");
            });
        }
        let area = ScrollArea::vertical().id_salt(("classes", i)).max_height(ROOM).auto_shrink([false, true]);
        area.show(ui, |ui| list(ui, model, i, settings, statistics));
    }
}

/// Says that the points have other colors than their classes, if so.
fn colored_otherwise(settings: &CloudSettings, statistics: &Statistics) -> Option<String> {
    let shown = match &settings.coloring.color_by {
        ColorBy::Auto => &statistics.auto,
        by => by,
    };
    match (settings.color, shown) {
        (Some(_), _) => Some("in one color".to_owned()),
        (None, ColorBy::Rgb) => Some("in the file's colors".to_owned()),
        (None, ColorBy::Auto | ColorBy::Classification) => None,
        (None, by) => Some(format!("colored by {}", by.word())),
    }
}

/// The classes that occur.
fn list(ui: &mut Ui, model: &mut Model, i: usize, settings: &CloudSettings, statistics: &Statistics) {
    for (code, count) in &statistics.classes {
        let changes = ui.horizontal(|ui| row(ui, model, i, settings, (*code, *count as u64))).inner;
        if let Some(changes) = changes {
            model.change(&changes);
        }
    }
}

/// A class with its controls; returns what was changed.
fn row(
    ui: &mut Ui,
    model: &mut Model,
    i: usize,
    settings: &CloudSettings,
    (code, count): (u8, u64),
) -> Option<Vec<Change>> {
    ui.spacing_mut().item_spacing.x = 5.0;
    let look = class_look(&settings.class, code);
    let blended = clouds::are_blended(model.scene());
    let change = |key| class_changes(i, &settings.class, code, key);
    let mut changes = eye(ui, model, i, code, look).map(change);
    changes = color(ui, code, look).map(change).or(changes);
    let [narrow, wide] = NAMES;
    let name = classes::label(code);
    let exactly = format!("{name}, class {code}, {} points", grouped(count));
    let text = RichText::new(name).size(11.5);
    let text = if look.visible { text } else { text.weak() };
    column(ui, if blended { narrow } else { wide }, &text, &exactly);
    column(ui, 32.0, &RichText::new(abbreviated(count)).weak().size(11.0), &exactly);
    if blended {
        changes = faintness(ui, model, i, settings, code).map(change).or(changes);
    }
    let opened = model.opened_scene().clouds.get(i).map(|cloud| cloud.class.clone()).unwrap_or_default();
    if look != class_look(&opened, code) && resets(ui, model, &format!("cloud.{i}.class.{code}")) {
        changes = Some(class_resets(i, &settings.class, &opened, code));
    }
    changes
}

/// The switch of a class.
fn eye(ui: &mut Ui, model: &mut Model, i: usize, code: u8, look: ClassLook) -> Option<ClassKey> {
    let symbol = RichText::new("👁").size(16.0);
    let symbol = if look.visible { symbol.strong() } else { symbol.weak().strikethrough() };
    let response = ui.add(Button::new(symbol).frame(false).min_size(vec2(20.0, 0.0)));
    let response = note(model, &format!("cloud.{i}.class.{code}.visible"), response);
    let response = response.on_hover_text(if look.visible { "is drawn" } else { "is not drawn" });
    response.clicked().then_some(ClassKey::Visible(!look.visible))
}

/// The color of a class: its own, or that of the standard.
fn color(ui: &mut Ui, code: u8, look: ClassLook) -> Option<ClassKey> {
    let standard = || classes::srgb(code).to_array().map(|x| decode_srgb_f64(x) as f32);
    let mut rgb = look.color.map_or_else(standard, |color| color.to_array());
    let response = ui.scope(|ui| {
        ui.spacing_mut().interact_size.x = 20.0;
        ui.color_edit_button_rgb(&mut rgb)
    });
    let response = response.inner;
    let rounded = || rgb.map(|x| (f64::from(x.clamp(0.0, 1.0)) * 1e4).round() / 1e4);
    response.changed().then(|| ClassKey::Color(rounded()))
}

/// The opacity of a class: its own, or the cloud's.
fn faintness(ui: &mut Ui, model: &mut Model, i: usize, settings: &CloudSettings, code: u8) -> Option<ClassKey> {
    let look = class_look(&settings.class, code);
    let mut value = rounded(look.opacity.unwrap_or(opacity(settings).1));
    ui.spacing_mut().slider_width = SLIDER;
    ui.spacing_mut().interact_size.x = 36.0;
    let response = ui.add_enabled(look.visible, opacity_slider(&mut value));
    let response = note(model, &format!("cloud.{i}.class.{code}.opacity"), response);
    let about = match look.opacity {
        Some(_) => "opacity of this class, in place of the cloud's",
        None => "the cloud's opacity; move to give the class its own",
    };
    let response = explained(response, about);
    response.changed().then(|| ClassKey::Opacity(three_digits(value)))
}

/// Text in a column of this width, in two lines if it is longer.
fn column(ui: &mut Ui, width: f32, text: &RichText, hint: &str) {
    let layout = Layout::left_to_right(Align::Center);
    let response = ui.allocate_ui_with_layout(vec2(width, 16.0), layout, |ui| {
        ui.set_min_width(width);
        ui.add(Label::new(text.clone()).wrap().selectable(false))
    });
    response.inner.on_hover_text(hint);
}

#[cfg(test)]
mod tests {
    use super::*;
    use pellucid_scene::ColorSettings;

    #[test]
    fn other_colors_than_those_of_classes_are_said() {
        let line = |by: ColorBy, auto: ColorBy| {
            let coloring = ColorSettings { color_by: by, ..ColorSettings::default() };
            let settings = CloudSettings { coloring, ..CloudSettings::default() };
            colored_otherwise(&settings, &Statistics { colors: true, auto, ..Statistics::default() })
        };
        for (auto, wanted) in [
            (ColorBy::Rgb, Some("in the file's colors")),
            // Though the file has colors, all black or all white.
            (ColorBy::Classification, None),
            (ColorBy::Height, Some("colored by height")),
            (ColorBy::Auto, None),
        ] {
            assert_eq!(line(ColorBy::Auto, auto).as_deref(), wanted);
        }
        assert_eq!(line(ColorBy::Intensity, ColorBy::Rgb).as_deref(), Some("colored by intensity"));
        let red = CloudSettings { color: Some(glam::Vec3::X), ..CloudSettings::default() };
        assert_eq!(colored_otherwise(&red, &Statistics::default()).as_deref(), Some("in one color"));
    }

    #[test]
    fn counts_are_short() {
        let counts = [0, 999, 1_250, 12_345, 512_000, 1_234_567, 98_765_432].map(abbreviated);
        assert_eq!(counts, ["0", "999", "1.2k", "12k", "512k", "1.2M", "99M"]);
    }
}
