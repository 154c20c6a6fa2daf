//! The inputs that `render`, `profile` and `plan` share: a scene file, point clouds or nothing, with options over them.

use std::path::{Path, PathBuf};

use super::bar::Bar;
use clap::Args;
use glam::DVec3;
use pellucid_engine::camera::Camera;
use pellucid_engine::cloud::shadow_texture::ShadowTexture;
use pellucid_engine::cloud::{Cloud, UpAxis};
use pellucid_engine::points::Points;
use pellucid_engine::prepare::Arranged;
use pellucid_engine::scene::legend::Legend;
use pellucid_engine::scene::{
    self, DEFAULT_SCENE, Family, Method, Opened, Overrides, Scene, ScreenSplats, Vertical, View, ViewName,
};
use pellucid_engine::{Result, output};

use super::console::Console;
use super::filters;
use super::presets::{self, Asked, Preset};

/// The inputs to render, and the options that stand for keys of a scene file.
#[derive(Debug, Args)]
pub struct InputArgs {
    /// A scene file (.toml) or one or more point clouds (PLY, LAS, LAZ, COPC, E57, PCD, PTS, PTX, XYZ, CSV, TXT), or pictures
    /// that stand for clouds. Without any: the built-in scene `garden`.
    #[arg(value_name = "INPUT")]
    pub inputs: Vec<PathBuf>,
    /// A recipe, which is a set of keys: canopy, building, indoor, heritage or model; `list` prints their keys. It wins over the
    /// scene file, and options win over it.
    #[arg(long, value_name = "NAME", value_parser = presets::asked)]
    preset: Option<Asked>,
    // The help lists all methods.
    #[arg(long, value_name = "NAME", help = method_help())]
    method: Option<String>,
    /// Size of the image in pixels, as in 1024x768; by default the scene file's, else 1024x1024.
    #[arg(long, value_name = "WxH")]
    pub size: Option<String>,
    // The help lists all keys.
    #[arg(long, value_name = "KEY=VALUE", help = SET_HELP, long_help = set_help())]
    set: Vec<String>,
    /// Opacity of all points, from 0 to 1; by default the scene file's, else 1. A file's own alpha multiplies it.
    #[arg(long, value_name = "A", allow_hyphen_values = true)]
    opacity: Option<String>,
    /// Opacity of the surface that the points lie on, from 0 to 1: discs become as faint as their overlap asks for. For spbr the
    /// same as --opacity.
    #[arg(long, value_name = "A", allow_hyphen_values = true, conflicts_with_all = ["opacity"])]
    surface_opacity: Option<String>,
    /// Finds the opacity for which half of the covered pixels let at least this share of the light behind them through, from 0
    /// to 1, and prints it. Of clouds with opacities of their own all are multiplied by one factor.
    #[arg(long, value_name = "T", value_parser = share, conflicts_with = "opacity")]
    see_through: Option<f64>,
    /// Radius of all points in world units; by default the scene file's, else the point file's, else from the distance
    /// to the 24th nearest neighbor.
    #[arg(long, value_name = "R", allow_hyphen_values = true)]
    radius: Option<String>,
    /// The meaning of the colors: auto, rgb, height, intensity, classification, return, source, gps-time, normal, cloud, uniform,
    /// field, or the name of a scalar of the file; by default the scene file's, else auto, which is the file's colors, else
    /// classes, else height (`plan` says which, and why).
    #[arg(long, value_name = "WHAT")]
    color_by: Option<String>,
    /// The colors of values: viridis, cividis, magma, inferno, plasma, turbo, terrain or grey; by default the scene file's, else
    /// viridis.
    #[arg(long, value_name = "NAME")]
    colormap: Option<String>,
    /// Opacity of a class, as in high-vegetation=0.05 or 5=0.05; repeatable.
    #[arg(long, value_name = "NAME=OPACITY")]
    class: Vec<String>,
    /// Draw these classes only, as in 2,6 or ground,building.
    #[arg(long, value_name = "LIST")]
    classes: Option<String>,
    /// Draw all classes but these, as in 7,18.
    #[arg(long, value_name = "LIST")]
    without: Option<String>,
    /// Draw what lies between two planes across an axis, as in z=2..4, z=2.. or z=..4; repeatable.
    #[arg(long, value_name = "AXIS=FROM..TO")]
    slice: Vec<String>,
    /// Columns of text files (PTS, PTX, XYZ, CSV, TXT), as in x,y,z,-,r,g,b: also a (alpha), i (intensity),
    /// nx, ny, nz, radius, class, any other word for a scalar, and - for a column to skip. By default the scene file's, else
    /// the file's own line of names, else by the columns' number and values.
    #[arg(long, value_name = "LIST", allow_hyphen_values = true)]
    columns: Option<String>,
    /// Background: a color of CSS (white, "#80c0ff"), or linear R,G,B, each from 0 to 1; by default the scene file's, else
    /// black.
    #[arg(long, value_name = "COLOR", allow_hyphen_values = true)]
    background: Option<String>,
    /// Frame the whole scene from a named side, or from where a compass points. This and the two angles replace the camera's eye
    /// and target.
    #[arg(long, value_enum, value_name = "NAME")]
    view: Option<Side>,
    /// Degrees around the vertical: 0 from the front (−Y of surveys, +Z of models), 90 from +X; or where a compass points, as in
    /// SW: N is +Y of surveys and −Z of models, E is +X.
    #[arg(long, value_name = "DEG", allow_hyphen_values = true, value_parser = azimuth)]
    azimuth: Option<f64>,
    /// Degrees above the horizon, from −90 to 90.
    #[arg(long, value_name = "DEG", allow_hyphen_values = true, value_parser = elevation)]
    elevation: Option<f64>,
    /// The vertical, as in y or -z: the axis that points to the top of the image. By default the scene file's camera.up, else Y for
    /// PLY (Z for one in survey coordinates), Z for all other point clouds.
    #[arg(long, value_name = "AXIS", allow_hyphen_values = true, value_parser = axis)]
    up: Option<Vertical>,
    /// An orthographic camera; without camera.height it shows the whole scene.
    #[arg(long)]
    ortho: bool,
    /// Seed of everything random: of the built-in scene, if it is rendered, and of stochastic methods.
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub seed: u64,
}

