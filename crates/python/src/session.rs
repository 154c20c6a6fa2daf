//! A scene on a device: the road of `pellucid render`, which `crates/cli/src/commands/loaded.rs` and `session.rs` take for
//! the command line.

use pellucid_engine::camera::Camera;
use pellucid_engine::cloud::{Cloud as Columns, UpAxis};
use pellucid_engine::gpu::Device;
use pellucid_engine::methods::see_through::{self, Found};
use pellucid_engine::methods::{Factors, Frame, Renderer, spbr};
use pellucid_engine::passes::project::DeviceCloud;
use pellucid_engine::points::Points;
use pellucid_engine::prepare::Arranged;
use pellucid_engine::progress::Phase;
use pellucid_engine::scene::stored::{Stored, are_complete, have_levels, open_stores};
use pellucid_engine::scene::{self as engine, Document, Method, MethodChoice, Named, Scene, ScreenSplats, Vertical};
use pellucid_engine::{io, plan};
use pellucid_lab::choice::{self, Choice, Subject, Wish};
use pellucid_lab::ensemble_warnings;
use pellucid_lab::report::tradeoff::settings::formation;

use crate::failure::Failure;
use crate::request::{self, Ask};
use crate::scene::{Clouds, State};
use crate::talk::Talk;

/// A scene on a device, and the frame that was asked for last.
pub struct Session {
    pub state: State,
    pub device: Device,
    pub renderer: Renderer,
    pub cloud: DeviceCloud,
    pub made: Made,
    /// The settings in force.
    pub scene: Scene,
    pub frame: Frame,
    /// The reason for the method.
    pub why: String,
    pub found: Option<Found>,
    pub choice: Option<Choice>,
    /// What method and opacities were decided for.
    decided: Option<Decided>,
    told: Vec<String>,
}

/// The points of a scene, and what is known of them.
pub struct Made {
    /// The settings that they were made by.
    scene: Scene,
    pub arranged: Arranged,
    pub colorings: Vec<String>,
    up: UpAxis,
    pub stored: Option<Stored>,
    /// The camera that was found last, and for which settings.
    camera: Option<(Scene, Camera)>,
}

#[derive(PartialEq)]
struct Decided {
    method: MethodChoice,
    frame: Frame,
    see_through: Option<f64>,
    wish: Option<Wish>,
}

impl Made {
    pub fn points(&self) -> &Points {
        self.arranged.points()
    }

    /// True if a scene wants other points, or others of their columns.
    fn is_outdated_for(&self, scene: &Scene, seed: (u64, u64)) -> bool {
        let (a, b) = (&self.scene, scene);
        let needs = |scene: &Scene| {
            let method = &scene.method;
            (method.is_dealt(), method.needs_radii(), method.needs_field(), scene.shading_normals())
        };
        // Heights are those along the camera's vertical.
        let vertical = |scene: &Scene| scene.camera.up.and_then(Vertical::nearest).unwrap_or(self.up.into());
        let splats = self.points().gaussians.is_some() || self.points().whole.is_some();
        a.clouds != b.clouds
            || a.clips != b.clips
            || needs(a) != needs(b)
            || a.shadows != b.shadows
            || vertical(a).up() != vertical(b).up()
            || (splats && (a.method != b.method || a.image.color != b.image.color || a.detail != b.detail))
            || (a.method.is_dealt() && seed.0 != seed.1)
    }
}

