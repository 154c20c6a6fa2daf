//! Pointer and keyboard actions on the picture.

use std::collections::HashSet;

use egui::{Context, Event, Id, Key, Modifiers, PointerButton, Rect, Response, Sense, Ui};
use glam::{DVec2, DVec3};

use super::model::{Model, Viewport};
use super::navigate::Navigator;
use super::panel::VIEWS;
use pellucid_scene::View;

/// Points of the wheel for a factor of e.
const WHEEL: f64 = 300.0;

/// The picture's place in the window: reacts to the pointer.
pub fn picture(ui: &mut Ui, model: &mut Model) {
    let (rect, scale) = (ui.max_rect(), f64::from(ui.ctx().pixels_per_point()));
    model.set_viewport(viewport(rect, scale));
    let response = ui.interact(rect, ui.id().with("picture"), Sense::click_and_drag());
    drag(&response, model, scale);
    let local = |at: egui::Pos2| {
        let at = at - rect.min;
        DVec2::new(f64::from(at.x), f64::from(at.y)) * scale
    };
    if let Some(at) = response.interact_pointer_pos().filter(|_| response.double_clicked()) {
        model.pivot_at(local(at));
    }
    if let Some(at) = response.hover_pos() {
        let wheel = f64::from(ui.input(|input| input.smooth_scroll_delta.y));
        if wheel != 0.0 {
            model.zoom_at(local(at), (-wheel / WHEEL).exp());
        }
    }
}

fn viewport(rect: Rect, scale: f64) -> Viewport {
    let px = |x: f32| (f64::from(x.max(0.0)) * scale).round() as u32;
    let (at, end) = ([px(rect.left()), px(rect.top())], [px(rect.right()), px(rect.bottom())]);
    Viewport { at, size: [end[0].saturating_sub(at[0]), end[1].saturating_sub(at[1])] }
}

/// Turns or moves the picture by the pointer's movement since it was pressed or last seen, even if several events fell
/// between two frames.
fn drag(response: &Response, model: &mut Model, scale: f64) {
    let (pressed, now, shift) =
        response.ctx.input(|input| (input.pointer.press_origin(), input.pointer.latest_pos(), input.modifiers.shift));
    if response.drag_started() {
        model.grabbed = pressed.map(<[f32; 2]>::from);
    }
    let buttons = [PointerButton::Primary, PointerButton::Secondary, PointerButton::Middle];
    let dragged = buttons.into_iter().find(|button| response.dragged_by(*button) || response.drag_stopped_by(*button));
    let (Some(button), Some(from), Some(to)) = (dragged, model.grabbed, now) else { return };
    model.grabbed = (!response.drag_stopped()).then_some(to.into());
    let delta = DVec2::new(f64::from(to.x - from[0]), f64::from(to.y - from[1])) * scale;
    let height = f64::from(model.viewport().size[1]);
    model.navigate(|navigator| match button {
        PointerButton::Primary if !shift => navigator.orbit(delta, height),
        _ => navigator.pan(delta, height),
    });
}

/// Lets the changes between a press and its release be one step of undo: a drag, or a key that is held.
fn divide_steps(ctx: &Context, model: &mut Model) {
    let (begins, goes_on) = ctx.input(|input| {
        let is_press = |event: &Event| matches!(event, Event::Key { pressed: true, repeat: false, .. });
        let is_release = |event: &Event| matches!(event, Event::Key { pressed: false, .. });
        let (pointer, any) = (&input.pointer, |is: &dyn Fn(&Event) -> bool| input.events.iter().any(is));
        let is_held = pointer.any_down() || !input.keys_down.is_empty();
        // The last change of a drag comes with the release.
        (pointer.any_pressed() || any(&is_press), is_held || pointer.any_released() || any(&is_release))
    });
    if begins || !goes_on {
        model.end_step();
    }
}

