//! A scene on the device, and pictures of it: repeats the work of `render`.

use std::time::Instant;

use pellucid_engine::progress::{Observer, Progress};

use super::accuracy::Standing;
use super::census::{FieldFacts, Histograms};
use super::draft::{Cost, Costs, Draft, Effort};
use super::navigate::Subject;
use super::placed::Placed;
use super::thinned::{self, ThinnedCloud};
use super::worker::Setup;
use pellucid_engine::camera::Camera;
use pellucid_engine::gpu::Device;
use pellucid_engine::methods::brightness::{self, Applied};
use pellucid_engine::methods::{self, Frame, Rendered, Renderer, Stop, shadows};
use pellucid_engine::passes::project::DeviceCloud;
use pellucid_engine::points::Changes;
use pellucid_engine::scene::legend::Legend;
use pellucid_engine::scene::{self, CameraSettings, Detail, Method, MethodChoice, Scene, View};
use pellucid_engine::supply::Cut;
use pellucid_engine::{Result, plan};
use pellucid_session::{Clouds, Sources};

/// Points that are this near to others add nothing that is seen, in pixels.
const FINE_PX: f32 = 1.0;

/// Share of the whole picture's work from which a picture at rest is the whole one.
const NEARLY_WHOLE: f64 = 0.5;

/// Where a picture is taken from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Pose {
    /// The scene's own camera.
    Scene,
    /// A camera with perspective that sees everything from the direction of a view.
    View(View),
    /// A camera whose eye, target and up are given.
    At(CameraSettings),
}

/// Cancels work while the device is stopped.
struct WhileAllowed(Device);

impl Observer for WhileAllowed {
    fn is_cancelled(&self) -> bool {
        self.0.is_stopped()
    }
}

/// A picture and how it came about.
pub struct TakenPicture {
    /// The picture, its times and what it met.
    pub rendered: Rendered,
    /// The frame that it is of.
    pub frame: Frame,
    /// Why this method.
    pub why: String,
    /// The brightening that was applied.
    pub brightness: Option<Applied>,
    /// The points' box, radius and vertical.
    pub subject: Subject,
    /// The share of the whole picture that was rendered.
    pub draft: Draft,
    /// Lights that stand for an area light: the number used, and the number the scene wants.
    pub lights: Option<[u32; 2]>,
    /// The picture's relation to the exact one, for whole pictures.
    pub standing: Option<Standing>,
    /// The distribution of F over the points, if the method uses it.
    pub field: Option<FieldFacts>,
    /// How much of clouds that stay in their files the picture holds.
    pub held: Option<Held>,
}

/// How much of a cloud that stays in its file a picture holds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Held {
    /// Points in the picture.
    pub points: u64,
    /// All points.
    pub all: u64,
    /// True if those left out are less than a pixel from one that is there.
    pub is_fine: bool,
}

impl TakenPicture {
    /// The description of the draft among others of its method.
    pub fn name(&self) -> String {
        let draft = self.draft.name(&self.frame.method);
        match self.lights {
            Some([used, wanted]) if wanted > 1 => format!("{draft}, {used} lights"),
            _ => draft,
        }
    }

    /// True if nothing was left out.
    pub fn is_whole(&self) -> bool {
        self.draft == Draft::whole(&self.frame.method) && self.lights.is_none_or(|[used, wanted]| used == wanted)
    }
}

/// A renderer with the clouds of one scene.
pub struct Stage {
    renderer: Renderer,
    sources: Sources,
    /// Seed of stochastic methods.
    seed: u64,
    /// Says what is done to points before they can be rendered, and nothing once they can.
    pub progress: Progress,
    memory_budget: Option<u64>,
    placed: Option<Placed>,
    /// The name of the last method, its number of samples, ensembles or layers, and the cost of its frames.
    costs: Option<(&'static str, Option<u32>, Costs)>,
    histograms: Histograms,
    /// The last choice for `auto`: the requested method, the chosen one, and the reason.
    chosen: Option<(MethodChoice, Method, String)>,
}

impl Stage {
    /// A stage for the clouds of a scene. Work that nobody waits for any more ends when the device is told to do none.
    ///
    /// # Errors
    /// The device failed.
    pub fn new(device: &Device, sources: Sources, setup: &Setup) -> Result<Self> {
        let Setup { seed, memory_budget, .. } = *setup;
        let mut renderer = Renderer::new(device)?;
        renderer.progress = Progress::observed(WhileAllowed(device.clone()));
        let (progress, histograms) = (Progress::hidden(), Histograms::default());
        let (placed, costs, chosen) = (None, None, None);
        Ok(Self { renderer, sources, seed, progress, memory_budget, placed, costs, chosen, histograms })
    }

