//! Several files that are opened at once, or one that cannot be shown.

use super::*;

#[test]
fn files_that_are_opened_one_upon_the_other_are_waited_for() {
    let (mut model, now) = settled();
    let document = |name: &str| Box::new(Document::from_clouds([name], &Overrides::default()).unwrap());
    model.open(vec!["b.ply".into()]);
    model.open(vec!["c.ply".into(), "flight.json".into()]);
    assert_eq!(std::iter::from_fn(|| model.next_task(now)).count(), 3);
    // What is saved now would have the clouds of another scene.
    model.save(true);
    assert!(
        model.next_task(now).is_none() && model.message.as_ref().is_some_and(|(text, _)| text.contains("not saved"))
    );
    // The clouds of this one are gone already when its picture could be asked for.
    model.take_in(News::Opened("b.ply".into(), document("b.ply"))).unwrap();
    assert!(model.busy && asked(&mut model, now).is_none());
    model.take_in(News::Opened("c.ply".into(), document("c.ply"))).unwrap();
    assert!(model.busy && asked(&mut model, now).is_none());
    model.take_in(News::Failed(0, "flight.json: no such file".into())).unwrap();
    assert!(!model.busy && asked(&mut model, now).is_some());
    // What waits for the worker when a scene comes goes to it then.
    model.open(vec!["d.ply".into()]);
    model.next_task(now);
    model.open(vec!["e.ply".into()]);
    model.take_in(News::Opened("d.ply".into(), document("d.ply"))).unwrap();
    assert!(matches!(model.next_task(now), Some(Task::Open(files)) if files == [Path::new("e.ply")]));
    assert!(model.busy && model.next_task(now).is_none());
}
