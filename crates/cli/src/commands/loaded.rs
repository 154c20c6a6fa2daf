//! From inputs to a frame before it meets a device: scene and clouds read, points made, camera found.

use std::path::Path;

use bytesize::ByteSize;
use pellucid_engine::camera::Camera;
use pellucid_engine::cloud::shadow_texture::ShadowTexture;
use pellucid_engine::cloud::{Cloud, UpAxis};
use pellucid_engine::io::store::Summary;
use pellucid_engine::methods::see_through::Found;
use pellucid_engine::points::Points;
use pellucid_engine::prepare::Arranged;
use pellucid_engine::progress::Phase;
use pellucid_engine::scene::legend::Legend;
use pellucid_engine::scene::stored::{Stored, are_complete, have_levels, open_stores};
use pellucid_engine::scene::{self, Method, Named, Scene, ScreenSplats};
use pellucid_engine::{Error, Result, output};

use super::bar::Bar;
use super::console::Console;
use super::input::InputArgs;
use super::limit::usage;
use super::prepare_store::host_memory;

/// A frame before it meets a device.
pub struct Resolved {
    /// The inputs as they were named.
    pub name: String,
    /// All settings.
    pub scene: Scene,
    /// All points, in the order that the method wants.
    pub arranged: Arranged,
    /// The shadows of the scene that were stored with its cloud, in the order of the file.
    pub shadow_texture: Option<ShadowTexture>,
    /// The camera, given or automatic.
    pub camera: Camera,
    /// How clouds are colored and why, a phrase for each way.
    pub colorings: Vec<String>,
    /// What the colors mean, if it was asked for.
    pub legend: Option<Legend>,
    /// `--see-through`.
    pub see_through: Option<f64>,
    /// What it found already, of a scene that this is a part of.
    pub opacity_found: Option<Found>,
    /// True if an option gave all points one opacity.
    pub opacity_given: bool,
    /// `--seed`.
    pub seed: u64,
    /// Where the clouds are stored, if they are not in memory.
    pub stored: Option<Stored>,
}

impl Resolved {
    /// How much was read of clouds that stay where they are stored.
    pub fn described_reads(&self) -> Option<String> {
        let [read, all] = self.stored.as_ref()?.bytes_read();
        let share = 100.0 * read as f64 / all.max(1) as f64;
        Some(format!("{} of {} were read for the picture ({share:.1} %)", ByteSize(read), ByteSize(all)))
    }

    /// All points.
    pub fn points(&self) -> &Points {
        self.arranged.points()
    }

    /// The names of the clouds in [`Arranged::surfaces`], which omits clouds without points.
    pub fn cloud_names(&self) -> Vec<String> {
        let (clouds, count) = (&self.scene.clouds, self.arranged.surfaces().len());
        if clouds.len() == count {
            clouds.iter().map(|cloud| cloud.path.display().to_string()).collect()
        } else {
            (1..=count).map(|number| format!("cloud {number} of those with points")).collect()
        }
    }

    /// The metadata of an image. `method` and `device` are those finally used.
    pub fn metadata(&self, method: &str, device: &str) -> Vec<(String, String)> {
        output::tags(&self.name, method, &self.scene.settings, device, self.seed)
    }
}

/// How clouds are colored and why, a phrase for each way.
fn colorings(scene: &Scene, each: &[String]) -> Vec<String> {
    let mut ways: Vec<(&str, Vec<&Path>)> = Vec::new();
    for (settings, way) in scene.clouds.iter().zip(each) {
        match ways.iter_mut().find(|(known, _)| known == way) {
            Some((_, paths)) => paths.push(&settings.path),
            None => ways.push((way, vec![&settings.path])),
        }
    }
    let phrase = |(way, paths): &(&str, Vec<&Path>)| match paths[..] {
        [path] => format!("{} is colored by {way}", path.display()),
        _ => format!("{} clouds are colored by {way}", paths.len()),
    };
    ways.iter().map(phrase).collect()
}

/// Reads the inputs, applies the options and finds the camera; warnings go to standard error.
pub fn prepare(args: &InputArgs, console: Console, progress: &Bar) -> Result<Resolved> {
    read(args, None, console, progress)?.resolve(None, console, progress)
}

/// The clouds of a scene, in its order.
#[derive(Clone)]
enum Clouds {
    Held(Vec<Cloud>),
    /// They stay in their files.
    Stored(Stored),
}

/// A scene and its clouds as they were read.
#[derive(Clone)]
pub struct Loaded {
    name: String,
    scene: Scene,
    clouds: Clouds,
    /// True if the meaning of colors is asked for.
    legend: bool,
    see_through: Option<f64>,
    opacity_given: bool,
    seed: u64,
}

impl Loaded {
    /// Has the meaning of colors found as well, if it is `wanted`.
    pub fn with_legend(self, wanted: bool) -> Self {
        Self { legend: wanted, ..self }
    }

