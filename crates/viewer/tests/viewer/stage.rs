//! Tests that after any sequence of settings a picture is, to the bit, the one that a fresh start makes of the scene;
//! and that what is said to stay on the device isn't uploaded again.

mod common;
mod drafts;
mod stored;
mod views;

use std::path::Path;

use glam::DVec3;

use common::{assert_same, assert_same_clouds, cloud, clouds, document, number, numbers, words};
use pellucid_core::cloud::Cloud;
use pellucid_core::cloud::shadow_texture::ShadowTexture;
use pellucid_core::points::Changes;
use pellucid_core::progress::Progress;
use pellucid_gpu::{Device, Preferences};
use pellucid_scene::prepare::{self, Request};
use pellucid_scene::{Document, METHODS, Overrides, Scene, Setting};
use pellucid_session::{Clouds, Sources};
use pellucid_testing::{with_device, with_device_that_prefers};
use pellucid_viewer::draft::{Cost, Costs, Effort};
use pellucid_viewer::messages::Setup;
use pellucid_viewer::navigate::Pose;
use pellucid_viewer::stage::{SceneRenderer, TakenPicture};

const SEED: u64 = 5;

const SETUP: Setup = Setup { seed: SEED, memory_budget: None, host_memory: u64::MAX };

fn stage(device: &Device, clouds: Vec<Cloud>) -> SceneRenderer {
    let clouds = Clouds::Held(clouds.into_iter().map(Into::into).collect());
    SceneRenderer::new(device, Sources::new(clouds, u64::MAX, false), &SETUP).unwrap()
}

/// The picture of a stage and a renderer that know nothing yet, which take the place of `other`.
fn fresh(other: &mut SceneRenderer, device: &Device, clouds: &[Cloud], scene: &Scene) -> TakenPicture {
    *other = stage(device, clouds.to_vec());
    other.take(scene, Pose::Scene, Effort::Whole).unwrap()
}

/// A draft with a share of the work, independent of the machine's frame time: the whole picture is said to take a
/// second.
fn draft(stage: &mut SceneRenderer, scene: &Scene, effort: impl Fn(f64) -> Effort, work: f64) -> TakenPicture {
    stage.costs = Some((scene.method.name(), None, Costs::new(Cost { ms: 1000.0, work: 1.0 })));
    stage.take(scene, Pose::Scene, effort(1000.0 * work)).unwrap()
}

/// Where the points of a stage are in memory, once it has some.
fn places(stage: &mut SceneRenderer) -> Option<*const DVec3> {
    Some(stage.session().ok()?.points().positions.as_ptr())
}

/// A setting of each kind; each picture but the first few has all earlier ones in force.
fn changes(threshold: f64) -> Vec<(String, Setting)> {
    vec![
        number("cloud.0.opacity", 0.35),
        number("cloud.*.opacity", 1.0),
        numbers("cloud.1.color", [0.9, 0.2, 0.1]),
        number("cloud.0.radius_factor", 1.7),
        words("cloud.*.field", "height"),
        number("cloud.1.radius", 0.11),
        number("method.threshold", threshold),
        ("cloud.0.soft_classes".into(), Setting::Integers(vec![0, 2])),
        words("cloud.0.field", "classification"),
        ("cloud.0.soft_classes".into(), Setting::Integers(vec![1])),
        ("cloud.0.neighbors".into(), Setting::Integer(3)),
        numbers("cloud.0.color", [0.1, 0.2, 0.8]),
        numbers("shading.light", [-0.4, -1.0, -0.2]),
        number("cloud.1.opacity", 0.45),
        numbers("cloud.1.translate", [0.2, 0.0, 0.1]),
        number("cloud.0.scale", 1.25),
        number("cloud.0.opacity", 0.7),
    ]
}

/// Few samples, ensembles and layers, because the test takes many pictures.
fn quick(document: &mut Document) {
    for (key, value) in [("samples", 4), ("ensembles", 6)] {
        document.put(&format!("method.{key}"), Setting::Integer(value)).unwrap();
    }
}

fn each_setting_of(methods: &[&str]) {
    with_device(|device| {
        let clouds = clouds();
        let (mut live, mut other) = (stage(device, clouds.clone()), stage(device, clouds.clone()));
        let mut following = 0;
        for (i, method) in methods.iter().enumerate() {
            let mut document = document();
            quick(&mut document);
            let there = ["soft-express", "spbr", "points", "abuffer"][i % 4];
            let mut all = vec![words("method.name", method)];
            all.extend(changes(0.3 + 0.1 * (i % 4) as f64));
            all.extend([words("method.name", there), words("method.name", method), number("cloud.0.opacity", 0.2)]);
            for (key, value) in all {
                let scene = document.set(&key, value.clone()).unwrap();
                let before = places(&mut live);
                let taken = live.take(&scene, Pose::Scene, Effort::Whole).unwrap();
                following += usize::from(before == places(&mut live));
                let what = format!("{method} (by way of {there}), {key} = {value:?}");
                assert_same(&taken, &fresh(&mut other, device, &clouds, &scene), &what);
                assert_same_clouds(&mut live, &mut other, &what);
                live.recycle(taken.rendered.image);
            }
        }
        // Most of it in place, or nothing was tested.
        assert!(following >= 14 * methods.len(), "{following} of {} methods", methods.len());
    });
}