/// The sides that `--view` names.
#[derive(Debug, Clone, Copy, clap::ValueEnum)]
enum Side {
    /// The side that a viewer of the file's convention faces: −Y for surveys (from the south), +Z for models.
    Front,
    /// From behind.
    Back,
    /// From −X.
    Left,
    /// From +X.
    Right,
    /// From above; north (surveys) or the back (models) is at the image's top.
    Top,
    /// From below.
    Bottom,
    /// From the front's right and above, all three axes equally foreshortened.
    Iso,
    /// From the south and above.
    South,
    /// From the south-east and above.
    SouthEast,
    /// From the east and above.
    East,
    /// From the north-east and above.
    NorthEast,
    /// From the north and above.
    North,
    /// From the north-west and above.
    NorthWest,
    /// From the west and above.
    West,
    /// From the south-west and above.
    SouthWest,
}

impl From<Side> for ViewName {
    fn from(side: Side) -> Self {
        match side {
            Side::Front => Self::Front,
            Side::Back => Self::Back,
            Side::Left => Self::Left,
            Side::Right => Self::Right,
            Side::Top => Self::Top,
            Side::Bottom => Self::Bottom,
            Side::Iso => Self::Iso,
            Side::South => Self::South,
            Side::SouthEast => Self::SouthEast,
            Side::East => Self::East,
            Side::NorthEast => Self::NorthEast,
            Side::North => Self::North,
            Side::NorthWest => Self::NorthWest,
            Side::West => Self::West,
            Side::SouthWest => Self::SouthWest,
        }
    }
}

