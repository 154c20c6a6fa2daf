//! `pellucid prepare`.

use pellucid_session::{describe_cloud, shadow_holes};
use std::path::{Path, PathBuf};

use super::bar::Bar;
use bytesize::ByteSize;
use clap::{ArgGroup, Args};
use pellucid_core::cloud::gaussians::Gaussians;
use pellucid_core::cloud::shadow_texture::ShadowTexture;
use pellucid_core::cloud::{Cloud, Prepared};
use pellucid_engine::Result;
use pellucid_engine::methods::{Frame, Renderer};
use pellucid_gpu::Device;
use pellucid_io as io;
use pellucid_io::output::{self, Inputs, Output};
use pellucid_io::store::OCTREE_FILES;
use pellucid_scene::prepare;
use pellucid_scene::{self as scene, CloudSettings, Overrides, Scene};

use super::console::Console;
use super::limit::usage;
use super::options::DeviceArgs;
use super::prepare_store;
use super::touched::{Touched, Touches};

/// The soft methods (soft-base, soft-concentric, soft-express, one-layer) tell solid points from soft ones by a field F
/// in [0, 1]. This computes it and the radii once and writes them with the cloud; render, plan and all others then use
/// what is stored, with the same bytes as result, as long as the points are the same (a hash tells) and the settings,
/// if they name a field or a number of neighbors at all, name these. Takes about 4·K + 170 bytes of memory for each
/// point.
///
/// An OUT that ends in `/`, has no extension or is a folder becomes a store: an octree of Potree 2.0, which its viewer
/// opens. It may be made of several clouds and be of any size: memory stays within --host-memory, and a run that was
/// cut short goes on where it was.
///
/// With --light or --light-position it also finds, on the device, which share of the light reaches each point, and
/// stores it. A scene of this one cloud with [shadows] of the same settings then casts none anew.
///
/// Gaussian splats of any format become a PLY file of them as other programs read it, or a store with every number as
/// it was. Nothing is computed of them.
#[derive(Debug, Args)]
#[command(group(ArgGroup::new("any_light").args(["light", "light_position"])))]
pub struct PrepareArgs {
    /// Point cloud in any supported format; several for an octree.
    #[arg(value_name = "IN", required = true)]
    inputs: Vec<PathBuf>,
    /// Output: a PLY file, or a folder for an octree.
    ///
    /// A binary PLY (.ply) holds all columns of the cloud, `radius` and `field`. It must not be the input. A name
    /// without an extension, or one that ends in /, is the folder of a store, an octree of Potree 2.0 for clouds larger
    /// than memory. docs/prepared-clouds.md describes both.
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
    /// Main memory to use for a store, as in 4GiB; by default half of the free memory.
    #[arg(long, value_name = "SIZE")]
    host_memory: Option<ByteSize>,
    /// Largest number of points in a node of a store; by default 20000.
    #[arg(long, value_name = "N")]
    node_points: Option<u32>,
    /// Columns of a text file, as in x,y,z,-,r,g,b; `pellucid render --help` lists the names.
    #[arg(long, value_name = "LIST", allow_hyphen_values = true)]
    columns: Option<String>,
    /// Number of neighbors that determine the radius and the uncertainty of a point.
    ///
    /// Default: that of a prepared input, else 24.
    #[arg(long, value_name = "K")]
    neighbors: Option<String>,
    /// Largest radius of a point, as a multiple of the median radius around it.
    ///
    /// It keeps isolated points small. 0 means no limit. Default: that of a prepared input, else 4.
    #[arg(long, value_name = "C")]
    radius_cap: Option<String>,
    /// Field of soft transparency, as in classification.
    ///
    /// One of uncertainty (how little the neighborhood resembles a surface), classification, intensity,
    /// distance-to-axis, or the name of a scalar in the file. Default: that of a prepared input, else uncertainty.
    #[arg(long, value_name = "NAME")]
    field: Option<String>,
    /// With --field classification: soft classes, as in 3,4,5.
    #[arg(long, value_name = "LIST")]
    soft_classes: Option<String>,
    /// With --field distance-to-axis: a point on the axis; by default the center of the bounds.
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    axis_point: Option<String>,
    /// With --field distance-to-axis: direction of the axis; by default the vertical of the automatic camera.
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    axis_direction: Option<String>,
    /// Store normals, estimated from the neighbors where the file has none.
    ///
    /// They change the picture: solid points are then oriented and shaded. Otherwise estimated normals are only used
    /// for the field.
    #[arg(long)]
    normals: bool,
    /// Store the shadows of a light that shines in this direction.
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    light: Option<String>,
    /// Store the shadows of a light at this position.
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    light_position: Option<String>,
    /// Number of lights that sample an area light; by default 1.
    #[arg(long, value_name = "M", requires = "any_light")]
    shadow_samples: Option<String>,
    /// Radius of the area light; by default 0, hard shadows.
    ///
    /// Degrees around a direction, world units around a position.
    #[arg(long, value_name = "R", requires = "any_light")]
    light_radius: Option<String>,
    /// Side of the shadow map in pixels; by default auto.
    ///
    /// auto gives each lit pixel about one point of the nearest surface, with 64 to 4096 pixels.
    #[arg(long, value_name = "N", requires = "any_light")]
    shadow_resolution: Option<String>,
    /// Iterations that fill background between points of the shadow map, or auto; by default 1.
    #[arg(long, value_name = "N", requires = "any_light")]
    shadow_fill: Option<String>,
    /// Iterations that replace points seen through holes of the shadow map, or auto; by default 1.
    #[arg(long, value_name = "N", requires = "any_light")]
    shadow_occlusion: Option<String>,
    /// Smallest distance between surfaces in world units; by default 1% of the diagonal of the bounds.
    #[arg(long, value_name = "D", requires = "any_light")]
    min_layer_distance: Option<String>,
    /// Seed of the positions of the lights; by default 0.
    #[arg(long, value_name = "N", requires = "any_light")]
    seed: Option<u64>,
    #[command(flatten)]
    device: DeviceArgs,
}

