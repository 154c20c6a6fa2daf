//! Renders the frames of a path by all methods.

use glam::Vec3;
use pellucid_core::camera::Camera;
use pellucid_core::image::LinearImage;
use pellucid_core::progress::Progress;
use pellucid_engine::Result;
use pellucid_engine::methods::{self, Frame, Renderer, Upload};
use pellucid_gpu::Device;
use pellucid_io::output::linear;
use pellucid_scene::Method;
use pellucid_scene::prepare::Arranged;

use super::{Candidate, Follower, Popping, Refused};
use pellucid_session::choice::Renderers;

/// Subject of a film.
#[derive(Debug, Clone, Copy)]
pub struct Film<'a> {
    /// The scene's points.
    pub arranged: &'a Arranged,
    /// The frame with the exact method ([`exact`](super::exact)); its camera is replaced.
    pub frame: &'a Frame,
    /// Linear RGB.
    pub background: Vec3,
    /// The camera of each frame.
    pub cameras: &'a [Camera],
}

/// Follows the methods along the path. Each frame has the same seed, as in `render`. `progress` counts frames of all
/// methods.
///
/// # Errors
/// The exact method can't render a frame, a lost device, a message of the validation layers. A method that can't render
/// one is left out.
pub fn measure(device: &Device, film: &Film<'_>, candidates: &[Candidate], progress: &Progress) -> Result<Popping> {
    progress.set_length(((1 + candidates.len()) * film.cameras.len()) as u64);
    let mut first = Renderer::new(device)?;
    let mut cloud = first.upload(Upload::with_detail(film.arranged, &film.frame.detail))?;
    // The others take about as much memory as this one.
    let peak = first.render(&mut cloud, film.frame)?.facts.peak_device_bytes;
    drop(first);
    let names = candidates.iter().map(|candidate| &candidate.method).chain([&film.frame.method]);
    let mut renderers = Renderers::new(device, names.map(|method| (method.name(), peak)));
    let mut followers: Vec<Result<Follower, String>> = candidates.iter().map(|_| Ok(Follower::default())).collect();
    for (number, camera) in film.cameras.iter().enumerate() {
        let mut take = |frame: Frame| -> Result<LinearImage, methods::Error> {
            progress.set_message(format!("popping, frame {number}, {}", frame.method.name()));
            progress.inc(1);
            let renderer = renderers.for_method(frame.method.name())?;
            let rendered = renderer.render(&mut cloud, &Frame { camera: *camera, ..frame })?;
            let image = linear(&rendered.image, film.background, frame.color);
            renderer.recycle(rendered.image);
            Ok(image)
        };
        let exact = take(*film.frame)?;
        for (candidate, follower) in candidates.iter().zip(&mut followers) {
            let Ok(followed) = follower else { continue };
            match take(Frame { method: candidate.method, ..*film.frame }) {
                Ok(image) => _ = followed.add(&exact, &image),
                Err(error) if error.is_refusal() => *follower = Err(error.to_string()),
                Err(error) => return Err(error.into()),
            }
        }
        device.check_validation()?;
    }
    Ok(report(film, candidates, followers))
}

/// An exact method with its order of Gaussians, if it was given one.
pub fn named(exact: &Method) -> String {
    let order = exact.discs().and_then(|discs| discs.gaussians.order);
    format!("{}{}", exact.name(), order.map_or_else(String::new, |order| format!(" order={}", order.word())))
}

fn report(film: &Film<'_>, candidates: &[Candidate], followers: Vec<Result<Follower, String>>) -> Popping {
    let mut popping = Popping {
        exact: named(&film.frame.method),
        frames: film.cameras.len() as u32,
        curves: Vec::new(),
        refused: Vec::new(),
    };
    for (candidate, follower) in candidates.iter().zip(followers) {
        match follower {
            Ok(follower) => popping.curves.push(follower.curve(candidate)),
            Err(reason) => {
                let method = format!("{} {}", candidate.method.name(), candidate.setting).trim_end().to_owned();
                popping.refused.push(Refused { method, reason });
            }
        }
    }
    popping
}