/// Every method, family by family.
fn method_help() -> String {
    let family = |family: Family| {
        let names: Vec<_> = family.methods().map(|method| method.name()).collect();
        format!("{} ({})", names.join(", "), family.title())
    };
    let families: Vec<_> = Family::ALL.into_iter().map(family).collect();
    format!(
        "The method: {}; or auto, the cheapest one that is exact for the scene (`plan` says which, and why). By default the \
         scene file's, else auto",
        families.join("; ")
    )
}

const SET_HELP: &str = "Any key of the scene file by its dotted path, as in method.shape=oriented, cloud.0.opacity=0.2 or \
    cloud.*.neighbors=12; the value is TOML, or else a string. Repeatable; wins over the file and over short forms";

/// Describes the option, and lists every key, table by table.
fn set_help() -> String {
    let names = |path: &str, keys: &mut dyn Iterator<Item = &'static str>| {
        let keys: Vec<_> = keys.collect();
        format!("{path}: {}", keys.join(", "))
    };
    let tables = scene::tables();
    let tables = tables.iter().map(|table| names(table.path, &mut table.keys.iter().map(|key| key.name)));
    let method = names("method", &mut std::iter::once("name").chain(scene::all_method_keys()));
    let lines: Vec<_> = tables.chain([method]).collect();
    format!("{SET_HELP}. The keys (docs/scene-file.md says more):\n{}", lines.join("\n"))
}

fn finite(text: &str) -> Result<f64, String> {
    text.parse().ok().filter(|x: &f64| x.is_finite()).ok_or_else(|| "expected a number of degrees".into())
}

/// Degrees, or a point of the compass by its letters or words.
fn azimuth(text: &str) -> Result<f64, String> {
    const COMPASS: [(&str, &str); 8] = [
        ("s", "south"),
        ("se", "south-east"),
        ("e", "east"),
        ("ne", "north-east"),
        ("n", "north"),
        ("nw", "north-west"),
        ("w", "west"),
        ("sw", "south-west"),
    ];
    let lower = text.to_lowercase();
    let point = COMPASS.iter().position(|(letters, words)| lower == *letters || lower == *words);
    let degrees = point.map(|point| 45.0 * point as f64).or_else(|| finite(text).ok());
    degrees.ok_or_else(|| "expected a number of degrees, or N, NE, E, SE, S, SW, W or NW".into())
}

/// An axis and which way it goes.
fn axis(text: &str) -> Result<Vertical, String> {
    let (sign, name) = text.strip_prefix('-').map_or((1.0, text.trim_start_matches('+')), |name| (-1.0, name));
    let direction = match name {
        "x" | "X" => Some(DVec3::X),
        "y" | "Y" => Some(DVec3::Y),
        "z" | "Z" => Some(DVec3::Z),
        _ => None,
    };
    direction.and_then(|axis| Vertical::nearest(sign * axis)).ok_or_else(|| "expected x, y, z, -x, -y or -z".into())
}

fn share(text: &str) -> Result<f64, String> {
    finite(text).ok().filter(|x| (0.0..=1.0).contains(x)).ok_or_else(|| "expected a share from 0 to 1".into())
}

fn elevation(text: &str) -> Result<f64, String> {
    finite(text).ok().filter(|x| x.abs() <= 90.0).ok_or_else(|| "expected degrees from -90 to 90".into())
}

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
    /// True if an option gave all points one opacity.
    pub opacity_given: bool,
    /// `--seed`.
    pub seed: u64,
}

impl Resolved {
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

impl InputArgs {
    /// The method requested by `--method`; `None` for `auto`.
    pub fn asked_method(&self) -> Option<&str> {
        self.method.as_deref().filter(|name| *name != "auto")
    }

    /// The file that a picture of these inputs is written to if no other is named: after the first input, here.
    pub fn default_output(&self) -> PathBuf {
        self.named(".png")
    }

    /// Like [`InputArgs::default_output`], for the steps of a time series.
    pub fn default_steps(&self) -> PathBuf {
        self.named("_%02d.png")
    }

    /// Like [`InputArgs::default_output`], for the frames of a camera path.
    pub fn default_frames(&self) -> PathBuf {
        self.named("_%04d.png")
    }

