//! A control with its name, for a key of the scene file.

use egui::{Button, ComboBox, DragValue, Label, Response, RichText, Sense, Slider, SliderClamping, Ui};

use crate::controls::{self, Control, KeyControl, Presence, significant};
use crate::hints::hint;
use crate::model::Model;
use pellucid_scene::Setting;

/// Room at the end of a row for its button, in points.
const BUTTON: f32 = 20.0;

/// Room that a switch takes before a control, in points.
const SWITCH: f32 = 26.0;

/// An edit of a key.
#[derive(Debug, Clone, PartialEq)]
pub enum Edit {
    /// The key has this value now.
    Set(Setting),
    /// The key is removed.
    Remove,
    /// The key has the value of the scene that was opened.
    Reset,
}

/// A row that applies its own edits, if its key has a control. Returns true if its name was clicked.
pub fn row(ui: &mut Ui, model: &mut Model, key: &str, label: &str, entry: Option<KeyControl>) -> bool {
    let Some(entry) = entry else { return false };
    let (edit, clicked) = edit_row(ui, model, key, label, entry);
    match edit {
        Some(Edit::Set(value)) => model.set(key, value),
        Some(Edit::Remove) => model.set(key, None),
        Some(Edit::Reset) => model.reset(&[key]),
        None => {}
    }
    clicked
}

/// A control with its name and, if its key is not what it was in the scene that was opened, a button that makes it so;
/// records the control's position. Returns the edit, and true if the name was clicked.
pub fn edit_row(ui: &mut Ui, model: &mut Model, key: &str, label: &str, entry: KeyControl) -> (Option<Edit>, bool) {
    let is_changed = model.is_changed(key);
    edit_row_with(ui, model, key, label, entry, is_changed)
}

/// Does the same as [`edit_row`], with the button if `is_changed`.
pub fn edit_row_with(
    ui: &mut Ui,
    model: &mut Model,
    key: &str,
    label: &str,
    entry: KeyControl,
    is_changed: bool,
) -> (Option<Edit>, bool) {
    let KeyControl { control, value, presence, about } = entry;
    ui.horizontal(|ui| {
        if presence != Presence::Always {
            // Leave room for the switch, so that numbers align below each other.
            ui.spacing_mut().slider_width -= SWITCH;
        }
        let (on, mut edit) = switch(ui, model, key, &presence, &value, about);
        if on {
            let (response, changed) = change(ui, key, label, control, value);
            note(model, key, explained(response, about));
            edit = edit.or(changed.map(Edit::Set));
        }
        if let (Presence::Optional { without, .. }, false) = (&presence, on) {
            ui.weak(without);
        }
        let has_button = is_changed && presence == Presence::Always;
        let room = ui.available_width() - if has_button { BUTTON } else { 0.0 };
        let named = (control != Control::Flag).then(|| name_within(ui, about, label, room));
        if has_button && resets(ui, model, key) {
            edit = Some(Edit::Reset);
        }
        (edit, named.is_some_and(|name| name.clicked()))
    })
    .inner
}

/// The switch before a control, if it has one; whether it is on.
fn switch(
    ui: &mut Ui,
    model: &mut Model,
    key: &str,
    presence: &Presence,
    start: &Setting,
    about: &str,
) -> (bool, Option<Edit>) {
    let (mut on, radio) = match presence {
        Presence::Always => return (true, None),
        Presence::Optional { on, .. } => (*on, false),
        Presence::Rival { on } => (*on, true),
    };
    let was = on;
    let response = if radio { ui.radio(on, "") } else { ui.checkbox(&mut on, "") };
    let response = note(model, &format!("{key}?"), response);
    let clicked = if radio { response.clicked() && !was } else { response.changed() };
    explained(response, about);
    // Switched on again, it is as it was, but for methods, whose keys depend on each other, and for several clouds. The
    // scene that was opened may say that it is off.
    let returns = model.is_changed(key) && !key.starts_with("method.") && !key.contains('*') && model.opened_has(key);
    let on = if returns { Edit::Reset } else { Edit::Set(start.clone()) };
    let edit = if was { Edit::Remove } else { on };
    (was, clicked.then_some(edit))
}

/// The name of a row, as long as the row has room for it.
pub fn name(ui: &mut Ui, key: &str, label: &str) -> Response {
    let room = ui.available_width() - BUTTON;
    name_within(ui, hint(key), label, room)
}

fn name_within(ui: &mut Ui, about: &str, label: &str, room: f32) -> Response {
    let label = Label::new(label).truncate().selectable(false).sense(Sense::click());
    let shown = ui.scope(|ui| {
        ui.set_max_width(room.max(0.0));
        ui.add(label)
    });
    if about.is_empty() { shown.inner } else { shown.inner.on_hover_text(about) }
}

/// Explains a control while the pointer rests on it. While it is dragged, the explanation would hide what is below.
pub fn explained(response: Response, about: &str) -> Response {
    if response.ctx.input(|input| input.pointer.any_down()) { response } else { response.on_hover_text(about) }
}

/// The button that returns a key to the scene that was opened; keys with a switch have none. Returns true if it was
/// clicked.
pub fn resets(ui: &mut Ui, model: &mut Model, key: &str) -> bool {
    let button = Button::new(RichText::new("⟲").size(11.0)).frame(false);
    let response = ui.add(button).on_hover_text("return to the scene as it was opened");
    note(model, &format!("{key} default"), response).clicked()
}

/// Notes where a control is.
pub fn note(model: &mut Model, key: &str, response: Response) -> Response {
    let (rect, scale) = (response.rect, response.ctx.pixels_per_point());
    let place = [rect.left(), rect.top(), rect.width(), rect.height()].map(|x| (x * scale).round() as i32);
    model.controls.insert(key.to_owned(), place);
    response
}

