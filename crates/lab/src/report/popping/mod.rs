//! Popping: how much the error of a method changes from one frame of a camera path to the next.
//!
//! A picture that moves shows an error twice: by what is wrong in each frame, and by how that jumps. The first is the
//! error of [`tradeoff`](super::tradeoff); an error that stays as it is looks like another scene, and is not counted
//! here.

mod follower;
mod page;

use glam::Vec3;
use pellucid_core::camera::Camera;
use pellucid_core::image::LinearImage;
use pellucid_core::points::Points;
use pellucid_core::progress::Progress;
use pellucid_engine::methods::{self, Frame, Renderer, Upload, linear};
use pellucid_engine::{Result, plan};
use pellucid_gpu::Device;
use pellucid_scene::prepare::Arranged;
use pellucid_scene::{Discs, Family, GaussianSettings, Method, Order};
use pellucid_session::choice::Renderers;
use serde::{Deserialize, Serialize};

pub use follower::Follower;
pub use page::{csv, popping_table, write};

pub(super) use page::{over_frames, section};

/// Error of a method in a single frame.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct FrameError {
    /// Number of the frame, from 0.
    pub frame: u32,
    /// RMSE of the frame against the exact one.
    pub error: f64,
    /// RMSE of the change of the error since the frame before; `None` for the first frame.
    pub rmse: Option<f64>,
    /// FLIP of that change ([`Follower::add`]), in [0, 1].
    pub flip: Option<f64>,
}

/// The frames of a method, and the figures over all of them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Curve {
    /// Name of the method.
    pub method: String,
    /// Setting of the method as options of the command line would give it; empty for the scene's own.
    pub setting: String,
    /// Errors of the frames, in the order of the path.
    pub frames: Vec<FrameError>,
    /// Mean of the errors.
    pub mean_error: f64,
    /// Mean and greatest RMSE of the changes; 0 for a single frame.
    pub mean_rmse: f64,
    /// See `mean_rmse`.
    pub worst_rmse: f64,
    /// The frame with the greatest RMSE: the change came with it.
    pub worst_frame: u32,
    /// Mean and greatest FLIP of the changes.
    pub mean_flip: f64,
    /// See `mean_flip`.
    pub worst_flip: f64,
}

impl Curve {
    /// The curve of some frames.
    pub fn new(candidate: &Candidate, frames: Vec<FrameError>) -> Self {
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len().max(1) as f64;
        let errors: Vec<f64> = frames.iter().map(|frame| frame.error).collect();
        let changes: Vec<f64> = frames.iter().filter_map(|frame| frame.rmse).collect();
        let flips: Vec<f64> = frames.iter().filter_map(|frame| frame.flip).collect();
        // The first one of equals.
        let worst =
            frames.iter().filter(|frame| frame.rmse.is_some()).rev().max_by(|a, b| a.rmse().total_cmp(&b.rmse()));
        Self {
            method: candidate.method.name().to_owned(),
            setting: candidate.setting.clone(),
            mean_error: mean(&errors),
            mean_rmse: mean(&changes),
            worst_rmse: worst.map_or(0.0, FrameError::rmse),
            worst_frame: worst.map_or(0, |frame| frame.frame),
            mean_flip: mean(&flips),
            worst_flip: flips.iter().copied().fold(0.0, f64::max),
            frames,
        }
    }

    /// Method and setting, as one would say it.
    pub fn name(&self) -> String {
        format!("{} {}", self.method, self.setting.replace("method.", "")).trim_end().to_owned()
    }
}

impl FrameError {
    fn rmse(&self) -> f64 {
        self.rmse.unwrap_or(0.0)
    }
}

/// A method that could not be measured, and why.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Refused {
    /// Method and setting, as one would say it.
    pub method: String,
    /// Reason for the omission.
    pub reason: String,
}

/// The popping of some methods along a path.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Popping {
    /// The method that made the exact frames, with its settings where they are not the scene's.
    pub exact: String,
    /// Number of frames.
    pub frames: u32,
    /// A curve for each method.
    pub curves: Vec<Curve>,
    /// The methods without one.
    pub refused: Vec<Refused>,
}

/// A method with its setting.
#[derive(Debug, Clone, PartialEq)]
pub struct Candidate {
    /// The method to render.
    pub method: Method,
    /// Setting as options of the command line would give it, in addition to `--method`; empty for the scene's own.
    pub setting: String,
}

