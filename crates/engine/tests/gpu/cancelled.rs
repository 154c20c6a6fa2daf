//! Frames that an observer cancels, at whichever question: they end before their next submission, and the renderer goes
//! on as if they had not been.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use pellucid_core::points::Points;
use pellucid_core::progress::{Observer, Progress};
use pellucid_engine::methods::{Error, Frame, Renderer};
use pellucid_engine::passes::project::DeviceCloud;
use pellucid_gpu::{self as gpu, Device};
use pellucid_scene::prepare::{Arranged, ensembles, order};
use pellucid_scene::{Light, Method, Shading, ShadingModel, Shadows};
use pellucid_testing::*;

/// Counts the questions of a renderer, and answers with yes from one of them on.
struct Questions {
    asked: AtomicU64,
    first_yes: AtomicU64,
}

#[derive(Clone)]
struct Watch(Arc<Questions>);

impl Observer for Watch {
    fn is_cancelled(&self) -> bool {
        self.0.asked.fetch_add(1, Ordering::Relaxed) >= self.0.first_yes.load(Ordering::Relaxed)
    }
}

impl Watch {
    fn new() -> Self {
        Self(Arc::new(Questions { asked: AtomicU64::new(0), first_yes: AtomicU64::new(u64::MAX) }))
    }

    /// Counts from 0 again, and cancels at the question of that number.
    fn cancel_at(&self, question: u64) {
        self.0.asked.store(0, Ordering::Relaxed);
        self.0.first_yes.store(question, Ordering::Relaxed);
    }

    fn watch_only(&self) {
        self.cancel_at(u64::MAX);
    }

    fn asked(&self) -> u64 {
        self.0.asked.load(Ordering::Relaxed)
    }
}

/// Points with normals, every other one soft.
fn points() -> Points {
    let soup = scene(&soup(5, 600, 0.05..0.3, 0.2..0.9, true));
    order::canonical(Points { fields: (0..soup.len()).map(|i| (i % 2) as f32).collect(), ..soup })
}

/// A frame of every method, one with shadows, and one that is cut into windows and bands. Nothing of them is read from
/// the device but their windows.
fn frames() -> Vec<Frame> {
    let plain = |method| Frame { fragments: false, ..frame(perspective(), [60, 44], method) };
    let mut all: Vec<Frame> = Method::all().into_iter().map(plain).collect();
    let light = Light::Direction(glam::DVec3::new(-1.0, -2.0, -0.5));
    all.push(Frame {
        shading: Shading { model: ShadingModel::Lambert, light, ..Shading::default() },
        shadows: Some(Shadows { samples: 3, light_radius: 10.0, ..Shadows::default() }),
        ..plain(Method::Points)
    });
    all.push(Frame { memory_budget: Some(64 << 10), ..plain(Method::ABuffer(Default::default())) });
    all
}

fn arranged(frame: &Frame) -> Arranged {
    if frame.method.is_dealt() {
        Arranged::Dealt(ensembles::deal(vec![points()], frame.seed, &Progress::hidden()))
    } else {
        Arranged::Canonical(points().into())
    }
}

/// A renderer that is watched, and the points of a frame.
fn watched(device: &Device, frame: &Frame) -> (Renderer, Watch, Arranged) {
    let (mut renderer, watch) = (Renderer::new(device).expect("a renderer"), Watch::new());
    renderer.progress = Progress::observed(watch.clone());
    (renderer, watch, arranged(frame))
}

/// The frame's bytes; `None` if the device cannot render it.
fn fresh(device: &Device, frame: &Frame) -> Option<Vec<u32>> {
    let mut renderer = Renderer::new(device).expect("a renderer");
    let mut cloud = renderer.upload(&arranged(frame)).expect("fits");
    match renderer.render(&mut cloud, frame) {
        Ok(rendered) => Some(bits(&rendered.image)),
        Err(error @ (Error::NoSubgroups { .. } | Error::NoHardwareRaster { .. })) => {
            println!("not applicable: {error}");
            None
        }
        Err(error) => panic!("{}: {error}", frame.method.name()),
    }
}

