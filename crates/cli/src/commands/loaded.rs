//! From inputs to a frame before it meets a device: scene and clouds read, points made, camera found.

use bytesize::ByteSize;
use pellucid_engine::camera::Camera;
use pellucid_engine::cloud::UpAxis;
use pellucid_engine::cloud::shadow_texture::ShadowTexture;
use pellucid_engine::methods::see_through::{self, Found};
use pellucid_engine::points::Points;
use pellucid_engine::prepare::Arranged;
use pellucid_engine::progress::Phase;
use pellucid_engine::scene::legend::Legend;
use pellucid_engine::scene::made::{Made, Source, Wanted};
use pellucid_engine::scene::stored::Stored;
use pellucid_engine::scene::{self, Scene};
use pellucid_engine::{Result, output};

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
    /// Meaning of the colors, if it was requested.
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
    /// True if points that are in memory come to the device window by window, even if it has room for all.
    pub by_windows: bool,
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

    /// The metadata of an image. `method` and `device` are those finally used.
    pub fn metadata(&self, method: &str, device: &str) -> Vec<(String, String)> {
        output::tags(&self.name, method, &self.scene.settings, device, self.seed)
    }
}

/// Reads the inputs, applies the options and finds the camera; warnings go to standard error.
pub fn prepare(args: &InputArgs, console: Console, progress: &Bar) -> Result<Resolved> {
    read(args, None, console, progress)?.resolve(None, console, progress)
}

/// A scene and its clouds as they were read.
#[derive(Clone)]
pub struct Loaded {
    name: String,
    scene: Scene,
    clouds: Source,
    /// True if the meaning of colors is asked for.
    legend: bool,
    /// True if radii are wanted whatever the method.
    radii: bool,
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
            Source::Held(clouds) => Ok(clouds.len()),
            Source::Stored(_) => Err(usage(
                "this command needs all clouds in memory, but they take more than --host-memory allows".to_owned(),
            )),
        }
    }

    /// The scene with the first `count` of its clouds alone.
    pub fn first(&self, count: usize) -> Self {
        let (mut scene, mut clouds) = (self.scene.clone(), self.clouds.clone());
        scene.clouds.truncate(count);
        if let Source::Held(clouds) = &mut clouds {
            clouds.truncate(count);
        }
        Self { name: self.name.clone(), scene, clouds, ..*self }
    }

    /// Has radii estimated even if the scene's method does without.
    pub fn with_radii(self) -> Self {
        Self { radii: true, ..self }
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
        let Self { name, scene, clouds, legend, radii, see_through, opacity_given, seed } = self;
        let wanted = Wanted { seed, legend, radii, folder: &std::env::temp_dir() };
        let Made { scene, arranged, legend, colorings, up, shadow_texture, stored, follows_method: _ } =
            clouds.made(scene, wanted, &console, progress)?;
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
            by_windows: false,
        })
    }
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
    if let (Some(share), Some(reason)) = (args.see_through, see_through::refusal(scene.method)) {
        return Err(usage(format!("--see-through {share}: {reason} (--help lists them)")));
    }
    let opacity_given = args.opacity.is_some() || args.surface_opacity.is_some();
    let name = named.name.clone();
    let open = if args.kept_in_files.holds(&named, &scene)? { Source::open_in_parts } else { Source::open };
    let clouds = open(&named, &scene, host_memory(args.host_memory)?, &console, progress)?;
    let see_through = match &clouds {
        Source::Held(clouds) => args.share(&scene, clouds),
        Source::Stored(stored) => args.share_of(&scene, stored.is_classified()),
    };
    Ok(Loaded { name, scene, clouds, legend: false, radii: false, see_through, opacity_given, seed: args.seed })
}
