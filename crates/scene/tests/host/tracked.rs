//! Points that follow the settings of a scene are, step by step, those that the scene gives from scratch.

use glam::{DVec3, Vec3};
use pellucid_core::cloud::Cloud;
use pellucid_core::cloud::field::Field;
use pellucid_core::points::{Changes, Points};
use pellucid_core::progress::Progress;
use pellucid_scene::prepare::Arranged;
use pellucid_scene::tracked::{DerivedColumns, Tracked};
use pellucid_scene::{
    ClassSettings, Clip, ClipShape, ColorBy, ColorRange, Discs, Method, Outliers, Scene, Selection, Soft, Spbr,
    SpbrSimplified,
};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

const SEED: u64 = 3;

/// Points of which many share their position, some with others that look the same, and what the settings pick from.
fn cloud(r: &mut Pcg64, count: usize) -> Cloud {
    let mut cloud = Cloud::default();
    let optional = |r: &mut Pcg64| r.random_range(0..2) == 1;
    let column = |r: &mut Pcg64, steps: u32| -> Vec<f32> {
        (0..count).map(|_| r.random_range(0..steps) as f32 / (steps - 1) as f32).collect()
    };
    let place = |v: f32| (4.0 * f64::from(v) - 1.0).max(0.0);
    let [x, y, colors, axes] = [column(r, 5), column(r, 4), column(r, 3), column(r, 3)];
    cloud.positions =
        x.iter().zip(&y).map(|(x, y)| DVec3::new(place(*x), place(*y), if *x > 0.5 { 0.0 } else { -0.0 })).collect();
    cloud.colors = optional(r).then(|| colors.iter().map(|c| Vec3::new(*c, 0.5, 1.0 - c)).collect());
    cloud.normals = optional(r).then(|| axes.iter().map(|a| if *a > 0.4 { Vec3::X } else { Vec3::ZERO }).collect());
    cloud.alphas = optional(r).then(|| column(r, 3));
    cloud.radii = optional(r).then(|| column(r, 3));
    cloud.classification = Some(column(r, 4).iter().map(|c| (3.0 * c) as u8).collect());
    cloud.intensity = Some(column(r, 4));
    cloud.scalars = vec![("height".into(), column(r, 5))];
    cloud
}

fn scene(clouds: usize) -> Scene {
    let text: String = (0..clouds).map(|i| format!("[[cloud]]\npath = '{i}.ply'\n")).collect();
    Scene::from_toml(&text, "some.toml".as_ref()).unwrap()
}

fn one_of<T: Clone>(r: &mut Pcg64, of: &[T]) -> T {
    of[r.random_range(0..of.len())].clone()
}

