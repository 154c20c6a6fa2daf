//! A frame that is stopped, at whichever submission, leaves nothing behind: the next one of the same renderer and cloud
//! is as if it had not been.

use std::collections::HashSet;

use pellucid_engine::methods::{Error, Frame, Renderer};
use pellucid_gpu::{self as gpu, Device};
use pellucid_lab::check::{self, Lack, MethodScene};
use pellucid_scene::Kernel;
use pellucid_testing::{is_llvmpipe, with_device};

use crate::by_halves;

/// Frames that are stopped on llvmpipe, for all subjects together.
const STOPS: u64 = 120;

/// The first subject of each method, and the first with what has buffers of its own beside those of its method. A
/// stopped frame leaves nothing behind but what lies in buffers.
fn subjects() -> Vec<MethodScene> {
    let mut seen = HashSet::new();
    let buffers = |Frame { method, shadows, .. }: &Frame| {
        let kernel = method.discs().map(|discs| discs.gaussians.kernel);
        (method.name(), kernel == Some(Kernel::Ellipsoid), shadows.is_some())
    };
    check::subjects().into_iter().filter(|subject| seen.insert(buffers(&subject.frame))).collect()
}

/// The first submissions one by one, then fewer and fewer of them.
fn places() -> impl Iterator<Item = u64> {
    std::iter::successors(Some(0), |k| Some(k + 1 + k / 8))
}

/// Stops at place after place until a frame gets through; how many were stopped, or what is wrong.
fn stop_everywhere(device: &Device, renderer: &mut Renderer, subject: &MethodScene) -> Result<u64, String> {
    let arranged = subject.arranged();
    let first = match subject.render_arranged(renderer, &arranged) {
        Ok(first) => first,
        Err(error) if Lack::in_error(&error).is_some() => return Ok(0),
        Err(error) => return Err(format!("{error}")),
    };
    for (stops, allowed) in places().enumerate() {
        // A cloud of its own: what is found for it, axes and shadows, is found under way.
        let mut cloud = renderer.upload(&arranged).map_err(|error| format!("upload: {error}"))?;
        // A frame that waits for its counts submits most often.
        renderer.forget();
        device.allow_submissions(Some(allowed));
        let stopped = renderer.render(&mut cloud, &subject.frame);
        device.allow_submissions(None);
        match &stopped {
            Ok(_) => {}
            Err(Error::Gpu(gpu::Error::Stopped { .. })) => {}
            Err(error) => return Err(format!("after {allowed} submissions: {error}")),
        }
        let next = renderer.render(&mut cloud, &subject.frame);
        let next = next.map_err(|error| format!("the frame after one of {allowed} submissions: {error}"))?;
        if let Some(difference) = check::difference(&first.image, &next.image) {
            return Err(format!("the frame after one of {allowed} submissions: {difference}"));
        }
        if stopped.is_ok() {
            return Ok(stops as u64);
        }
    }
    unreachable!("a frame has an end")
}

#[test]
fn a_frame_that_is_stopped_leaves_nothing_behind() {
    let halves = by_halves(|half| {
        let mut stopped = None;
        with_device(|device| {
            let (mut renderer, mut wrong, mut stops) = (Renderer::new(device).expect("a renderer"), Vec::new(), 0);
            for subject in subjects().iter().skip(half).step_by(2) {
                match stop_everywhere(device, &mut renderer, subject) {
                    Ok(count) => stops += count,
                    Err(problem) => wrong.push(format!("{}: {problem}", subject.name)),
                }
            }
            assert!(wrong.is_empty(), "{}", wrong.join("\n"));
            stopped = Some((stops, is_llvmpipe(device)));
        });
        stopped
    });
    // Without a device both were skipped.
    let [Some((a, is_llvmpipe)), Some((b, _))] = halves else { return };
    println!("{} frames were stopped", a + b);
    // Each submits at least once; on llvmpipe, which renders all of them, as often as it was counted.
    assert!(a + b >= 12, "{}", a + b);
    if is_llvmpipe {
        assert_eq!(a + b, STOPS, "a frame that submits more or less often changes this number");
    }
}
