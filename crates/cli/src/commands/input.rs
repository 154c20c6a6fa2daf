//! The inputs that `render`, `profile` and `plan` share: a scene file, point clouds or nothing, with options over them.

use std::path::PathBuf;

use bytesize::ByteSize;
use clap::Args;
use pellucid_core::progress::Phase;
use pellucid_engine::Result;
use pellucid_engine::methods::see_through;
use pellucid_io::output::Inputs;
use pellucid_io::{LEAST_MEMORY, memory_for_points};
use pellucid_scene::{self as scene, DEFAULT_SCENE, Family, Named, Overrides, ViewName};
use pellucid_session::{Limits, Request, Residence, SeeThrough, SeeThroughBy};

use super::bar::Bar;
use super::filters;
use super::headings::{APPEARANCE, DEVICE, METHOD, POINTS};
use super::limit::usage;
use super::options::number;
use super::presets::{self, Asked, Preset};
use super::view_args::ViewArgs;

/// The inputs to render, and the options that stand for keys of a scene file.
#[derive(Debug, Args)]
pub struct InputArgs {
    /// A scene file (.toml), or one or more point clouds; without any the built-in scene `garden`.
    ///
    /// Point clouds are PLY, LAS, LAZ, COPC, E57, PCD, PTS, PTX, XYZ, CSV and TXT files, octrees, and Gaussian splats.
    /// A picture (PNG, JPEG, TIFF) becomes a cloud with a point for each pixel.
    #[arg(value_name = "INPUT")]
    pub inputs: Vec<PathBuf>,
    /// Recipe: canopy, building, indoor, heritage, model or print; `list` prints them.
    ///
    /// A recipe sets keys of the scene file, and some also set --see-through and --view. It overrides the scene file;
    /// other options override the recipe.
    #[arg(long, value_name = "NAME", value_parser = presets::asked)]
    preset: Option<Asked>,
    /// Size of the image in pixels, as in 1024x768.
    ///
    /// Default: the scene file's, else 1024x1024.
    #[arg(long, value_name = "WxH")]
    pub size: Option<String>,
    /// Samples of each pixel's area: 1, 2, 4, 8, 16, 32, 64 or auto.
    ///
    /// The picture is the mean of so many images, each moved by a fraction of a pixel, and takes up to as many times as
    /// long. With auto the number doubles until the picture changes by less than image.sampling_error. Default: the
    /// scene file's, else 1, which shows the center of each pixel.
    #[arg(long, value_name = "N")]
    samples: Option<String>,
    // The help lists all keys.
    #[arg(long, value_name = "KEY=VALUE", help = SET_HELP, long_help = set_help())]
    set: Vec<String>,
    // The help lists all methods.
    #[arg(long, value_name = "NAME", help_heading = METHOD, help = METHOD_HELP, long_help = method_help())]
    method: Option<String>,
    /// Seed of everything random: stochastic methods, and the built-in scene.
    #[arg(long, value_name = "N", default_value_t = 0, help_heading = METHOD)]
    pub seed: u64,
    /// Opacity of every point, from 0 to 1.
    ///
    /// Default: the scene file's, else 1. Alpha values of a file are multiplied by it.
    #[arg(long, value_name = "A", allow_hyphen_values = true, help_heading = APPEARANCE)]
    pub opacity: Option<String>,
    /// Opacity of the surface that the points sample, from 0 to 1.
    ///
    /// The more discs overlap, the fainter each becomes. With spbr the same as --opacity.
    #[arg(long, value_name = "A", allow_hyphen_values = true, conflicts_with_all = ["opacity"], help_heading = APPEARANCE)]
    pub surface_opacity: Option<String>,
    /// Find the opacity that lets this share of light through, from 0 to 1.
    ///
    /// With the opacity found, half of the covered pixels let at least this share of the light behind them through. The
    /// program prints it. If clouds have opacities of their own, one factor multiplies all of them.
    #[arg(long, value_name = "T", value_parser = number(|x| (0.0..=1.0).contains(x), "expected a share from 0 to 1"), conflicts_with = "opacity", help_heading = APPEARANCE)]
    pub see_through: Option<f64>,
    /// Radius of every point in world units.
    ///
    /// Default: the scene file's, else the point file's, else derived from the distance to the 24th nearest neighbor.
    #[arg(long, value_name = "R", allow_hyphen_values = true, help_heading = APPEARANCE)]
    radius: Option<String>,
    /// Source of the colors, as in height, classification or intensity.
    ///
    /// One of auto, rgb, height, intensity, classification, return, source, gps-time, normal, cloud, uniform, field, or
    /// the name of a scalar in the file. Default: the scene file's, else auto, which takes the file's colors, else
    /// classes, else height; `pellucid plan` prints the choice and its reason.
    #[arg(long, value_name = "WHAT", help_heading = APPEARANCE)]
    color_by: Option<String>,
    /// Colormap for values, as in turbo.
    ///
    /// One of viridis, cividis, magma, inferno, plasma, turbo, terrain and gray. Default: the scene file's, else
    /// viridis.
    #[arg(long, value_name = "NAME", help_heading = APPEARANCE)]
    colormap: Option<String>,
    /// Background color, as in white, "#80c0ff" or 0.1,0.1,0.1.
    ///
    /// A CSS color, linear R,G,B with each from 0 to 1, or auto: black, or white where the points are dark. Default:
    /// the scene file's, which is black if it gives none; without a scene file auto.
    #[arg(long, value_name = "COLOR", allow_hyphen_values = true, help_heading = APPEARANCE)]
    background: Option<String>,
    /// Opacity of one class, as in high-vegetation=0.05 or 5=0.05; repeatable.
    #[arg(long, value_name = "NAME=OPACITY", help_heading = POINTS)]
    class: Vec<String>,
    /// Draw only these classes, as in 2,6 or ground,building.
    #[arg(long, value_name = "LIST", help_heading = POINTS)]
    classes: Option<String>,
    /// Draw all classes except these, as in 7,18.
    #[arg(long, value_name = "LIST", help_heading = POINTS)]
    without: Option<String>,
    /// Draw only points between two planes, as in z=2..4; repeatable.
    ///
    /// The planes are perpendicular to the axis x, y or z. One end may be open, as in z=2.. or z=..4.
    #[arg(long, value_name = "AXIS=FROM..TO", help_heading = POINTS)]
    slice: Vec<String>,
    /// Thin out points that are closer than PX pixels to each other.
    ///
    /// The radii of the remaining points grow to cover the gaps. Default: the scene file's, else 0, which keeps all
    /// points.
    #[arg(long, value_name = "PX", allow_hyphen_values = true, help_heading = POINTS)]
    detail: Option<String>,
    /// Draw at most N of the points in view, coarsest levels first.
    ///
    /// The radii of these points grow to cover the gaps. Default: the scene file's, else all points.
    #[arg(long, value_name = "N", allow_hyphen_values = true, help_heading = POINTS)]
    max_points: Option<String>,
    /// Columns of a text file, as in x,y,z,-,r,g,b.
    ///
    /// For PTS, PTX, XYZ, CSV and TXT. Other names: a (alpha), i (intensity), nx, ny, nz, radius, class; `-` skips a
    /// column, and any other word names a scalar. Default: the scene file's, else the header line of the file, else a
    /// guess from the number and the values of the columns.
    #[arg(long, value_name = "LIST", allow_hyphen_values = true, help_heading = POINTS)]
    columns: Option<String>,
    #[command(flatten)]
    pub view: ViewArgs,
    /// Main memory for points, as in 4GiB.
    ///
    /// Default: half of the free memory. Larger clouds stay on disk, and each part of the picture reads only the points
    /// that it shows. That works for octrees (Potree, EPT, COPC), LAS, LAZ and PLY.
    #[arg(long, value_name = "SIZE", help_heading = DEVICE)]
    pub host_memory: Option<ByteSize>,
    /// Rule by which clouds stay in their files even if memory has room for them.
    #[arg(skip)]
    pub residence: Residence,
}

