//! `[[clip]]`, against sides written from the equations: which points are drawn, and that nothing else changes.

use std::path::Path;

use glam::{DVec3, Vec3};
use pellucid_core::cloud::{Cloud, UpAxis};
use pellucid_core::points::Points;
use pellucid_core::progress::Progress;
use pellucid_engine::methods::Frame;
use pellucid_scene::prepare::Arranged;
use pellucid_scene::{self as scene, Method, Overrides, Scene, Spbr, assemble};
use pellucid_testing::picked;

/// A grid of 9 x 9 x 9 whole coordinates from -4 to 4, so that borders go through points.
fn cloud() -> Cloud {
    let coordinate = |i: u32| f64::from(i % 9) - 4.0;
    let positions: Vec<_> =
        (0..729).map(|i| DVec3::new(coordinate(i), coordinate(i / 9), coordinate(i / 81))).collect();
    Cloud {
        normals: Some(positions.iter().map(|p| p.as_vec3().normalize_or_zero()).collect()),
        scalars: vec![("dose".into(), positions.iter().map(|p| (p.x * p.y + p.z) as f32).collect())],
        colors: Some(positions.iter().map(|p| (0.5 + 0.1 * p.as_vec3()).clamp(Vec3::ZERO, Vec3::ONE)).collect()),
        positions,
        up: UpAxis::Z,
        ..Cloud::default()
    }
}

fn scene_in(folder: &Path, clips: &str) -> Scene {
    // An automatic camera would frame what is left.
    let text =
        format!("camera = {{ frame = 'all' }}\n[[cloud]]\npath = 'a.ply'\nneighbors = 7\ncolor_by = 'dose'\n{clips}");
    Scene::from_toml(&text, &folder.join("s.toml")).unwrap_or_else(|error| panic!("{clips}: {error}"))
}

fn scene_of(clips: &str) -> Scene {
    scene_in("".as_ref(), clips)
}

fn points(scene: &Scene) -> Points {
    assemble(scene, vec![cloud()], true, &Progress::hidden()).unwrap_or_else(|error| panic!("{error}"))
}

/// Asserts that a scene draws just the points that are `kept`, each with the color and radius that it has without
/// clips.
#[track_caller]
fn assert_kept(scene: &Scene, kept: impl Fn(DVec3) -> bool) {
    let (all, found) = (points(&scene_of("")), points(scene));
    // In the order that all of them have.
    let wanted = picked(&all, |i| kept(all.positions[i]));
    assert!(!wanted.is_empty() && wanted.len() < all.len(), "{} of {}", wanted.len(), all.len());
    assert_eq!((&found.positions, &found.colors, &found.radii), (&wanted.positions, &wanted.colors, &wanted.radii));
    assert_eq!((&found.opacities, &found.normals), (&wanted.opacities, &wanted.normals));
    assert_eq!((found.bounds(), found.largest_radius()), (all.bounds(), all.largest_radius()));
    let camera = |points: &Points| scene::camera(scene, points, UpAxis::Z).unwrap().0;
    assert_eq!(camera(&found), camera(&all));
}

#[test]
fn borders_are_kept_on_both_sides() {
    type Sides = fn(DVec3) -> f64;
    // Above 0 inside, 0 on the border.
    let shapes: [(&str, Sides); 6] = [
        ("box = { min = [-1, -2, -3], max = [1, 2, 3] }", |p| (DVec3::new(1.0, 2.0, 3.0) - p.abs()).min_element()),
        ("box = { min = [2, -4, 0], max = [2, 4, 0] }", |p| -(p.x - 2.0).abs().max(p.z.abs())),
        ("plane = { point = [1, 0, 0], normal = [1, 0, 0] }", |p| p.x - 1.0),
        ("plane = { point = [1, 1, 1], normal = [3, -2, 0.5] }", |p| 3.0 * p.x - 2.0 * p.y + 0.5 * p.z - 1.5),
        ("slab = { axis = 'z', min = -2, max = 1 }", |p| (p.z + 2.0).min(1.0 - p.z)),
        ("slab = { axis = 'y', max = 0.5 }", |p| 0.5 - p.y),
    ];
    for (shape, side) in shapes {
        assert_kept(&scene_of(&format!("[[clip]]\n{shape}")), |p| side(p) >= 0.0);
        // A box without thickness has no inside: all points are outside or on it.
        if !shape.contains("[2, -4, 0]") {
            assert_kept(&scene_of(&format!("[[clip]]\n{shape}\ninvert = true")), |p| side(p) <= 0.0);
        }
    }
    let two = "[[clip]]\nslab = { axis = 'x', min = 0 }\n[[clip]]\nslab = { axis = 'x', max = 2 }\ninvert = true";
    assert_kept(&scene_of(two), |p| p.x >= 2.0);
}

