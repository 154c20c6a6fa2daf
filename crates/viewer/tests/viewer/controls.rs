//! Every key has a control, and every place of a control is a scene.

use pellucid_scene::{
    Change, Document, Key, Light, METHODS, Method, Overrides, Scene, Setting, Shadows, SoftLayout, method_keys, rounded,
};
use pellucid_viewer::controls::{
    self, Control, ControlExtent, KeyControl, Presence, cloud, entry, find, light_changes, method, method_changes,
    shadows, significant, thousandths,
};

const EXTENT: ControlExtent = ControlExtent { diagonal: 250.0, median_radius: 0.125 };

fn document(method: &str) -> Document {
    let text = format!("[[cloud]]\npath = 'a.ply'\n[method]\nname = '{method}'\n");
    Document::from_toml(&text, "s.toml".as_ref(), &Overrides::default()).unwrap()
}

/// Returns the least and the largest value of a control.
pub fn ends(control: Control) -> Vec<Setting> {
    match control {
        Control::Slider(from, to) | Control::Powers(from, to) => vec![Setting::Number(from), Setting::Number(to)],
        Control::Opacity => vec![Setting::Number(0.0), Setting::Number(1.0)],
        Control::Count(from, to) => vec![Setting::Integer(from), Setting::Integer(to)],
        Control::OneOf(numbers) => numbers.iter().copied().map(Setting::Integer).collect(),
        Control::Flag => vec![Setting::Flag(false), Setting::Flag(true)],
        Control::Choice(words) => words.iter().map(|word| Setting::Word(word.name.to_owned())).collect(),
        Control::Color => vec![Setting::Numbers(vec![0.0; 3]), Setting::Numbers(vec![1.0; 3])],
    }
}

/// A change of one key, and nothing else.
fn changes(key: &str, value: Option<Setting>) -> Vec<Change> {
    vec![(key.to_owned(), value)]
}

fn names(keys: &[Key]) -> Vec<&'static str> {
    keys.iter().map(|key| key.name).collect()
}

fn is_on(entry: &KeyControl) -> bool {
    match &entry.presence {
        Presence::Always => true,
        Presence::Optional { on, .. } | Presence::Rival { on } => *on,
    }
}

/// The scene of a saved file with these changes.
fn saved(document: &Document) -> Scene {
    let text = document.to_toml("".as_ref()).unwrap();
    Document::from_toml(&text, "s.toml".as_ref(), &Overrides::default()).unwrap().scene().unwrap()
}

/// Goes to both ends of a control and back: each is a scene that has the value and nothing else changed, saved too, and
/// without the key everything is as before.
fn moves(
    document: &Document,
    key: &str,
    entry: &dyn Fn(&Scene) -> KeyControl,
    give: &dyn Fn(Option<Setting>) -> Vec<Change>,
) {
    let before = document.scene().unwrap();
    let first = entry(&before);
    let mut changed = document.clone();
    let same = changed.change(&give(Some(first.value.clone()))).unwrap();
    assert_eq!(entry(&same).value, first.value, "{key}: as it begins");
    if is_on(&first) {
        assert_eq!((same.method, &same.clouds, same.shading), (before.method, &before.clouds, before.shading), "{key}");
    }
    for end in ends(first.control) {
        let scene = changed.change(&give(Some(end.clone()))).unwrap_or_else(|error| panic!("{key} = {end:?}: {error}"));
        let shown = entry(&scene);
        assert!(is_on(&shown) && shown.control == first.control, "{key} = {end:?}: {shown:?}");
        assert_eq!(entry(&saved(&changed)), shown, "{key} = {end:?} as saved");
        // Threshold and modulation alone stop at each other.
        if !matches!(key, "method.modulation" | "method.threshold") {
            assert_eq!(shown.value, end, "{key}");
        }
    }
    let scene = changed.change(&give(None)).unwrap();
    assert_eq!(entry(&scene), first, "{key} taken out");
    assert_eq!(scene, Scene { settings: scene.settings.clone(), ..before }, "{key}");
}