/// Split in halves, which the test runner can run in parallel.
#[test]
fn each_setting_of_each_method_gives_the_bytes_of_a_fresh_start() {
    each_setting_of(&METHODS[..METHODS.len() / 2]);
}

#[test]
fn each_setting_of_each_other_method_gives_the_bytes_of_a_fresh_start() {
    each_setting_of(&METHODS[METHODS.len() / 2..]);
}

#[test]
fn only_columns_that_changed_are_uploaded() {
    with_device(|device| {
        let text = "[image]\nsize = [28, 18]\n[[cloud]]\npath = 'a.ply'\nopacity = 0.8\n[method]\nname = 'soft-base'\n[shading]\nmodel = 'phong'";
        let mut document = Document::from_toml(text, Path::new("/scans/s.toml"), &Overrides::default()).unwrap();
        let mut stage = stage(device, vec![cloud(1, 60)]);
        let n = 60;
        let vector = 16 * n;
        // The upload of all points except for the normals' light terms: four vectors and F; at first also ids, which
        // never change.
        let all = 4 * vector + 4 * n;
        let height = words("cloud.0.field", "height");
        let steps = [
            (number("cloud.0.opacity", 0.5), all + 4 * n, Changes::ALL),
            (number("cloud.0.opacity", 0.25), vector, Changes { opacities: true, ..Changes::default() }),
            (number("cloud.0.radius_factor", 3.0), vector, Changes { radii: true, ..Changes::default() }),
            (number("method.threshold", 0.75), 0, Changes::default()),
            (number("method.softness", 0.75), 0, Changes::default()),
            (words("shading.model", "lambert"), 0, Changes::default()),
            (height.clone(), 4 * n, Changes { fields: true, ..Changes::default() }),
            (height, 0, Changes::default()),
            // Without colors of their own F decides which of two points in the same place comes first.
            (
                numbers("cloud.0.color", [1.0, 0.5, 0.0]),
                all,
                Changes { colors: true, order: true, ..Changes::default() },
            ),
            (number("cloud.0.opacity", 1.0), vector, Changes { opacities: true, ..Changes::default() }),
        ];
        for ((key, value), bytes, changes) in steps {
            let scene = document.set(&key, value).unwrap();
            let before = device.uploaded_bytes();
            assert_eq!(stage.place(&scene, Pose::Scene).unwrap(), changes, "{key}");
            assert_eq!(device.uploaded_bytes() - before, bytes, "{key}");
        }
    });
}

#[test]
fn dealt_points_stay_dealt_when_colors_and_opacities_change() {
    with_device(|device| {
        let clouds = vec![cloud(1, 60), cloud(2, 50)];
        let mut document = document();
        quick(&mut document);
        document.put("method.name", Setting::Word("spbr".into())).unwrap();
        let (mut live, mut other) = (stage(device, clouds.clone()), stage(device, clouds.clone()));
        let n = 110;
        let settings = [number("cloud.0.opacity", 0.3), number("cloud.1.opacity", 0.9), number("cloud.0.opacity", 0.0)];
        for (i, (key, value)) in settings.into_iter().enumerate() {
            let scene = document.set(&key, value).unwrap();
            let before = device.uploaded_bytes();
            let changes = live.place(&scene, Pose::Scene).unwrap();
            if i > 0 {
                assert_eq!(changes, Changes { opacities: true, ..Changes::default() }, "{key}");
                assert_eq!(device.uploaded_bytes() - before, 16 * n, "{key}");
            }
            let taken = live.take(&scene, Pose::Scene, Effort::Whole).unwrap();
            assert_same(&taken, &fresh(&mut other, device, &clouds, &scene), &key);
        }
    });
}

