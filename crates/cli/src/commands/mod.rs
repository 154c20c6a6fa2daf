//! The commands and what they share: options to library calls, results to standard output, the rest to standard error.

mod along;
mod bar;
mod check;
mod compare;
mod compare_profiles;
mod completions;
pub mod console;
mod deep;
mod devices;
pub mod films;
mod filters;
mod frames;
mod headings;
mod info;
pub mod input;
mod interrupt;
mod limit;
mod man;
mod measured;
#[cfg(feature = "mpi")]
pub mod mpi;
#[cfg(any(feature = "mpi", test))]
mod mpi_args;
mod noise;
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

use console::{Console, Streams};

/// Render point clouds you can see through, with exact transparency and every GPU pass timed.
#[derive(Debug, Parser)]
#[command(name = "pellucid", version, max_term_width = 100)]
pub struct Cli {
    #[command(subcommand)]
    command: Command,
    /// Print no progress and no warnings.
    #[arg(short, long, global = true, conflicts_with = "verbose", display_order = 1000)]
    quiet: bool,
    /// Print details: files, choices, counts and times.
    #[arg(short, long, global = true, display_order = 1001)]
    verbose: bool,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Render point clouds or a scene to a picture.
    Render(render::RenderArgs),
    /// Render a few frames and print the time of each pass.
    Profile(profile::ProfileArgs),
    /// Measure time, memory and error of the exact methods as layers increase.
    Stress(stress::StressArgs),
    /// Measure time and error of every method on one scene.
    Tradeoff(tradeoff::TradeoffArgs),
    /// Run numerically hard cases on a device and compare errors with bounds.
    Check(check::CheckArgs),
    /// Print the passes of a frame, and the reason for each.
    Plan(plan::PlanArgs),
    /// Store a cloud with its radii and fields, or as an octree.
    Prepare(prepare::PrepareArgs),
    /// Print the contents of point-cloud files, and a command that suits them.
    Info(info::InfoArgs),
    /// Write a built-in scene to a folder.
    Scene(scene::SceneArgs),
    /// Open a scene in a window.
    #[cfg(feature = "viewer")]
    View(view::ViewArgs),
    /// List the Vulkan devices.
    Devices(devices::DevicesArgs),
    /// Compare two pictures or two profiles.
    Compare(compare::CompareArgs),
    /// Print a script that completes commands and options in a shell.
    Completions(completions::CompletionsArgs),
    /// Write the manual pages.
    Man(man::ManArgs),
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
    /// Device to render on, by index or part of its name.
    ///
    /// `pellucid devices` lists them.
    #[arg(long, value_name = "NAME_OR_INDEX", help_heading = headings::DEVICE)]
    device: Option<String>,
    /// Device memory for the fragments of a frame, as in 256MiB.
    ///
    /// Default: three quarters of the memory of the device, less the cloud.
    #[arg(long, value_name = "SIZE", help_heading = headings::DEVICE)]
    memory_budget: Option<ByteSize>,
}

/// Measurements of a frame, as files.
#[derive(Debug, Args)]
struct MeasureArgs {
    /// Write the time of each pass and of each phase on the CPU as JSON.
    #[arg(long, value_name = "FILE.json", help_heading = headings::MEASUREMENTS)]
    profile: Option<PathBuf>,
    /// Write a timeline of phases, frames and passes; opens in Perfetto.
    #[arg(long, value_name = "FILE.json", help_heading = headings::MEASUREMENTS)]
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

/// The command line of `pellucid-mpi`.
#[cfg(any(feature = "mpi", test))]
pub fn command_of_ranks() -> clap::Command {
    <mpi_args::Cli as clap::CommandFactory>::command()
}

/// Parses a command line and runs its command.
pub fn run(given: impl IntoIterator<Item = OsString>, streams: Streams) -> Result<ExitCode, crate::error::Error> {
    let cli = match Cli::try_parse_from(given) {
        Ok(cli) => cli,
        Err(stopped) => {
            streams.print_usage(&stopped);
            return Ok(ExitCode::from(u8::try_from(stopped.exit_code()).unwrap_or(2)));
        }
    };
    let console = Console::new(cli.quiet, cli.verbose).with_streams(streams);
    if streams.is_process() {
        interrupt::watch();
        pellucid_engine::io::silence_decoder_panics();
    }
    if cli.command.input().is_some_and(input::InputArgs::lists_presets) {
        console.print(&presets::list())?;
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
        Command::Completions(args) => completions::run(&args, console)?,
        Command::Man(args) => man::run(&args, console)?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_options_do_not_contradict_each_other() {
        <Cli as clap::CommandFactory>::command().debug_assert();
    }
}