    /// The renderer.
    pub fn renderer(&self) -> &Renderer {
        &self.renderer
    }

    /// The clouds as they were read.
    pub fn clouds(&self) -> &Clouds {
        self.sources.clouds()
    }

    /// Settles what the clouds decide about a scene.
    pub fn settle(&self, scene: &mut Scene) {
        if let Clouds::Held(clouds) = self.clouds() {
            scene.settle(clouds);
        }
    }

    /// Returns the clouds and columns derived from them, when everything else goes.
    pub fn into_sources(self) -> Sources {
        self.sources
    }

    /// Returns the meaning of the colors in the scene of the last picture.
    ///
    /// # Errors
    /// A cloud lacks what its colors are to show.
    pub fn legend(&self, scene: &Scene) -> Result<Legend> {
        let placed = self.placed.as_ref().ok_or_else(no_points)?;
        placed.legend(scene, &self.sources)
    }

    /// Takes an image back whose memory the next one may have.
    pub fn recycle(&mut self, image: pellucid_engine::image::Image) {
        self.renderer.recycle(image);
    }

    /// Takes a picture of a scene at the size the scene gives or, with less than full effort, with fewer pixels,
    /// samples or points. Drafts reuse the last choice for `auto`.
    ///
    /// # Errors
    /// The scene can't be rendered; the next one may work.
    pub fn take(&mut self, scene: &Scene, pose: Pose, effort: Effort) -> Result<TakenPicture> {
        if self.place(scene)?.any() {
            self.reconsider(scene);
        }
        let (seed, memory_budget) = (self.seed, self.memory_budget);
        let known = self.chosen.clone().filter(|(requested, method, _)| {
            *requested == scene.method && self.draft(method, effort, scene.image.size) != Draft::whole(method)
        });
        let Some(placed) = &mut self.placed else { return Err(no_points()) };
        let camera = camera(scene, pose, placed)?;
        let mut settled = scene.clone();
        placed.assembled.settle(&mut settled);
        let scene = &settled;
        let stop = Stop::EightBit { transparent: false };
        // The window has drafts of its own, and draws all points at rest.
        let detail = Detail::default();
        let mut frame = Frame { memory_budget, stop, spread: true, detail, ..Frame::of_scene(scene, camera, seed) };
        let (method, why) = match known {
            Some((_, method, why)) => (method, why),
            None => {
                let Placed { assembled, uploaded, .. } = placed;
                let points = assembled.points();
                plan::choose(&mut self.renderer, &mut uploaded.cloud, points, scene.method, &frame)?
            }
        };
        self.chosen = Some((scene.method, method, why.clone()));
        frame.method = method;
        let lights = lights(&mut frame, &placed.uploaded.cloud, effort);
        let draft = self.draft(&method, effort, scene.image.size);
        let started = Instant::now();
        // Nobody but the screen needs the colors of a moving picture, unless one at rest follows.
        self.renderer.host_colors = !matches!(effort, Effort::Moving(_));
        let drawn = self.draw(&frame, draft);
        self.renderer.host_colors = true;
        let (rendered, brightness) = drawn?;
        // Shadows that were cast are there for the next one.
        if rendered.facts.light_views == 0 {
            let ms = started.elapsed().as_secs_f64() * 1e3;
            let cost = Cost { ms, work: draft.work(&method) * self.share(draft, rendered.facts.points) };
            let costs = self.costs_of(&method).map_or_else(|| Costs::new(cost), |costs| costs.with(cost));
            self.costs = Some((method.name(), Draft::whole(&method).steps, costs));
        }
        let Some(placed) = &mut self.placed else { return Err(no_points()) };
        // Medians of radii may be asked for, which drafts have no time for.
        let whole = effort == Effort::Whole || draft == Draft::whole(&method);
        let standing = whole.then(|| Standing::for_method(&method, placed.points()));
        let field = method.threshold().map(|threshold| FieldFacts {
            histogram: self.histograms.for_scene(scene, &placed.points().fields),
            parts: placed.uploaded.cloud.parts(threshold),
        });
        let all = self.sources.clouds().points();
        let held = placed.stored().is_some().then(|| {
            let points = if draft.points.is_some() { rendered.facts.points.min(all) } else { all };
            let px = placed.uploaded.cloud.cut_in_force().map_or(f64::INFINITY, Cut::px);
            let is_fine = draft.points.is_none() || draft.coarse == 1 && px <= FINE_PX.into();
            Held { points, all, is_fine: is_fine && draft.steps == Draft::whole(&method).steps }
        });
        let subject = placed.subject;
        Ok(TakenPicture { rendered, frame, why, brightness, subject, draft, lights, standing, field, held })
    }

