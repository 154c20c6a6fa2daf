//! Levels of detail: the same bytes window by window, fewer points, and errors that fall along the ladder.

use std::path::Path;
use std::sync::Arc;

use pellucid_core::cloud::UpAxis;
use pellucid_core::image::Image;
use pellucid_core::progress::Progress;
use pellucid_engine::methods::{Error, Frame, Rendered, Renderer, Upload};
use pellucid_gpu::Device;
use pellucid_io::store::build::Settings;
use pellucid_scene::prepare::{self, Arranged, Request};
use pellucid_scene::stored::{Stored, open_stores};
use pellucid_scene::{
    self as scene, Detail, Discs, Light, Method, Scene, ScreenSplats, Shading, ShadingModel, Shadows,
};
use pellucid_testing::{bits, by_windows, frame, perspective, scene as points_of, soup, with_device};

/// Points of a cloud of the tests with radii, as a store whose nodes have few points; and the same in memory.
fn both(folder: &Path) -> (Scene, Arranged, Stored) {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/data/models/turbine_blade_6k.ply");
    let hidden = Progress::hidden();
    let input = [pellucid_io::store::open(&file, Default::default(), &hidden).unwrap()];
    let target = folder.join("store");
    let settings = Settings { node_points: 200, host_memory: 4 << 20 };
    let request = Request { radii: true, ..Request::default() };
    prepare::store::prepare(&input, &target, &request, &settings, &hidden).unwrap();
    let text =
        format!("[image]\nsize = [160, 120]\n[shading]\nmodel = 'none'\n[[cloud]]\npath = '{}'\n", target.display());
    let mut scene = Scene::from_toml(&text, Path::new("scene.toml")).unwrap();
    scene.method = Method::Circles(ScreenSplats::default()).into();
    let clouds = scene::load_clouds(&scene, &hidden).unwrap();
    let whole = scene::arrange(&scene, clouds, 3, &hidden).unwrap();
    let stored = Stored::new(&scene, &open_stores(&scene, &hidden).unwrap(), 64 << 20, &hidden).unwrap();
    (scene, whole, stored)
}

fn rendered(device: &Device, arranged: &Arranged, frame: &Frame) -> Result<Rendered, Error> {
    let mut renderer = Renderer::new(device)?;
    let mut cloud = renderer.upload(Upload::with_detail(arranged, &frame.detail))?;
    renderer.render(&mut cloud, frame)
}

fn spacing(spacing_px: f32) -> Detail {
    Detail { spacing_px, ..Detail::default() }
}

fn rmse(a: &Image, b: &Image) -> f64 {
    let pairs = a.rgba.iter().flatten().zip(b.rgba.iter().flatten());
    let sum: f64 = pairs.map(|(a, b)| f64::from(a - b).powi(2)).sum();
    (sum / (4 * a.rgba.len()) as f64).sqrt()
}

#[test]
fn levels_have_the_same_bytes_window_by_window() {
    let folder = tempfile::tempdir().unwrap();
    let (scene, whole, stored) = both(folder.path());
    let camera = scene::camera(&scene, whole.points(), UpAxis::Z).unwrap().0;
    let methods =
        [Method::Circles(ScreenSplats::default()), Method::ABuffer(Discs::default()), Method::Sorted(Discs::default())];
    with_device(|device| {
        for method in methods {
            for detail in [spacing(3.0), Detail { max_points: Some(2500), ..Detail::default() }] {
                for (name, arranged) in [("store", &stored.arranged()), ("memory", &whole)] {
                    let frame = Frame { method, detail, ..Frame::of_scene(&scene, camera, 3) };
                    let all = rendered(device, arranged, &frame).expect("a frame");
                    let small = Frame { memory_budget: Some(1 << 19), ..frame };
                    let windows = rendered(device, arranged, &small).expect("a frame in windows");
                    let about = format!("{name}, {}, {detail:?}", method.name());
                    assert!(windows.facts.windows > 1, "{about}");
                    assert_eq!(bits(&windows.image), bits(&all.image), "{about}");
                    assert!(all.facts.points < whole.points().count(), "{about}: {}", all.facts.points);
                }
            }
        }
    });
}

#[test]
fn errors_fall_along_the_ladder() {
    let folder = tempfile::tempdir().unwrap();
    let (scene, whole, stored) = both(folder.path());
    let camera = scene::camera(&scene, whole.points(), UpAxis::Z).unwrap().0;
    with_device(|device| {
        let frame = Frame::of_scene(&scene, camera, 3);
        let full = rendered(device, &whole, &frame).expect("a frame");
        let covered = |image: &Image| image.rgba.iter().filter(|[.., a]| *a > 0.0).count() as f64;
        for (name, arranged) in [("store", &stored.arranged()), ("memory", &whole)] {
            let mut before: Option<(f64, u64)> = None;
            for px in [16.0, 8.0, 4.0, 2.0] {
                let coarse = rendered(device, arranged, &Frame { detail: spacing(px), ..frame }).expect("a frame");
                let found = (rmse(&coarse.image, &full.image), coarse.facts.points);
                println!("{name}, {px} px: RMSE {:.4}, {} points", found.0, found.1);
                assert!(before.is_none_or(|(error, points)| found.0 < error && found.1 > points), "{name}, {px} px");
                // Radii grow to cover, and shapes stay about as large.
                let share = covered(&coarse.image) / covered(&full.image);
                assert!(px > 4.0 || (0.9..1.3).contains(&share), "{name}, {px} px: {share}");
                before = Some(found);
            }
            // Nothing is this fine: the full image.
            let fine = rendered(device, arranged, &Frame { detail: spacing(1e-6), ..frame }).expect("a frame");
            assert_eq!(bits(&fine.image), bits(&full.image), "{name}");
        }
    });
}

