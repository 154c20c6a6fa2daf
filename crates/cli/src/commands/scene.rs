//! `pellucid scene`.

use std::io::Write;
use std::path::{Path, PathBuf};

use bytesize::ByteSize;
use clap::Args;
use pellucid_engine::Result;
use pellucid_io as io;
use pellucid_io::output::{self, Inputs, Output};
use pellucid_io::volume::{Dims, Scalar};
use pellucid_scene as scene;
use pellucid_scene::procedural::{self, BUILTINS, Generated, iso, terrain};

use super::console::Console;
use super::limit::usage;
use super::prepare_store;
use super::touched::{Touched, Touches};

#[derive(Debug, Args)]
pub struct SceneArgs {
    /// Name of the scene; --list prints all names.
    #[arg(required_unless_present = "list")]
    name: Option<String>,
    /// List the scenes and their parameters with default and range.
    #[arg(long)]
    list: bool,
    /// Folder for scene.toml and its clouds; created if missing.
    #[arg(short, long, value_name = "DIR", required_unless_present = "list")]
    output: Option<PathBuf>,
    /// Set a parameter of the scene, as in points=400000; repeatable.
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Seed of everything random in the scene.
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    #[command(flatten)]
    volume: VolumeArgs,
    #[command(flatten)]
    store: StoreArgs,
}

/// Options for writing a landscape.
#[derive(Debug, Args)]
#[command(next_help_heading = "Landscapes of any size (terrain)")]
struct StoreArgs {
    /// Write a store, an octree of Potree 2.0, instead of a PLY file.
    ///
    /// Scenes of more than 10000000 points are always written as a store. An interrupted run continues where it
    /// stopped.
    #[arg(long)]
    store: bool,
    /// Main memory to use for the store, as in 4GiB; by default half of the free memory.
    ///
    /// It seldom takes more than 1 GiB.
    #[arg(long, value_name = "SIZE")]
    host_memory: Option<ByteSize>,
}

impl StoreArgs {
    /// The landscape, if it is asked for and becomes a store.
    fn terrain(&self, name: &str, parameters: &[(String, f64)], seed: u64) -> Result<Option<terrain::Terrain>> {
        if name != terrain::NAME {
            if self.store || self.host_memory.is_some() {
                return Err(usage(format!(
                    "--store and --host-memory belong to the scene {}, not to {name}",
                    terrain::NAME
                )));
            }
            return Ok(None);
        }
        let points = terrain::points(parameters).map_err(scene::Error::from)?;
        if !self.store && points <= terrain::FILE_POINTS {
            if self.host_memory.is_some() {
                return Err(usage("--host-memory is for stores; give --store too".to_owned()));
            }
            return Ok(None);
        }
        Ok(Some(terrain::Terrain::new(points, seed).map_err(scene::Error::from)?))
    }
}

/// The source of the surfaces of `iso`.
#[derive(Debug, Args)]
#[command(next_help_heading = "Surfaces of a volume (iso)")]
struct VolumeArgs {
    /// Volume: a raw file, as in hydrogen_64x64x64_float32.raw.
    ///
    /// It has little-endian numbers without a header, x fastest. The name gives size and type, or else --dims and
    /// --type do. Default: a hydrogen orbital, the density of the electron in the state 3d (m = 0) relative to its
    /// maximum.
    #[arg(long, value_name = "FILE")]
    volume: Option<PathBuf>,
    /// Size of the volume along x, y and z; overrides the file's name.
    #[arg(long, value_name = "XxYxZ", requires = "volume")]
    dims: Option<Dims>,
    /// Type of its values; overrides the file's name.
    ///
    /// One of uint8, int8, uint16, int16, uint32, int32, float32 and float64.
    #[arg(long = "type", value_name = "NAME", requires = "volume")]
    scalar: Option<Scalar>,
    /// Values of the surfaces; by default several that enclose a tenth to a hundredth of the volume.
    #[arg(long, value_name = "V1,V2,…", value_delimiter = ',', allow_hyphen_values = true, value_parser = finite)]
    values: Vec<f64>,
}