    /// The picture of the exact method that this one approximates, from the same scene.
    ///
    /// # Errors
    /// The frame can't be rendered.
    pub fn exact(&mut self, scene: &Scene, frame: &Frame, method: Method) -> Result<Rendered> {
        // A picture that came to nothing may have left other points.
        self.place(scene)?;
        let Some(placed) = &mut self.placed else { return Err(no_points()) };
        let frame = Frame { method, stop: Stop::Exact, spread: false, ensembles: None, ..*frame };
        Ok(self.renderer.render(&mut placed.uploaded.cloud, &frame)?)
    }

    fn costs_of(&self, method: &Method) -> Option<Costs> {
        let (_, steps, costs) = self.costs.filter(|(name, ..)| *name == method.name())?;
        Some(costs.rescaled(steps, Draft::whole(method).steps))
    }

    /// The share of the points that a draft draws, of which so many are there.
    fn share(&self, draft: Draft, points: u64) -> f64 {
        let Some(most) = draft.points else { return 1.0 };
        points.min(most.into()) as f64 / self.sources.clouds().points().max(1) as f64
    }

    /// The draft of a method that this effort allows in a picture of so many pixels.
    fn draft(&self, method: &Method, effort: Effort, size: [u32; 2]) -> Draft {
        let Some(budget) = effort.budget_ms() else { return Draft::whole(method) };
        if let (Clouds::Stored(_), false) = (self.sources.clouds(), method.is_dealt()) {
            return Draft::of_stored(method, self.costs_of(method), effort, self.sources.clouds().points(), size);
        }
        let draft = Draft::within(method, self.costs_of(method), budget);
        // At rest the whole picture is worth twice the wait for most of it.
        let nearly = matches!(effort, Effort::Refining(_)) && draft.work(method) >= NEARLY_WHOLE;
        if nearly { Draft::whole(method) } else { draft }
    }

    /// Renders what a draft has of a whole frame.
    fn draw(&mut self, whole: &Frame, draft: Draft) -> Result<(Rendered, Option<Applied>)> {
        let Some(placed) = &mut self.placed else { return Err(no_points()) };
        let (renderer, method) = (&mut self.renderer, draft.method(whole.method));
        let mut frame = Frame { method, ensembles: draft.ensembles(&method), size: draft.size(whole.size), ..*whole };
        if let Some(points) = draft.points {
            return Ok((draw_some(renderer, placed, frame, points)?, None));
        }
        // Points of ensembles are fewer on fewer pixels by themselves; shadows are those of all points.
        let thinned =
            draft.coarse > 1 && !method.is_dealt() && shadows::casting(whole, &placed.uploaded.cloud).is_none();
        if !thinned {
            let mut rendered = renderer.render(&mut placed.uploaded.cloud, &frame)?;
            let brightness = brightness::apply(renderer, &mut placed.uploaded.cloud, &frame, &mut rendered.image)?;
            return Ok((rendered, brightness));
        }
        let one_of = (draft.coarse * draft.coarse) as usize;
        if let Some(soft) = method.soft() {
            frame.method = thinned::as_dense(method, placed.uploaded.cloud.parts(soft.threshold).median_radius);
        }
        frame.factors.radius *= draft.coarse as f32;
        let cloud = ThinnedCloud::reuse_or_upload(&mut placed.thinned, renderer, placed.assembled.points(), one_of)?;
        Ok((renderer.render(cloud, &frame)?, None))
    }

    /// Brings the scene's points to the device: uploads the missing and the changed ones.
    fn place(&mut self, scene: &Scene) -> Result<Changes> {
        let placed = self.place_quietly(scene);
        self.progress.set_message("");
        placed
    }

    fn place_quietly(&mut self, scene: &Scene) -> Result<Changes> {
        let Self { renderer, sources, seed, progress, placed, .. } = self;
        let seed = *seed;
        sources.complete(scene, progress)?;
        if let Some(before) = placed {
            if let Some(changes) = before.follow(renderer, sources, (scene, seed), progress)? {
                return Ok(changes);
            }
            // The points moved. They are freed first, so that old and new never occupy memory together.
            *placed = None;
        }
        *placed = Some(Placed::new(renderer, sources, (scene, seed), progress)?);
        Ok(Changes::ALL)
    }