#[test]
fn at_most_so_many_points_are_in_the_picture() {
    let folder = tempfile::tempdir().unwrap();
    let (scene, whole, stored) = both(folder.path());
    let camera = scene::camera(&scene, whole.points(), UpAxis::Z).unwrap().0;
    with_device(|device| {
        for (name, arranged) in [("store", &stored.arranged()), ("memory", &whole)] {
            let mut fewest = u64::MAX;
            for most in [4000, 2000, 1000] {
                let detail = Detail { max_points: Some(most), ..Detail::default() };
                let frame = Frame { detail, ..Frame::of_scene(&scene, camera, 3) };
                let image = rendered(device, arranged, &frame).expect("a frame");
                // All of the scene is in the picture.
                assert!(image.facts.visible <= most.into(), "{name}: {} of {most}", image.facts.visible);
                assert!(image.facts.visible < fewest, "{name}: {}", image.facts.visible);
                fewest = image.facts.visible;
            }
        }
        let detail = Detail { max_points: Some(1), ..Detail::default() };
        let frame = Frame { detail, ..Frame::of_scene(&scene, camera, 3) };
        let error = rendered(device, &stored.arranged(), &frame).expect_err("fewer than the coarsest level has");
        assert!(matches!(error, Error::Coarsest { allowed: 1, points: 2.. }), "{error}");
        assert!(error.to_string().contains("detail.max_points = 1, but the coarsest level alone has"), "{error}");
    });
}

#[test]
fn other_cameras_have_other_cuts_and_points_on_the_device_have_none() {
    let points = Arc::new(points_of(&soup(41, 20_000, 0.002..0.02, 0.1..0.9, true)));
    with_device(|device| {
        let mut renderer = Renderer::new(device).expect("a renderer");
        let mut cloud = by_windows(&renderer, &points);
        let near = perspective();
        let mut far = near;
        far.eye -= 20.0 * far.forward;
        far.far += 20.0;
        let of = |camera| Frame {
            detail: spacing(2.0),
            ..frame(camera, [80, 60], Method::Circles(ScreenSplats::default()))
        };
        let images: Vec<Rendered> = [near, far, near]
            .iter()
            .map(|camera| renderer.render(&mut cloud, &of(*camera)).expect("a frame"))
            .collect();
        assert!(images[1].facts.points < images[0].facts.points);
        assert_eq!(bits(&images[0].image), bits(&images[2].image));
        // Without it all come back.
        let whole = Frame { detail: Detail::default(), ..of(near) };
        let all = renderer.render(&mut cloud, &whole).expect("a frame");
        assert_eq!(all.facts.points, 20_000);
        let mut resident = renderer.upload(&*points).expect("room");
        assert_eq!(bits(&renderer.render(&mut resident, &whole).expect("a frame").image), bits(&all.image));
        assert!(matches!(renderer.render(&mut resident, &of(near)), Err(Error::NoLevels)));
        let nothing = Frame { detail: spacing(1e9), ..of(near) };
        assert!(renderer.render(&mut cloud, &nothing).expect("a frame").image.rgba.iter().all(|[.., a]| *a == 0.0));
    });
}

#[test]
fn shadows_are_cast_by_the_points_of_the_level() {
    let folder = tempfile::tempdir().unwrap();
    let (scene, whole, stored) = both(folder.path());
    let camera = scene::camera(&scene, whole.points(), UpAxis::Z).unwrap().0;
    let light = Light::Direction(glam::DVec3::new(0.3, 0.2, -0.9));
    let lit = Frame {
        shading: Shading { model: ShadingModel::Lambert, light, ..Shading::default() },
        shadows: Some(Shadows::default()),
        ..Frame::of_scene(&scene, camera, 3)
    };
    with_device(|device| {
        let mut renderer = Renderer::new(device).expect("a renderer");
        let mut cloud = renderer.upload(&stored.arranged()).expect("small buffers");
        // The images of the light are those of the level before, until they are made anew.
        for detail in [spacing(12.0), Detail::default(), spacing(12.0), spacing(3.0)] {
            let frame = Frame { detail, ..lit };
            let found = renderer.render(&mut cloud, &frame).expect("a frame").image;
            let fresh = rendered(device, &stored.arranged(), &frame).expect("a frame").image;
            assert!(bits(&found) == bits(&fresh), "{detail:?}");
            let dark = rendered(device, &stored.arranged(), &Frame { shadows: None, ..frame }).expect("a frame").image;
            assert!(bits(&found) != bits(&dark), "{detail:?}: no shadows");
        }
    });
}
