//! The command line of `pellucid-mpi`.

use clap::{Args, Parser, Subcommand, ValueEnum};

use super::VerbosityArgs;
use super::plan::PlanArgs;
use super::profile::ProfileArgs;
use super::render::RenderArgs;

/// Render point clouds you can see through on many machines.
///
/// Every rank that `mpirun` starts renders a part. The first rank writes the picture, with the same bytes as
/// `pellucid`.
#[derive(Debug, Parser)]
#[command(name = "pellucid-mpi", version, max_term_width = 100)]
pub struct Cli {
    #[command(subcommand)]
    pub command: Command,
    #[command(flatten)]
    pub verbosity: VerbosityArgs,
}

#[derive(Debug, Subcommand)]
pub enum Command {
    /// Render point clouds or a scene to a picture, or to the frames of a path.
    Render {
        #[command(flatten)]
        args: RenderArgs,
        #[command(flatten)]
        sharing: SharingArgs,
        #[command(flatten)]
        spread: SpreadArgs,
    },
    /// Render a few frames and print the times of each pass and each rank.
    Profile {
        #[command(flatten)]
        args: ProfileArgs,
        #[command(flatten)]
        sharing: SharingArgs,
        #[command(flatten)]
        spread: SpreadArgs,
    },
    /// Print the ways to share the work among ranks, with the expected time of each.
    Plan {
        #[command(flatten)]
        args: PlanArgs,
        #[command(flatten)]
        sharing: SharingArgs,
        /// Plan for N ranks instead of the running ones.
        #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
        ranks: Option<u32>,
    },
}

/// How the ranks share the work.
#[derive(Debug, Args)]
pub struct SharingArgs {
    /// Work that the ranks share; the picture has the same bytes in any case.
    ///
    /// `windows`: parts of the image, of about the same expected cost. `ensembles`: the ensembles of spbr, or the
    /// samples of stochastic. `frames`: the frames of a path or turntable. `auto`: whatever a cost model expects to be
    /// fastest, as `pellucid-mpi plan` prints it.
    #[arg(long, value_name = "WHAT", value_enum, default_value = "auto")]
    pub share: Wanted,
}

/// Choice of what the ranks share.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Wanted {
    Auto,
    Windows,
    Ensembles,
    Frames,
}

/// How points are held.
#[derive(Debug, Clone, Copy, Args)]
pub struct SpreadArgs {
    /// Distribute the points over the memory of the ranks.
    ///
    /// For clouds larger than the memory of one machine, and for machines without a shared file system. Only the first
    /// rank reads files. Each rank keeps a part of the points and receives the others that its part of the picture
    /// needs. Not available for spbr, shadows and levels of detail.
    #[arg(long)]
    pub spread: bool,
}
