//! The commands and what they share: options to library calls, results to standard output, the rest to standard error.

mod along;
mod bar;
mod check;
mod compare;
mod compare_profiles;
pub mod console;
mod deep;
mod devices;
pub mod films;
mod filters;
mod frames;
mod info;
pub mod input;
mod interrupt;
mod limit;
pub mod loaded;
mod measured;
#[cfg(feature = "mpi")]
pub mod mpi;
mod noise;
mod opacity_notes;
mod plan;
mod popped;
mod prepare;
mod prepare_store;
mod presets;
mod profile;
mod render;
mod scene;
mod sequence;
mod session;
mod stress;
mod tradeoff;
#[cfg(feature = "viewer")]
mod view;
mod view_args;

use std::ffi::OsString;
use std::path::PathBuf;
use std::process::ExitCode;

use bytesize::ByteSize;
use clap::{Args, Parser, Subcommand};
use pellucid_engine::Result;

use console::Console;

/// Renders point clouds you can see through: exact transparency on Vulkan, every pass timed.
#[derive(Debug, Parser)]
#[command(name = "pellucid", version, max_term_width = 100)]
pub struct Cli {
    #[command(subcommand)]
    command: Command,
    /// Say less: no progress, no warnings.
    #[arg(short, long, global = true, conflicts_with = "verbose", display_order = 1000)]
    quiet: bool,
    /// Say more: what was read, chosen and written, and what it took.
    #[arg(short, long, global = true, display_order = 1001)]
    verbose: bool,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Render a scene or point clouds to a picture.
    Render(render::RenderArgs),
    /// Render a few frames and print what each pass costs.
    Profile(profile::ProfileArgs),
    /// Measure what layers of transparency cost every method: time, memory, error.
    Stress(stress::StressArgs),
    /// Measure what accuracy costs in time: every method and setting on one scene, against the exact image.
    Tradeoff(tradeoff::TradeoffArgs),
    /// Run the numerically hard cases on a device: what each is off, and what it may be.
    Check(check::CheckArgs),
    /// Print which passes a frame would have, and why.
    Plan(plan::PlanArgs),
    /// Compute radii and the field of soft transparency once, and store them with the cloud.
    Prepare(prepare::PrepareArgs),
    /// Print what point-cloud files hold.
    Info(info::InfoArgs),
    /// Write one of the built-in scenes.
    Scene(scene::SceneArgs),
    /// Look at a scene in a window: turn it, change its settings, see what each pass costs.
    #[cfg(feature = "viewer")]
    View(view::ViewArgs),
    /// List the Vulkan devices.
    Devices(devices::DevicesArgs),
    /// Compare two pictures or two profiles.
    Compare(compare::CompareArgs),
}

impl Command {
    /// The inputs, of commands that render them.
    fn input(&self) -> Option<&input::InputArgs> {
        match self {
            Self::Render(args) => Some(&args.input),
            Self::Profile(args) => Some(&args.input),
            Self::Tradeoff(args) => Some(&args.input),
            Self::Plan(args) => Some(&args.input),
            #[cfg(feature = "viewer")]
            Self::View(args) => Some(&args.input),
            _ => None,
        }
    }
}

/// The device and what it may use.
#[derive(Debug, Args)]
struct DeviceArgs {
    /// Device to render on: its index or a part of its name, as `pellucid devices` lists them.
    #[arg(long, value_name = "NAME_OR_INDEX")]
    device: Option<String>,
    /// Largest amount of device memory for a frame's fragments, as in 256MiB; by default what the device has, less a reserve.
    #[arg(long, value_name = "SIZE")]
    memory_budget: Option<ByteSize>,
}

/// Measurements of a frame, as files.
#[derive(Debug, Args)]
struct MeasureArgs {
    /// Write the measurements as JSON: each pass of each frame, and the phases of the host.
    #[arg(long, value_name = "FILE.json")]
    profile: Option<PathBuf>,
    /// Write a Chrome trace, which opens in Perfetto: phases of the host, frames and passes, each where it happened.
    #[arg(long, value_name = "FILE.json")]
    trace: Option<PathBuf>,
}

impl MeasureArgs {
    /// True if passes have to be timed.
    fn is_asked(&self) -> bool {
        self.profile.is_some() || self.trace.is_some()
    }

    /// Refuses files that could not be written in the end.
    fn check(&self) -> Result<()> {
        for path in [&self.profile, &self.trace].into_iter().flatten() {
            pellucid_engine::output::check_folder(path)?;
        }
        Ok(())
    }
}

/// The arguments, with the number of `--frames 36` joined to it (`--frames=36`): without a number `--frames` means a
/// time series, and the next argument is an input.
pub fn arguments(given: impl IntoIterator<Item = OsString>) -> Vec<OsString> {
    let mut arguments: Vec<OsString> = Vec::new();
    let mut options = true;
    for argument in given {
        let text = argument.to_str().unwrap_or_default();
        let is_number = text.starts_with(|c: char| c.is_ascii_digit()) && text.parse::<f64>().is_ok();
        match arguments.last_mut().filter(|last| options && is_number && *last == "--frames") {
            Some(frames) => {
                frames.push("=");
                frames.push(argument);
            }
            None => {
                options &= argument != "--";
                arguments.push(argument);
            }
        }
    }
    arguments
}

/// Parses the command line and runs its command.
pub fn run() -> Result<ExitCode, crate::error::Error> {
    let cli = Cli::parse_from(arguments(std::env::args_os()));
    let console = Console::new(cli.quiet, cli.verbose);
    interrupt::watch();
    pellucid_engine::io::silence_decoder_panics();
    if cli.command.input().is_some_and(input::InputArgs::lists_presets) {
        console::print(&presets::list())?;
        return Ok(ExitCode::SUCCESS);
    }
    Ok(match cli.command {
        Command::Render(args) => render::run(args, console)?,
        Command::Profile(args) => profile::run(args, console)?,
        Command::Stress(args) => stress::run(args, console)?,
        Command::Tradeoff(args) => tradeoff::run(args, console)?,
        Command::Check(args) => check::run(args, console)?,
        Command::Plan(args) => plan::run(args, console)?,
        Command::Prepare(args) => prepare::run(args, console)?,
        Command::Info(args) => info::run(args, console)?,
        Command::Scene(args) => scene::run(args, console)?,
        #[cfg(feature = "viewer")]
        Command::View(args) => view::run(args, console)?,
        Command::Devices(args) => devices::run(args, console)?,
        Command::Compare(args) => compare::run(args, console)?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_number_belongs_to_frames() {
        let joined = |given: &str| arguments(given.split(' ').map(OsString::from)).join(" ".as_ref());
        for (given, expected) in [
            ("render --frames 36 a.ply", "render --frames=36 a.ply"),
            ("render --frames scene.toml", "render --frames scene.toml"),
            ("render --frames 1.5", "render --frames=1.5"),
            ("render --frames 3d.ply", "render --frames 3d.ply"),
            ("render --frames ./36", "render --frames ./36"),
            ("render --frames -o 36", "render --frames -o 36"),
            ("render --frames=36 36", "render --frames=36 36"),
            ("render -- --frames 36", "render -- --frames 36"),
            ("profile --frames 3", "profile --frames=3"),
            ("render --frames", "render --frames"),
        ] {
            assert_eq!(joined(given), OsString::from(expected), "{given}");
        }
    }

    #[test]
    fn the_options_do_not_contradict_each_other() {
        <Cli as clap::CommandFactory>::command().debug_assert();
    }
}