const METHOD_HELP: &str = "Rendering method, as in abuffer; by default an exact one";

/// Describes the option, and lists every method, family by family.
fn method_help() -> String {
    let family = |family: Family| {
        let names: Vec<_> = family.methods().map(|method| method.name()).collect();
        format!("- {}: {}", family.title(), names.join(", "))
    };
    let families: Vec<_> = Family::ALL.into_iter().map(family).collect();
    format!(
        "Rendering method, as in abuffer.\n\n{}\n\nDefault: the scene file's, else auto: an exact method for the \
         scene. `pellucid plan` prints the choice and its reason.",
        families.join("\n")
    )
}

const SET_HELP: &str = "Set any key of the scene file, as in method.shape=oriented; repeatable";

/// Describes the option, and lists every key, table by table.
fn set_help() -> String {
    let names = |path: &str, keys: &mut dyn Iterator<Item = &'static str>| {
        let keys: Vec<_> = keys.collect();
        format!("- {path}: {}", keys.join(", "))
    };
    let tables = scene::tables();
    let tables = tables.iter().map(|table| names(table.path, &mut table.keys.iter().map(|key| key.name)));
    let method = names("method", &mut std::iter::once("name").chain(scene::all_method_keys()));
    let lines: Vec<_> = tables.chain([method]).collect();
    format!(
        "{SET_HELP}.\n\nA key is its dotted path, as in cloud.0.opacity=0.2 or, for all clouds, cloud.*.neighbors=12. The value is \
         TOML, else a string. --set overrides the scene file and all other options. docs/scene-file.md describes the keys:\n{}",
        lines.join("\n")
    )
}

