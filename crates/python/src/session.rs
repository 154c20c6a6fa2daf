//! Scene on a device, remade as far as a frame asks for other settings than the one before.

use glam::Vec3;
use pellucid_engine::camera::Camera;
use pellucid_engine::cloud::{Bounds, Cloud as Columns};
use pellucid_engine::gpu::Device;
use pellucid_engine::methods::see_through::{self, Found};
use pellucid_engine::methods::{Factors, Frame, Renderer};
use pellucid_engine::passes::project::DeviceCloud;
use pellucid_engine::progress::Phase;
use pellucid_engine::scene::made::{self, Made, Source, Wanted};
use pellucid_engine::scene::{self as engine, Document, Method, MethodChoice, Scene, ShadingModel, Vertical};
use pellucid_engine::{io, plan};
use pellucid_session::choice::{self, Choice, Subject, Wish};
use pellucid_lab::frame_notes;

use crate::failure::Failure;
use crate::request::{self, Ask, Changes};
use crate::scene::{Clouds, State};
use crate::talk::Talk;

/// Scene on a device, and the frame that was requested last.
pub struct Session {
    pub state: State,
    pub device: Device,
    pub renderer: Renderer,
    pub cloud: DeviceCloud,
    pub made: Made,
    /// Scene and seed for which they were made, as they were asked for.
    asked: (Scene, u64),
    /// Bounding box of the points, found from all of them.
    pub bounds: Option<Bounds>,
    /// `true` if points have radii whatever the method.
    radii: bool,
    /// Camera that was found last, and its settings.
    camera: Option<(Scene, Camera)>,
    /// Settings in force.
    pub scene: Scene,
    pub frame: Frame,
    /// Reason for the method.
    pub why: String,
    pub found: Option<Found>,
    pub choice: Option<Choice>,
    /// Facts that method and opacities were decided for.
    decided: Option<Decided>,
    told: Vec<String>,
    /// Changes that were requested last, and their result.
    laid: Option<((Vec<String>, Changes), Laid)>,
}

#[derive(Clone)]
struct Laid {
    document: Document,
    scene: Scene,
}

#[derive(PartialEq)]
struct Decided {
    method: MethodChoice,
    background: Vec3,
    frame: Frame,
    see_through: Option<f64>,
    wish: Option<Wish>,
}

/// Returns `true` if a scene wants other points than were made for another one, or others of their columns.
fn is_outdated(made: &Made, (a, seed): &(Scene, u64), (b, other_seed): (&Scene, u64)) -> bool {
    let needs = |scene: &Scene| {
        let method = &scene.method;
        (method.is_dealt(), method.needs_radii(), method.needs_field(), scene.shading_normals())
    };
    // Heights are those along the camera's vertical.
    let vertical = |scene: &Scene| scene.camera.up.and_then(Vertical::nearest).unwrap_or(made.up.into());
    a.clouds != b.clouds
        || a.clips != b.clips
        || needs(a) != needs(b)
        || a.shadows != b.shadows
        || vertical(a).up() != vertical(b).up()
        || (made.follows_method && (a.method != b.method || a.image.color != b.image.color || a.detail != b.detail))
        || (a.method.is_dealt() && *seed != other_seed)
}

/// Settles what the clouds decide about a scene, as they did when points were made of them.
fn settle(scene: &mut Scene, made: &Made) {
    if made.follows_method {
        scene.image.color = made.scene.image.color;
    }
    if scene.shading.model == ShadingModel::Auto && made.scene.shading.model == ShadingModel::None {
        // Without normals there is nothing to shade by.
        scene.shading.model = ShadingModel::None;
    }
}

impl Session {
    /// Reads, arranges and uploads the points of a scene; with radii, if they are wanted, whatever the method.
    pub fn open(device: Device, state: State, ask: &Ask, radii: bool, talk: &Talk) -> Result<Self, Failure> {
        let mut document = state.document.clone();
        let scene = request::lay_over(&mut document, &ask.drop, &ask.changes)?;
        let scene = viewed(scene, &state, ask);
        check_see_through(&scene, ask)?;
        let seed = ask.seed.unwrap_or(state.seed);
        let asked = (scene.clone(), seed);
        let made = make(&state.clouds, document, scene, ask, (seed, radii), talk)?;
        talk.go_on()?;
        let mut scene = made.scene.clone();
        engine::camera_notes(&scene, made.points(), made.up).into_iter().for_each(|note| talk.note(note));
        let (camera, warnings) = engine::camera(&scene, made.points(), made.up)?;
        let told: Vec<String> = scene.warnings.drain(..).chain(warnings).collect();
        told.iter().for_each(|warning| talk.warn(warning));
        talk.progress.begin(Phase::Upload);
        talk.stage("uploading");
        let renderer = Renderer::new(&device)?;
        let cloud = renderer.upload_for(&scene.detail, &made.arranged, made.shadow_texture.as_ref())?;
        let frame = frame_of(&scene, camera, seed, ask);
        let (camera, why) = (Some((scene.clone(), camera)), String::new());
        let (found, choice, decided) = (None, None, None);
        let bounds = made.points().bounds();
        Ok(Self {
            state,
            device,
            renderer,
            cloud,
            made,
            asked,
            bounds,
            radii,
            camera,
            scene,
            frame,
            why,
            found,
            choice,
            decided,
            told,
            laid: None,
        })
    }