    fn named(&self, end: &str) -> PathBuf {
        let stem = self.inputs.first().and_then(|input| input.file_stem());
        let mut name = stem.unwrap_or(DEFAULT_SCENE.as_ref()).to_owned();
        name.push(end);
        name.into()
    }

    /// The options as keys of the scene file; `size` counts where `--size` is not given.
    pub fn overrides(&self, size: Option<[u32; 2]>) -> Result<Overrides> {
        let mut overrides = Overrides::default();
        if let Some(preset) = self.preset() {
            // First, so that all other options win.
            preset.apply(&mut overrides, |key| self.gives(key))?;
        }
        if let (None, Some([width, height])) = (&self.size, size) {
            overrides.set("--path", "image.size", &format!("[{width}, {height}]"))?;
        }
        if let Some(size) = &self.size {
            let option = format!("--size {size}");
            let Some((width, height)) = size.split_once(['x', 'X', '×']) else {
                return Err(scene::Error::Usage(format!("{option}: expected WxH, as in 1024x768")).into());
            };
            overrides.set(option, "image.size", &format!("[{width}, {height}]"))?;
        }
        if let Some(columns) = &self.columns {
            overrides.set(format!("--columns {columns}"), "cloud.*.columns", &format!("{columns:?}"))?;
        }
        if let Some(background) = &self.background {
            overrides.set(format!("--background {background}"), "image.background", &color_as_toml(background))?;
        }
        let short = [
            ("method", "method.name", &self.method),
            ("opacity", "cloud.*.opacity", &self.opacity),
            ("surface-opacity", "cloud.*.surface_opacity", &self.surface_opacity),
            ("radius", "cloud.*.radius", &self.radius),
            ("colormap", "cloud.*.colormap", &self.colormap),
        ];
        if let Some(name) = &self.color_by {
            // The name of a scalar may look like a number.
            overrides.set(format!("--color-by {name}"), "cloud.*.color_by", &format!("{name:?}"))?;
        }
        for (option, key, value) in short {
            if let Some(value) = value {
                overrides.set(format!("--{option} {value}"), key, value)?;
            }
        }
        let Self { class, classes, without, slice, .. } = self;
        filters::classes(&mut overrides, class, classes.as_deref(), without.as_deref())?;
        filters::slices(&mut overrides, slice)?;
        if let Some(up) = self.up {
            overrides.set(format!("--up {up}"), "camera.up", &format!("{:?}", up.up().to_array()))?;
        }
        if self.ortho {
            overrides.set("--ortho", "camera.ortho", "true")?;
        }
        self.set.iter().try_for_each(|pair| overrides.set_pair(pair))?;
        Ok(overrides)
    }

    /// True if the presets are to be printed instead of anything else.
    pub fn lists_presets(&self) -> bool {
        self.preset == Some(Asked::List)
    }

    /// The preset that was asked for.
    pub fn preset(&self) -> Option<&Preset> {
        self.preset.as_ref().and_then(Asked::preset)
    }

    /// True if an option gives this key of clouds.
    fn gives(&self, key: &str) -> bool {
        let short = [("opacity", &self.opacity), ("radius", &self.radius), ("color_by", &self.color_by)];
        let paths = self.set.iter().filter_map(|pair| pair.split_once('=')).map(|(path, _)| path.trim());
        let mut of_clouds = paths.filter_map(|path| path.strip_prefix("cloud.")?.split_once('.'));
        short.iter().any(|(known, value)| *known == key && value.is_some()) || of_clouds.any(|(_, known)| known == key)
    }

    /// The share of light that is to get through: that of the option, else of the preset.
    fn share(&self, scene: &Scene, clouds: &[Cloud]) -> Option<f64> {
        let has_opacity = scene.method.fixed().is_none_or(|method| method.family().has_opacity());
        // LAS files always have a code for each point: 0 and 1 say that nothing was classified.
        let without_classes = clouds.iter().all(|cloud| cloud.classification.iter().flatten().all(|code| *code <= 1));
        let of_preset = self.preset().and_then(|preset| preset.see_through);
        let of_preset = of_preset.filter(|_| has_opacity && !self.gives("opacity"));
        let of_preset = of_preset.filter(|see_through| without_classes || !see_through.without_classes);
        self.see_through.or(of_preset.map(|see_through| see_through.share))
    }

