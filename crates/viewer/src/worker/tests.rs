//! The queue of tasks, reading cameras, and the end of the thread.

use super::*;
use crate::draft::Effort;
use pellucid_scene::Document;

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
