//! `[[cloud.class]]`: opacities, colors, radii and visibility of points by class or by a scalar, worked by hand.

use glam::{DVec3, Vec3};
use pellucid_core::cloud::{Bounds, Cloud, UpAxis};
use pellucid_core::points::Points;
use pellucid_core::progress::Progress;
use pellucid_scene::{self as scene, Method, Overrides, Scene, Spbr, assemble};

/// Points at x = 0, 1, 2, … with these classes.
fn cloud(codes: &[u8]) -> Cloud {
    let count = codes.len();
    Cloud {
        positions: (0..count).map(|i| DVec3::new(i as f64, 0.0, 0.0)).collect(),
        classification: Some(codes.to_vec()),
        scalars: vec![("dose".into(), (0..count).map(|i| 10.0 * i as f32).collect())],
        up: UpAxis::Z,
        ..Cloud::default()
    }
}

fn scene_of(text: &str, overrides: &Overrides) -> Scene {
    Scene::from_toml_with(text, "s.toml".as_ref(), overrides).unwrap_or_else(|error| panic!("{text}: {error}"))
}

fn points(keys: &str, cloud: Cloud) -> Points {
    let text = format!("[[cloud]]\npath = 'a.las'\nradius = 0.5\ncolor_by = 'uniform'\nopacity = 0.5\n{keys}");
    assemble(&scene_of(&text, &Overrides::default()), vec![cloud], true, &Progress::hidden()).unwrap()
}

/// Values of a column for the points in the order of x.
fn by_x<T: Copy>(points: &Points, column: &[T]) -> Vec<T> {
    let mut places: Vec<usize> = (0..points.len()).collect();
    places.sort_by(|a, b| points.positions[*a].x.total_cmp(&points.positions[*b].x));
    places.into_iter().map(|place| column[place]).collect()
}

#[test]
fn the_last_entry_that_states_a_key_wins_point_by_point() {
    let keys = "
        [[cloud.class]]
        id = 'high-vegetation'
        opacity = 0.25
        color = [0, 1, 0]
        [[cloud.class]]
        scalar = 'dose'
        range = [10, 20]
        opacity = 0.125
        [[cloud.class]]
        id = 6
        color = [1, 0, 0]";
    let found = points(keys, cloud(&[5, 5, 6, 6, 2]));
    assert_eq!(by_x(&found, &found.opacities), [0.25, 0.125, 0.125, 0.5, 0.5], "10 and 20 are in the closed range");
    assert_eq!(by_x(&found, &found.colors), [Vec3::Y, Vec3::Y, Vec3::X, Vec3::X, Vec3::ONE]);
    // An opacity replaces the cloud's; the file's alpha multiplies either.
    let transparent = Cloud { alphas: Some(vec![0.5; 5]), ..cloud(&[5, 5, 6, 6, 2]) };
    let found = points(keys, transparent);
    assert_eq!(by_x(&found, &found.opacities), [0.125, 0.0625, 0.0625, 0.25, 0.25]);
    // Its color beats the cloud's own.
    let found = points(&format!("color = [0, 0, 1]\n{keys}"), cloud(&[5, 1, 6]));
    assert_eq!(by_x(&found, &found.colors), [Vec3::Y, Vec3::Z, Vec3::X]);
}

#[test]
fn numbers_that_are_none_lie_in_no_range() {
    let mut a = cloud(&[1, 1]);
    a.scalars[0].1[0] = f32::NAN;
    let found = points("[[cloud.class]]\nscalar = 'Dose'\nrange = [-1e300, 1e300]\nopacity = 1.0", a);
    assert_eq!(by_x(&found, &found.opacities), [0.5, 1.0]);
}

