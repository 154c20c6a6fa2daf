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
mod error;
mod films;
mod filters;
mod frames;
mod headings;
mod info;
mod input;
mod interrupt;
mod job;
mod limit;
mod man;
mod measured;
#[cfg(feature = "mpi")]
pub mod mpi;
#[cfg(any(feature = "mpi", test))]
mod mpi_args;
mod noise;
mod options;
mod picture;
mod plan;
mod popped;
mod prepare;
mod prepare_store;
mod presets;
mod profile;
mod render;
mod scene;
mod sequence;
mod stress;
mod tables;
mod touched;
mod tradeoff;
mod typed;
mod unknown;
#[cfg(feature = "viewer")]
mod view;
mod view_args;

use std::ffi::OsString;
use std::process::{ExitCode, Termination};

use clap::{Args, Parser, Subcommand};

use console::{Console, Streams};
pub use error::Error;
use touched::{Touched, Touches};

/// Render point clouds you can see through, with exact transparency and every GPU pass timed.
#[derive(Debug, Parser)]
#[command(name = "pellucid", version, max_term_width = 100)]
pub struct Cli {
    #[command(subcommand)]
    command: Command,
    #[command(flatten)]
    verbosity: VerbosityArgs,
}

/// Amount of output on standard error.
#[derive(Debug, Args)]
pub struct VerbosityArgs {
    /// Print no progress and no warnings.
    #[arg(short, long, global = true, conflicts_with = "verbose", display_order = 1000)]
    quiet: bool,
    /// Print details: files, choices, counts and times.
    #[arg(short, long, global = true, display_order = 1001)]
    verbose: bool,
}

/// The table of commands, in the order of `--help`: sentence, name, and the module with its arguments and its `run`.
/// `{ input }` stands behind arguments with a field of that name, for which `--preset list` prints the presets.
macro_rules! commands {
    (@input $args:ident) => { None };
    (@input $args:ident $input:ident) => { Some(&$args.$input) };
    ($($(#[doc = $about:tt])+ $(#[cfg($cfg:meta)])? $name:ident($module:ident::$args:ident $({ $input:ident })?),)+) => {
        #[derive(Debug, Subcommand)]
        enum Command {
            $($(#[doc = $about])+ $(#[cfg($cfg)])? $name($module::$args),)+
        }

        impl Command {
            /// The inputs, of commands that render them.
            fn input(&self) -> Option<&input::InputArgs> {
                match self {
                    $($(#[cfg($cfg)])? Self::$name(_args) => commands!(@input _args $($input)?),)+
                }
            }

            /// The files that the command reads and writes.
            fn touched(&self) -> pellucid_engine::Result<Touched> {
                match self {
                    $($(#[cfg($cfg)])? Self::$name(args) => args.touched(),)+
                }
            }

            fn run(self, console: Console) -> Result<ExitCode, Error> {
                self.touched()?.check()?;
                Ok(match self {
                    $($(#[cfg($cfg)])? Self::$name(args) => $module::run(args, console)?.report(),)+
                })
            }
        }
    };
}

commands! {
    /// Render point clouds or a scene to a picture.
    Render(render::RenderArgs { input }),
    /// Render a few frames and print the time of each pass.
    Profile(profile::ProfileArgs { input }),
    /// Measure time, memory and error of the exact methods as layers increase.
    Stress(stress::StressArgs),
    /// Measure time and error of every method on one scene.
    Tradeoff(tradeoff::TradeoffArgs { input }),
    /// Run numerically hard cases on a device and compare errors with bounds.
    Check(check::CheckArgs),
    /// Print the passes of a frame, and the reason for each.
    Plan(plan::PlanArgs { input }),
    /// Store a cloud with its radii and fields, or as an octree.
    Prepare(prepare::PrepareArgs),
    /// Print the contents of point-cloud files, and a command that suits them.
    Info(info::InfoArgs),
    /// Write a built-in scene to a folder.
    Scene(scene::SceneArgs),
    /// Open a scene in a window.
    #[cfg(feature = "viewer")]
    View(view::ViewArgs { input }),
    /// List the Vulkan devices.
    Devices(devices::DevicesArgs),
    /// Compare two pictures or two profiles.
    Compare(compare::CompareArgs),
    /// Print a script that completes commands and options in a shell.
    Completions(completions::CompletionsArgs),
    /// Write the manual pages.
    Man(man::ManArgs),
}

/// The command line of `pellucid-mpi`.
#[cfg(any(feature = "mpi", test))]
pub fn command_of_ranks() -> clap::Command {
    <mpi_args::Cli as clap::CommandFactory>::command()
}

/// `pellucid`.
pub fn main() -> ExitCode {
    run_from(std::env::args_os(), Streams::Process)
}

/// Runs a command line, whose first argument is the program's name, and returns its exit status.
///
/// Tests capture the output and start no process. Then the handlers of signals and panics stay those of the caller.
pub fn run_from(arguments: impl IntoIterator<Item = OsString>, streams: Streams) -> ExitCode {
    let Cli { command, verbosity } = match Cli::try_parse_from(arguments) {
        Ok(cli) => cli,
        Err(stopped) => {
            let stopped = unknown::advise(stopped);
            streams.print_usage(&stopped);
            return ExitCode::from(u8::try_from(stopped.exit_code()).unwrap_or(2));
        }
    };
    let console = Console::new(verbosity.quiet, verbosity.verbose, streams);
    if streams.is_process() {
        interrupt::watch();
        pellucid_io::silence_decoder_panics();
    }
    let done = if command.input().is_some_and(input::InputArgs::lists_presets) {
        console.print(&presets::list()).map(|()| ExitCode::SUCCESS).map_err(Error::from)
    } else {
        command.run(console)
    };
    done.unwrap_or_else(|error| {
        streams.print_stderr(format_args!("error: {}", error.with_causes()));
        ExitCode::from(error.exit_status())
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
