//! A scene that was saved and is opened again, by the worker on a device.

use super::*;
use crate::worker::started;
use pellucid_gpu::Device;
use pellucid_scene::{self as scene, Opened};
use pellucid_testing::with_device;
use pellucid_viewer::worker::Worker;

/// Runs the tasks of a model until a picture is there that nothing was left out of; its pixels.
fn settle(model: &mut Model, worker: &Worker) -> Vec<u32> {
    let until = Instant::now() + Duration::from_secs(120);
    loop {
        let now = Instant::now();
        while let Some(task) = model.next_task(now) {
            worker.ask(task);
        }
        while let Some(news) = worker.news() {
            model.take_in(news).unwrap();
        }
        if model.is_at_rest(Instant::now()) {
            let pixels = model.picture().and_then(|picture| picture.pixels.clone()).expect("a picture");
            return pixels.read(0, pixels.len()).unwrap();
        }
        assert!(now < until, "{:?}", model.message);
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// Two clouds in a folder: balls of points, one within the other.
fn write_clouds(folder: &Path) {
    for (name, radius, color) in [("inner", 1.0, "255 40 10"), ("outer", 2.0, "10 90 255")] {
        let mut text = String::from("x y z r g b\n");
        for i in 0..600 {
            // A spiral of even density (Saff and Kuijlaars 1997).
            let z: f64 = 1.0 - (2.0 * f64::from(i) + 1.0) / 600.0;
            let (sine, cosine) = (2.399_963 * f64::from(i)).sin_cos();
            let flat = (1.0 - z * z).sqrt();
            text += &format!("{} {} {} {color}\n", radius * flat * cosine, radius * flat * sine, radius * z);
        }
        std::fs::write(folder.join(format!("{name}.xyz")), text).unwrap();
    }
}

#[test]
fn a_saved_scene_is_the_same_when_it_is_opened_again() {
    with_device(reopen);
}

fn reopen(device: &Device) {
    let folder = tempfile::tempdir().unwrap();
    write_clouds(folder.path());
    let files = ["inner.xyz", "outer.xyz"].map(|name| folder.path().join(name));
    let opened = scene::open(&files, &Overrides::default(), 7, &Progress::hidden()).unwrap();
    let Opened { name, document, clouds, generated } = opened;
    let mut model = Model::new(name, document, View::default(), 33.0).unwrap();
    model.set_viewport(Viewport { at: [0, 0], size: SIZE });
    let worker = started(device, clouds, generated, 7);
    let first = settle(&mut model, &worker);
    let settings = [
        ("method.name", Setting::Word("sorted".into())),
        ("cloud.1.opacity", Setting::Number(0.3)),
        ("cloud.*.radius_factor", Setting::Number(0.7)),
        ("image.background", Setting::Numbers(vec![0.1, 0.2, 0.3])),
    ];
    for (key, value) in settings {
        model.set(key, value);
        assert_eq!(model.message, None);
    }
    let file = folder.path().join("views/kept.toml");
    std::fs::create_dir(folder.path().join("views")).unwrap();
    for flat in [false, true] {
        model.navigate(|navigator| navigator.orbit(DVec2::new(11.0, 5.0), 48.0));
        model.navigate(|navigator| navigator.pan(DVec2::new(3.0, -2.0), 48.0));
        model.navigate(|navigator| navigator.zoom(DVec3::ZERO, 0.8));
        if flat {
            model.navigate(Navigator::toggle_projection);
        }
        let shown = settle(&mut model, &worker);
        assert!(shown != first, "it is another picture");
        let (scene, pose) = (Scene::clone(model.scene()), model.pose());
        model.save_to(true, Some(file.clone()));
        settle(&mut model, &worker);
        let said = model.message.clone().unwrap().0;
        assert!(said.contains("kept.toml") && said.contains("kept.png"), "{said}");
        // Something else in between.
        model.open(files[..1].to_vec());
        assert!(settle(&mut model, &worker) != shown);
        model.open(vec![file.clone()]);
        assert_eq!(settle(&mut model, &worker), shown, "the same bytes");
        let again = model.scene();
        assert!(again.method == scene.method && again.image.background == scene.image.background);
        let settings = |scene: &Scene| scene.clouds.iter().map(|c| (c.opacity, c.radius_factor)).collect::<Vec<_>>();
        assert_eq!(settings(again), settings(&scene));
        assert!(matches!(pose, Pose::At(camera) if camera == again.camera), "{:?}", again.camera);
    }
    drop(worker);
}
