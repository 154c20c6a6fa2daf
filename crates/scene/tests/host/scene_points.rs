//! Points of a scene: settings applied, fields, what is dropped.

use glam::{DVec3, Vec3};
use pellucid_core::cloud::Cloud;
use pellucid_core::points::Points;
use pellucid_core::progress::Progress;
use pellucid_scene::*;

use crate::scene::{CLOUD, refused, scene_of};

fn assembled(text: &str, clouds: Vec<Cloud>, needs_radii: bool) -> Points {
    assemble(&scene_of(text), clouds, needs_radii, &Progress::hidden()).unwrap()
}

/// The point at a position, as (color, opacity, radius, normal): the order of points is not this test's business.
fn at(points: &Points, position: DVec3) -> (Vec3, f32, f32, Option<Vec3>) {
    let i = points.positions.iter().position(|p| *p == position).expect("a point at that position");
    (points.colors[i], points.opacities[i], points.radii[i], points.normals.as_ref().map(|normals| normals[i]))
}

#[test]
fn settings_apply_to_points() {
    let own = Cloud {
        positions: vec![DVec3::new(1.0, 0.0, 0.0)],
        colors: Some(vec![Vec3::new(0.1, 0.2, 0.3)]),
        alphas: Some(vec![0.5]),
        radii: Some(vec![0.25]),
        normals: Some(vec![Vec3::Z]),
        ..Cloud::default()
    };
    let bare = Cloud { positions: vec![DVec3::new(7.0, 7.0, 7.0)], ..Cloud::default() };
    let text = "[[cloud]]\npath = \"a\"\nopacity = 0.5\ntranslate = [500000, 4500000, 100]\nscale = 2\n\
                [[cloud]]\npath = \"b\"\nradius = 3.0\ncolor_by = \"uniform\"\n";
    let points = assembled(text, vec![own.clone(), bare.clone()], true);
    let moved = DVec3::new(500_002.0, 4_500_000.0, 100.0);
    // Alpha 0.5·0.5; the file's radius 0.25 times scale 2.
    assert_eq!(at(&points, moved), (Vec3::new(0.1, 0.2, 0.3), 0.25, 0.5, Some(Vec3::Z)));
    // White, opaque, the scene's radius, no normal beside one that has.
    assert_eq!(at(&points, DVec3::splat(7.0)), (Vec3::ONE, 1.0, 3.0, Some(Vec3::ZERO)));

    let points = assembled("[[cloud]]\npath = \"a\"\nradius = 3.0\nscale = 2\ncolor = [1, 0, 0]", vec![own], true);
    // A radius of the scene is not scaled, its color wins.
    assert_eq!(at(&points, DVec3::new(2.0, 0.0, 0.0)), (Vec3::X, 0.5, 3.0, Some(Vec3::Z)));
    let points = assembled("[[cloud]]\npath = \"b\"\ncolor_by = \"uniform\"", vec![bare], false);
    assert_eq!(at(&points, DVec3::splat(7.0)), (Vec3::ONE, 1.0, 0.0, None));
}

#[test]
fn radii_are_estimated_after_the_scale() {
    let line = Cloud { positions: (0..5).map(|i| DVec3::X * f64::from(i)).collect(), ..Cloud::default() };
    let radius = |scale: f64| {
        let text = format!("[[cloud]]\npath = \"a\"\nneighbors = 4\nscale = {scale}");
        at(&assembled(&text, vec![line.clone()], true), DVec3::ZERO).2
    };
    // Eq. 20 at the end of the line: its 4 neighbors reach to 4, so 2·4/sqrt(4).
    assert_eq!(radius(1.0), 4.0);
    assert_eq!(radius(1000.0), 4000.0);
}