/// A key that a method gets can't be forgotten here, and a control shows the value that is in force.
#[test]
fn every_key_of_every_method_has_a_control_with_its_value() {
    for name in METHODS {
        let document = document(name);
        for key in method_keys(name) {
            let entry = |scene: &Scene| {
                method(&scene.method.representative(), key, EXTENT)
                    .unwrap_or_else(|| panic!("{name}: {key} has no control"))
            };
            let method = document.scene().unwrap().method.representative();
            moves(&document, &format!("method.{key}"), &entry, &|value| method_changes(&method, key, value));
        }
        assert_eq!(method(&document.scene().unwrap().method.representative(), "nonsense", EXTENT), None);
    }
}

#[test]
fn every_key_of_shading_and_shadows_has_a_control() {
    for light in ["[1, 2, -3]", "{ position = [1, 2, 3] }"] {
        let text = format!(
            "[[cloud]]\npath = 'a.ply'\n[method]\nname = 'points'\n[shadows]\n[shading]\nmodel = 'phong'\nlight = {light}"
        );
        let document = Document::from_toml(&text, "s.toml".as_ref(), &Overrides::default()).unwrap();
        let given = document.clone().scene().unwrap().shading;
        for key in names(&given.keys()).into_iter().filter(|key| *key != "light") {
            let dotted = format!("shading.{key}");
            let entry = |scene: &Scene| entry(&find(scene.shading.keys(), key).expect(key), EXTENT).expect(key);
            // The model of this scene is not the default.
            if key == "model" {
                let mut document = document.clone();
                for end in ends(entry(&document.scene().unwrap()).control) {
                    let scene = document.change(&changes(&dotted, Some(end.clone()))).unwrap();
                    assert_eq!(entry(&scene).value, end);
                }
            } else {
                moves(&document, &dotted, &entry, &|value| changes(&dotted, value));
            }
        }
        for key in names(&Shadows::default().keys()) {
            let dotted = format!("shadows.{key}");
            let entry = |scene: &Scene| shadows(&scene.shadows.unwrap(), given.light, key, EXTENT).expect(key);
            moves(&document, &dotted, &entry, &|value| changes(&dotted, value));
        }
    }
}

#[test]
fn clouds_have_their_controls() {
    let document = document("soft-base");
    let keys =
        ["opacity", "radius_factor", "color", "color_by", "colormap", "radius", "neighbors", "radius_cap", "outliers"];
    for key in keys {
        for target in ["cloud.0", "cloud.*"] {
            let dotted = format!("{target}.{key}");
            let entry = |scene: &Scene| cloud(&scene.clouds[0], key, false, Some(12), EXTENT).expect(key);
            moves(&document, &dotted, &entry, &|value| changes(&dotted, value));
        }
    }
}

#[test]
fn threshold_and_modulation_stop_at_each_other() {
    let mut document = document("soft-express");
    let mut set = |key: &str, value: Option<f64>| {
        let method = document.scene().unwrap().method.representative();
        let scene = document.change(&method_changes(&method, key, value.map(Setting::Number))).unwrap();
        let soft = *scene.method.fixed().and_then(Method::soft).unwrap();
        (soft.threshold, soft.modulation)
    };
    assert_eq!(set("modulation", Some(0.75)), (0.5, Some(0.75)));
    assert_eq!(set("threshold", Some(0.9)), (0.749, Some(0.75)));
    assert_eq!(set("threshold", Some(0.25)), (0.25, Some(0.75)));
    assert_eq!(set("modulation", Some(0.0)), (0.25, Some(0.251)));
    assert_eq!(set("threshold", Some(0.0)), (0.0, Some(0.251)));
    assert_eq!(set("modulation", Some(0.0)), (0.0, Some(0.001)));
    assert_eq!(set("modulation", None), (0.0, None));
    assert_eq!(set("threshold", Some(1.0)), (1.0, None));
}