    /// The number of clouds, which are all in memory.
    ///
    /// # Errors
    /// They are not.
    pub fn count(&self) -> Result<usize> {
        match &self.clouds {
            Clouds::Held(clouds) => Ok(clouds.len()),
            Clouds::Stored(_) => Err(usage(
                "this needs all clouds in memory, and these would take more than --host-memory allows".to_owned(),
            )),
        }
    }

    /// The scene with the first `count` of its clouds alone.
    pub fn first(&self, count: usize) -> Self {
        let (mut scene, mut clouds) = (self.scene.clone(), self.clouds.clone());
        scene.clouds.truncate(count);
        if let Clouds::Held(clouds) = &mut clouds {
            clouds.truncate(count);
        }
        Self { name: self.name.clone(), scene, clouds, ..*self }
    }

    /// Makes points of the clouds, with radii even if the scene's method does without; warnings go to standard error.
    pub fn resolve_with_radii(mut self, console: Console, progress: &Bar) -> Result<Resolved> {
        self.count()?;
        let method = self.scene.method;
        if matches!(method.fixed(), Some(Method::Points | Method::ImageSpace(_))) {
            // Like these two it wants the points in canonical order, and nothing else of them.
            self.scene.method = Method::Circles(ScreenSplats::default()).into();
        }
        let mut resolved = self.resolve(None, console, progress)?;
        resolved.scene.method = method;
        Ok(resolved)
    }

    /// Makes points of the clouds, and finds the camera if it isn't `given`; warnings go to standard error.
    pub fn resolve(self, given: Option<Camera>, console: Console, progress: &Bar) -> Result<Resolved> {
        let find = |scene: &Scene, points: &Points, up: UpAxis| match given {
            Some(camera) => Ok((camera, Vec::new())),
            None => {
                scene::camera_notes(scene, points, up).iter().for_each(|note| console.note(note));
                Ok(scene::camera(scene, points, up)?)
            }
        };
        self.resolve_by(find, console, progress)
    }

    /// Makes points of the clouds, and has the camera found for these and the clouds' vertical; warnings go to standard error.
    pub fn resolve_by(
        self,
        find: impl FnOnce(&Scene, &Points, UpAxis) -> Result<(Camera, Vec<String>)>,
        console: Console,
        progress: &Bar,
    ) -> Result<Resolved> {
        let Self { name, scene, clouds, legend, see_through, opacity_given, seed } = self;
        let stored = match &clouds {
            Clouds::Stored(stored) => Some(stored.clone()),
            Clouds::Held(_) => None,
        };
        let Made { scene, arranged, legend, colorings, up, shadow_texture } = match clouds {
            Clouds::Held(clouds) => made(scene, clouds, legend, seed, console, progress)?,
            Clouds::Stored(stored) => made_of_stores(&stored, legend, seed, console, progress)?,
        };
        colorings.iter().for_each(|how| console.detail(how));
        scene::note_of_layers(&scene, arranged.points()).iter().for_each(|note| console.note(note));
        let (camera, warnings) = find(&scene, arranged.points(), up)?;
        console.detail(described(&camera, arranged.points()));
        for warning in scene.warnings.iter().chain(&warnings) {
            console.warn(warning);
        }
        Ok(Resolved {
            name,
            scene,
            arranged,
            shadow_texture,
            camera,
            colorings,
            legend,
            see_through,
            opacity_found: None,
            opacity_given,
            seed,
            stored,
        })
    }
}

/// The points of a scene, and what is known of them.
struct Made {
    scene: Scene,
    arranged: Arranged,
    legend: Option<Legend>,
    colorings: Vec<String>,
    up: UpAxis,
    shadow_texture: Option<ShadowTexture>,
}

/// What is said of a scene of Gaussians alone.
fn blended_displays() -> String {
    "colors are blended encoded, since every cloud is of Gaussians".to_owned()
}

/// Makes points of clouds in memory.
fn made(
    mut scene: Scene,
    clouds: Vec<Cloud>,
    legend: bool,
    seed: u64,
    console: Console,
    progress: &Bar,
) -> Result<Made> {
    scene::notes(&scene, &clouds, scene.method.needs_radii()).iter().for_each(|note| console.note(note));
    let (shadow_texture, note) = scene::shadow_texture(&scene, &clouds, seed);
    note.iter().for_each(|note| console.note(note));
    let up = scene::up_axis(&clouds);
    let mut colorings = colorings(&scene, &scene::colorings(&scene, &clouds));
    colorings.extend(scene.settle(&clouds).then(blended_displays));
    let (arranged, legend) = if legend {
        let (arranged, legend) = scene::arrange_with_legend(&scene, clouds, seed, progress)?;
        (arranged, Some(legend))
    } else {
        (scene::arrange(&scene, clouds, seed, progress)?, None)
    };
    Ok(Made { scene, arranged, legend, colorings, up, shadow_texture })
}

