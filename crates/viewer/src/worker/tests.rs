//! Rendering, stopping and reading cameras in the worker.

use pellucid_testing::with_device;

use super::*;
use crate::draft::Effort;
use pellucid_scene::{CameraSettings, Document, Setting};
use pellucid_session::{Clouds, Sources};

#[test]
fn files_without_cameras_are_refused_with_the_formats_that_have_them() {
    let folder = tempfile::tempdir().unwrap();
    let failed = |name: &str, text: &str| {
        let file = folder.path().join(name);
        std::fs::write(&file, text).unwrap();
        match cameras(&file) {
            News::Failed(0, message) => message,
            _ => panic!("{name} holds no cameras"),
        }
    };
    for (text, says) in [
        ("{\"points\": 3}", "has neither keys (a camera path) nor frames"),
        ("solid", ":1:1: "),
        ("{\"version\": 1, \"keys\": []}", "a path has from 1 to"),
    ] {
        let message = failed("a.json", text);
        assert!(message.contains(says) && message.contains("key frames of this program"), "{message}");
        assert!(message.contains("nerfstudio") && message.contains("COLMAP"), "{message}");
    }
    assert!(matches!(cameras(&folder.path().join("none.json")), News::Failed(0, text) if !text.contains("COLMAP")));
}

#[test]
fn a_picture_that_a_later_one_replaces_is_not_rendered() {
    let scene = Document::from_clouds(["a.ply"], &Overrides::default()).unwrap().scene().unwrap();
    let scene = Arc::new(scene);
    let show = |serial| {
        let effort = Effort::Whole;
        Task::Show(Box::new(Request { scene: scene.clone(), pose: Pose::Scene, effort, serial, legend: false }))
    };
    let (sender, waiting) = mpsc::channel();
    for task in [show(2), show(3), Task::Open(Vec::new()), show(4), show(5)] {
        sender.send(task).unwrap();
    }
    let kept: Vec<u64> = latest(show(1), &waiting)
        .iter()
        .map(|task| if let Task::Show(request) = task { request.serial } else { 0 })
        .collect();
    assert_eq!(kept, [3, 0, 5]);
}

const SIZE: [u32; 2] = [48, 32];

/// A worker on a device, with a plane of transparent points, and the document of its scene.
fn working(test: impl FnOnce(&Device, &Worker, Document, &Path)) {
    with_device(|device| work(device, test));
}

fn work(device: &Device, test: impl FnOnce(&Device, &Worker, Document, &Path)) {
    let folder = tempfile::tempdir().unwrap();
    let text: String = (0..300).map(|i| format!("{} {} {} {} 90 20\n", i % 20, i / 20, i % 7, i % 256)).collect();
    let file = folder.path().join("plane.xyz");
    std::fs::write(&file, format!("x y z r g b\n{text}")).unwrap();
    let opened = scene::open(&[file], &Overrides::default(), 0, &Progress::hidden()).unwrap();
    let mut document = opened.document;
    let keys = [
        ("image.size", Setting::Integers(SIZE.to_vec())),
        ("method.name", Setting::Word("weighted".into())),
        ("cloud.0.opacity", Setting::Number(0.6)),
        ("cloud.0.radius", Setting::Number(1.5)),
    ];
    keys.into_iter().for_each(|(key, value)| document.put(key, value).unwrap());
    let clouds = Clouds::Held(opened.clouds.into_iter().map(Into::into).collect());
    let workload = Workload { sources: Sources::new(clouds, u64::MAX, true), generated: false, tasks: Vec::new() };
    let worker =
        Worker::start(device, workload, Setup { seed: 0, memory_budget: None, host_memory: u64::MAX }, false, || {})
            .unwrap();
    test(device, &worker, document, folder.path());
}