#[test]
fn of_two_keys_that_exclude_each_other_the_last_one_stays() {
    let mut document = document("soft-base");
    let mut set = |key: &str, value: Setting| {
        let method = document.scene().unwrap().method.representative();
        document.change(&method_changes(&method, key, Some(value))).unwrap().method.representative()
    };
    // In either order: the other slider starts with the same density.
    let lambda = method(&set("softness", Setting::Number(0.25)), "lambda", EXTENT).unwrap();
    let method = set("lambda", lambda.value);
    assert_eq!(controls::method(&method, "softness", EXTENT).unwrap().value, Setting::Number(0.25));
    assert!(!is_on(&controls::method(&method, "softness", EXTENT).unwrap()));
    let method = set("softness", Setting::Number(0.75));
    assert!(!is_on(&controls::method(&method, "lambda", EXTENT).unwrap()));
    set("modulation", Setting::Number(0.75));
    let method = set("layout", Setting::Word("paper".into()));
    assert_eq!(method.soft().unwrap().modulation, None);
    let method = set("modulation", Setting::Number(0.75));
    assert_eq!(method.soft().unwrap().layout, SoftLayout::Precise);
}

#[test]
fn lights_take_each_others_place() {
    let text = "[[cloud]]\npath = 'a.ply'\n[method]\nname = 'points'\n[shading]\nmodel = 'lambert'\n[shadows]\nlight_radius = 200.0";
    let mut document = Document::from_toml(text, "s.toml".as_ref(), &Overrides::default()).unwrap();
    let (along, at) = (glam::DVec3::new(0.5, 0.25, -1.0), glam::DVec3::new(7.0, 8.0, 9.0));
    let lights = [Light::Position(at), Light::Direction(along), Light::Headlight, Light::Direction(along)];
    for light in lights.into_iter().chain([Light::Position(at), Light::Position(along), Light::Headlight]) {
        let before = document.scene().unwrap().shading.light;
        let scene = document.change(&light_changes(before, light)).unwrap();
        assert_eq!((scene.shading.light, saved(&document).shading.light), (light, light));
    }
    assert!(!document.has("shadows.light_radius"), "degrees are no world units");
}

#[test]
fn numbers_are_as_short_as_in_the_file() {
    assert_eq!(rounded(0.17), 0.17);
    assert_eq!(rounded(f32::MAX) as f32, f32::MAX);
    assert_eq!((significant(0.012_345_67), significant(98_765.4), significant(0.0)), (0.012_35, 98_770.0, 0.0));
    assert_eq!(thousandths(0.249_999_9), 0.25);
}

/// Most characters of a phrase beside a switch, and of a label.
const MOST: usize = 18;

/// Texts of the reference are longer and have code in them: a control needs words of its own.
#[test]
fn labels_are_short_and_plain() {
    let extent = ControlExtent { diagonal: 123_456.78, median_radius: 0.125 };
    let scene = document("auto").scene().unwrap();
    let keys_of = |name: &'static str| method_keys(name).into_iter().map(move |key| (name, key));
    let methods = METHODS.iter().flat_map(|name| keys_of(name)).map(|(name, key)| {
        let document = document(name);
        (key, method(&document.scene().unwrap().method.representative(), key, extent))
    });
    let clouds =
        ["primitive", "sh_degree", "radius", "neighbors", "radius_cap", "outliers", "colormap", "reverse", "log"];
    let clouds = clouds.into_iter().flat_map(|key| {
        [None, Some(12)].map(|prepared| (key, cloud(&scene.clouds[0], key, prepared.is_some(), prepared, extent)))
    });
    let shading = names(&scene.shading.keys()).into_iter().filter(|key| *key != "light");
    let shading = shading.map(|key| (key, entry(&find(scene.shading.keys(), key).expect(key), extent)));
    let shaded = names(&Shadows::default().keys()).into_iter();
    let shaded = shaded.map(|key| (key, shadows(&Shadows::default(), Light::Headlight, key, extent)));
    let all: Vec<_> = methods.chain(clouds).chain(shading).chain(shaded).collect();
    assert!(all.len() > 100);
    for (key, entry) in all {
        let entry = entry.unwrap_or_else(|| panic!("{key} has no control"));
        let words = match entry.control {
            Control::Choice(words) => words.iter().map(|word| word.name.to_owned()).collect(),
            _ => vec![],
        };
        let without = match entry.presence {
            Presence::Optional { without, .. } => Some(without),
            _ => None,
        };
        for text in words.into_iter().chain(without).chain([controls::label(key)]) {
            let is_plain = !text.contains(['`', '"', ';', '_', '.']) || text.contains('%');
            assert!(text.chars().count() <= MOST && is_plain, "{key}: {text:?}");
        }
    }
}
