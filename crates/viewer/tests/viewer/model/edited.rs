//! Edits of the scene by the panel.

use super::*;
use crate::controls::ends;
use pellucid_engine::passes::project::Parts;
use pellucid_scene::{DiscShape, METHODS, Shells, method_keys};
use pellucid_viewer::controls::{self, ControlExtent};
use pellucid_viewer::statistics::{FieldFacts, Statistics};

fn word(word: &str) -> Setting {
    Setting::Word(word.to_owned())
}

/// Every change requests a picture at once, even while another one is being rendered; an invalid change requests none.
#[test]
fn every_change_asks_for_a_picture() {
    let (mut model, _) = settled();
    let asks = |model: &mut Model| asked(model, Instant::now()).map(|request| request.scene.method.representative());
    model.set("method.name", word("soft-express"));
    assert!(asks(&mut model).is_some_and(|method| method.soft().is_some()));
    let give = |model: &mut Model, key: &str, value| {
        let method = model.scene().method;
        model.change(&controls::method_changes(&method.representative(), key, value));
    };
    for (key, value) in [("lambda", 0.25), ("softness", 0.5), ("modulation", 0.75), ("threshold", 0.25)] {
        give(&mut model, key, Some(Setting::Number(value)));
        assert_eq!((asks(&mut model), &model.message), (Some(model.scene().method.representative()), &None), "{key}");
    }
    give(&mut model, "shells", Some(Setting::Integer(9)));
    assert!(asks(&mut model).is_some_and(|method| method.soft().unwrap().shells == Shells::Fixed(9)));
    assert!(model.is_given("method.shells"));
    give(&mut model, "shells", None);
    assert!(asks(&mut model).is_some_and(|method| method.soft().unwrap().shells == Shells::Adaptive));
    assert!(!model.is_given("method.shells"));
    // All or nothing.
    let before = model.scene().clone();
    let half = Some(Setting::Number(0.5));
    model.change(&[("cloud.*.opacity".into(), half), ("method.softness".into(), Some(Setting::Number(7.0)))]);
    assert_eq!(asks(&mut model), None);
    assert_eq!(model.scene(), &before);
    assert!(model.message.as_ref().is_some_and(|(text, wrong)| *wrong && text.contains("softness")));
}

/// Changes from every method to every other one, with the least and the largest value of all of the first one's keys.
#[test]
fn every_method_can_be_chosen_from_every_other() {
    let mut model = model();
    let end = |control, last: bool| {
        let ends = ends(control);
        ends[if last { ends.len() - 1 } else { 0 }].clone()
    };
    for first in METHODS {
        for last in [false, true] {
            model.set_method(first);
            for key in method_keys(first) {
                let method = model.scene().method;
                let control = controls::method(&method.representative(), key, model.extent()).unwrap().control;
                model.change(&controls::method_changes(&method.representative(), key, Some(end(control, last))));
            }
            let edited = model.document_as_shown().unwrap();
            for second in METHODS {
                model.set_method(second);
                assert_eq!((model.scene().method.name(), &model.message), (*second, &None), "from {first}");
                model.take_in(News::Opened("s.toml".into(), Box::new(edited.clone()))).unwrap();
            }
        }
    }
}

#[test]
fn values_of_another_method_make_room() {
    let mut model = model();
    model.set_method("peel");
    model.set("method.layers", Setting::Integer(0));
    model.set("method.shape", word("oriented"));
    // Peeling points has no "all layers"; keys that both methods share stay.
    model.set_method("peel-layers");
    assert!(matches!(model.scene().method.fixed(), Some(Method::PeelLayers(layers)) if layers.layers == 4));
    model.set_method("sorted");
    assert!(model.scene().method.representative().discs().is_some_and(|discs| discs.shape == DiscShape::Oriented));
    model.set_method("nonsense");
    assert!(model.message.as_ref().is_some_and(|(text, wrong)| *wrong && text.contains("nonsense")));
    assert_eq!(model.scene().method.name(), "sorted");
}

#[test]
fn statistics_of_clouds_and_points_come_with_the_news() {
    let (mut model, _) = settled();
    // The wall's box is a cube of 6.
    let diagonal = 6.0 * 3f64.sqrt();
    assert!((model.extent().diagonal - diagonal).abs() < 1e-9 && model.extent().median_radius == 0.0);
    assert_eq!(self::model().extent(), ControlExtent::default());
    assert!(model.statistics().is_empty());
    model.take_in(News::Clouds([Statistics { points: 7, ..Statistics::default() }].into())).unwrap();
    assert_eq!(model.statistics()[0].points, 7);
    model.set("method.name", word("soft-base"));
    let request = asked(&mut model, Instant::now()).unwrap();
    let News::Picture(mut shown) = picture(&request, true) else { panic!("a picture") };
    let parts = Parts { solid: 1, soft: 2, median_radius: 0.5, ends: Some([0.0, 1.0]) };
    shown.field = Some(FieldFacts { histogram: Arc::new([1, 2]), parts });
    model.take_in(News::Picture(shown)).unwrap();
    assert_eq!(model.extent().median_radius, 0.5);
    // Other clouds are not those.
    opened(&mut model, "b.ply");
    assert!(model.statistics().is_empty());
}
