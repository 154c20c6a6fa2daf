//! A scene on the device, and pictures of it: repeats the work of `render`.

use std::time::Instant;

use pellucid_core::progress::{Observer, Progress};

use super::accuracy::Exactness;
use super::draft::{Cost, Costs, Draft, Effort};
use super::messages::{CloudShare, Setup};
use super::navigate::{CameraSubject, Pose};
use super::statistics::{FieldFacts, Histograms};
use super::thinned::{self, ThinnedCloud};
use pellucid_core::camera::StatedCamera;
use pellucid_core::points::{Changes, Points};
use pellucid_engine::methods::brightness::Applied;
use pellucid_engine::methods::{self, Frame, Outputs, Rendered, Renderer, Stop, shadows};
use pellucid_engine::passes::project::DeviceCloud;
use pellucid_engine::{Result, plan};
use pellucid_gpu::Device;
use pellucid_io::output::WriteOptions;
use pellucid_scene::legend::Legend;
use pellucid_scene::{self as scene, Detail, Input, Method, MethodChoice, Samples, Scene};
use pellucid_session::{Assembled, Clouds, FrameRequest, Prepared, Request, Session, Silent, Sources, Uploaded};

/// Points that are this near to others add nothing that is seen, in pixels.
const FINE_PX: f32 = 1.0;

/// Share of the whole picture's work from which a picture at rest is the whole one.
const NEARLY_WHOLE: f64 = 0.5;

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
    pub subject: CameraSubject,
    /// The share of the whole picture that was rendered.
    pub draft: Draft,
    /// Lights that stand for an area light: the number used, and the number the scene wants.
    pub lights: Option<[u32; 2]>,
    /// Samples of each pixel's area that the scene wants. The frame has those that the picture has.
    pub samples: Samples,
    /// The picture's relation to the exact one, for whole pictures.
    pub exactness: Option<Exactness>,
    /// The distribution of F over the points, if the method uses it.
    pub field: Option<FieldFacts>,
    /// How much of clouds that stay in their files the picture holds.
    pub held: Option<CloudShare>,
}

impl TakenPicture {
    /// The description of the draft among others of its method.
    pub fn name(&self) -> String {
        let lights = self.lights.filter(|[_, wanted]| *wanted > 1).map(|[used, _]| format!("{used} lights"));
        let samples = match (self.samples, self.frame.samples) {
            (Samples::Count(1), _) => None,
            (_, 1) => Some("1 sample per pixel".to_owned()),
            (_, samples) => Some(format!("{samples} samples per pixel")),
        };
        [Some(self.draft.name(&self.frame.method)), lights, samples]
            .into_iter()
            .flatten()
            .collect::<Vec<_>>()
            .join(", ")
    }

    /// True if nothing was left out.
    pub fn is_whole(&self) -> bool {
        let has_samples = match self.samples {
            Samples::Auto => self.frame.samples > 1,
            Samples::Count(wanted) => self.frame.samples == wanted,
        };
        has_samples && self.has_all()
    }

    /// True if nothing was left out of an image.
    fn has_all(&self) -> bool {
        self.draft == Draft::whole(&self.frame.method) && self.lights.is_none_or(|[used, wanted]| used == wanted)
    }

    /// True if a picture of full effort comes next: only samples of each pixel's area are missing.
    pub fn lacks_samples(&self) -> bool {
        self.has_all() && !self.is_whole()
    }
}

/// A scene on the device.
struct UploadedScene {
    session: Session,
    /// A smaller number of the points, for coarser pictures.
    thinned: Option<ThinnedCloud>,
    /// The points' box, largest radius and vertical.
    subject: CameraSubject,
}

