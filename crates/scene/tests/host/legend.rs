//! The facts of a legend: what is listed, with which colors, and what is not.

use std::sync::Arc;

use glam::DVec3;
use pellucid_core::camera::{Camera, Projection};
use pellucid_core::cloud::crs::{Crs, Unit};
use pellucid_core::cloud::{Cloud, UpAxis};
use pellucid_core::color::classes;
use pellucid_core::progress::Progress;
use pellucid_scene::legend::{Legend, Swatch};
use pellucid_scene::tracked::{self, DerivedColumns, Tracked};
use pellucid_scene::{Scene, arrange, arrange_with_legend, differing_units};

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

fn in_units(unit: Option<Unit>, vertical_unit: Option<Unit>) -> Option<Arc<Crs>> {
    Some(Arc::new(Crs { unit, vertical_unit, ..Crs::default() }))
}

fn us_foot() -> Option<Unit> {
    Unit::length("", 1200.0 / 3937.0)
}

/// The scene of clouds with these systems and keys; the headings of its legend and the label of the scale bar of a
/// camera that looks along −Z or Y.
fn with_units(systems: &[Option<Arc<Crs>>], keys: &[&str]) -> (Scene, Vec<String>, [String; 2]) {
    let text: String = keys.iter().map(|keys| format!("[[cloud]]\npath = 'a.las'\nradius = 1.0\n{keys}\n")).collect();
    let scene = Scene::from_toml(&text, "s.toml".as_ref()).unwrap();
    let clouds: Vec<Cloud> = systems.iter().map(|crs| Cloud { crs: crs.clone(), ..cloud() }).collect();
    let (_, legend) = arrange_with_legend(&scene, clouds.clone(), 0, &Progress::hidden()).unwrap();
    let mut derived = vec![DerivedColumns::default(); clouds.len()];
    Tracked::new(&scene, &clouds, &mut derived, 0, &Progress::hidden()).unwrap();
    assert_eq!(tracked::legend(&scene, &clouds, &derived).unwrap(), legend);
    let bar = |eye: DVec3, up: DVec3| {
        let flat = Projection::Orthographic { height: 30.0 };
        let camera = Camera::look_at(eye, DVec3::ZERO, up, flat, 0.1, 10.0).unwrap();
        legend.scale_bar(&camera, [800, 600]).unwrap().label
    };
    let headings = legend.entries.iter().filter_map(|entry| entry.heading.clone()).collect();
    (scene, headings, [bar(DVec3::Z, DVec3::Y), bar(DVec3::NEG_Y, DVec3::Z)])
}

#[test]
fn lengths_have_the_units_of_the_file() {
    let meter = || Some(Unit::metre());
    for (system, keys, heading, bars) in [
        (None, "color_by = 'height'", "height (units)", ["10 units"; 2]),
        (in_units(meter(), None), "color_by = 'height'", "height (m)", ["10 m"; 2]),
        (in_units(us_foot(), None), "color_by = 'height'", "height (US survey ft)", ["10 US survey ft"; 2]),
        (in_units(us_foot(), meter()), "color_by = 'height'", "height (m)", ["10 US survey ft"; 2]),
        (in_units(us_foot(), meter()), "color_by = 'x'", "x (US survey ft)", ["10 US survey ft"; 2]),
        (in_units(us_foot(), meter()), "color_by = 'z'", "z (m)", ["10 US survey ft"; 2]),
        (in_units(Some(Unit::degree()), None), "color_by = 'height'", "height (units)", ["10°"; 2]),
        (in_units(Some(Unit::degree()), meter()), "color_by = 'y'", "y (°)", ["10°"; 2]),
        // A column has the file's unit, whatever the scene's.
        (in_units(us_foot(), None), "color_by = 'z'\nscale = 2.0", "z (US survey ft)", ["10 units"; 2]),
        (in_units(us_foot(), None), "color_by = 'height'\nscale = 2.0", "height (units)", ["10 units"; 2]),
        (in_units(us_foot(), None), "color_by = 'height'\nscale = 0.3048006096", "height (m)", ["10 m"; 2]),
        (in_units(meter(), None), "color_by = 'dose'", "dose", ["10 m"; 2]),
    ] {
        let (scene, headings, found) = with_units(std::slice::from_ref(&system), &[keys]);
        assert_eq!((headings, found), (vec![heading.to_owned()], bars.map(str::to_owned)), "{system:?} {keys}");
        assert_eq!(differing_units(&scene, &[system]), None);
    }
}

#[test]
fn clouds_in_different_units_have_none_and_a_warning_names_both() {
    let (feet, meters) = (in_units(us_foot(), None), in_units(Some(Unit::metre()), None));
    let height = "color_by = 'height'";
    let systems = [feet.clone(), None, meters.clone()];
    let (scene, headings, bars) = with_units(&systems, &[height; 3]);
    assert_eq!((headings, bars), (vec!["height (units)".to_owned()], ["10 units", "10 units"].map(str::to_owned)));
    let warning = differing_units(&scene, &systems).unwrap();
    assert!(
        warning.starts_with("a.las is in US survey foot (0.3048006096012192 m), but a.las is in metre (1 m): "),
        "{warning}"
    );
    // Heights alone differ.
    let systems = [meters.clone(), in_units(Some(Unit::metre()), us_foot())];
    let (scene, _, bars) = with_units(&systems, &[height; 2]);
    assert_eq!(bars[0], "10 units");
    assert!(differing_units(&scene, &systems).unwrap().contains("metre (1 m) with heights in US survey foot"));
    // Converted, they are one.
    let systems = [meters, feet];
    let (scene, headings, bars) = with_units(&systems, &[height, "color_by = 'height'\nscale = 0.3048006096"]);
    assert_eq!((headings[0].as_str(), bars[0].as_str()), ("height (m)", "10 m"));
    assert_eq!(differing_units(&scene, &systems), None);
}