/// The next piece of news other than cloud statistics; repeats `meanwhile` until it arrives.
fn news(worker: &Worker, mut meanwhile: impl FnMut()) -> News {
    let until = std::time::Instant::now() + std::time::Duration::from_secs(120);
    loop {
        match worker.news() {
            Some(News::Clouds(_)) => {}
            Some(news) => return news,
            None => assert!(std::time::Instant::now() < until, "no news"),
        }
        meanwhile();
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
}

fn whole(document: &Document, pose: Pose, serial: u64) -> Task {
    let scene = Arc::new(document.scene().unwrap());
    Task::Show(Box::new(Request { scene, pose, effort: Effort::Whole, serial, legend: false }))
}

/// A stop request may be late and hit the next task.
#[test]
fn files_are_written_whenever_rendering_is_stopped() {
    working(|device, worker, document, folder| {
        let to = Some(folder.join("kept.toml"));
        worker.ask(Task::Save(Box::new(Saving { document, stem: String::new(), picture: true, path: None, to })));
        let mut stops = 0;
        let saved = news(worker, || {
            stops += 1;
            if stops < 50 {
                device.allow_submissions(Some(0));
            }
        });
        assert!(matches!(saved, News::Saved(files) if files.len() == 2 && files.iter().all(|file| file.exists())));
    });
}

/// A failed picture may have left other points on the device.
#[test]
fn accuracy_is_that_of_the_picture_that_is_shown() {
    working(|_, worker, mut document, _| {
        let measured = |serial| {
            worker.ask(Task::Measure(serial));
            match news(worker, || {}) {
                News::Measured(of, accuracy) if of == serial => accuracy,
                _ => panic!("not measured"),
            }
        };
        worker.ask(whole(&document, Pose::Scene, 1));
        assert!(matches!(news(worker, || {}), News::Picture(_)));
        let before = measured(1);
        assert!(before.refinements[0].rmse.is_some_and(|rmse| rmse > 1e-4), "{before:?}");
        document.put("cloud.0.opacity", Setting::Number(0.1)).unwrap();
        worker.ask(whole(
            &document,
            Pose::At(CameraSettings { near: Some(2.0), far: Some(1.0), ..CameraSettings::default() }),
            2,
        ));
        assert!(matches!(news(worker, || {}), News::Failed(2, _)));
        assert_eq!(measured(1), before);
    });
}

/// The colors of a moving picture come to the host only if a better one of the same view follows.
#[test]
fn a_moving_picture_is_measured_once_a_better_one_is_there() {
    working(|_, worker, mut document, folder| {
        document.put("method.name", Setting::Word("stochastic".into())).unwrap();
        let show = |document: &Document, effort, serial| {
            let scene = Arc::new(document.scene().unwrap());
            worker.ask(Task::Show(Box::new(Request { scene, pose: Pose::Scene, effort, serial, legend: false })));
            match news(worker, || {}) {
                News::Picture(picture) => picture.accuracy.refinements,
                _ => panic!("no picture"),
            }
        };
        let draft = show(&document, Effort::Moving(1e-6), 1);
        assert!(draft.len() == 1 && draft[0].rmse.is_none(), "{draft:?}");
        let refinements = show(&document, Effort::Whole, 2);
        assert!(refinements.len() == 2 && refinements[0].rmse.is_some_and(|rmse| rmse > 1e-3), "{refinements:?}");
        // The saved picture takes the place of the draft on the device, so the draft can't be measured.
        document.put("cloud.0.opacity", Setting::Number(0.5)).unwrap();
        show(&document, Effort::Moving(1e-6), 3);
        let saving = Saving {
            document: document.clone(),
            stem: String::new(),
            picture: true,
            path: None,
            to: Some(folder.join("kept.toml")),
        };
        worker.ask(Task::Save(Box::new(saving)));
        assert!(matches!(news(worker, || {}), News::Saved(_)));
        let refinements = show(&document, Effort::Whole, 4);
        assert!(refinements.len() == 2 && refinements[0].rmse.is_none(), "{refinements:?}");
    });
}

/// Opens files with the same names and view, but different points.
#[test]
fn files_that_are_opened_again_have_no_accuracy_yet() {
    working(|_, worker, document, folder| {
        worker.ask(whole(&document, Pose::Scene, 1));
        assert!(matches!(news(worker, || {}), News::Picture(_)));
        worker.ask(Task::Open(vec![folder.join("plane.xyz")]));
        assert!(matches!(news(worker, || {}), News::Opened(..)));
        worker.ask(Task::Measure(1));
        let News::Measured(1, accuracy) = news(worker, || {}) else { panic!("not measured") };
        assert!(accuracy.refinements.is_empty(), "{accuracy:?}");
    });
}

/// The thread may start a picture before the requester continues.
#[test]
fn a_picture_is_not_stopped_by_being_asked_for() {
    working(|_, worker, document, _| {
        for serial in 1..=40 {
            worker.ask(whole(&document, Pose::Scene, serial));
            assert!(matches!(news(worker, || {}), News::Picture(picture) if picture.serial == serial));
        }
    });
}

#[test]
fn a_panic_is_news() {
    let (sender, news) = mpsc::channel();
    let (rings, heard) = mpsc::channel();
    let reporter = Reporter { news: sender, bell: Bell(move || rings.send(()).unwrap()) };
    let thread = std::thread::spawn(move || {
        reporter.report(News::Stopped(1));
        // Resumes without the panic hook, which is global and would print.
        std::panic::resume_unwind(Box::new("a bug"));
    });
    for _ in 0..2 {
        heard.recv_timeout(std::time::Duration::from_secs(60)).expect("a ring");
    }
    assert!(matches!(news.try_recv(), Ok(News::Stopped(1))));
    assert!(matches!(news.try_recv(), Err(TryRecvError::Disconnected)), "known before the bell rings");
    assert!(thread.join().is_err());
}