    /// Gets everything ready for the frame that is asked for.
    pub fn prepare(&mut self, ask: &Ask, talk: &Talk) -> Result<(), Failure> {
        self.renderer.progress = talk.progress.clone();
        let Laid { document, scene } = self.laid(ask)?;
        let mut scene = viewed(scene, &self.state, ask);
        check_see_through(&scene, ask)?;
        let seed = ask.seed.unwrap_or(self.state.seed);
        // Whatever goes wrong from here on, the next frame is decided anew.
        let mut decided = self.decided.take();
        if is_outdated(&self.made, &self.asked, (&scene, seed)) {
            let asked = (scene.clone(), seed);
            let made = make(&self.state.clouds, document, scene, ask, (seed, self.radii), talk)?;
            self.cloud = self.renderer.upload_for(&made.scene.detail, &made.arranged, made.shadow_texture.as_ref())?;
            scene = made.scene.clone();
            self.bounds = made.points().bounds();
            (self.made, self.asked, self.camera, decided) = (made, asked, None, None);
        } else {
            settle(&mut scene, &self.made);
            if !scene.detail.is_whole() && self.cloud.supply().is_none() {
                self.cloud = self.renderer.upload_for(&scene.detail, &self.made.arranged, None)?;
            }
        }
        let camera = self.camera(&scene, talk)?;
        for warning in std::mem::take(&mut scene.warnings) {
            self.warn_once(warning, talk);
        }
        let frame = frame_of(&scene, camera, seed, ask);
        self.scene = scene;
        self.decide(decided, frame, ask, talk)?;
        if let Some(found) = self.found {
            // What the caller asks for beside the share of light, as a slider does, needs no search.
            self.frame.factors.opacity = found.factor * ask.factors().opacity;
        }
        Ok(())
    }

    /// Returns the document with the requested changes, and its scene: mostly those of the last frame.
    fn laid(&mut self, ask: &Ask) -> Result<Laid, Failure> {
        let by = (ask.drop.clone(), ask.changes.clone());
        if let Some((last, laid)) = &self.laid
            && *last == by
        {
            return Ok(laid.clone());
        }
        let mut document = self.state.document.clone();
        let scene = request::lay_over(&mut document, &ask.drop, &ask.changes)?;
        let (_, laid) = self.laid.insert((by, Laid { document, scene }));
        Ok(laid.clone())
    }

    fn warn_once(&mut self, warning: String, talk: &Talk) {
        if !self.told.contains(&warning) {
            talk.warn(&warning);
            self.told.push(warning);
        }
    }

    /// Returns the camera of a scene of these points.
    fn camera(&mut self, scene: &Scene, talk: &Talk) -> Result<Camera, Failure> {
        if let Some((known, camera)) = &self.camera
            && known.camera == scene.camera
            && known.image.size == scene.image.size
        {
            return Ok(*camera);
        }
        let points = self.made.points();
        let given = self.bounds.filter(|_| !scene.camera.view.is_given());
        let given = given.and_then(|bounds| engine::camera_at(&scene.camera, &bounds, points.largest_radius()));
        let camera = match given {
            Some(camera) => camera,
            None => {
                let (camera, warnings) = engine::camera(scene, points, self.made.up)?;
                warnings.into_iter().for_each(|warning| self.warn_once(warning, talk));
                camera
            }
        };
        self.camera = Some((scene.clone(), camera));
        Ok(camera)
    }

    /// Decides method and opacities, unless nothing has changed of what the last ones followed from.
    fn decide(&mut self, last: Option<Decided>, frame: Frame, ask: &Ask, talk: &Talk) -> Result<(), Failure> {
        let Scene { method, image, .. } = &self.scene;
        let (background, see_through) = (image.background, ask.see_through);
        let asked = Decided { method: *method, background, frame, see_through, wish: ask.wish() };
        if last.as_ref() == Some(&asked) {
            self.decided = last;
            talk.stage("rendering");
            return Ok(());
        }
        self.frame = frame;
        (self.found, self.choice) = (None, None);
        talk.progress.begin(Phase::Frame);
        talk.stage("choosing the method");
        match self.wish(ask, talk) {
            Some(wish) => {
                self.find_opacity(ask.see_through, talk)?;
                self.choose(wish, talk)?;
            }
            None => {
                let Self { renderer, cloud, frame, made, scene, .. } = self;
                (self.frame.method, self.why) = plan::choose(renderer, cloud, made.points(), scene.method, frame)?;
                self.find_opacity(ask.see_through, talk)?;
            }
        }
        self.warn_of_effects(talk);
        talk.stage("rendering");
        self.decided = Some(asked);
        Ok(())
    }