impl Session {
    /// Reads, arranges and uploads the points of a scene, and decides the method.
    pub fn open(device: Device, state: State, ask: &Ask, with_radii: bool, talk: &Talk) -> Result<Self, Failure> {
        let mut document = state.document.clone();
        let scene = request::lay_over(&mut document, &ask.drop, &ask.changes)?;
        let scene = viewed(scene, &state, ask);
        check_see_through(&scene, ask)?;
        let (made, mut scene, texture) = make(&state, document, scene, ask, with_radii, talk)?;
        talk.go_on()?;
        let mut made = made;
        for note in engine::camera_notes(&scene, made.points(), made.up) {
            talk.note(note);
        }
        let (camera, warnings) = engine::camera(&scene, made.points(), made.up)?;
        let told: Vec<String> = scene.warnings.iter().chain(&warnings).cloned().collect();
        told.iter().for_each(|warning| talk.warn(warning));
        made.camera = Some((scene.clone(), camera));
        talk.progress.begin(Phase::Upload);
        talk.stage("uploading");
        let renderer = Renderer::new(&device)?;
        let cloud = renderer.upload_for(&scene.detail, &made.arranged, texture.as_ref())?;
        scene.warnings.clear();
        let frame = frame_of(&scene, camera, ask.seed.unwrap_or(state.seed), ask);
        let why = String::new();
        let (found, choice, decided) = (None, None, None);
        Ok(Self { state, device, renderer, cloud, made, scene, frame, why, found, choice, decided, told })
    }