impl PrepareArgs {
    /// The options as keys of a scene of these clouds, so that they are checked as those are.
    fn overrides(&self) -> Result<Overrides> {
        let mut overrides = Overrides::default();
        // A method that reads all the keys.
        overrides.set("prepare", "method.name", "soft-base")?;
        let columns = self.columns.as_ref().map(|names| format!("{names:?}"));
        for (option, key, value) in [("columns", "columns", columns)].into_iter().chain(self.values()) {
            for cloud in 0..self.inputs.len() {
                if let Some(value) = &value {
                    overrides.set(format!("--{option}"), &format!("cloud.{cloud}.{key}"), value)?;
                }
            }
        }
        Ok(overrides)
    }

    /// The options that say how values of points are computed, each with its key and its value as TOML.
    fn values(&self) -> [(&'static str, &'static str, Option<String>); 6] {
        let list = |text: &Option<String>| text.as_ref().map(|text| format!("[{text}]"));
        [
            ("neighbors", "neighbors", self.neighbors.clone()),
            ("radius-cap", "radius_cap", self.radius_cap.clone()),
            ("field", "field", self.field.as_ref().map(|name| format!("{name:?}"))),
            ("soft-classes", "soft_classes", list(&self.soft_classes)),
            ("axis-point", "axis.point", list(&self.axis_point)),
            ("axis-direction", "axis.direction", list(&self.axis_direction)),
        ]
    }

    /// True if options ask for values of points to be computed, or say how.
    fn asks_for_values(&self) -> bool {
        self.normals || self.values().iter().any(|(.., value)| value.is_some())
    }

    /// The options of the light as keys of a scene with shadows; `None` without a light.
    fn light(&self) -> Result<Option<Overrides>> {
        let list = |text: &str| format!("[{text}]");
        let light = match (&self.light, &self.light_position) {
            (Some(direction), _) => ("light", "shading.light", Some(list(direction))),
            (None, Some(position)) => ("light-position", "shading.light.position", Some(list(position))),
            (None, None) => return Ok(None),
        };
        let mut overrides = Overrides::default();
        // A method that supports shadows.
        overrides.set("prepare", "method.name", "points")?;
        overrides.set("prepare", "shading.model", "lambert")?;
        overrides.set("prepare", "shadows.method", "texture")?;
        for (option, key, value) in [
            light,
            ("shadow-samples", "shadows.samples", self.shadow_samples.clone()),
            ("light-radius", "shadows.light_radius", self.light_radius.clone()),
            ("shadow-resolution", "shadows.resolution", self.shadow_resolution.clone()),
            ("shadow-fill", "shadows.fill", self.shadow_fill.clone()),
            ("shadow-occlusion", "shadows.occlusion", self.shadow_occlusion.clone()),
            ("min-layer-distance", "shadows.min_layer_distance", self.min_layer_distance.clone()),
        ] {
            if let Some(value) = value {
                overrides.set(format!("--{option}"), key, &value)?;
            }
        }
        Ok(Some(overrides))
    }

    /// Finds the light of each point of a cloud, as a scene of it alone has it.
    fn shadows(&self, scene: &Scene, cloud: &Cloud, progress: &Bar) -> Result<ShadowTexture> {
        progress.stage("casting shadows");
        let points = scene::assemble(scene, vec![cloud.clone()], false, progress)?;
        let (camera, _) = scene::camera(scene, &points, cloud.up)?;
        let device = Device::open(&self.device.options())?;
        let frame = Frame {
            shading: scene.shading,
            shadows: scene.shadows,
            color: scene.image.color_space(),
            memory_budget: self.device.budget(),
            seed: self.seed.unwrap_or(0),
            ..Frame::new(camera, scene.image.size, scene.method.representative())
        };
        let mut renderer = Renderer::new(&device)?;
        let mut uploaded = renderer.upload(&points)?;
        let casting = renderer.cast(&mut uploaded, &frame)?;
        shadow_holes(&uploaded, &frame).iter().for_each(|warning| progress.console.warn(warning));
        let (found, mut lit) = (uploaded.lit()?, vec![1.0; cloud.len()]);
        for (m, place) in found.into_iter().zip(&points.file_order) {
            if let Some(at) = lit.get_mut(*place as usize) {
                *at = m;
            }
        }
        device.check_validation()?;
        let casting = casting.ok_or_else(|| usage("this light casts no shadows".to_owned()))?;
        Ok(ShadowTexture { casting, lit })
    }
}