/// A renderer with the clouds of one scene.
pub struct SceneRenderer {
    /// The renderer and the clouds while no points are on the device.
    waiting: Option<(Renderer, Sources)>,
    placed: Option<UploadedScene>,
    setup: Setup,
    /// Says what is done to points before they can be rendered, and nothing once they can.
    pub progress: Progress,
    /// The name of the last method, its number of samples, ensembles or layers, and the cost of its frames: drafts are
    /// chosen by them.
    pub costs: Option<(&'static str, Option<u32>, Costs)>,
    histograms: Histograms,
    /// The last choice for `auto`: the requested method, the chosen one, and the reason.
    chosen: Option<(MethodChoice, Method, String)>,
}

impl SceneRenderer {
    /// A renderer for the clouds of a scene. Work that nobody waits for any more ends when the device is told to do
    /// none.
    ///
    /// # Errors
    /// The device failed.
    pub fn new(device: &Device, sources: Sources, setup: &Setup) -> Result<Self> {
        let mut renderer = Renderer::new(device)?;
        renderer.progress = Progress::observed(WhileAllowed(device.clone()));
        Ok(Self {
            waiting: Some((renderer, sources)),
            placed: None,
            setup: *setup,
            progress: Progress::hidden(),
            costs: None,
            histograms: Histograms::default(),
            chosen: None,
        })
    }

    /// The renderer.
    pub fn renderer(&self) -> &Renderer {
        let waiting = || self.waiting.as_ref().map(|(renderer, _)| renderer);
        self.placed.as_ref().map(|placed| &placed.session.renderer).or_else(waiting).expect("either is there")
    }

    /// The clouds as they were read.
    pub fn clouds(&self) -> &Clouds {
        let waiting = || self.waiting.as_ref().map(|(_, sources)| sources);
        let placed = self.placed.as_ref().map(|placed| &placed.session.prepared.sources);
        placed.or_else(waiting).expect("either is there").clouds()
    }

    /// The session with the points on the device.
    ///
    /// # Errors
    /// No points are there: nothing was rendered yet, or it failed.
    pub fn session(&mut self) -> Result<&mut Session> {
        Ok(&mut self.placed.as_mut().ok_or_else(no_points)?.session)
    }

    /// Returns the clouds and columns derived from them, when everything else goes.
    pub fn into_sources(mut self) -> Sources {
        self.free();
        self.waiting.map(|(_, sources)| sources).expect("nothing is on the device")
    }

    /// Returns the meaning of the colors in the scene of the last picture.
    ///
    /// # Errors
    /// A cloud lacks what its colors are to show.
    pub fn legend(&self, scene: &Scene) -> Result<Legend> {
        let Prepared { assembled, sources, .. } = &self.placed.as_ref().ok_or_else(no_points)?.session.prepared;
        assembled.legend_of(scene, sources)
    }

    /// Returns a scene with what the clouds on the device decide about it.
    pub fn settled(&self, scene: &Scene) -> Scene {
        let mut settled = scene.clone();
        if let Some(placed) = &self.placed {
            placed.session.assembled().settle(&mut settled);
        }
        settled
    }

    /// Takes an image back whose memory the next one may have.
    pub fn recycle(&mut self, image: pellucid_core::image::Image) {
        if let Some(placed) = &mut self.placed {
            placed.session.renderer.recycle(image);
        }
    }