#[test]
fn a_factor_multiplies_radii_from_anywhere() {
    let line = Cloud { positions: (0..5).map(|i| DVec3::X * f64::from(i)).collect(), ..Cloud::default() };
    let own = Cloud { radii: Some(vec![0.5; 5]), ..line.clone() };
    let radius = |cloud: &Cloud, keys: &str| {
        let text = format!("[[cloud]]\npath = \"a\"\nneighbors = 4\nradius_factor = 0.25\n{keys}");
        at(&assembled(&text, vec![cloud.clone()], true), DVec3::ZERO).2
    };
    // Estimated 4, as above; the file's 0.5, scaled; the scene's, not scaled.
    assert_eq!(radius(&line, ""), 1.0);
    assert_eq!(radius(&own, "scale = 1000"), 125.0);
    assert_eq!(radius(&own, "scale = 1000\nradius = 8"), 2.0);
    assert!(refused(&format!("{CLOUD}radius_factor = -1")).contains("cloud.0.radius_factor"));
}

const SOFT: &str = "[method]\nname = \"soft-base\"\n[[cloud]]\npath = \"a\"\n";

/// F of the points of one cloud by their x, under a soft method.
fn fields(cloud: &Cloud, keys: &str) -> Vec<f32> {
    let points = assembled(&format!("{SOFT}{keys}"), vec![cloud.clone()], true);
    let mut order: Vec<usize> = (0..points.len()).collect();
    order.sort_by(|&a, &b| points.positions[a].x.total_cmp(&points.positions[b].x));
    order.into_iter().map(|i| points.fields[i]).collect()
}

fn with_properties() -> Cloud {
    Cloud {
        positions: (0..5).map(|i| DVec3::new(f64::from(i), 2.0, f64::from(i % 2))).collect(),
        classification: Some(vec![2, 3, 4, 5, 3]),
        intensity: Some(vec![0.0, 100.0, 50.0, 200.0, 25.0]),
        scalars: vec![
            ("share".into(), vec![0.5, 0.25, 1.0, 0.75, 0.5]),
            ("pulse width".into(), vec![-1.0, 0.0, 3.0, f32::NAN, f32::INFINITY]),
            ("constant".into(), vec![7.0; 5]),
        ],
        ..Cloud::default()
    }
}

#[test]
fn fields_of_every_kind() {
    let cloud = with_properties();
    assert_eq!(fields(&cloud, "field = \"classification\"\nsoft_classes = [3, 5]"), [0.0, 1.0, 0.0, 1.0, 1.0]);
    assert_eq!(fields(&cloud, "field = \"classification\"\nsoft_classes = []"), [0.0; 5]);
    assert_eq!(fields(&cloud, "field = \"intensity\""), [0.0, 0.5, 0.25, 1.0, 0.125]);
    assert_eq!(fields(&cloud, "field = \"share\""), [0.5, 0.25, 1.0, 0.75, 0.5], "within [0, 1]: as stored");
    assert_eq!(fields(&cloud, "field = \"pulse width\""), [0.0, 0.25, 1.0, 0.0, 1.0], "NaN 0, infinity 1");
    assert_eq!(fields(&cloud, "field = \"pulse_width\""), [0.0, 0.25, 1.0, 0.0, 1.0], "as PLY files spell it");
    assert_eq!(fields(&cloud, "field = \"constant\""), [0.0; 5]);
    assert_eq!(fields(&cloud, "field = \"x\""), [0.0, 0.25, 0.5, 0.75, 1.0]);
    assert_eq!(fields(&cloud, "field = \"label\""), [0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0, 1.0 / 3.0], "the codes");
    // The vertical through the center (2, 2, 0.5) is along Y: distances √(4.25), √(1.25), 0.5, √(1.25), √(4.25).
    let [near, middle, far] = [0.5f64, 1.25f64.sqrt(), 4.25f64.sqrt()];
    let share = ((middle - near) / (far - near)) as f32;
    assert_eq!(fields(&cloud, "field = \"distance-to-axis\""), [1.0, share, 0.0, share, 1.0]);
    let axis = "field = \"distance-to-axis\"\naxis = { point = [0, 7, 0], direction = [0, 0, -3] }";
    assert!(fields(&cloud, axis).is_sorted(), "5 from each, and x beside");
}

