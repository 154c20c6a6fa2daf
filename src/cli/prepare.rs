//! `pellucid prepare`.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Args;
use pellucid::scene::{self, CloudSettings, Overrides, Scene};
use pellucid::{Result, io, output, prepare};

use super::input::report_cloud;
use super::limit::usage;
use super::talk::{Talk, stage};

/// The soft methods (soft-base, soft-concentric, soft-express, one-layer) tell solid points from soft ones by a field F in
/// [0, 1]. This computes it and the radii once and writes them with the cloud; render, plan and all others then use what
/// is stored, with the same bytes as result, as long as the points are the same (a hash tells) and the settings, if they
/// name a field or a number of neighbors at all, name these. Takes about 4·K + 170 bytes of memory for each point.
#[derive(Debug, Args)]
pub struct PrepareArgs {
    /// A point cloud in any format that is read.
    #[arg(value_name = "IN")]
    input: PathBuf,
    /// The file to write, a binary PLY (.ply) with every column of the cloud, `radius` and `field`; docs/prepared-clouds.md
    /// describes it. May be the input.
    #[arg(short, long, value_name = "OUT.ply")]
    output: PathBuf,
    /// What the columns of a text file (PTS, PTX, XYZ, CSV, TXT) are, as in x,y,z,-,r,g,b; `render --help` has the names.
    #[arg(long, value_name = "LIST", allow_hyphen_values = true)]
    columns: Option<String>,
    /// K: neighbors of a point that decide its radius and its uncertainty; by default those of a prepared input, else 24.
    #[arg(long, value_name = "K")]
    neighbors: Option<String>,
    /// What F is: uncertainty (how unlike a surface the neighborhood is), classification, intensity, distance-to-axis, or the
    /// name of a scalar property; by default that of a prepared input, else uncertainty.
    #[arg(long, value_name = "NAME")]
    field: Option<String>,
    /// With --field classification: the classes that are soft, as in 3,4,5.
    #[arg(long, value_name = "LIST")]
    soft_classes: Option<String>,
    /// With --field distance-to-axis: a point of the axis; by default the centre of the bounds.
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    axis_point: Option<String>,
    /// With --field distance-to-axis: the direction of the axis; by default the vertical (Y for PLY, Z for all other point clouds).
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    axis_direction: Option<String>,
    /// Where a point has no normal, store the one estimated from its neighbors. Then solid points become oriented and
    /// shaded: the picture is another one. Without this, estimated normals serve the field only.
    #[arg(long)]
    normals: bool,
}

impl PrepareArgs {
    /// The options as keys of a scene of this one cloud, so that they are checked as those are.
    fn overrides(&self) -> Result<Overrides> {
        let mut overrides = Overrides::default();
        // A method that reads all the keys.
        overrides.set("prepare", "method.name", "soft-base")?;
        let list = |text: &String| format!("[{text}]");
        let options = [
            ("columns", "columns", self.columns.as_ref().map(|names| format!("{names:?}"))),
            ("neighbors", "neighbors", self.neighbors.clone()),
            ("field", "field", self.field.as_ref().map(|name| format!("{name:?}"))),
            ("soft-classes", "soft_classes", self.soft_classes.as_ref().map(list)),
            ("axis-point", "axis.point", self.axis_point.as_ref().map(list)),
            ("axis-direction", "axis.direction", self.axis_direction.as_ref().map(list)),
        ];
        for (option, key, value) in options {
            if let Some(value) = value {
                overrides.set(format!("--{option}"), &format!("cloud.0.{key}"), &value)?;
            }
        }
        Ok(overrides)
    }
}

pub fn run(args: PrepareArgs, talk: Talk) -> Result<ExitCode> {
    let has = |path: &Path, extension: &str| path.extension().is_some_and(|e| e.eq_ignore_ascii_case(extension));
    if !has(&args.output, "ply") {
        return Err(usage(format!(
            "{}: prepared clouds are PLY files; the name must end in .ply",
            args.output.display()
        )));
    }
    if has(&args.input, "toml") {
        return Err(usage(format!("{}: prepare takes a point cloud, not a scene file", args.input.display())));
    }
    output::check_folder(&args.output)?;
    let scene = Scene::from_clouds([&args.input], &args.overrides()?)?;
    scene.warnings.iter().for_each(|warning| talk.warn(warning));
    let progress = talk.progress();
    progress.set_message(format!("reading {}", args.input.display()));
    let settings = scene.clouds.into_iter().next();
    let hints = settings.as_ref().map(CloudSettings::hints).unwrap_or_default();
    let cloud = io::load_with(&args.input, hints, &progress)?;
    report_cloud(&args.input, &cloud, talk);
    let (neighbors, field) = settings.map(|cloud| (cloud.neighbors, cloud.field)).unwrap_or_default();
    let request = prepare::Request { neighbors, field, normals: args.normals, ..Default::default() };
    progress.reset();
    progress.set_message("finding neighbors");
    let prepared = prepare::prepared(cloud, &request, &progress);
    let prepared = prepared.map_err(|source| scene::Error::Field { path: args.input.clone(), source })?;
    stage(&progress, "writing");
    io::ply::write_prepared(&args.output, &prepared)?;
    progress.finish_and_clear();
    talk.detail(format_args!("{}: written", args.output.display()));
    Ok(ExitCode::SUCCESS)
}