    /// Forgets what `auto` stood for if other points ask for something else: opaque ones for no order at all.
    fn reconsider(&mut self, scene: &Scene) {
        let Some(placed) = &self.placed else { return };
        let needs_order = |method: &Method| !matches!(method, Method::Circles(_));
        let (resolved, _why) = plan::resolve(scene.method, placed.points());
        self.chosen.take_if(|(_, method, _)| needs_order(method) != needs_order(&resolved));
    }

    /// The passes of a frame and their reasons.
    pub fn plan(&self, picture: &TakenPicture) -> Vec<plan::Step> {
        let TakenPicture { rendered, frame, why, .. } = picture;
        plan::plan(self.renderer.device(), frame, &rendered.facts, self.renderer.switches.wide_atomics, why)
    }
}

/// Renders about so many points of a cloud that stays in its file: its levels, or, if it has none, those that stand for
/// all.
fn draw_some(renderer: &mut Renderer, placed: &mut Placed, mut frame: Frame, points: u32) -> Result<Rendered> {
    let has_levels = |cloud: &DeviceCloud| {
        cloud.supply().is_some_and(|supply| supply.blocks().iter().all(|block| block.branch.is_some()))
    };
    if !has_levels(&placed.uploaded.cloud) {
        let (some, all) = (placed.points().len(), placed.points().count());
        if let Some(soft) = frame.method.soft() {
            frame.method = thinned::as_dense(frame.method, placed.uploaded.cloud.parts(soft.threshold).median_radius);
        }
        // The discs of a place together keep their area.
        frame.factors.radius *= (all as f32 / some.max(1) as f32).sqrt();
        let cloud = ThinnedCloud::reuse_or_upload(&mut placed.thinned, renderer, placed.assembled.points(), 1)?;
        return Ok(renderer.render(cloud, &frame)?);
    }
    frame.detail = Detail { spacing_px: FINE_PX, max_points: Some(points) };
    match renderer.render(&mut placed.uploaded.cloud, &frame) {
        Err(methods::Error::Coarsest { points, .. }) => {
            frame.detail.max_points = Some(u32::try_from(points).unwrap_or(u32::MAX));
            Ok(renderer.render(&mut placed.uploaded.cloud, &frame)?)
        }
        rendered => Ok(rendered?),
    }
}

/// The number of lights that stand for the area light of a frame, and the number the scene wants. All are used if they
/// were cast already or nothing may be left out. Otherwise the frame uses the existing ones, or one, or, at rest, four
/// times as many as exist. `None` without shadows.
fn lights(frame: &mut Frame, cloud: &DeviceCloud, effort: Effort) -> Option<[u32; 2]> {
    let wanted = shadows::casting(frame, cloud)?;
    let existing =
        cloud.casting().filter(|existing| existing.differences(&wanted).iter().all(|name| *name == "samples"));
    let used = match (existing, effort) {
        (Some(existing), Effort::Moving(_)) => existing.samples,
        (Some(existing), Effort::Refining(_)) if *existing != wanted => {
            existing.samples.saturating_mul(4).min(wanted.samples)
        }
        // Shadows of stores are cast anew for each level of detail.
        (None, Effort::Refining(_)) if cloud.supply().is_some() => wanted.samples,
        (None, Effort::Moving(_) | Effort::Refining(_)) => 1,
        _ => wanted.samples,
    };
    frame.shadows = frame.shadows.map(|shadows| scene::Shadows { samples: used, ..shadows });
    Some([used, wanted.samples])
}

pub(super) fn no_points() -> pellucid_engine::Error {
    scene::Error::NoPoints { clouds: "the scene".into(), hidden: 0 }.into()
}

fn camera(scene: &Scene, pose: Pose, placed: &Placed) -> Result<Camera> {
    let Subject { bounds, radius, up } = &placed.subject;
    let settings = match pose {
        Pose::At(settings) => {
            let found = scene::camera_at(&settings, bounds, *radius);
            return found.ok_or_else(|| scene::Error::Extent { min: bounds.min, max: bounds.max }.into());
        }
        Pose::Scene => scene.camera,
        Pose::View(view) => CameraSettings { view, eye: None, target: None, up: None, height: None, ..scene.camera },
    };
    let framed = Scene { camera: settings, clouds: Vec::new(), ..scene.clone() };
    let (camera, _warnings) = scene::camera(&framed, placed.points(), *up)?;
    Ok(camera)
}

#[cfg(test)]
mod tests;