    /// Gets everything ready for the frame that is asked for.
    pub fn prepare(&mut self, ask: &Ask, talk: &Talk) -> Result<(), Failure> {
        self.renderer.progress = talk.progress.clone();
        let mut document = self.state.document.clone();
        let scene = request::lay_over(&mut document, &ask.drop, &ask.changes)?;
        let mut scene = viewed(scene, &self.state, ask);
        check_see_through(&scene, ask)?;
        let seed = ask.seed.unwrap_or(self.state.seed);
        if self.made.is_outdated_for(&scene, (self.frame.seed, seed)) {
            let state = State { seed, ..self.state.clone() };
            let (made, settled, texture) = make(&state, document, scene, ask, false, talk)?;
            self.cloud = self.renderer.upload_for(&settled.detail, &made.arranged, texture.as_ref())?;
            (self.made, scene, self.decided) = (made, settled, None);
        } else {
            scene.image.color = scene.image.color.or(self.made.scene.image.color);
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
        self.decide(frame, ask, talk)
    }

    fn warn_once(&mut self, warning: String, talk: &Talk) {
        if !self.told.contains(&warning) {
            talk.warn(&warning);
            self.told.push(warning);
        }
    }

    /// The camera of a scene of these points.
    fn camera(&mut self, scene: &Scene, talk: &Talk) -> Result<Camera, Failure> {
        if let Some((known, camera)) = &self.made.camera
            && known.camera == scene.camera
            && known.image.size == scene.image.size
        {
            return Ok(*camera);
        }
        let points = self.made.points();
        let given = points.bounds().filter(|_| !scene.camera.view.is_given());
        let given = given.and_then(|bounds| engine::camera_at(&scene.camera, &bounds, points.largest_radius()));
        let camera = match given {
            Some(camera) => camera,
            None => {
                let (camera, warnings) = engine::camera(scene, points, self.made.up)?;
                warnings.into_iter().for_each(|warning| self.warn_once(warning, talk));
                camera
            }
        };
        self.made.camera = Some((scene.clone(), camera));
        Ok(camera)
    }

    /// Decides method and opacities, unless nothing that they follow from has changed.
    fn decide(&mut self, frame: Frame, ask: &Ask, talk: &Talk) -> Result<(), Failure> {
        let asked = Decided { method: self.scene.method, frame, see_through: ask.see_through, wish: ask.wish() };
        if self.decided.as_ref() == Some(&asked) {
            return Ok(());
        }
        self.frame = frame;
        (self.found, self.choice) = (None, None);
        talk.progress.begin(Phase::Frame);
        talk.stage("choosing the method");
        if ask.see_through.is_some() {
            // Before it is found, the opacity is one that can be seen through: `auto` takes a method for that.
            self.frame.factors.opacity = 0.5;
        }
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

    /// The limits that are asked for, if they are meaningful for the scene's method.
    fn wish(&mut self, ask: &Ask, talk: &Talk) -> Option<Wish> {
        let wish = ask.wish()?;
        let points = self.made.points();
        let taken = plan::resolve(self.scene.method, points).0;
        let stays = if self.scene.shadows.is_some() && taken.takes_shadows() {
            "where there are shadows"
        } else if self.scene.shading.edl.edl {
            "with eye-dome lighting, which only some methods have"
        } else if formation(&self.scene.method.representative(), points).is_err() {
            "on this method, whose image no other one draws"
        } else {
            return Some(wish);
        };
        let name = taken.name();
        self.warn_once(format!("max_error and budget_ms have no effect {stays}: {name} stays the method"), talk);
        None
    }

    /// Chooses method and setting by what they must keep to.
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
        let opacities = &self.made.points().opacities;
        let faintest = opacities.iter().copied().filter(|a| *a > 0.0).fold(1.0, f32::min);
        let Self { renderer, cloud, frame, .. } = self;
        self.found = see_through::find(renderer, cloud, frame, share, 1.0 / faintest)?;
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
        let shares = spbr::shares(&self.cloud, &self.frame).unwrap_or_default();
        let names = self.cloud_names();
        let warnings = ensemble_warnings::warnings(&names, self.made.arranged.surfaces(), &shares, &self.frame);
        warnings.into_iter().for_each(|warning| self.warn_once(warning, talk));
        let (method, whole) = (self.frame.method, self.frame.detail.is_whole());
        let name = method.name();
        if !whole && method.is_dealt() {
            self.warn_once(format!("[detail] has no effect: method {name} deals all points to ensembles"), talk);
        } else if !whole && !method.needs_radii() {
            let message =
                format!("method {name} draws points of one size, which don't grow to cover what [detail] leaves out");
            self.warn_once(message, talk);
        }
        if self.frame.shadows.is_some() && !method.takes_shadows() {
            let message = format!("[shadows] has no effect: method {name} takes no shadows ({})", self.why);
            self.warn_once(message, talk);
        }
    }

    /// The names of the clouds that have points.
    fn cloud_names(&self) -> Vec<String> {
        let (clouds, count) = (&self.scene.clouds, self.made.arranged.surfaces().len());
        if clouds.len() == count {
            clouds.iter().map(|cloud| cloud.path.display().to_string()).collect()
        } else {
            (1..=count).map(|number| format!("cloud {number} of those with points")).collect()
        }
    }
}

/// The scene with the view that is asked for.
fn viewed(mut scene: Scene, state: &State, ask: &Ask) -> Scene {
    if ask.framed {
        scene.camera.view = state.view;
    }
    scene
}

fn check_see_through(scene: &Scene, ask: &Ask) -> Result<(), Failure> {
    match (ask.see_through, scene.method.fixed()) {
        (Some(share), Some(method)) if !method.family().has_opacity() => Err(Failure::Value(format!(
            "see_through={share}: no opacity makes light pass through the pictures of method {}; auto, abuffer, sorted, spbr and others \
             have one",
            method.name()
        ))),
        _ => Ok(()),
    }
}

fn frame_of(scene: &Scene, camera: Camera, seed: u64, ask: &Ask) -> Frame {
    let factors = if ask.see_through.is_some() { Factors { opacity: 0.5, ..ask.factors() } } else { ask.factors() };
    Frame {
        memory_budget: ask.memory_budget,
        fragments: ask.fragments,
        stop: if ask.wish().is_some() { Default::default() } else { ask.stop() },
        factors,
        ..Frame::of_scene(scene, camera, seed)
    }
}

type Texture = Option<pellucid_engine::cloud::shadow_texture::ShadowTexture>;

/// Makes points of a scene's clouds.
fn make(
    state: &State,
    document: Document,
    scene: Scene,
    ask: &Ask,
    with_radii: bool,
    talk: &Talk,
) -> Result<(Made, Scene, Texture), Failure> {
    talk.progress.begin(Phase::Read);
    let clouds = match &state.clouds {
        Clouds::Held(clouds) => clouds.iter().map(|cloud| Columns::clone(cloud)).collect(),
        Clouds::Files(named) => {
            let mut named = named.clone();
            named.document = document;
            match stored(&named, &scene, ask, talk)? {
                Some(stored) => return made_of_stores(&stored, state.seed, ask, talk),
                None => {
                    let clouds = named.load(&talk.progress)?.clouds;
                    tell_of(&scene, &clouds, talk);
                    clouds
                }
            }
        }
    };
    talk.go_on()?;
    made_of_clouds(scene, clouds, state.seed, with_radii, talk)
}

fn tell_of(scene: &Scene, clouds: &[Columns], talk: &Talk) {
    for (settings, cloud) in scene.clouds.iter().zip(clouds) {
        let path = settings.path.display();
        if cloud.non_finite > 0 {
            talk.warn(format!("{path}: {} points without finite coordinates are left out", cloud.non_finite));
        }
        cloud.warnings.iter().for_each(|warning| talk.warn(format!("{path}: {warning}")));
    }
}

/// Makes points of clouds in memory; `with_radii` even if the scene's method does without.
fn made_of_clouds(
    mut scene: Scene,
    clouds: Vec<Columns>,
    seed: u64,
    with_radii: bool,
    talk: &Talk,
) -> Result<(Made, Scene, Texture), Failure> {
    let method = scene.method;
    if with_radii && matches!(method.fixed(), Some(Method::Points | Method::ImageSpace(_))) {
        // Like these two it wants the points in canonical order, and nothing else of them.
        scene.method = Method::Circles(ScreenSplats::default()).into();
    }
    for note in engine::notes(&scene, &clouds, scene.method.needs_radii()) {
        talk.note(note);
    }
    let (texture, note) = engine::shadow_texture(&scene, &clouds, seed);
    note.into_iter().for_each(|note| talk.note(note));
    let up = engine::up_axis(&clouds);
    let colorings = colorings(&scene, &engine::colorings(&scene, &clouds));
    scene.settle(&clouds);
    let arranged = engine::arrange(&scene, clouds, seed, &talk.progress)?;
    scene.method = method;
    let made = Made { scene: scene.clone(), arranged, colorings, up, stored: None, camera: None };
    Ok((made, scene, texture))
}

/// Points that stay where they are stored, or, if they are dealt to ensembles, in a temporary file.
fn made_of_stores(stored: &Stored, seed: u64, ask: &Ask, talk: &Talk) -> Result<(Made, Scene, Texture), Failure> {
    stored.notes().iter().for_each(|note| talk.note(note));
    let arranged = if stored.scene().method.is_dealt() {
        let folder = ask.folder.clone().unwrap_or_else(std::env::temp_dir);
        stored.dealt(seed, &folder, &talk.progress)?
    } else {
        stored.arranged()
    };
    let scene = stored.scene().clone();
    let colorings = colorings(&scene, &stored.colorings());
    let (up, stored) = (stored.up(), Some(stored.clone()));
    Ok((Made { scene: scene.clone(), arranged, colorings, up, stored, camera: None }, scene, None))
}

/// The scene with its clouds where they are stored, if memory is too small for all of them, or if they have levels of detail
/// there that the picture does without.
fn stored(named: &Named, scene: &Scene, ask: &Ask, talk: &Talk) -> Result<Option<Stored>, Failure> {
    let memory = match ask.host_memory {
        Some(bytes) if bytes < io::LEAST_MEMORY => {
            return Err(Failure::Value(format!(
                "host_memory: expected at least {} bytes, found {bytes}",
                io::LEAST_MEMORY
            )));
        }
        Some(bytes) => bytes,
        None => io::memory_for_points(),
    };
    let announced = named.needed_memory()?;
    let fits = announced.unwrap_or(0) <= memory;
    let by_levels = || Ok::<_, Failure>(announced.is_some() && !scene.detail.is_whole() && have_levels(scene)?);
    if fits && (scene.method.is_dealt() || !by_levels()?) {
        return Ok(None);
    }
    let stores = open_stores(scene, &talk.progress)?;
    if fits && !are_complete(scene, &stores)? {
        talk.note(
            "the levels of stores have neither the radii nor the normals that the scene needs: points are left out at random instead; \
             `pellucid prepare` stores both",
        );
        return Ok(None);
    }
    Ok(Some(Stored::new(scene, &stores, memory, &talk.progress)?))
}

/// How clouds are colored and why, a phrase for each way.
fn colorings(scene: &Scene, each: &[String]) -> Vec<String> {
    let phrase =
        |(settings, way): (&engine::CloudSettings, &String)| format!("{} is colored by {way}", settings.path.display());
    scene.clouds.iter().zip(each).map(phrase).collect()
}