    /// Takes a picture of a scene at the size the scene gives or, with less than full effort, with fewer pixels,
    /// samples or points. Drafts reuse the last choice for `auto`.
    ///
    /// # Errors
    /// The scene can't be rendered; the next one may work.
    pub fn take(&mut self, scene: &Scene, pose: Pose, effort: Effort) -> Result<TakenPicture> {
        self.place(scene, pose)?;
        let known = self.chosen.clone().filter(|(requested, method, _)| {
            *requested == scene.method && self.draft(method, effort, scene.image.size) != Draft::whole(method)
        });
        let session = self.session()?;
        match known {
            Some((_, method, why)) => session.keep_method(method, why),
            None => session.decide(&Silent)?,
        }
        let (mut frame, why) = (session.frame, session.why.clone());
        let method = frame.method;
        let lights = lights(&mut frame, &session.uploaded.cloud, effort);
        let samples = scene.image.samples;
        if effort != Effort::Whole {
            frame.samples = 1;
        }
        self.chosen = Some((scene.method, method, why.clone()));
        let draft = self.draft(&method, effort, scene.image.size);
        let started = Instant::now();
        let (rendered, brightness) = self.draw(&frame, draft, effort)?;
        frame.samples = rendered.image.samples.max(1);
        // Shadows that were cast are there for the next one; drafts have one sample per pixel.
        if rendered.facts.light_views == 0 && frame.samples == 1 {
            let ms = started.elapsed().as_secs_f64() * 1e3;
            let cost = Cost { ms, work: draft.work(&method) * self.share(draft, rendered.facts.points) };
            let costs = self.costs_of(&method).map_or_else(|| Costs::new(cost), |costs| costs.with(cost));
            self.costs = Some((method.name(), Draft::whole(&method).steps, costs));
        }
        let all = self.clouds().points();
        let Some(UploadedScene { session, subject, .. }) = &mut self.placed else { return Err(no_points()) };
        let (points, cloud) = (session.prepared.points(), &mut session.uploaded.cloud);
        // Medians of radii may be asked for, which drafts have no time for.
        let whole = effort == Effort::Whole || draft == Draft::whole(&method);
        let exactness = whole.then(|| Exactness::for_method(&method, points));
        let field = method.threshold().map(|threshold| FieldFacts {
            histogram: self.histograms.for_scene(scene, &points.fields),
            parts: cloud.parts(threshold),
        });
        let held = session.prepared.assembled.stored().is_some().then(|| {
            let points = if draft.points.is_some() { rendered.facts.points.min(all) } else { all };
            let px = cloud.cut_in_force().map_or(f64::INFINITY, |cut| cut.px);
            let is_fine = draft.points.is_none() || draft.coarse == 1 && px <= FINE_PX.into();
            CloudShare { points, all, is_fine: is_fine && draft.steps == Draft::whole(&method).steps }
        });
        let subject = *subject;
        Ok(TakenPicture { rendered, frame, why, brightness, subject, draft, lights, samples, exactness, field, held })
    }

    /// Returns how the last picture is written to a file, with the metadata of a scene of this name.
    ///
    /// # Errors
    /// There is no picture.
    pub fn write_options(&mut self, name: String, applied: Option<&Applied>) -> Result<WriteOptions> {
        let session = self.session()?;
        session.prepared.request.name = name;
        Ok(session.write_options(applied, Vec::new()))
    }

    /// The picture of the exact method that this one approximates, from the same scene.
    ///
    /// # Errors
    /// The frame can't be rendered.
    pub fn exact(&mut self, scene: &Scene, pose: Pose, frame: &Frame, method: Method) -> Result<Rendered> {
        // A picture that came to nothing may have left other points.
        self.place(scene, pose)?;
        let session = self.session()?;
        session.frame = Frame { method, stop: Stop::Exact, spread: false, ensembles: None, ..*frame };
        session.render()
    }

    fn costs_of(&self, method: &Method) -> Option<Costs> {
        let (_, steps, costs) = self.costs.filter(|(name, ..)| *name == method.name())?;
        Some(costs.rescaled(steps, Draft::whole(method).steps))
    }

    /// The share of the points that a draft draws, of which so many are there.
    fn share(&self, draft: Draft, points: u64) -> f64 {
        let Some(most) = draft.points else { return 1.0 };
        points.min(most.into()) as f64 / self.clouds().points().max(1) as f64
    }

    /// The draft of a method that this effort allows in a picture of so many pixels.
    fn draft(&self, method: &Method, effort: Effort, size: [u32; 2]) -> Draft {
        let Some(budget) = effort.budget_ms() else { return Draft::whole(method) };
        if let (Clouds::Stored(_), false) = (self.clouds(), method.is_dealt()) {
            return Draft::of_stored(method, self.costs_of(method), effort, self.clouds().points(), size);
        }
        let draft = Draft::within(method, self.costs_of(method), budget);
        // At rest the whole picture is worth twice the wait for most of it.
        let nearly = matches!(effort, Effort::Refining(_)) && draft.work(method) >= NEARLY_WHOLE;
        if nearly { Draft::whole(method) } else { draft }
    }

    /// Renders what a draft has of a whole frame.
    fn draw(&mut self, whole: &Frame, draft: Draft, effort: Effort) -> Result<(Rendered, Option<Applied>)> {
        let Some(UploadedScene { session, thinned, .. }) = &mut self.placed else { return Err(no_points()) };
        let method = draft.method(whole.method);
        // Nobody but the screen needs the colors of a moving picture, unless one at rest follows.
        let outputs = if matches!(effort, Effort::Moving(_)) { Outputs::SCREEN } else { Outputs::default() };
        let (ensembles, size) = (draft.ensembles(&method), draft.size(whole.size));
        session.frame = Frame { method, outputs, ensembles, size, ..*whole };
        let drawn = draw(session, thinned, (draft, effort));
        session.frame.outputs = Outputs::default();
        drawn
    }

