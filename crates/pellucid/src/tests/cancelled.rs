//! Loading and frames that an observer cancels: an error of that kind, and nothing else changes.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use pellucid::{Camera, Cloud, ErrorKind, Loaded, Observer, Picture, Renderer, Result, Scene};
use pellucid_testing::has_device;

/// Counts questions from 0, and answers with yes from one of them on.
#[derive(Clone)]
struct Watch {
    asked: Arc<AtomicU64>,
    first_yes: Arc<AtomicU64>,
}

impl Watch {
    fn new() -> Self {
        Self { asked: Arc::default(), first_yes: Arc::new(AtomicU64::new(u64::MAX)) }
    }

    fn cancel_at(&self, question: u64) {
        self.asked.store(0, Ordering::Relaxed);
        self.first_yes.store(question, Ordering::Relaxed);
    }

    fn asked(&self) -> u64 {
        self.asked.load(Ordering::Relaxed)
    }
}

impl Observer for Watch {
    fn is_cancelled(&self) -> bool {
        self.asked.fetch_add(1, Ordering::Relaxed) >= self.first_yes.load(Ordering::Relaxed)
    }
}

fn scene() -> Result<Scene> {
    let positions: Vec<[f64; 3]> = (0..200).map(|i| f64::from(i) * 0.1).map(|a| [a.cos(), a.sin(), 0.05 * a]).collect();
    let cloud = Cloud::from_positions(positions).radius(0.2).opacity(0.5).build()?;
    let mut scene = Scene::from_clouds([cloud])?;
    scene.set("image.size", [48, 36])?;
    Ok(scene)
}

fn render(loaded: &mut Loaded) -> Result<Picture> {
    let camera = Camera::look_at([0.0, -3.0, 4.0], [0.0, 0.0, 0.5], [0.0, 1.0, 0.0]);
    loaded.frame().camera(camera).render()
}

#[test]
fn cancelled_frames_leave_nothing_behind() -> Result<()> {
    if !has_device() {
        return Ok(());
    }
    let (mut scene, watch) = (scene()?, Watch::new());
    scene.set("method.name", "abuffer")?;
    let wanted = render(&mut Renderer::open()?.load(&scene)?)?;
    let mut loaded = Renderer::open()?.observed_by(watch.clone()).load(&scene)?;
    watch.cancel_at(u64::MAX);
    assert_eq!(render(&mut loaded)?.pixels(), wanted.pixels());
    let questions = watch.asked();
    assert!(questions > 2, "{questions}");
    for question in [0, questions / 2, questions - 1] {
        watch.cancel_at(question);
        let error = render(&mut loaded).err().expect("cancelled");
        assert_eq!((error.kind(), error.to_string().as_str()), (ErrorKind::Cancelled, "cancelled"), "{question}");
        watch.cancel_at(u64::MAX);
        let next = render(&mut loaded)?;
        assert_eq!((next.pixels(), next.depth()), (wanted.pixels(), wanted.depth()), "{question} of {questions}");
    }
    Ok(())
}

#[test]
fn loading_can_be_cancelled() -> Result<()> {
    if !has_device() {
        return Ok(());
    }
    let (scene, watch) = (scene()?, Watch::new());
    let renderer = Renderer::open()?.observed_by(watch.clone());
    renderer.load(&scene)?;
    for question in 0..watch.asked() {
        watch.cancel_at(question);
        let error = renderer.load(&scene).err().expect("cancelled");
        assert_eq!(error.kind(), ErrorKind::Cancelled, "{question}");
    }
    Ok(())
}