/// Changes something, mostly what keeps positions.
fn change(r: &mut Pcg64, scene: &mut Scene) {
    let (soft, spbr) = (Soft::default(), Spbr { ensembles: 4, ..Spbr::default() });
    let methods = [
        Method::Points,
        Method::ABuffer(Discs::default()),
        Method::SoftBase(soft),
        Method::SoftExpress(Soft { threshold: 0.2, ..soft }),
        Method::Spbr(spbr),
        Method::Spbr(Spbr { ensembles: 7, ..spbr }),
        Method::SpbrSimplified(SpbrSimplified::default()),
    ];
    let fields = [
        None,
        Some(Field::Uncertainty),
        Some(Field::Intensity),
        Some(Field::Classification { classes: vec![1, 2] }),
        Some(Field::Classification { classes: vec![] }),
        Some(Field::Property { name: "height".into() }),
        Some(Field::DistanceToAxis { point: None, direction: None }),
    ];
    let index = r.random_range(0..scene.clouds.len());
    let cloud = &mut scene.clouds[index];
    let colorings = [
        ColorBy::Auto,
        ColorBy::Height,
        ColorBy::Classification,
        ColorBy::Uniform,
        ColorBy::Field,
        ColorBy::Cloud,
        ColorBy::Scalar("height".into()),
    ];
    let selections =
        [Selection::Class(1), Selection::Class(2), Selection::Scalar { name: "height".into(), range: [0.25, 0.5] }];
    let entry = |r: &mut Pcg64| ClassSettings {
        points: one_of(r, &selections),
        opacity: one_of(r, &[None, Some(0.125)]),
        color: one_of(r, &[None, Some(Vec3::Y)]),
        radius: one_of(r, &[None, Some(0.0), Some(0.75)]),
        visible: one_of(r, &[None, Some(false), Some(true)]),
    };
    let slab = |max| Clip { shape: ClipShape::Slab { axis: 0, min: None, max: Some(max) }, invert: false };
    match r.random_range(0..38) {
        0..4 => cloud.opacity = one_of(r, &[0.0, 0.25, 0.5, 1.0]),
        4..8 => cloud.color = one_of(r, &[None, Some(Vec3::ONE), Some(Vec3::new(0.2, 0.9, 0.0))]),
        8..11 => cloud.radius = one_of(r, &[None, Some(0.1), Some(0.0)]),
        11..14 => cloud.radius_factor = one_of(r, &[0.0, 1.0, 2.5]),
        14..18 => cloud.field = one_of(r, &fields),
        18..20 => cloud.neighbors = one_of(r, &[None, Some(1), Some(5)]),
        20 => cloud.translate = one_of(r, &[DVec3::ZERO, DVec3::X, DVec3::splat(1e308)]),
        // Positions beyond float64 are dropped.
        21 => cloud.scale = one_of(r, &[1.0, 2.0, 1.7e308]),
        22..25 => cloud.coloring.color_by = one_of(r, &colorings),
        25 => {
            cloud.coloring.range = one_of(r, &[None, Some(ColorRange::Drawn), Some(ColorRange::Between([0.25, 0.5]))]);
        }
        26..28 => cloud.class = (0..r.random_range(0..3)).map(|_| entry(r)).collect(),
        34 => cloud.surface_opacity = one_of(r, &[None, Some(0.3), Some(0.6)]),
        35 => cloud.strays.radius_cap = one_of(r, &[None, Some(0.0), Some(1.0)]),
        36 => cloud.strays.outliers = one_of(r, &[Outliers::Keep, Outliers::Drop]),
        37 => cloud.strays.outlier_factor = one_of(r, &[0.5, 1.0]),
        28 => scene.clips = one_of(r, &[vec![], vec![slab(1.0)], vec![slab(0.5)]]),
        _ => scene.method = one_of(r, &methods).into(),
    }
}

/// Columns that are others, as far as one can see.
fn differences(before: &Points, after: &Points) -> Changes {
    let bits = |values: &[f32]| values.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
    Changes {
        colors: before.colors != after.colors,
        opacities: bits(&before.opacities) != bits(&after.opacities),
        radii: bits(&before.radii) != bits(&after.radii),
        fields: bits(&before.fields) != bits(&after.fields),
        order: before.file_order != after.file_order || before.normals != after.normals,
        unseen: before.unseen != after.unseen,
        gaussians: before.gaussians != after.gaussians,
    }
}

/// The events during sequences of settings.
#[derive(Debug, Default)]
struct Met {
    followed: usize,
    traded: [usize; 2],
    anew: usize,
    dropped: usize,
    unseen: usize,
    without_points: usize,
}

