//! Keyboard actions, without a window: egui accepts input from anywhere.

use egui::{Context, Event, Key, Modifiers, RawInput};

use super::*;
use pellucid_viewer::pointer;

/// A frame in which keys went down or up, with these modifiers at its end.
fn frame(ctx: &Context, model: &mut Model, keys: &[(Key, bool, Modifiers)], modifiers: Modifiers) {
    let event = |(key, pressed, modifiers)| Event::Key { key, physical_key: None, pressed, repeat: false, modifiers };
    let input = RawInput { events: keys.iter().copied().map(event).collect(), modifiers, ..RawInput::default() };
    let _ = ctx.run(input, |ctx| {
        pointer::keys(ctx, model);
    });
}

#[test]
fn a_key_of_a_shortcut_moves_nothing_however_long_it_is_held() {
    let (mut model, _) = settled();
    let (ctx, none) = (Context::default(), Modifiers::NONE);
    let before = model.navigator();
    // A hand lets go of the modifier first, within the same frame.
    frame(&ctx, &mut model, &[(Key::S, true, Modifiers::CTRL)], none);
    assert!(model.busy, "it saves");
    frame(&ctx, &mut model, &[], none);
    assert_eq!(model.navigator(), before);
    frame(&ctx, &mut model, &[(Key::S, false, none)], none);
    frame(&ctx, &mut model, &[], none);
    assert_eq!(model.navigator(), before);
    // The key alone flies; a modifier pressed later stops it.
    frame(&ctx, &mut model, &[(Key::S, true, none)], none);
    let moved = model.navigator();
    assert_ne!(moved, before);
    frame(&ctx, &mut model, &[], Modifiers::SHIFT);
    assert_eq!(model.navigator(), moved);
}

#[test]
fn keys_make_and_play_a_path() {
    let (mut model, _) = settled();
    let (ctx, none) = (Context::default(), Modifiers::NONE);
    let press = |model: &mut Model, key, modifiers| {
        frame(&ctx, model, &[(key, true, modifiers), (key, false, modifiers)], none);
    };
    for count in 1..=3 {
        press(&mut model, Key::K, none);
        assert_eq!(model.route.keys().len(), count);
        model.navigate(|navigator| navigator.pan(DVec2::X, 48.0));
    }
    press(&mut model, Key::K, Modifiers::CTRL);
    assert!(model.busy && model.route.keys().len() == 3);
    assert!(matches!(model.next_task(Instant::now()), Some(Task::Save(saving)) if saving.path.is_some()));
    press(&mut model, Key::Space, none);
    assert!(model.route.is_playing());
    press(&mut model, Key::Space, none);
    assert!(!model.route.is_playing());
    // While files are being written no others are requested, and an open dialog receives all keys.
    press(&mut model, Key::O, Modifiers::CTRL);
    assert!(!model.dialog.is_open());
    model.busy = false;
    press(&mut model, Key::O, Modifiers::CTRL);
    assert!(model.dialog.is_open());
    press(&mut model, Key::K, none);
    assert_eq!(model.route.keys().len(), 3);
}