/// A cloud with shadows that no light casts: they must be those of the file for the light that they are stored for, and
/// cast for others.
#[test]
fn stored_shadows_are_there_for_their_light_only() {
    with_device(|device| {
        let mut document = Document::from_toml(
            "[image]\nsize = [28, 18]\n[shading]\nmodel = 'lambert'\nlight = [0, -1, 0]\n[shadows]\n\
             resolution = 32\n[[cloud]]\npath = 'a.ply'\n[method]\nname = 'points'\n",
            Path::new("/scans/s.toml"),
            &Overrides::default(),
        )
        .unwrap();
        let mut cloud = prepare::prepared(cloud(1, 60), &Request::default(), &Progress::hidden()).unwrap();
        let scene = document.scene().unwrap();
        let all = (&cloud.bounds().unwrap(), cloud.len() as u64);
        let casting = scene.shadows.unwrap().casting(scene.shading.light, SEED, all).unwrap();
        let lit = (0..60).map(|i| (i % 3) as f32 / 2.0).collect();
        cloud.prepared.as_mut().unwrap().shadows = Some(ShadowTexture { casting, lit });
        let clouds = vec![cloud];
        let (mut live, mut other) = (stage(device, clouds.clone()), stage(device, clouds.clone()));
        let (stored, elsewhere) = ([0.0, -1.0, 0.0], [0.0, -1.0, -0.5]);
        let settings = [
            numbers("shading.light", stored),
            // Points without colors of their own trade places, and their shadows with them.
            numbers("cloud.0.color", [0.5, 0.5, 1.0]),
            number("cloud.0.opacity", 0.5),
            numbers("shading.light", elsewhere),
            number("cloud.0.opacity", 0.75),
            numbers("shading.light", stored),
            ("shadows.resolution".into(), Setting::Integer(16)),
            ("shadows.resolution".into(), Setting::Integer(32)),
            words("method.name", "circles"),
            words("method.name", "soft-base"),
            words("cloud.0.field", "height"),
            words("method.name", "points"),
        ];
        let mut views = Vec::new();
        for (key, value) in settings {
            let scene = document.set(&key, value.clone()).unwrap();
            let taken = live.take(&scene, Pose::Scene, Effort::Whole).unwrap();
            assert_same(&taken, &fresh(&mut other, device, &clouds, &scene), &format!("{key} = {value:?}"));
            views.push(taken.rendered.facts.light_views);
        }
        // Shadows are cast only for a light the file has none for, and only once.
        assert_eq!(views, [0, 0, 0, 1, 0, 0, 1, 0, 0, 0, 0, 0]);
    });
}

#[test]
fn a_setting_that_a_cloud_has_nothing_for_leaves_the_others_in_force() {
    with_device(|device| {
        let clouds = clouds();
        let mut document = document();
        document.put("method.name", Setting::Word("soft-base".into())).unwrap();
        let (mut live, mut other) = (stage(device, clouds.clone()), stage(device, clouds.clone()));
        live.take(&document.scene().unwrap(), Pose::Scene, Effort::Whole).unwrap();
        let scene = document.set("cloud.1.field", Setting::Word("weight".into())).unwrap();
        assert!(live.take(&scene, Pose::Scene, Effort::Whole).is_err() && live.session().is_ok());
        let scene = document.set("cloud.1.field", Setting::Word("height".into())).unwrap();
        let taken = live.take(&scene, Pose::Scene, Effort::Whole).unwrap();
        assert_same(&taken, &fresh(&mut other, device, &clouds, &scene), "after an error");
    });
}

#[test]
fn uploads_that_were_stopped_are_repeated() {
    // Uploads to a GPU are submitted; into a CPU driver's memory the host writes by itself.
    with_device_that_prefers(Preferences::GPU, |device| {
        let (clouds, mut document) = (clouds(), document());
        document.put("method.name", Setting::Word("soft-base".into())).unwrap();
        document.put("cloud.*.field", Setting::Word("height".into())).unwrap();
        let (mut live, mut other) = (stage(device, clouds.clone()), stage(device, clouds.clone()));
        live.take(&document.scene().unwrap(), Pose::Scene, Effort::Whole).unwrap();
        let settings = [
            (0, number("cloud.0.opacity", 0.5)),
            (2, numbers("cloud.0.color", [1.0, 0.5, 0.0])),
            (1, numbers("cloud.1.color", [0.0, 0.5, 0.0])),
            (0, words("cloud.0.field", "uncertainty")),
            (0, words("method.name", "abuffer")),
            (0, words("method.name", "soft-express")),
        ];
        for (allowed, (key, value)) in settings {
            let scene = document.set(&key, value).unwrap();
            device.allow_submissions(Some(allowed));
            let stopped = live.take(&scene, Pose::Scene, Effort::Whole);
            device.allow_submissions(None);
            assert!(stopped.is_err(), "{key}");
            // Another one in between.
            if allowed == 1 {
                document.set("cloud.0.radius_factor", Setting::Number(1.5)).unwrap();
            }
            let scene = document.scene().unwrap();
            let taken = live.take(&scene, Pose::Scene, Effort::Whole).unwrap();
            assert_same(&taken, &fresh(&mut other, device, &clouds, &scene), &key);
            assert_same_clouds(&mut live, &mut other, &key);
        }
    });
}

#[test]
fn auto_is_asked_again_when_points_become_transparent() {
    with_device(|device| {
        let (mut document, opaque) = (document(), vec![cloud(1, 60), cloud(2, 50)]);
        document.put("cloud.*.opacity", Setting::Number(1.0)).unwrap();
        let mut stage = stage(device, opaque);
        let mut method = |document: &Document| {
            stage.take(&document.scene().unwrap(), Pose::Scene, Effort::Moving(1e9)).unwrap().frame.method.name()
        };
        assert_eq!(method(&document), "circles");
        document.put("cloud.1.opacity", Setting::Number(0.5)).unwrap();
        assert_eq!(method(&document), "sorted");
        document.put("cloud.1.opacity", Setting::Number(1.0)).unwrap();
        assert_eq!(method(&document), "circles");
    });
}