impl InputArgs {
    /// The file or pattern that pictures of these inputs are written to if no other is named: after the first input,
    /// here. If that is the name of a file that is read, `.render` stands in it too.
    pub fn default_output(&self, end: &str) -> PathBuf {
        let stem = self.inputs.first().and_then(|input| input.file_stem()).unwrap_or(DEFAULT_SCENE.as_ref());
        let named = |middle: &str| {
            let mut name = stem.to_owned();
            name.push(middle);
            name.push(end);
            name
        };
        let name = named("");
        let is_taken = self.files().iter().any(|file| file.file_name().is_some_and(|n| n.eq_ignore_ascii_case(&name)));
        if is_taken { named(".render").into() } else { name.into() }
    }

    /// The inputs, the picture of --like, and the files that a scene file among them names. A scene that can't be read
    /// names none, which is said by whoever reads it in the end.
    fn files(&self) -> Vec<PathBuf> {
        let mut files: Vec<_> = self.inputs.iter().chain(&self.view.like).cloned().collect();
        // Of the built-in scene only options name files.
        if !self.inputs.is_empty() || !self.set.is_empty() {
            let named = self.overrides(None).ok().and_then(|all| scene::name(&self.inputs, &all, self.seed).ok());
            files.extend(named.into_iter().flat_map(|named| named.document.named_files()));
        }
        files
    }

    /// The files that are read.
    pub fn reads(&self) -> Inputs {
        Inputs::default().with(self.files())
    }