impl Touches for PrepareArgs {
    fn touched(&self) -> Result<Touched> {
        let written = if prepare_store::is_store(&self.output) {
            Output::folder("-o", &self.output, &OCTREE_FILES)
        } else {
            Output::file("-o", &self.output)
        };
        Ok(Touched::reads(Inputs::default().with(&self.inputs)).and([written]))
    }
}

pub fn run(args: PrepareArgs, console: Console) -> Result<()> {
    let has = |path: &Path, extension: &str| path.extension().is_some_and(|e| e.eq_ignore_ascii_case(extension));
    if let Some(scene) = args.inputs.iter().find(|input| has(input, "toml")) {
        return Err(usage(format!("{}: prepare takes a point cloud, not a scene file", scene.display())));
    }
    if prepare_store::is_store(&args.output) {
        return run_store(&args, console);
    }
    if !has(&args.output, "ply") {
        return Err(usage(format!(
            "{}: prepared clouds are PLY files or folders; the name must end in .ply, in / or in no extension",
            args.output.display()
        )));
    }
    let [input] = args.inputs.as_slice() else {
        return Err(usage(format!(
            "{}: a PLY file holds one prepared cloud, not {}; name a folder to write several as a store",
            args.output.display(),
            args.inputs.len()
        )));
    };
    if args.host_memory.is_some() || args.node_points.is_some() {
        return Err(usage(format!("{}: --host-memory and --node-points are for stores", args.output.display())));
    }
    run_ply(&args, input, console)
}

/// Writes a store.
fn run_store(args: &PrepareArgs, console: Console) -> Result<()> {
    if args.light.is_some() || args.light_position.is_some() {
        return Err(usage(format!(
            "{}: shadows can only be stored in a PLY file; name an output that ends in .ply",
            args.output.display()
        )));
    }
    let settings = prepare_store::settings(args.host_memory, args.node_points)?;
    let scene = Scene::from_clouds(&args.inputs, &args.overrides()?)?;
    scene.warnings.iter().for_each(|warning| console.warn(warning));
    prepare_store::run(&args.inputs, &args.output, &scene, args.normals, &settings, args.asks_for_values(), console)
}

/// Writes a PLY file.
fn run_ply(args: &PrepareArgs, input: &PathBuf, console: Console) -> Result<()> {
    output::check_folder(&args.output)?;
    let scene = Scene::from_clouds([input], &args.overrides()?)?;
    let light = args.light()?.map(|overrides| Scene::from_clouds([input], &overrides)).transpose()?;
    scene.warnings.iter().for_each(|warning| console.warn(warning));
    let progress = console.progress();
    progress.set_message(format!("reading {}", input.display()));
    let settings = scene.clouds.into_iter().next();
    let hints = settings.as_ref().map(CloudSettings::hints).unwrap_or_default();
    let cloud = io::load_with(input, hints, &progress)?;
    describe_cloud(input, &cloud, &progress);
    if cloud.gaussians.is_some() {
        progress.stage("writing");
        write_splats(args, input, &cloud, console)?;
        progress.finish_and_clear();
        return Ok(());
    }
    let request = prepare_store::request(settings.as_ref(), args.normals);
    progress.reset();
    progress.set_message("finding neighbors");
    let prepared = prepare::prepared(cloud, &request, &progress);
    let mut prepared = prepared.map_err(|source| scene::Error::Field { path: input.clone(), source })?;
    if let Some(light) = light {
        let texture = args.shadows(&light, &prepared, &progress)?;
        prepared.prepared = prepared.prepared.map(|prepared| Prepared { shadows: Some(texture), ..prepared });
    }
    progress.stage("writing");
    io::ply::write_prepared(&args.output, &prepared)?;
    progress.finish_and_clear();
    console.detail(format_args!("{}: written", args.output.display()));
    Ok(())
}

/// Writes Gaussian splats, which have nothing to be prepared.
fn write_splats(args: &PrepareArgs, input: &Path, cloud: &Cloud, console: Console) -> Result<()> {
    let shown = input.display();
    if args.light.is_some() || args.light_position.is_some() {
        return Err(usage(format!("{shown}: Gaussian splats can't store shadows; leave out the light")));
    }
    if args.asks_for_values() {
        console.warn(prepare_store::prepare_without(input));
    }
    if cloud.gaussians.as_ref().is_some_and(Gaussians::may_be_linear) {
        console.warn(format_args!(
            "{}: colors stay linear, as a property of the file says; other programs take them for display values",
            args.output.display()
        ));
    }
    io::ply::write(&args.output, cloud)?;
    console.detail(format_args!("{}: written", args.output.display()));
    Ok(())
}