/// The method whose frames are exact for a method of discs, Gaussians or soft spheres; `None` for others. Gaussians are
/// ordered in each pixel whatever the method's own order is, since an order by centers is what pops.
pub fn exact(method: &Method, points: &Points) -> Option<Method> {
    match plan::exact(method, points)? {
        Method::ABuffer(discs) if points.gaussians.is_some() => Some(Method::ABuffer(ordered(discs, Order::Pixel))),
        found @ (Method::ABuffer(_) | Method::SoftBase(_)) => Some(found),
        _ => None,
    }
}

/// The methods of a scene's image formation with its settings: those named, or all that are not exact. Of Gaussians
/// that are sorted once both orders.
pub fn candidates(method: &Method, points: &Points, only: &[String]) -> Vec<Candidate> {
    let own = |method: Method| Candidate { method, setting: String::new() };
    let mut all = match plan::exact(method, points) {
        Some(Method::ABuffer(discs)) if points.gaussians.is_some() => {
            let family = Family::Discs.methods().map(|method| method.with_keys(&discs.keys()));
            let others = family.filter(|method| !matches!(method, Method::Sorted(_))).map(own);
            sorted(discs).into_iter().chain(others).collect()
        }
        Some(Method::ABuffer(discs)) => {
            Family::Discs.methods().map(|method| own(method.with_keys(&discs.keys()))).collect::<Vec<_>>()
        }
        Some(Method::SoftBase(soft)) => {
            Family::Soft.methods().map(|method| own(method.with_keys(&soft.keys()))).collect()
        }
        _ => Vec::new(),
    };
    all.retain(|candidate| match only {
        [] => !is_exact(&candidate.method, points),
        names => names.iter().any(|name| name == candidate.method.name()),
    });
    all
}

/// Gaussians sorted once, in both ways.
fn sorted(discs: Discs) -> [Candidate; 2] {
    [Order::Center, Order::Distance].map(|order| Candidate {
        method: Method::Sorted(ordered(discs, order)),
        setting: format!("method.order={}", order.word()),
    })
}

fn ordered(discs: Discs, order: Order) -> Discs {
    Discs { gaussians: GaussianSettings { order: Some(order), ..discs.gaussians }, ..discs }
}

/// True if the frames are those of the exact method, except for rounding.
fn is_exact(method: &Method, points: &Points) -> bool {
    let has_gaussians = points.gaussians.is_some();
    let crossing = has_gaussians || points.normals.is_some();
    method.is_exact(crossing) && (!has_gaussians || method.order() == Order::Pixel)
}

/// Subject of a film.
#[derive(Debug, Clone, Copy)]
pub struct Film<'a> {
    /// The scene's points.
    pub arranged: &'a Arranged,
    /// The frame with the exact method ([`exact`]); its camera is replaced.
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
            let image = linear(&rendered.image, film.background, frame.color)?;
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

#[cfg(test)]
mod tests {
    use pellucid_core::cloud::gaussians::Gaussians;
    use pellucid_scene::Spbr;

    use super::*;

    fn names(method: Method, points: &Points, only: &[&str]) -> Vec<String> {
        let only: Vec<String> = only.iter().map(|name| (*name).to_owned()).collect();
        let name = |c: &Candidate| format!("{} {}", c.method.name(), c.setting).trim_end().to_owned();
        candidates(&method, points, &only).iter().map(name).collect()
    }

    #[test]
    fn exact_methods_are_followed_only_if_they_are_named() {
        let discs = Method::ABuffer(Discs::default());
        let approximate = ["stochastic", "hybrid", "mlab", "moments", "wavelet", "weighted", "average", "unsorted"];
        assert_eq!(names(discs, &Points::default(), &[]), approximate);
        assert_eq!(names(discs, &Points::default(), &["peel", "sorted"]), ["sorted", "peel"]);
        let gaussians = Points { gaussians: Some(Gaussians::default()), ..Points::default() };
        let sorted = ["sorted method.order=center", "sorted method.order=distance"];
        assert_eq!(names(discs, &gaussians, &[]), [&sorted[..], &approximate].concat());
        // An order by centers is not exact, whichever method has it.
        let centers = Method::ABuffer(ordered(Discs::default(), Order::Center));
        assert!(names(centers, &gaussians, &[]).contains(&"abuffer".to_owned()));
        assert_eq!(exact(&centers, &gaussians).unwrap().order(), Order::Pixel);
        assert_eq!(exact(&Method::Spbr(Spbr::default()), &gaussians), None);
        assert_eq!(names(Method::Spbr(Spbr::default()), &gaussians, &[]), Vec::<String>::new());
    }
}
