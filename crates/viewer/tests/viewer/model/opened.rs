//! Several files that are opened at once, or one that cannot be shown; what was saved, and what is asked for with a
//! picture.

use super::*;

#[test]
fn files_that_are_opened_one_upon_the_other_are_waited_for() {
    let (mut model, now) = settled();
    model.open(vec!["b.ply".into()]);
    model.open(vec!["c.ply".into(), "flight.json".into()]);
    assert_eq!(std::iter::from_fn(|| model.next_task(now)).count(), 3);
    // Saving now would write the clouds of another scene.
    model.save(true);
    assert!(
        model.next_task(now).is_none() && model.message.as_ref().is_some_and(|(text, _)| text.contains("not saved"))
    );
    // The clouds of this one are gone already when its picture could be asked for.
    opened(&mut model, "b.ply");
    assert!(model.busy && asked(&mut model, now).is_none());
    opened(&mut model, "c.ply");
    assert!(model.busy && asked(&mut model, now).is_none());
    model.take_in(News::Failed(0, "flight.json: no such file".into())).unwrap();
    assert!(!model.busy && asked(&mut model, now).is_some());
    // Tasks that wait while a scene arrives are sent to the worker afterwards.
    model.open(vec!["d.ply".into()]);
    model.next_task(now);
    model.open(vec!["e.ply".into()]);
    opened(&mut model, "d.ply");
    assert!(matches!(model.next_task(now), Some(Task::Open(files)) if files == [Path::new("e.ply")]));
    assert!(model.busy && model.next_task(now).is_none());
}

#[test]
fn a_scene_without_a_picture_does_not_promise_one() {
    let mut model = model();
    let request = asked(&mut model, Instant::now()).unwrap();
    assert!(model.line_without_picture().unwrap().contains("rendering the first picture"));
    model.take_in(News::Failed(request.serial, "no property `height`".into())).unwrap();
    assert!(model.line_without_picture().unwrap().contains("no picture"));
    // Another setting may have one, and then nothing is wrong any more.
    model.navigate(|_| ());
    model.look_from(View::default());
    assert!(model.line_without_picture().unwrap().contains("rendering the first picture"));
    shown(&mut model);
    assert_eq!((model.line_without_picture(), &model.message), (None, &None));
    // Other messages stay.
    model.look_from(View::default());
    let request = asked(&mut model, Instant::now()).unwrap();
    model.take_in(News::Failed(request.serial, "too many points".into())).unwrap();
    model.message = Some(("something else".into(), true));
    model.look_from(View::default());
    shown(&mut model);
    assert_eq!(model.message, Some(("something else".into(), true)));
}

/// The panel may leave no room for the picture, and pictures of no size are no scene.
#[test]
fn a_window_without_room_for_a_picture_saves_none() {
    let (mut model, now) = settled();
    model.add_key();
    while model.next_task(now).is_some() {}
    model.set_viewport(Viewport { at: [0, 0], size: [0, 48] });
    for save in [|model: &mut Model| model.save(true), Model::save_path] {
        model.message = None;
        save(&mut model);
        assert!(model.next_task(now).is_none() && !model.busy && model.message.is_some());
    }
}

/// The whole names of saved files stay until others are saved, whatever else is said or opened.
#[test]
fn saved_files_are_named_until_others_are_saved() {
    let (mut model, now) = settled();
    let here = std::env::current_dir().unwrap();
    model.take_in(News::Saved(vec!["s-1.toml".into(), "s-1.png".into()])).unwrap();
    let (said, _) = model.message.clone().unwrap();
    let saved = model.saved.clone().unwrap();
    assert_eq!((saved.files.clone(), &saved.command), (vec![here.join("s-1.toml"), here.join("s-1.png")], &None));
    assert!(saved.says(&said) && !saved.says("something else"), "{said}");
    model.set("cloud.0.opacity", Setting::Number(0.25));
    model.set("cloud.0.nonsense", Setting::Number(0.25));
    assert!(model.message.as_ref().is_some_and(|(_, wrong)| *wrong) && model.saved.as_ref() == Some(&saved));
    model.open(vec!["b.ply".into()]);
    while model.next_task(now).is_some() {}
    opened(&mut model, "b.ply");
    assert_eq!(model.saved, Some(saved));
    model.take_in(News::Saved(vec!["/x/b-1.toml".into(), "/x/b-1.json".into()])).unwrap();
    let saved = model.saved.unwrap();
    assert!(
        saved.files == [Path::new("/x/b-1.toml"), Path::new("/x/b-1.json")] && saved.command.is_some(),
        "{saved:?}"
    );
}

#[test]
fn dismissed_files_are_named_nowhere() {
    let (mut model, _) = settled();
    let saves = |model: &mut Model| model.take_in(News::Saved(vec!["s-1.toml".into()])).unwrap();
    saves(&mut model);
    assert!(model.message.is_some());
    model.dismiss_saved();
    assert_eq!((&model.saved, &model.message), (&None, &None));
    // Something else that was said since stays.
    saves(&mut model);
    model.set("cloud.0.nonsense", Setting::Number(0.25));
    let said = model.message.clone();
    model.dismiss_saved();
    assert!(said.is_some() && model.saved.is_none() && model.message == said);
}

/// The meaning of colors costs a look at all points, so that it is asked for only where it is shown, and then once.
#[test]
fn the_meaning_of_colors_is_asked_for_where_it_is_shown() {
    let (mut model, now) = settled();
    model.explain_colors();
    assert!(asked(&mut model, now).is_none());
    model.shows.colors = true;
    model.explain_colors();
    let request = asked(&mut model, now).unwrap();
    assert!(request.legend);
    model.explain_colors();
    assert!(asked(&mut model, now).is_none(), "it is on its way");
    model.take_in(picture(&request, true)).unwrap();
    model.explain_colors();
    assert!(asked(&mut model, now).is_none() && model.is_at_rest(now + REST));
    // Behind a hidden panel nobody reads it.
    model.shows.panel = false;
    model.set("cloud.0.opacity", Setting::Number(0.5));
    assert!(!asked(&mut model, now).unwrap().legend);
}

#[test]
fn t_goes_through_all_that_times_can_be() {
    let all = [Passes::Total, Passes::List, Passes::Hidden];
    for (i, passes) in all.into_iter().enumerate() {
        assert_eq!(
            [0, 1, 2, 3, 4].map(|presses| passes.after(presses)),
            [0, 1, 2, 0, 1].map(|step| all[(i + step) % 3])
        );
    }
}
