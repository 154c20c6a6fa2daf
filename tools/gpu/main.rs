//! Measures a machine with a GPU: what `tools/gpu/measure.sh` runs (docs/internals/measuring.md, "Measuring on a GPU").
//!
//! ```sh
//! cargo run --release --example gpu-table -- rows --seconds 60    # methods × scenes × sizes, with the passes of each
//! cargo run --release --example gpu-table -- record DIR           # this driver's pictures of all methods
//! cargo run --release --example gpu-table -- pictures DIR         # those of another driver against them
//! ```
//!
//! Each command prints lines of JSON, one object each, as soon as it has them: `kind` says what a line is. The exit
//! status is 1 if anything failed or was left out for lack of time, and 2 if there is no device that can be used.
//! `--quick` measures little of everything.

mod ceilings;
mod checks;
mod device;
mod lines;
mod pictures;
mod pipelines;
mod rates;
mod rows;
mod scenes;

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::{Duration, Instant};

use clap::{Parser, Subcommand};
use pellucid_gpu::{Device, DeviceOptions};

#[derive(Debug, Parser)]
struct Args {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// The device and its limits.
    Device,
    /// The cases of `pellucid check`, a line each.
    Check {
        /// Only cases whose name contains one of these.
        names: Vec<String>,
    },
    /// Times of methods × scenes × sizes, with those of their passes.
    Rows(Size),
    /// Writes this driver's pictures of the subjects of the example `drivers` to a folder.
    Record {
        folder: PathBuf,
        /// Only subjects whose name contains this.
        #[arg(long)]
        only: Option<String>,
    },
    /// Compares this driver's pictures with those that `record` wrote.
    Pictures {
        folder: PathBuf,
        /// Folder for those that differ.
        #[arg(long)]
        keep: Option<PathBuf>,
    },
    /// Measure ceilings of the device: copies, atomics, random reads, arithmetic, empty passes.
    Ceilings(Size),
    /// Opaque points, sort and scan by their number.
    Rates(Size),
    /// Print facts of the driver about each pipeline.
    Pipelines(Size),
}

/// Size of a measurement.
#[derive(Debug, Clone, Copy, clap::Args)]
struct Size {
    /// Measures little of everything.
    #[arg(long)]
    quick: bool,
    /// Begins nothing more after so many seconds.
    #[arg(long, default_value_t = 600)]
    seconds: u64,
}

/// Bounds of a command.
#[derive(Debug, Clone, Copy)]
struct Bounds {
    quick: bool,
    end: Instant,
}

impl Bounds {
    fn new(size: Size) -> Self {
        Self { quick: size.quick, end: Instant::now() + Duration::from_secs(size.seconds) }
    }

    fn is_over(&self) -> bool {
        Instant::now() >= self.end
    }
}

fn main() -> ExitCode {
    let args = Args::parse();
    // So that the driver keeps its statistics only where they are asked for.
    let statistics = matches!(args.command, Command::Pipelines(_));
    let device = match Device::open(&DeviceOptions { statistics, ..DeviceOptions::from_env() }) {
        Ok(device) => device,
        Err(error) => return failed(&error.to_string(), 2),
    };
    let done = match args.command {
        Command::Device => device::run(&device),
        Command::Check { names } => checks::run(&device, &names),
        Command::Rows(size) => rows::run(&device, Bounds::new(size)),
        Command::Record { folder, only } => pictures::record(&device, &folder, only.as_deref()),
        Command::Pictures { folder, keep } => pictures::compare(&device, &folder, keep.as_deref()),
        Command::Ceilings(size) => ceilings::run(&device, Bounds::new(size)),
        Command::Rates(size) => rates::run(&device, Bounds::new(size)),
        Command::Pipelines(size) => pipelines::run(&device, Bounds::new(size)),
    };
    match done {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => failed(&error.to_string(), 1),
    }
}

fn failed(error: &str, status: u8) -> ExitCode {
    eprintln!("error: {error}");
    ExitCode::from(status)
}