    /// The direction that was asked for by options, else by the preset where the scene's camera stands nowhere.
    pub fn view_of(&self, scene: &Scene) -> View {
        let from_outside = self.preset().is_some_and(|preset| preset.from_outside);
        if from_outside && !self.view().is_given() && scene.camera.eye.is_none() {
            return View { name: Some(ViewName::Iso), ..View::default() };
        }
        self.view()
    }

    /// The direction that was asked for by options.
    pub fn view(&self) -> View {
        View { name: self.view.map(ViewName::from), azimuth: self.azimuth, elevation: self.elevation }
    }
}

/// How clouds are colored and why, a phrase for each way.
fn colorings(scene: &Scene, clouds: &[Cloud]) -> Vec<String> {
    let mut ways: Vec<(String, Vec<&Path>)> = Vec::new();
    for (settings, way) in scene.clouds.iter().zip(scene::colorings(scene, clouds)) {
        match ways.iter_mut().find(|(known, _)| *known == way) {
            Some((_, paths)) => paths.push(&settings.path),
            None => ways.push((way, vec![&settings.path])),
        }
    }
    let phrase = |(way, paths): &(String, Vec<&Path>)| match paths[..] {
        [path] => format!("{} is colored by {way}", path.display()),
        _ => format!("{} clouds are colored by {way}", paths.len()),
    };
    ways.iter().map(phrase).collect()
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
    /// The clouds of the scene, in its order.
    clouds: Vec<Cloud>,
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

    /// The number of clouds.
    pub fn count(&self) -> usize {
        self.clouds.len()
    }

    /// The scene with the first `count` of its clouds alone.
    pub fn first(&self, count: usize) -> Self {
        let (mut scene, mut clouds) = (self.scene.clone(), self.clouds.clone());
        scene.clouds.truncate(count);
        clouds.truncate(count);
        Self { name: self.name.clone(), scene, clouds, ..*self }
    }

    /// Makes points of the clouds, with radii even if the scene's method does without; warnings go to standard error.
    pub fn resolve_with_radii(mut self, console: Console, progress: &Bar) -> Result<Resolved> {
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
        scene::notes(&scene, &clouds, scene.method.needs_radii()).iter().for_each(|note| console.note(note));
        let (shadow_texture, note) = scene::shadow_texture(&scene, &clouds, seed);
        note.iter().for_each(|note| console.note(note));
        let up = scene::up_axis(&clouds);
        let colorings = colorings(&scene, &clouds);
        colorings.iter().for_each(|how| console.detail(how));
        let (arranged, legend) = if legend {
            let (arranged, legend) = scene::arrange_with_legend(&scene, clouds, seed, progress)?;
            (arranged, Some(legend))
        } else {
            (scene::arrange(&scene, clouds, seed, progress)?, None)
        };
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
            opacity_given,
            seed,
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
    let Opened { name, document, clouds, .. } = scene::open(&args.inputs, &overrides, args.seed, progress)?;
    let mut scene = document.scene()?;
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
        return Err(scene::Error::Usage(problem).into());
    }
    for (settings, cloud) in scene.clouds.iter().zip(&clouds) {
        report_cloud(&settings.path, cloud, console);
    }
    let see_through = args.share(&scene, &clouds);
    let opacity_given = args.opacity.is_some() || args.surface_opacity.is_some();
    Ok(Loaded { name, scene, clouds, legend: false, see_through, opacity_given, seed: args.seed })
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

/// A color of the command line as a scene file has it: an array where there are numbers between commas, else a text.
fn color_as_toml(color: &str) -> String {
    let numbers: Option<Vec<f64>> = color.split(',').map(|text| text.trim().parse().ok()).collect();
    // Numbers are formatted anew, because TOML rejects a form like .5.
    numbers.map_or_else(|| format!("{color:?}"), |numbers| format!("{numbers:?}"))
}