/// Handles the keys. Returns true if they ask to close the window.
pub fn keys(ctx: &Context, model: &mut Model) -> bool {
    note_shortcuts(ctx);
    divide_steps(ctx, model);
    if ctx.wants_keyboard_input() || model.dialog.is_open() {
        return false;
    }
    let pressed = |modifiers, key| ctx.input_mut(|input| input.consume_key(modifiers, key));
    if pressed(Modifiers::CTRL | Modifiers::SHIFT, Key::S) && !model.busy {
        model.ask_where_to_save();
    }
    if pressed(Modifiers::CTRL, Key::S) && !model.busy {
        model.save(false);
    }
    if pressed(Modifiers::CTRL, Key::O) && !model.busy {
        model.dialog.open();
    }
    if pressed(Modifiers::CTRL | Modifiers::SHIFT, Key::Z) || pressed(Modifiers::CTRL, Key::Y) {
        model.redo();
    }
    if pressed(Modifiers::CTRL, Key::Z) {
        model.undo();
    }
    path_keys(&pressed, model);
    let close = pressed(Modifiers::CTRL, Key::Q);
    if pressed(Modifiers::NONE, Key::F12) && !model.busy {
        model.save(true);
    }
    let shows = &mut model.shows;
    shows.help ^= pressed(Modifiers::NONE, Key::F1);
    shows.panel ^= pressed(Modifiers::NONE, Key::H);
    let presses = ctx.input_mut(|input| input.count_and_consume_key(Modifiers::NONE, Key::T));
    shows.passes = shows.passes.after(presses);
    if pressed(Modifiers::NONE, Key::P) {
        model.navigate(Navigator::toggle_projection);
    }
    if pressed(Modifiers::NONE, Key::Home) {
        model.look_from(View::default());
    }
    let digits = [Key::Num1, Key::Num2, Key::Num3, Key::Num4, Key::Num5, Key::Num6, Key::Num7];
    for (key, (name, ..)) in digits.into_iter().zip(VIEWS) {
        if pressed(Modifiers::NONE, key) {
            model.look_from(View { name: Some(*name), ..View::default() });
        }
    }
    fly(ctx, model);
    close
}

/// Handles the keys that edit the path.
fn path_keys(pressed: &impl Fn(Modifiers, Key) -> bool, model: &mut Model) {
    if pressed(Modifiers::CTRL, Key::K) && !model.busy {
        model.save_path();
    }
    if pressed(Modifiers::NONE, Key::K) {
        model.add_key();
    }
    if pressed(Modifiers::NONE, Key::Space) {
        model.play();
    }
}

/// Runs on along the path, if the camera runs.
pub fn play(ctx: &Context, model: &mut Model) {
    if model.route.is_playing() {
        // A frame longer than half a second is not part of the motion.
        model.tick(f64::from(ctx.input(|input| input.stable_dt.min(0.5))));
        ctx.request_repaint();
    }
}

/// Keys that went down with a modifier and are still down. They belong to a shortcut even if the modifier is released
/// first.
type Shortcuts = HashSet<Key>;

fn shortcuts() -> Id {
    Id::new("keys of shortcuts")
}

fn note_shortcuts(ctx: &Context) {
    let mut keys: Shortcuts = ctx.data(|data| data.get_temp(shortcuts())).unwrap_or_default();
    ctx.input(|input| {
        for event in &input.events {
            match event {
                Event::Key { key, pressed: false, .. } => keys.remove(key),
                Event::Key { key, modifiers, repeat: false, .. } if modifiers.any() => keys.insert(*key),
                _ => false,
            };
        }
    });
    ctx.data_mut(|data| data.insert_temp(shortcuts(), keys));
}

fn fly(ctx: &Context, model: &mut Model) {
    let shortcuts: Shortcuts = ctx.data(|data| data.get_temp(shortcuts())).unwrap_or_default();
    let (direction, seconds) = ctx.input(|input| {
        let down = |key| f64::from(input.key_down(key) && !shortcuts.contains(&key));
        let axis = |ahead, back| down(ahead) - down(back);
        let direction = DVec3::new(axis(Key::D, Key::A), axis(Key::E, Key::Q), axis(Key::W, Key::S));
        // A key that was pressed since the last frame has flown for no more than one of them.
        (if input.modifiers.any() { DVec3::ZERO } else { direction }, f64::from(input.stable_dt.min(0.1)))
    });
    if direction != DVec3::ZERO {
        model.navigate(|navigator| navigator.fly(direction, seconds));
        ctx.request_repaint();
    }
}
