//! The inputs that `render`, `profile` and `plan` share: a scene file, point clouds or nothing, with options over them.

use std::path::PathBuf;

use bytesize::ByteSize;
use clap::Args;
use pellucid_engine::Result;
use pellucid_engine::cloud::Cloud;
#[cfg(feature = "mpi")]
use pellucid_engine::scene::MethodChoice;
#[cfg(feature = "mpi")]
use pellucid_engine::scene::stored::have_levels;
use pellucid_engine::scene::{self, DEFAULT_SCENE, Family, Named, Overrides, Scene, View, ViewName};

use super::filters;
use super::presets::{self, Asked, Preset};
use super::view_args::ViewArgs;

/// The inputs to render, and the options that stand for keys of a scene file.
#[derive(Debug, Args)]
pub struct InputArgs {
    /// A scene file (.toml) or one or more point clouds (PLY, LAS, LAZ, COPC, E57, PCD, PTS, PTX, XYZ, CSV, TXT), or pictures
    /// that stand for clouds. Without any: the built-in scene `garden`.
    #[arg(value_name = "INPUT")]
    pub inputs: Vec<PathBuf>,
    /// A recipe, which stands for keys, and for --see-through and --view in some: canopy, building, indoor, heritage or model;
    /// `list` prints them. It wins over the scene file, and options win over it.
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
    pub opacity: Option<String>,
    /// Opacity of the surface that the points lie on, from 0 to 1: discs become as faint as their overlap asks for. For spbr the
    /// same as --opacity.
    #[arg(long, value_name = "A", allow_hyphen_values = true, conflicts_with_all = ["opacity"])]
    pub surface_opacity: Option<String>,
    /// Finds the opacity for which half of the covered pixels let at least this share of the light behind them through, from 0
    /// to 1, and prints it. Of clouds with opacities of their own all are multiplied by one factor.
    #[arg(long, value_name = "T", value_parser = share, conflicts_with = "opacity")]
    pub see_through: Option<f64>,
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
    /// Leaves out points where others are as near as PX pixels to one another, and has the radii of those grow to cover; by default the
    /// scene file's, else 0, which leaves none out.
    #[arg(long, value_name = "PX", allow_hyphen_values = true)]
    detail: Option<String>,
    /// Draws at most N points of those in the picture, the coarsest levels first, and has their radii grow to cover; by default the
    /// scene file's, else all.
    #[arg(long, value_name = "N", allow_hyphen_values = true)]
    max_points: Option<String>,
    /// Memory of the host for points, as in 4GiB; by default half of what is free. Clouds that would take more stay in their files,
    /// of which a part of the picture reads what shows there: octrees of Potree, EPT, COPC, LAS, LAZ and PLY.
    #[arg(long, value_name = "SIZE")]
    pub host_memory: Option<ByteSize>,
    #[command(flatten)]
    pub view: ViewArgs,
    /// Seed of everything random: of the built-in scene, if it is rendered, and of stochastic methods.
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub seed: u64,
    /// Which clouds stay in their files even if memory has room for them.
    #[arg(skip)]
    pub kept_in_files: KeptInFiles,
}

/// Clouds that stay in their files even if memory has room for them, where the picture is that of points in memory.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum KeptInFiles {
    /// None.
    #[default]
    Nothing,
    /// Octrees, of which each of several processes reads the nodes that its part of the picture shows.
    #[cfg(feature = "mpi")]
    Octrees,
    /// All that are read in parts, since the points go to other processes part by part.
    #[cfg(feature = "mpi")]
    Everything,
}

impl KeptInFiles {
    /// True if the clouds of a scene stay in their files.
    ///
    /// # Errors
    /// A cloud that can't be opened.
    #[cfg_attr(not(feature = "mpi"), allow(unused_variables, reason = "no other processes"))]
    pub fn holds(self, named: &Named, scene: &Scene) -> Result<bool> {
        match self {
            Self::Nothing => Ok(false),
            // `auto` may choose otherwise among points in memory.
            #[cfg(feature = "mpi")]
            Self::Octrees => Ok(matches!(scene.method, MethodChoice::Fixed(_))
                && named.needed_memory()?.is_some()
                && have_levels(scene)?),
            #[cfg(feature = "mpi")]
            Self::Everything => Ok(true),
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

fn share(text: &str) -> Result<f64, String> {
    text.parse().ok().filter(|x: &f64| (0.0..=1.0).contains(x)).ok_or_else(|| "expected a share from 0 to 1".into())
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
            ("detail", "detail.spacing_px", &self.detail),
            ("max-points", "detail.max_points", &self.max_points),
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
        self.view.apply(&mut overrides)?;
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
        let short = [
            ("opacity", &self.opacity),
            ("surface_opacity", &self.surface_opacity),
            ("radius", &self.radius),
            ("color_by", &self.color_by),
        ];
        let paths = self.set.iter().filter_map(|pair| pair.split_once('=')).map(|(path, _)| path.trim());
        let mut of_clouds = paths.filter_map(|path| path.strip_prefix("cloud.")?.split_once('.'));
        short.iter().any(|(known, value)| *known == key && value.is_some()) || of_clouds.any(|(_, known)| known == key)
    }

    /// The share of light that is to get through: that of the option, else of the preset.
    pub fn share(&self, scene: &Scene, clouds: &[Cloud]) -> Option<f64> {
        // LAS files always have a code for each point: 0 and 1 say that nothing was classified.
        let is_classified = |cloud: &Cloud| cloud.classification.iter().flatten().any(|code| *code > 1);
        self.share_of(scene, clouds.iter().any(is_classified))
    }

    /// The same of a scene some points of which are classified, or none.
    pub fn share_of(&self, scene: &Scene, is_classified: bool) -> Option<f64> {
        let has_opacity = scene.method.fixed().is_none_or(|method| method.family().has_opacity());
        let without_classes = !is_classified;
        let of_preset = self.preset().and_then(|preset| preset.see_through);
        let of_preset = of_preset.filter(|_| has_opacity && !self.gives("opacity") && !self.gives("surface_opacity"));
        let of_preset = of_preset.filter(|see_through| without_classes || !see_through.without_classes);
        self.see_through.or(of_preset.map(|see_through| see_through.share))
    }

    /// The direction that was asked for by options, else by the preset where the scene's camera stands nowhere.
    pub fn view_of(&self, scene: &Scene) -> View {
        let from_outside = self.preset().is_some_and(|preset| preset.from_outside);
        let view = self.view.view();
        if from_outside && !view.is_given() && scene.camera.eye.is_none() && scene.camera.target.is_none() {
            return View { name: Some(ViewName::Iso), ..View::default() };
        }
        view
    }
}

/// A color of the command line as a scene file has it: an array where there are numbers between commas, else a text.
fn color_as_toml(color: &str) -> String {
    let finite = |text: &str| text.trim().parse().ok().filter(|x: &f64| x.is_finite());
    let numbers: Option<Vec<f64>> = color.split(',').map(finite).collect();
    // Numbers are formatted anew, because TOML rejects a form like .5.
    numbers.map_or_else(|| format!("{color:?}"), |numbers| format!("{numbers:?}"))
}