#[test]
fn an_axis_is_in_the_scenes_coordinates() {
    let cloud = with_properties();
    let keys = |point: &str, more: &str| {
        format!("field = \"distance-to-axis\"\naxis = {{ point = {point}, direction = [0, 0, 1] }}\n{more}")
    };
    let moved = keys("[500004, 4500008, 0]", "scale = 2\ntranslate = [500000, 4500000, 100]");
    assert_eq!(fields(&cloud, &moved), fields(&cloud, &keys("[2, 4, 0]", "")));
    assert_ne!(fields(&cloud, &moved), fields(&cloud, &keys("[2, 5, 0]", "")));
}

#[test]
fn methods_without_soft_points_get_no_fields() {
    let cloud = with_properties();
    assert!(assembled("[[cloud]]\npath = \"a\"\nfield = \"nonsense\"", vec![cloud], true).fields.is_empty());
}

#[test]
fn fields_are_scaled_cloud_by_cloud_and_dropped_with_their_points() {
    let cloud = |values: [f32; 2]| Cloud {
        positions: vec![DVec3::X, DVec3::X * 1e300],
        scalars: vec![("v".into(), values.to_vec())],
        ..Cloud::default()
    };
    let text = format!("{SOFT}field = \"v\"\n[[cloud]]\npath = \"b\"\nfield = \"v\"\nscale = 1e10");
    let points = assembled(&text, vec![cloud([0.0, 2.0]), cloud([9.0, 3.0])], true);
    let field = |x: f64| points.fields[points.positions.iter().position(|p| p.x == x).unwrap()];
    assert_eq!((points.len(), points.fields.len()), (3, 3));
    assert_eq!([1.0, 1e300, 1e10].map(field), [0.0, 1.0, 1.0]);
}

#[test]
fn clouds_that_lack_what_a_field_needs_are_refused_by_name() {
    let refused = |cloud: Cloud, keys: &str| {
        let scene = scene_of(&format!("{SOFT}{keys}"));
        let error = assemble(&scene, vec![cloud], true, &Progress::hidden()).unwrap_err();
        assert_eq!(error.exit_status(), 1, "the scene is fine, the file lacks something: {error}");
        error.to_string()
    };
    let bare = || Cloud { classification: None, intensity: None, ..with_properties() };
    let message = refused(bare(), "field = \"classification\"\nsoft_classes = [3]");
    let there = "it has share, pulse width, constant, x, y, z";
    assert_eq!(message, format!("a: field = \"classification\" needs classes, but the file has none; {there}"));
    assert_eq!(
        refused(bare(), "field = \"intensity\""),
        format!("a: field = \"intensity\", but the file has none; {there}")
    );
    let message = refused(with_properties(), "field = \"shape\"");
    assert_eq!(message, "a: no scalar property `shape` for field; did you mean `share`?");
    let message = refused(with_properties(), "field = \"temperature\"");
    let all = "classification, intensity, share, pulse width, constant, x, y, z";
    assert_eq!(message, format!("a: no scalar property `temperature` for field; the file has: {all}"));
}

#[test]
fn points_that_leave_float64_are_dropped_with_their_attributes() {
    let cloud = Cloud {
        positions: vec![DVec3::X, DVec3::new(1e300, 0.0, 0.0), DVec3::Y],
        colors: Some(vec![Vec3::X, Vec3::Y, Vec3::Z]),
        ..Cloud::default()
    };
    let text = "[[cloud]]\npath = \"a\"\nscale = 1e10";
    let points = assembled(text, vec![cloud], false);
    assert_eq!(points.len(), 2);
    assert_eq!(at(&points, DVec3::Y * 1e10).0, Vec3::Z);
    let far = Cloud { positions: vec![DVec3::X * 1e300], ..Cloud::default() };
    let error = assemble(&scene_of(text), vec![far], false, &Progress::hidden()).unwrap_err();
    assert_eq!(error.exit_status(), 1);
}