    /// The request for pictures of a scene. The window has drafts of its own, and draws all points at rest.
    fn request(&self, scene: &Scene) -> Request {
        let Setup { seed, memory_budget, .. } = self.setup;
        let mut request = Request::of_scene(String::new(), scene.clone(), Input::Files, self.setup.limits(), seed);
        request.wanted.is_edited = true;
        let (stop, detail) = (Stop::EightBit { transparent: false }, Some(Detail::default()));
        request.frame = FrameRequest { memory_budget, stop, spread: true, detail, ..FrameRequest::default() };
        request
    }

    /// Brings the scene's points to the device, the missing and the changed ones, and finds the camera. Returns the
    /// changes.
    ///
    /// # Errors
    /// The points can't be made or uploaded; those of another scene may.
    pub fn place(&mut self, scene: &Scene, pose: Pose) -> Result<Changes> {
        let placed = self.place_quietly(self.request(scene), pose);
        self.progress.set_message("");
        placed
    }

    fn place_quietly(&mut self, request: Request, pose: Pose) -> Result<Changes> {
        let followed = match &mut self.placed {
            Some(placed) => placed.session.follow(&request, &self.progress)?,
            None => None,
        };
        let Some(changes) = followed else {
            // The points moved. They are freed first, so that old and new never occupy memory together.
            self.free();
            self.upload(request, pose)?;
            return Ok(Changes::ALL);
        };
        if changes.any() {
            self.reconsider(request.scene.method);
        }
        let Some(UploadedScene { session, thinned, subject }) = &mut self.placed else { return Err(no_points()) };
        if changes.any() {
            *thinned = None;
        }
        subject.vertical = request.scene.camera.vertical(subject.up);
        if changes.radii || changes.unseen {
            subject.radius = session.points().largest_radius();
        }
        session.prepared.camera = camera(&request.scene, pose, subject, session.points())?;
        session.prepared.request = request;
        Ok(changes)
    }

    /// Frees what is on the device.
    fn free(&mut self) {
        if let Some(UploadedScene { session: Session { renderer, prepared, .. }, .. }) = self.placed.take() {
            self.waiting = Some((renderer, prepared.sources));
        }
    }

    /// Makes points of the clouds and brings them to the device.
    fn upload(&mut self, request: Request, pose: Pose) -> Result<()> {
        let Some((renderer, sources)) = &mut self.waiting else { return Err(no_points()) };
        let (scene, progress) = (&request.scene, &self.progress);
        sources.complete(scene, progress)?;
        let assembled = Assembled::new(sources, scene, request.wanted, &Silent, progress)?;
        let bounds = assembled.points().bounds().ok_or_else(no_points)?;
        let (radius, up) = (assembled.points().largest_radius(), assembled.up);
        let subject = CameraSubject { bounds, radius, up, vertical: scene.camera.vertical(up) };
        let camera = camera(scene, pose, &subject, assembled.points())?;
        progress.set_message("uploading points");
        let uploaded = Uploaded::new(renderer, &assembled, &Detail::default(), false)?;
        let Some((renderer, sources)) = self.waiting.take() else { return Err(no_points()) };
        let prepared = Prepared { request, assembled, camera, bounds: Some(bounds), sources };
        let session = Session::of(renderer, prepared, uploaded, &Progress::hidden());
        let requested = session.scene().method;
        self.placed = Some(UploadedScene { session, thinned: None, subject });
        self.reconsider(requested);
        Ok(())
    }

    /// Forgets what `auto` stood for if other points ask for something else: opaque ones for no order at all.
    fn reconsider(&mut self, requested: MethodChoice) {
        let Some(placed) = &self.placed else { return };
        let needs_order = |method: &Method| !matches!(method, Method::Circles(_));
        let (resolved, _why) = plan::resolve(requested, placed.session.points());
        self.chosen.take_if(|(_, method, _)| needs_order(method) != needs_order(&resolved));
    }