#[test]
fn hidden_points_are_not_drawn_but_count_for_everything_else() {
    let text =
        |keys: &str| format!("[[cloud]]\npath = 'a.las'\nneighbors = 2\ncolor_by = 'dose'\ncolormap = 'grey'\n{keys}");
    let hide = "[[cloud.class]]\nid = 7\nvisible = false";
    let codes = [7, 2, 2, 7, 2, 7];
    let of = |keys: &str| scene_of(&text(keys), &Overrides::default());
    let assembled = |scene: &Scene| assemble(scene, vec![cloud(&codes)], true, &Progress::hidden()).unwrap();
    let (whole, rest) = (of(""), of(hide));
    let (all, shown) = (assembled(&whole), assembled(&rest));
    let kept: Vec<usize> = (0..6).filter(|i| codes[*i] != 7).collect();
    let (found, wanted) = (by_x(&shown, &shown.radii), by_x(&all, &all.radii));
    assert_eq!(found, kept.iter().map(|i| wanted[*i]).collect::<Vec<_>>(), "neighbors");
    let wanted = by_x(&all, &all.colors);
    assert_eq!(by_x(&shown, &shown.colors), kept.iter().map(|i| wanted[*i]).collect::<Vec<_>>(), "percentiles");
    let bounds = Bounds { min: DVec3::ZERO, max: DVec3::new(5.0, 0.0, 0.0) };
    assert_eq!((all.bounds(), shown.bounds()), (Some(bounds), Some(bounds)));
    let camera = |scene: &Scene, points: &Points| scene::camera(scene, points, UpAxis::Z).unwrap().0;
    let framed = scene_of(&format!("camera = {{ frame = 'all' }}\n{}", text(hide)), &Overrides::default());
    assert_eq!(camera(&whole, &all), camera(&framed, &shown));
    assert!(camera(&rest, &shown).far < camera(&whole, &all).far, "only what is drawn is framed");
    // Shown again by a later entry.
    let again = of(&format!("{hide}\n[[cloud.class]]\nscalar = 'dose'\nrange = [0, 0]\nvisible = true"));
    assert_eq!(assembled(&again).len(), 4);
}

#[test]
fn entries_of_options_come_behind_those_of_the_file() {
    let mut overrides = Overrides::default();
    overrides.append("--class", "cloud.*.class", "{ id = 2, opacity = 0.75 }").unwrap();
    for (keys, wanted) in [
        ("", [0.75, 1.0]),
        ("[[cloud.class]]\nid = 2\nopacity = 0.1\n[[cloud.class]]\nid = 3\nopacity = 0.2", [0.75, 0.2]),
    ] {
        let scene = scene_of(&format!("[[cloud]]\npath = 'a.las'\nradius = 1\n{keys}"), &overrides);
        let found = assemble(&scene, vec![cloud(&[2, 3])], true, &Progress::hidden()).unwrap();
        assert_eq!(by_x(&found, &found.opacities), wanted);
    }
}

#[test]
fn entries_with_missing_or_surplus_keys_are_errors() {
    for (entry, wanted) in [
        (
            "id = 300\nopacity = 1",
            "s.toml:4:6: `cloud.0.class.0.id` must be an integer from 0 to 255 or the name of a class, found 300",
        ),
        (
            "id = 'grund'\nopacity = 1",
            "s.toml:4:6: `cloud.0.class.0.id` names no class: \"grund\"; did you mean `ground`?",
        ),
        ("id = 2", "s.toml:3:1: a [[cloud.class]] needs `opacity`, `color`, `radius` or `visible`"),
        ("scalar = 'a'\nopacity = 1", "s.toml:3:1: a [[cloud.class]] needs either `id`, or `scalar` and `range`"),
        ("id = 2\nradius = -1", "s.toml:5:10: `cloud.0.class.0.radius` must be a number of at least 0, found -1"),
        ("id = 2\nopacity = 2", "s.toml:5:11: `cloud.0.class.0.opacity` must be a number from 0.0 to 1.0, found 2"),
    ] {
        let text = format!("[[cloud]]\npath = 'a'\n[[cloud.class]]\n{entry}");
        assert_eq!(Scene::from_toml(&text, "s.toml".as_ref()).unwrap_err().to_string(), wanted);
    }
    let none =
        scene_of("[[cloud]]\npath = 'a'\nradius = 1\n[[cloud.class]]\nid = 2\nvisible = false", &Overrides::default());
    let error = assemble(&none, vec![cloud(&[2, 2])], true, &Progress::hidden()).unwrap_err();
    assert_eq!(
        error.to_string(),
        "a: no point remains to draw: hidden classes leave out all 2; the points have class 2 (ground)"
    );
    let missing = scene_of(
        "[[cloud]]\npath = 'a'\n[[cloud.class]]\nscalar = 'dosis'\nrange = [0, 1]\nopacity = 0",
        &Overrides::default(),
    );
    let error = assemble(&missing, vec![cloud(&[2, 2])], true, &Progress::hidden()).unwrap_err();
    assert_eq!(error.to_string(), "a: no scalar `dosis` for cloud.class; did you mean `dose`?");
}