    /// Returns the requested limits, if they are meaningful for the scene's method.
    fn wish(&mut self, ask: &Ask, talk: &Talk) -> Option<Wish> {
        let wish = ask.wish()?;
        let reason = Wish::hindrance(&self.scene, self.made.points());
        let Some(reason) = reason else { return Some(wish) };
        self.warn_once(format!("max_error and budget_ms have no effect {reason}"), talk);
        None
    }

    /// Chooses the method and its setting by the limits that they must meet.
    fn choose(&mut self, wish: Wish, talk: &Talk) -> Result<(), Failure> {
        let name = self.scene.method.fixed().map(Method::name);
        let subject = Subject {
            arranged: &self.made.arranged,
            frame: self.frame,
            background: self.scene.image.background,
            only: name,
        };
        let choice = choice::choose(&self.device, &mut self.cloud, &subject, wish, false, &talk.progress)?;
        choice.warning.iter().for_each(|warning| talk.warn(warning));
        self.frame.method = choice.method;
        if !choice.detail.is_whole() && self.cloud.supply().is_none() {
            self.cloud = self.renderer.upload_for(&choice.detail, &self.made.arranged, None)?;
        }
        self.frame.detail = choice.detail;
        self.why = "chosen by what was measured on this scene".to_owned();
        self.choice = Some(choice);
        Ok(())
    }

    /// Finds the opacity at which the median covered pixel lets a share of the light through.
    fn find_opacity(&mut self, share: Option<f64>, talk: &Talk) -> Result<(), Failure> {
        let Some(share) = share else { return Ok(()) };
        talk.stage("finding the opacity");
        let Self { renderer, cloud, frame, made, .. } = self;
        self.found = see_through::find(renderer, cloud, frame, share, see_through::largest_factor(made.points()))?;
        self.frame.factors.opacity = self.found.map_or(1.0, |found| found.factor);
        self.device.check_validation()?;
        match self.found {
            None => talk.warn(format!("see_through={share}: no pixel is covered, so that no opacity was looked for")),
            Some(found) if !found.meets(share) => talk.warn(format!(
                "see_through={share} is out of reach: the nearest lets {:.3} of the light through the median covered pixel",
                found.transmittance
            )),
            Some(_) => {}
        }
        Ok(())
    }

    /// Warns of settings and clouds that don't come out as asked.
    fn warn_of_effects(&mut self, talk: &Talk) {
        let names = made::cloud_names(&self.scene, &self.made.arranged);
        let warnings = frame_notes::warnings(&names, &self.made.arranged, &self.cloud, &self.frame, &self.why);
        warnings.into_iter().for_each(|warning| self.warn_once(warning, talk));
    }
}

/// Returns the scene with the requested view.
fn viewed(mut scene: Scene, state: &State, ask: &Ask) -> Scene {
    if ask.framed {
        scene.camera.view = state.view;
    }
    scene
}

fn check_see_through(scene: &Scene, ask: &Ask) -> Result<(), Failure> {
    match (ask.see_through, see_through::refusal(scene.method)) {
        (Some(share), Some(reason)) => Err(Failure::Value(format!("see_through={share}: {reason}"))),
        _ => Ok(()),
    }
}

fn frame_of(scene: &Scene, camera: Camera, seed: u64, ask: &Ask) -> Frame {
    // Before it is found, the opacity is one that can be seen through: `auto` takes a method for that.
    let factors = if ask.see_through.is_some() { Factors { opacity: 0.5, ..ask.factors() } } else { ask.factors() };
    Frame {
        memory_budget: ask.memory_budget,
        fragments: ask.fragments,
        stop: if ask.wish().is_some() { Default::default() } else { ask.stop() },
        factors,
        ..Frame::of_scene(scene, camera, seed)
    }
}

/// Makes points of a scene's clouds.
fn make(
    clouds: &Clouds,
    document: Document,
    scene: Scene,
    ask: &Ask,
    (seed, radii): (u64, bool),
    talk: &Talk,
) -> Result<Made, Failure> {
    talk.progress.begin(Phase::Read);
    let source = match clouds {
        Clouds::Held(clouds) => Source::Held(clouds.iter().map(|cloud| Columns::clone(cloud)).collect()),
        Clouds::Files(named) => {
            let mut named = named.clone();
            named.document = document;
            Source::open(&named, &scene, host_memory(ask)?, talk, &talk.progress)?
        }
    };
    talk.go_on()?;
    let folder = ask.folder.clone().unwrap_or_else(std::env::temp_dir);
    let wanted = Wanted { seed, legend: false, radii, folder: &folder };
    Ok(source.made(scene, wanted, talk, &talk.progress)?)
}

/// Returns the host memory that points may take, in bytes.
fn host_memory(ask: &Ask) -> Result<u64, Failure> {
    let least = io::LEAST_MEMORY;
    match ask.host_memory {
        Some(bytes) if bytes < least => {
            Err(Failure::Value(format!("host_memory: expected at least {least} bytes, found {bytes}")))
        }
        Some(bytes) => Ok(bytes),
        None => Ok(io::memory_for_points()),
    }
}