impl VolumeArgs {
    /// The surfaces, if they are what is asked for.
    fn build(&self, name: &str, parameters: &[(String, f64)], seed: u64) -> Result<Option<Generated>> {
        if name != iso::NAME {
            if self.volume.is_none() && self.values.is_empty() {
                return Ok(None);
            }
            return Err(usage(format!("--volume and --values belong to the scene {}, not to {name}", iso::NAME)));
        }
        let volume = match &self.volume {
            Some(path) => io::volume::read(path, self.dims, self.scalar)?,
            None => iso::built_in(),
        };
        Ok(Some(iso::build_iso(&volume, &self.values, parameters, seed).map_err(scene::Error::from)?))
    }
}

impl Touches for SceneArgs {
    fn touched(&self) -> Result<Touched> {
        let inputs = Inputs::default().with(self.volume.volume.as_ref());
        let written = self.output.as_ref().map(|folder| Output::folder("-o", folder, &["scene.toml", ".ply"]));
        Ok(Touched::reads(inputs).and(written))
    }
}

pub fn run(args: SceneArgs, console: Console) -> Result<()> {
    if args.list {
        return console.print(&list());
    }
    if let (Some(name), Some(folder)) = (&args.name, &args.output) {
        let parameters = args.set.iter().map(|pair| parameter(pair)).collect::<Result<Vec<_>, _>>()?;
        let volume = args.volume.build(name, &parameters, args.seed)?;
        if let Some(terrain) = args.store.terrain(name, &parameters, args.seed)? {
            write_store(folder, &terrain, args.store.host_memory, console)?;
        } else {
            let build = || procedural::build(name, &parameters, args.seed).map_err(scene::Error::from);
            write(folder, &volume.map_or_else(build, Ok)?)?;
        }
        console.detail(format_args!("{}: written", folder.join("scene.toml").display()));
    }
    Ok(())
}

fn finite(text: &str) -> Result<f64, String> {
    text.trim().parse().ok().filter(|value: &f64| value.is_finite()).ok_or_else(|| "expected a number".into())
}

fn list() -> String {
    let line = |(name, summary, parameters): (&str, &str, &[procedural::Parameter])| {
        let parameter =
            |p: &procedural::Parameter| format!("{}={} ({} to {}: {})", p.name, p.default, p.min, p.max, p.summary);
        let parameters: Vec<_> = parameters.iter().map(parameter).collect();
        format!("{name:<10} {summary}; {}\n", parameters.join(", "))
    };
    let builtins = BUILTINS.iter().map(|builtin| (builtin.name, builtin.summary, builtin.parameters));
    builtins.chain([(iso::NAME, iso::SUMMARY, iso::PARAMETERS.as_slice())]).map(line).collect()
}

fn parameter(pair: &str) -> Result<(String, f64), scene::Error> {
    let problem = || scene::Error::Usage(format!("--set {pair}: expected KEY=NUMBER, as in points=400000"));
    let (key, value) = pair.split_once('=').ok_or_else(problem)?;
    let value = value.trim().parse().ok().filter(|value: &f64| value.is_finite()).ok_or_else(problem)?;
    Ok((key.trim().to_owned(), value))
}

/// Writes a landscape as a store, and the scene file when that is complete.
fn write_store(
    folder: &Path,
    terrain: &terrain::Terrain,
    host_memory: Option<ByteSize>,
    console: Console,
) -> Result<()> {
    let settings = prepare_store::settings(host_memory, None)?;
    output::check_report_folder(folder)?;
    let _new = output::make_folder(folder)?;
    let progress = console.progress();
    let store = folder.join(terrain::NAME);
    let built = terrain.write(&store, &settings, &progress)?;
    progress.finish_and_clear();
    console.detail(format_args!("{}: written, {} points", store.display(), built.points));
    let mut files = output::Files::default();
    let text = terrain.scene_toml(terrain::NAME);
    files.add(&folder.join("scene.toml"), |out| out.write_all(text.as_bytes()))?;
    Ok(files.publish()?)
}

/// Writes clouds and scene file. None has its name before all are complete, the scene file last.
fn write(folder: &Path, generated: &Generated) -> Result<()> {
    output::check_report_folder(folder)?;
    let _new = output::make_folder(folder)?;
    let mut files = output::Files::default();
    for (name, cloud) in &generated.clouds {
        let mut file = PathBuf::from(name);
        if file.extension().is_none() {
            file.set_extension("ply");
        }
        files.add(&folder.join(&file), |out| io::ply::write_to(out, cloud))?;
    }
    files.add(&folder.join("scene.toml"), |out| out.write_all(generated.scene_toml.as_bytes()))?;
    Ok(files.publish()?)
}