#[test]
fn a_cloud_may_be_hidden_whole() {
    let text = "[[cloud]]\npath = 'a'\nradius = 1\n[[cloud.class]]\nid = 2\nvisible = false\n\
                [[cloud]]\npath = 'b'\nradius = 2\ntranslate = [10, 0, 0]";
    for method in [Method::Points, Method::Spbr(Spbr::default())] {
        let scene = Scene { method: method.into(), ..scene_of(text, &Overrides::default()) };
        let arranged = scene::arrange(&scene, vec![cloud(&[2, 2]), cloud(&[2])], 1, &Progress::hidden()).unwrap();
        let points = arranged.points();
        assert_eq!(points.positions, [DVec3::new(10.0, 0.0, 0.0)]);
        assert_eq!(points.bounds(), Some(Bounds { min: DVec3::ZERO, max: DVec3::new(10.0, 0.0, 0.0) }));
        assert_eq!(arranged.surfaces().len(), usize::from(method.is_dealt()), "clouds without points are omitted");
    }
}

/// Radii of a cloud's points in the order of x.
fn radii(keys: &str, cloud: Cloud) -> Vec<f32> {
    let text = format!("[[cloud]]\npath = 'a.las'\nneighbors = 2\n{keys}");
    let found = assemble(&scene_of(&text, &Overrides::default()), vec![cloud], true, &Progress::hidden()).unwrap();
    by_x(&found, &found.radii)
}

const GROUND_IS_LARGE: &str = "[[cloud.class]]\nid = 'ground'\nradius = 0.25";

#[test]
fn a_class_has_its_radius_and_the_others_keep_theirs() {
    let of = || cloud(&[2, 5, 2, 6]);
    let own = || Cloud { radii: Some(vec![0.125, 0.5, 0.75, 1.0]), ..of() };
    // The radius of all points, those of the file, and those that are estimated from all points, whatever their class.
    let estimated = radii("", of());
    assert!(estimated.iter().all(|radius| *radius > 0.25), "{estimated:?}");
    assert_eq!(radii(&format!("radius = 4\n{GROUND_IS_LARGE}"), of()), [0.25, 4.0, 0.25, 4.0]);
    assert_eq!(radii(GROUND_IS_LARGE, own()), [0.25, 0.5, 0.25, 1.0]);
    assert_eq!(radii(GROUND_IS_LARGE, of()), [0.25, estimated[1], 0.25, estimated[3]]);
    // `radius_factor` multiplies it and `scale` doesn't, like `radius`.
    assert_eq!(radii(&format!("scale = 8\nradius_factor = 2\n{GROUND_IS_LARGE}"), own()), [0.5, 8.0, 0.5, 16.0]);
    // Of several entries the last one that gives a radius counts; one without leaves it.
    let later =
        "[[cloud.class]]\nscalar = 'dose'\nrange = [15, 35]\nradius = 2\n[[cloud.class]]\nid = 6\nopacity = 0.5";
    assert_eq!(radii(&format!("{GROUND_IS_LARGE}\n{later}"), own()), [0.25, 0.5, 2.0, 2.0]);
    assert_eq!(radii("[[cloud.class]]\nid = 2\nradius = 0", own()), [0.0, 0.5, 0.0, 1.0]);
    let unclassified = Cloud { classification: None, ..own() };
    assert_eq!(radii(GROUND_IS_LARGE, unclassified), [0.125, 0.5, 0.75, 1.0]);
}

#[test]
fn radii_of_classes_count_where_others_do() {
    let of = |keys: &str| scene_of(&format!("[[cloud]]\npath = 'a.las'\nneighbors = 2\n{keys}"), &Overrides::default());
    let assembled = |scene: &Scene| assemble(scene, vec![cloud(&[2; 9])], true, &Progress::hidden()).unwrap();
    // A class that all points have.
    let both = ["radius = 0.75", "radius = 3\n[[cloud.class]]\nid = 2\nradius = 0.75"].map(|keys| {
        let scene = of(&format!("surface_opacity = 0.5\n{keys}"));
        let points = assembled(&scene);
        (scene::camera(&scene, &points, UpAxis::Z).unwrap().0, points.opacities)
    });
    assert_eq!(both[0].0, both[1].0, "the camera shows whole discs");
    assert_eq!(both[0].1, both[1].1, "larger discs are fainter where a surface has an opacity");
    assert!(both[0].1 != assembled(&of("surface_opacity = 0.5\nradius = 3")).opacities);
}