    /// The passes of a frame and their reasons.
    pub fn plan(&self, picture: &TakenPicture) -> Vec<plan::Step> {
        let (TakenPicture { rendered, frame, why, .. }, renderer) = (picture, self.renderer());
        plan::plan(renderer.device(), frame, &rendered.facts, renderer.switches.wide_atomics, why)
    }
}

/// Renders what a draft has of the session's frame.
fn draw(
    session: &mut Session,
    kept: &mut Option<ThinnedCloud>,
    (draft, effort): (Draft, Effort),
) -> Result<(Rendered, Option<Applied>)> {
    if let Some(points) = draft.points {
        return Ok((draw_some(session, kept, points)?, None));
    }
    // Points of ensembles are fewer on fewer pixels by themselves; shadows are those of all points.
    let is_thinned = draft.coarse > 1
        && !session.frame.method.is_dealt()
        && shadows::casting(&session.frame, &session.uploaded.cloud).is_none();
    if !is_thinned {
        // Only pictures of full effort have the scene's samples.
        let mut rendered =
            if effort == Effort::Whole { session.first(session.frame.outputs, &Silent) } else { session.render() }?;
        let brightness = session.brighten(&mut rendered)?;
        return Ok((rendered, brightness));
    }
    let one_of = (draft.coarse * draft.coarse) as usize;
    Ok((draw_thinned(session, kept, one_of, draft.coarse as f32)?, None))
}

/// Renders one of so many points with larger radii.
fn draw_thinned(
    session: &mut Session,
    kept: &mut Option<ThinnedCloud>,
    one_of: usize,
    radius_factor: f32,
) -> Result<Rendered> {
    let Session { renderer, prepared, uploaded, frame, .. } = session;
    let mut frame = *frame;
    if let Some(soft) = frame.method.soft() {
        frame.method = thinned::as_dense(frame.method, uploaded.cloud.parts(soft.threshold).median_radius);
    }
    frame.factors.radius *= radius_factor;
    let cloud = ThinnedCloud::reuse_or_upload(kept, renderer, prepared.points(), one_of)?;
    Ok(renderer.render(cloud, &frame)?)
}

/// Renders about so many points of a cloud that stays in its file: its levels, or, if it has none, those that stand for
/// all.
fn draw_some(session: &mut Session, kept: &mut Option<ThinnedCloud>, points: u32) -> Result<Rendered> {
    let has_levels = |cloud: &DeviceCloud| {
        cloud.supply().is_some_and(|supply| supply.blocks().iter().all(|block| block.branch.is_some()))
    };
    if !has_levels(&session.uploaded.cloud) {
        let (some, all) = (session.points().len(), session.points().count());
        // The discs of a place together keep their area.
        return draw_thinned(session, kept, 1, (all as f32 / some.max(1) as f32).sqrt());
    }
    let Session { renderer, uploaded, frame, .. } = session;
    frame.detail = Detail { spacing_px: FINE_PX, max_points: Some(points) };
    match renderer.render(&mut uploaded.cloud, frame) {
        Err(methods::Error::Coarsest { points, .. }) => {
            frame.detail.max_points = Some(u32::try_from(points).unwrap_or(u32::MAX));
            Ok(renderer.render(&mut uploaded.cloud, frame)?)
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

fn no_points() -> pellucid_engine::Error {
    scene::Error::NoPoints { clouds: "the scene".into(), reason: "there is no point to draw".into() }.into()
}

fn camera(scene: &Scene, pose: Pose, subject: &CameraSubject, points: &Points) -> Result<StatedCamera> {
    let CameraSubject { bounds, radius, up, .. } = subject;
    let settings = match pose {
        Pose::At(settings) => {
            let found = scene::stated_camera_at(&settings, bounds, *radius);
            return found.ok_or_else(|| scene::Error::Extent { min: bounds.min, max: bounds.max }.into());
        }
        Pose::Scene => scene.camera,
        Pose::View(view) => scene.camera.seen_from(view),
    };
    let framed = Scene { camera: settings, clouds: Vec::new(), ..scene.clone() };
    let (camera, _warnings) = scene::stated_camera(&framed, points, *up)?;
    Ok(camera)
}