#[test]
fn a_frame_does_not_know_of_clips() {
    // A method knows the frame and the points alone: no pass, and no shader, can depend on clips.
    let frame = |clips: &str| {
        let scene = scene_of(clips);
        let camera = scene::camera(&scene, &points(&scene), UpAxis::Z).unwrap().0;
        format!("{:?}", Frame::of_scene(&scene, camera, 0))
    };
    assert_eq!(frame("[[clip]]\nslab = { axis = 'z', min = 0 }"), frame(""));
    assert_ne!(frame("[image]\nsize = [8, 8]"), frame(""));
}

#[test]
fn clips_are_in_the_scene_s_coordinates() {
    let text = "[[cloud]]\npath = 'a.ply'\nscale = 10\ntranslate = [500000, 0, 0]\nradius = 1\n\
                [[clip]]\nslab = { axis = 'x', min = 500020, max = 500030 }";
    let scene = Scene::from_toml(text, "s.toml".as_ref()).unwrap();
    let found = points(&scene);
    assert_eq!(found.len(), 2 * 81);
    assert!(found.positions.iter().all(|p| [500_020.0, 500_030.0].contains(&p.x)));
}

#[test]
fn polygons_come_from_files_beside_the_scene() {
    let folder = tempfile::tempdir().unwrap();
    let square =
        |min: i32, max: i32| format!("[[{min},{min}],[{max},{min}],[{max},{max}],[{min},{max}],[{min},{min}]]");
    let feature = |rings: &str| {
        format!(r#"{{"type":"Feature","properties":{{}},"geometry":{{"type":"Polygon","coordinates":[{rings}]}}}}"#)
    };
    // A frame, and a square in its hole.
    let frame = feature(&format!("{},{}", square(-3, 3), square(-2, 2)));
    let text = format!(r#"{{"type":"FeatureCollection","features":[{frame},{}]}}"#, feature(&square(-1, 1)));
    std::fs::write(folder.path().join("area.geojson"), text).unwrap();
    let scene = |more: &str| scene_in(folder.path(), &format!("[[clip]]\npolygon = 'area.geojson'\n{more}"));
    let reach = |p: DVec3| p.x.abs().max(p.y.abs());
    assert_kept(&scene(""), |p| reach(p) <= 3.0 && !(1.0 < reach(p) && reach(p) < 2.0));
    // Whole coordinates between 1 and 2 there are none: the inverse keeps borders and what lies beyond them.
    assert_kept(&scene("invert = true"), |p| reach(p) >= 1.0);
    let refusals = [
        ("none.geojson", None, "no such file"),
        ("text.geojson", Some("POLYGON ((0 0, 1 1, 1 0, 0 0))"), "not GeoJSON"),
        ("point.geojson", Some(r#"{"type":"Point","coordinates":[1,2]}"#), "no polygon in the file"),
    ];
    for (name, content, says) in refusals {
        if let Some(content) = content {
            std::fs::write(folder.path().join(name), content).unwrap();
        }
        let scene = scene_in(folder.path(), &format!("[[clip]]\npolygon = '{name}'"));
        let error = assemble(&scene, vec![cloud()], true, &Progress::hidden()).unwrap_err();
        assert!(error.to_string().contains(name) && error.to_string().contains(says), "{error}");
        assert_eq!(error.exit_status(), 1);
    }
}

#[test]
fn clipped_points_do_not_count_for_the_density_of_ensembles() {
    let spbr = |clips: &str| Scene { method: Method::Spbr(Spbr::default()).into(), ..scene_of(clips) };
    let arranged = |scene: &Scene, cloud: Cloud| scene::arrange(scene, vec![cloud], 3, &Progress::hidden()).unwrap();
    let slab = "[[clip]]\nslab = { axis = 'x', max = -1 }";
    let cut = arranged(&spbr(slab), cloud());
    assert!(cut.points().positions.iter().all(|p| p.x <= -1.0));
    assert_eq!((cut.points().len(), cut.points().unseen.positions.len()), (4 * 81, 5 * 81));
    // As if the file had those points alone; their colors alone come from all of them.
    let whole = cloud();
    let kept: Vec<usize> = (0..whole.len()).filter(|i| whole.positions[*i].x <= -1.0).collect();
    let column = |values: &[Vec3]| kept.iter().map(|i| values[*i]).collect::<Vec<_>>();
    let alone = Cloud {
        positions: kept.iter().map(|i| whole.positions[*i]).collect(),
        normals: whole.normals.as_deref().map(column),
        colors: whole.colors.as_deref().map(column),
        scalars: vec![("dose".into(), kept.iter().map(|i| whole.scalars[0].1[*i]).collect())],
        ..Cloud::default()
    };
    let alone = arranged(&spbr(""), alone);
    // Points that are cut off decide on the order, too.
    let sorted = |arranged: &Arranged| {
        let mut positions: Vec<[u64; 3]> =
            arranged.points().positions.iter().map(|p| p.to_array().map(f64::to_bits)).collect();
        positions.sort_unstable();
        positions
    };
    assert_eq!(sorted(&cut), sorted(&alone));
    let ([cut], [alone]) = (cut.surfaces(), alone.surfaces()) else { panic!("one surface each") };
    assert_eq!((&cut.points, cut.center, cut.opacity), (&alone.points, alone.center, alone.opacity));
    assert!((cut.density / alone.density - 1.0).abs() < 1e-9, "{} {}", cut.density, alone.density);
}

#[test]
fn options_cut_too() {
    let mut overrides = Overrides::default();
    overrides.append("--slice z=2..", "clip", "{ slab = { axis = \"z\", min = 2 } }").unwrap();
    for (clip, least) in [("", -4.0), ("[[clip]]\nslab = { axis = 'x', min = 3 }", 3.0)] {
        let text = format!("[[cloud]]\npath = 'a.ply'\nradius = 1\n{clip}");
        let scene = Scene::from_toml_with(&text, "s.toml".as_ref(), &overrides).unwrap();
        let found = points(&scene);
        assert!(found.positions.iter().all(|p| p.z >= 2.0 && p.x >= least));
        assert_eq!(found.len(), 3 * 9 * (5.0 - least) as usize);
    }
}

#[test]
fn errors_in_clips_name_their_position() {
    for (clip, wanted) in [
        ("invert = true", "s.toml:3:1: a [[clip]] needs one of `box`, `plane`, `slab` and `polygon`, found 0"),
        (
            "slab = { axis = 'z', min = 1 }\npolygon = 'a'",
            "s.toml:3:1: a [[clip]] needs one of `box`, `plane`, `slab` and `polygon`, found 2",
        ),
        ("box = { min = [0, 0, 0] }", "s.toml:4:7: a box needs `min` and `max`"),
        (
            "box = { min = [0, 2, 0], max = [1, 1, 1] }",
            "s.toml:4:7: the `min` of a box must be at most its `max`, on every axis",
        ),
        ("plane = { point = [0, 0, 0] }", "s.toml:4:9: a plane needs `point` and `normal`"),
        (
            "plane = { point = [0, 0, 0], normal = [0, 0, 0] }",
            "s.toml:4:39: `clip.0.plane.normal` must be a direction, found [0, 0, 0]",
        ),
        ("slab = { axis = 'z' }", "s.toml:4:8: a slab needs `axis`, and `min` or `max`"),
        ("slab = { axis = 'z', min = 2, max = 1 }", "s.toml:4:8: the `min` of a slab must be at most its `max`"),
        (
            "slab = { axis = 'w', min = 2 }",
            "s.toml:4:17: `clip.0.slab.axis` must be one of \"x\", \"y\", \"z\", found the string \"w\"",
        ),
        ("sphere = 1", "s.toml:4:1: unknown key `clip.0.sphere`"),
    ] {
        let text = format!("[[cloud]]\npath = 'a'\n[[clip]]\n{clip}");
        let error = Scene::from_toml(&text, "s.toml".as_ref()).unwrap_err().to_string();
        assert!(error.starts_with(wanted), "{error}");
    }
    let none = scene_of("[[clip]]\nslab = { axis = 'x', min = 99 }");
    let error = assemble(&none, vec![cloud()], true, &Progress::hidden()).unwrap_err();
    assert_eq!(
        error.to_string(),
        "a.ply: no point remains to draw: clips cut off all 729; the points extend over x -4.000 to 4.000"
    );
}
