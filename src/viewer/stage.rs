//! A scene on the device, and pictures of it: what `render` does, again and again.

use indicatif::ProgressBar;

use super::census::{Histograms, Spread};
use super::draft::{self, Cost};
use super::navigate::Subject;
use crate::camera::Camera;
use crate::cloud::Cloud;
use crate::gpu::Device;
use crate::methods::brightness::{self, Applied};
use crate::methods::{Frame, Rendered, Renderer, Stop};
use crate::passes::project::DeviceCloud;
use crate::points::Arranged;
use crate::prepare::{self, Request};
use crate::scene::{self, CameraSettings, CloudSettings, Scene, View};
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

/// Of the points: what they depend on.
#[derive(Debug, Clone, PartialEq)]
struct Arrangement {
    clouds: Vec<CloudSettings>,
    dealt: bool,
    radii: bool,
    fields: bool,
    shadows: Option<scene::Shadows>,
}

impl Arrangement {
    fn of(scene: &Scene) -> Self {
        let method = &scene.method;
        // Where a cloud came from doesn't matter any more.
        let clouds = scene.clouds.iter().map(|cloud| CloudSettings { path: Default::default(), ..cloud.clone() });
        Self {
            clouds: clouds.collect(),
            dealt: method.is_dealt(),
            radii: method.needs_radii(),
            fields: method.needs_field(),
            shadows: scene.shadows,
        }
    }
}

/// Points on the device.
struct Placed {
    arrangement: Arrangement,
    arranged: Arranged,
    cloud: DeviceCloud,
    subject: Subject,
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
    /// How F of the points is spread, if the method asks for it.
    pub spread: Option<Spread>,
}

/// A renderer with the clouds of one scene.
pub struct Stage {
    renderer: Renderer,
    clouds: Vec<Cloud>,
    seed: u64,
    memory_budget: Option<u64>,
    placed: Option<Placed>,
    /// What the last frame of a method took.
    cost: Option<(&'static str, Cost)>,
    histograms: Histograms,
}

impl Stage {
    pub fn new(device: &Device, clouds: Vec<Cloud>, seed: u64, memory_budget: Option<u64>) -> Result<Self> {
        let renderer = Renderer::new(device)?;
        Ok(Self { renderer, clouds, seed, memory_budget, placed: None, cost: None, histograms: Histograms::default() })
    }

    /// The renderer.
    pub fn renderer(&self) -> &Renderer {
        &self.renderer
    }

    /// The clouds as they were read.
    pub fn clouds(&self) -> &[Cloud] {
        &self.clouds
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
        let (seed, memory_budget) = (self.seed, self.memory_budget);
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
        let spread = whole.threshold().map(|threshold| Spread {
            histogram: self.histograms.of(scene, &placed.arranged.points().fields),
            parts: placed.cloud.parts(threshold),
        });
        Ok(Taken { rendered, frame, why, brightness, subject: placed.subject, full, spread })
    }

    /// Brings the scene's points to the device, unless they are there.
    fn place(&mut self, scene: &Scene) -> Result<()> {
        let arrangement = Arrangement::of(scene);
        if self.placed.as_ref().is_some_and(|placed| placed.arrangement == arrangement) {
            return Ok(());
        }
        let progress = ProgressBar::hidden();
        self.remember_neighbors(scene, &arrangement, &progress);
        let (texture, _) = scene::shadow_texture(scene, &self.clouds, self.seed);
        let up = scene::up_axis(&self.clouds);
        let arranged = scene::arrange(scene, self.clouds.clone(), self.seed, &progress)?;
        let points = arranged.points();
        let Some(bounds) = points.bounds() else { return Err(no_points()) };
        let radius = points.radii.iter().fold(0.0, |max: f64, r| max.max(f64::from(*r)));
        // Freed first, so that old and new never lie on the device together.
        self.placed = None;
        let cloud = self.renderer.upload_lit(&arranged, texture.as_ref())?;
        let subject = Subject { bounds, radius, up };
        self.placed = Some(Placed { arrangement, arranged, cloud, subject });
        Ok(())
    }

    /// Finds radii and fields once and keeps them with the clouds, as a prepared file does.
    fn remember_neighbors(&mut self, scene: &Scene, arrangement: &Arrangement, progress: &ProgressBar) {
        for (settings, cloud) in scene.clouds.iter().zip(&mut self.clouds) {
            let estimated = arrangement.radii && settings.radius.is_none() && cloud.own_radii().is_none();
            if !(estimated || arrangement.fields) || arrangement.dealt {
                continue;
            }
            let field = settings.field.as_ref().map(|field| field.in_file_units(settings.scale, settings.translate));
            let (radii, fields) = (true, arrangement.fields);
            let request = Request { neighbors: settings.neighbors, field, radii, fields, normals: false };
            if cloud.prepared.is_some() && request.notes(cloud).is_empty() {
                continue;
            }
            // What can't be found is an error of arranging, if it is asked for.
            if let Ok(prepared) = prepare::prepared(cloud.clone(), &request, progress) {
                *cloud = prepared;
            }
        }
    }

    /// What a frame would do: its passes and why.
    pub fn plan(&self, taken: &Taken) -> Vec<plan::Step> {
        let Taken { rendered, frame, why, .. } = taken;
        plan::plan(self.renderer.device(), frame, &rendered.facts, self.renderer.wide_atomics, why)
    }
}

fn no_points() -> crate::Error {
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
