//! Popping: how much the error of a method changes from one frame of a camera path to the next.
//!
//! A picture that moves shows an error twice: by what is wrong in each frame, and by how that jumps. The first is the
//! error of [`tradeoff`](super::tradeoff); an error that stays as it is looks like another scene, and is not counted
//! here.

mod follower;
mod page;
mod roll;

use glam::Vec3;
use pellucid_core::camera::Camera;
use pellucid_core::image::LinearImage;
use pellucid_core::points::Points;
use pellucid_core::progress::Progress;
use pellucid_engine::methods::{self, Frame, Renderer, Upload, linear};
use pellucid_engine::passes::project::DeviceCloud;
use pellucid_engine::{Result, plan};
use pellucid_gpu::Device;
use pellucid_scene::prepare::Arranged;
use pellucid_scene::{Discs, Family, GaussianSettings, Method, Order};
use pellucid_session::candidates::Surfaces;
use pellucid_session::choice::Renderers;
use serde::{Deserialize, Serialize};

use super::tradeoff::supersampled;

pub use follower::Follower;
pub use page::{csv, popping_table, write};

pub(super) use page::{over_frames, section};
use roll::rolled;

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
    /// Mean RMSE of the changes if the camera rolls instead, so that the picture moves as much and no point changes its
    /// depth; `None` where it isn't measured, as of transparent points.
    #[serde(default)]
    pub rolled_rmse: Option<f64>,
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
            rolled_rmse: None,
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
    /// The method that made the exact frames, or for opaque points those of their surfaces, with its settings where
    /// they are not the scene's.
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

/// The method whose frames those of a method are compared with: the exact one ([`exact`]), or for opaque points the one
/// that draws surfaces best with many samples in a pixel; `None` for others.
pub fn reference(method: &Method, points: &Points) -> Option<Method> {
    exact(method, points).or_else(|| Some(Surfaces::for_method(method, points)?.reference()))
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
        Some(_) => Vec::new(),
        None => Surfaces::for_method(method, points)
            .map_or_else(Vec::new, |all| all.alike(method).into_iter().map(own).collect()),
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
    /// The frame with the method of the reference ([`reference()`]); its camera is replaced.
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
/// The method of the reference can't render a frame, a lost device, a message of the validation layers. A method that
/// can't render one is left out.
pub fn measure(device: &Device, film: &Film<'_>, candidates: &[Candidate], progress: &Progress) -> Result<Popping> {
    let is_surface = is_surface(&film.frame.method);
    let cameras = film.cameras.len() + if is_surface { film.cameras.len().saturating_sub(1) } else { 0 };
    progress.set_length(((1 + candidates.len()) * cameras) as u64);
    let mut first = Renderer::new(device)?;
    let mut cloud = first.upload(Upload::with_detail(film.arranged, &film.frame.detail))?;
    // The others take about as much memory as this one.
    let peak = first.render(&mut cloud, film.frame)?.facts.peak_device_bytes;
    drop(first);
    let names = candidates.iter().map(|candidate| &candidate.method).chain([&film.frame.method]);
    let renderers = Renderers::new(device, names.map(|method| (method.name(), peak)));
    let mut shot = Shot { film, progress, renderers, cloud, samples_across: 1 };
    let positions = &film.arranged.points().positions;
    let mut followers: Vec<Result<Follower, String>> = candidates.iter().map(|_| Ok(Follower::default())).collect();
    for (number, camera) in film.cameras.iter().enumerate() {
        let before = number.checked_sub(1).filter(|_| is_surface).map(|before| &film.cameras[before]);
        let roll = before.map(|before| rolled([before, camera], positions, film.frame.size));
        for (camera, is_rolled) in roll.iter().map(|roll| (roll, true)).chain([(camera, false)]) {
            progress.set_message(format!("popping, frame {number}"));
            let exact = shot.exact(camera)?;
            for (candidate, follower) in candidates.iter().zip(&mut followers) {
                let Ok(followed) = follower else { continue };
                match shot.image(camera, candidate.method) {
                    Ok(image) if is_rolled => followed.add_rolled(&exact, &image),
                    Ok(image) => _ = followed.add(&exact, &image),
                    Err(error) if error.is_refusal() => *follower = Err(error.to_string()),
                    Err(error) => return Err(error.into()),
                }
            }
        }
        device.check_validation()?;
    }
    Ok(report(shot.named(), film, candidates, followers))
}

/// Renders the frames of a film.
struct Shot<'a> {
    film: &'a Film<'a>,
    progress: &'a Progress,
    renderers: Renderers,
    cloud: DeviceCloud,
    /// Samples across a pixel of the last exact frame.
    samples_across: u32,
}

impl Shot<'_> {
    /// The frame of a method by a camera.
    fn image(&mut self, camera: &Camera, method: Method) -> Result<LinearImage, methods::Error> {
        self.progress.inc(1);
        let renderer = self.renderers.for_method(method.name())?;
        let rendered = renderer.render(&mut self.cloud, &Frame { camera: *camera, method, ..*self.film.frame })?;
        let image = linear(&rendered.image, self.film.background, self.film.frame.color)?;
        renderer.recycle(rendered.image);
        Ok(image)
    }

    /// The frame that others are compared with.
    fn exact(&mut self, camera: &Camera) -> Result<LinearImage, methods::Error> {
        let frame = Frame { camera: *camera, ..*self.film.frame };
        if !is_surface(&frame.method) {
            return self.image(camera, frame.method);
        }
        self.progress.inc(1);
        let renderer = self.renderers.for_method(frame.method.name())?;
        let made = supersampled(renderer, &mut self.cloud, &frame, self.film.background)?;
        self.samples_across = made.samples_across;
        Ok(made.image)
    }

    /// Says what made the exact frames.
    fn named(&self) -> String {
        let (method, across) = (&self.film.frame.method, self.samples_across);
        match is_surface(method) {
            false => named(method),
            true => format!("{} with {across} × {across} samples in a pixel", method.name()),
        }
    }
}

/// True for methods that draw surfaces, whose frames are no reference unless they have many samples in a pixel.
fn is_surface(method: &Method) -> bool {
    matches!(method, Method::Hqs(_) | Method::Splats(_))
}

/// An exact method with its order of Gaussians, if it was given one.
pub fn named(exact: &Method) -> String {
    let order = exact.discs().and_then(|discs| discs.gaussians.order);
    format!("{}{}", exact.name(), order.map_or_else(String::new, |order| format!(" order={}", order.word())))
}

fn report(
    exact: String,
    film: &Film<'_>,
    candidates: &[Candidate],
    followers: Vec<Result<Follower, String>>,
) -> Popping {
    let mut popping = Popping { exact, frames: film.cameras.len() as u32, curves: Vec::new(), refused: Vec::new() };
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
    use pellucid_scene::{ScreenSplats, Spbr};

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

    #[test]
    fn opaque_methods_are_followed_against_blended_splats() {
        let circles = Method::Circles(ScreenSplats::default());
        let opaque = ["points", "squares", "circles", "paraboloid", "cone", "sphere", "hqs", "image-space"];
        assert_eq!(names(circles, &Points::default(), &[]), opaque);
        assert_eq!(names(Method::Points, &Points::default(), &["cone", "circles"]), ["circles", "cone"]);
        let with_normals = Points { normals: Some(Vec::new()), ..Points::default() };
        let reference_of = |points: &Points| reference(&circles, points).map(|method| method.name());
        assert_eq!([reference_of(&Points::default()), reference_of(&with_normals)], [Some("hqs"), Some("splats")]);
    }
}
