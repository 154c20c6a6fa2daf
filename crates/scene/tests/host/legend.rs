//! The facts of a legend: what is listed, with which colors, and what is not.

use glam::DVec3;
use pellucid_core::cloud::{Cloud, UpAxis};
use pellucid_core::color::classes;
use pellucid_core::progress::Progress;
use pellucid_scene::legend::{Legend, Swatch};
use pellucid_scene::tracked::{self, DerivedColumns, Tracked};
use pellucid_scene::{Scene, arrange, arrange_with_legend};

/// 20 points along X from 0 to 19, of classes 2, 5, 6 and 9 in turn, as high as their place.
fn cloud() -> Cloud {
    Cloud {
        positions: (0..20).map(|i| DVec3::new(f64::from(i), 0.0, f64::from(i))).collect(),
        classification: Some((0..20).map(|i| [2, 5, 6, 9][i % 4]).collect()),
        intensity: Some((0..20).map(|i| i as f32).collect()),
        scalars: vec![("dose".into(), (0..20).map(|i| if i == 3 { f32::NAN } else { i as f32 }).collect())],
        up: UpAxis::Z,
        ..Cloud::default()
    }
}

/// The legend of clouds `a.las`, `b.las` and so on, one for each text of keys; with and without it the points are the
/// same, and so is the legend of points that follow a scene.
fn legend(keys: &[&str], rest: &str) -> Legend {
    let names = ["a.las", "b.las", "c.las"];
    let entries = keys.iter().zip(names);
    let text: String =
        entries.map(|(keys, name)| format!("[[cloud]]\npath = 'to/{name}'\nradius = 1.0\n{keys}\n")).collect();
    let scene = Scene::from_toml(&format!("{text}{rest}"), "s.toml".as_ref()).unwrap();
    let clouds = vec![cloud(); keys.len()];
    let (arranged, legend) = arrange_with_legend(&scene, clouds.clone(), 0, &Progress::hidden()).unwrap();
    let plain = arrange(&scene, clouds.clone(), 0, &Progress::hidden()).unwrap();
    assert_eq!(arranged.points(), plain.points());
    let mut derived = vec![DerivedColumns::default(); clouds.len()];
    Tracked::new(&scene, &clouds, &mut derived, 0, &Progress::hidden()).unwrap();
    assert_eq!(tracked::legend(&scene, &clouds, &derived).unwrap(), legend);
    legend
}

fn labels(swatches: &[Swatch]) -> Vec<&str> {
    swatches.iter().map(|swatch| swatch.label.as_str()).collect()
}

#[test]
fn classes_are_those_that_are_drawn() {
    for (keys, rest, wanted) in [
        ("", "", &["ground", "high-vegetation", "building", "water"][..]),
        ("[[cloud.class]]\nid = 5\nvisible = false", "", &["ground", "building", "water"]),
        ("[[cloud.class]]\nid = 'ground'\nopacity = 0.0", "", &["high-vegetation", "building", "water"]),
        // Points 0 and 1 alone.
        ("", "[[clip]]\nslab = { axis = 'x', max = 1.5 }", &["ground", "high-vegetation"]),
    ] {
        let found = legend(&[&format!("color_by = 'classification'\n{keys}")], rest);
        assert_eq!(labels(&found.entries[0].swatches), wanted, "{keys} {rest}");
        assert_eq!(found.entries[0].heading.as_deref(), Some("class"));
        assert_eq!(found.title(&found.entries[0]), None);
        for swatch in &found.entries[0].swatches {
            assert_eq!(swatch.srgb, classes::srgb(classes::code(&swatch.label).unwrap()));
        }
    }
}

#[test]
fn colors_of_classes_and_ranges_are_listed_with_what_they_replace() {
    let keys = "color_by = 'height'\n[[cloud.class]]\nid = 6\ncolor = [0.0, 1.0, 0.0]\n\
                [[cloud.class]]\nscalar = 'intensity'\nrange = [18, 30]\ncolor = [1.0, 0.0, 0.0]";
    let found = legend(&[keys], "");
    let entry = &found.entries[0];
    assert_eq!(entry.heading.as_deref(), Some("height (units)"));
    assert!(entry.values.is_some());
    assert_eq!(labels(&entry.swatches), ["building", "intensity 18 to 30"]);
    assert!((entry.swatches[0].srgb - DVec3::Y).length() < 1e-12);
    assert!((entry.swatches[1].srgb - DVec3::X).length() < 1e-12);
    // Where one color stands in place of all, only what is painted has a meaning.
    let found = legend(&[&keys.replace("color_by = 'height'", "color = [1.0, 1.0, 1.0]")], "");
    assert!(found.entries[0].values.is_none());
    assert_eq!(found.entries[0].swatches.len(), 2);
}

#[test]
fn values_have_the_ends_that_their_colors_have() {
    // Percentiles 1 and 99 of 0 to 19: places 0.19 and 18.81.
    let found = legend(&["color_by = 'height'"], "");
    let [low, high] = found.entries[0].values.as_ref().unwrap().scale.ends();
    assert!((low - 0.19).abs() < 1e-12 && (high - 18.81).abs() < 1e-12, "{low} {high}");
    let found = legend(&["color_by = 'dose'\nrange = [1, 100]\nlog = true\nreverse = true\ncolormap = 'grey'"], "");
    let entry = &found.entries[0];
    let values = entry.values.as_ref().unwrap();
    assert_eq!((values.scale.ends(), values.scale.log), ([1.0, 100.0], true));
    assert_eq!([0.0, 0.25, 1.0].map(|place| values.srgb(place).x), [1.0, 0.75, 0.0]);
    // A dose of 0 and one that is no number.
    assert_eq!((entry.heading.as_deref(), labels(&entry.swatches)), (Some("dose"), vec!["no value"]));
    assert_eq!(legend(&["color_by = 'height'"], "").entries[0].swatches, []);
    let heights = legend(&["color_by = 'auto'"], "");
    assert_eq!(heights.entries[0].heading.as_deref(), Some("class"), "four classes are enough for auto");
}

#[test]
fn clouds_share_equal_entries_and_have_titles_for_different_ones() {
    let titles =
        |found: &Legend| found.entries.iter().map(|entry| found.title(entry).unwrap_or_default()).collect::<Vec<_>>();
    let height = "color_by = 'height'";
    assert_eq!(titles(&legend(&[height, height], "")), [""]);
    assert_eq!(titles(&legend(&[height, "color_by = 'uniform'", height], "")), ["a.las, c.las"]);
    assert_eq!(titles(&legend(&[height, "color_by = 'height'\ntranslate = [0, 0, 5]"], "")), ["a.las", "b.las"]);
    let found = legend(&["color_by = 'cloud'", "color_by = 'cloud'"], "");
    assert_eq!((titles(&found), labels(&found.entries[0].swatches)), (vec![String::new()], vec!["a.las", "b.las"]));
    assert_eq!(found.entries[0].swatches[1].srgb, classes::distinct(1));
    for nothing in ["color_by = 'uniform'", "color = [0.1, 0.2, 0.3]", "opacity = 0.0\ncolor_by = 'height'"] {
        assert!(legend(&[nothing], "").is_empty(), "{nothing}");
    }
}
