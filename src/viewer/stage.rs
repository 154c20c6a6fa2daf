//! A scene on the device, and pictures of it: what `render` does, again and again.

use indicatif::ProgressBar;

use super::draft::{self, Cost};
use super::navigate::Subject;
use super::placed::{Placed, Sources};
use crate::camera::Camera;
use crate::cloud::Cloud;
use crate::gpu::Device;
use crate::methods::brightness::{self, Applied};
use crate::methods::{Frame, Rendered, Renderer, Stop};
use crate::points::Changes;
use crate::scene::{self, CameraSettings, Scene, View};
use crate::{Result, plan};

/// From where a picture is taken.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Pose {
    /// As the scene says.
    Scene,
    /// Such that everything fits, from a side, with perspective.
    View(View),
    /// From here: eye, target and up are given.
    At(CameraSettings),
}

/// A picture and how it came about.
pub struct Taken {
    /// The picture, its times and what it met.
    pub rendered: Rendered,
    /// The frame that it is of.
    pub frame: Frame,
    /// Why this method.
    pub why: String,
    /// By how much it was brightened.
    pub brightness: Option<Applied>,
    /// The points' box, radius and vertical.
    pub subject: Subject,
    /// Whether nothing was left out.
    pub full: bool,
}

/// A renderer with the clouds of one scene.
pub struct Stage {
    renderer: Renderer,
    sources: Sources,
    /// Says what is done to points before they can be rendered, and nothing once they can.
    pub progress: ProgressBar,
    memory_budget: Option<u64>,
    placed: Option<Placed>,
    /// What the last frame of a method took.
    cost: Option<(&'static str, Cost)>,
}

impl Stage {
    pub fn new(device: &Device, clouds: Vec<Cloud>, seed: u64, memory_budget: Option<u64>) -> Result<Self> {
        let renderer = Renderer::new(device)?;
        let (sources, progress) = (Sources::new(clouds, seed), ProgressBar::hidden());
        Ok(Self { renderer, sources, progress, memory_budget, placed: None, cost: None })
    }

    /// The renderer.
    pub fn renderer(&self) -> &Renderer {
        &self.renderer
    }

    /// The clouds as they were read.
    pub fn clouds(&self) -> &[Cloud] {
        self.sources.clouds()
    }

    /// Takes an image back whose memory the next one may have.
    pub fn recycle(&mut self, image: crate::image::Image) {
        self.renderer.recycle(image);
    }

    /// A picture of a scene, of the size that it says. With a budget in milliseconds samples, ensembles or layers may be left
    /// out.
    ///
    /// # Errors
    /// Whatever keeps the scene from being rendered; the next one may do.
    pub fn take(&mut self, scene: &Scene, pose: Pose, budget_ms: Option<f64>) -> Result<Taken> {
        self.place(scene)?;
        let (seed, memory_budget) = (self.sources.seed(), self.memory_budget);
        let Some(placed) = &mut self.placed else { return Err(no_points()) };
        let camera = camera(scene, pose, placed)?;
        let stop = Stop::EightBit { transparent: false };
        let mut frame = Frame { memory_budget, stop, ..Frame::of(scene, camera, seed) };
        let why;
        (frame.method, why) = plan::choose(&mut self.renderer, &mut placed.cloud, placed.arranged.points(), &frame)?;
        let whole = frame.method;
        if let Some(budget) = budget_ms {
            let last = self.cost.filter(|(name, _)| *name == whole.name()).map(|(_, cost)| cost);
            frame.method = draft::within(whole, last, budget);
        }
        let mut rendered = self.renderer.render(&mut placed.cloud, &frame)?;
        let brightness = brightness::apply(&mut self.renderer, &mut placed.cloud, &frame, &mut rendered.image)?;
        let ms = rendered.profile.wall.as_secs_f64() * 1e3;
        let steps = draft::steps(&frame.method).unwrap_or(1);
        self.cost = Some((whole.name(), Cost { ms, steps }));
        let full = frame.method == whole;
        Ok(Taken { rendered, frame, why, brightness, subject: placed.subject, full })
    }

    /// Brings the scene's points to the device: what of them isn't there, or is another than before.
    fn place(&mut self, scene: &Scene) -> Result<Changes> {
        let placed = self.place_quietly(scene);
        self.progress.set_message("");
        placed
    }

    fn place_quietly(&mut self, scene: &Scene) -> Result<Changes> {
        let Self { renderer, sources, progress, placed, .. } = self;
        if let Some(before) = placed {
            match before.follow(renderer, sources, scene, progress) {
                Ok(Some(changes)) => return Ok(changes),
                // The points are elsewhere by now. Freed first, so that old and new never lie in memory together.
                Ok(None) => *placed = None,
                Err(error) => {
                    // Where the device failed, nobody knows what it holds.
                    placed.take_if(|_| !matches!(error, crate::Error::Scene(_)));
                    return Err(error);
                }
            }
        }
        *placed = Some(Placed::new(renderer, sources, scene, progress)?);
        Ok(Changes::ALL)
    }

    /// What a frame would do: its passes and why.
    pub fn plan(&self, taken: &Taken) -> Vec<plan::Step> {
        let Taken { rendered, frame, why, .. } = taken;
        plan::plan(self.renderer.device(), frame, &rendered.facts, self.renderer.wide_atomics, why)
    }
}

pub(super) fn no_points() -> crate::Error {
    scene::Error::NoPoints { clouds: "the scene".into() }.into()
}

fn camera(scene: &Scene, pose: Pose, placed: &Placed) -> Result<Camera> {
    let Placed { subject: Subject { bounds, radius, up }, arranged, .. } = placed;
    let settings = match pose {
        Pose::At(settings) => {
            let found = scene::camera_at(&settings, bounds, *radius);
            return found.ok_or_else(|| scene::Error::Extent { min: bounds.min, max: bounds.max }.into());
        }
        Pose::Scene => scene.camera,
        Pose::View(view) => CameraSettings { view, eye: None, target: None, up: None, height: None, ..scene.camera },
    };
    let framed = Scene { camera: settings, clouds: Vec::new(), ..scene.clone() };
    let (camera, _warnings) = scene::camera(&framed, arranged.points(), *up)?;
    Ok(camera)
}

#[cfg(test)]
mod tests;