/// Points that stay where they are stored, or, if they are dealt to ensembles, in a temporary file.
fn made_of_stores(stored: &Stored, legend: bool, seed: u64, console: Console, progress: &Bar) -> Result<Made> {
    stored.notes().iter().for_each(|note| console.note(note));
    let arranged = if stored.scene().method.is_dealt() {
        let folder = std::env::temp_dir();
        console.detail(format_args!("points are dealt to ensembles in a temporary file in {}", folder.display()));
        stored.dealt(seed, &folder, progress)?
    } else {
        stored.arranged()
    };
    let mut colorings = colorings(stored.scene(), &stored.colorings());
    colorings.extend(stored.blends_displays().then(blended_displays));
    Ok(Made {
        scene: stored.scene().clone(),
        arranged,
        legend: legend.then(|| stored.legend().clone()),
        colorings,
        up: stored.up(),
        shadow_texture: None,
    })
}

/// The camera that was found, as a scene file has it.
fn described(camera: &Camera, points: &Points) -> String {
    let distance = points.bounds().map_or(1.0, |bounds| (bounds.center() - camera.eye).dot(camera.forward));
    camera.to_toml(distance)
}

/// Reads the inputs and applies the options. `size` is the image size for when no option gives one.
pub fn read(args: &InputArgs, size: Option<[u32; 2]>, console: Console, progress: &Bar) -> Result<Loaded> {
    let overrides = args.overrides(size)?;
    progress.begin(Phase::Read);
    let named = scene::name(&args.inputs, &overrides, args.seed)?;
    let mut scene = named.document.scene()?;
    args.preset().iter().for_each(|preset| console.note(preset.note()));
    scene.camera.view = args.view_of(&scene);
    if let (Some(share), Some(method)) = (args.see_through, scene.method.fixed())
        && !method.family().has_opacity()
    {
        let name = method.name();
        let problem = format!(
            "--see-through {share}: no opacity makes light pass through the pictures of method {name}; `auto`, abuffer, sorted, \
             spbr and others have one (--help lists them)"
        );
        return Err(usage(problem));
    }
    let opacity_given = args.opacity.is_some() || args.surface_opacity.is_some();
    let name = named.name.clone();
    let (clouds, see_through) = match stored(args, &named, &scene, console, progress)? {
        Some(stored) => {
            let see_through = args.share_of(&scene, stored.is_classified());
            (Clouds::Stored(stored), see_through)
        }
        None => {
            let clouds = named.load(progress)?.clouds;
            for (settings, cloud) in scene.clouds.iter().zip(&clouds) {
                report_cloud(&settings.path, cloud, console);
            }
            let see_through = args.share(&scene, &clouds);
            (Clouds::Held(clouds), see_through)
        }
    };
    Ok(Loaded { name, scene, clouds, legend: false, see_through, opacity_given, seed: args.seed })
}

/// The scene with its clouds where they are stored, if memory is too small for all of them, or if they have levels of detail there that
/// the picture does without.
fn stored(args: &InputArgs, named: &Named, scene: &Scene, console: Console, progress: &Bar) -> Result<Option<Stored>> {
    let memory = host_memory(args.host_memory)?;
    let announced = named.needed_memory()?;
    let needed = announced.unwrap_or(0);
    let fits = needed <= memory;
    let by_levels = || Ok::<_, Error>(announced.is_some() && !scene.detail.is_whole() && have_levels(scene)?);
    if fits && (scene.method.is_dealt() || !by_levels()?) {
        return Ok(None);
    }
    if !fits {
        console.detail(format_args!(
            "all points would take {} of memory, {} are allowed: they are read as the picture needs them",
            ByteSize(needed),
            ByteSize(memory)
        ));
    }
    let stores = open_stores(scene, progress)?;
    if fits && !are_complete(scene, &stores)? {
        console.note(
            "the levels of stores have neither the radii nor the normals that the scene needs: points are left out at random instead; \
             `pellucid prepare` stores both",
        );
        return Ok(None);
    }
    stores.iter().for_each(|store| report_store(store.summary(), console));
    Ok(Some(Stored::new(scene, &stores, memory, progress)?))
}

/// Says how large a cloud is that stays where it is stored, and what is odd about it.
pub fn report_store(summary: &Summary, console: Console) {
    console.detail(format_args!("{}: {} points", summary.path.display(), summary.points));
    report_cloud(&summary.path, &summary.like, console.without_details());
}

/// Says what was read and what was odd about it.
pub fn report_cloud(path: &Path, cloud: &Cloud, console: Console) {
    let path = path.display();
    console.detail(format_args!("{path}: {} points", cloud.len()));
    if cloud.non_finite > 0 {
        console.warn(format_args!("{path}: {} points without finite coordinates are left out", cloud.non_finite));
    }
    cloud.warnings.iter().for_each(|warning| console.warn(format_args!("{path}: {warning}")));
}