fn run(seed: u64, steps: usize, met: &mut Met) {
    let mut r = Pcg64::seed_from_u64(seed);
    let counts = [40, one_of(&mut r, &[0, 1, 25]), 30];
    let clouds: Vec<Cloud> = counts.map(|count| cloud(&mut r, count)).into();
    let all: usize = clouds.iter().map(Cloud::len).sum();
    let mut known = vec![DerivedColumns::default(); clouds.len()];
    let (mut scene, hidden) = (scene(clouds.len()), Progress::hidden());
    let mut tracked: Option<Tracked> = None;
    for step in 0..steps {
        change(&mut r, &mut scene);
        let what = format!("seed {seed}, step {step}: {:?}, {:?}", scene.method, scene.clouds);
        let wanted = match pellucid_scene::arrange(&scene, clouds.clone(), SEED, &hidden) {
            Ok(wanted) => wanted,
            Err(_) => {
                assert!(Tracked::new(&scene, &clouds, &mut known, SEED, &hidden).is_err(), "{what}");
                met.without_points += 1;
                continue;
            }
        };
        let before = tracked.as_ref().map(|tracked| tracked.points().clone());
        let followed = tracked.as_mut().and_then(|t| t.follow(&scene, &clouds, &mut known, &hidden).expect(&what));
        match (followed, before) {
            (Some(changes), Some(before)) => {
                let seen = differences(&before, wanted.points());
                // Points that trade places take all of their columns along; dealt ones don't say where they stood.
                let order = changes.order;
                let said = |column: bool, seen: bool| order || column == seen;
                assert!(said(changes.colors, seen.colors) && said(changes.opacities, seen.opacities), "{what}");
                assert!(said(changes.radii, seen.radii) && said(changes.fields, seen.fields), "{what}");
                assert_eq!(changes.unseen, seen.unseen, "{what}");
                assert!(order || !seen.order, "{what}: normals and origins stay");
                met.followed += 1;
                met.traded[usize::from(scene.method.is_dealt())] += usize::from(order);
            }
            _ => {
                tracked = Some(Tracked::new(&scene, &clouds, &mut known, SEED, &hidden).expect(&what));
                met.anew += 1;
            }
        }
        let tracked = tracked.as_ref().expect("there is one by now");
        assert!(*tracked.arranged() == wanted, "{what}");
        met.dropped += usize::from(wanted.points().len() < all);
        met.unseen += usize::from(!wanted.points().unseen.radii.is_empty());
    }
}

#[test]
fn settings_one_after_the_other_are_as_good_as_from_scratch() {
    let mut met = Met::default();
    for seed in 0..24 {
        run(seed, 60, &mut met);
    }
    // All of it happened, and often.
    assert!(met.followed > 500 && met.anew > 50 && met.dropped > 50 && met.unseen > 50, "{met:?}");
    assert!(met.traded[0] > 50 && met.traded[1] > 10, "{met:?}");
}

#[test]
fn points_in_one_place_stand_by_what_they_are() {
    let mut clouds = vec![Cloud { positions: vec![DVec3::ZERO; 3], ..Cloud::default() }];
    clouds[0].alphas = Some(vec![0.25, 1.0, 0.5]);
    let (mut scene, mut known, hidden) = (scene(1), vec![DerivedColumns::default()], Progress::hidden());
    scene.clouds[0].radius = Some(1.0);
    let mut tracked = Tracked::new(&scene, &clouds, &mut known, 0, &hidden).unwrap();
    assert_eq!((&*tracked.points().opacities, &*tracked.points().file_order), (&[0.25, 0.5, 1.0][..], &[0, 2, 1][..]));
    // With no opacity they are identical, and stand as in the file.
    scene.clouds[0].opacity = 0.0;
    let changes = tracked.follow(&scene, &clouds, &mut known, &hidden).unwrap().unwrap();
    assert_eq!(changes, Changes { opacities: true, order: true, ..Changes::default() });
    assert_eq!((&*tracked.points().opacities, &*tracked.points().file_order), (&[0.0; 3][..], &[0, 1, 2][..]));
    // The same again changes nothing.
    assert_eq!(tracked.follow(&scene, &clouds, &mut known, &hidden).unwrap(), Some(Changes::default()));
}