    /// The options as keys of the scene file; `size` counts where `--size` is not given.
    pub fn overrides(&self, size: Option<[u32; 2]>) -> Result<Overrides> {
        let mut overrides = Overrides::default();
        if let Some(preset) = self.preset() {
            // First, so that all other options win.
            preset.apply(&mut overrides, |key| self.gives(key))?;
        }
        self.view.apply_like(&mut overrides)?;
        if let (None, Some([width, height])) = (&self.size, size) {
            overrides.set("--path", "image.size", &format!("[{width}, {height}]"))?;
        }
        if let Some(size) = &self.size {
            let option = format!("--size {size}");
            let Some((width, height)) = size.split_once(['x', 'X', '×']) else {
                return Err(usage(format!("{option}: expected WxH, as in 1024x768")));
            };
            overrides.set(option, "image.size", &format!("[{width}, {height}]"))?;
        }
        // Texts, of which a name may look like a number.
        let quoted = |text: &Option<String>| text.as_ref().map(|text| format!("{text:?}"));
        for (option, key, value, toml) in [
            ("samples", "image.samples", &self.samples, None),
            ("columns", "cloud.*.columns", &self.columns, quoted(&self.columns)),
            ("background", "image.background", &self.background, self.background.as_deref().map(color_as_toml)),
            ("color-by", "cloud.*.color_by", &self.color_by, quoted(&self.color_by)),
            ("method", "method.name", &self.method, None),
            ("opacity", "cloud.*.opacity", &self.opacity, None),
            ("surface-opacity", "cloud.*.surface_opacity", &self.surface_opacity, None),
            ("radius", "cloud.*.radius", &self.radius, None),
            ("colormap", "cloud.*.colormap", &self.colormap, None),
            ("detail", "detail.spacing_px", &self.detail, None),
            ("max-points", "detail.max_points", &self.max_points, None),
        ] {
            if let Some(value) = value {
                overrides.set(format!("--{option} {value}"), key, toml.as_deref().unwrap_or(value))?;
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
        if let Some(Asked::Of(preset)) = &self.preset { Some(preset) } else { None }
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

    /// Returns the request for frames of these inputs; see [`Self::named`].
    pub fn request(&self, size: Option<[u32; 2]>, progress: &Bar) -> Result<Request> {
        Ok(self.named(size, progress)?.1)
    }

    /// Returns the scene of these inputs, and the request for frames of it; `size` counts where `--size` is not given.
    /// Begins the phase of reading.
    pub fn named(&self, size: Option<[u32; 2]>, progress: &Bar) -> Result<(Named, Request)> {
        let overrides = self.overrides(size)?;
        let limits = Limits { memory: host_memory(self.host_memory)?, residence: self.residence };
        let (see_through, mut view) = (self.share(), self.view.view());
        progress.begin(Phase::Read);
        let named = scene::name(&self.inputs, &overrides, self.seed)?;
        let mut request = Request::new(&named, limits, self.seed)?;
        self.preset().iter().for_each(|preset| progress.console.note(preset.note()));
        if let (Some(share), Some(reason)) = (self.see_through, see_through::refusal(request.scene.method)) {
            return Err(usage(format!("--see-through {share}: {reason} (--help lists them)")));
        }
        let camera = &mut request.scene.camera;
        let is_free = !view.is_given() && camera.eye.is_none() && camera.target.is_none();
        if is_free && self.preset().is_some_and(|preset| preset.from_outside) {
            view.name = Some(ViewName::Iso);
        }
        camera.view = view;
        request.see_through = see_through;
        request.opacity_given = self.opacity.is_some() || self.surface_opacity.is_some();
        // `auto` leaves the choice open.
        request.choice.only = self.method.clone().filter(|name| name != "auto");
        Ok((named, request))
    }

    /// Returns the share of light that is to get through: that of the option, else of the preset.
    fn share(&self) -> Option<SeeThrough> {
        let of_option = self.see_through.map(|share| SeeThrough { share, by: SeeThroughBy::Option });
        let gives_opacity = self.gives("opacity") || self.gives("surface_opacity");
        of_option.or_else(|| self.preset()?.see_through.filter(|_| !gives_opacity))
    }
}

/// The memory to use: as asked for, else half of what is free.
pub fn host_memory(asked: Option<ByteSize>) -> Result<u64> {
    match asked.map(|size| size.as_u64()) {
        Some(bytes) if bytes < LEAST_MEMORY => {
            Err(usage(format!("--host-memory {}: at least 1 MiB is needed", ByteSize(bytes))))
        }
        Some(bytes) => Ok(bytes),
        None => Ok(memory_for_points()),
    }
}

/// A color of the command line as a scene file has it: an array where there are numbers between commas, else a text.
fn color_as_toml(color: &str) -> String {
    let finite = |text: &str| text.trim().parse().ok().filter(|x: &f64| x.is_finite());
    let numbers: Option<Vec<f64>> = color.split(',').map(finite).collect();
    // Numbers are formatted anew, because TOML rejects a form like .5.
    numbers.map_or_else(|| format!("{color:?}"), |numbers| format!("{numbers:?}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_part_of_the_memory_is_used() {
        assert_eq!(host_memory(Some(ByteSize::mib(64))).unwrap(), 64 << 20);
        assert!(host_memory(Some(ByteSize::kib(64))).is_err());
        assert!(host_memory(None).unwrap() >= LEAST_MEMORY);
    }
}
