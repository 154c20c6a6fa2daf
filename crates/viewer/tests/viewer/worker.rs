//! Rendering, stopping and measuring in the worker.

use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

use pellucid_core::cloud::Cloud;
use pellucid_core::progress::Progress;
use pellucid_gpu::Device;
use pellucid_scene::{self as scene, CameraSettings, Document, Overrides, Setting};
use pellucid_session::{Clouds, Sources};
use pellucid_testing::with_device;
use pellucid_viewer::draft::Effort;
use pellucid_viewer::messages::{News, Request, Saving, Setup, Task};
use pellucid_viewer::navigate::Pose;
use pellucid_viewer::worker::{Worker, Workload};

const SIZE: [u32; 2] = [48, 32];

/// A worker on a device that has these clouds in memory.
pub fn started(device: &Device, clouds: Vec<Cloud>, generated: bool, seed: u64) -> Worker {
    let clouds = Clouds::Held(clouds.into_iter().map(Into::into).collect());
    let workload = Workload { sources: Sources::new(clouds, u64::MAX, true), generated, tasks: Vec::new() };
    let setup = Setup { seed, memory_budget: None, host_memory: u64::MAX };
    Worker::start(device, workload, setup, false, || {}).unwrap()
}

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
    let worker = started(device, opened.clouds, false, 0);
    test(device, &worker, document, folder.path());
}

/// The next piece of news other than cloud statistics; repeats `meanwhile` until it arrives.
fn news(worker: &Worker, mut meanwhile: impl FnMut()) -> News {
    let until = Instant::now() + Duration::from_secs(120);
    loop {
        match worker.news() {
            Some(News::Clouds(_)) => {}
            Some(news) => return news,
            None => assert!(Instant::now() < until, "no news"),
        }
        meanwhile();
        std::thread::sleep(Duration::from_millis(1));
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