#[test]
fn a_cancelled_frame_ends_at_once_and_leaves_nothing_behind() {
    with_device(|device| {
        for (number, frame) in frames().into_iter().enumerate() {
            let Some(wanted) = fresh(device, &frame) else { continue };
            let name = frame.method.name();
            let (mut renderer, watch, arranged) = watched(device, &frame);
            let upload = |renderer: &Renderer| renderer.upload(&arranged).expect("fits");
            for steady in [false, true] {
                // A cloud of its own: its shadows are found under way, unless it is steady.
                let mut cloud = upload(&renderer);
                become_known(&mut renderer, &mut cloud, &frame, steady);
                watch.watch_only();
                let whole = renderer.render(&mut cloud, &frame).expect("watching changes nothing");
                assert!(bits(&whole.image) == wanted, "{name}");
                let questions = watch.asked();
                assert!(questions > 2, "{name}: {questions}");
                // The one in the middle by turns with the first and the last: every pair of frame, state and question.
                let all = [0, questions / 2, questions - 1];
                for question in all.into_iter().skip((number + usize::from(steady)) % 2).step_by(2) {
                    let mut cloud = upload(&renderer);
                    watch.watch_only();
                    become_known(&mut renderer, &mut cloud, &frame, steady);
                    watch.cancel_at(question);
                    let cancelled = renderer.render(&mut cloud, &frame);
                    assert!(matches!(cancelled, Err(Error::Cancelled)), "{name}, {question} of {questions}, {steady}");
                    assert_eq!(watch.asked(), question + 1, "{name}: nobody asks after a yes");
                    watch.watch_only();
                    let next = renderer.render(&mut cloud, &frame).expect("the next frame renders");
                    assert!(bits(&next.image) == wanted, "{name}, after {question} of {questions}");
                }
            }
        }
    });
}

/// Makes the counts of a frame known from earlier ones if it is to be `steady`, or forgotten.
fn become_known(renderer: &mut Renderer, cloud: &mut DeviceCloud, frame: &Frame, steady: bool) {
    if steady {
        renderer.render(cloud, frame).expect("renders");
        renderer.render(cloud, frame).expect("renders");
    } else {
        renderer.forget();
    }
}

/// Renders with so many submissions; true if they were enough.
fn renders_with(device: &Device, renderer: &mut Renderer, cloud: &mut DeviceCloud, frame: &Frame, most: u64) -> bool {
    device.allow_submissions(Some(most));
    let rendered = renderer.render(cloud, frame);
    device.allow_submissions(None);
    match rendered {
        Ok(_) => true,
        Err(Error::Gpu(gpu::Error::Stopped { .. })) => false,
        Err(error) => panic!("{}: {error}", frame.method.name()),
    }
}

/// A renderer asks once before it brings the points, once before each submission of a frame whose counts it waits for,
/// and once for each window that is done.
#[test]
fn a_renderer_asks_before_every_submission() {
    with_device(|device| {
        for frame in frames() {
            if fresh(device, &frame).is_none() {
                continue;
            }
            let (mut renderer, watch, arranged) = watched(device, &frame);
            let mut cloud = renderer.upload(&arranged).expect("fits");
            // Points, shadows and orders come to the device with the first frame.
            renderer.render(&mut cloud, &frame).expect("renders");
            renderer.forget();
            watch.watch_only();
            let windows = renderer.render(&mut cloud, &frame).expect("renders").facts.windows;
            let (name, submissions) = (frame.method.name(), watch.asked() - 1 - windows);
            for (most, enough) in [(submissions, true), (submissions - 1, false)] {
                renderer.forget();
                let renders = renders_with(device, &mut renderer, &mut cloud, &frame, most);
                assert_eq!(renders, enough, "{name}: {most} of {submissions}");
            }
        }
    });
}

#[test]
fn a_survey_can_be_cancelled() {
    with_device(|device| {
        let frame = frame(perspective(), [60, 44], Method::ABuffer(Default::default()));
        let (mut renderer, watch, arranged) = watched(device, &frame);
        let mut cloud = renderer.upload(&arranged).expect("fits");
        let wanted = renderer.survey(&mut cloud, &frame).expect("counts");
        for question in 0..watch.asked() {
            watch.cancel_at(question);
            assert!(matches!(renderer.survey(&mut cloud, &frame), Err(Error::Cancelled)), "{question}");
        }
        watch.watch_only();
        assert_eq!(renderer.survey(&mut cloud, &frame).expect("counts"), wanted);
    });
}