/// -0 is 0, but the bits of what it is a factor of are others, and the order goes by bits.
#[test]
fn zeros_of_two_signs_are_two_settings() {
    let clouds =
        [0.25, 1.0].map(|x| Cloud { positions: vec![DVec3::splat(-0.0), DVec3::splat(x)], ..Cloud::default() });
    let clouds = Vec::from(clouds);
    let hidden = Progress::hidden();
    let plain = || {
        let mut scene = scene(2);
        scene.clouds.iter_mut().for_each(|cloud| (cloud.radius, cloud.opacity) = (Some(0.0), 0.0));
        scene.clouds.iter_mut().for_each(|cloud| cloud.color = Some(Vec3::ZERO));
        scene
    };
    type Set = fn(&mut Scene);
    let settings: [Set; 4] = [
        |scene| scene.clouds[0].opacity = -0.0,
        |scene| scene.clouds[0].color = Some(Vec3::new(0.0, -0.0, 0.0)),
        |scene| scene.clouds[0].radius = Some(-0.0),
        |scene| scene.clouds[0].translate = DVec3::splat(-0.0),
    ];
    let bits = |points: &Points| {
        let singles = |values: &[f32]| values.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
        let colors: Vec<_> = points.colors.iter().map(|c| c.to_array().map(f32::to_bits)).collect();
        let positions: Vec<_> = points.positions.iter().map(|p| p.to_array().map(f64::to_bits)).collect();
        (positions, colors, singles(&points.opacities), singles(&points.radii), points.file_order.clone())
    };
    for (case, set) in settings.into_iter().enumerate() {
        let (mut scene, mut known) = (plain(), vec![DerivedColumns::default(); 2]);
        let mut tracked = Tracked::new(&scene, &clouds, &mut known, SEED, &hidden).unwrap();
        set(&mut scene);
        let wanted = pellucid_scene::arrange(&scene, clouds.clone(), SEED, &hidden).unwrap();
        match tracked.follow(&scene, &clouds, &mut known, &hidden).unwrap() {
            Some(_) => assert_eq!(bits(tracked.points()), bits(wanted.points()), "{case}"),
            None => assert_eq!(case, 3, "positions stay"),
        }
    }
}

#[test]
fn requests_for_missing_columns_fail_and_change_nothing() {
    let mut r = Pcg64::seed_from_u64(1);
    let clouds = vec![cloud(&mut r, 20), cloud(&mut r, 20)];
    let (mut scene, mut known, hidden) = (scene(2), vec![DerivedColumns::default(); 2], Progress::hidden());
    let mut tracked = Tracked::new(&scene, &clouds, &mut known, SEED, &hidden).unwrap();
    let before = tracked.arranged().clone();
    let good = scene.clone();
    scene.method = Method::SoftBase(Soft::default()).into();
    scene.clouds[0].field = Some(Field::Intensity);
    scene.clouds[1].field = Some(Field::Property { name: "weight".into() });
    let error = tracked.follow(&scene, &clouds, &mut known, &hidden).unwrap_err().to_string();
    assert!(error.contains("weight") && error.contains("1.ply"), "{error}");
    assert!(*tracked.arranged() == before);
    for scene in [&good, &Scene { method: Method::SoftBase(Soft::default()).into(), ..good.clone() }] {
        tracked.follow(scene, &clouds, &mut known, &hidden).unwrap().unwrap();
        assert!(*tracked.arranged() == pellucid_scene::arrange(scene, clouds.clone(), SEED, &hidden).unwrap());
    }
}

#[test]
fn who_is_dealt_and_who_is_not_is_another_arrangement() {
    let clouds = vec![cloud(&mut Pcg64::seed_from_u64(2), 20)];
    let (mut scene, mut known, hidden) = (scene(1), vec![DerivedColumns::default()], Progress::hidden());
    let mut tracked = Tracked::new(&scene, &clouds, &mut known, SEED, &hidden).unwrap();
    let before = tracked.arranged().clone();
    scene.method = Method::Spbr(Spbr::default()).into();
    assert_eq!(tracked.follow(&scene, &clouds, &mut known, &hidden).unwrap(), None);
    assert!(*tracked.arranged() == before && matches!(before, Arranged::Canonical(_)));
}