fn change(ui: &mut Ui, key: &str, label: &str, control: Control, value: Setting) -> (Response, Option<Setting>) {
    let (response, changed) = match (control, value) {
        (Control::Slider(from, to), Setting::Number(mut x)) => {
            (ui.add(slider(&mut x, from, to).max_decimals(3).step_by(0.001)), Setting::Number(x))
        }
        (Control::Powers(from, to), Setting::Number(mut x)) => {
            let least = if from > 0.0 { from } else { 1e-5 * to };
            let slider = slider(&mut x, from, to).logarithmic(true).smallest_positive(least);
            (ui.add(slider.custom_formatter(|x, _| short(x))), Setting::Number(significant(x)))
        }
        (Control::Opacity, Setting::Number(mut x)) => {
            (ui.add(opacity_slider(&mut x)), Setting::Number(three_digits(x)))
        }
        (Control::Count(from, to), Setting::Integer(mut n)) => {
            let slider = Slider::new(&mut n, from..=to).logarithmic(to > 32).clamping(SliderClamping::Edits);
            (ui.add(slider.update_while_editing(false)), Setting::Integer(n))
        }
        (Control::OneOf(numbers), Setting::Integer(n)) => {
            let words: Vec<String> = numbers.iter().map(u32::to_string).collect();
            let (own, words) = (n.to_string(), words.iter().map(String::as_str).collect::<Vec<_>>());
            let (response, chosen) = choice(ui, key, &own, &words);
            return (response, chosen.and_then(|word| word.parse().ok()).map(Setting::Integer));
        }
        (Control::Flag, Setting::Flag(mut flag)) => (ui.checkbox(&mut flag, label), Setting::Flag(flag)),
        (Control::Choice(words), Setting::Word(word)) => {
            let words: Vec<&str> = words.iter().map(|word| word.name).collect();
            let (response, chosen) = choice(ui, key, &word, &words);
            return (response, chosen.map(Setting::from));
        }
        (Control::Color, Setting::Numbers(color)) => {
            let mut rgb: [f32; 3] = std::array::from_fn(|i| color.get(i).copied().unwrap_or_default() as f32);
            let response = ui.color_edit_button_rgb(&mut rgb);
            (response, rgb.map(|x| (f64::from(x.clamp(0.0, 1.0)) * 1e4).round() / 1e4).into())
        }
        // A control has the value that belongs to it.
        (_, other) => return (ui.weak(format!("{other:?}")), None),
    };
    let changed = response.changed().then_some(changed);
    (response, changed)
}

/// A slider of opacities. Small ones have as much room as large ones, because layers overlap.
pub fn opacity_slider(x: &mut f64) -> Slider<'_> {
    let slider = slider(x, 0.0, 1.0).logarithmic(true).smallest_positive(controls::FAINTEST);
    slider.custom_formatter(|x, _| short(x))
}

/// A number to three significant digits: what a slider's place says.
pub fn three_digits(x: f64) -> f64 {
    format!("{x:.2e}").parse().unwrap_or(x)
}

fn slider(x: &mut f64, from: f64, to: f64) -> Slider<'_> {
    Slider::new(x, from..=to).clamping(SliderClamping::Edits).update_while_editing(false)
}

/// A choice between words; returns the one that was chosen, if it changed.
pub fn choice<'a>(ui: &mut Ui, key: &str, word: &'a str, words: &[&'a str]) -> (Response, Option<&'a str>) {
    let mut chosen = word;
    let combo = ComboBox::from_id_salt(key).selected_text(word).width(110.0).truncate();
    let shown = combo.show_ui(ui, |ui| {
        for other in words {
            ui.selectable_value(&mut chosen, other, *other);
        }
    });
    (shown.response, (chosen != word).then_some(chosen))
}

/// A choice between words for the first of some keys with its name and, if one of the keys is not what it was in the
/// scene that was opened, a button that returns all of them to it. Returns the word that was chosen.
pub fn choice_row<'a>(
    ui: &mut Ui,
    model: &mut Model,
    keys: &[&str],
    label: &str,
    word: &'a str,
    words: &[&'a str],
) -> Option<&'a str> {
    let is_changed = keys.iter().any(|key| model.is_changed(key));
    let key = keys.first().copied().unwrap_or_default();
    let row = ui.horizontal(|ui| {
        let (response, chosen) = choice(ui, key, word, words);
        note(model, key, response);
        name(ui, key, label);
        if is_changed && resets(ui, model, key) {
            model.reset(keys);
            return None;
        }
        chosen
    });
    row.inner
}

/// Three numbers with a name; returns them if they changed.
pub fn vector(ui: &mut Ui, model: &mut Model, key: &str, vector: [f64; 3], speed: f64) -> Option<[f64; 3]> {
    let mut changed = vector;
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        let responses = changed.each_mut().map(|x| {
            let number = DragValue::new(x).speed(speed).max_decimals(4).update_while_editing(false);
            explained(ui.add_sized([70.0, 18.0], number), hint(key))
        });
        let [first, ..] = responses;
        note(model, key, first);
    });
    (changed != vector).then_some(changed)
}

/// A number to four significant digits, as short as possible.
fn short(x: f64) -> String {
    let x = significant(x);
    if x == 0.0 || (1e-3..1e5).contains(&x.abs()) { x.to_string() } else { format!("{x:e}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        for (x, wanted) in [(0.0, "0"), (0.012_345_6, "0.01235"), (1234.56, "1235"), (1.5e-7, "1.5e-7"), (2e9, "2e9")] {
            assert_eq!(short(x), wanted);
            // The displayed text can be typed again.
            assert_eq!(wanted.parse(), Ok(significant(x)));
        }
    }
}
